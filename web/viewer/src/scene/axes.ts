// Axes: a box around the gamuts, whose grid is drawn on the sides behind them, and labels above the canvas.
import {
  Box3,
  BufferGeometry,
  type Camera,
  Float32BufferAttribute,
  Group,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  Vector3,
} from "three";
import { niceStep, numberText } from "../charts/chart.js";

/** Least distances of ticks with labels in pixels: across, and of lines above each other. */
const LEAST_APART = [33, 24] as const;
/** An axis that is shorter on the screen, in pixels, has no labels. */
const LEAST_LENGTH = 24;
export const FONT = 'system-ui, "Segoe UI", Roboto, sans-serif';
export const TEXT_SIZE = 12.5;
/** Half the height of a line of text, with room for the halo. */
const HALF_LINE = 9;
/** Distances in pixels from an edge to its numbers, and from these to the name of the axis. */
const GAP = 7;
const NAME_GAP = 5;
const AXES = [0, 1, 2] as const;

/** One text of the axes, in pixels from the left and the top of the picture. */
export interface Label {
  text: string;
  x: number;
  y: number;
  width: number;
  axis: number;
  /** The sentence of a name; null for a number. */
  meaning: string | null;
}

/** An axis of the box in scene coordinates: x to the right, y up, z towards the viewer. */
export interface Axis {
  name: string;
  /** −1 where the coordinate grows against the scene's direction. */
  sign: 1 | -1;
  /** What the coordinate is. */
  meaning: string;
}

/** The scene axes of a colour space with these coordinates, as `orientation` places them. */
export function sceneAxes(names: readonly string[]): [Axis, Axis, Axis] {
  const axis = (name: string, sign: 1 | -1 = 1): Axis => ({ name, sign, meaning: meaningOf(name) });
  const [first, second, third] = names as [string, string, string];
  return first === "X" ? [axis(first), axis(second), axis(third)] : [axis(second), axis(first), axis(third, -1)];
}

function meaningOf(name: string): string {
  if (/^[XYZ]$/.test(name)) return `${name} tristimulus value relative to the white, whose Y is 1`;
  if (/^(L|J|I)/.test(name)) return `${name}: lightness, without a unit`;
  return `${name}: opponent colour coordinate, without a unit; 0 on the neutral axis`;
}

/** A side of the box: where an axis has its least or largest value. */
interface Side {
  axis: 0 | 1 | 2;
  end: 1 | -1;
  at: number;
  lines: LineSegments;
}

interface Tick {
  text: string;
  at: number;
  /** Number of steps from zero. */
  count: number;
  width: number;
}

export class AxesBox {
  readonly group = new Group();
  private readonly faint: LineBasicMaterial;
  private readonly strong: LineBasicMaterial;
  private readonly sides: Side[] = [];
  private readonly ticks: Tick[][];
  private readonly nameWidths: number[];
  /** Distance of the lines of the grid. */
  readonly step: number;
  /** The box, in scene coordinates. Its ends are multiples of half a step. */
  readonly box = new Box3();

  /** `colour` is that of the lines. */
  constructor(
    readonly axes: readonly [Axis, Axis, Axis],
    gamuts: Box3,
    colour: string,
  ) {
    const size = gamuts.getSize(new Vector3());
    this.step = niceStep(Math.max(size.x, size.y, size.z), 12);
    const half = this.step / 2;
    const toHalves = (value: number, round: (value: number) => number) => half * round(value / half);
    this.box.min.set(...gamuts.min.toArray().map((value) => toHalves(value, (count) => Math.floor(count + 0.02))) as [number, number, number]);
    this.box.max.set(...gamuts.max.toArray().map((value) => toHalves(value, (count) => Math.ceil(count - 0.02))) as [number, number, number]);
    this.faint = new LineBasicMaterial({ color: colour, transparent: true, opacity: 0.16 });
    this.strong = new LineBasicMaterial({ color: colour, transparent: true, opacity: 0.5 });
    this.ticks = AXES.map((axis) => this.ticksOf(axis));
    this.nameWidths = axes.map(({ name }) => textWidth(name, true));
    for (const axis of AXES) for (const end of [-1, 1] as const) this.addSide(axis, end);
  }

  dispose(): void {
    this.group.removeFromParent();
    for (const { lines } of this.sides) {
      for (const part of [lines, ...(lines.children as LineSegments[])]) part.geometry.dispose();
    }
    this.faint.dispose();
    this.strong.dispose();
  }

  private ticksOf(axis: 0 | 1 | 2): Tick[] {
    const { sign } = this.axes[axis];
    const { step } = this;
    const [low, high] = [this.box.min.getComponent(axis), this.box.max.getComponent(axis)];
    const ticks: Tick[] = [];
    for (let count = Math.ceil(low / step - 1e-6); count * step <= high + 1e-6 * step; count++) {
      const text = numberText(sign * count * step);
      ticks.push({ text, at: count * step, count, width: textWidth(text, false) });
    }
    return ticks;
  }

  /** Grid of the side of the box where an axis has its least (−1) or largest (1) value. */
  private addSide(axis: 0 | 1 | 2, end: 1 | -1): void {
    const { min, max } = this.box;
    const at = (end < 0 ? min : max).getComponent(axis);
    const [across, up] = AXES.filter((other) => other !== axis) as [0 | 1 | 2, 0 | 1 | 2];
    const point = (first: number, second: number) =>
      new Vector3()
        .setComponent(axis, at)
        .setComponent(across, first)
        .setComponent(up, second)
        .toArray();
    const [left, right] = [min.getComponent(across), max.getComponent(across)];
    const [bottom, top] = [min.getComponent(up), max.getComponent(up)];
    const grid = [
      ...this.ticks[across]!.flatMap((tick) => [...point(tick.at, bottom), ...point(tick.at, top)]),
      ...this.ticks[up]!.flatMap((tick) => [...point(left, tick.at), ...point(right, tick.at)]),
    ];
    const corners = [point(left, bottom), point(right, bottom), point(right, top), point(left, top)];
    const frame = corners.flatMap((corner, i) => [...corner, ...corners[(i + 1) % 4]!]);
    const lines = segments(grid, this.faint);
    lines.add(segments(frame, this.strong));
    this.sides.push({ axis, end, at, lines });
    this.group.add(lines);
  }

  /** Show the sides that face away from the viewer. */
  turnTo(camera: Camera): void {
    const isParallel = "isOrthographicCamera" in camera;
    const place = isParallel ? camera.getWorldDirection(new Vector3()).negate() : camera.position;
    for (const { axis, end, at, lines } of this.sides) {
      lines.visible = end * (place.getComponent(axis) - (isParallel ? 0 : at)) < 0;
    }
  }

  /** Labels for a picture of a size. None overlaps another one or leaves the `free` part of it. */
  labels(camera: Camera, width: number, height: number, free: Edges): Label[] {
    const project = projection(camera, width, height);
    const middle = project(this.box.getCenter(new Vector3()));
    const names: Label[] = [];
    const ends: Label[] = [];
    const between: Label[] = [];
    for (const axis of AXES) {
      const edge = this.labelledEdge(axis, project, middle);
      if (edge === null) continue;
      const { outward, at, length } = edge;
      const ticks = this.ticks[axis]!;
      const span = this.box.max.getComponent(axis) - this.box.min.getComponent(axis);
      const along = Math.abs(outward[0]) > Math.abs(outward[1]);
      const stride = strideOf((length / span) * this.step, LEAST_APART[along ? 1 : 0]);
      const shown = ticks.filter(({ count }) => count % stride === 0);
      const reach = (label: number) => Math.abs(outward[0]) * label * 0.5 + Math.abs(outward[1]) * TEXT_SIZE * 0.5;
      const place = (value: number, away: number): [number, number] => {
        const [x, y] = at(value);
        return [x + away * outward[0], y + away * outward[1]];
      };
      shown.forEach(({ text, at: value, width: wide }, i) => {
        const [x, y] = place(value, GAP + reach(wide));
        (i === 0 || i === shown.length - 1 ? ends : between).push({ text, x, y, width: wide, axis, meaning: null });
      });
      const widest = Math.max(0, ...shown.map((tick) => tick.width));
      const wide = this.nameWidths[axis]!;
      const { name: text, meaning } = this.axes[axis];
      const centre = (this.box.max.getComponent(axis) + this.box.min.getComponent(axis)) / 2;
      const [x, y] = place(centre, GAP + 2 * reach(widest) + NAME_GAP + reach(wide));
      const within = (value: number, low: number, high: number) => Math.min(Math.max(value, low), Math.max(low, high));
      names.push({
        text,
        x: within(x, free.left + wide / 2 + 3, width - free.right - wide / 2 - 3),
        y: within(y, free.top + HALF_LINE, height - free.bottom - HALF_LINE),
        width: wide,
        axis,
        meaning,
      });
    }
    return withoutOverlaps([...names, ...ends, ...between], width, height, free);
  }

  /**
   * The edge of the box at which an axis has its labels: on the outline of the box, lowest or leftmost.
   *
   * `outward` points away from the box, in pixels; `at` gives the place of a coordinate.
   */
  private labelledEdge(axis: 0 | 1 | 2, project: Projection, middle: Point) {
    const [first, second] = AXES.filter((other) => other !== axis) as [0 | 1 | 2, 0 | 1 | 2];
    const visible = (side: 0 | 1 | 2, end: number) => this.sides[2 * side + (end < 0 ? 0 : 1)]!.lines.visible;
    let best: { score: number; from: Vector3; to: Vector3; outward: Point; length: number } | null = null;
    for (const one of [-1, 1]) {
      for (const other of [-1, 1]) {
        // An edge between a side that is drawn and one that is not is on the outline.
        if (visible(first, one) === visible(second, other)) continue;
        const corner = (end: number) =>
          new Vector3()
            .setComponent(axis, (end < 0 ? this.box.min : this.box.max).getComponent(axis))
            .setComponent(first, (one < 0 ? this.box.min : this.box.max).getComponent(first))
            .setComponent(second, (other < 0 ? this.box.min : this.box.max).getComponent(second));
        const [from, to] = [corner(-1), corner(1)];
        const [a, b] = [project(from), project(to)];
        const along: Point = [b[0] - a[0], b[1] - a[1]];
        const length = Math.hypot(...along);
        if (length < LEAST_LENGTH) continue;
        let outward: Point = [along[1] / length, -along[0] / length];
        const out = (a[0] - middle[0]) * outward[0] + (a[1] - middle[1]) * outward[1];
        if (out < 0) outward = [-outward[0], -outward[1]];
        const score = outward[1] - (axis === 1 ? 2 : 0.1) * outward[0];
        if (best === null || score > best.score) best = { score, from, to, outward, length };
      }
    }
    if (best === null) return null;
    const { from, to, outward, length } = best;
    const at = (value: number): Point => {
      const point = from.clone();
      return project(point.setComponent(axis, Math.min(Math.max(value, from.getComponent(axis)), to.getComponent(axis))));
    };
    return { outward, length, at };
  }
}

type Point = [number, number];
type Projection = (point: Vector3) => Point;

/** Widths in pixels of what covers the picture at its edges. */
export interface Edges {
  left: number;
  top: number;
  right: number;
  bottom: number;
}

/** Room in pixels that labels need beside the box. */
export const LABEL_ROOM: Edges = { left: 56, top: 14, right: 44, bottom: 42 };

function projection(camera: Camera, width: number, height: number): Projection {
  const matrix = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  const place = new Vector3();
  return (point) => {
    place.copy(point).applyMatrix4(matrix);
    return [((place.x + 1) * width) / 2, ((1 - place.y) * height) / 2];
  };
}

/** Every how many ticks have a label, so that they are some pixels apart. */
function strideOf(pixels: number, least: number): number {
  return [1, 2, 5, 10, 20].find((stride) => stride * pixels >= least) ?? 50;
}

function withoutOverlaps(labels: Label[], width: number, height: number, free: Edges): Label[] {
  const kept: Label[] = [];
  for (const label of labels) {
    const { x, y } = label;
    const half = label.width / 2;
    const fits =
      x - half >= free.left + 2 && x + half <= width - free.right - 2 &&
      y - HALF_LINE >= free.top && y + HALF_LINE <= height - free.bottom;
    const meets = kept.some(
      (other) => Math.abs(other.x - x) < half + other.width / 2 + 4 && Math.abs(other.y - y) < 2 * HALF_LINE - 2,
    );
    if (fits && !meets) kept.push(label);
  }
  return kept;
}


let measure: CanvasRenderingContext2D | null = null;

function textWidth(text: string, isName: boolean): number {
  measure ??= document.createElement("canvas").getContext("2d")!;
  measure.font = `${isName ? 600 : 400} ${TEXT_SIZE}px ${FONT}`;
  return measure.measureText(text).width;
}

function segments(points: number[], material: LineBasicMaterial): LineSegments {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
  return new LineSegments(geometry, material);
}

const SVG = "http://www.w3.org/2000/svg";

/** The labels above the canvas. Nodes are used again from picture to picture. */
export class LabelLayer {
  readonly element = document.createElementNS(SVG, "svg");
  private readonly nodes = new Map<string, SVGTextElement>();

  constructor() {
    this.element.setAttribute("class", "labels");
    this.element.setAttribute("aria-hidden", "true");
  }

  clear(): void {
    this.element.replaceChildren();
    this.nodes.clear();
  }

  show(labels: Label[]): void {
    const unused = new Set(this.nodes.values());
    for (const { text, x, y, axis, meaning } of labels) {
      const key = `${axis} ${text}`;
      const node = this.nodes.get(key) ?? this.add(key, text, meaning);
      node.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)})`);
      node.removeAttribute("display");
      unused.delete(node);
    }
    for (const node of unused) node.setAttribute("display", "none");
  }

  private add(key: string, text: string, meaning: string | null): SVGTextElement {
    const node = document.createElementNS(SVG, "text");
    node.setAttribute("dy", ".35em");
    node.textContent = text;
    if (meaning !== null) {
      node.setAttribute("class", "name");
      const title = document.createElementNS(SVG, "title");
      title.textContent = meaning;
      node.append(title);
    }
    this.nodes.set(key, node);
    this.element.append(node);
    return node;
  }
}
