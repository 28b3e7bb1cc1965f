// Pictures of the view in any size, with title, legend and labels.
import { SCREEN } from "../colours/colours.js";
import { FONT, type Edges, type Label, TEXT_SIZE } from "./axes.js";
import { type Size, escaped } from "../charts/chart.js";
import type { View } from "./scene.js";

/** How much of another gamut one covers. */
export interface PictureBar {
  name: string;
  other: string;
  /** From 0 to 1, and in words. */
  share: number;
  text: string;
  colour: string;
}

/** What a picture has besides the view. */
export interface Picture {
  /** In CSS pixels, and pixels of the picture per CSS pixel. */
  width: number;
  height: number;
  ratio: number;
  title: string;
  /** A line for each gamut, with the CSS colour of its mark, and a figure behind its name. */
  legend: { text: string; figure: string; colour: string }[];
  note: string;
  bars: PictureBar[];
  /** A chart at the right of the view or below it. */
  chart: { svg: string; width: number; height: number; isBelow: boolean } | null;
  /** CSS colours of the text, of the rest of a bar, and behind everything. */
  colour: string;
  line: string;
  ground: string;
  /** Whether the ground is transparent; rims of texts keep its colour. */
  isClear: boolean;
}

const MARGIN = 16;
const TITLE_SIZE = 16;
const LEGEND_SIZE = 13;
const NOTE_SIZE = 11.5;
const LINE = 18;
/** Height of a line with a bar, and of the bar. */
const BAR_LINE = 24;
const BAR = 9;
const BAR_WIDTH = 480;
/** Bars stand behind their texts if there is so much room, else below them. */
const WIDE = 560;

/** The view as a PNG file. */
export async function pngPicture(view: View, picture: Picture): Promise<Blob> {
  const canvas = await drawnPicture(view, picture);
  return new Promise((resolve, reject) =>
    canvas.toBlob((blob) => (blob === null ? reject(new Error("This browser cannot save so large a picture. Choose a smaller one.")) : resolve(blob))),
  );
}

/** The view as a picture on a canvas. */
export async function drawnPicture(view: View, picture: Picture): Promise<HTMLCanvasElement> {
  const context = contextFor(picture);
  await drawOn(context, view, picture);
  return context.canvas;
}

function contextFor({ width, height, ratio }: Picture): CanvasRenderingContext2D {
  const canvas = document.createElement("canvas");
  canvas.width = Math.floor(width * ratio);
  canvas.height = Math.floor(height * ratio);
  const context = canvas.getContext("2d", { colorSpace: SCREEN });
  if (context === null) throw new Error("This browser cannot draw so large a picture. Choose a smaller one.");
  return context;
}

async function drawOn(context: CanvasRenderingContext2D, view: View, picture: Picture): Promise<void> {
  const { canvas } = context;
  const text = view.at({ ...picture, ...viewSize(picture) }, edges(picture), (seen, labels) => {
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.fillStyle = picture.ground;
    if (!picture.isClear) context.fillRect(0, 0, canvas.width, canvas.height);
    context.drawImage(seen, 0, 0);
    return drawing(picture, labels);
  });
  const image = new Image();
  image.src = `data:image/svg+xml,${encodeURIComponent(text)}`;
  await image.decode();
  context.drawImage(image, 0, 0, canvas.width, canvas.height);
}

/** The part of a picture that the view has: the bars are below it, and the chart is beside or below both. */
function viewSize({ width, height, bars, chart }: Picture): Size {
  const across = chart === null || chart.isBelow ? width : width - chart.width;
  const down = chart?.isBelow ? height - chart.height : height;
  const bar = BAR_LINE + (across < WIDE ? BAR_LINE / 2 : 0);
  return { width: across, height: down - (bars.length === 0 ? 0 : MARGIN / 2 + bar * bars.length) };
}

/** Room for the texts above and below. */
function edges({ legend, note }: Picture): Edges {
  return { left: 0, right: 0, top: MARGIN + TITLE_SIZE + LINE * legend.length + 6, bottom: note === "" ? 0 : MARGIN + NOTE_SIZE };
}

function drawing(picture: Picture, labels: Label[]): string {
  const { width, height, ratio, title, legend, note, bars, chart, colour, line, ground } = picture;
  const part = viewSize(picture);
  const text = (x: number, y: number, size: number, content: string, more = "") =>
    `<text x="${x.toFixed(1)}" y="${y.toFixed(1)}" font-size="${size}"${more}>${escaped(content)}</text>`;
  const room = part.width - 2 * MARGIN;
  const lines = [
    text(MARGIN, MARGIN + 12, TITLE_SIZE, shortened(title, TITLE_SIZE, room), ' font-weight="600"'),
    ...legend.flatMap(({ text: name, figure, colour: tint }, i) => {
      const y = MARGIN + 14 + LINE * (i + 1);
      const named = shortened(name, LEGEND_SIZE, room - LINE - textWidth(figure, LEGEND_SIZE));
      return [
        `<circle cx="${MARGIN + 5}" cy="${y - 4.5}" r="5" fill="${tint}"/>`,
        text(MARGIN + LINE, y, LEGEND_SIZE, named + figure),
      ];
    }),
    text(MARGIN, part.height - MARGIN + 4, NOTE_SIZE, shortened(note, NOTE_SIZE, room)),
  ];
  const marks = labels.map(({ text: content, x, y, meaning }) =>
    text(x, y, TEXT_SIZE, content, ` dy=".35em"${meaning === null ? "" : ' font-weight="600"'}`),
  );
  return [
    `<svg xmlns="http://www.w3.org/2000/svg" width="${width * ratio}" height="${height * ratio}" viewBox="0 0 ${width} ${height}">`,
    `<g font-family="${FONT.replaceAll('"', "'")}" fill="${colour}" stroke="${ground}" stroke-width="3.5" stroke-linejoin="round" paint-order="stroke">`,
    ...lines,
    ...barLines(bars, part, line, text),
    // Texts of the chart have the same rim, as they state none.
    chart === null ? "" : `<g transform="translate(${chart.isBelow ? `0 ${height - chart.height}` : `${part.width} ${(height - chart.height) / 2}`})">${chart.svg}</g>`,
    `<g text-anchor="middle">`,
    ...marks,
    "</g></g></svg>",
  ].join("\n");
}

/** Bars of coverage under the view, each with its text. */
function barLines(bars: PictureBar[], { width, height }: Size, line: string, text: (x: number, y: number, size: number, content: string) => string): string[] {
  const isWide = width >= WIDE;
  const room = width - 2 * MARGIN;
  const texts = bars.map(({ name, other, text: share }) => {
    const middle = ` covers ${share} of `;
    const most = ((isWide ? 0.6 : 1) * room - textWidth(middle, LEGEND_SIZE)) / 2;
    return shortened(name, LEGEND_SIZE, most) + middle + shortened(other, LEGEND_SIZE, most);
  });
  const left = MARGIN + (isWide ? Math.max(...texts.map((each) => textWidth(each, LEGEND_SIZE))) + MARGIN : 0);
  return bars.flatMap(({ share, colour }, i) => {
    const y = height + 13 + BAR_LINE * (isWide ? 1 : 1.5) * i;
    const most = Math.min(BAR_WIDTH, MARGIN + room - left);
    const bar = (part: number, fill: string) =>
      `<rect x="${left.toFixed(1)}" y="${isWide ? y - BAR : y + 6}" width="${(part * most).toFixed(1)}" height="${BAR}" fill="${fill}"/>`;
    return [text(MARGIN, y, LEGEND_SIZE, texts[i]!), bar(1, line), bar(share, colour)];
  });
}

function textWidth(text: string, size: number): number {
  const context = document.createElement("canvas").getContext("2d")!;
  context.font = `600 ${size}px ${FONT}`;
  return context.measureText(text).width;
}

function shortened(text: string, size: number, room: number): string {
  if (textWidth(text, size) <= room) return text;
  let end = text.length;
  while (end > 1 && textWidth(`${text.slice(0, end)}…`, size) > room) end -= 1;
  return `${text.slice(0, end).trimEnd()}…`;
}
