// Questions about colours that a level of a gamut answers.
import { Cones, WIDTH } from "./cones.js";
import type { History } from "./history.js";
import { FaceTree, type Line } from "./tree.js";

/** Three coordinates in the colour space of the gamut; L, a, b in CIELAB. */
export type Colour = ArrayLike<number>;

/** Where colours out of gamut go: to the nearest point, towards the centre, or to another chroma. */
export type ClipMethod = "nearest" | "centre" | "chroma";

/** From the smallest to the largest chroma. */
export type Interval = [from: number, to: number];

/** Part of the size of the gamut by which clipped colours are moved inwards: far above rounding. */
const INWARDS = 2 ** -40;

/** Distance from the middle of a cell of a grid to its corner ÷ the size of the cell. */
const GRID_CORNER = Math.sqrt(3) / 2;

/**
 * A closed surface around a gamut that its centre sees from inside: a level of a history.
 *
 * Numbers are those of the space of the gamut. Chroma and hue are for spaces whose first coordinate is
 * lightness. Questions allocate nothing but their results.
 */
export class Boundary {
  /** Volume in cubic units of the space. */
  readonly volume: number;
  readonly triangles: number;
  private readonly cones: Cones;
  private tree: FaceTree | null = null;
  private readonly corners: Float64Array;
  /** Squares of distances from the centre: no surface is nearer, and none is farther. */
  private readonly inner: number;
  private readonly outer: number;
  private ends: Float64Array | null = null;

  /**
   * `tolerance` is the default of `contains`.
   *
   * A `RangeError` says which face the centre does not see from its inner side.
   */
  constructor(
    { positions, faces }: { positions: ArrayLike<number>; faces: ArrayLike<number> },
    readonly centre: readonly [number, number, number],
    readonly tolerance = 0,
  ) {
    const corners = new Float64Array(3 * faces.length);
    for (let i = 0; i < corners.length; i++) {
      corners[i] = positions[3 * faces[Math.floor(i / 3)]! + (i % 3)]! - centre[i % 3]!;
    }
    this.corners = corners;
    this.triangles = faces.length / 3;
    this.cones = new Cones(corners);
    this.volume = this.cones.volume;
    let [inner, outer] = [Infinity, 0];
    for (let face = 0; face < this.triangles; face++) {
      const at = WIDTH * face + 9;
      const { planes } = this.cones;
      inner = Math.min(inner, 1 / (planes[at]! ** 2 + planes[at + 1]! ** 2 + planes[at + 2]! ** 2));
    }
    for (let i = 0; i < corners.length; i += 3) {
      outer = Math.max(outer, corners[i]! ** 2 + corners[i + 1]! ** 2 + corners[i + 2]! ** 2);
    }
    this.inner = inner * (1 - INWARDS);
    this.outer = outer * (1 + INWARDS);
  }

  /**
   * The boundary at a level of a history: by default the present one.
   *
   * Its tolerance is the error of the level and of the full boundary, where the history states them:
   * a colour that the device can make is not farther outside.
   */
  static of(history: History, triangles?: number): Boundary {
    if (triangles !== undefined) history.refineTo(triangles);
    return new Boundary(history.level, history.header.centre, toleranceOf(history));
  }

  /** Whether a colour is in gamut: inside or on the surface, or outside by `tolerance` at most. */
  contains(colour: Colour, tolerance = this.tolerance): boolean {
    const [cx, cy, cz] = this.centre;
    const [x, y, z] = [colour[0]! - cx, colour[1]! - cy, colour[2]! - cz];
    if (this.height(x, y, z) <= 1) return true;
    if (!(tolerance > 0)) return false;
    const reach = Math.sqrt(this.outer) + tolerance;
    if (x * x + y * y + z * z > reach * reach) return false;
    const limit = tolerance * tolerance * (1 + INWARDS); // the search finds what is nearer
    return this.faces.search(x, y, z, limit) < limit;
  }

  /** Distance of a colour from the surface, negative inside. */
  distance(colour: Colour): number {
    const [cx, cy, cz] = this.centre;
    const [x, y, z] = [colour[0]! - cx, colour[1]! - cy, colour[2]! - cz];
    const isInside = this.height(x, y, z) <= 1;
    const distance = Math.sqrt(this.faces.search(x, y, z, Infinity));
    return isInside ? -distance : distance;
  }

  /** The point of the surface that is nearest to a colour. `out` takes the result, if it is given. */
  nearest(colour: Colour, out?: Float64Array): Float64Array {
    const [cx, cy, cz] = this.centre;
    const [x, y, z] = [colour[0]! - cx, colour[1]! - cy, colour[2]! - cz];
    check(x, y, z);
    const { point } = this.faces;
    this.faces.search(x, y, z, Infinity);
    return filled(out, point[0]! + cx, point[1]! + cy, point[2]! + cz);
  }

  /**
   * A colour in gamut. Colours that are in gamut stay as they are; others go
   *
   * - `nearest`: to the nearest point,
   * - `centre`: along the line to the centre, up to the surface,
   * - `chroma`: at their hue and lightness to the largest chroma below their own, or else to the
   *   smallest one. Lighter and darker colours go to the end of the neutral axis. Where the gamut has
   *   neither, `nearest` applies.
   *
   * `contains` is true for the result, with a tolerance of 0.
   */
  clip(colour: Colour, method: ClipMethod = "nearest", out?: Float64Array): Float64Array {
    const [cx, cy, cz] = this.centre;
    const [x, y, z] = [colour[0]! - cx, colour[1]! - cy, colour[2]! - cz];
    const height = this.height(x, y, z);
    if (height <= 1) return filled(out, colour[0]!, colour[1]!, colour[2]!);
    if (method === "centre") return this.inwards(x / height, y / height, z / height, out);
    if (method === "chroma") {
      const clipped = this.atHue(colour[0]!, colour[1]!, colour[2]!, out);
      if (clipped !== null) return clipped;
    } else if (method !== "nearest") throw new RangeError(`there is no method ${String(method)}`);
    const { point } = this.faces;
    this.faces.search(x, y, z, Infinity);
    return this.inwards(point[0]!, point[1]!, point[2]!, out);
  }

  /** Intervals of chroma at a lightness and a hue in degrees: several where the gamut is concave. */
  chroma(lightness: number, hue: number): Interval[] {
    const angle = (hue * Math.PI) / 180;
    return this.intervals(lightness, Math.cos(angle), Math.sin(angle));
  }

  private get faces(): FaceTree {
    return (this.tree ??= new FaceTree(this.corners));
  }

  /** Distance from the centre ÷ that of the surface in the same direction; 0 in the inner ball. */
  private height(x: number, y: number, z: number): number {
    const square = x * x + y * y + z * z;
    if (square < this.inner) return 0;
    check(x, y, z);
    const { planes } = this.cones;
    const at = WIDTH * this.cones.faceTowards(x, y, z) + 9;
    return planes[at]! * x + planes[at + 1]! * y + planes[at + 2]! * z;
  }

  /** A point of the surface, a little nearer to the centre. */
  private inwards(x: number, y: number, z: number, out?: Float64Array): Float64Array {
    const [cx, cy, cz] = this.centre;
    const part = 1 - INWARDS;
    return filled(out, cx + part * x, cy + part * y, cz + part * z);
  }

  private intervals(lightness: number, cosine: number, sine: number): Interval[] {
    const [cx, cy, cz] = this.centre;
    check(lightness, cosine, sine);
    const crossings = this.faces.crossings({
      origin: [lightness - cx, -cy, -cz],
      direction: [0, cosine, sine],
      sideways: [1, 0, 0],
      upwards: [0, -sine, cosine],
    });
    const found: Interval[] = [];
    for (let i = 0; i + 1 < crossings.length; i += 2) {
      const [from, to] = [crossings[i]!, crossings[i + 1]!];
      if (to >= 0) found.push([Math.max(0, from), to]);
    }
    return found;
  }

  /** Lightness at the ends of the neutral axis in gamut; NaN if the axis is not. */
  private get axis(): Float64Array {
    if (this.ends !== null) return this.ends;
    const [cx, cy, cz] = this.centre;
    const line: Line = { origin: [-cx, -cy, -cz], direction: [1, 0, 0], sideways: [0, 1, 0], upwards: [0, 0, 1] };
    const found = this.faces.crossings(line);
    this.ends = Float64Array.of(found[0] ?? NaN, found.at(-1) ?? NaN);
    return this.ends;
  }

  private atHue(lightness: number, a: number, b: number, out?: Float64Array): Float64Array | null {
    const inwards = INWARDS * Math.sqrt(this.outer);
    const [low, high] = [this.axis[0]!, this.axis[1]!];
    if (lightness > high) return filled(out, high - inwards, 0, 0);
    if (lightness < low) return filled(out, low + inwards, 0, 0);
    const chroma = Math.hypot(a, b);
    if (chroma === 0) return null;
    const intervals = this.intervals(lightness, a / chroma, b / chroma);
    const below = intervals.findLast(([, to]) => to <= chroma);
    const [from, to] = below ?? intervals[0] ?? [NaN, NaN];
    const step = Math.min(inwards, (to - from) / 2);
    const target = below === undefined ? from + step : to - step;
    if (!(target >= 0)) return null;
    return filled(out, lightness, (a / chroma) * target, (b / chroma) * target);
  }
}

function filled(out: Float64Array | undefined, x: number, y: number, z: number): Float64Array {
  const point = out ?? new Float64Array(3);
  point[0] = x;
  point[1] = y;
  point[2] = z;
  return point;
}

function check(x: number, y: number, z: number): void {
  if (!(Math.abs(x) + Math.abs(y) + Math.abs(z) < Infinity)) {
    throw new RangeError("a colour must be three finite numbers");
  }
}

/** The distance of the present level from the device's own colours, as far as the history states it. */
function toleranceOf({ header, triangles }: History): number {
  const { levels = [], boundary_error: missed = 0 } = (header.gamut ?? {}) as {
    levels?: { triangles: number; distance_bound: number }[];
    boundary_error?: number;
  };
  const level = levels.findLast((each) => each.triangles <= triangles);
  return (level?.distance_bound ?? 0) + missed + GRID_CORNER * header.step;
}
