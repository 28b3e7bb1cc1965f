// The controls of the slice, its two pictures, and the colour under the pointer in it.
import { Box3, type LineSegments, type LineBasicMaterial, Vector3 } from "three";
import { SCREEN, cssColour } from "../colours/colours.js";
import { spaceOf } from "../colours/spaces.js";
import { byId, element } from "../page/elements.js";
import { embedded } from "../page/embedded.js";
import { type Page, axisNames } from "../page/page.js";
import { orientation } from "../scene/layer.js";
import { type Gamut, request } from "../service/api.js";
import { mayHaveRecipes } from "../service/queries.js";
import { AnswerLines, coordinates, recipeLines } from "./readout.js";
import { type Frame, type Slice, colourAt, drawSlice, sliceLines } from "./slice.js";

const HUES = 360;
/** Time in ms for which the pointer rests before a recipe is asked for. */
const REST = 120;

interface SliceState {
  kind: "off" | "lightness" | "hue" | "rings";
  lightness: number | null;
  hue: number;
}

export class SlicePanel {
  private readonly state: SliceState = { kind: "off", lightness: null, hue: 40 };
  private lines: LineSegments | null = null;
  /** Address of the rings that are shown or on the way. */
  private rings = "";
  private readonly recipe = new AnswerLines(REST);
  /** Show the colour at a place of the drawing, as fractions of it. */
  private point: (place: [number, number]) => void = () => {};
  private readonly kind = byId<HTMLSelectElement>("slice-kind");
  private readonly value = byId<HTMLInputElement>("slice-value");

  constructor(private readonly page: Page) {
    page.address.add({ read: (given) => readState(this.state, given), write: () => entries(this.state) });
    for (const event of ["gamuts", "level", "theme"] as const) page.on(event, () => this.draw());
    this.kind.addEventListener("change", () => {
      this.state.kind = this.kind.value as SliceState["kind"];
      this.changed();
    });
    this.value.addEventListener("input", () => {
      if (this.state.kind === "hue") this.state.hue = Number(this.value.value);
      else this.state.lightness = Number(this.value.value);
      this.changed();
    });
    const canvas = byId<HTMLCanvasElement>("slice");
    const pointed = (event: PointerEvent) => {
      const { left, top, width, height } = canvas.getBoundingClientRect();
      this.point([(event.clientX - left) / width, (event.clientY - top) / height]);
    };
    canvas.addEventListener("pointermove", pointed);
    canvas.addEventListener("pointerdown", pointed);
    canvas.addEventListener("pointerleave", (event) => {
      // A finger that is lifted leaves as well.
      if (event.pointerType === "mouse") this.read(null, []);
    });
  }

  /** Show a colour of the slice with its recipe for the first gamut. */
  private read(gamut: Gamut | null, names: string[], point: [number, number, number] | null = null): void {
    const output = byId("readout");
    output.hidden = gamut === null || point === null;
    if (gamut === null || point === null) {
      this.recipe.clear();
      return;
    }
    const lines: HTMLElement[] = coordinates(names, point).map((line) => element("span", line));
    const swatch = element("span", "", { className: "swatch" });
    swatch.style.backgroundColor = cssColour(spaceOf(gamut.provenance.colour_space).linear(Float32Array.from(point), SCREEN));
    lines.unshift(swatch);
    output.replaceChildren(...lines, this.recipe.element);
    if (embedded !== null || !mayHaveRecipes(gamut)) this.recipe.clear();
    else this.recipe.ask((signal) => recipeLines(gamut, point, signal), "Recipe: …");
  }

  private changed(): void {
    this.draw();
    this.page.view.draw();
    this.page.address.save();
  }

  /** Draw the slice of the levels that are shown. */
  private draw(): void {
    const { shown } = this.page;
    const names = shown[0] === undefined ? [] : axisNames(shown[0].gamut);
    this.clear();
    const { kind } = this.state;
    const levels = shown.flatMap(({ gamut, layer }) =>
      layer.level === null ? [] : [{ level: layer.level, space: spaceOf(gamut.provenance.colour_space) }],
    );
    const isOn = levels.length > 0;
    byId("section").hidden = kind === "off" || !isOn;
    byId("slice-row").hidden = kind === "off" || kind === "rings";
    byId("slice").hidden = kind === "rings";
    byId("rings").hidden = kind !== "rings";
    this.kind.value = kind;
    this.kind.disabled = shown.length === 0;
    if (kind === "off" || !isOn) return;
    if (kind === "rings") {
      this.showRings(shown.map(({ gamut }) => gamut)).catch((error: unknown) => this.page.complain(error));
      return;
    }
    const box = new Box3();
    for (const { gamut } of shown) {
      for (const corner of gamut.bounds) box.expandByPoint(new Vector3().fromArray(corner));
    }
    const lightness = names[0] === "X" ? 1 : 0;
    const slice = this.slice(kind, box, lightness);
    this.label(slice, names[lightness]!, box, lightness);
    const second = shown[1]?.gamut.name;
    if (second !== undefined) byId("slice-caption").append(`; dashed: ${second}`);
    const others = [0, 1, 2].filter((axis) => axis !== lightness);
    const frame = frameOf(kind, box, lightness, others);
    const labels: [string, string] =
      kind === "hue" ? ["C", names[lightness]!] : [names[others[0]!]!, names[others[1]!]!];
    const canvas = byId<HTMLCanvasElement>("slice");
    const { gamut } = shown[0]!;
    this.point = (place) => this.read(gamut, names, colourAt(place, slice, lightness, frame));
    const loops = drawSlice(canvas, levels, slice, lightness, frame, labels);
    this.lines = sliceLines(loops, slice, orientation(names), getComputedStyle(canvas).accentColor);
    this.page.view.scene.add(this.lines);
  }

  /** Show the gamut rings that the service draws, with those of the second gamut as reference. */
  private async showRings([first, second]: Gamut[]): Promise<void> {
    const query = second === undefined ? "" : `?reference=${second.id}`;
    const address = `/v1/gamuts/${first!.id}/rings.svg${query}`;
    if (address === this.rings) return;
    this.rings = address;
    byId("slice-caption").textContent = "Gamut rings";
    const picture = byId<HTMLImageElement>("rings");
    picture.alt = `Gamut rings of ${first!.name}${second === undefined ? "" : ` and ${second.name}`}`;
    const response = await request(address, { headers: { Accept: "image/svg+xml" } });
    const content = await response.blob();
    if (address !== this.rings) return;
    URL.revokeObjectURL(picture.src);
    picture.src = URL.createObjectURL(content);
  }

  private slice(kind: Slice["kind"], box: Box3, lightness: number): Slice {
    if (kind === "hue") return { kind, value: this.state.hue };
    const middle = (box.min.getComponent(lightness) + box.max.getComponent(lightness)) / 2;
    this.state.lightness ??= Number(middle.toPrecision(2));
    return { kind, value: this.state.lightness };
  }

  private label(slice: Slice, name: string, box: Box3, lightness: number): void {
    const [low, high] = slice.kind === "hue" ? [0, HUES] : [box.min.getComponent(lightness), box.max.getComponent(lightness)];
    const step = slice.kind === "hue" ? 1 : 10 ** Math.round(Math.log10((high - low) / 100));
    const [from, to] = [Math.ceil(low / step) * step, Math.floor(high / step) * step];
    Object.assign(this.value, { min: String(from), max: String(to), step: String(step) });
    this.value.value = String(slice.value);
    const shown = Number(slice.value.toPrecision(4));
    const text = slice.kind === "hue" ? `Hue ${shown}°` : `${name} ${shown}`;
    byId("slice-label").textContent = text;
    byId("slice-caption").textContent = text;
    byId("slice").setAttribute("aria-label", `Outlines of the shown gamuts at ${text}`);
  }

  private clear(): void {
    this.lines?.removeFromParent();
    this.lines?.geometry.dispose();
    (this.lines?.material as LineBasicMaterial | undefined)?.dispose();
    this.lines = null;
  }
}

function readState(state: SliceState, given: URLSearchParams): void {
  if (given.has("rings")) state.kind = "rings";
  for (const kind of ["lightness", "hue"] as const) {
    const text = given.get(kind);
    if (text === null || !Number.isFinite(Number(text))) continue;
    state.kind = kind;
    state[kind] = Number(text);
  }
}

function entries({ kind, lightness, hue }: SliceState): [string, string | null][] {
  if (kind === "off") return [];
  return [[kind, kind === "rings" ? "on" : String(kind === "hue" ? hue : lightness)]];
}

/** Room for the slice at any value, so that the drawing does not jump. */
function frameOf(kind: Slice["kind"], box: Box3, lightness: number, others: number[]): Frame {
  const range = (axis: number): [number, number] => {
    const [low, high] = [box.min.getComponent(axis), box.max.getComponent(axis)];
    return [low - 0.04 * (high - low), high + 0.04 * (high - low)];
  };
  if (kind === "lightness") {
    const [x, y] = others.map(range) as [[number, number], [number, number]];
    const half = Math.max(x[1] - x[0], y[1] - y[0]) / 2;
    const around = ([low, high]: [number, number]): [number, number] => [(low + high) / 2 - half, (low + high) / 2 + half];
    return [around(x), around(y)];
  }
  const reach = Math.max(...others.flatMap((axis) => range(axis).map(Math.abs)));
  const [bottom, top] = range(lightness);
  return [
    [0, Math.max(reach, top - bottom)],
    [bottom, bottom + Math.max(reach, top - bottom)],
  ];
}
