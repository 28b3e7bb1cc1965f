// Questions to the service: comparison, colours in gamut, nearest colours, recipes.
import { numberText } from "../charts/chart.js";
import type { HueSectors } from "../charts/hues.js";
import { type Gamut, ProblemError, request } from "./api.js";

/** Areas in a chromaticity diagram; `area_ratio` is A ÷ B. */
interface Areas {
  area_ratio: number;
  a_covers_b: number;
  b_covers_a: number;
}

/** ΔE00 between the surface of a gamut and the nearest colours of another one. */
interface Loss {
  mean: number;
  percentile_95: number;
  share_outside: number;
}

export interface Comparison {
  intersection: number;
  a_covers_b: number;
  b_covers_a: number;
  jaccard: number;
  white_a: number[];
  white_b: number[];
  black_a: number[];
  black_b: number[];
  /** Sentences with A and B for the gamuts. */
  summary: string[];
  lost_a?: Loss | null;
  lost_b?: Loss | null;
  sectors: HueSectors;
  /** Null if a gamut has no chromaticities. */
  chromaticity: { basis_a: string; basis_b: string; xy: Areas; uv: Areas } | null;
  warnings: string[];
}

/** Where colours are. The edge is within `edge_width` of the surface; `inside` is to `tolerance`. */
export interface Positions {
  inside: boolean[];
  position: Position[];
  distance: number[];
  tolerance: number;
  edge_width: number;
}

export type Position = "inside" | "edge" | "outside";

/** A table as the service read it, with the place of its colours. */
export interface CheckedTable extends Positions {
  /** What the service understood: columns, scale and space. */
  reading: string;
  /** Name of each colour: a text of its row, or its line. */
  labels: string[];
  lines: number[];
  /** The colours in the space of the gamut. */
  colours: number[][];
  /** Reasons why the answer may mislead. */
  warnings?: unknown[];
}

/** Nearest colours of the surface, in the order of the colours. */
export interface Nearest {
  point: number[][];
  delta_e_2000: number[];
  device?: number[][];
  warnings?: unknown[];
}

/** Device values in 0 to 1 that give colours, in the order of the colours. */
export interface Recipes {
  device: number[][];
  /** CIEDE2000 of the recipe's colour from the colour asked. */
  delta_e_2000: number[];
  inside: boolean[];
  /** The possible range of black; only of devices with black. */
  black_least?: (number | null)[];
  black_most?: (number | null)[];
  warnings?: unknown[];
}

/** How a table is to be read, where it does not say so itself. Empty texts leave it to the table. */
export interface TableReading {
  space: string;
  columns: string;
  table_scale: string;
  edge_width: string;
}

export async function compare(a: string, b: string, signal: AbortSignal): Promise<Comparison> {
  const query = new URLSearchParams({ a, b, lost: "true" });
  return (await (await request(`/v1/comparisons?${query}`, { signal })).json()) as Comparison;
}

/** Where colours are, with their distances from the surface of a gamut, negative inside. */
export async function positionsOf(gamut: Gamut, colours: number[][], signal: AbortSignal): Promise<Positions> {
  const response = await request(`/v1/gamuts/${gamut.id}/contains`, {
    method: "POST",
    body: JSON.stringify({ colours, distance: true, position: true }),
    signal,
    headers: { "Content-Type": "application/json" },
  });
  return (await response.json()) as Positions;
}

/** Where the colours of a table are: a text or a file, in any form that the service reads. */
export async function checkTable(
  gamut: Gamut,
  table: Blob,
  reading: TableReading,
  signal: AbortSignal,
): Promise<CheckedTable> {
  const stated = Object.entries(reading).filter(([, value]) => value !== "");
  const query = new URLSearchParams([["position", "true"], ["distance", "true"], ...stated]);
  const response = await request(`/v1/gamuts/${gamut.id}/contains?${query}`, {
    method: "POST",
    body: table,
    signal,
    headers: { "Content-Type": "application/octet-stream" }, // the service recognises the form
  });
  return (await response.json()) as CheckedTable;
}

/** A line of a list that is no colour. */
export interface LineRefusal {
  line: number;
  detail: string;
  remedy: string;
}

/** Lines that may be refused before the whole list is; each of them costs a request. */
const MOST_REFUSED = 20;

/**
 * The same without the lines that the service refuses.
 *
 * It answers whole tables only, so a refused line is emptied, which keeps the numbers of the others,
 * and the rest is sent again. A list of which more is refused than answered is read wrongly: it is
 * refused as a whole, with its first error.
 */
export async function checkLines(
  gamut: Gamut,
  table: Blob,
  reading: TableReading,
  signal: AbortSignal,
): Promise<{ checks: CheckedTable; refused: LineRefusal[] }> {
  const refused: LineRefusal[] = [];
  let lines: string[] | null = null;
  let first: unknown = null;
  for (let list = table; ; ) {
    try {
      const checks = await checkTable(gamut, list, reading, signal);
      if (refused.length > checks.lines.length) break;
      return { checks, refused: refused.sort((one, other) => one.line - other.line) };
    } catch (error) {
      first ??= error;
      lines ??= await linesOf(table);
      const line = refusedLine(error, lines);
      if (line === null || refused.length >= MOST_REFUSED) throw first;
      const { detail, remedy } = (error as ProblemError).problem;
      refused.push({ line, detail, remedy });
      lines[line - 1] = "";
      list = new Blob([lines.join("\n")]);
    }
  }
  throw first;
}

/** Lines of a text; none of a file in another encoding than UTF-8. */
async function linesOf(table: Blob): Promise<string[]> {
  try {
    return new TextDecoder("utf-8", { fatal: true }).decode(await table.arrayBuffer()).split(/\r\n|\r|\n/);
  } catch {
    return [];
  }
}

/** The line that an error is about; null if it is about the whole list, such as the names of columns. */
function refusedLine(error: unknown, lines: string[]): number | null {
  if (!(error instanceof ProblemError) || error.problem.status !== 422) return null;
  const { line, row } = error.problem.where ?? {};
  if (typeof line !== "number" || (lines[line - 1] ?? "").trim() === "") return null;
  // Names of columns have no numbers and no notation.
  const isRow = typeof row === "number" || /#|\(|(^|[\s,;])[-+]?\d/.test(lines[line - 1]!);
  return isRow ? line : null;
}

/** What the edge of a gamut is, for people. */
export function edgeText({ edge_width: width, tolerance }: Positions): string {
  const spelt = (value: number) => (value >= 1 ? value.toFixed(1) : numberText(value, 2));
  return `edge: within ${spelt(width)} of the surface; tolerance ${spelt(tolerance)}`;
}

export async function nearest(gamut: Gamut, colours: number[][], signal: AbortSignal): Promise<Nearest> {
  const metric = gamut.options.space === "CIELAB" ? { metric: "CIE 2000" } : {};
  const response = await request(`/v1/gamuts/${gamut.id}/nearest`, {
    method: "POST",
    body: JSON.stringify({ colours, ...metric }),
    signal,
    headers: { "Content-Type": "application/json" },
  });
  return (await response.json()) as Nearest;
}

/** Gamuts of devices that have no recipes. They are not asked again. */
const withoutModel = new Set<string>();

/** Whether colours of a gamut may have recipes. */
export function mayHaveRecipes(gamut: Gamut): boolean {
  return gamut.channels.length > 0 && !withoutModel.has(gamut.id);
}

/** Recipes of colours. The first question of a gamut waits until its device model is made. */
export async function recipes(gamut: Gamut, colours: number[][], signal: AbortSignal): Promise<Recipes> {
  try {
    const response = await request(`/v1/gamuts/${gamut.id}/recipes`, {
      method: "POST",
      body: JSON.stringify({ colours }),
      signal,
      headers: { "Content-Type": "application/json" },
    });
    return (await response.json()) as Recipes;
  } catch (error) {
    if (error instanceof ProblemError && error.problem.status === 422) withoutModel.add(gamut.id);
    throw error;
  }
}
