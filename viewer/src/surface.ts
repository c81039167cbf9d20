// A surface as columns: places, values there, sections and volumes. All in doubles, frame coordinates.
import {type Columns, type Frame, type SceneData, decoded} from './block';

export interface Place { x: number; y: number }
export interface Reading extends Place { za: number; zb: number; d: number; lod: number | null }
/** A stretch of a section within one triangle; s: distance along the line. */
export interface Stretch { from: Reading & {s: number}; to: Reading & {s: number} }
export interface Volumes { above: number; below: number; area: number; polygonArea: number }

export class Surface {
  readonly box = {minX: Infinity, minY: Infinity, maxX: -Infinity, maxY: -Infinity, minZ: Infinity, maxZ: -Infinity};
  private readonly side: number;
  private readonly columns: number;
  private readonly rows: number;
  private readonly starts: Uint32Array;
  private readonly items: Uint32Array;

  static async of(data: SceneData): Promise<Surface> { return new Surface(data, await decoded(data)); }

  private constructor(readonly data: SceneData, readonly c: Columns) {
    const {box} = this;
    for (const v of c.corners) {
      box.minX = Math.min(box.minX, c.x[v]!); box.maxX = Math.max(box.maxX, c.x[v]!);
      box.minY = Math.min(box.minY, c.y[v]!); box.maxY = Math.max(box.maxY, c.y[v]!);
      box.minZ = Math.min(box.minZ, c.z[v]!, c.z[v]! + c.d[v]!); box.maxZ = Math.max(box.maxZ, c.z[v]!, c.z[v]! + c.d[v]!);
    }
    const count = c.corners.length / 3;
    const width = box.maxX - box.minX, height = box.maxY - box.minY;
    this.side = Math.max(Math.sqrt(Math.max(width * height, 1e-300) / Math.max(1, count / 2)), width / 2000, height / 2000, 1e-300);
    this.columns = Math.floor(width / this.side) + 1;
    this.rows = Math.floor(height / this.side) + 1;
    this.starts = new Uint32Array(this.columns * this.rows + 1);
    this.cellsOf(count, cell => { ++this.starts[cell + 1]!; });
    for (let i = 1; i < this.starts.length; ++i) this.starts[i]! += this.starts[i - 1]!;
    this.items = new Uint32Array(this.starts[this.starts.length - 1]!);
    const fill = this.starts.slice();
    this.cellsOf(count, (cell, t) => { this.items[fill[cell]!++] = t; });
  }

  get triangles(): number { return this.c.corners.length / 3; }

  private column(x: number): number { return Math.min(this.columns - 1, Math.max(0, Math.floor((x - this.box.minX) / this.side))); }
  private row(y: number): number { return Math.min(this.rows - 1, Math.max(0, Math.floor((y - this.box.minY) / this.side))); }

  private cellsOf(count: number, f: (cell: number, triangle: number) => void): void {
    const {x, y, corners} = this.c;
    for (let t = 0; t < count; ++t) {
      const [i, j, k] = [corners[3 * t]!, corners[3 * t + 1]!, corners[3 * t + 2]!];
      const c0 = this.column(Math.min(x[i]!, x[j]!, x[k]!)), c1 = this.column(Math.max(x[i]!, x[j]!, x[k]!));
      const r0 = this.row(Math.min(y[i]!, y[j]!, y[k]!)), r1 = this.row(Math.max(y[i]!, y[j]!, y[k]!));
      for (let r = r0; r <= r1; ++r) for (let c = c0; c <= c1; ++c) f(r * this.columns + c, t);
    }
  }

  /** Triangles whose boxes' squares meet a box, each once. */
  private near(minX: number, minY: number, maxX: number, maxY: number): Set<number> {
    const found = new Set<number>();
    for (let r = this.row(minY); r <= this.row(maxY); ++r)
      for (let c = this.column(minX); c <= this.column(maxX); ++c) {
        const cell = r * this.columns + c;
        for (let i = this.starts[cell]!; i < this.starts[cell + 1]!; ++i) found.add(this.items[i]!);
      }
    return found;
  }

  private weights(t: number, x: number, y: number): [number, number, number] | null {
    const {c} = this;
    const [i, j, k] = [c.corners[3 * t]!, c.corners[3 * t + 1]!, c.corners[3 * t + 2]!];
    const ux = c.x[j]! - c.x[i]!, uy = c.y[j]! - c.y[i]!, vx = c.x[k]! - c.x[i]!, vy = c.y[k]! - c.y[i]!;
    const all = ux * vy - uy * vx;
    if (!(all > 0)) return null;
    const px = x - c.x[i]!, py = y - c.y[i]!;
    const b = (px * vy - py * vx) / all, g = (ux * py - uy * px) / all;
    return [1 - b - g, b, g];
  }

  private reading(t: number, x: number, y: number, w: [number, number, number]): Reading {
    const {c} = this;
    const mixed = (column: Float64Array): number =>
      w[0] * column[c.corners[3 * t]!]! + w[1] * column[c.corners[3 * t + 1]!]! + w[2] * column[c.corners[3 * t + 2]!]!;
    const za = mixed(c.z), d = mixed(c.d);
    return {x, y, za, zb: za + d, d, lod: c.lod ? mixed(c.lod) : null};
  }

  /** Both surfaces at a place; null outside of the area compared. */
  at(x: number, y: number): Reading | null {
    const {box} = this;
    if (!(x >= box.minX && x <= box.maxX && y >= box.minY && y <= box.maxY)) return null;
    const cell = this.row(y) * this.columns + this.column(x);
    for (let i = this.starts[cell]!; i < this.starts[cell + 1]!; ++i) {
      const t = this.items[i]!, w = this.weights(t, x, y);
      if (w && Math.min(...w) >= -1e-12) return this.reading(t, x, y, w);
    }
    return null;
  }

  /** Along a polyline: the stretch within each triangle that it crosses, in order. */
  section(line: Place[]): Stretch[] {
    const out: Stretch[] = [];
    let before = 0;
    for (let i = 1; i < line.length; ++i) {
      const a = line[i - 1]!, b = line[i]!, length = Math.hypot(b.x - a.x, b.y - a.y);
      if (!(length > 0)) continue;
      const found: {t: number; low: number; high: number}[] = [];
      for (const t of this.along(a, b)) {
        const range = this.crossing(t, a, b);
        if (range) found.push({t, low: range[0], high: range[1]});
      }
      found.sort((p, q) => p.low + p.high - q.low - q.high || p.t - q.t);
      let reached = 0;  // a line along an edge is in both triangles there
      for (const {t, low, high} of found) {
        const from = Math.max(low, reached);
        if (!(high - from > 1e-12)) continue;
        const end = (at: number): Reading & {s: number} => {
          const x = a.x + at * (b.x - a.x), y = a.y + at * (b.y - a.y);
          return {...this.reading(t, x, y, this.weights(t, x, y)!), s: before + at * length};
        };
        out.push({from: end(from), to: end(high)});
        reached = high;
      }
      before += length;
    }
    return out;
  }

  private along(a: Place, b: Place): Set<number> {
    const steps = Math.max(1, Math.ceil(Math.max(Math.abs(b.x - a.x), Math.abs(b.y - a.y)) / (4 * this.side)));
    const found = new Set<number>();
    for (let k = 0; k < steps; ++k) {
      const [p, q] = [k / steps, (k + 1) / steps];
      const [x0, x1] = [a.x + p * (b.x - a.x), a.x + q * (b.x - a.x)], [y0, y1] = [a.y + p * (b.y - a.y), a.y + q * (b.y - a.y)];
      for (const t of this.near(Math.min(x0, x1), Math.min(y0, y1), Math.max(x0, x1), Math.max(y0, y1))) found.add(t);
    }
    return found;
  }

  private crossing(t: number, a: Place, b: Place): [number, number] | null {
    const p = this.weights(t, a.x, a.y), q = this.weights(t, b.x, b.y);
    if (!p || !q) return null;
    let low = 0, high = 1;
    for (let k = 0; k < 3; ++k) {
      const from = p[k]!, change = q[k]! - p[k]!;
      if (change === 0) { if (from < 0) return null; continue; }
      const at = -from / change;
      if (change > 0) low = Math.max(low, at); else high = Math.min(high, at);
    }
    return high > low ? [low, high] : null;
  }

  /** Between the surfaces over a simple polygon, by the closed form on every piece of a triangle in it. */
  volumes(polygon: Place[]): Volumes {
    const {c} = this;
    const out: Volumes = {above: 0, below: 0, area: 0, polygonArea: 0};
    for (const ear of ears(polygon)) {
      out.polygonArea += area2(ear[0]!, ear[1]!, ear[2]!) / 2;
      const xs = ear.map(p => p.x), ys = ear.map(p => p.y);
      for (const t of this.near(Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys))) {
        let piece = [0, 1, 2].map(k => { const v = c.corners[3 * t + k]!; return {x: c.x[v]!, y: c.y[v]!, d: c.d[v]!}; });
        for (let k = 0; k < 3 && piece.length > 2; ++k) piece = clipped(piece, ear[k]!, ear[(k + 1) % 3]!);
        for (let k = 2; k < piece.length; ++k) {
          const [p, q, r] = [piece[0]!, piece[k - 1]!, piece[k]!];
          const area = area2(p, q, r) / 2, [above, below] = split(area, p.d, q.d, r.d);
          out.area += area; out.above += above; out.below += below;
        }
      }
    }
    return out;
  }

  /** Areas by d in equal bins from low to high; the outermost also hold what lies beyond. */
  histogram(low: number, high: number, bins: number): Float64Array {
    const {c} = this, out = new Float64Array(bins);
    const add = (d: number, area: number): void => {
      out[Math.min(bins - 1, Math.max(0, Math.floor((d - low) / (high - low) * bins)))]! += area;
    };
    for (let t = 0; t < this.triangles; ++t) {
      const [i, j, k] = [c.corners[3 * t]!, c.corners[3 * t + 1]!, c.corners[3 * t + 2]!];
      const area = ((c.x[j]! - c.x[i]!) * (c.y[k]! - c.y[i]!) - (c.y[j]! - c.y[i]!) * (c.x[k]! - c.x[i]!)) / 8;
      const [p, q, r] = [c.d[i]!, c.d[j]!, c.d[k]!];
      add((p + q + r) / 3, area); add((4 * p + q + r) / 6, area); add((p + 4 * q + r) / 6, area); add((p + q + 4 * r) / 6, area);
    }
    return out;
  }

  /** Nodes of the largest d of one sign, none within `apart` of a larger one, all beyond the level of detection. */
  extremes(sign: 1 | -1, count: number, apart: number): number[] {
    const {c} = this, used = new Uint8Array(c.x.length);
    for (const v of c.corners) used[v] = 1;
    const best: number[] = [];
    for (let n = 0; n < count; ++n) {
      let found = -1;
      for (let i = 0; i < c.x.length; ++i) {
        if (!used[i] || sign * c.d[i]! <= (c.lod ? c.lod[i]! : 0) || (found >= 0 && sign * c.d[i]! <= sign * c.d[found]!)) continue;
        if (best.every(j => Math.hypot(c.x[i]! - c.x[j]!, c.y[i]! - c.y[j]!) >= apart)) found = i;
      }
      if (found < 0) break;
      best.push(found);
    }
    return best;
  }

  get lodLargest(): number { return this.c.lod ? this.c.lod.reduce((m, v) => Math.max(m, v), 0) : 0; }
  get dLargest(): number { return this.c.corners.reduce((m, v) => Math.max(m, Math.abs(this.c.d[v]!)), 0); }
}

const area2 = (p: Place, q: Place, r: Place): number => (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);

/** What of a convex piece lies left of a line. */
function clipped<T extends Place & {d: number}>(piece: T[], a: Place, b: Place): {x: number; y: number; d: number}[] {
  const out: {x: number; y: number; d: number}[] = [];
  for (let i = 0; i < piece.length; ++i) {
    const p = piece[i]!, q = piece[(i + 1) % piece.length]!, sp = area2(a, b, p), sq = area2(a, b, q);
    if (sp >= 0) out.push(p);
    if ((sp < 0 && sq > 0) || (sp > 0 && sq < 0)) {
      const t = sp / (sp - sq);
      out.push({x: p.x + t * (q.x - p.x), y: p.y + t * (q.y - p.y), d: p.d + t * (q.d - p.d)});
    }
  }
  return out;
}

/** The integrals of max(d, 0) and max(-d, 0) over a triangle with d linear. */
export function split(area: number, a: number, b: number, c: number): [number, number] {
  const whole = area * (a + b + c) / 3;
  if (a >= 0 && b >= 0 && c >= 0) return [whole, 0];
  if (a <= 0 && b <= 0 && c <= 0) return [0, -whole];
  const positive = (a > 0 ? 1 : 0) + (b > 0 ? 1 : 0) + (c > 0 ? 1 : 0);
  // The corner that is alone on its side, and the others.
  const alone = positive === 1 ? Math.max(a, b, c) : Math.min(a, b, c);
  const [p, q] = alone === a ? [b, c] : alone === b ? [a, c] : [a, b];
  const tip = area * (alone / (alone - p)) * (alone / (alone - q)) * Math.abs(alone) / 3;
  return positive === 1 ? [tip, tip - whole] : [whole + tip, tip];
}

/** Whether no two sides of a closed line cross. */
export function isSimple(polygon: Place[]): boolean {
  const n = polygon.length;
  for (let i = 0; i < n; ++i)
    for (let j = i + 2; j < n; ++j) {
      if (i === 0 && j === n - 1) continue;
      const [a, b, c, d] = [polygon[i]!, polygon[(i + 1) % n]!, polygon[j]!, polygon[(j + 1) % n]!];
      if (area2(a, b, c) * area2(a, b, d) <= 0 && area2(c, d, a) * area2(c, d, b) <= 0) return false;
    }
  return n >= 3;
}

/** A simple polygon as counter-clockwise triangles. */
export function ears(polygon: Place[]): Place[][] {
  let signed = 0;
  for (let i = 0; i < polygon.length; ++i) {
    const p = polygon[i]!, q = polygon[(i + 1) % polygon.length]!;
    signed += (p.x - polygon[0]!.x) * (q.y - polygon[0]!.y) - (p.y - polygon[0]!.y) * (q.x - polygon[0]!.x);
  }
  const rest = signed < 0 ? [...polygon].reverse() : [...polygon];
  const out: Place[][] = [];
  while (rest.length > 3) {
    const n = rest.length;
    const i = rest.findIndex((q, k) => {
      const p = rest[(k + n - 1) % n]!, r = rest[(k + 1) % n]!;
      if (area2(p, q, r) <= 0) return false;
      return rest.every(s => s === p || s === q || s === r ||
        !(area2(p, q, s) >= 0 && area2(q, r, s) >= 0 && area2(r, p, s) >= 0));
    });
    const k = i >= 0 ? i : 0;
    const ear = [rest[(k + n - 1) % n]!, rest[k]!, rest[(k + 1) % n]!];
    if (area2(ear[0]!, ear[1]!, ear[2]!) > 0) out.push(ear);
    rest.splice(k, 1);
  }
  if (rest.length === 3 && area2(rest[0]!, rest[1]!, rest[2]!) > 0) out.push(rest);
  return out;
}

/** Frame coordinates to those of the input, and back. */
export function toInput(f: Frame, x: number, y: number, z: number): [number, number, number] {
  const r = f.rotation;
  return [0, 1, 2].map(k => f.origin[k]! + (r[k]! * x + r[3 + k]! * y + r[6 + k]! * z)) as [number, number, number];
}
export function toFrame(f: Frame, p: readonly number[]): [number, number, number] {
  const r = f.rotation, [a, b, c] = [p[0]! - f.origin[0], p[1]! - f.origin[1], p[2]! - f.origin[2]];
  return [0, 1, 2].map(k => r[3 * k]! * a + r[3 * k + 1]! * b + r[3 * k + 2]! * c) as [number, number, number];
}
