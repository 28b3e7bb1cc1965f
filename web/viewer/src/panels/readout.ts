// The readout: the colour under the pointer, or the one that a click keeps. Coordinates, chroma and hue,
// device values, the distance to another gamut, and in a section the recipe.
import { Boundary } from "@gamut/boundary";
import { type Intersection, Vector3 } from "three";
import type { Gamut } from "../service/api.js";
import { BEYOND, SCREEN, cssColour, excessOf, polar } from "../colours/colours.js";
import { blackChannel, blackRange, deviceLine } from "../colours/device_values.js";
import { byId, element } from "../page/elements.js";
import { type Page, type Shown, axisNames } from "../page/page.js";
import { tintOf } from "../page/slots.js";
import { orientation } from "../scene/layer.js";
import type { LevelBuffers } from "../scene/messages.js";
import { edgeText, positionsOf, type Positions, recipes } from "../service/queries.js";

/** Interpolate values of vertices, `width` numbers each, at a point of a surface. */
function valuesAt(hit: Intersection, values: Float32Array, width: number): number[] {
  const { a, b, c } = hit.face!;
  const weights = hit.barycoord!.toArray();
  return Array.from({ length: width }, (_, i) =>
    [a, b, c].reduce((sum, corner, k) => sum + weights[k]! * values[width * corner + i]!, 0),
  );
}

/** A colour that is read, and what is said about it. */
export interface Reading {
  subject: Shown;
  /** Another gamut that the lines compare with. */
  other?: Shown | undefined;
  point: number[];
  /** CSS colour of the swatch. */
  colour: string;
  lines: string[];
  answer: AnswerLines;
}

/** The readout waits for so many ms without a change before it is announced. */
const QUIET = 600;
/** A pointer that moved farther than this between down and up, in CSS pixels, turned the view. */
const CLICK_REACH = 4;

export interface PagePlace {
  clientX: number;
  clientY: number;
}

export function isNear(one: PagePlace | null, other: PagePlace): boolean {
  return one !== null && Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY) <= CLICK_REACH;
}

/** The readout of the page: it follows the pointer, unless a click keeps it. */
export class Readout {
  private readonly box = byId("readout");
  private readonly mark = byId("readout-mark");
  private reading: Reading | null = null;
  /** The click that keeps the reading. */
  private keeper: PagePlace | null = null;

  constructor(private readonly page: Page) {
    let timer = 0;
    new MutationObserver(() => {
      clearTimeout(timer);
      timer = setTimeout(() => this.box.hidden || page.announce(this.box.innerText.replaceAll("\n", ", ")), QUIET);
    }).observe(this.box, { childList: true, subtree: true });
    page.on(["slots", "looks"], () => {
      const { reading } = this;
      const isShown = (one: Shown) => page.shown.some(({ gamut }) => gamut === one.gamut);
      if (reading === null) return;
      if (!isShown(reading.subject) || !page.lookOf(reading.subject.slot).isVisible || (reading.other && !isShown(reading.other))) this.clear();
    });
    page.view.onDraw.push(() => this.placeMark());
    addEventListener("keydown", ({ key }) => key === "Escape" && this.release());
  }

  get isKept(): boolean {
    return this.keeper !== null;
  }

  show(reading: Reading): void {
    if (this.reading?.answer !== reading.answer) this.reading?.answer.clear();
    this.reading = reading;
    const { subject: { gamut, slot }, colour, lines, answer } = reading;
    const name = element("strong", gamut.name, { title: gamut.name });
    const tint = element("span", "", { className: "tint" });
    tint.style.backgroundColor = tintOf(slot, this.page.isDark);
    name.prepend(tint);
    const swatch = element("span", "", { className: "swatch" });
    swatch.style.backgroundColor = colour;
    this.box.replaceChildren(name, swatch, ...lines.map((line) => element("span", line)), answer.element);
    this.box.hidden = false;
  }

  /** The pointer is at no colour. */
  leave(): void {
    if (!this.isKept) this.clear();
  }

  /** Keep what `read` shows. A second click at the same place, or one at no colour, lets go. */
  click(place: PagePlace, read: () => void): void {
    const isSame = isNear(this.keeper, place);
    this.release();
    if (isSame) return;
    read();
    if (this.reading === null) return;
    this.keeper = place;
    this.box.classList.add("kept");
    this.box.append(element("small", "Kept until Esc or another click"));
    this.placeMark();
  }

  /** Let go of the reading that is kept. */
  release(): void {
    if (this.isKept) this.clear();
  }

  private clear(): void {
    this.reading?.answer.clear();
    this.reading = this.keeper = null;
    this.box.hidden = this.mark.hidden = true;
    this.box.classList.remove("kept");
  }

  /** Mark the colour that is kept in the view. */
  private placeMark(): void {
    const { mark, page, reading } = this;
    mark.hidden = !this.isKept || reading === null;
    if (mark.hidden) return;
    const point = new Vector3().fromArray(reading!.point).applyMatrix4(orientation(axisNames(reading!.subject.gamut)));
    mark.style.translate = page.view.stagePlace(point).map((value) => `${value.toFixed(1)}px`).join(" ");
  }
}

/** What a point of a surface says by itself. */
export function surfaceReading(gamut: Gamut, level: LevelBuffers, hit: Intersection): Pick<Reading, "point" | "colour" | "lines"> {
  const mean = (values: Float32Array, width: number) => valuesAt(hit, values, width);
  const [point, colour] = [mean(level.positions, 3), mean(level.colours, 3)];
  const lines = coordinates(axisNames(gamut), point);
  if (excessOf(Float32Array.from(colour))[0]! > BEYOND) {
    lines.push(`Outside ${SCREEN === "srgb" ? "sRGB" : "Display P3"}: the screen shows a similar colour`);
  }
  if (level.device !== null) lines.push(deviceLine(gamut.channels, mean(level.device, gamut.channels.length)));
  return { point, colour: cssColour(colour), lines };
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

/** The signed distance of a colour to the level of another gamut that the page shows; nothing if it is too fine. */
export function levelDistance(other: Gamut, level: LevelBuffers | null, point: number[]): string[] {
  if (level === null || level.triangles > MOST_TRIANGLES) return [];
  const boundary = boundaries.get(level) ?? new Boundary(level, other.centre);
  boundaries.set(level, boundary);
  const distance = boundary.distance(point);
  const where = distance > 0 ? "outside" : "inside";
  return [`Euclidean distance ${distanceNumber(distance)} from ${other.name}: ${where} (${level.triangles} triangles)`];
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
