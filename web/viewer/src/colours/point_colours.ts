// Colours of points from those of nearby points, for colour spaces whose formulas the page lacks.

const NEAREST = 4;
const CELLS = 24;

/** Return a function that interpolates linear sRGB between coloured points by inverse distance. */
export function pointColours(
  points: Float32Array,
  linear: Float32Array,
): (positions: Float32Array) => Float32Array {
  const low = [0, 1, 2].map((axis) => extreme(points, axis, Math.min, Infinity));
  const high = [0, 1, 2].map((axis) => extreme(points, axis, Math.max, -Infinity));
  const cell = low.map((value, axis) => Math.max(high[axis]! - value, 1e-9) / CELLS);
  const place = (value: number, axis: number) =>
    Math.min(CELLS - 1, Math.max(0, Math.floor((value - low[axis]!) / cell[axis]!)));
  const cells = new Map<number, number[]>();
  for (let i = 0; i < points.length; i += 3) {
    const at = [0, 1, 2].reduce((sum, axis) => CELLS * sum + place(points[i + axis]!, axis), 0);
    cells.set(at, [...(cells.get(at) ?? []), i]);
  }
  const around = (x: number, y: number, z: number, reach: number) => {
    const found: number[] = [];
    for (let i = Math.max(0, x - reach); i <= Math.min(CELLS - 1, x + reach); i++) {
      for (let j = Math.max(0, y - reach); j <= Math.min(CELLS - 1, y + reach); j++) {
        for (let k = Math.max(0, z - reach); k <= Math.min(CELLS - 1, z + reach); k++) {
          found.push(...(cells.get((CELLS * i + j) * CELLS + k) ?? []));
        }
      }
    }
    return found;
  };
  return (positions) => {
    const result = new Float32Array(positions.length);
    for (let i = 0; i < positions.length; i += 3) {
      const [x, y, z] = [0, 1, 2].map((axis) => place(positions[i + axis]!, axis)) as [number, number, number];
      let near: number[] = [];
      for (let reach = 1; near.length < NEAREST && reach <= CELLS; reach++) near = around(x, y, z, reach);
      const weighted = near
        .map((at): [number, number] => {
          const square = [0, 1, 2].reduce(
            (sum, axis) => sum + ((positions[i + axis]! - points[at + axis]!) / cell[axis]!) ** 2,
            0,
          );
          return [at, 1 / (square + 1e-9)];
        })
        .sort((one, other) => other[1] - one[1])
        .slice(0, NEAREST);
      const total = weighted.reduce((sum, [, weight]) => sum + weight, 0);
      for (const [at, weight] of weighted) {
        for (let c = 0; c < 3; c++) result[i + c]! += (weight / total) * linear[at + c]!;
      }
    }
    return result;
  };
}

function extreme(
  points: Float32Array,
  axis: number,
  choose: (a: number, b: number) => number,
  start: number,
): number {
  let found = start;
  for (let i = axis; i < points.length; i += 3) found = choose(found, points[i]!);
  return found;
}
