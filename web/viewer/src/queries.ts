// Questions to the service: comparison, colours in gamut, nearest colours.
import { type Gamut, request } from "./api.js";
import { warningTexts } from "./elements.js";

/** Areas in a chromaticity diagram; `area_ratio` is A ÷ B. */
interface Areas {
  area_ratio: number;
  a_covers_b: number;
  b_covers_a: number;
}

export interface Comparison {
  intersection: number;
  a_covers_b: number;
  b_covers_a: number;
  jaccard: number;
  /** Null if a gamut has no chromaticities. */
  chromaticity: { basis_a: string; basis_b: string; xy: Areas; uv: Areas } | null;
  warnings: string[];
}

/** Where colours are, and the nearest colours of the surface, in their order. */
export interface Nearest {
  inside: boolean[];
  point: number[][];
  distance: number[];
  delta_e_2000: number[];
  device?: number[][];
  /** Reasons why the answer may mislead. */
  warnings: string[];
}

export async function compare(a: string, b: string, signal: AbortSignal): Promise<Comparison> {
  const query = new URLSearchParams({ a, b, sectors: "1" });
  return (await (await request(`/v1/comparisons?${query}`, { signal })).json()) as Comparison;
}

/** Which points are in a gamut; three coordinates each. */
export async function contained(gamut: Gamut, points: Float32Array, signal: AbortSignal): Promise<boolean[]> {
  const response = await request(`/v1/gamuts/${gamut.id}/contains`, {
    method: "POST",
    body: npy(points),
    signal,
    headers: { "Content-Type": "application/x-npy" },
  });
  return ((await response.json()) as { inside: boolean[] }).inside;
}

/** Distance of a colour from the surface of a gamut, negative inside. */
export async function signedDistance(gamut: Gamut, point: number[], signal: AbortSignal): Promise<number> {
  const response = await request(`/v1/gamuts/${gamut.id}/contains`, {
    method: "POST",
    body: JSON.stringify({ colours: [point], distance: true }),
    signal,
    headers: { "Content-Type": "application/json" },
  });
  return ((await response.json()) as { distance: number[] }).distance[0]!;
}

export async function nearest(gamut: Gamut, colours: number[][], signal: AbortSignal): Promise<Nearest> {
  const ask = async (name: string, members: object) => {
    const response = await request(`/v1/gamuts/${gamut.id}/${name}`, {
      method: "POST",
      body: JSON.stringify({ colours, ...members }),
      signal,
      headers: { "Content-Type": "application/json" },
    });
    return (await response.json()) as Omit<Nearest, "warnings"> & { warnings?: unknown[] };
  };
  const metric = gamut.options.space === "CIELAB" ? { metric: "CIE 2000" } : {};
  const [where, found] = await Promise.all([ask("contains", {}), ask("nearest", metric)]);
  const warnings = warningTexts([...(where.warnings ?? []), ...(found.warnings ?? [])]);
  return { ...found, inside: where.inside, warnings };
}

/** An array (n, 3) of float32 as a NumPy file, version 1.0. */
function npy(points: Float32Array): Blob {
  const shape = `{'descr': '<f4', 'fortran_order': False, 'shape': (${points.length / 3}, 3), }`;
  const text = shape.padEnd(64 * Math.ceil((shape.length + 11) / 64) - 11) + "\n";
  const head = new Uint8Array(10 + text.length);
  head.set([0x93, ...new TextEncoder().encode("NUMPY"), 1, 0, text.length & 255, text.length >> 8]);
  head.set(new TextEncoder().encode(text), 10);
  return new Blob([head, points as Float32Array<ArrayBuffer>]);
}
