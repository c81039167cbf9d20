// Colours of d, as report/draw/palette.cpp makes them: white at 0, two hues of equal lightness either side, in OKLab.
// Beside them the spectrum that metrology is used to: green at 0.
type Rgb = [number, number, number];

const stops: [at: number, lightness: number, chroma: number][] = [[0, 1, 0], [0.3, 0.87, 0.06], [0.7, 0.64, 0.125], [1, 0.43, 0.12]];
const hues: Record<string, [first: number, second: number, chroma: number]> = {
  'blue-red': [252, 29, 1], 'purple-orange': [300, 60, 0.75], 'teal-brown': [195, 50, 0.6],
};
const spectrum: Rgb[] = [[0.15, 0.17, 0.62], [0.1, 0.45, 0.85], [0.25, 0.75, 0.85], [0.35, 0.75, 0.4], [0.93, 0.88, 0.3], [0.93, 0.55, 0.15], [0.75, 0.1, 0.1]];

export const paletteNames: [value: string, label: string][] = [
  ['blue-red', 'blue – red'], ['purple-orange', 'purple – orange'], ['teal-brown', 'teal – brown'],
  ['spectrum', 'spectrum (not for the colour-blind)'],
];

const gamma = (v: number): number => {
  const c = Math.min(1, Math.max(0, v));
  return c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055;
};

function oklab(light: number, a: number, b: number): Rgb {
  const l = (light + 0.3963377774 * a + 0.2158037573 * b) ** 3, m = (light - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (light - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [gamma(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
    gamma(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s), gamma(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s)];
}

function diverging(t: number, hue: number, share: number): Rgb {
  let k = 1;
  while (k + 1 < stops.length && stops[k]![0] < t) ++k;
  const from = stops[k - 1]!, to = stops[k]!, s = (t - from[0]) / (to[0] - from[0]);
  const light = from[1] + s * (to[1] - from[1]), chroma = share * (from[2] + s * (to[2] - from[2])), angle = hue * Math.PI / 180;
  return oklab(light, chroma * Math.cos(angle), chroma * Math.sin(angle));
}

/** Colour of t in [-1, 1]: positive t has the first hue unless flipped. The spectrum is red at its upper end. */
export function colour(name: string, flip: boolean, t: number): Rgb {
  const v = Math.min(1, Math.max(-1, t));
  if (name === 'spectrum') {
    const at = (v + 1) / 2 * (spectrum.length - 1), k = Math.min(spectrum.length - 2, Math.floor(at)), s = at - k;
    return [0, 1, 2].map(i => spectrum[k]![i]! * (1 - s) + spectrum[k + 1]![i]! * s) as Rgb;
  }
  const [first, second, share] = hues[name] ?? hues['blue-red']!;
  return diverging(Math.abs(v), (v > 0) !== flip ? first : second, share);
}

/** Heights from low to high: dark to light, one after another for every eye. */
export function heightColour(t: number): Rgb {
  const v = Math.min(1, Math.max(0, t));
  return oklab(0.42 + 0.5 * v, 0.085 * Math.cos(2.7 - 1.6 * v), 0.085 * Math.sin(2.7 - 1.6 * v));
}

export const css = (c: Rgb): string => '#' + c.map(v => Math.round(255 * v).toString(16).padStart(2, '0')).join('');

/** RGBA bytes of a table from -1 to 1 (or 0 to 1). */
export function table(size: number, f: (t: number) => Rgb, low: number): Uint8Array {
  const out = new Uint8Array(4 * size);
  for (let i = 0; i < size; ++i) {
    const c = f(low + (1 - low) * i / (size - 1));
    for (let k = 0; k < 3; ++k) out[4 * i + k] = Math.round(255 * c[k]!);
    out[4 * i + 3] = 255;
  }
  return out;
}
