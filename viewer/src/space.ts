// The view of points in space: parts of a model, coloured by a distance or by what they belong to, moved frame by frame.
import {
  BufferAttribute, BufferGeometry, DataTexture, DoubleSide, LinearFilter, Matrix3, Matrix4, Mesh, PerspectiveCamera, Points, RGBAFormat,
  Scene, ShaderMaterial, Vector2, Vector3, WebGLRenderer,
} from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import {type SpaceData} from './block';
import {colour, css, table} from './palette';
import {copy, el, fixed, nice, num, save, signed} from './words';

const vertex = `
attribute float value, level, part, blend; attribute vec3 facing;
uniform mat4 motion; uniform mat3 turn; uniform float size, pixels, shown[8];
varying float vValue, vLevel; varying vec3 vNormal2; varying float vPart;
void main() {
  vec3 p = mix(position, (motion * vec4(position, 1.0)).xyz, blend);
  vec3 n = mix(facing, turn * facing, blend);
  vec4 eye = modelViewMatrix * vec4(p, 1.0);
  vNormal2 = normalize(normalMatrix * n);
  vValue = value; vLevel = level; vPart = part;
  gl_Position = projectionMatrix * eye;
  if (shown[int(part + 0.5)] < 0.5) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = clamp(size * pixels / -eye.z, 1.5, 64.0);
}`;
const fragment = `
uniform sampler2D ramp; uniform vec3 colours[8]; uniform float mode, limit, isPoint, grey;
varying float vValue, vLevel; varying vec3 vNormal2; varying float vPart;
void main() {
  if (isPoint > 0.5) { vec2 c = gl_PointCoord - 0.5; if (dot(c, c) > 0.25) discard; }
  vec3 colour = colours[int(vPart + 0.5)];
  if (mode > 0.5) {
    colour = vec3(0.58, 0.56, 0.54);
    if (vValue < 1e29) colour = grey > 0.5 && !(abs(vValue) > vLevel) ? vec3(0.77) :
      texture2D(ramp, vec2(0.5 + 0.4990234 * clamp(vValue / limit, -1.0, 1.0), 0.5)).rgb;
  } else if (mode < -0.5) colour = vec3(0.80, 0.78, 0.75);
  vec3 n = normalize(vNormal2);
  if (n.z < 0.0) n = -n;
  float shade = min(1.0, 0.5 + 0.55 * max(0.0, dot(n, vec3(-0.45, 0.55, 0.70))));
  gl_FragColor = vec4(colour * shade, 1.0);
}`;

type Columns = Map<string, Float64Array>;

export class SpaceView {
  private readonly renderer: WebGLRenderer;
  private readonly controls: OrbitControls;
  private readonly camera = new PerspectiveCamera(30, 1, 1, 1000);
  private readonly scene = new Scene();
  private readonly canvas = el('canvas', {tabindex: 0, role: 'application', 'aria-describedby': 'view-help'});
  private readonly tag = el('div', {class: 'v-over v-tag'});
  private readonly scaleBar = el('i');
  private readonly scaleText = el('span');
  private readonly reading = el('div', {class: 'v-read', 'aria-live': 'polite', role: 'status'});
  private readonly printed = el('img', {class: 'v-print', alt: 'The model as it was turned when the page was printed'});
  private readonly mark = new Points(new BufferGeometry(), new ShaderMaterial({depthTest: false,
    vertexShader: 'void main() { gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); gl_PointSize = 15.0; }',
    fragmentShader: 'void main() { vec2 c = gl_PointCoord - 0.5; float r = dot(c, c); if (r > 0.25) discard; gl_FragColor = vec4(vec3(r > 0.11 ? 1.0 : 0.0), 1.0); }'}));
  private readonly root: HTMLElement;
  private readonly uniforms: Record<string, {value: unknown}>;
  private readonly places: Float32Array;  // axes of the view, from the middle
  private readonly middle: [number, number, number];
  private readonly radius: number;
  private readonly shown: boolean[];
  private readonly syncs: (() => void)[] = [];
  private frame = 0;
  private motion = new Matrix4();
  private playing = 0;  // timer
  private speed = 1;
  private mode: number;
  private limit: number;
  private size = 1;
  private last = -1;
  private queued = false;
  private hashTimer = 0;

  constructor(place: HTMLElement, private readonly page: SpaceData, private readonly c: Columns, corners: Uint32Array) {
    const n = page.nodes, [x, y, z] = ['x', 'y', 'z'].map(k => c.get(k)!) as [Float64Array, Float64Array, Float64Array];
    const ends = [x, y, z].map(v => v.reduce(([a, b], w) => [Math.min(a!, w), Math.max(b!, w)], [Infinity, -Infinity])) as [number, number][];
    this.middle = ends.map(([a, b]) => (a + b) / 2) as [number, number, number];
    this.radius = Math.hypot(...ends.map(([a, b]) => b - a)) / 2 || 1;
    this.places = new Float32Array(3 * n);
    const facing = new Float32Array(3 * n), u = page.upright, coded = c.get('normal')!;
    for (let i = 0; i < n; ++i) {
      const p = [x[i]! - this.middle[0], y[i]! - this.middle[1], z[i]! - this.middle[2]];
      for (let k = 0; k < 3; ++k) this.places[3 * i + k] = u[3 * k]! * p[0]! + u[3 * k + 1]! * p[1]! + u[3 * k + 2]! * p[2]!;
      const s = Math.floor(coded[i]! / 64) / 31.5 - 1, t = coded[i]! % 64 / 31.5 - 1, a = (s + t) / 2, b = (s - t) / 2;
      facing.set([a, b, 1 - Math.abs(a) - Math.abs(b)], 3 * i);
    }
    const has = c.has('value'), column = (name: string, other: number): Float32Array =>
      c.has(name) ? Float32Array.from(c.get(name)!, v => (Number.isNaN(v) ? 1e30 : v)) : new Float32Array(n).fill(other);
    this.mode = has ? 1 : 0;
    this.limit = page.limit > 0 ? page.limit : 1;
    this.shown = page.parts.map(() => true);
    const g = new BufferGeometry();
    g.setAttribute('position', new BufferAttribute(this.places, 3));
    g.setAttribute('facing', new BufferAttribute(facing, 3));
    g.setAttribute('value', new BufferAttribute(column('value', 0), 1));
    g.setAttribute('level', new BufferAttribute(column('level', -1), 1));
    g.setAttribute('part', new BufferAttribute(column('part', 0), 1));
    g.setAttribute('blend', new BufferAttribute(column('blend', 0), 1));
    const ramp = new DataTexture(table(1025, t => colour('blue-red', page.flip, t), -1), 1025, 1, RGBAFormat);
    ramp.minFilter = ramp.magFilter = LinearFilter; ramp.needsUpdate = true;
    const eight = <T>(f: (i: number) => T): T[] => [0, 1, 2, 3, 4, 5, 6, 7].map(f);
    const isMesh = corners.length > 0;
    this.uniforms = {
      motion: {value: this.motion}, turn: {value: new Matrix3()}, size: {value: 1}, pixels: {value: 1}, shown: {value: eight(() => 1)},
      ramp: {value: ramp}, mode: {value: this.mode}, limit: {value: this.limit}, isPoint: {value: isMesh ? 0 : 1}, grey: {value: c.has('level') ? 1 : 0},
      colours: {value: eight(i => { const s = page.parts[i]?.colour ?? '#888888'; return new Vector3(...[1, 3, 5].map(k => parseInt(s.slice(k, k + 2), 16) / 255)); })},
    };
    const material = new ShaderMaterial({vertexShader: vertex, fragmentShader: fragment, uniforms: this.uniforms, side: DoubleSide});
    if (isMesh) g.setIndex(new BufferAttribute(corners, 1));
    const object = isMesh ? new Mesh(g, material) : new Points(g, material);
    object.frustumCulled = false; this.mark.frustumCulled = false; this.mark.visible = false; this.mark.renderOrder = 2;
    this.scene.add(object, this.mark);
    this.canvas.setAttribute('aria-label', `${page.title}, in three dimensions`);
    this.renderer = new WebGLRenderer({canvas: this.canvas, antialias: true, alpha: true, preserveDrawingBuffer: true});
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.zoomToCursor = true; this.controls.screenSpacePanning = true;
    this.controls.listenToKeyEvents(this.canvas);
    this.root = this.built();
    place.append(this.root);
    this.listen();
    this.tell();
  }

  begin(): void {
    this.resize();
    this.lookFrom(this.page.azimuth, this.page.elevation);
    this.readHash();
    this.setFrame(this.frame);
    this.apply();
  }

  // --- the controls -----------------------------------------------------------------------------------------------

  private button(text: string, f: () => void): HTMLButtonElement { return el('button', {type: 'button', click: f}, text); }
  private group(title: string, open: boolean, ...content: Node[]): HTMLElement {
    return el('details', open ? {open: true} : {}, el('summary', {}, title), el('div', {}, ...content));
  }

  private built(): HTMLElement {
    const stage = el('div', {class: 'v-stage'}, this.canvas, this.tag, el('div', {class: 'v-over v-scale'}, this.scaleText, this.scaleBar));
    const wide = window.innerWidth > 860, groups: HTMLElement[] = [];
    groups.push(this.group(this.c.has('value') ? 'Colours' : 'Parts', true, ...this.colourControls()));
    groups.push(this.group('Point of view', wide, ...this.viewControls()), this.group('Save', false, ...this.saveControls()),
      this.group('Mouse, touch and keys', false, this.help()));
    const below = el('div', {class: 'v-below v-foot-row'});
    below.hidden = this.page.frames.length === 0;
    if (this.page.frames.length > 0) below.append(...this.player());
    below.style.padding = '0'; below.style.borderTop = '0';
    return el('section', {class: 'v', 'aria-label': 'The model, to be turned and read'},
      el('div', {class: 'v-main'}, this.printed, stage, this.reading, below, el('div', {class: 'v-panel', role: 'region', 'aria-label': 'Controls of the view', tabindex: 0}, ...groups)),
      el('p', {class: 'v-foot'}, this.footer()));
  }

  private footer(): string {
    const p = this.page, kept = p.whole ? `The view has all ${fixed(p.nodes, 0)} points.`
      : `The view has ${fixed(p.nodes, 0)} of ${fixed(p.of, 0)} points, ${num(p.spacing, 2)} ${p.unit} apart.`;
    return `${kept} Places are rounded to a millionth of the extent. For the numbers take the tables of this page.`;
  }

  private colourControls(): HTMLElement[] {
    const out: HTMLElement[] = [], p = this.page;
    if (this.c.has('value')) {
      const mode = el('select', {'aria-label': 'What the colours show', change: () => { this.mode = Number(mode.value); this.apply(); }},
        el('option', {value: 1}, `coloured by the ${p.value}`), el('option', {value: -1}, 'shaded only'));
      const ramp = el('canvas', {class: 'v-ramp', width: 280, height: 16, role: 'img', 'aria-label': 'Colours from the lower to the upper limit'}), g = ramp.getContext('2d')!;
      for (let i = 0; i < 280; ++i) { const t = p.signed ? 2 * i / 279 - 1 : i / 279; g.fillStyle = css(colour('blue-red', p.flip, t)); g.fillRect(i, 0, 1, 16); }
      const low = el('span'), high = el('span');
      const input = el('input', {type: 'number', step: 'any', min: 0, 'aria-label': 'Limit of the colours', change: () => {
        const v = Number(input.value);
        if (v > 0 && Number.isFinite(v)) this.limit = v;
        this.apply();
      }});
      this.syncs.push(() => {
        mode.value = String(this.mode);
        if (document.activeElement !== input) input.value = String(Number(this.limit.toPrecision(4)));
        low.textContent = p.signed ? signed(-this.limit, 3) : '0'; high.textContent = `${p.signed ? signed(this.limit, 3) : num(this.limit, 3)} ${p.unit}`;
      });
      out.push(mode, el('div', {}, ramp, el('div', {class: 'v-ends'}, low, high)), el('label', {class: 'v-row'}, 'limit', input, p.unit));
      if (this.c.has('level')) {
        const grey = el('input', {type: 'checkbox', checked: true, change: () => { this.uniforms['grey']!.value = grey.checked ? 1 : 0; this.apply(); }});
        out.push(el('label', {class: 'v-check'}, grey, 'grey within the level of detection'));
      }
      out.push(el('p', {class: 'v-hint'}, 'Beyond the limit the colour stays that of the limit. Brown-grey: no distance there.'));
    }
    if (p.parts.length > 1 || !this.c.has('value'))
      p.parts.forEach((part, i) => {
        const box = el('input', {type: 'checkbox', checked: true, change: () => { this.shown[i] = box.checked; this.apply(); }});
        this.syncs.push(() => { box.checked = this.shown[i]!; });
        const swatch = el('span', {class: 'v-swatch', 'aria-hidden': 'true'});
        swatch.style.background = part.colour;
        out.push(el('label', {class: 'v-check'}, box, swatch, `${part.name}: ${fixed(part.count, 0)} points`));
      });
    return out;
  }

  private viewControls(): HTMLElement[] {
    const full: HTMLButtonElement = this.button('Fill the window', () => {
      full.setAttribute('aria-pressed', String(this.root.classList.toggle('v-full')));
      this.resize();
    });
    full.setAttribute('aria-pressed', 'false');
    const size = el('input', {type: 'range', min: 0.4, max: 2.5, step: 0.05, input: () => { this.size = Number(size.value); this.apply(); }}), said = el('output', {});
    this.syncs.push(() => { size.value = String(this.size); said.textContent = `\u00d7 ${this.size}`; });
    const rows: HTMLElement[] = [el('div', {class: 'v-row'}, this.button('From the front', () => this.lookFrom(0, 0)), this.button('From the left', () => this.lookFrom(-90, 0)),
      this.button('From the right', () => this.lookFrom(90, 0)), this.button('From above', () => this.lookFrom(0, 89.9)), full)];
    if (this.uniforms['isPoint']!.value === 1) rows.push(el('label', {class: 'v-slide'}, 'Size of points', size, said));
    return rows;
  }

  private saveControls(): HTMLElement[] {
    const said = el('span', {class: 'v-hint', role: 'status'});
    return [el('div', {class: 'v-row'}, this.button('Picture (PNG)', () => { this.drawNow(); this.picture().toBlob(b => { if (b) save('view.png', 'image/png', b); }); }),
      this.button('Copy link to this view', async () => { this.writeHash(); said.textContent = await copy(location.href) ? 'copied' : 'the address of this page holds the view'; }), said)];
  }

  private help(): HTMLElement {
    const rows: [string, string][] = [['drag, one finger', 'turn'], ['right button or Shift + drag, two fingers', 'move'], ['wheel, pinch, + and \u2212', 'nearer, farther'],
      ['click, tap, Enter (at the middle)', 'read a point'], ['C', 'copy what was read'], ['1, 2, 3, 4', 'from the front, left, right, above'], ['arrows; with Shift', 'move; turn'], ['Esc', 'clear; leave the full window']];
    if (this.page.frames.length > 0) rows.push(['Space', 'play, pause'], [', and .', 'a frame back, a frame on']);
    return el('div', {id: 'view-help'}, el('table', {}, el('tbody', {}, ...rows.map(([k, v]) => el('tr', {}, el('td', {}, k), el('td', {}, v))))));
  }

  // --- the motion ---------------------------------------------------------------------------------------------------

  private readonly playButton = this.button('Play', () => this.play(!this.playing));

  private player(): HTMLElement[] {
    const frames = this.page.frames, said = el('output', {'aria-live': 'off'});
    const slider = el('input', {type: 'range', min: 0, max: frames.length - 1, step: 1, 'aria-label': 'Frame', input: () => { const frame = Number(slider.value); this.play(false); this.setFrame(frame); }});
    const speed = el('select', {'aria-label': 'Speed', change: () => { this.speed = Number(speed.value); if (this.playing) { this.play(false); this.play(true); } }},
      ...[['0.25', 'quarter speed'], ['0.5', 'half speed'], ['1', 'as recorded'], ['2', 'double speed']].map(([value, text]) => el('option', {value: value!}, text!)));
    speed.value = '1'; speed.style.width = 'auto';
    this.syncs.push(() => {
      slider.value = String(this.frame); slider.setAttribute('aria-valuetext', frames[this.frame]!.label);
      said.textContent = frames[this.frame]!.label; this.playButton.textContent = this.playing ? 'Pause' : 'Play';
    });
    const step = (text: string, label: string, by: number): HTMLElement => { const b = this.button(text, () => this.step(by)); b.setAttribute('aria-label', label); return b; };
    return [el('div', {class: 'v-play'}, this.playButton, el('span', {class: 'v-row'}, step('\u2039', 'A frame back', -1), step('\u203a', 'A frame on', 1)), speed, slider, said)];
  }

  private play(on: boolean): void {
    clearInterval(this.playing);
    this.playing = on && this.page.frames.length > 1 ? window.setInterval(() => this.setFrame((this.frame + 1) % this.page.frames.length), 1000 * this.page.second / this.speed) : 0;
    this.apply();
  }
  private step(by: number): void { this.play(false); const n = this.page.frames.length; this.setFrame((this.frame + by + n) % n); }

  /** The motion in the axes of the view, about the middle of the points: v -> U M U^T v, in doubles. */
  private setFrame(frame: number): void {
    this.frame = Math.min(Math.max(0, frame), Math.max(0, this.page.frames.length - 1));
    const m = this.page.frames[this.frame]?.matrix;
    if (m) {
      const u = this.page.upright, c = this.middle, r: number[] = [];
      for (let i = 0; i < 3; ++i) for (let j = 0; j < 3; ++j) {
        let sum = 0;
        for (let a = 0; a < 3; ++a) for (let b = 0; b < 3; ++b) sum += u[3 * i + a]! * m[4 * a + b]! * u[3 * j + b]!;
        r.push(sum);
      }
      const way = [0, 1, 2].map(a => m[4 * a]! * c[0] + m[4 * a + 1]! * c[1] + m[4 * a + 2]! * c[2] + m[4 * a + 3]! - c[a]!);
      const t = [0, 1, 2].map(i => u[3 * i]! * way[0]! + u[3 * i + 1]! * way[1]! + u[3 * i + 2]! * way[2]!);
      this.motion.set(r[0]!, r[1]!, r[2]!, t[0]!, r[3]!, r[4]!, r[5]!, t[1]!, r[6]!, r[7]!, r[8]!, t[2]!, 0, 0, 0, 1);
      (this.uniforms['turn']!.value as Matrix3).setFromMatrix4(this.motion);
    }
    this.apply();
  }

  private at(i: number): Vector3 {
    const p = new Vector3().fromArray(this.places, 3 * i), blend = this.c.get('blend')?.[i] ?? 0;
    return blend > 0 ? p.clone().lerp(p.clone().applyMatrix4(this.motion), blend) : p;
  }

  // --- what happens -------------------------------------------------------------------------------------------------

  private apply(): void {
    this.uniforms['mode']!.value = this.mode; this.uniforms['limit']!.value = this.limit;
    (this.uniforms['shown']!.value as number[]).forEach((_, i, all) => { all[i] = this.shown[i] === false ? 0 : 1; });
    this.tag.textContent = this.page.frames[this.frame]?.label ?? this.page.title;
    for (const sync of this.syncs) sync();
    this.draw();
  }

  private listen(): void {
    const {canvas} = this;
    let down: {x: number; y: number} | null = null;
    canvas.addEventListener('pointerdown', e => { down = e.isPrimary && e.button === 0 ? {x: e.clientX, y: e.clientY} : null; });
    canvas.addEventListener('pointerup', e => {
      if (!down || Math.hypot(e.clientX - down.x, e.clientY - down.y) > 5) return;
      const box = canvas.getBoundingClientRect();
      this.read(e.clientX - box.left, e.clientY - box.top);
    });
    canvas.addEventListener('keydown', e => this.key(e));
    this.controls.addEventListener('change', () => this.draw());
    new ResizeObserver(() => this.resize()).observe(canvas);
    window.addEventListener('beforeprint', () => { this.drawNow(); this.printed.src = this.picture().toDataURL('image/png'); });
    window.addEventListener('hashchange', () => { if (location.hash !== this.written) { this.readHash(); this.setFrame(this.frame); } });
  }

  private key(e: KeyboardEvent): void {
    if (e.ctrlKey || e.metaKey || e.altKey) return;
    const zoom = (by: number): void => { this.camera.position.sub(this.controls.target).multiplyScalar(by).add(this.controls.target); this.controls.update(); this.draw(); };
    const hasFrames = this.page.frames.length > 0;
    const keys: Record<string, () => void> = {
      '+': () => zoom(0.8), '=': () => zoom(0.8), '-': () => zoom(1.25), Enter: () => this.read(this.canvas.clientWidth / 2, this.canvas.clientHeight / 2),
      c: () => void this.copyReading(), 1: () => this.lookFrom(0, 0), 2: () => this.lookFrom(-90, 0), 3: () => this.lookFrom(90, 0), 4: () => this.lookFrom(0, 89.9),
      Escape: () => { this.last = -1; this.tell(); this.draw(); if (this.root.classList.contains('v-full')) (this.root.querySelector('button[aria-pressed=true]') as HTMLElement | null)?.click(); },
      ...(hasFrames ? {' ': () => this.play(!this.playing), ',': () => this.step(-1), '.': () => this.step(1)} : {}),
    };
    const act = keys[e.key.length === 1 ? e.key.toLowerCase() : e.key];
    if (!act) return;
    e.preventDefault();
    act();
  }

  /** The nearest to the viewer of the points drawn around a pixel. */
  private read(px: number, py: number): void {
    const w = this.canvas.clientWidth, h = this.canvas.clientHeight, part = this.c.get('part'), reach = Math.max(9, this.pointPixels());
    this.camera.updateMatrixWorld();
    let best = -1, nearest = Infinity;
    for (let i = 0; i < this.page.nodes; ++i) {
      if (!this.shown[part?.[i] ?? 0]) continue;
      const p = this.at(i).project(this.camera);
      const off = Math.hypot((p.x + 1) / 2 * w - px, (1 - p.y) / 2 * h - py);
      if (off > reach || p.z > 1) continue;
      const far = this.at(i).distanceTo(this.camera.position) + off * this.pixel();
      if (far < nearest) { nearest = far; best = i; }
    }
    this.last = best;
    this.tell(best < 0 ? 'No point is there.' : '');
    this.draw();
  }

  private tell(words = ''): void {
    const i = this.last, {c, page} = this;
    if (i < 0) { this.reading.replaceChildren(el('i', {class: 'v-tools'}, words || 'Click on the model to read a point.')); return; }
    const digits = Math.min(9, Math.max(0, Math.ceil(-Math.log10(2 * Math.max(...page.columns.slice(0, 3).map(k => k.step)) || 1e-3))));
    const rows: [string, string][] = ['x', 'y', 'z'].map(k => [k, fixed(c.get(k)![i]!, digits)]);
    const value = c.get('value')?.[i], level = c.get('level')?.[i];
    if (value !== undefined) rows.push([page.value, Number.isNaN(value) ? 'none' : `${page.signed ? signed(value) : num(value)} ${page.unit}`]);
    if (level !== undefined && value !== undefined && !Number.isNaN(value))
      rows.push(['level of detection', Number.isNaN(level) ? 'none: too few points' : `\u00b1${num(level, 2)} ${page.unit}: ${Math.abs(value) > level ? 'significant' : 'within it'}`]);
    if (page.parts.length > 1) rows.push(['part', page.parts[c.get('part')?.[i] ?? 0]!.name]);
    const button = this.button('Copy', () => void this.copyReading());
    button.classList.add('v-tools');
    this.reading.replaceChildren(...rows.map(([k, v]) => el('span', {}, el('i', {}, k), el('b', {}, v))), button);
    if (c.has('blend')) this.reading.append(el('i', {}, 'place in the reference frame'));
  }
  private async copyReading(): Promise<void> {
    if (this.last < 0) return;
    const text = [...this.reading.querySelectorAll('b')].map(b => b.textContent).join('\t');
    const done = await copy(text);
    this.reading.querySelector('.v-copied')?.remove();
    this.reading.append(el('i', {class: 'v-copied'}, done ? 'copied' : text));
  }

  /** From the right by the azimuth, from above by the elevation, degrees. */
  private lookFrom(azimuth: number, elevation: number): void {
    const a = azimuth * Math.PI / 180, e = Math.min(elevation, 89.9) * Math.PI / 180, aspect = this.camera.aspect;
    const distance = 0.86 * this.radius / (Math.tan(this.camera.fov * Math.PI / 360) * Math.min(1, aspect));
    this.controls.target.set(0, 0, 0);
    this.camera.position.set(Math.sin(a) * Math.cos(e), Math.sin(e), Math.cos(a) * Math.cos(e)).multiplyScalar(distance);
    this.controls.update();
    this.draw();
  }

  private pixel(): number {
    return 2 * this.camera.position.distanceTo(this.controls.target) * Math.tan(this.camera.fov * Math.PI / 360) / Math.max(1, this.canvas.clientHeight);
  }
  private pointPixels(): number { return this.page.spacing * this.size / this.pixel(); }

  private resize(): void {
    const {clientWidth: w, clientHeight: h} = this.canvas;
    if (!(w > 0 && h > 0)) return;
    this.renderer.setSize(w, h, false);
    this.camera.aspect = w / h;
    this.drawNow();
  }
  private draw(): void {
    if (this.queued) return;
    this.queued = true;
    requestAnimationFrame(() => { this.queued = false; this.drawNow(); });
  }
  private drawNow(): void {
    const size = this.renderer.getDrawingBufferSize(new Vector2()), distance = this.camera.position.length();
    this.camera.far = distance + 3 * this.radius; this.camera.near = Math.max(this.camera.far / 10000, distance - 3 * this.radius);
    this.camera.updateProjectionMatrix();
    this.uniforms['size']!.value = 2 * this.page.spacing * this.size;
    this.uniforms['pixels']!.value = size.y / (2 * Math.tan(this.camera.fov * Math.PI / 360));
    this.mark.visible = this.last >= 0;
    if (this.last >= 0) { const p = this.at(this.last); this.mark.geometry.dispose(); this.mark.geometry = new BufferGeometry().setFromPoints([p]); }
    this.renderer.render(this.scene, this.camera);
    const pixel = this.pixel(), length = nice(140 * pixel);
    this.scaleBar.style.width = `${(length / pixel).toFixed(1)}px`;
    this.scaleText.textContent = `${num(length, 1)} ${this.page.unit} (in the middle)`;
    clearTimeout(this.hashTimer);
    if (!this.playing) this.hashTimer = window.setTimeout(() => this.writeHash(), 300);
  }

  /** The view with its legend. */
  private picture(): HTMLCanvasElement {
    const source = this.renderer.domElement, width = source.width, height = source.height, unit = width / 1000, foot = Math.round(56 * unit);
    const out = el('canvas', {width, height: height + foot}), g = out.getContext('2d')!, p = this.page;
    g.fillStyle = '#fff'; g.fillRect(0, 0, width, height + foot);
    g.drawImage(source, 0, 0);
    g.font = `${13 * unit}px system-ui, sans-serif`;
    let x = 20 * unit;
    const y = height + 14 * unit;
    if (this.mode === 1) {
      for (let i = 0; i < 300; ++i) { g.fillStyle = css(colour('blue-red', p.flip, p.signed ? 2 * i / 299 - 1 : i / 299)); g.fillRect(x + i * unit, y, 1.5 * unit, 14 * unit); }
      g.fillStyle = '#1d2126'; g.fillText(p.signed ? signed(-this.limit, 3) : '0', x, y + 32 * unit);
      g.textAlign = 'right'; g.fillText(`${p.signed ? signed(this.limit, 3) : num(this.limit, 3)} ${p.unit}`, x + 300 * unit, y + 32 * unit); g.textAlign = 'left';
      x += 330 * unit;
    } else if (this.mode === 0)
      for (const [i, part] of p.parts.entries()) {
        if (!this.shown[i]) continue;
        g.fillStyle = part.colour; g.fillRect(x, y + 8 * unit, 12 * unit, 12 * unit);
        g.fillStyle = '#1d2126'; g.fillText(part.name, x + 18 * unit, y + 19 * unit);
        x += 40 * unit + g.measureText(part.name).width;
      }
    g.fillStyle = '#1d2126'; g.fillText(this.tag.textContent ?? '', x, y + 19 * unit, width - x - 10 * unit);
    return out;
  }

  // --- the state in the address --------------------------------------------------------------------------------------

  private written = '';
  private writeHash(): void {
    const p = new URLSearchParams(), short = (v: number): string => String(Number(v.toPrecision(6)));
    p.set('camera', [...this.controls.target.toArray(), ...this.camera.position.toArray()].map(short).join(','));
    if (this.page.frames.length > 0) p.set('frame', String(this.frame));
    if (this.c.has('value')) p.set('limit', short(this.limit));
    if (this.shown.some(s => !s)) p.set('hidden', this.shown.flatMap((s, i) => (s ? [] : [i])).join(','));
    this.written = '#' + p.toString().replaceAll('%2C', ',');
    try { history.replaceState(null, '', this.written); } catch { /* a page within another, or one without an address */ }
  }
  private readHash(): void {
    if (!location.hash.includes('=')) return;
    const p = new URLSearchParams(location.hash.slice(1)), camera = (p.get('camera') ?? '').split(',').map(Number);
    if (camera.length === 6 && camera.every(Number.isFinite)) {
      this.controls.target.fromArray(camera); this.camera.position.fromArray(camera, 3); this.controls.update();
    }
    const frame = Number(p.get('frame') ?? 0), limit = Number(p.get('limit'));
    if (Number.isInteger(frame) && this.page.frames[frame]) this.frame = frame;
    if (limit > 0 && Number.isFinite(limit)) this.limit = limit;
    const hidden = (p.get('hidden') ?? '').split(',');
    this.shown.forEach((_, i) => { this.shown[i] = !hidden.includes(String(i)); });
  }
}
