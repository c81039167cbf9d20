// The areas by d, coloured as the surface is, with the two limits to be dragged: legend and control in one.
import type {PageData} from './block';
import {css} from './palette';
import {num, signed, svg} from './words';

export interface Histogram { element: SVGElement; update(areas: Float64Array, low: number, high: number, colour: (d: number) => [number, number, number]): void }

const width = 280, margin = 8, height = 118, top = 6, bottom = 40, floor = height - bottom;

export function histogram(page: PageData, reach: number, onLimit: (upper: boolean, value: number) => void): Histogram {
  const bars = svg('g'), handles = svg('g');
  const element = svg('svg', {viewBox: `${-margin} 0 ${width + 2 * margin} ${height}`, class: 'v-histogram', role: 'img',
    'aria-label': 'Areas by difference, in the colours of the surface; the two lines are the limits of the colours'}, bars, handles);
  const x = (d: number): number => width * (d + reach) / (2 * reach);
  let dragged: boolean | null = null, limits: [number, number] = [-reach, reach];
  const value = (e: PointerEvent): number => {
    const box = element.getBoundingClientRect();
    return (((e.clientX - box.left) / box.width * (width + 2 * margin) - margin) / width * 2 - 1) * reach;
  };
  element.addEventListener('pointerdown', e => {
    const d = value(e);
    dragged = Math.abs(d - limits[1]) < Math.abs(d - limits[0]);
    element.setPointerCapture(e.pointerId);
    e.preventDefault();
  });
  element.addEventListener('pointermove', e => { if (dragged !== null) onLimit(dragged, value(e)); });
  for (const end of ['pointerup', 'pointercancel']) element.addEventListener(end, () => { dragged = null; });
  return {element, update(areas, low, high, colour) {
    limits = [low, high];
    const most = Math.max(...areas, 1e-300), n = areas.length;
    bars.replaceChildren(svg('path', {d: `M0 ${floor}H${width}`, stroke: 'currentColor', 'stroke-opacity': 0.5}));
    areas.forEach((area, i) => {
      const from = -reach + 2 * reach * i / n, to = from + 2 * reach / n, size = Math.sqrt(area / most) * (floor - top);
      const bar = svg('rect', {x: x(from).toFixed(2), y: (floor - size).toFixed(2), width: (width / n).toFixed(2), height: size.toFixed(2),
        fill: css(colour((from + to) / 2)), stroke: 'var(--bar)', 'stroke-width': 0.5});
      bar.append(svg('title', {}, `${signed(from, 3)} \u2026 ${signed(to, 3)} ${page.heightUnit}: ${num(area, 3)} ${page.areaUnit}`));
      bars.append(bar);
    });
    for (let i = 0; i < 140; ++i) {
      const d = -reach + 2 * reach * (i + 0.5) / 140;
      bars.append(svg('rect', {x: 2 * i, y: floor + 2, width: 2.3, height: 9, fill: css(colour(d))}));
    }
    handles.replaceChildren();
    for (const [d, anchor] of [[low, 'start'], [high, 'end']] as const) {
      const at = x(d);
      handles.append(svg('path', {d: `M${at} ${top}V${floor + 14}`, stroke: 'currentColor', 'stroke-width': 2}),
        svg('circle', {cx: at, cy: top + 5, r: 5, fill: 'currentColor'}));
      const room = anchor === 'start' ? Math.min(at, width / 2 - 34) : Math.max(at, width / 2 + 34);
      handles.append(svg('text', {x: anchor === 'start' ? Math.max(0, room - 14) : Math.min(width, room + 14), y: height - 10, 'text-anchor': anchor, 'font-size': 12.5, fill: 'currentColor'}, signed(d, 3)));
    }
    handles.append(svg('text', {x: width / 2, y: height - 10, 'text-anchor': 'middle', 'font-size': 12.5, fill: 'currentColor'}, '0'));
  }};
}
