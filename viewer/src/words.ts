// Numbers as the page writes them, and small help with its elements. Text is set as text everywhere.

/** `digits` significant ones, no fewer than the integer part has; thousands apart; a true minus. */
export function num(value: number, digits = 4): string {
  if (!Number.isFinite(value)) return 'n/a';
  if (value === 0) return '0';
  const size = Math.floor(Math.log10(Math.abs(value)));
  if (size < -5 || size > 14) {
    const [m, e] = value.toExponential(digits - 1).split('e') as [string, string];
    return `${m.replace('-', '\u2212')}\u00d710^${Number(e)}`.replace('^-', '^\u2212');
  }
  return fixed(value, Math.max(0, digits - 1 - size));
}
export function fixed(value: number, decimals: number): string {
  const text = Math.abs(value).toFixed(decimals), [whole, rest] = text.split('.') as [string, string | undefined];
  const grouped = whole.replace(/\B(?=(\d{3})+$)/g, '\u202f');
  return (value < 0 && Number(text) !== 0 ? '\u2212' : '') + grouped + (rest ? '.' + rest : '');
}
export const signed = (value: number, digits = 4): string => (value > 0 ? '+' : '') + num(value, digits);

type Props = Record<string, string | number | boolean | ((e: never) => void)>;
/** An element with attributes; functions are listeners, strings among the children are text. */
export function el<K extends keyof HTMLElementTagNameMap>(tag: K, props: Props = {}, ...children: (Node | string)[]): HTMLElementTagNameMap[K] {
  const e = document.createElement(tag);
  for (const [name, value] of Object.entries(props)) {
    if (typeof value === 'function') e.addEventListener(name, value as unknown as EventListener);
    else if (typeof value === 'boolean') { if (value) e.setAttribute(name, ''); }
    else e.setAttribute(name, String(value));
  }
  e.append(...children);
  return e;
}
export function svg(tag: string, props: Props = {}, ...children: (Node | string)[]): SVGElement {
  const e = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(props)) {
    if (typeof value === 'function') e.addEventListener(name, value as unknown as EventListener);
    else e.setAttribute(name, String(value));
  }
  e.append(...children);
  return e;
}

export function save(name: string, type: string, content: BlobPart): void {
  const url = URL.createObjectURL(new Blob([content], {type}));
  const link = el('a', {href: url, download: name});
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

export async function copy(text: string): Promise<boolean> {
  try { await navigator.clipboard.writeText(text); return true; } catch { /* no permission: the old way */ }
  const area = el('textarea', {'aria-hidden': 'true', style: 'position:fixed;left:-99em'});
  area.value = text;
  const before = document.activeElement as HTMLElement | null;
  document.body.append(area);
  area.select();
  const done = document.execCommand('copy');
  area.remove();
  before?.focus();
  return done;
}

/** The least of 1, 2, 5 times a power of ten that is not below v. */
export const niceAbove = (v: number): number => (nice(v) >= v ? nice(v) : nice(2.5 * v));

/** The greatest of 1, 2, 5 times a power of ten that is not above v. */
export function nice(v: number): number {
  const power = 10 ** Math.floor(Math.log10(v));
  return (v >= 5 * power ? 5 : v >= 2 * power ? 2 : 1) * power;
}
