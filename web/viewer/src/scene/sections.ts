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
