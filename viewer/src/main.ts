// The view of a report: reads the page's data, builds the controls, keeps all of its state in one object and in the hash.
import {type PageData, type SpaceData, decodedSpace} from './block';
import {sectionChart} from './chart';
import {histogram} from './histogram';
import {colour, css, heightColour, paletteNames, table} from './palette';
import {SpaceView} from './space';
import {type Mode, type Show, Stage} from './stage';
import {style} from './style';
import {type Place, type Reading, type Stretch, Surface, isSimple, toFrame, toInput} from './surface';
import {copy, el, fixed, nice, num, save, signed, svg} from './words';

const brief = (v: number): string => String(Number(v.toPrecision(2)));

type Tool = 'read' | 'section' | 'polygon';

interface State {
  scene: number; show: Show; mode: Mode; swipe: number; low: number; high: number; symmetric: boolean; palette: string;
  grey: boolean; hatch: boolean; exaggeration: number; light: number; clip: [number, number, number, number];
  tool: Tool; line: Place[]; done: boolean;
}

class View {
  private readonly stage: Stage;
  private readonly state: State;
  private readonly canvas = el('canvas', {tabindex: 0, role: 'application', 'aria-describedby': 'view-help'});
  private readonly tag = el('div', {class: 'v-over v-tag'});
  private readonly northArrow = svg('g');
  private readonly scaleBar = el('i');
  private readonly scaleText = el('span');
  private readonly swipeInput = el('input', {type: 'range', min: 0, max: 1, step: 0.001, 'aria-label': 'Line between the two surfaces'});
  private readonly swipeBox = el('div', {class: 'v-swipe'}, this.swipeInput);
  private readonly swipeBar = el('div', {class: 'v-bar'});
  private readonly reading = el('div', {class: 'v-read', 'aria-live': 'polite', role: 'status'});
  private readonly below = el('div', {class: 'v-below', hidden: true});
  private readonly foot = el('p', {class: 'v-foot'});
  private readonly printed = el('img', {class: 'v-print', alt: ''});
  private readonly root: HTMLElement;
  private readonly bars: ReturnType<typeof histogram>;
  private readonly reach: number;
  private readonly syncs: (() => void)[] = [];
  private last: Reading | null = null;
  private hashTimer = 0;

  constructor(place: HTMLElement, private readonly page: PageData, private readonly surfaces: Surface[]) {
    const widest = Math.max(...surfaces.map(s => s.dLargest)), limit = page.limit > 0 ? page.limit : Math.max(widest, 1e-12);
    this.reach = Math.min(Math.max(widest, limit), 2.5 * limit);
    this.state = {
      scene: surfaces.length - 1, show: 'b', mode: 'difference', swipe: 0.5, low: -limit, high: limit, symmetric: true,
      palette: page.palette, grey: true, hatch: true, exaggeration: 1, light: 315, clip: [0, 0, 1, 1], tool: 'read', line: [], done: false,
    };
    this.state.exaggeration = this.usualExaggeration();
    this.canvas.setAttribute('aria-label', `Surfaces ${page.words.a} and ${page.words.b} in three dimensions, coloured by their difference`);
    this.stage = new Stage(this.canvas, surfaces, this.look(), table(256, heightColour, 0));
    this.bars = histogram(page, this.reach, (upper, value) => this.setLimit(upper, value));
    this.root = this.built();
    place.append(this.root);
    this.listen();
    this.stage.onFrame = () => { this.overlays(); this.writeHash(); };
    this.resize();
    this.stage.lookFrom(...this.oblique());
    this.tell();
    this.readHash();
    this.apply();
    this.stage.begin();
  }

  /** What takes longer and is not seen at once: the places to go to, and the search tree for the first click. */
  prepare(): void { this.places(); this.stage.pick(1, 1); }

  /** Ground is looked at from the side, an object that was scanned from one side rather from there. */
  private oblique(): [azimuth: number, elevation: number] { return this.page.unit === 'mm' || !this.page.vertical ? [188, 70] : [205, 42]; }

  /** Flat ground is shown steeper, so that its shape is seen: 1, 2, 5 or 10 times. */
  private usualExaggeration(): number {
    const b = this.surfaces[0]!.box, flatness = Math.hypot(b.maxX - b.minX, b.maxY - b.minY) / Math.max(b.maxZ - b.minZ, 1e-300);
    if (!this.page.vertical) return 1;
    return flatness > 200 ? 10 : flatness > 60 ? 5 : flatness > 22 ? 2 : 1;
  }

  private colourOf = (t: number): [number, number, number] => colour(this.state.palette, this.page.flip, t);
  private paletteTable: {key: string; f: (t: number) => [number, number, number]} = {key: '', f: this.colourOf};

  private look(): ConstructorParameters<typeof Stage>[2] {
    const s = this.state;
    if (this.paletteTable.key !== s.palette) { const name = s.palette; this.paletteTable = {key: name, f: t => colour(name, this.page.flip, t)}; }
    return {show: s.show, mode: s.mode, swipe: s.swipe, low: s.low, high: s.high, palette: this.paletteTable.f, grey: s.grey, hatch: s.hatch,
      exaggeration: s.exaggeration, light: s.light, clip: s.clip};
  }

  /** Everything that follows from the state. */
  private apply(): void {
    const s = this.state;
    if (this.stage.sceneIndex !== s.scene) { this.stage.setScene(s.scene); this.last = null; this.tell(); this.places(); }
    this.stage.setLook(this.look());
    this.swipeBox.hidden = this.swipeBar.hidden = s.show !== 'both';
    this.swipeBar.style.left = `${100 * s.swipe}%`;
    const scene = this.surfaces[s.scene]!.data.label, {a, b} = this.page.words;
    const {data} = this.surfaces[s.scene]!, file = s.show === 'a' ? data.a.name : data.b.name;
    this.tag.textContent = (scene ? `${scene}: ` : '') + (s.show === 'both' ? `${a} | ${b}` : `${s.show === 'a' ? a : b} \u00b7 ${file}`);
    for (const sync of this.syncs) sync();
    this.bars.update(this.areas(), s.low, s.high, d => this.legend(d));
    this.showLine();
    this.footer();
    this.writeHash();
  }

  private readonly areasOf = new Map<number, Float64Array>();
  private areas(): Float64Array {
    let found = this.areasOf.get(this.state.scene);
    if (!found) this.areasOf.set(this.state.scene, found = this.surfaces[this.state.scene]!.histogram(-this.reach, this.reach, 70));
    return found;
  }
  private legend(d: number): [number, number, number] {
    const s = this.state, surface = this.surfaces[s.scene]!;
    const isEven = surface.data.lod !== null && !(surface.data.lod.step > 0);
    if (s.grey && isEven && Math.abs(d) <= surface.data.lod!.low) return [0.77, 0.77, 0.77];
    return this.colourOf(d > 0 ? d / s.high : d / -s.low);
  }

  private setLimit(upper: boolean, value: number): void {
    const s = this.state, least = this.reach / 500, size = Math.min(this.reach, Math.max(least, upper ? value : -value));
    if (!Number.isFinite(size)) return;
    if (upper || s.symmetric) s.high = size;
    if (!upper || s.symmetric) s.low = -size;
    this.apply();
  }

  // --- the controls -----------------------------------------------------------------------------------------------

  private built(): HTMLElement {
    const north = svg('svg', {viewBox: '-17 -17 34 52', class: 'v-over v-north', 'aria-hidden': 'true'}, this.northArrow);
    this.northArrow.append(svg('path', {d: 'M0 -14L8 12L0 7L-8 12Z', fill: 'currentColor'}));
    const letter = svg('text', {y: 32, 'text-anchor': 'middle', 'font-size': 14, 'font-weight': 600, fill: 'currentColor'}, this.page.north ? 'N' : 'y');
    north.append(letter);
    if (!this.page.vertical) north.setAttribute('visibility', 'hidden');
    const cross = svg('svg', {viewBox: '0 0 21 21', class: 'v-cross', 'aria-hidden': 'true'}, svg('path', {d: 'M10.5 0V8M10.5 13V21M0 10.5H8M13 10.5H21', stroke: 'currentColor', 'stroke-width': 2}));
    const stage = el('div', {class: 'v-stage'}, this.canvas, cross, this.tag, north,
      el('div', {class: 'v-over v-scale'}, this.scaleText, this.scaleBar), this.swipeBar, this.swipeBox);
    this.printed.alt = 'The surface as it was turned when the page was printed';
    return el('section', {class: 'v', 'aria-label': 'The surface, to be turned, read and cut'},
      el('div', {class: 'v-main'}, this.printed, stage, this.reading, this.below, this.panel()), this.foot);
  }

  private group(title: string, open: boolean, ...content: Node[]): HTMLElement {
    return el('details', open ? {open: true} : {}, el('summary', {}, title), el('div', {}, ...content));
  }
  private segmented<K extends string | number>(name: string, label: string, options: [K, string][], get: () => K, set: (v: K) => void): HTMLElement {
    const inputs = options.map(([value]) => el('input', {type: 'radio', name: `view-${name}`, change: () => { set(value); this.apply(); }}));
    this.syncs.push(() => options.forEach(([value], i) => { inputs[i]!.checked = get() === value; }));
    return el('div', {class: 'v-seg', role: 'radiogroup', 'aria-label': label}, ...options.map(([, text], i) => el('label', {}, inputs[i]!, el('span', {}, text))));
  }
  private check(text: string, get: () => boolean, set: (v: boolean) => void): HTMLElement {
    const input = el('input', {type: 'checkbox', change: () => { set(input.checked); this.apply(); }});
    this.syncs.push(() => { input.checked = get(); });
    return el('label', {class: 'v-check'}, input, text);
  }
  private slide(text: string, low: number, high: number, step: number, get: () => number, set: (v: number) => void, write: (v: number) => string): HTMLElement {
    const input = el('input', {type: 'range', min: low, max: high, step, input: () => { set(Number(input.value)); this.apply(); }});
    const output = el('output', {});
    this.syncs.push(() => { input.value = String(get()); output.textContent = write(get()); });
    return el('label', {class: 'v-slide'}, text, input, output);
  }
  private choice(label: string, options: [string, string][], get: () => string, set: (v: string) => void): HTMLElement {
    const select = el('select', {'aria-label': label, change: () => { set(select.value); this.apply(); }},
      ...options.map(([value, text]) => el('option', {value}, text)));
    this.syncs.push(() => { select.value = get(); });
    return select;
  }
  private button(text: string, f: () => void): HTMLButtonElement { return el('button', {type: 'button', click: f}, text); }

  private panel(): HTMLElement {
    const groups: HTMLElement[] = [];
    const isWide = window.innerWidth > 860;
    groups.push(this.group('Surface', true, ...this.surfaceControls()), this.group('Read and measure', true, ...this.toolControls()),
      this.group('Colours of the difference', true, ...this.colourControls()), this.group('Point of view', isWide, ...this.viewControls()));
    groups.push(this.placesGroup);
    groups.push(this.group('Cut away the sides', false, ...this.clipControls()), this.group('Save', false, ...this.saveControls()),
      this.group('Mouse, touch and keys', false, this.help()));
    return el('div', {class: 'v-panel', role: 'region', 'aria-label': 'Controls of the view', tabindex: 0}, ...groups);
  }

  private surfaceControls(): HTMLElement[] {
    const s = this.state, {a, b} = this.page.words, out: HTMLElement[] = [];
    if (this.surfaces.length > 1)
      out.push(this.segmented('scene', 'Before or after', this.surfaces.map((x, i) => [i, x.data.label]), () => s.scene, v => { s.scene = v; }));
    out.push(this.segmented<Show>('show', 'Surface shown', [['a', a], ['b', b], ['both', 'both']], () => s.show, v => { s.show = v; }));
    out.push(this.choice('Colours of the surface', [['difference', 'coloured by the difference'], ['height', 'coloured by height'], ['plain', 'shaded only']],
      () => s.mode, v => { s.mode = v as Mode; }));
    out.push(el('div', {class: 'v-row'}, this.button('Flicker between the two', () => this.flicker()), el('span', {class: 'v-hint'}, 'key: space')));
    return out;
  }

  private colourControls(): HTMLElement[] {
    const s = this.state, out: HTMLElement[] = [this.bars.element as unknown as HTMLElement];
    const limit = (upper: boolean): HTMLElement => {
      const input = el('input', {type: 'number', step: 'any', 'aria-label': upper ? 'Upper limit of the colours' : 'Lower limit of the colours',
        change: () => { this.setLimit(upper, Number(input.value)); this.apply(); }});
      this.syncs.push(() => { if (document.activeElement !== input) input.value = String(Number((upper ? s.high : s.low).toPrecision(4))); });
      return input;
    };
    out.push(el('div', {class: 'v-row'}, limit(false), '\u2026', limit(true), this.page.heightUnit));
    out.push(this.check('the same limit above and below', () => s.symmetric, v => { s.symmetric = v; if (v) s.low = -s.high; }));
    out.push(this.choice('Palette', paletteNames, () => s.palette, v => { s.palette = v; }));
    if (this.surfaces.some(x => x.c.lod)) out.push(this.check('grey within the level of detection', () => s.grey, v => { s.grey = v; }));
    out.push(this.check('hatched beyond the limits', () => s.hatch, v => { s.hatch = v; }));
    return out;
  }

  private viewControls(): HTMLElement[] {
    const s = this.state;
    const parallel = el('input', {type: 'checkbox', change: () => { this.stage.setParallel(parallel.checked); this.writeHash(); }});
    this.syncs.push(() => { parallel.checked = this.stage.orthographic; });
    const full: HTMLButtonElement = this.button('Fill the window', () => {
      const on = this.root.classList.toggle('v-full');
      full.setAttribute('aria-pressed', String(on));
      this.resize();
    });
    full.setAttribute('aria-pressed', 'false');
    return [
      el('div', {class: 'v-row'}, this.button('From above', () => this.fromAbove()), this.button('Oblique', () => this.stage.lookFrom(...this.oblique())),
        this.button('Level', () => this.stage.lookFrom(180, 4)), full),
      el('label', {class: 'v-check'}, parallel, 'no perspective (to scale)'),
      this.slide('Heights \u00d7', -1, 1.7, 0.01, () => Math.log10(s.exaggeration), v => { s.exaggeration = Math.abs(v) < 0.03 ? 1 : 10 ** v; }, () => brief(s.exaggeration)),
      this.slide('Light from', 0, 360, 5, () => s.light, v => { s.light = v; }, v => `${v}\u00b0`),
    ];
  }

  private fromAbove(): void { this.stage.lookFrom(180, 89.999); }

  private readonly finishButton = this.button('Finish', () => this.finish());
  private readonly undoButton = this.button('Undo last point', () => { this.state.line.pop(); this.state.done = false; this.apply(); });
  private readonly clearButton = this.button('Clear', () => { this.clear(); });
  private readonly toolHint = el('p', {class: 'v-hint'});

  private toolControls(): HTMLElement[] {
    const s = this.state;
    const hints: Record<Tool, string> = {
      read: 'Click on the surface: ' + (this.page.places ? 'its coordinates and the difference there stand' : 'the difference there stands') + ' below. Key C copies it.',
      section: 'Click points along a line, then Finish (or double-click): both surfaces along it are drawn below.',
      polygon: 'Click the corners of an area, then Finish (or double-click): the volumes over it stand below.',
    };
    this.syncs.push(() => {
      this.toolHint.textContent = hints[s.tool];
      const isLine = s.tool !== 'read';
      this.finishButton.disabled = s.done || s.line.length < (s.tool === 'polygon' ? 3 : 2);
      this.undoButton.disabled = this.clearButton.disabled = s.line.length === 0;
      for (const b of [this.finishButton, this.undoButton, this.clearButton]) b.hidden = !isLine;
    });
    return [
      this.segmented<Tool>('tool', 'What a click does', [['read', 'value'], ['section', 'section'], ['polygon', 'volume']], () => s.tool,
        v => { s.tool = v; s.line = []; s.done = false; }),
      this.toolHint, el('div', {class: 'v-row'}, this.finishButton, this.undoButton, this.clearButton),
    ];
  }

  private readonly placeList = el('ul', {class: 'v-list'});
  private readonly placesGroup = this.group('Go to', false, this.placeList);

  private places(): void {
    const surface = this.surfaces[this.state.scene]!, {c, data} = surface, rows: HTMLElement[] = [];
    const radius = this.stage.radius;
    const add = (name: string, value: string, f: () => void): void => {
      rows.push(el('li', {}, el('button', {type: 'button', click: f}, el('span', {}, name), el('span', {}, value))));
    };
    for (const row of [...data.budget, ...data.changes]) {
      const [x0, y0, x1, y1] = row.box, middle = {x: (x0 + x1) / 2, y: (y0 + y1) / 2};
      add(row.name, `net ${signed(row.net)} ${this.page.volumeUnit}`, () => {
        const r = surface.at(middle.x, middle.y);
        this.stage.flyTo(middle, r?.zb ?? surface.box.minZ, Math.max(Math.hypot(x1 - x0, y1 - y0) / 2 * 1.2, radius / 200));
      });
    }
    for (const sign of [1, -1] as const)
      for (const i of surface.extremes(sign, 3, 0.12 * radius)) {
        const place = {x: c.x[i]!, y: c.y[i]!};
        add(sign > 0 ? this.page.words.above : this.page.words.below, `${signed(c.d[i]!, 3)} ${this.page.heightUnit}`, () => {
          this.stage.flyTo(place, c.z[i]! + c.d[i]!, radius / 6);
          this.read(place);
        });
      }
    this.placeList.replaceChildren(...rows);
    this.placesGroup.hidden = rows.length === 0;
  }

  private clipControls(): HTMLElement[] {
    const s = this.state, [w, e, n, so] = this.page.north ? ['west', 'east', 'north', 'south'] : ['left', 'right', 'far', 'near'];
    const percent = (v: number): string => `${Math.round(100 * v)} %`;
    const side = (name: string, i: 0 | 1 | 2 | 3): HTMLElement => this.slide(name, 0, 0.95, 0.005,
      () => (i < 2 ? s.clip[i] : 1 - s.clip[i]), v => { s.clip = s.clip.map((old, k) => (k === i ? (i < 2 ? v : 1 - v) : old)) as State['clip']; }, percent);
    return [side(w!, 0), side(e!, 2), side(n!, 3), side(so!, 1)];
  }

  private saveControls(): HTMLElement[] {
    const said = el('span', {class: 'v-hint', role: 'status'});
    return [el('div', {class: 'v-row'}, this.button('Picture (PNG)', () => this.savePicture()), this.button('Copy link to this view', async () => {
      this.writeHashNow();
      said.textContent = await copy(location.href) ? 'copied' : 'the address of this page holds the view';
    }), said)];
  }

  private help(): HTMLElement {
    const rows: [string, string][] = [['drag, one finger', 'turn'], ['right button or Shift + drag, two fingers', 'move'], ['wheel, pinch, + and \u2212', 'nearer, farther'],
      ['click, tap, Enter (at the cross)', 'read a value, add a point'], ['Space', 'the other surface'], ['C', 'copy the value read'], ['T, O', 'from above, oblique'],
      ['arrows; with Shift', 'move; turn'], ['Esc', 'clear the line; leave the full window']];
    return el('div', {id: 'view-help'}, el('table', {}, el('tbody', {}, ...rows.map(([k, v]) => el('tr', {}, el('td', {}, k), el('td', {}, v))))));
  }

  // --- what happens -------------------------------------------------------------------------------------------------

  private listen(): void {
    const {canvas} = this;
    let down: {x: number; y: number} | null = null;
    canvas.addEventListener('pointerdown', e => { down = e.isPrimary && e.button === 0 ? {x: e.clientX, y: e.clientY} : null; });
    canvas.addEventListener('pointerup', e => {
      if (!down || Math.hypot(e.clientX - down.x, e.clientY - down.y) > 5) return;
      const box = canvas.getBoundingClientRect();
      this.click(e.clientX - box.left, e.clientY - box.top);
    });
    canvas.addEventListener('dblclick', e => { e.preventDefault(); if (this.state.tool !== 'read') this.finish(); });
    canvas.addEventListener('keydown', e => this.key(e));
    this.swipeInput.addEventListener('input', () => { this.state.swipe = Number(this.swipeInput.value); this.apply(); });
    this.syncs.push(() => { this.swipeInput.value = String(this.state.swipe); });
    new ResizeObserver(() => this.resize()).observe(canvas);
    window.addEventListener('hashchange', () => { if (location.hash !== this.written) { this.readHash(); this.apply(); } });
    window.addEventListener('beforeprint', () => { this.printed.src = this.picture(2000).toDataURL('image/png'); });
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.apply());
    document.addEventListener('keydown', e => {
      if (e.key === 'Escape' && this.root.classList.contains('v-full') && this.state.line.length === 0)
        (this.root.querySelector('button[aria-pressed=true]') as HTMLElement | null)?.click();
    });
  }

  private key(e: KeyboardEvent): void {
    if (e.ctrlKey || e.metaKey || e.altKey) return;
    const zoom = (by: number): void => {
      const {controls, camera} = this.stage;
      if ('isOrthographicCamera' in camera) camera.zoom /= by;
      else camera.position.sub(controls.target).multiplyScalar(by).add(controls.target);
      controls.update(); this.stage.draw(); this.writeHash();
    };
    const keys: Record<string, () => void> = {
      ' ': () => this.flicker(), c: () => void this.copyReading(), t: () => this.fromAbove(), o: () => this.stage.lookFrom(...this.oblique()),
      '+': () => zoom(0.8), '=': () => zoom(0.8), '-': () => zoom(1.25), Enter: () => this.click(this.canvas.clientWidth / 2, this.canvas.clientHeight / 2),
      Escape: () => this.clear(),
    };
    const act = keys[e.key.length === 1 ? e.key.toLowerCase() : e.key];
    if (!act) return;
    e.preventDefault();
    act();
  }

  private flicker(): void { this.state.show = this.state.show === 'b' ? 'a' : 'b'; this.apply(); }

  private click(px: number, py: number): void {
    const place = this.stage.pick(px, py);
    if (!place) { if (this.state.tool === 'read') { this.last = null; this.tell('Nothing is compared there.'); } return; }
    if (this.state.tool === 'read') return this.read(place);
    if (this.state.done) { this.state.line = []; this.state.done = false; }
    const previous = this.state.line.at(-1);
    if (previous && Math.hypot(previous.x - place.x, previous.y - place.y) < 2 * this.stage.pixel) return;  // of a double click
    this.state.line.push(place);
    this.apply();
  }

  private read(place: Place): void {
    this.last = this.stage.surface.at(place.x, place.y);
    this.tell();
    this.showLine();
  }

  private decimals(step: number): number { return Math.min(9, Math.max(0, Math.ceil(-Math.log10(2 * step || 1e-3)))); }

  private coordinates(r: Reading): {a: number[]; b: number[]; plane: number; up: number} {
    const {data} = this.stage.surface;
    return {a: toInput(data.frame, r.x, r.y, r.za), b: toInput(data.frame, r.x, r.y, r.zb), plane: this.decimals(data.x.step),
      up: this.decimals(Math.max(data.d.step, data.z.step) || data.x.step)};
  }

  private tell(words = ''): void {
    const r = this.last, {page} = this, {a, b} = page.words;
    if (!r) { this.reading.replaceChildren(el('i', {class: 'v-tools'}, words || `Click on the surface to read ${page.places ? 'its coordinates and ' : ''}the difference there.`)); return; }
    const p = this.coordinates(r), unit = page.heightUnit, parts: [string, string][] = [];
    if (page.vertical) parts.push(['x', fixed(p.a[0]!, p.plane)], ['y', fixed(p.a[1]!, p.plane)], [`z of ${a}`, fixed(p.a[2]!, p.up)], [`z of ${b}`, fixed(p.b[2]!, p.up)]);
    else if (page.places) parts.push([a, p.a.map(v => fixed(v, p.up)).join(', ')], [b, p.b.map(v => fixed(v, p.up)).join(', ')]);
    parts.push(['difference', `${r.d > 0 ? '+' : ''}${fixed(r.d, p.up)} ${unit}`]);
    if (r.lod !== null) parts.push(['level of detection', `\u00b1${num(r.lod, 2)} ${unit}: ${Math.abs(r.d) > r.lod ? 'significant' : 'within it'}`]);
    this.reading.replaceChildren(...parts.map(([k, v]) => el('span', {}, el('i', {}, k), el('b', {}, v))));
    const copied = this.button('Copy', () => void this.copyReading());
    copied.classList.add('v-tools');
    this.reading.append(copied);
  }

  private async copyReading(): Promise<void> {
    const r = this.last;
    if (!r) return;
    const p = this.coordinates(r), row = this.page.vertical
      ? [p.a[0]!.toFixed(p.plane), p.a[1]!.toFixed(p.plane), p.a[2]!.toFixed(p.up), p.b[2]!.toFixed(p.up)]
      : this.page.places ? [...p.a, ...p.b].map(v => v.toFixed(p.up)) : [];
    const text = [...row, r.d.toFixed(p.up), ...(r.lod === null ? [] : [r.lod.toPrecision(3)])].join('\t');
    const done = await copy(text);
    this.reading.querySelector('.v-copied')?.remove();
    this.reading.append(el('i', {class: 'v-copied'}, done ? 'copied' : text));
  }

  private clear(): void { this.state.line = []; this.state.done = false; this.last = null; this.tell(); this.apply(); }

  private finish(): void {
    const s = this.state;
    if (s.tool === 'read' || s.line.length < (s.tool === 'polygon' ? 3 : 2)) return;
    s.done = true;
    this.apply();
  }

  // --- the line: section or polygon -----------------------------------------------------------------------------

  private shownLine = '';

  private showLine(): void {
    const s = this.state, surface = this.stage.surface;
    const height = (r: Reading): number => (s.show === 'a' ? r.za : r.zb);
    const onSurface = (p: Place): [number, number, number] => {
      const r = surface.at(p.x, p.y);
      return [p.x, p.y, r ? height(r) : (surface.box.minZ + surface.box.maxZ) / 2];
    };
    const closed = s.tool === 'polygon' && s.line.length > 2 && s.done ? [...s.line, s.line[0]!] : s.line;
    const stretches = closed.length > 1 ? surface.section(closed) : [];
    const points = stretches.length ? stretches.flatMap(t => [t.from, t.to]).map(r => [r.x, r.y, height(r)] as [number, number, number]) : [];
    const marks = s.line.map(onSurface);
    if (s.tool === 'read' && this.last) marks.push([this.last.x, this.last.y, height(this.last)]);
    this.stage.setLine(points, marks, getComputedStyle(this.root).getPropertyValue('--ink').trim() || '#000');
    const key = JSON.stringify([s.scene, s.tool, s.done, s.line]);
    if (key === this.shownLine) return;
    this.shownLine = key;
    this.below.hidden = !s.done || s.tool === 'read';
    if (this.below.hidden) { this.below.replaceChildren(); return; }
    if (s.tool === 'section') this.showSection(surface.section(s.line)); else this.showVolumes();
  }

  private thinning(): string {
    const {data} = this.stage.surface, unit = this.page.heightUnit, {drawn} = this.page;
    if (drawn) return `The view is ${drawn}${data.whole ? '' : `, and has ${fixed(data.nodes, 0)} of ${fixed(data.of, 0)} of them; at each of these its d is within ${num(data.error.d, 2)} ${unit} of their mean`}.`;
    return data.whole ? 'The view has every node of the comparison.'
      : `The view has ${fixed(data.nodes, 0)} of ${fixed(data.of, 0)} nodes. At every node of the comparison its d is within ${num(data.error.d, 2)} ${unit} of the exact one, within ${num(data.error.rms, 2)} ${unit} as the root mean square.`;
  }

  private showSection(stretches: Stretch[]): void {
    if (stretches.length === 0) { this.below.replaceChildren(el('p', {}, 'The line does not cross the area compared.')); return; }
    const chart = sectionChart(stretches, this.page, Math.min(1000, Math.max(340, this.root.clientWidth - 32)),
      this.page.vertical ? this.stage.surface.data.frame.origin[2] : 0);
    this.below.replaceChildren(chart, el('p', {class: 'v-hint'}, `Every crossing with the triangles shown, none left out. ${this.thinning()}`),
      el('div', {class: 'v-row v-tools'}, this.button('Values (CSV)', () => save('section.csv', 'text/csv', this.sectionCsv(stretches))),
        this.button('Drawing (SVG)', () => {
          const style = getComputedStyle(this.root), copied = chart.cloneNode(true) as SVGElement;
          copied.setAttribute('style', `color:#333;--accent:${style.getPropertyValue('--accent').trim()};background:#fff`);
          save('section.svg', 'image/svg+xml', new XMLSerializer().serializeToString(copied));
        })));
  }

  private sectionCsv(stretches: Stretch[]): string {
    const {data} = this.stage.surface, hasLevel = data.lod !== null;
    const lines = [`s,x,y,z_a,z_b,d${hasLevel ? ',lod' : ''}`];
    let last = -1;
    for (const e of stretches.flatMap(t => [t.from, t.to])) {
      if (e.s === last) continue;
      last = e.s;
      const p = this.page.vertical ? toInput(data.frame, e.x, e.y, e.za) : [e.x, e.y, e.za];
      const zb = this.page.vertical ? toInput(data.frame, e.x, e.y, e.zb)[2]! : e.zb;
      lines.push([e.s, p[0], p[1], p[2], zb, e.d, ...(hasLevel ? [e.lod] : [])].join(','));
    }
    return lines.join('\n') + '\n';
  }

  private showVolumes(): void {
    const s = this.state, {page} = this, {data} = this.stage.surface;
    if (!isSimple(s.line)) { this.below.replaceChildren(el('p', {}, 'The sides of this area cross each other: undo a point, or clear it.')); return; }
    const v = this.stage.surface.volumes(s.line), row = (k: string, value: string): HTMLElement =>
      el('tr', {}, el('td', {}, k), el('td', {class: 'n'}, value));
    const table = el('table', {}, el('tbody', {}, row(page.words.above, `${num(v.above)} ${page.volumeUnit}`), row(page.words.below, `${num(v.below)} ${page.volumeUnit}`),
      row('net', `${signed(v.above - v.below)} ${page.volumeUnit}`), row('area compared in it', `${num(v.area)} ${page.areaUnit} (${num(100 * v.area / (v.polygonArea || 1), 3)} %)`),
      row('mean difference', v.area > 0 ? `${signed((v.above - v.below) / v.area)} ${page.heightUnit}` : '\u2013')));
    table.dataset['above'] = String(v.above); table.dataset['below'] = String(v.below); table.dataset['area'] = String(v.area);
    table.dataset['bound'] = String(data.error.d * v.area);
    const parts: HTMLElement[] = [table, el('p', {class: 'v-hint'},
      `In closed form on the triangles shown. ${this.thinning()} Over this area that is at most about ${num(data.error.d * v.area, 2)} ${page.volumeUnit}.`)];
    const buttons = el('div', {class: 'v-row v-tools'}, this.button('This area (GeoJSON)', () => save('area.geojson', 'application/geo+json', this.areaJson())));
    if (page.command && page.vertical)
      parts.push(el('p', {class: 'v-hint'}, 'Exact volumes: save the area, then add ', el('code', {}, '--budget area.geojson'), ' to the command of this report, e.g. ',
        el('code', {class: 'v-command'}, `${page.command} --budget area.geojson`)), buttons);
    this.below.replaceChildren(...parts);
  }

  private areaJson(): string {
    const {frame} = this.stage.surface.data;
    const ring = [...this.state.line, this.state.line[0]!].map(p => toInput(frame, p.x, p.y, 0).slice(0, 2));
    return JSON.stringify({type: 'FeatureCollection', features: [{type: 'Feature', properties: {name: 'area'}, geometry: {type: 'Polygon', coordinates: [ring]}}]}) + '\n';
  }

  // --- drawing over the surface ------------------------------------------------------------------------------------

  private resize(): void {
    const {clientWidth, clientHeight} = this.canvas;
    if (clientWidth > 0 && clientHeight > 0) this.stage.resize(clientWidth, clientHeight);
  }

  private overlays(): void {
    this.northArrow.setAttribute('transform', `rotate(${(-(this.stage.azimuth + 180)).toFixed(1)})`);
    const {pixel} = this.stage, length = nice(140 * pixel);
    this.scaleBar.style.width = `${(length / pixel).toFixed(1)}px`;
    this.scaleText.textContent = `${num(length, 1)} ${this.page.unit}${this.stage.orthographic ? '' : ' (in the middle)'}`
      + (this.state.exaggeration === 1 ? '' : `, heights \u00d7 ${brief(this.state.exaggeration)}`);
  }

  private footer(): void {
    const {data} = this.stage.surface, {page} = this, t = data.thinned, x = data.exact;
    const totals = data.whole && !page.drawn ? '' : ` In all it has ${num(t.above, 5)} ${page.volumeUnit} above and ${num(t.below, 5)} below on ${num(t.area, 5)} ${page.areaUnit}; exact are ${num(x.above, 5)} and ${num(x.below, 5)} on ${num(x.area, 5)}.`;
    this.foot.textContent = `${this.thinning()}${totals}`;
  }

  /** The view with its legend, as it is now. */
  private picture(width: number): HTMLCanvasElement {
    this.stage.drawNow();
    const source = this.stage.renderer.domElement, height = Math.round(width * source.height / source.width), foot = Math.round(width * 0.075);
    const out = el('canvas', {width, height: height + foot}), g = out.getContext('2d')!, s = this.state, {page} = this;
    g.fillStyle = '#fff'; g.fillRect(0, 0, width, height + foot);
    g.drawImage(source, 0, 0, width, height);
    const unit = width / 1000, y = height + 18 * unit;
    g.fillStyle = '#1d2126'; g.font = `${13 * unit}px system-ui, sans-serif`; g.textBaseline = 'alphabetic';
    if (s.mode === 'difference') {
      for (let i = 0; i < 300; ++i) {
        const d = s.low + (s.high - s.low) * (i + 0.5) / 300;
        g.fillStyle = css(this.legend(d)); g.fillRect((20 + i) * unit, y, 1.5 * unit, 16 * unit);
      }
      g.fillStyle = '#1d2126';
      g.fillText(signed(s.low, 3), 20 * unit, y + 34 * unit);
      g.textAlign = 'right'; g.fillText(`${signed(s.high, 3)} ${page.heightUnit}`, 320 * unit, y + 34 * unit);
      g.textAlign = 'center'; g.fillText('difference', 170 * unit, y + 34 * unit); g.textAlign = 'left';
    }
    const length = nice(140 * this.stage.pixel), drawn = length / this.stage.pixel * width / this.stage.canvas.clientWidth;
    g.fillRect(370 * unit, y + 10 * unit, drawn, 3 * unit);
    g.fillText(this.scaleText.textContent ?? '', 370 * unit, y + 34 * unit);
    g.textAlign = 'right'; g.fillText(this.fitted(g, `${this.tag.textContent}: ${page.title}`, 290 * unit), width - 60 * unit, y + 34 * unit);
    if (!page.vertical) return out;
    g.translate(width - 28 * unit, y + 16 * unit); g.textAlign = 'center';
    g.fillText(page.north ? 'N' : 'y', 0, 24 * unit);
    g.rotate(-(this.stage.azimuth + 180) * Math.PI / 180); g.scale(unit, unit); g.fill(new Path2D('M0 -14L8 10L0 5L-8 10Z'));
    return out;
  }
  private fitted(g: CanvasRenderingContext2D, text: string, width: number): string {
    let out = text;
    while (out.length > 2 && g.measureText(out).width > width) out = out.slice(0, -2).trimEnd() + '\u2026';
    return out;
  }
  private savePicture(): void {
    this.picture(Math.max(1600, this.stage.renderer.domElement.width)).toBlob(blob => { if (blob) save('view.png', 'image/png', blob); });
  }

  // --- the state in the address --------------------------------------------------------------------------------------

  private written = '';

  private writeHash(): void { clearTimeout(this.hashTimer); this.hashTimer = window.setTimeout(() => this.writeHashNow(), 300); }
  private writeHashNow(): void {
    const s = this.state, {frame} = this.stage.surface.data, p = new URLSearchParams();
    const short = (v: number): string => String(Number(v.toPrecision(6)));
    p.set('camera', this.stage.state.map(v => String(Number(v.toPrecision(12)))).join(','));
    p.set('show', s.show); p.set('colours', `${s.mode},${s.palette}`); p.set('limits', `${short(s.low)},${short(s.high)}`);
    p.set('look', [s.exaggeration, s.light, s.grey ? 1 : 0, s.hatch ? 1 : 0, s.symmetric ? 1 : 0, s.swipe].map(short).join(','));
    if (this.surfaces.length > 1) p.set('scene', String(s.scene));
    if (s.clip.some((v, i) => v !== (i < 2 ? 0 : 1))) p.set('clip', s.clip.map(short).join(','));
    if (s.tool !== 'read') p.set(s.tool, s.line.map(q => toInput(frame, q.x, q.y, 0).map(v => v).join(' ')).join(',') + (s.done ? '!' : ''));
    else if (this.last) p.set('read', toInput(frame, this.last.x, this.last.y, this.last.za).join(' '));
    this.written = '#' + p.toString().replaceAll('%2C', ',').replaceAll('+', '_').replaceAll('%21', '!');
    try { history.replaceState(null, '', this.written); } catch { /* a page within another, or one without an address */ }
  }

  private readHash(): void {
    if (!location.hash.includes('camera=') && !location.hash.includes('=')) return;
    const p = new URLSearchParams(location.hash.slice(1).replaceAll('_', ' ')), s = this.state;
    const list = (name: string): number[] => (p.get(name) ?? '').split(',').map(Number);
    const within = (v: number, low: number, high: number): boolean => Number.isFinite(v) && v >= low && v <= high;
    const scene = Number(p.get('scene') ?? s.scene);
    if (this.surfaces[scene]) s.scene = scene;
    const show = p.get('show');
    if (show === 'a' || show === 'b' || show === 'both') s.show = show;
    const [mode, palette] = (p.get('colours') ?? '').split(',');
    if (mode === 'difference' || mode === 'height' || mode === 'plain') s.mode = mode;
    if (paletteNames.some(([n]) => n === palette)) s.palette = palette!;
    const [low, high] = list('limits');
    if (low! < 0 && high! > 0) { s.low = Math.max(low!, -this.reach); s.high = Math.min(high!, this.reach); s.symmetric = s.low === -s.high; }
    const [e, light, grey, hatch, symmetric, swipe] = list('look');
    if (within(e!, 0.05, 100)) s.exaggeration = e!;
    if (within(light!, 0, 360)) s.light = light!;
    if (swipe !== undefined) { s.grey = grey === 1; s.hatch = hatch === 1; s.symmetric = symmetric === 1; if (within(swipe, 0, 1)) s.swipe = swipe; }
    const clip = list('clip');
    if (clip.length === 4 && clip.every(v => within(v, 0, 1))) s.clip = clip as State['clip'];
    this.stage.setScene(s.scene);
    this.stage.setLook(this.look());
    const camera = list('camera');
    if (camera.length === 7 && camera.every(Number.isFinite)) this.stage.state = camera;
    this.readLine(p);
  }

  private readLine(p: URLSearchParams): void {
    const s = this.state, {frame} = this.stage.surface.data;
    const place = (text: string): Place | null => {
      const v = text.trim().split(' ').map(Number);
      if (v.length < 2 || !v.every(Number.isFinite)) return null;
      const [x, y] = toFrame(frame, [v[0]!, v[1]!, v[2] ?? frame.origin[2]]);
      return {x, y};
    };
    for (const tool of ['section', 'polygon'] as const) {
      const text = p.get(tool);
      if (text === null) continue;
      s.tool = tool;
      s.line = text.replace('!', '').split(',').filter(t => t).map(place).filter(q => q !== null);
      s.done = text.endsWith('!') && s.line.length > (tool === 'polygon' ? 2 : 1);
    }
    const read = place(p.get('read') ?? 'none');
    if (read && s.tool === 'read') { this.last = this.stage.surface.at(read.x, read.y); this.tell(); } else this.tell();
  }
}

/** The pictures stay, behind a word, for those who want one to keep. */
function keepPictures(place: HTMLElement, word: string): void {
  const figures: Element[] = [];
  for (let f = place.nextElementSibling; f?.tagName === 'FIGURE'; f = f.nextElementSibling) figures.push(f);
  if (figures.length > 0) {
    const kept = el('details', {}, el('summary', {}, word));
    place.after(kept);
    kept.append(...figures);
  }
  // Tables that are wider than a phone are scrolled by keys, too.
  for (const box of document.querySelectorAll<HTMLElement>('.scroll, main > pre')) if (box.scrollWidth > box.clientWidth) box.tabIndex = 0;
}

async function start(): Promise<void> {
  const place = document.getElementById('view'), source = document.getElementById('view-data');
  if (!place || !source) return;
  const page = JSON.parse(source.textContent ?? '') as PageData | SpaceData;
  const probe = document.createElement('canvas').getContext('webgl2');
  if (!probe || typeof DecompressionStream === 'undefined') return;  // the page is complete without the view
  probe.getExtension('WEBGL_lose_context')?.loseContext();
  if ('kind' in page) {
    const {columns, corners} = await decodedSpace(page);
    document.head.append(el('style', {}, style));
    const space = new SpaceView(place, page, columns, corners);
    keepPictures(place, 'As a picture');
    requestAnimationFrame(() => { space.begin(); requestAnimationFrame(() => { document.documentElement.dataset['view'] = 'ready'; }); });
    return;
  }
  const surfaces = await Promise.all(page.scenes.map(s => Surface.of(s)));
  if (surfaces.some(s => s.triangles === 0)) return;
  document.head.append(el('style', {}, style));
  const view = new View(place, page, surfaces);
  keepPictures(place, place.nextElementSibling?.nextElementSibling?.tagName === 'FIGURE' ? 'The maps as pictures' : 'The map as a picture');
  requestAnimationFrame(() => setTimeout(() => {  // after the first frame
    view.prepare();
    document.documentElement.dataset['view'] = 'ready';
  }));
}

void start();
