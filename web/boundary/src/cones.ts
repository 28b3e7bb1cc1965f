// Cones of faces seen from the centre, and the cube map that finds them by direction.

/** Numbers of a face in `planes`: three unit normals of its cone, and the plane m · x = 1. */
export const WIDTH = 12;

/** Cells along an edge of the cube, at most. */
const MOST_CELLS = 256;

/** How far faces reach beyond their edges. Directions are rounded by some 2⁻⁵². */
const WIDENING = 2 ** -40;

/** The faces of a star-shaped mesh by direction from its centre. */
export class Cones {
  /** `WIDTH` numbers for each face; products are positive inwards. */
  readonly planes: Float64Array;
  /** Volume of the mesh. */
  readonly volume: number;
  private readonly resolution: number;
  /** The faces that a cell meets are `listed` from `start[cell]` to `start[cell + 1]`. */
  private readonly start: Int32Array;
  private readonly listed: Int32Array;

  /** `triangles` are the corners of each face, nine numbers relative to the centre. */
  constructor(triangles: Float64Array) {
    const count = triangles.length / 9;
    this.planes = new Float64Array(WIDTH * count);
    this.volume = setPlanes(triangles, this.planes);
    this.resolution = Math.min(MOST_CELLS, Math.max(4, Math.round(Math.sqrt(count))));
    this.start = new Int32Array(6 * this.resolution ** 2 + 1);
    const { start } = this;
    this.visit(triangles, (cell) => start[cell + 1]!++);
    for (let cell = 1; cell < start.length; cell++) start[cell]! += start[cell - 1]!;
    const end = start.slice();
    this.listed = new Int32Array(start.at(-1)!);
    this.visit(triangles, (cell, face) => (this.listed[end[cell]!++] = face));
  }

  /** The face whose cone holds a direction of any length; at an edge, one of those that meet there. */
  faceTowards(x: number, y: number, z: number): number {
    const { planes, listed, start, resolution } = this;
    const wide = Math.abs(x);
    const deep = Math.abs(y);
    const high = Math.abs(z);
    let side = x > 0 ? 0 : 1;
    let u = y / wide;
    let v = z / wide;
    if (deep > wide && deep >= high) {
      side = y > 0 ? 2 : 3;
      u = z / deep;
      v = x / deep;
    } else if (high > wide) {
      side = z > 0 ? 4 : 5;
      u = x / high;
      v = y / high;
    }
    const row = Math.min(resolution - 1, Math.floor((u + 1) * 0.5 * resolution));
    const column = Math.min(resolution - 1, Math.floor((v + 1) * 0.5 * resolution));
    const cell = (side * resolution + row) * resolution + column;
    let best = -1;
    let most = -Infinity;
    for (let place = start[cell]!; place < start[cell + 1]!; place++) {
      const at = WIDTH * listed[place]!;
      const one = planes[at]! * x + planes[at + 1]! * y + planes[at + 2]! * z;
      const two = planes[at + 3]! * x + planes[at + 4]! * y + planes[at + 5]! * z;
      const three = planes[at + 6]! * x + planes[at + 7]! * y + planes[at + 8]! * z;
      const least = one < two ? (one < three ? one : three) : two < three ? two : three;
      if (least >= 0) return listed[place]!;
      if (least > most) {
        best = listed[place]!;
        most = least;
      }
    }
    return best;
  }

  /** Visit each cell with each face that may meet it. */
  private visit(triangles: Float64Array, see: (cell: number, face: number) => void): void {
    const { planes, resolution } = this;
    const cellAt = (ratio: number) => Math.min(resolution - 1, Math.max(0, Math.floor((ratio + 1) * 0.5 * resolution)));
    for (let face = 0; 9 * face < triangles.length; face++) {
      for (let side = 0; side < 6; side++) {
        const [axis, sign] = [side >> 1, side % 2 === 0 ? 1 : -1];
        const [next, last] = [(axis + 1) % 3, (axis + 2) % 3];
        let [isBehind, inFront] = [false, 0];
        let [lowU, highU, lowV, highV] = [Infinity, -Infinity, Infinity, -Infinity];
        // corners beyond the four edges of the side
        let [left, right, below, above] = [0, 0, 0, 0];
        for (let corner = 9 * face; corner < 9 * face + 9; corner += 3) {
          const w = sign * triangles[corner + axis]!;
          const u = triangles[corner + next]!;
          const v = triangles[corner + last]!;
          const edge = w + WIDENING * Math.abs(w);
          if (w > 0) inFront += 1;
          else isBehind = true;
          if (u > edge) right += 1;
          if (-u > edge) left += 1;
          if (v > edge) above += 1;
          if (-v > edge) below += 1;
          lowU = Math.min(lowU, u / w);
          highU = Math.max(highU, u / w);
          lowV = Math.min(lowV, v / w);
          highV = Math.max(highV, v / w);
        }
        if (inFront === 0 || left === 3 || right === 3 || below === 3 || above === 3) continue;
        // a face with a corner behind the centre may have any extent
        if (isBehind) [lowU, highU, lowV, highV] = [-1, 1, -1, 1];
        const [firstRow, lastRow] = [cellAt(lowU - WIDENING), cellAt(highU + WIDENING)];
        const [firstColumn, lastColumn] = [cellAt(lowV - WIDENING), cellAt(highV + WIDENING)];
        const isSmall = firstRow === lastRow && firstColumn === lastColumn;
        for (let row = firstRow; row <= lastRow; row++) {
          for (let column = firstColumn; column <= lastColumn; column++) {
            if (!isSmall && !meets(planes, face, side, row, column, resolution)) continue;
            see((side * resolution + row) * resolution + column, face);
          }
        }
      }
    }
  }
}

/** Write the planes of all faces; return the volume. */
function setPlanes(triangles: Float64Array, planes: Float64Array): number {
  let sum = 0;
  for (let face = 0; 9 * face < triangles.length; face++) {
    const [from, to] = [9 * face, WIDTH * face];
    let determinant = 0;
    for (let corner = 0; corner < 9; corner += 3) {
      const [p, q] = [from + corner, from + ((corner + 3) % 9)];
      let square = 0;
      for (let axis = 0; axis < 3; axis++) {
        const [next, last] = [(axis + 1) % 3, (axis + 2) % 3];
        const normal = triangles[p + next]! * triangles[q + last]! - triangles[p + last]! * triangles[q + next]!;
        planes[to + corner + axis] = normal;
        planes[to + 9 + axis]! += normal;
        square += normal * normal;
      }
      if (corner === 0) {
        determinant =
          planes[to]! * triangles[from + 6]! + planes[to + 1]! * triangles[from + 7]! + planes[to + 2]! * triangles[from + 8]!;
        if (!(determinant > 0)) throw new RangeError(`face ${face} does not see the centre from its inner side`);
        sum += determinant;
      }
      for (let axis = 0; axis < 3; axis++) planes[to + corner + axis]! /= Math.sqrt(square);
    }
    for (let axis = 9; axis < WIDTH; axis++) planes[to + axis]! /= determinant;
  }
  return sum / 6;
}

/** Whether a cell is not beyond one of the planes of a cone. */
function meets(planes: Float64Array, face: number, side: number, row: number, column: number, resolution: number): boolean {
  const axis = side >> 1;
  const sign = side % 2 === 0 ? 1 : -1;
  for (let plane = WIDTH * face; plane < WIDTH * face + 9; plane += 3) {
    const [w, u, v] = [sign * planes[plane + axis]!, planes[plane + ((axis + 1) % 3)]!, planes[plane + ((axis + 2) % 3)]!];
    // the corner of the cell that is farthest inwards
    const ratio = (place: number, number: number) => (2 * (place + (number > 0 ? 1 : 0))) / resolution - 1;
    if (w + u * ratio(row, u) + v * ratio(column, v) < -WIDENING) return false;
  }
  return true;
}
