// What a page carries of surfaces: see src/isopach/report/view/view.cpp and block.cpp, which write it.

export interface Numbers { low: number; step: number }
export interface Totals { area: number; above: number; below: number }
export interface Frame { origin: [number, number, number]; rotation: number[] }
export interface BudgetRow { name: string; net: number; box: [number, number, number, number] }

export interface SceneData {
  label: string; frame: Frame; nodes: number; triangles: number; of: number; whole: boolean;
  x: Numbers; y: Numbers; z: Numbers; d: Numbers; lod: Numbers | null;
  error: {d: number; rms: number; z: number}; thinned: Totals; exact: Totals;
  a: {name: string; path: string}; b: {name: string; path: string};
  budget: BudgetRow[]; changes: BudgetRow[]; data: string;
}

export interface PageData {
  version: number; title: string; drawn?: string; unit: string; heightUnit: string; areaUnit: string; volumeUnit: string;
  crs: string; north: boolean; vertical: boolean; places: boolean; limit: number; palette: string; flip: boolean;
  words: {a: string; b: string; above: string; below: string}; command: string; scenes: SceneData[];
}

/** Columns of a surface, frame coordinates. */
export interface Columns {
  x: Float64Array; y: Float64Array; z: Float64Array; d: Float64Array; lod: Float64Array | null;
  corners: Uint32Array;
}

async function inflated(text: string): Promise<Uint8Array> {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) bytes[i] = raw.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

const unfolded = (n: number): number => (n & 1 ? -(n + 1) / 2 : n / 2);

class Reader {
  private at = 0;
  constructor(private readonly bytes: Uint8Array) {}

  /** Byte planes, the lowest first. */
  planes(count: number): Float64Array {
    const out = new Float64Array(count);
    for (let plane = 0, weight = 1; plane < 4; ++plane, weight *= 256)
      for (let i = 0; i < count; ++i) out[i]! += weight * this.bytes[this.at++]!;
    return out;
  }

  column(count: number, numbers: Numbers): Float64Array {
    if (!(numbers.step > 0)) { this.at += 4 * count; return new Float64Array(count).fill(numbers.low); }
    const out = this.planes(count);
    for (let i = 0, last = 0; i < count; ++i) {
      last += unfolded(out[i]!);
      out[i] = numbers.low + numbers.step * last;
    }
    return out;
  }

  corners(count: number): Uint32Array {
    const first = this.planes(count), second = this.planes(count), third = this.planes(count);
    const out = new Uint32Array(3 * count);
    for (let i = 0, last = 0; i < count; ++i) {
      last += unfolded(first[i]!);
      out[3 * i] = last;
      out[3 * i + 1] = last + unfolded(second[i]!);
      out[3 * i + 2] = last + unfolded(third[i]!);
    }
    return out;
  }
}

export interface SpaceData {
  kind: 'space'; title: string; unit: string; of: number; nodes: number; whole: boolean; spacing: number; upright: number[];
  azimuth: number; elevation: number; second: number; value: string; signed: boolean; limit: number; flip: boolean;
  parts: {name: string; colour: string; count: number}[]; frames: {label: string; matrix: number[]}[];
  columns: (Numbers & {name: string})[]; triangles: number; data: string;
}

/** Columns by name, and corners of triangles. */
export async function decodedSpace(page: SpaceData): Promise<{columns: Map<string, Float64Array>; corners: Uint32Array}> {
  const reader = new Reader(await inflated(page.data)), columns = new Map<string, Float64Array>();
  for (const c of page.columns) columns.set(c.name, reader.column(page.nodes, c));
  for (const c of page.columns)  // the least number of these stands for a value that is missing
    if (c.name === 'value' || c.name === 'level') columns.set(c.name, columns.get(c.name)!.map(v => (v === c.low ? NaN : v)));
  return {columns, corners: reader.corners(page.triangles)};
}

export async function decoded(scene: SceneData): Promise<Columns> {
  const reader = new Reader(await inflated(scene.data));
  const n = scene.nodes;
  return {
    x: reader.column(n, scene.x), y: reader.column(n, scene.y), z: reader.column(n, scene.z),
    d: reader.column(n, scene.d), lod: scene.lod ? reader.column(n, scene.lod) : null,
    corners: reader.corners(scene.triangles),
  };
}
