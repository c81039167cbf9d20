// What is drawn: surfaces A and B of a scene, coloured by d, with marks and a line on them.
import {
  BufferAttribute, BufferGeometry, Color, DataTexture, DoubleSide, Group, Line, LineBasicMaterial, LinearFilter, Mesh,
  OrthographicCamera, PerspectiveCamera, Points, PointsMaterial, Ray, Raycaster, RGBAFormat, Scene, ShaderMaterial, Vector2,
  Vector3, Vector4, WebGLRenderer,
} from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import {MeshBVH} from 'three-mesh-bvh';
import {table} from './palette';
import {type Place, type Surface, toFrame, toInput} from './surface';

const vertex = `
attribute float other; attribute float difference; attribute float level; attribute vec2 slopeA; attribute vec2 slopeB;
uniform float side, exaggeration;
varying float vD, vLevel, vZ; varying vec3 vNormal2; varying vec2 vXy;
void main() {
  vec2 slope = side < 0.5 ? slopeA : slopeB;
  vZ = side < 0.5 ? position.z : other;
  vD = difference; vLevel = level; vXy = position.xy;
  vNormal2 = vec3(-slope * exaggeration, 1.0);
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position.xy, vZ * exaggeration, 1.0);
}`;
const fragment = `
uniform sampler2D ramp; uniform sampler2D heights; uniform vec3 light; uniform vec4 clip; uniform vec2 limits, range;
uniform float mode, grey, hatch, cut, keepLeft;
varying float vD, vLevel, vZ; varying vec3 vNormal2; varying vec2 vXy;
void main() {
  if (keepLeft > 0.5 ? gl_FragCoord.x > cut : (keepLeft < -0.5 && gl_FragCoord.x <= cut)) discard;
  if (vXy.x < clip.x || vXy.y < clip.y || vXy.x > clip.z || vXy.y > clip.w) discard;
  vec3 n = normalize(vNormal2);
  vec3 colour = vec3(0.80, 0.79, 0.77);
  if (mode < 0.5) {
    float t = vD > 0.0 ? vD / limits.y : vD / -limits.x;
    colour = texture2D(ramp, vec2(0.5 + 0.4990234 * clamp(t, -1.0, 1.0), 0.5)).rgb;
    if (grey > 0.5 && abs(vD) <= vLevel) colour = vec3(0.77);
    else if (hatch > 0.5 && abs(t) > 1.0 && mod(gl_FragCoord.x + gl_FragCoord.y, 9.0) < 2.0) colour *= 0.45;
  } else if (mode < 1.5) {
    colour = texture2D(heights, vec2(clamp((vZ - range.x) / max(range.y - range.x, 1e-30), 0.0, 1.0), 0.5)).rgb;
  }
  float shade = min(1.0, 0.54 + 0.53 * max(0.0, dot(n, light)));
  if (!gl_FrontFacing) shade *= 0.6;
  gl_FragColor = vec4(colour * shade, 1.0);
}`;

export type Show = 'a' | 'b' | 'both';
export type Mode = 'difference' | 'height' | 'plain';

export interface Look {
  show: Show; mode: Mode; swipe: number; low: number; high: number; palette: (t: number) => [number, number, number];
  grey: boolean; hatch: boolean; exaggeration: number; light: number; clip: [number, number, number, number];
}

/** Slopes of heights at nodes: the mean of those of the triangles around, by area. */
function slopes(s: Surface, height: (v: number) => number): Float32Array {
  const {x, y, corners} = s.c, out = new Float32Array(2 * x.length), area = new Float64Array(x.length);
  const sum = new Float64Array(2 * x.length);
  for (let t = 0; t < corners.length; t += 3) {
    const [i, j, k] = [corners[t]!, corners[t + 1]!, corners[t + 2]!];
    const ux = x[j]! - x[i]!, uy = y[j]! - y[i]!, vx = x[k]! - x[i]!, vy = y[k]! - y[i]!, a = ux * vy - uy * vx;
    if (!(a > 0)) continue;
    const p = height(j) - height(i), q = height(k) - height(i), gx = p * vy - q * uy, gy = q * ux - p * vx;
    for (const v of [i, j, k]) { sum[2 * v]! += gx; sum[2 * v + 1]! += gy; area[v]! += a; }
  }
  for (let v = 0; v < x.length; ++v)
    if (area[v]! > 0) { out[2 * v] = sum[2 * v]! / area[v]!; out[2 * v + 1] = sum[2 * v + 1]! / area[v]!; }
  return out;
}

/** One surface pair as meshes. Positions are relative to the middle of the first scene, so that floats hold them. */
class Pair {
  readonly group = new Group();
  readonly offset: Vector3;  // of this scene's frame in the world
  private readonly geometry = new BufferGeometry();
  private readonly materials: ShaderMaterial[] = [];
  private readonly meshes: Mesh[] = [];
  private readonly trees: (MeshBVH | null)[] = [null, null];

  constructor(readonly surface: Surface, middle: Vector3, shift: Vector3, uniforms: Record<string, {value: unknown}>) {
    const {x, y, z, d, lod, corners} = surface.c, n = x.length;
    this.offset = shift.clone().sub(middle);
    const position = new Float32Array(3 * n), other = new Float32Array(n);
    for (let i = 0; i < n; ++i) {
      position[3 * i] = x[i]! + this.offset.x; position[3 * i + 1] = y[i]! + this.offset.y; position[3 * i + 2] = z[i]! + this.offset.z;
      other[i] = z[i]! + d[i]! + this.offset.z;
    }
    const g = this.geometry;
    g.setAttribute('position', new BufferAttribute(position, 3));
    g.setAttribute('other', new BufferAttribute(other, 1));
    g.setAttribute('difference', new BufferAttribute(Float32Array.from(d), 1));
    g.setAttribute('level', new BufferAttribute(lod ? Float32Array.from(lod) : new Float32Array(n).fill(-1), 1));
    g.setAttribute('slopeA', new BufferAttribute(slopes(surface, v => z[v]!), 2));
    g.setAttribute('slopeB', new BufferAttribute(slopes(surface, v => z[v]! + d[v]!), 2));
    g.setIndex(new BufferAttribute(corners, 1));
    for (const side of [0, 1]) {
      const material = new ShaderMaterial({vertexShader: vertex, fragmentShader: fragment, side: DoubleSide,
        uniforms: {...uniforms, side: {value: side}, keepLeft: {value: 0}}});
      const mesh = new Mesh(g, material);
      mesh.frustumCulled = false;
      this.materials.push(material); this.meshes.push(mesh); this.group.add(mesh);
    }
  }

  show(show: Show): void {
    this.meshes[0]!.visible = show !== 'b'; this.meshes[1]!.visible = show !== 'a';
    this.materials[0]!.uniforms['keepLeft']!.value = show === 'both' ? 1 : 0;
    this.materials[1]!.uniforms['keepLeft']!.value = show === 'both' ? -1 : 0;
  }

  tree(side: 0 | 1): MeshBVH {
    let tree = this.trees[side];
    if (!tree) {
      const g = new BufferGeometry(), from = this.geometry.getAttribute('position') as BufferAttribute;
      const position = Float32Array.from(from.array as Float32Array);
      const other = this.geometry.getAttribute('other').array as Float32Array;
      if (side === 1) for (let i = 0; i < other.length; ++i) position[3 * i + 2] = other[i]!;
      g.setAttribute('position', new BufferAttribute(position, 3));
      g.setIndex(new BufferAttribute(this.surface.c.corners.slice(), 1));
      this.trees[side] = tree = new MeshBVH(g);
    }
    return tree;
  }
}

const ramp = (bytes: Uint8Array): DataTexture => {
  const texture = new DataTexture(bytes, bytes.length / 4, 1, RGBAFormat);
  texture.minFilter = texture.magFilter = LinearFilter;
  texture.needsUpdate = true;
  return texture;
};

export class Stage {
  readonly renderer: WebGLRenderer;
  readonly controls: OrbitControls;
  onFrame: () => void = () => undefined;
  private readonly scene = new Scene();
  private readonly perspective = new PerspectiveCamera(35, 1, 1, 1000);
  private readonly parallel = new OrthographicCamera(-1, 1, 1, -1, 1, 1000);
  private readonly pairs: Pair[] = [];
  private readonly uniforms: Record<string, {value: unknown}>;
  private readonly line = new Line(new BufferGeometry(), new LineBasicMaterial({depthTest: false, transparent: true}));
  private readonly marks: Points;
  private readonly middle: Vector3;
  readonly radius: number;
  private current = 0;
  private queued = false;
  private begun = false;
  private isParallel = false;

  constructor(readonly canvas: HTMLCanvasElement, readonly surfaces: Surface[], private look: Look, heightTable: Uint8Array) {
    this.renderer = new WebGLRenderer({canvas, antialias: true, alpha: true, preserveDrawingBuffer: true});
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    const b = surfaces[0]!.box;
    this.middle = new Vector3((b.minX + b.maxX) / 2, (b.minY + b.maxY) / 2, (b.minZ + b.maxZ) / 2);
    this.radius = Math.hypot(b.maxX - b.minX, b.maxY - b.minY, b.maxZ - b.minZ) / 2 || 1;
    this.uniforms = {
      ramp: {value: null}, heights: {value: ramp(heightTable)}, light: {value: new Vector3()}, clip: {value: new Vector4()},
      limits: {value: new Vector2()}, mode: {value: 0}, grey: {value: 0}, hatch: {value: 0}, cut: {value: 0},
      exaggeration: {value: 1}, range: {value: new Vector2(b.minZ - this.middle.z, b.maxZ - this.middle.z)},
    };
    for (const s of surfaces) {
      // Frames of one rotation share a world; others stand in their own.
      const f = surfaces[0]!.data.frame, g = s.data.frame;
      const isSame = f.rotation.every((v, i) => v === g.rotation[i]);
      const shift = isSame ? new Vector3(...toFrame(f, g.origin)) : new Vector3();
      const pair = new Pair(s, this.middle, shift, this.uniforms);
      this.pairs.push(pair); this.scene.add(pair.group);
    }
    this.line.renderOrder = 2; this.line.frustumCulled = false; this.line.visible = false;
    this.marks = new Points(new BufferGeometry(), new PointsMaterial({size: 11, sizeAttenuation: false, depthTest: false, transparent: true}));
    this.marks.renderOrder = 3; this.marks.frustumCulled = false; this.marks.visible = false;
    this.scene.add(this.line, this.marks);
    for (const camera of [this.perspective, this.parallel]) camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.perspective, canvas);
    this.controls.zoomToCursor = true;
    this.controls.screenSpacePanning = true;
    this.controls.listenToKeyEvents(canvas);
    this.controls.addEventListener('change', () => this.draw());
    this.setLook(look);
    this.setScene(0);
  }

  get camera(): PerspectiveCamera | OrthographicCamera { return this.isParallel ? this.parallel : this.perspective; }
  get orthographic(): boolean { return this.isParallel; }
  get surface(): Surface { return this.pairs[this.current]!.surface; }
  get sceneIndex(): number { return this.current; }

  setScene(index: number): void {
    this.current = index;
    this.pairs.forEach((p, i) => { p.group.visible = i === index; });
    this.pairs[index]!.show(this.look.show);
    this.draw();
  }

  setLook(look: Look): void {
    const isNewPalette = look.palette !== this.look.palette || this.uniforms['ramp']!.value === null;
    const oldExaggeration = this.uniforms['exaggeration']!.value as number;
    this.look = look;
    const u = this.uniforms;
    if (isNewPalette) {
      (u['ramp']!.value as DataTexture | null)?.dispose();
      u['ramp']!.value = ramp(table(1025, look.palette, -1));
    }
    (u['limits']!.value as Vector2).set(look.low, look.high);
    u['mode']!.value = look.mode === 'difference' ? 0 : look.mode === 'height' ? 1 : 2;
    u['grey']!.value = look.grey ? 1 : 0; u['hatch']!.value = look.hatch ? 1 : 0;
    u['exaggeration']!.value = look.exaggeration;
    const azimuth = look.light * Math.PI / 180, height = Math.PI / 4;
    (u['light']!.value as Vector3).set(Math.sin(azimuth) * Math.cos(height), Math.cos(azimuth) * Math.cos(height), Math.sin(height));
    const [x0, y0, x1, y1] = look.clip, b = this.surfaces[0]!.box, w = b.maxX - b.minX, h = b.maxY - b.minY;
    // Nothing is cut off where a slider stands at its end: scenes may reach beyond the first one.
    (u['clip']!.value as Vector4).set(
      x0 > 0 ? b.minX + x0 * w - this.middle.x : -1e30, y0 > 0 ? b.minY + y0 * h - this.middle.y : -1e30,
      x1 < 1 ? b.minX + x1 * w - this.middle.x : 1e30, y1 < 1 ? b.minY + y1 * h - this.middle.y : 1e30);
    this.pairs[this.current]?.show(look.show);
    if (look.exaggeration !== oldExaggeration) { this.controls.target.z *= look.exaggeration / oldExaggeration; this.scaleLine(); this.controls.update(); }
    this.draw();
  }

  resize(width: number, height: number): void {
    this.renderer.setSize(width, height, false);
    this.perspective.aspect = width / height;
    this.drawNow();
  }

  draw(): void {
    if (this.queued || !this.begun) return;
    this.queued = true;
    requestAnimationFrame(() => { this.queued = false; this.drawNow(); });
  }

  drawNow(): void {
    const size = this.renderer.getSize(new Vector2());
    if (!this.begun || !(size.x > 0 && size.y > 0)) return;
    const distance = this.camera.position.distanceTo(this.controls.target);
    const reach = this.radius * Math.max(1, this.look.exaggeration);
    if (this.isParallel) {
      const half = this.halfHeight();
      this.parallel.top = half; this.parallel.bottom = -half;
      this.parallel.left = -half * size.x / size.y; this.parallel.right = half * size.x / size.y;
      this.parallel.near = distance - 4 * reach - 4 * this.camera.position.length(); this.parallel.far = distance + 4 * reach + 4 * this.camera.position.length();
    } else {
      const far = this.camera.position.length() + 2 * reach;
      this.perspective.far = far; this.perspective.near = Math.max(far / 20000, distance / 200);
    }
    this.camera.updateProjectionMatrix();
    this.uniforms['cut']!.value = this.look.swipe * this.renderer.domElement.width;
    this.renderer.render(this.scene, this.camera);
    this.onFrame();
  }

  /** Nothing is drawn before: a frame of a large surface is not wasted on a state that is being set up. */
  begin(): void { this.begun = true; this.draw(); }

  private baseHalf = 1;
  private halfHeight(): number { return this.baseHalf; }

  setParallel(on: boolean): void {
    if (on === this.isParallel) return;
    const tangent = Math.tan(this.perspective.fov * Math.PI / 360), target = this.controls.target;
    const direction = this.camera.position.clone().sub(target);
    if (on) {
      this.baseHalf = direction.length() * tangent;
      this.parallel.zoom = 1;
      this.parallel.position.copy(this.perspective.position);
    } else {
      direction.setLength(this.baseHalf / this.parallel.zoom / tangent);
      this.perspective.position.copy(target).add(direction);
    }
    this.isParallel = on;
    this.controls.object = this.camera;
    this.controls.update();
    this.draw();
  }

  /** Looks from an azimuth (degrees clockwise from north) and a height, at everything or at what lies around a place. */
  lookFrom(azimuth: number, elevation: number, at = new Vector3(), radius = this.radius): void {
    const size = this.renderer.getSize(new Vector2()), aspect = size.x / Math.max(1, size.y);
    const tangent = Math.tan(this.perspective.fov * Math.PI / 360), fit = elevation > 89 ? 0.82 : 0.87;
    const distance = fit * radius / (tangent * Math.min(1, aspect / 1.25));
    const a = azimuth * Math.PI / 180, e = Math.min(elevation, 89.999) * Math.PI / 180;
    const direction = new Vector3(Math.sin(a) * Math.cos(e), Math.cos(a) * Math.cos(e), Math.sin(e));
    this.controls.target.copy(at);
    this.camera.position.copy(at).addScaledVector(direction, distance);
    if (this.isParallel) { this.baseHalf = distance * tangent; this.parallel.zoom = 1; }
    this.controls.update();
    this.draw();
  }

  flyTo(place: Place, z: number, radius: number): void {
    const p = this.world(place.x, place.y, z);
    const direction = this.camera.position.clone().sub(this.controls.target);
    const elevation = Math.asin(Math.min(1, direction.z / (direction.length() || 1))) * 180 / Math.PI;
    this.lookFrom(this.azimuth, Math.max(25, elevation), p, radius);
  }

  /** Azimuth of the camera seen from the target, degrees clockwise from north; up on the screen is the other way. */
  get azimuth(): number {
    // The camera's right is level; seen from above it is a quarter turn clockwise of where the camera looks.
    const right = new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0);
    return (Math.atan2(right.x, right.y) * 180 / Math.PI + 90 + 360) % 360;
  }

  /** Length in the world of a pixel at the target. */
  get pixel(): number {
    const size = this.renderer.getSize(new Vector2());
    if (this.isParallel) return 2 * this.baseHalf / this.parallel.zoom / size.y;
    return 2 * this.camera.position.distanceTo(this.controls.target) * Math.tan(this.perspective.fov * Math.PI / 360) / size.y;
  }

  world(x: number, y: number, z: number): Vector3 {
    const o = this.pairs[this.current]!.offset;
    return new Vector3(x + o.x, y + o.y, (z + o.z) * this.look.exaggeration);
  }

  /** Frame coordinates of the surface under a point of the canvas, in pixels from its upper left corner. */
  pick(px: number, py: number): Place | null {
    const size = this.renderer.getSize(new Vector2()), caster = new Raycaster();
    this.camera.updateMatrixWorld();
    caster.setFromCamera(new Vector2(2 * px / size.x - 1, 1 - 2 * py / size.y), this.camera);
    const e = this.look.exaggeration, ray = new Ray(caster.ray.origin.clone(), caster.ray.direction.clone());
    if (this.isParallel) ray.origin.addScaledVector(ray.direction, -8 * this.radius * Math.max(1, e));
    ray.origin.z /= e; ray.direction.z /= e;
    const pair = this.pairs[this.current]!, clip = this.uniforms['clip']!.value as Vector4;
    const side = this.look.show === 'a' || (this.look.show === 'both' && px / size.x <= this.look.swipe) ? 0 : 1;
    const hits = pair.tree(side).raycast(ray, DoubleSide).filter(h =>
      h.point.x >= clip.x && h.point.y >= clip.y && h.point.x <= clip.z && h.point.y <= clip.w);
    if (hits.length === 0) return null;
    const hit = hits.reduce((p, q) => (q.distance < p.distance ? q : p));
    return {x: hit.point.x - pair.offset.x, y: hit.point.y - pair.offset.y};
  }

  private linePoints: [number, number, number][] = [];
  private markPoints: [number, number, number][] = [];

  /** A line on the surface and points along it, frame coordinates. */
  setLine(points: [number, number, number][], marks: [number, number, number][], colour: string): void {
    this.linePoints = points; this.markPoints = marks;
    (this.line.material as LineBasicMaterial).color = new Color(colour);
    (this.marks.material as PointsMaterial).color = new Color(colour);
    this.scaleLine();
    this.draw();
  }

  private scaleLine(): void {
    const put = (object: Line | Points, points: [number, number, number][]): void => {
      object.geometry.dispose();
      object.geometry = new BufferGeometry().setFromPoints(points.map(p => this.world(...p)));
      object.visible = points.length > 0;
    };
    put(this.line, this.linePoints); put(this.marks, this.markPoints);
  }

  /** The camera as eight numbers: target and position in input coordinates, height of the view, kind. */
  get state(): number[] {
    const f = this.surfaces[0]!.data.frame, e = this.look.exaggeration, m = this.middle;
    const put = (v: Vector3): number[] => toInput(f, v.x + m.x, v.y + m.y, v.z / e + m.z);
    return [...put(this.controls.target), ...put(this.camera.position), this.isParallel ? this.baseHalf / this.parallel.zoom : 0];
  }
  set state(s: number[]) {
    const f = this.surfaces[0]!.data.frame, e = this.look.exaggeration, m = this.middle;
    const get = (i: number): Vector3 => {
      const p = toFrame(f, s.slice(i, i + 3));
      return new Vector3(p[0] - m.x, p[1] - m.y, (p[2] - m.z) * e);
    };
    this.setParallel(s[6]! > 0);
    if (s[6]! > 0) { this.baseHalf = s[6]!; this.parallel.zoom = 1; }
    this.controls.target.copy(get(0)); this.camera.position.copy(get(3));
    this.controls.update();
    this.draw();
  }
}
