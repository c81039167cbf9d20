// The chart of a section: both surfaces above, their difference below, with the band of the level of detection.
import type {PageData} from './block';
import type {Stretch} from './surface';
import {fixed, niceAbove, nice, svg} from './words';

const right = 16, upper = {top: 30, height: 190}, lower = {top: 262, height: 110}, total = 424;

interface Axis { low: number; high: number }

function axis(low: number, high: number): Axis {
  const room = Math.max(high - low, 1e-12 * Math.max(1, Math.abs(low), Math.abs(high))) * 0.08;
  return {low: low - room, high: high + room};
}

export function sectionChart(stretches: Stretch[], page: PageData, width: number, z0: number): SVGElement {
  const root = svg('svg', {viewBox: `0 0 ${width} ${total}`, role: 'img', 'font-size': 13,
    xmlns: 'http://www.w3.org/2000/svg', 'font-family': 'system-ui,sans-serif',
    'aria-label': 'Section: heights of both surfaces and their difference along the line'});
  const left = width < 500 ? 56 : 84, isNarrow = width < 500;
  const ends = stretches.flatMap(s => [s.from, s.to]);
  const length = ends[ends.length - 1]!.s, start = Math.min(0, ends[0]!.s);
  const range = (f: (e: (typeof ends)[number]) => number[]): [number, number] =>
    ends.reduce(([l, h], e) => [Math.min(l, ...f(e)), Math.max(h, ...f(e))], [Infinity, -Infinity]);
  const heights = axis(...range(e => [e.za + z0, e.zb + z0])), differences = axis(...range(e => [e.d, 0, ...(e.lod === null ? [] : [e.lod, -e.lod])]));
  const x = (s: number): number => left + (width - left - right) * (s - start) / (length - start || 1);
  const y = (v: number, a: Axis, p: {top: number; height: number}): number => p.top + p.height * (1 - (v - a.low) / (a.high - a.low));
  // Runs without a gap: a line may leave the area compared and come back.
  const runs: Stretch[][] = [];
  for (const s of stretches) {
    const last = runs[runs.length - 1]?.at(-1);
    if (last && s.from.s - last.to.s < 1e-9 * (length || 1)) runs[runs.length - 1]!.push(s); else runs.push([s]);
  }
  const path = (f: (e: Stretch['from']) => number): string => runs.map(run =>
    'M' + [run[0]!.from, ...run.map(s => s.to)].map(e => `${x(e.s).toFixed(1)},${f(e).toFixed(1)}`).join('L')).join('');
  const labels = (a: Axis, p: {top: number; height: number}, sign: boolean): void => {
    const step = niceAbove((a.high - a.low) * 30 / p.height), first = Math.ceil(a.low / step);
    const decimals = Math.min(12, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
    for (let k = first; k * step <= a.high; ++k) {
      const at = y(k * step, a, p);
      root.append(svg('path', {d: `M${left} ${at.toFixed(1)}H${width - right}`, stroke: 'currentColor', 'stroke-opacity': k === 0 && p === lower ? 0.7 : 0.2}),
        svg('text', {x: left - 8, y: (at + 4.5).toFixed(1), 'text-anchor': 'end', fill: 'currentColor'}, (sign && k > 0 ? '+' : '') + fixed(k * step, decimals)));
    }
  };
  labels(heights, upper, false);
  labels(differences, lower, true);
  if (ends.every(e => e.lod !== null)) {
    const band = runs.map(run => {
      const points = [run[0]!.from, ...run.map(s => s.to)];
      return 'M' + [...points.map(e => `${x(e.s).toFixed(1)},${y(e.lod!, differences, lower).toFixed(1)}`),
        ...points.reverse().map(e => `${x(e.s).toFixed(1)},${y(-e.lod!, differences, lower).toFixed(1)}`)].join('L') + 'Z';
    }).join('');
    root.append(svg('path', {d: band, fill: 'currentColor', 'fill-opacity': 0.16}));
  }
  const line = (f: (e: Stretch['from']) => number, extra: Record<string, string>): SVGElement =>
    svg('path', {d: path(f), fill: 'none', stroke: 'currentColor', 'stroke-width': 1.8, 'stroke-linejoin': 'round', ...extra});
  root.append(line(e => y(e.za + z0, heights, upper), {'stroke-dasharray': '5 3'}), line(e => y(e.zb + z0, heights, upper), {stroke: 'var(--accent,#0f4f8b)'}),
    line(e => y(e.d, differences, lower), {}));
  const text = (tx: number, ty: number, words: string, more: Record<string, string> = {}): void => {
    root.append(svg('text', {x: tx, y: ty, fill: 'currentColor', ...more}, words));
  };
  text(left, 16, `height (${page.heightUnit}):`);
  root.append(svg('path', {d: `M${left + 96} 12h30`, stroke: 'currentColor', 'stroke-width': 1.8, 'stroke-dasharray': '5 3'}));
  text(left + 132, 16, page.words.a);
  const second = left + 150 + 8 * page.words.a.length;
  root.append(svg('path', {d: `M${second} 12h30`, stroke: 'var(--accent,#0f4f8b)', 'stroke-width': 1.8}));
  text(second + 36, 16, page.words.b);
  text(left, lower.top - 12, `difference d (${page.heightUnit})` + (ends.every(e => e.lod !== null) ? (isNarrow ? '; grey: level of detection' : '; grey: within the level of detection') : ''));
  const step = nice((length - start) / Math.max(2, width / 160) || 1);
  for (let s = 0; s <= length * (1 + 1e-9); s += step)
    text(x(s), lower.top + lower.height + 20, fixed(s, Math.min(12, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)))), {'text-anchor': 'middle'});
  text((left + width - right) / 2, total - 6, `distance along the line (${page.unit})`, {'text-anchor': 'middle'});
  return root;
}
