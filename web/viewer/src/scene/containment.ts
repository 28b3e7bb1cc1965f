// Whether a gamut lies inside another one, from the triangles that are shown.
import type { LevelBuffers } from "./messages.js";

const POINTS = 64;
/** Points are moved towards the middle by this share: gamuts often have white, black or a primary in common. */
const INWARDS = 0.03;
/** Share of the points of a gamut that lies almost inside another one. */
const ALMOST = 0.95;

type Surface = Pick<LevelBuffers, "positions" | "faces">;

/** Whether nearly all vertices of a surface, moved a little inwards, are inside another one. */
export function liesInside(inner: Surface, outer: Surface): boolean {
  const { positions } = inner;
  const count = positions.length / 3;
  const middle = [0, 0, 0];
  for (let i = 0; i < positions.length; i++) middle[i % 3]! += positions[i]! / count;
  const step = Math.max(1, count / POINTS);
  let [inside, points] = [0, 0];
  for (let place = 0; place < count; place += step) {
    const start = 3 * Math.floor(place);
    const [x, y, z] = middle.map((value, axis) => value * INWARDS + positions[start + axis]! * (1 - INWARDS)) as [number, number, number];
    points += 1;
    if (isInside(outer, x, y, z)) inside += 1;
  }
  return inside >= ALMOST * points;
}

/** Whether a ray along the first axis meets the surface an odd number of times. */
function isInside({ positions, faces }: Surface, x: number, y: number, z: number): boolean {
  let isOdd = false;
  for (let face = 0; face < faces.length; face += 3) {
    const [a, b, c] = [3 * faces[face]!, 3 * faces[face + 1]!, 3 * faces[face + 2]!];
    const [ay, az] = [positions[a + 1]! - y, positions[a + 2]! - z];
    const [by, bz] = [positions[b + 1]! - y, positions[b + 2]! - z];
    const [cy, cz] = [positions[c + 1]! - y, positions[c + 2]! - z];
    // Areas to the point: barycentric coordinates of it in the plane of the other two axes.
    const [u, v, w] = [by * cz - bz * cy, cy * az - cz * ay, ay * bz - az * by];
    if (!((u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0))) continue;
    const area = u + v + w;
    if (area === 0) continue;
    if ((u * positions[a]! + v * positions[b]! + w * positions[c]!) / area > x) isOdd = !isOdd;
  }
  return isOdd;
}
