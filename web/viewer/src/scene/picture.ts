// Pictures of the view in any size, with title, legend and labels: PNG and turntable.
import { SCREEN } from "../colours/colours.js";
import { FONT, type Edges, type Label, TEXT_SIZE } from "./axes.js";
import { escaped } from "../charts/chart.js";
import type { View } from "./scene.js";
import { animatedWebp } from "./webp.js";

/** What a picture has besides the view. */
export interface Picture {
  /** In CSS pixels, and pixels of the picture per CSS pixel. */
  width: number;
  height: number;
  ratio: number;
  title: string;
  /** A line for each gamut, with the CSS colour of its mark. */
  legend: { text: string; colour: string }[];
  note: string;
  /** CSS colours of the text and behind everything. */
  colour: string;
  ground: string;
}

const MARGIN = 16;
const TITLE_SIZE = 16;
const LEGEND_SIZE = 13;
const NOTE_SIZE = 11.5;
const LINE = 18;
/** Time in ms of a whole turn. */
const TURN = 8000;
const QUALITY = 0.9;

/** The view as a PNG file. */
export async function pngPicture(view: View, picture: Picture): Promise<Blob> {
  const context = contextFor(picture);
  await drawOn(context, view, picture, null);
  return encoded(context.canvas, "image/png");
}

/** An animated WebP file in which the gamuts turn around the upright axis once. */
export async function turntable(
  view: View,
  picture: Picture,
  frames: number,
  progress: (part: number) => void,
  signal: AbortSignal,
): Promise<Blob> {
  const context = contextFor(picture);
  const pictures: Uint8Array[] = [];
  for (let i = 0; i < frames; i++) {
    await drawOn(context, view, picture, (2 * Math.PI * i) / frames);
    const frame = await encoded(context.canvas, "image/webp", QUALITY);
    if (frame.type !== "image/webp") throw new Error("This browser cannot write WebP pictures. Chromium and Firefox can.");
    signal.throwIfAborted();
    pictures.push(new Uint8Array(await frame.arrayBuffer()));
    progress((i + 1) / frames);
  }
  return animatedWebp(pictures, context.canvas.width, context.canvas.height, Math.round(TURN / frames));
}

function contextFor({ width, height, ratio }: Picture): CanvasRenderingContext2D {
  const canvas = document.createElement("canvas");
  canvas.width = Math.floor(width * ratio);
  canvas.height = Math.floor(height * ratio);
  const context = canvas.getContext("2d", { alpha: false, colorSpace: SCREEN });
  if (context === null) throw new Error("This browser cannot draw so large a picture. Choose a smaller one.");
  return context;
}

async function drawOn(context: CanvasRenderingContext2D, view: View, picture: Picture, azimuth: number | null): Promise<void> {
  const text = view.at(picture, edges(picture), azimuth, (canvas, labels) => {
    context.drawImage(canvas, 0, 0);
    return drawing(picture, labels, null);
  });
  const image = new Image();
  image.src = `data:image/svg+xml,${encodeURIComponent(text)}`;
  await image.decode();
  context.drawImage(image, 0, 0, context.canvas.width, context.canvas.height);
}

function encoded(canvas: HTMLCanvasElement, type: string, quality?: number): Promise<Blob> {
  return new Promise((resolve, reject) =>
    canvas.toBlob(
      (blob) => (blob === null ? reject(new Error("This browser cannot save so large a picture. Choose a smaller one.")) : resolve(blob)),
      type,
      quality,
    ),
  );
}

/** Room for the texts above and below. */
function edges({ legend, note }: Picture): Edges {
  return { left: 0, right: 0, top: MARGIN + TITLE_SIZE + LINE * legend.length + 6, bottom: note === "" ? 0 : MARGIN + NOTE_SIZE };
}

function drawing({ width, height, ratio, title, legend, note, colour, ground }: Picture, labels: Label[], image: string | null): string {
  const text = (x: number, y: number, size: number, content: string, more = "") =>
    `<text x="${x.toFixed(1)}" y="${y.toFixed(1)}" font-size="${size}"${more}>${escaped(content)}</text>`;
  const room = width - 2 * MARGIN;
  const lines = [
    text(MARGIN, MARGIN + 12, TITLE_SIZE, shortened(title, TITLE_SIZE, room), ' font-weight="600"'),
    ...legend.flatMap((line, i) => {
      const y = MARGIN + 14 + LINE * (i + 1);
      return [
        `<circle cx="${MARGIN + 5}" cy="${y - 4.5}" r="5" fill="${line.colour}" stroke="none"/>`,
        text(MARGIN + LINE, y, LEGEND_SIZE, shortened(line.text, LEGEND_SIZE, room - LINE)),
      ];
    }),
    text(MARGIN, height - MARGIN + 4, NOTE_SIZE, shortened(note, NOTE_SIZE, room)),
  ];
  const marks = labels.map(({ text: content, x, y, meaning }) =>
    text(x, y, TEXT_SIZE, content, ` dy=".35em"${meaning === null ? "" : ' font-weight="600"'}`),
  );
  return [
    `<svg xmlns="http://www.w3.org/2000/svg" width="${width * (image === null ? ratio : 1)}" height="${height * (image === null ? ratio : 1)}" viewBox="0 0 ${width} ${height}">`,
    `<title>${escaped(title)}</title>`,
    image === null ? "" : `<image href="${image}" width="${width}" height="${height}"/>`,
    `<g font-family="${FONT.replaceAll('"', "'")}" fill="${colour}" stroke="${ground}" stroke-width="3.5" stroke-linejoin="round" paint-order="stroke">`,
    ...lines,
    `<g text-anchor="middle">`,
    ...marks,
    "</g></g></svg>",
  ].join("\n");
}

function shortened(text: string, size: number, room: number): string {
  const context = document.createElement("canvas").getContext("2d")!;
  context.font = `600 ${size}px ${FONT}`;
  if (context.measureText(text).width <= room) return text;
  let end = text.length;
  while (end > 1 && context.measureText(`${text.slice(0, end)}…`).width > room) end -= 1;
  return `${text.slice(0, end)}…`;
}
