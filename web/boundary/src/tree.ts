// A binary tree of boxes around the faces: nearest points, and crossings with a line.

const LEAF = 4;
const MOST_DEPTH = 64;

/** Square of the sine of an angle below which rounding errors leave the normal of a triangle open. */
const THIN = 1e-12;

/** A line through a point. The three directions are perpendicular unit vectors. */
export interface Line {
  origin: readonly [number, number, number];
  direction: readonly [number, number, number];
  sideways: readonly [number, number, number];
  upwards: readonly [number, number, number];
}

/** The faces of a closed mesh, in a tree whose nodes halve them along the longest side of their box. */
export class FaceTree {
  /** The nearest point that `search` found, relative to the centre. */
  readonly point = new Float64Array(3);
  /** The corners of each face, nine numbers, in the order of the leaves. */
  private readonly corners: Float64Array;
  /** Least coordinates, then largest ones, of each node. */
  private readonly boxes: Float64Array;
  /** The second child of a node, the first one being the next node; −1 − the first face of a leaf. */
  private readonly children: Int32Array;
  /** The end of the faces of a leaf. */
  private readonly ends: Int32Array;
  private readonly nodes = new Int32Array(MOST_DEPTH);
  private readonly bounds = new Float64Array(MOST_DEPTH);

  constructor(triangles: Float64Array) {
    const count = triangles.length / 9;
    const order = Int32Array.from({ length: count }, (_, face) => face);
    const middles = new Float64Array(3 * count);
    for (let i = 0; i < triangles.length; i++) middles[3 * Math.floor(i / 9) + (i % 3)]! += triangles[i]!;
    const [boxes, children, ends]: number[][] = [[], [], []];
    const build = (first: number, last: number): void => {
      const node = children!.length;
      const box = boxAround(triangles, order.subarray(first, last));
      boxes!.push(...box);
      children!.push(-1 - first);
      ends!.push(last);
      if (last - first <= LEAF) return;
      const sizes = [0, 1, 2].map((axis) => box[3 + axis]! - box[axis]!);
      const middle = (first + last) >> 1;
      select(order, middles, sizes.indexOf(Math.max(...sizes)), first, last - 1, middle);
      build(first, middle);
      children![node] = children!.length;
      build(middle, last);
    };
    build(0, count);
    this.boxes = Float64Array.from(boxes!);
    this.children = Int32Array.from(children!);
    this.ends = Int32Array.from(ends!);
    this.corners = new Float64Array(triangles.length);
    order.forEach((face, place) => this.corners.set(triangles.subarray(9 * face, 9 * face + 9), 9 * place));
  }

  /**
   * Return the squared distance of the nearest point, which is in `point` then.
   *
   * It is `limit` if no point is nearer than its root.
   */
  search(x: number, y: number, z: number, limit: number): number {
    const { nodes, bounds, boxes, children, ends, corners, point } = this;
    let best = limit;
    let height = 1;
    nodes[0] = bounds[0] = 0;
    while (height > 0) {
      height -= 1;
      if (bounds[height]! >= best) continue;
      const node = nodes[height]!;
      const second = children[node]!;
      if (second < 0) {
        for (let at = 9 * (-1 - second); at < 9 * ends[node]!; at += 9) best = closer(corners, at, x, y, z, best, point);
        continue;
      }
      const one = squareOutside(boxes, node + 1, x, y, z);
      const two = squareOutside(boxes, second, x, y, z);
      const isFirst = one <= two; // the nearer child is on top
      nodes[height] = isFirst ? second : node + 1;
      bounds[height] = isFirst ? two : one;
      nodes[height + 1] = isFirst ? node + 1 : second;
      bounds[height + 1] = isFirst ? one : two;
      height += 2;
    }
    return best;
  }

  /** Return where a line crosses the surface, in ascending order: distances from its origin. */
  crossings({ origin, direction, sideways, upwards }: Line): Float64Array {
    const { nodes, boxes, children, ends, corners } = this;
    const found: number[] = [];
    // of the corners of a face: sideways, upwards, along the line
    const seen = new Float64Array(9);
    let height = 1;
    nodes[0] = 0;
    while (height > 0) {
      height -= 1;
      const node = nodes[height]!;
      if (!reaches(boxes, node, origin, sideways) || !reaches(boxes, node, origin, upwards)) continue;
      const second = children[node]!;
      if (second >= 0) {
        nodes[height++] = second;
        nodes[height++] = node + 1;
        continue;
      }
      for (let at = 9 * (-1 - second); at < 9 * ends[node]!; at += 9) {
        for (let corner = 0; corner < 9; corner += 3) {
          seen[corner] = component(corners, at + corner, origin, sideways);
          seen[corner + 1] = component(corners, at + corner, origin, upwards);
          seen[corner + 2] = component(corners, at + corner, origin, direction);
        }
        const place = crossing(seen);
        if (place === place) found.push(place);
      }
    }
    return Float64Array.from(found).sort();
  }
}

function boxAround(triangles: Float64Array, faces: Int32Array): Float64Array {
  const box = Float64Array.of(Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity);
  for (const face of faces) {
    for (let i = 0; i < 9; i++) {
      const value = triangles[9 * face + i]!;
      const axis = i % 3;
      if (value < box[axis]!) box[axis] = value;
      if (value > box[3 + axis]!) box[3 + axis] = value;
    }
  }
  return box;
}

/** Order faces such that the one at `place` has its rank along an axis (C. A. R. Hoare, 1961). */
function select(order: Int32Array, middles: Float64Array, axis: number, first: number, last: number, place: number): void {
  const key = (at: number) => middles[3 * order[at]! + axis]!;
  while (first < last) {
    const pivot = key((first + last) >> 1);
    let [low, high] = [first, last];
    while (low <= high) {
      while (key(low) < pivot) low += 1;
      while (key(high) > pivot) high -= 1;
      if (low > high) break;
      [order[low], order[high]] = [order[high]!, order[low]!];
      low += 1;
      high -= 1;
    }
    if (place <= high) last = high;
    else if (place >= low) first = low;
    else return;
  }
}

function squareOutside(boxes: Float64Array, node: number, x: number, y: number, z: number): number {
  const at = 6 * node;
  const dx = x < boxes[at]! ? boxes[at]! - x : x > boxes[at + 3]! ? x - boxes[at + 3]! : 0;
  const dy = y < boxes[at + 1]! ? boxes[at + 1]! - y : y > boxes[at + 4]! ? y - boxes[at + 4]! : 0;
  const dz = z < boxes[at + 2]! ? boxes[at + 2]! - z : z > boxes[at + 5]! ? z - boxes[at + 5]! : 0;
  return dx * dx + dy * dy + dz * dz;
}

/**
 * Return the squared distance of a point from a triangle if it is less than `best`, else `best`.
 *
 * The region of the point is found as in C. Ericson, "Real-Time Collision Detection" (2005), 5.1.5,
 * except that a point beside the triangle is projected on all edges: that is right for thin ones.
 */
function closer(
  corners: Float64Array,
  at: number,
  x: number,
  y: number,
  z: number,
  best: number,
  point: Float64Array,
): number {
  const ax = corners[at]!;
  const ay = corners[at + 1]!;
  const az = corners[at + 2]!;
  const bx = corners[at + 3]! - ax;
  const by = corners[at + 4]! - ay;
  const bz = corners[at + 5]! - az;
  const cx = corners[at + 6]! - ax;
  const cy = corners[at + 7]! - ay;
  const cz = corners[at + 8]! - az;
  const px = x - ax;
  const py = y - ay;
  const pz = z - az;
  const nx = by * cz - bz * cy;
  const ny = bz * cx - bx * cz;
  const nz = bx * cy - by * cx;
  const whole = nx * nx + ny * ny + nz * nz;
  const bb = bx * bx + by * by + bz * bz;
  const cc = cx * cx + cy * cy + cz * cz;
  const isThin = whole <= THIN * bb * cc;
  const off = nx * px + ny * py + nz * pz;
  if (off * off >= best * whole && !isThin) return best; // the plane is farther
  const u = nx * (py * cz - pz * cy) + ny * (pz * cx - px * cz) + nz * (px * cy - py * cx);
  const v = nx * (by * pz - bz * py) + ny * (bz * px - bx * pz) + nz * (bx * py - by * px);
  if (u >= 0 && v >= 0 && u + v <= whole && whole > 0) {
    const h = u / whole;
    const k = v / whole;
    best = nearer(x, y, z, ax + h * bx + k * cx, ay + h * by + k * cy, az + h * bz + k * cz, best, point);
    if (!isThin) return best;
  }
  let t = share(px * bx + py * by + pz * bz, bb);
  best = nearer(x, y, z, ax + t * bx, ay + t * by, az + t * bz, best, point);
  t = share(px * cx + py * cy + pz * cz, cc);
  best = nearer(x, y, z, ax + t * cx, ay + t * cy, az + t * cz, best, point);
  const ex = cx - bx;
  const ey = cy - by;
  const ez = cz - bz;
  t = share((px - bx) * ex + (py - by) * ey + (pz - bz) * ez, ex * ex + ey * ey + ez * ez);
  return nearer(x, y, z, ax + bx + t * ex, ay + by + t * ey, az + bz + t * ez, best, point);
}

function share(part: number, whole: number): number {
  return part > 0 ? (part < whole ? part / whole : 1) : 0;
}

function nearer(x: number, y: number, z: number, u: number, v: number, w: number, best: number, point: Float64Array): number {
  const square = (x - u) * (x - u) + (y - v) * (y - v) + (z - w) * (z - w);
  if (square >= best) return best;
  point[0] = u;
  point[1] = v;
  point[2] = w;
  return square;
}

type Vector = Line["origin"];

function component(corners: Float64Array, at: number, [x, y, z]: Vector, [u, v, w]: Vector): number {
  return (corners[at]! - x) * u + (corners[at + 1]! - y) * v + (corners[at + 2]! - z) * w;
}

/** Whether the interval of a box along a direction holds 0, within rounding. */
function reaches(boxes: Float64Array, node: number, origin: Vector, along: Vector): boolean {
  let [middle, half, scale] = [0, 0, 0];
  for (let axis = 0; axis < 3; axis++) {
    const low = boxes[6 * node + axis]! - origin[axis]!;
    const high = boxes[6 * node + 3 + axis]! - origin[axis]!;
    middle += ((low + high) / 2) * along[axis]!;
    half += ((high - low) / 2) * Math.abs(along[axis]!);
    scale += Math.abs(low) + Math.abs(high);
  }
  return Math.abs(middle) <= half + 1e-14 * scale;
}

/** Return where a triangle, as a line sees it, holds the line; NaN if it does not. */
function crossing(seen: Float64Array): number {
  const one = doubledArea(seen, 3, 6);
  const two = doubledArea(seen, 6, 0);
  const three = doubledArea(seen, 0, 3);
  const isHit = isLeft(seen, 3, 6, one);
  if (isLeft(seen, 6, 0, two) !== isHit || isLeft(seen, 0, 3, three) !== isHit) return NaN;
  const sum = one + two + three;
  if (sum === 0) return (seen[2]! + seen[5]! + seen[8]!) / 3; // it is seen as a point
  return (one * seen[2]! + two * seen[5]! + three * seen[8]!) / sum;
}

function doubledArea(seen: Float64Array, from: number, to: number): number {
  return seen[from]! * seen[to + 1]! - seen[from + 1]! * seen[to]!;
}

/**
 * Whether the line is to the left of an edge.
 *
 * A line through an edge or a corner counts as moved by ε sideways and ε² upwards, so that both faces
 * of the edge agree, and the line is never between them (H. Edelsbrunner & E. P. Mücke, 1990).
 */
function isLeft(seen: Float64Array, from: number, to: number, area: number): boolean {
  if (area !== 0) return area > 0;
  const rise = seen[from + 1]! - seen[to + 1]!;
  if (rise !== 0) return rise > 0;
  return seen[to]! > seen[from]!;
}
