// The colour under the pointer: coordinates, chroma and hue, device values, the distance to the other
// gamut, and what the service is asked for: whether that is at the edge, and the recipe in a slice.
import { Boundary } from "@gamut/boundary";
import type { Intersection } from "three";
import type { Gamut } from "../service/api.js";
import { BEYOND, SCREEN, cssColour, excessOf, polar } from "../colours/colours.js";
import { blackChannel, blackRange, deviceLine } from "../colours/device_values.js";
import { element } from "../page/elements.js";
import type { LevelBuffers } from "../scene/messages.js";
import { edgeText, positionsOf, type Positions, recipes } from "../service/queries.js";

/** Interpolate values of vertices, `width` numbers each, at a point of a surface. */
export function valuesAt(hit: Intersection, values: Float32Array, width: number): number[] {
  const { a, b, c } = hit.face!;
  const weights = hit.barycoord!.toArray();
  return Array.from({ length: width }, (_, i) =>
    [a, b, c].reduce((sum, corner, k) => sum + weights[k]! * values[width * corner + i]!, 0),
  );
}

export function readout(
  gamut: Gamut,
  names: string[],
  level: LevelBuffers,
  hit: Intersection,
): HTMLElement[] {
  const mean = (values: Float32Array, width: number) => valuesAt(hit, values, width);
  const point = mean(level.positions, 3);
  const swatch = element("span", "", { className: "swatch" });
  swatch.style.backgroundColor = cssColour(mean(level.colours, 3));
  const lines = coordinates(names, point);
  if (excessOf(Float32Array.from(mean(level.colours, 3)))[0]! > BEYOND) {
    lines.push(`Outside ${SCREEN === "srgb" ? "sRGB" : "Display P3"}: the screen shows a similar colour`);
  }
  if (level.device !== null) lines.push(deviceLine(gamut.channels, mean(level.device, gamut.channels.length)));
  return [swatch, ...lines.map((line) => element("span", line))];
}

/** Lines with the coordinates of a colour. */
export function coordinates(names: string[], point: number[]): string[] {
  const digits = Math.max(...point.map(Math.abs)) < 5 ? 4 : 1;
  const lines = [names.map((name, i) => `${name} ${signed(point[i]!, digits)}`).join("  ")];
  if (names[0] !== "X") {
    const [chroma, hue] = polar(point[1]!, point[2]!);
    lines.push(`C ${chroma.toFixed(digits)}  h ${hue.toFixed(1)}°`);
  }
  return lines;
}

type Question = (signal: AbortSignal) => Promise<string[]>;

/** Lines that the service is asked for, one question at a time. */
export class AnswerLines {
  readonly element = element("span");
  private busy = false;
  private wish: Question | null = null;
  private asking = new AbortController();

  /** `pause` is the time in ms for which a question waits, in case that another one follows. */
  constructor(private readonly pause = 0) {}

  /** Ask. While an answer is under way, only the last wish counts. The first has a text meanwhile. */
  ask(question: Question, meanwhile = ""): void {
    this.wish = question;
    if (this.element.textContent === "") this.element.textContent = meanwhile;
    if (!this.busy) void this.answer();
  }

  /** Show nothing, and drop the answer that is under way. */
  clear(): void {
    this.wish = null;
    this.asking.abort();
    this.element.replaceChildren();
  }

  private async answer(): Promise<void> {
    this.busy = true;
    while (this.wish !== null) {
      if (this.pause > 0) await new Promise((resolve) => setTimeout(resolve, this.pause));
      const question: Question | null = this.wish;
      if (question === null) break;
      this.wish = null;
      this.asking = new AbortController();
      const { signal } = this.asking;
      // Colours at which the service fails have no line: the panel of the question tells why.
      const lines = await question(signal).catch((): string[] => []);
      if (!signal.aborted) this.element.replaceChildren(...lines.map((line) => element("span", line)));
    }
    this.busy = false;
  }
}

/** The signed distance of a colour to another gamut. */
export async function distanceLines(other: Gamut, point: number[], signal: AbortSignal): Promise<string[]> {
  return [distanceText(other.name, await positionsOf(other, [point], signal))];
}

const boundaries = new WeakMap<LevelBuffers, Boundary>();

/** Triangles of a level that the page prepares for questions without a pause. */
const MOST_TRIANGLES = 50_000;

/** The signed distance of a colour to the level of another gamut that the page shows; null if it is too fine. */
export function levelDistance(other: Gamut, level: LevelBuffers | null, point: number[]): string | null {
  if (level === null || level.triangles > MOST_TRIANGLES) return null;
  const boundary = boundaries.get(level) ?? new Boundary(level, other.centre);
  boundaries.set(level, boundary);
  const distance = boundary.distance(point);
  const where = distance > 0 ? "outside" : "inside";
  return `Euclidean distance ${distanceNumber(distance)} from ${other.name}: ${where} (${level.triangles} triangles)`;
}

/** The recipe of a colour. */
export async function recipeLines(gamut: Gamut, point: number[], signal: AbortSignal): Promise<string[]> {
  const recipe = await recipes(gamut, [point], signal);
  const { channels } = gamut;
  const range = blackRange(recipe, 0);
  const black = range === null ? "" : `; ${blackChannel(channels)} can be ${range} %`;
  const kind = recipe.inside[0] ? "Recipe" : "Outside; recipe of the nearest colour";
  return [`${kind}: ΔE00 ${recipe.delta_e_2000[0]!.toFixed(2)}${black}`, deviceLine(channels, recipe.device[0]!)];
}

function distanceText(name: string, positions: Positions): string {
  const distance = positions.distance[0]!;
  return `Euclidean distance ${distanceNumber(distance)} from ${name}: ${positions.position[0]!} (${edgeText(positions)})`;
}

function distanceNumber(distance: number): string {
  return signed(distance, Math.abs(distance) < 0.1 ? 4 : 2);
}

function signed(value: number, digits: number): string {
  return value.toFixed(digits).replace("-", "−");
}
