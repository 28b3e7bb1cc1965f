// Charts as SVG text, drawn for a size in CSS pixels: text has the same size in every chart.
//
// A chart has a frame with two axes. Marks are drawn in the order of the calls; grid, ticks, labels,
// legend, title and caption are added by `svg`. Coordinates are those of the axes.

export interface Theme {
  text: string;
  /** Of less important text, such as numbers at the axes. */
  soft: string;
  line: string;
  back: string;
  /** Whether the ground is left out; rims keep its colour. */
  isClear?: boolean;
}

export const LIGHT: Theme = { text: "#1b1b1b", soft: "#595959", line: "#d0d0d0", back: "#ffffff" };
export const DARK: Theme = { text: "#ededed", soft: "#a8a8a8", line: "#3a3a3a", back: "#232323" };

export interface Size {
  width: number;
  height: number;
}

export type Point = readonly [number, number];

export interface Axis {
  range: Point;
  /** May have `_italic_`, `^raised^` and `~lowered~` parts. */
  label: string;
  /** Numbers at round steps, unless given. */
  ticks?: { value: number; text: string }[];
}

export interface Style {
  stroke?: string;
  width?: number;
  /** Lengths of dashes and gaps. */
  dash?: string;
  fill?: string;
  opacity?: number;
  /** A rim of the colour of the ground, so that the mark is visible on any colour. */
  rim?: boolean;
}

export interface LegendEntry {
  name: string;
  style: Style;
}

export interface ChartOptions {
  size: Size;
  theme: Theme;
  title: string;
  caption?: string;
  x: Axis;
  y: Axis;
  /** Whether both axes have the same scale; the frame is then as large as fits. */
  isEqual?: boolean;
  /** Whether axes, grid and frame are left out, as in polar charts. */
  isBare?: boolean;
  /** Names of marks: in a corner of the frame at the right, or below it. */
  legend?: LegendEntry[];
  legendAt?: "top" | "bottom" | "below";
}

/** Lines of gamuts, in the order of the gamuts. */
export const DASHES = ["", "7 4", "2 3", "10 3 2 3", "5 5", "12 4"];

const TEXT = 12;
const SMALL = 11;
const LINE = 16;
/** Mean width of a character of a sans-serif font, in parts of its size. */
const CHARACTER = 0.54;
const LEGEND_LINE = 18;
const TICK_ROOM = 18;
const EDGE = 8;

let charts = 0;

export function escaped(text: string): string {
  const entities: Record<string, string> = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "'": "&#39;" };
  // Characters that XML does not allow are left out.
  return text.replaceAll(/[\u0000-\u0008\u000b\u000c\u000e-\u001f\ufffe\uffff]/g, "").replaceAll(/[&<>"']/g, (character) => entities[character]!);
}

/** A number from 1, 2 or 5 times a power of ten that divides a length into about `parts` parts. */
export function niceStep(length: number, parts: number): number {
  const rough = length / parts;
  const power = 10 ** Math.floor(Math.log10(rough));
  return power * ([1, 2, 5].find((factor) => factor * power >= 0.98 * rough) ?? 10);
}

/** A number with some significant digits, and without an exponent. */
export function numberText(value: number, digits = 6): string {
  const text = (value || 0).toLocaleString("en", { maximumSignificantDigits: digits, useGrouping: false });
  return text.replace("-", "−");
}

export class Chart {
  /** The frame in pixels. */
  readonly left: number;
  readonly top: number;
  readonly width: number;
  readonly height: number;
  private readonly id = `chart-${(charts += 1)}`;
  private readonly marks: string[] = [];
  private readonly definitions: string[] = [];
  private readonly titleLines: string[];
  private readonly captionLines: string[];
  private readonly legendRoom: number;
  private ticks: { x: Tick[]; y: Tick[] };

  constructor(private readonly options: ChartOptions) {
    const { size, title, caption = "", x, y, legend = [], legendAt } = options;
    const room = Math.max(8, Math.floor((size.width - 2 * EDGE) / (SMALL * CHARACTER)));
    this.titleLines = wrapped(title, Math.floor(room * 0.85));
    this.captionLines = wrapped(caption, room);
    this.top = EDGE + LINE * this.titleLines.length + (this.titleLines.length > 0 ? 10 : 0);
    this.legendRoom = legendAt === "below" ? LEGEND_LINE * legend.length + 6 : 0;
    const below = LINE * this.captionLines.length + EDGE + this.legendRoom;
    const [across, upward] = options.isBare ? [0, 0] : [TICK_ROOM + LINE + 4, LINE];
    let height = Math.max(40, size.height - this.top - below - across);
    this.ticks = { x: [], y: ticksOf(y, height / 44) };
    const widest = Math.max(0, ...this.ticks.y.map(({ text }) => text.length)) * SMALL * CHARACTER;
    this.left = options.isBare ? EDGE : EDGE + upward + widest + 6;
    let width = Math.max(40, size.width - this.left - EDGE - (options.isBare ? 0 : 12));
    if (options.isEqual) {
      const scale = Math.min(width / (x.range[1] - x.range[0]), height / (y.range[1] - y.range[0]));
      const spare = width - scale * (x.range[1] - x.range[0]);
      width -= spare;
      height = scale * (y.range[1] - y.range[0]);
      this.left += spare / 2;
      this.ticks.y = ticksOf(y, height / 44);
    }
    this.width = width;
    this.height = height;
    this.ticks.x = ticksOf(x, width / 50);
  }

  /** Pixels from the left. */
  x(value: number): number {
    const [low, high] = this.options.x.range;
    return this.left + ((value - low) / (high - low)) * this.width;
  }

  /** Pixels from the top. */
  y(value: number): number {
    const [low, high] = this.options.y.range;
    return this.top + (1 - (value - low) / (high - low)) * this.height;
  }

  /** Outline of points as the value of the attribute `d`. */
  path(points: readonly Point[], isClosed = true): string {
    if (points.length === 0) return "";
    const corners = points.map(([x, y]) => `${this.x(x).toFixed(1)},${this.y(y).toFixed(1)}`);
    return `M${corners.join("L")}${isClosed ? "Z" : ""}`;
  }

  /** Draw a path. Parts out of the frame are not shown. */
  draw(path: string, style: Style): void {
    if (path === "") return;
    const { stroke = "none", width = 1.6, fill = "none", opacity = 1, dash = "", rim = false } = style;
    const common = `d="${path}" stroke-linejoin="round" clip-path="url(#${this.id}-frame)"`;
    if (rim) this.marks.push(`<path ${common} fill="none" stroke="${this.options.theme.back}" stroke-width="${width + 2.4}" opacity="0.75"/>`);
    const dashes = dash === "" ? "" : ` stroke-dasharray="${dash}"`;
    this.marks.push(`<path ${common} fill="${fill}" stroke="${stroke}" stroke-width="${width}" opacity="${opacity}"${dashes}/>`);
  }

  polygon(points: readonly Point[], style: Style): void {
    this.draw(this.path(points), style);
  }

  line(points: readonly Point[], style: Style): void {
    this.draw(this.path(points, false), style);
  }

  point([x, y]: Point, { stroke = this.options.theme.text, fill = this.options.theme.back, width = 1.4 }: Style, radius = 3.5): void {
    this.marks.push(
      `<circle cx="${this.x(x).toFixed(1)}" cy="${this.y(y).toFixed(1)}" r="${radius}" fill="${fill}" stroke="${stroke}" stroke-width="${width}"/>`,
    );
  }

  /** Write a text beside a point, away from it by pixels, with a rim. */
  text(point: Point, text: string, away: Point = [6, 0], anchor: "start" | "middle" | "end" = "start", colour = this.options.theme.text): void {
    const [x, y] = [this.x(point[0]) + away[0], this.y(point[1]) + away[1] + 0.35 * SMALL];
    this.marks.push(
      `<text x="${x.toFixed(1)}" y="${y.toFixed(1)}" font-size="${SMALL}" text-anchor="${anchor}" fill="${colour}"${this.rim}>${escaped(text)}</text>`,
    );
  }

  /** Fill a part of the frame with a picture, cut out by a path. */
  image(address: string, [left, right]: Point, [bottom, top]: Point, clip: string, opacity = 1): void {
    const id = `${this.id}-clip-${this.definitions.length}`;
    this.definitions.push(`<clipPath id="${id}"><path clip-rule="evenodd" d="${clip}"/></clipPath>`);
    const [x, y] = [this.x(left), this.y(top)];
    const box = `x="${x.toFixed(2)}" y="${y.toFixed(2)}" width="${(this.x(right) - x).toFixed(2)}" height="${(this.y(bottom) - y).toFixed(2)}"`;
    this.marks.push(
      `<image ${box} preserveAspectRatio="none" clip-path="url(#${id})" opacity="${opacity}" href="${address}"/>`,
    );
  }

  /** A fill of oblique lines. */
  hatch(colour: string): string {
    const id = `${this.id}-hatch-${this.definitions.length}`;
    this.definitions.push(
      `<pattern id="${id}" width="7" height="7" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">` +
        `<path d="M0,0V7" stroke="${this.options.theme.back}" stroke-width="4"/><path d="M0,0V7" stroke="${colour}" stroke-width="2"/></pattern>`,
    );
    return `url(#${id})`;
  }

  svg(): string {
    const { size, theme, title, x, y, isBare = false } = this.options;
    const { left, top, width, height, id } = this;
    const [right, bottom] = [left + width, top + height];
    const frame = `x="${left.toFixed(1)}" y="${top.toFixed(1)}" width="${width.toFixed(1)}" height="${height.toFixed(1)}"`;
    const tick = (at: number, text: string, isAcross: boolean) =>
      isAcross
        ? `<text x="${at.toFixed(1)}" y="${(bottom + 15).toFixed(1)}" text-anchor="middle">${escaped(text)}</text>`
        : `<text x="${(left - 6).toFixed(1)}" y="${(at + 4).toFixed(1)}" text-anchor="end">${escaped(text)}</text>`;
    const grid = [
      ...this.ticks.x.map(({ value }) => `M${this.x(value).toFixed(1)},${top.toFixed(1)}V${bottom.toFixed(1)}`),
      ...this.ticks.y.map(({ value }) => `M${left.toFixed(1)},${this.y(value).toFixed(1)}H${right.toFixed(1)}`),
    ].join("");
    const axes = isBare
      ? []
      : [
          `<rect ${frame} fill="none" stroke="${theme.soft}" stroke-width="1"/>`,
          `<g font-size="${SMALL}" fill="${theme.soft}">`,
          ...this.ticks.x.map(({ value, text }) => tick(this.x(value), text, true)),
          ...this.ticks.y.map(({ value, text }) => tick(this.y(value), text, false)),
          "</g>",
          `<text x="${((left + right) / 2).toFixed(1)}" y="${(bottom + TICK_ROOM + LINE).toFixed(1)}" text-anchor="middle">${rich(x.label)}</text>`,
          `<text transform="translate(${(left - this.tickWidth - LINE + 4).toFixed(1)},${((top + bottom) / 2).toFixed(1)}) rotate(-90)" text-anchor="middle">${rich(y.label)}</text>`,
        ];
    const captionTop = bottom + (isBare ? 0 : TICK_ROOM + LINE + 4) + LINE + this.legendRoom;
    return [
      `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${size.width} ${size.height}" width="${size.width}" height="${size.height}" role="img" font-family="system-ui, 'Segoe UI', Roboto, sans-serif" font-size="${TEXT}" fill="${theme.text}">`,
      `<title>${escaped(title)}</title>`,
      `<defs><clipPath id="${id}-frame"><rect ${frame}/></clipPath>${this.definitions.join("")}</defs>`,
      ...(theme.isClear ? [] : [`<rect width="100%" height="100%" fill="${theme.back}"/>`]),
      ...(isBare ? [] : [`<path d="${grid}" fill="none" stroke="${theme.line}" stroke-width="1"/>`]),
      ...this.marks,
      ...axes,
      ...this.legendLines(),
      ...this.titleLines.map((line, row) => `<text x="${EDGE}" y="${EDGE + 12 + LINE * row}" font-size="13" font-weight="600">${escaped(line)}</text>`),
      ...this.captionLines.map(
        (line, row) => `<text x="${EDGE}" y="${(captionTop + LINE * row).toFixed(1)}" font-size="${SMALL}" fill="${theme.soft}">${escaped(line)}</text>`,
      ),
      "</svg>",
    ].join("\n");
  }

  private get tickWidth(): number {
    return Math.max(0, ...this.ticks.y.map(({ text }) => text.length)) * SMALL * CHARACTER;
  }

  private get rim(): string {
    return ` stroke="${this.options.theme.back}" stroke-width="3" stroke-linejoin="round" paint-order="stroke"`;
  }

  private legendLines(): string[] {
    const { size, theme, legend = [], legendAt = "top", isBare } = this.options;
    const isBelow = legendAt === "below";
    const bottom = this.top + this.height;
    const start = { top: this.top + 15, bottom: bottom - 13 - LEGEND_LINE * (legend.length - 1), below: bottom + (isBare ? 0 : TICK_ROOM + LINE + 4) + 15 }[legendAt];
    const room = isBelow ? size.width - 2 * EDGE : 0.62 * this.width;
    const most = Math.max(8, Math.floor((room - 50) / (SMALL * CHARACTER)));
    return legend.map(({ name, style }, row) => {
      const y = start + LEGEND_LINE * row;
      const { stroke = "none", width = 1.6, dash = "" } = style;
      const left = isBelow ? EDGE : this.left + this.width - 38;
      const [end, anchor] = isBelow ? [left + 36, "start"] : [left - 6, "end"];
      const dashes = dash === "" ? "" : ` stroke-dasharray="${dash}"`;
      const mark = `<path d="M${left.toFixed(1)},${y.toFixed(1)}h30" stroke="${stroke}" stroke-width="${width}"${dashes}/>`;
      const text = `<text x="${end.toFixed(1)}" y="${(y + 4).toFixed(1)}" font-size="${SMALL}" text-anchor="${anchor}" fill="${theme.text}"${this.rim}>${escaped(shortened(name, most))}</text>`;
      return `<g><title>${escaped(name)}</title>${mark}${text}</g>`;
    });
  }
}

interface Tick {
  value: number;
  text: string;
}

function ticksOf({ range: [low, high], ticks }: Axis, parts: number): Tick[] {
  if (ticks !== undefined) return ticks;
  const step = niceStep(high - low, Math.max(2, parts));
  const first = Math.ceil(low / step - 1e-9);
  const count = Math.floor(high / step + 1e-9) - first + 1;
  return Array.from({ length: count }, (_, i) => ({ value: (first + i) * step, text: numberText((first + i) * step) }));
}

export function shortened(text: string, most: number): string {
  return text.length <= most ? text : `${text.slice(0, most - 1).trimEnd()}…`;
}

/** Lines of at most so many characters. */
function wrapped(text: string, most: number): string[] {
  const lines: string[] = [];
  for (const word of text.split(" ").filter((each) => each !== "")) {
    const last = lines.at(-1);
    if (last !== undefined && last.length + 1 + word.length <= most) lines[lines.length - 1] = `${last} ${word}`;
    else lines.push(shortened(word, most));
  }
  return lines;
}

/** Text with `_italic_`, `^raised^` and `~lowered~` parts. */
function rich(text: string): string {
  return escaped(text)
    .replaceAll(/_([^_]+)_/g, '<tspan font-style="italic">$1</tspan>')
    .replaceAll(/([\^~])([^\^~]+)\1(.?)/g, (_, kind: string, part: string, next: string) => {
      const shift = kind === "^" ? -4 : 4;
      return `<tspan dy="${shift}" font-size="${SMALL}">${part}</tspan>${next === "" ? "" : `<tspan dy="${-shift}">${next}</tspan>`}`;
    });
}

/** A PNG file of RGBA pixels, row by row from the top, as a data address; without compression. */
export function png(pixels: Uint8ClampedArray, columns: number): string {
  const rows = pixels.length / 4 / columns;
  const scanlines = new Uint8Array(rows * (4 * columns + 1));
  for (let row = 0; row < rows; row++) {
    scanlines.set(pixels.subarray(4 * columns * row, 4 * columns * (row + 1)), row * (4 * columns + 1) + 1);
  }
  const stored: number[][] = [[0x78, 0x01]];
  const parts: (number[] | Uint8Array)[] = stored;
  for (let begin = 0; begin < scanlines.length; begin += 0xffff) {
    const block = scanlines.subarray(begin, begin + 0xffff);
    const size = block.length;
    const isLast = begin + size === scanlines.length ? 1 : 0;
    parts.push([isLast, size & 255, size >> 8, ~size & 255, (~size >> 8) & 255], block);
  }
  let [a, b] = [1, 0];
  for (const value of scanlines) {
    a = (a + value) % 65521;
    b = (b + a) % 65521;
  }
  parts.push(bigEndian(((b << 16) | a) >>> 0));
  const chunks = [
    Uint8Array.of(0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a),
    chunk("IHDR", [[...bigEndian(columns), ...bigEndian(rows), 8, 6, 0, 0, 0]]),
    chunk("IDAT", parts),
    chunk("IEND", []),
  ];
  let text = "";
  for (const each of chunks) for (const value of each) text += String.fromCharCode(value);
  return `data:image/png;base64,${btoa(text)}`;
}

function bigEndian(value: number): number[] {
  return [value >>> 24, (value >>> 16) & 255, (value >>> 8) & 255, value & 255];
}

/** Remainders of the cyclic redundancy check of PNG (ISO/IEC 15948, annex D). */
const REMAINDERS = Uint32Array.from({ length: 256 }, (_, value) => {
  for (let bit = 0; bit < 8; bit++) value = value & 1 ? 0xedb88320 ^ (value >>> 1) : value >>> 1;
  return value;
});

function chunk(name: string, parts: (number[] | Uint8Array)[]): Uint8Array {
  const size = parts.reduce((sum, part) => sum + part.length, 0);
  const bytes = new Uint8Array(size + 12);
  bytes.set([...bigEndian(size), ...Array.from(name, (letter) => letter.charCodeAt(0))]);
  let at = 8;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  let check = 0xffffffff;
  for (const value of bytes.subarray(4, at)) check = REMAINDERS[(check ^ value) & 255]! ^ (check >>> 8);
  bytes.set(bigEndian(~check >>> 0), at);
  return bytes;
}
