// Sections of a level by a plane, found from the triangles that are shown.

/** A closed outline: x, y, z of its points. */
export type Loop = Float32Array;

/**
 * Return the closed outlines of the section where a height is 0.
 *
 * The mesh is closed and oriented, so each face that is cut has one edge that leads down and one
 * that leads up, and the outline passes from face to face over them. Height 0 counts as above.
 */
export function sectionLoops(
  positions: Float32Array,
  faces: Int32Array,
  height: (x: number, y: number, z: number) => number,
): Loop[] {
  const count = positions.length / 3;
  const heights = new Float64Array(count);
  for (let i = 0; i < count; i++) {
    heights[i] = height(positions[3 * i]!, positions[3 * i + 1]!, positions[3 * i + 2]!);
  }
  const key = (from: number, to: number) => Math.min(from, to) * count + Math.max(from, to);
  const next = new Map<number, number>();
  for (let face = 0; face < faces.length; face += 3) {
    let down = -1;
    let up = -1;
    for (let corner = 0; corner < 3; corner++) {
      const from = faces[face + corner]!;
      const to = faces[face + ((corner + 1) % 3)]!;
      const isAbove = heights[from]! >= 0;
      if (isAbove === heights[to]! >= 0) continue;
      if (isAbove) down = key(from, to);
      else up = key(from, to);
    }
    if (down >= 0) next.set(down, up);
  }
  const loops: Loop[] = [];
  for (let start = next.keys().next(); !start.done; start = next.keys().next()) {
    const edges: number[] = [];
    for (let edge = start.value; next.has(edge); ) {
      edges.push(edge);
      const following = next.get(edge)!;
      next.delete(edge);
      edge = following;
    }
    const loop = new Float32Array(3 * edges.length);
    edges.forEach((edge, place) => {
      const from = Math.floor(edge / count);
      const to = edge % count;
      const t = heights[from]! / (heights[from]! - heights[to]!);
      for (let axis = 0; axis < 3; axis++) {
        const begin = positions[3 * from + axis]!;
        loop[3 * place + axis] = begin + t * (positions[3 * to + axis]! - begin);
      }
    });
    loops.push(loop);
  }
  return loops;
}

export type Point = [number, number, number];
/** Coordinates in a plane: to the right, and upwards. */
export type Place = [number, number];

/** A plane with coordinates of its own; all three directions are unit vectors, `normal` is right × up. */
export interface SectionPlane {
  origin: Point;
  normal: Point;
  right: Point;
  up: Point;
}

/** What a plane cuts at: a lightness, or a hue in degrees. */
export interface Cut {
  kind: "lightness" | "hue";
  value: number;
}

/** Return the plane of a cut, in the coordinates of a space whose lightness is the axis `lightness`. */
export function planeOf(cut: Cut, lightness: number): SectionPlane {
  const [first, second] = lightness === 0 ? [1, 2] : [0, 2];
  const vector = (light: number, a: number, b: number): Point => {
    const made: Point = [0, 0, 0];
    made[lightness] = light;
    made[first] = a;
    made[second] = b;
    return made;
  };
  if (cut.kind === "lightness") {
    return withNormal(vector(cut.value, 0, 0), vector(0, 1, 0), vector(0, 0, 1));
  }
  const [cos, sin] = direction(cut.value);
  return withNormal([0, 0, 0], vector(0, cos, sin), vector(1, 0, 0));
}

/** Height of a point above a plane. */
export function heightAbove({ origin, normal }: SectionPlane): (x: number, y: number, z: number) => number {
  const [a, b, c] = normal;
  const offset = a * origin[0] + b * origin[1] + c * origin[2];
  return (x, y, z) => a * x + b * y + c * z - offset;
}

/** The coordinates in a plane of points, three numbers each. */
export function placesIn({ origin, right, up }: SectionPlane, points: ArrayLike<number>): Place[] {
  return Array.from({ length: points.length / 3 }, (_, i) => {
    const [x, y, z] = [0, 1, 2].map((axis) => points[3 * i + axis]! - origin[axis]!) as Point;
    return [x * right[0] + y * right[1] + z * right[2], x * up[0] + y * up[1] + z * up[2]];
  });
}

/** The point of the space at a place of a plane. */
export function pointAt({ origin, right, up }: SectionPlane, [h, v]: Place): Point {
  return origin.map((value, axis) => value + h * right[axis]! + v * up[axis]!) as Point;
}

/** The part of a closed outline to the right of the neutral axis (Sutherland and Hodgman, 1974). */
export function rightHalf(outline: Place[]): Place[] {
  return outline.flatMap((place, i) => {
    const [h, v] = place;
    const [x, y] = outline.at(i - 1)!;
    const crossing: Place[] = h >= 0 === x >= 0 ? [] : [[0, y + ((v - y) * x) / (x - h)]];
    return h >= 0 ? [...crossing, place] : crossing;
  });
}

/** The area within closed outlines of one section: holes run the other way round. */
export function areaWithin(outlines: Place[][]): number {
  const signed = outlines.map((outline) =>
    outline.reduce((sum, [h, v], i) => {
      const [x, y] = outline.at(i - 1)!;
      return sum + (x * v - h * y) / 2;
    }, 0),
  );
  return Math.abs(signed.reduce((sum, area) => sum + area, 0));
}

/** Outlines in groups: each outer one is followed by its holes, by the even-odd rule. */
export function nested(outlines: Place[][]): Place[][][] {
  const around = outlines.map((inner) => outlines.filter((outer) => outer !== inner && isWithin(inner[0]!, outer)));
  const groups = new Map(outlines.filter((_, i) => around[i]!.length % 2 === 0).map((outer) => [outer, [outer]]));
  outlines.forEach((outline, i) => {
    if (groups.has(outline)) return;
    // The innermost of the outer ones around a hole is itself within all others.
    const depth = (outer: Place[]) => around[outlines.indexOf(outer)]!.length;
    const outer = around[i]!.filter((each) => groups.has(each)).sort((a, b) => depth(b) - depth(a))[0];
    if (outer !== undefined) groups.get(outer)!.push(outline);
  });
  return [...groups.values()];
}

function isWithin([h, v]: Place, outline: Place[]): boolean {
  return outline.reduce((inside, [x, y], i) => {
    const [x0, y0] = outline.at(i - 1)!;
    return v < y === v < y0 || h > x0 + ((v - y0) * (x - x0)) / (y - y0) ? inside : !inside;
  }, false);
}

function withNormal(origin: Point, right: Point, up: Point): SectionPlane {
  return { origin, right, up, normal: cross(right, up) };
}

function cross([a, b, c]: Point, [x, y, z]: Point): Point {
  return [b * z - c * y, c * x - a * z, a * y - b * x];
}

function direction(degrees: number): [number, number] {
  const angle = (degrees * Math.PI) / 180;
  return [Math.cos(angle), Math.sin(angle)];
}
