// The slice: outlines of all shown gamuts at one lightness or one hue, beside and in the 3-D view.
import { BufferGeometry, Float32BufferAttribute, LineBasicMaterial, LineSegments, type Matrix4 } from "three";
import { niceStep } from "../scene/axes.js";
import { SCREEN, pictureOf } from "../colours/colours.js";
import type { Space } from "../colours/spaces.js";
import type { LevelBuffers } from "../scene/messages.js";
import { type Loop, sectionLoops } from "../scene/sections.js";

const PIXELS = 300;
const MARGIN = 32;
const RASTER = 96;

export interface SlicedGamut {
  level: LevelBuffers;
  space: Space;
}

export interface Slice {
  kind: "lightness" | "hue";
  /** Lightness, or hue in degrees. */
  value: number;
}

/** Bounds of the drawing: horizontal, then vertical. */
export type Frame = [[number, number], [number, number]];

/** Outlines of a level, and their coordinates in the plane of the slice. */
export function outlines(level: LevelBuffers, { kind, value }: Slice, lightness: number): Loop[] {
  const { positions, faces } = level;
  if (kind === "lightness") {
    return sectionLoops(positions, faces, (...point) => point[lightness]! - value);
  }
  const [cos, sin] = direction(value);
  return sectionLoops(positions, faces, (_, a, b) => cos * b - sin * a);
}

/** Coordinates in the plane: a*, b* at a lightness; chroma and lightness at a hue. */
export function planar(loop: Loop, { kind, value }: Slice, lightness: number): [number, number][] {
  const [first, second] = lightness === 0 ? [1, 2] : [0, 2];
  const [cos, sin] = direction(value);
  return Array.from({ length: loop.length / 3 }, (_, i) => {
    const point = loop.subarray(3 * i, 3 * i + 3);
    if (kind === "lightness") return [point[first]!, point[second]!];
    return [cos * point[1]! + sin * point[2]!, point[0]!];
  });
}

/** The colour at a place of the drawing, as fractions from the left and the top; null beside it. */
export function colourAt(
  [across, down]: [number, number],
  { kind, value }: Slice,
  lightness: number,
  [[left, right], [bottom, top]]: Frame,
): [number, number, number] | null {
  const extent = Math.max(right - left, top - bottom) / (PIXELS - 2 * MARGIN);
  const h = left + (across * PIXELS - MARGIN) * extent;
  const v = bottom + (PIXELS - MARGIN - down * PIXELS) * extent;
  if (h < left || h > right || v < bottom || v > top) return null;
  return pointAt([h, v], { kind, value }, lightness);
}

/** The coordinates of a point of the plane. */
function pointAt([h, v]: [number, number], { kind, value }: Slice, lightness: number): [number, number, number] {
  const [cos, sin] = direction(value);
  if (kind === "hue") return [v, h * cos, h * sin];
  return lightness === 0 ? [value, h, v] : [h, value, v];
}

function direction(hue: number): [number, number] {
  const angle = (hue * Math.PI) / 180;
  return [Math.cos(angle), Math.sin(angle)];
}

/** Draw the outlines: the first gamut filled with its colours, the second one dashed. */
export function drawSlice(
  canvas: HTMLCanvasElement,
  gamuts: SlicedGamut[],
  slice: Slice,
  lightness: number,
  frame: Frame,
  names: [string, string],
): Loop[][] {
  const scale = Math.min(devicePixelRatio, 2);
  canvas.width = canvas.height = PIXELS * scale;
  const context = canvas.getContext("2d", { colorSpace: SCREEN })!;
  const { color } = getComputedStyle(canvas);
  context.scale(scale, scale);
  const [[left, right], [bottom, top]] = frame;
  const size = PIXELS - 2 * MARGIN;
  const factor = size / Math.max(right - left, top - bottom);
  const x = (value: number) => MARGIN + (value - left) * factor;
  const y = (value: number) => PIXELS - MARGIN - (value - bottom) * factor;
  drawGrid(context, frame, x, y, color, names);
  context.save();
  context.beginPath();
  context.rect(x(left), y(top), x(right) - x(left), y(bottom) - y(top));
  context.clip();
  const all = gamuts.map(({ level, space }, place) => {
    const loops = outlines(level, slice, lightness);
    const path = new Path2D();
    for (const loop of loops) {
      planar(loop, slice, lightness).forEach(([h, v], i) => (i === 0 ? path.moveTo(x(h), y(v)) : path.lineTo(x(h), y(v))));
      path.closePath();
    }
    if (place === 0) {
      context.save();
      context.clip(path);
      context.drawImage(colours(space, slice, frame), x(left), y(top), x(right) - x(left), y(bottom) - y(top));
      context.restore();
    }
    context.strokeStyle = color;
    context.lineWidth = 1.6;
    context.setLineDash(place === 0 ? [] : [5, 4]);
    context.stroke(path);
    return loops;
  });
  context.restore();
  return all;
}

function drawGrid(
  context: CanvasRenderingContext2D,
  [[left, right], [bottom, top]]: Frame,
  x: (value: number) => number,
  y: (value: number) => number,
  color: string,
  [across, upward]: [string, string],
): void {
  context.strokeStyle = context.fillStyle = color;
  context.font = "11px system-ui, sans-serif";
  const step = niceStep(Math.max(right - left, top - bottom), 5);
  const line = (strength: number, x1: number, y1: number, x2: number, y2: number) => {
    context.globalAlpha = strength;
    context.beginPath();
    context.moveTo(x1, y1);
    context.lineTo(x2, y2);
    context.stroke();
    context.globalAlpha = 1;
  };
  context.textAlign = "center";
  for (let value = Math.ceil(left / step) * step; value <= right; value += step) {
    line(value === 0 ? 0.6 : 0.15, x(value), y(bottom), x(value), y(top));
    context.fillText(plain(value), x(value), PIXELS - 10);
  }
  context.textAlign = "right";
  for (let value = Math.ceil(bottom / step) * step; value <= top; value += step) {
    line(value === 0 ? 0.6 : 0.15, x(left), y(value), x(right), y(value));
    context.fillText(plain(value), MARGIN - 4, y(value) + 4);
  }
  context.font = "bold 12px system-ui, sans-serif";
  context.fillText(across, x(right), y(bottom) - 5);
  context.textAlign = "left";
  context.fillText(upward, x(left) + 5, y(top) + 12);
}

function plain(value: number): string {
  return String(Number(value.toPrecision(4))).replace("-", "−");
}

/** The colours of the whole frame. */
function colours(space: Space, slice: Slice, [[left, right], [bottom, top]]: Frame): OffscreenCanvas {
  const points = new Float32Array(3 * RASTER * RASTER);
  for (let row = 0; row < RASTER; row++) {
    for (let column = 0; column < RASTER; column++) {
      const h = left + ((column + 0.5) / RASTER) * (right - left);
      const v = top - ((row + 0.5) / RASTER) * (top - bottom);
      points.set(pointAt([h, v], slice, space.lightness), 3 * (row * RASTER + column));
    }
  }
  return pictureOf(space.linear(points, SCREEN), RASTER);
}

/** The outlines as lines of the 3-D view; a hue has only the half with its chroma. */
export function sliceLines(all: Loop[][], slice: Slice, turn: Matrix4, colour: string): LineSegments {
  const points: number[] = [];
  const [cos, sin] = direction(slice.value);
  const isShown = (loop: Loop, i: number) =>
    slice.kind === "lightness" || cos * loop[3 * i + 1]! + sin * loop[3 * i + 2]! >= 0;
  for (const loop of all.flat()) {
    const count = loop.length / 3;
    for (let i = 0; i < count; i++) {
      const j = (i + 1) % count;
      if (!isShown(loop, i) || !isShown(loop, j)) continue;
      points.push(...loop.subarray(3 * i, 3 * i + 3), ...loop.subarray(3 * j, 3 * j + 3));
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
  const lines = new LineSegments(geometry, new LineBasicMaterial({ color: colour, depthTest: false }));
  lines.applyMatrix4(turn);
  lines.renderOrder = 2;
  lines.frustumCulled = false;
  return lines;
}
