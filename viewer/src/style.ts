// Beside the style of the page, whose colours and letters it takes.
export const style = `
.v{margin:26px 0;border:1px solid var(--line);border-radius:8px;overflow:hidden;background:var(--paper)}
@media(min-width:1124px){.v{margin-inline:calc((1004px - min(100vw - 48px,1400px))/2)}}
.v.v-full{position:fixed;inset:0;z-index:9;margin:0;border:0;border-radius:0;overflow:auto}
.v-main{display:grid;grid-template:"stage panel" auto "read panel" auto "below below" auto/minmax(0,1fr) 316px}
.v-stage{grid-area:stage}.v-read{grid-area:read}.v-below{grid-area:below}.v-panel{grid-area:panel}
.v-stage{position:relative;background:var(--tint);min-width:0}
.v-stage canvas{display:block;width:100%;height:min(72vh,680px);touch-action:none;cursor:crosshair;outline-offset:-3px}
.v-full .v-stage canvas{height:calc(100vh - 120px)}
.v-stage canvas:focus-visible{outline:3px solid var(--accent)}
.v-cross{display:none;position:absolute;left:50%;top:50%;width:21px;height:21px;margin:-10px 0 0 -10px;pointer-events:none;color:var(--ink)}
canvas:focus-visible~.v-cross{display:block}
.v-over{position:absolute;pointer-events:none;color:var(--ink);font-size:13px;font-variant-numeric:tabular-nums}
.v-tag{left:14px;top:12px;font-weight:600;background:var(--paper);border-radius:4px;padding:2px 8px}
.v-north{right:14px;top:12px;width:34px;height:52px}
.v-scale{left:14px;bottom:12px;background:var(--paper);border-radius:4px;padding:2px 8px 5px}
.v-scale i{display:block;height:5px;border:2px solid var(--ink);border-top:0;margin-top:1px}
.v-swipe{position:absolute;inset:auto 12px 44px;pointer-events:none}
.v-swipe input{width:100%;pointer-events:auto;margin:0}
.v-bar{position:absolute;top:0;bottom:0;width:2px;background:var(--ink);pointer-events:none}
.v-panel{border-left:1px solid var(--line);padding:6px 16px 14px;font-size:14px;overflow:auto;max-height:calc(min(72vh,680px) + 47px)}
.v-full .v-panel{max-height:calc(100vh - 73px)}
.v-panel details{border-bottom:1px solid var(--line);padding:8px 0}
.v-panel details:last-child{border:0}
.v-panel summary{color:var(--ink);font-weight:600}
.v-panel details>div{padding:8px 0 4px;display:grid;gap:9px}
.v-row{display:flex;flex-wrap:wrap;gap:6px 8px;align-items:center}
.v-row>label,.v label.v-check{display:flex;gap:7px;align-items:center}
.v label.v-slide{display:grid;grid-template-columns:6.4em 1fr 3.6em;gap:8px;align-items:center}
.v label.v-slide output{text-align:right;font-variant-numeric:tabular-nums}
.v input[type=range]{min-width:0;width:100%;accent-color:var(--accent)}
.v input[type=checkbox],.v input[type=radio]{accent-color:var(--accent);margin:0;width:16px;height:16px}
.v button,.v select,.v input[type=number]{font:inherit;color:var(--ink);background:var(--paper);border:1px solid var(--bar);border-radius:5px;padding:4px 10px;min-height:32px}
.v select{width:100%}.v input[type=number]{width:7.2em}
.v button{cursor:pointer}.v button:hover{background:var(--tint)}
.v button[aria-pressed=true]{background:var(--accent);border-color:var(--accent);color:var(--paper)}
.v button:disabled{opacity:.45;cursor:default}
.v :focus-visible{outline:2px solid var(--accent);outline-offset:1px}
.v-seg{display:flex}.v-seg label{flex:1;position:relative}
.v-seg input{position:absolute;opacity:0;inset:0;width:100%!important;height:100%!important;cursor:pointer}
.v-seg span{display:block;text-align:center;border:1px solid var(--bar);padding:5px 4px;margin-left:-1px;overflow:hidden;text-overflow:ellipsis;white-space:nowrap}
.v-seg label:first-child span{border-radius:5px 0 0 5px;margin-left:0}.v-seg label:last-child span{border-radius:0 5px 5px 0}
.v-seg input:checked+span{background:var(--accent);border-color:var(--accent);color:var(--paper)}
.v-seg input:focus-visible+span{outline:2px solid var(--accent);outline-offset:1px}
.v-histogram{touch-action:none;cursor:ew-resize;color:var(--ink)}
.v-swatch{width:14px;height:14px;border-radius:3px;flex:none}.v-play{display:grid;grid-template-columns:auto auto auto 1fr;gap:8px;align-items:center;padding:10px 16px;border-top:1px solid var(--line)}
.v-play output{grid-column:1/-1;font-variant-numeric:tabular-nums;font-size:14.5px;overflow-wrap:anywhere}.v-foot-row{display:grid}
.v-ramp{width:100%;height:16px;display:block;border:1px solid var(--line)}.v-ends{display:flex;justify-content:space-between;font-size:13px;font-variant-numeric:tabular-nums}
.v-hint{color:var(--soft);font-size:13px;margin:0}
.v-list{list-style:none;margin:0;padding:0;display:grid;gap:4px}
.v-list button{width:100%;display:flex;justify-content:space-between;gap:10px;text-align:left}
.v-list button span:first-child{overflow-wrap:anywhere}.v-list button span:last-child{white-space:nowrap;font-variant-numeric:tabular-nums}
.v-read{display:flex;flex-wrap:wrap;gap:2px 22px;padding:10px 16px;border-top:1px solid var(--line);min-height:46px;align-items:baseline;font-variant-numeric:tabular-nums;font-size:14.5px}
.v-read b{font-weight:600;margin-left:5px}.v-read i{font-style:normal;color:var(--soft)}
.v-below{border-top:1px solid var(--line);padding:12px 16px;font-size:14.5px}
.v-below table{width:auto;margin:6px 0 10px}.v-below td:first-child{padding-right:22px}
.v-below code{overflow-wrap:anywhere}
.v-foot{border-top:1px solid var(--line);padding:9px 16px;color:var(--soft);font-size:13px;max-width:none;margin:0}
.v-print{display:none}
@media(max-width:860px){.v{margin-inline:-6px}.v-main{display:block}.v-panel{border-left:0;border-top:1px solid var(--line);max-height:none}
.v-stage canvas{height:min(62vh,420px)}.v-panel summary{padding:4px 0}.v button,.v select,.v input[type=number]{min-height:40px}}
@media print{.v{border:0;margin:10px 0;break-inside:avoid;overflow:visible}.v-main{display:block}.v-stage,.v-panel,.v-tools,.v-play{display:none!important}.v-print{display:block;width:100%}
.v-foot,.v-read,.v-below{padding-inline:0;border:0}}
`;
