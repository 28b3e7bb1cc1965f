// The unrolled surface: the largest chroma at each hue and lightness, and where another one is larger.
import { encoded } from "../colours/colours.js";
import type { Space } from "../colours/spaces.js";
import { Chart, type Size, type Theme, niceStep, numberText, png, shortened } from "./chart.js";

/** A closed surface, with the name of its gamut. */
export interface Surface {
  name: string;
  /** Three coordinates for each vertex. */
  positions: Float32Array;
  /** Three vertices for each face. */
  faces: Int32Array;
}

/** Largest chroma by lightness (rows, from the least) and hue (columns, from 0°); 0 without colours. */
export interface Reach {
  columns: number;
  rows: number;
  lightness: readonly [number, number];
  chroma: Float32Array;
}

const COLUMNS = 180;
const ROWS = 96;
/** Characters of names in sentences. */
const MOST_NAME = 36;
/** The second gamut reaches further where it does by this part of the largest chroma. */
const SLIGHT = 0.01;

/** Least and largest lightness of surfaces. */
export function lightnessRange(surfaces: readonly Surface[]): [number, number] {
  const range: [number, number] = [Infinity, -Infinity];
  for (const { positions } of surfaces) {
    for (let i = 0; i < positions.length; i += 3) {
      range[0] = Math.min(range[0], positions[i]!);
      range[1] = Math.max(range[1], positions[i]!);
    }
  }
  return range;
}

/**
 * Return the largest chroma of a surface in a space with lightness, a and b.
 *
 * Each face is cut by the planes of the rows. The cut is a segment, whose chroma at a hue is where the
 * ray of the hue meets it.
 */
export function reachOf({ positions, faces }: Surface, lightness: readonly [number, number], columns = COLUMNS, rows = ROWS): Reach {
  const chroma = new Float32Array(columns * rows);
  const [low, high] = lightness;
  const step = (high - low) / rows;
  const ends = new Float64Array(4);
  for (let face = 0; face < faces.length; face += 3) {
    const corners = [3 * faces[face]!, 3 * faces[face + 1]!, 3 * faces[face + 2]!];
    const heights = corners.map((at) => positions[at]!);
    const first = Math.max(0, Math.ceil((Math.min(...heights) - low) / step - 0.5));
    const last = Math.min(rows - 1, Math.floor((Math.max(...heights) - low) / step - 0.5));
    for (let row = first; row <= last; row++) {
      const height = low + (row + 0.5) * step;
      let count = 0;
      for (let corner = 0; corner < 3 && count < 4; corner++) {
        const [from, to] = [heights[corner]!, heights[(corner + 1) % 3]!];
        if (from >= height === to >= height) continue;
        const t = (height - from) / (to - from);
        const [p, q] = [corners[corner]!, corners[(corner + 1) % 3]!];
        for (let axis = 1; axis <= 2; axis++) ends[count++] = positions[p + axis]! + t * (positions[q + axis]! - positions[p + axis]!);
      }
      if (count === 4) extend(chroma, row * columns, columns, ends[0]!, ends[1]!, ends[2]!, ends[3]!);
    }
  }
  return { columns, rows, lightness, chroma };
}

/** Largest chroma by hue, at any lightness: where edges cross the plane of the hue. */
export function reachByHue({ positions, faces }: Surface, columns = COLUMNS): number[] {
  const chroma = new Float32Array(columns);
  for (let corner = 0; corner < faces.length; corner++) {
    const p = 3 * faces[corner]!;
    const q = 3 * faces[corner % 3 === 2 ? corner - 2 : corner + 1]!;
    if (p < q) extend(chroma, 0, columns, positions[p + 1]!, positions[p + 2]!, positions[q + 1]!, positions[q + 2]!);
  }
  return Array.from(chroma);
}

/** Raise the chroma of the hues under which a segment of the a-b plane is seen to where it is. */
function extend(chroma: Float32Array, begin: number, columns: number, a1: number, b1: number, a2: number, b2: number): void {
  if (a1 * b2 < b1 * a2) [a1, b1, a2, b2] = [a2, b2, a1, b1]; // counter-clockwise
  const area = a1 * b2 - b1 * a2;
  const turn = (2 * Math.PI) / columns;
  const from = Math.atan2(b1, a1);
  const angle = Math.atan2(area, a1 * a2 + b1 * b2); // less than 180°
  const last = Math.floor((from + angle) / turn - 0.5);
  for (let column = Math.ceil(from / turn - 0.5); column <= last; column++) {
    const hue = (column + 0.5) * turn;
    const divisor = Math.cos(hue) * (b2 - b1) - Math.sin(hue) * (a2 - a1);
    const at = begin + (((column % columns) + columns) % columns);
    if (divisor > 0) chroma[at] = Math.max(chroma[at]!, area / divisor);
  }
}

/** Return the chart as SVG. Surfaces are in `space`; not in CIEXYZ, which has no hue. */
export function unrolledChart(
  space: Space,
  first: Surface,
  second: Surface | null,
  { size, theme }: { size: Size; theme: Theme },
): string {
  const range = lightnessRange(second === null ? [first] : [first, second]);
  const reach = reachOf(first, range);
  const other = second === null ? null : reachOf(second, range);
  const lightness = space.axes[space.lightness]!;
  const compared = other === null ? "" : ` Hatched: ${shortened(second!.name, MOST_NAME)} reaches further.`;
  const chart = new Chart({
    size,
    theme,
    title: `Largest chroma of ${shortened(first.name, MOST_NAME)}`,
    caption: `Each point is the surface's own colour. Lines: equal chroma.${compared}`,
    x: { range: [0, 360], label: "Hue", ticks: [0, 60, 120, 180, 240, 300, 360].map((value) => ({ value, text: `${value}°` })) },
    y: { range: lightnessAxis(range), label: `Lightness ${lightness}` },
  });
  const whole = chart.path([[0, range[0]], [360, range[0]], [360, range[1]], [0, range[1]]]);
  chart.image(picture(space, reach), [0, 360], range, whole);
  const most = reach.chroma.reduce((one, two) => Math.max(one, two), 0);
  const step = niceStep(most, 5);
  const values: number[] = [];
  for (let value = step; value < 0.98 * most; value += step) values.push(value);
  const lines = values.map((value) => contours(reach, reach.chroma, value));
  lines.forEach((segments) => chart.draw(pathOf(chart, reach, segments), { stroke: theme.text, width: 0.9, rim: true }));
  if (other !== null) {
    const further = other.chroma.map((value, i) => value - reach.chroma[i]!);
    const tolerance = SLIGHT * most;
    chart.draw(cells(chart, reach, further, tolerance), { fill: chart.hatch(theme.text), opacity: 0.55 });
    chart.draw(pathOf(chart, reach, contours(reach, further, tolerance)), { stroke: theme.text, width: 1.8, rim: true });
  }
  lines.forEach((segments, i) => {
    // One label, where the line is most to the left, and others at a third and two thirds.
    for (const place of [0.08, 0.42, 0.75]) {
      const [x, y] = nearest(segments, place * reach.columns) ?? [NaN, NaN];
      if (Number.isFinite(x)) chart.text(valuesAt(reach, x, y), numberText(values[i]!), [0, 0], "middle");
    }
  });
  return chart.svg();
}

/** Whole steps around a range. */
function lightnessAxis([low, high]: readonly [number, number]): [number, number] {
  const step = niceStep(high - low, 10);
  return [Math.floor(low / step + 0.05) * step, Math.ceil(high / step - 0.05) * step];
}

/** The surface's own colours; transparent where there is none. */
function picture(space: Space, { columns, rows, lightness: [low, high], chroma }: Reach): string {
  const points = new Float32Array(3 * chroma.length);
  for (let i = 0; i < chroma.length; i++) {
    const hue = (((i % columns) + 0.5) / columns) * 2 * Math.PI;
    const height = low + ((Math.floor(i / columns) + 0.5) / rows) * (high - low);
    points.set([height, chroma[i]! * Math.cos(hue), chroma[i]! * Math.sin(hue)], 3 * i);
  }
  const linear = space.linear(points, "srgb");
  const pixels = new Uint8ClampedArray(4 * chroma.length);
  for (let i = 0; i < chroma.length; i++) {
    const from = (rows - 1 - Math.floor(i / columns)) * columns + (i % columns);
    for (let channel = 0; channel < 3; channel++) pixels[4 * i + channel] = 255 * encoded(linear[3 * from + channel]!);
    pixels[4 * i + 3] = chroma[from]! > 0 ? 255 : 0;
  }
  return png(pixels, columns);
}

/** A segment between two points, in columns and rows. */
type Segment = [number, number, number, number];

/** Lines where values of the grid have a level: marching squares between the middles of its cells. */
function contours({ columns, rows }: Reach, values: Float32Array, level: number): Segment[] {
  const segments: Segment[] = [];
  const at = (column: number, row: number) => values[row * columns + (column % columns)]! - level;
  for (let row = 0; row + 1 < rows; row++) {
    for (let column = 0; column < columns; column++) {
      const corners: [number, number, number][] = [
        [column, row, at(column, row)],
        [column + 1, row, at(column + 1, row)],
        [column + 1, row + 1, at(column + 1, row + 1)],
        [column, row + 1, at(column, row + 1)],
      ];
      const crossings = corners.flatMap(([x, y, value], i) => {
        const [x2, y2, value2] = corners[(i + 1) % 4]!;
        if (value >= 0 === value2 >= 0) return [];
        const t = value / (value - value2);
        return [[x + t * (x2 - x), y + t * (y2 - y)]];
      });
      for (let i = 0; i + 1 < crossings.length; i += 2) segments.push([...crossings[i]!, ...crossings[i + 1]!] as Segment);
    }
  }
  return segments;
}

/** Hue and lightness of a place between the middles of cells. */
function valuesAt({ columns, rows, lightness: [low, high] }: Reach, column: number, row: number): [number, number] {
  return [((column + 0.5) / columns) * 360, low + ((row + 0.5) / rows) * (high - low)];
}

function pathOf(chart: Chart, reach: Reach, segments: Segment[]): string {
  const place = (column: number, row: number) => {
    const [hue, lightness] = valuesAt(reach, column, row);
    return `${chart.x(hue).toFixed(1)},${chart.y(lightness).toFixed(1)}`;
  };
  // A cell across 360° is drawn at both ends.
  return segments
    .flatMap((segment) => (Math.max(segment[0], segment[2]) > reach.columns - 1 ? [segment, shifted(segment, reach.columns)] : [segment]))
    .map(([x1, y1, x2, y2]) => `M${place(x1, y1)}L${place(x2, y2)}`)
    .join("");
}

function shifted([x1, y1, x2, y2]: Segment, columns: number): Segment {
  return [x1 - columns, y1, x2 - columns, y2];
}

/** The cells with values above a level, as runs of each row. */
function cells(chart: Chart, reach: Reach, values: Float32Array, level: number): string {
  const { columns, rows } = reach;
  const runs: string[] = [];
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      if (values[row * columns + column]! < level) continue;
      const begin = column;
      while (column < columns && values[row * columns + column]! >= level) column += 1;
      const [from, bottom] = valuesAt(reach, begin - 0.5, row - 0.5);
      const [to, top] = valuesAt(reach, column - 0.5, row + 0.5);
      runs.push(`M${chart.x(from).toFixed(1)},${chart.y(bottom).toFixed(2)}H${chart.x(to).toFixed(1)}V${chart.y(top).toFixed(2)}H${chart.x(from).toFixed(1)}Z`);
    }
  }
  return runs.join("");
}

/** The highest point of a line near a column. */
function nearest(segments: Segment[], column: number): [number, number] | null {
  const near = segments.filter(([x]) => Math.abs(x - column) < 2);
  const top = near.reduce<Segment | null>((best, each) => (best === null || each[1] > best[1] ? each : best), null);
  return top === null ? null : [top[0], top[1]];
}
