// Slices and diagrams: the controls, the cut in the view, the chart beside it, and the colour at a point.
import { Box3, Vector3 } from "three";
import { numberText, png } from "../charts/chart.js";
import { pageTheme } from "../charts/save.js";
import { type Frame, sectionChart } from "../charts/section.js";
import { SCREEN, cssColour, encoded } from "../colours/colours.js";
import { type Screen, type Space, gamutSpace } from "../colours/spaces.js";
import { byId, element, openPart } from "../page/elements.js";
import { embedded } from "../page/embedded.js";
import { type Page, type Shown, axisNames } from "../page/page.js";
import { SLOTS, tintOf } from "../page/slots.js";
import { CutAway, type CutLayer, type Half, type Raster } from "../scene/cut.js";
import { orientation } from "../scene/layer.js";
import { type Cut, type Place, type Point, type SectionPlane, areaWithin, heightAbove, placesIn, planeOf, pointAt, rightHalf, sectionLoops } from "../scene/sections.js";
import type { Gamut } from "../service/api.js";
import { mayHaveRecipes } from "../service/queries.js";
import { type DiagramKind, DIAGRAMS, diagram, diagramName, isDiagram } from "./diagrams.js";
import { PlaneHandle } from "./plane_handle.js";
import { AnswerLines, type PagePlace, type Readout, coordinates, recipeLines } from "./readout.js";
import { SectionFigure } from "./section_figure.js";

const PLANES = ["lightness", "hue"] as const;
/** Time in ms for which the pointer rests before a recipe is asked for. */
const REST = 120;
/** Columns and rows of the colours of a section; they are interpolated between. */
const RASTER = 96;
/** Least time in ms between two charts while the plane moves. */
const CHART_MILLISECONDS = 100;
/** Room between a frame and what is in it, relative to its size. */
const OUTSIDE = 0.05;

/** What the sections and diagrams are. */
const SENTENCES: Partial<Record<SliceState["kind"], string>> = {
  lightness: "All colours of one lightness.",
  hue: "All colours of one hue, the kind of a colour such as red: an angle around the grey axis. Chroma is how far a colour is from grey.",
  xy: "Colours without their lightness. The colours of the spectrum are on the curve around them.",
  uv: "Colours without their lightness. The colours of the spectrum are on the curve around them.",
};

interface SliceState {
  kind: "off" | (typeof PLANES)[number] | DiagramKind;
  lightness: number | null;
  hue: number;
  half: Half;
}

export class SlicePanel {
  private readonly state: SliceState = { kind: "off", lightness: null, hue: 40, half: "front" };
  private readonly cut: CutAway;
  private readonly handle: PlaneHandle;
  readonly figure = new SectionFigure(() => this.change({ kind: "off" }));
  private readonly recipe = new AnswerLines(REST);
  /** What the lightness is in. */
  private space = "";
  /** When the chart of a section was drawn last, and the timer of the next time. */
  private charted = -Infinity;
  private charting = 0;
  private readonly kind = byId<HTMLSelectElement>("slice-kind");
  private readonly value = byId<HTMLInputElement>("slice-value");
  private readonly number = byId<HTMLInputElement>("slice-number");

  constructor(
    private readonly page: Page,
    private readonly readout: Readout,
  ) {
    this.cut = new CutAway(page.view);
    this.handle = new PlaneHandle(page);
    page.address.add({
      read: (given) => {
        readState(this.state, given);
        if (this.state.kind !== "off") openPart("cut");
      },
      write: () => entries(this.state),
    });
    for (const event of ["gamuts", "level", "theme"] as const) page.on(event, () => this.draw());
    page.on("camera", () => this.cut.follow());
    page.readable.push({
      targets: () => (isPlane(this.state.kind) ? [this.cut.cap] : []),
      read: ({ point }) => this.read(this.cut.pointOf(point)),
    });
    const diagrams = element("optgroup", "", { label: "Diagrams" });
    diagrams.append(...Object.entries(DIAGRAMS).map(([value, text]) => element("option", text, { value })));
    this.kind.append(diagrams);
    this.connectControls();
    this.connectChart();
  }

  private connectChart(): void {
    const { figure, readout } = this;
    const { box } = figure;
    const read = ({ clientX, clientY }: PagePlace) => {
      const { left, top } = box.getBoundingClientRect();
      const point = figure.pointAt(clientX - left, clientY - top);
      if (point === null) readout.leave();
      else this.read(point);
    };
    for (const event of ["pointermove", "pointerdown"] as const) box.addEventListener(event, (place) => readout.isKept || read(place));
    box.addEventListener("click", (place) => readout.click(place, () => read(place)));
    box.addEventListener("pointerleave", (event) => {
      // A finger that is lifted leaves as well.
      if (event.pointerType === "mouse") readout.leave();
    });
  }

  private connectControls(): void {
    this.kind.addEventListener("change", () => this.change({ kind: this.kind.value as SliceState["kind"], half: "front" }));
    this.value.addEventListener("input", () => this.change({ [this.state.kind]: this.value.valueAsNumber }));
    this.number.addEventListener("change", () => {
      const { max, min, valueAsNumber } = this.number;
      const value = Number.isNaN(valueAsNumber) ? this.value.valueAsNumber : Math.min(Math.max(valueAsNumber, Number(min)), Number(max));
      this.number.value = String(value);
      this.change({ [this.state.kind]: value });
    });
    byId("slice-flip").addEventListener("click", () => this.change({ half: this.cut.isAboveCut ? "below" : "above" }));
    byId<HTMLInputElement>("slice-open").addEventListener("change", ({ target }) => {
      this.change({ half: (target as HTMLInputElement).checked ? "front" : "none" });
    });
  }

  private change(changes: Partial<SliceState>): void {
    Object.assign(this.state, changes);
    this.readout.release();
    this.draw();
    this.page.view.draw();
    this.page.address.save();
  }

  /** Draw the section of the levels that are shown. */
  private draw(): void {
    clearTimeout(this.charting);
    const { state } = this;
    const shown = this.page.shown.filter(({ layer }) => layer.level !== null);
    if (shown.length > 0) this.followSpace(shown[0]!.gamut);
    const isOn = state.kind !== "off" && shown.length > 0;
    const hasPlane = isOn && isPlane(state.kind);
    this.kind.value = state.kind;
    this.kind.disabled = this.page.shown.length === 0;
    const sentence = isOn ? SENTENCES[state.kind] : undefined;
    byId("slice-note").hidden = sentence === undefined;
    byId("slice-note").textContent = sentence ?? "";
    byId("slice-row").hidden = !hasPlane;
    byId("slice-half").hidden = !hasPlane;
    if (!hasPlane) {
      this.cut.hide(shown.map(({ layer }) => layer));
      this.handle.hide();
    }
    if (!isOn) this.figure.close();
    else {
      this.figure.open();
      if (isDiagram(state.kind)) this.drawDiagram(state.kind, shown);
      else this.drawPlane(shown);
    }
  }

  /** X, Y and Z have no hue. The lightness of another space means nothing in this one. */
  private followSpace(gamut: Gamut): void {
    const { state } = this;
    const { lightness } = gamutSpace(gamut);
    byId<HTMLOptionElement>("slice-hue").disabled = lightness !== 0;
    if (lightness !== 0 && state.kind === "hue") state.kind = "lightness";
    const { space } = gamut.options;
    if (this.space !== "" && this.space !== space) state.lightness = null;
    this.space = space;
  }

  private drawDiagram(kind: DiagramKind, shown: Shown[]): void {
    const drawing = diagram(kind, shown, this.page.isDark);
    if (typeof drawing === "string") this.figure.say(drawing);
    else this.figure.show(drawing, diagramName(kind, this.page));
  }

  private drawPlane(shown: Shown[]): void {
    const { page, state } = this;
    const { gamut } = shown[0]!;
    const names = axisNames(gamut);
    const space = gamutSpace(gamut);
    const { lightness } = space;
    const box = boxOf(shown.map((each) => each.gamut));
    const middle = middleLightness(boxOf([gamut]), lightness);
    const others = [0, 1, 2].filter((axis) => axis !== lightness);
    const positions = shown.map(({ layer }) => layer.level!.positions);
    const origin: Point = [0, 0, 0];
    const reach = farthest(positions, origin, others);
    state.lightness ??= middle;
    const cut = this.cutOf(box, lightness, middle);
    const plane = planeOf(cut, lightness);
    const text = this.label(cut, names[lightness]!, box, lightness);
    const layers = shown.map(({ slot, gamut: each, layer }): CutLayer => {
      const { positions, faces } = layer.level!;
      const loops = sectionLoops(positions, faces, heightAbove(plane));
      const { isVisible, opacity } = page.lookOf(slot);
      return {
        layer,
        name: each.name,
        outlines: loops.map((loop) => placesIn(plane, loop)),
        isFilled: isVisible && (opacity === 1 || slot === shown[0]!.slot),
        colour: tintOf(slot, page.isDark),
        order: SLOTS.indexOf(slot),
      };
    });
    const frame = frameOf(cut, plane, box, reach);
    const raster = colours(space, plane, frame, SCREEN);
    const theme = pageTheme(this.figure.box);
    const turn = orientation(names);
    const visible = layers.filter(({ layer }) => layer.isVisible);
    this.cut.show({ plane, turn, frame, raster, layers: visible, half: state.half, ink: theme.text, back: theme.back });
    byId<HTMLInputElement>("slice-open").checked = state.half !== "none";
    byId<HTMLButtonElement>("slice-flip").disabled = state.half === "none";
    const [[left, right], [bottom, top]] = frame;
    const isHue = cut.kind === "hue";
    const height = (bottom + top) / 2;
    this.handle.show(
      (value) => this.cut.screen(pointAt(planeOf({ ...cut, value }, lightness), isHue ? [right, height] : [right, bottom])),
      text,
      isHue ? { place: () => this.cut.screen(pointAt(plane, [left, height])), text: `Hue ${(cut.value + 180) % 360}°` } : undefined,
    );
    this.chartLater(() => {
      const half = layers.map((layer) => ({ ...layer, outlines: isHue ? layer.outlines.map(rightHalf).filter((each) => each.length > 0) : layer.outlines }));
      const named = half.map((layer) => ({ ...layer, name: `${layer.name}, area ${areaText(areaWithin(layer.outlines))}` }));
      // A file without a profile is sRGB, whatever the screen is.
      const address = png(pixels(SCREEN === "srgb" ? raster : colours(space, plane, frame, "srgb")), RASTER);
      const chart = {
        title: text,
        labels: this.chartLabels(cut, names, lightness, others),
        frame: isHue ? ([[0, right], frame[1]] satisfies Frame) : frame,
      };
      this.figure.show(
        (options) => {
          const { svg, placeAt } = sectionChart({ ...chart, ...options }, named, { address, frame });
          const colourAt = (x: number, y: number) => {
            const place = placeAt(x, y);
            return place && pointAt(plane, place);
          };
          return { svg, pointAt: colourAt };
        },
        `${layers.map(({ name }) => name).join(" and ")}, ${text}`,
      );
    });
  }

  /** Draw the chart now, or a moment later if it was just drawn: the cut in the view follows every step. */
  private chartLater(draw: () => void): void {
    const charted = () => {
      this.charted = performance.now();
      draw();
    };
    const wait = this.charted + CHART_MILLISECONDS - performance.now();
    if (wait <= 0) charted();
    else this.charting = setTimeout(charted, wait);
  }

  /** The cut of the state; through the middle if an address has a value far outside of the gamuts. */
  private cutOf(box: Box3, axis: number, middle: number): Cut {
    const { kind, lightness, hue } = this.state;
    if (kind === "hue") return { kind, value: hue };
    const isWithin = lightness! >= box.min.getComponent(axis) && lightness! <= box.max.getComponent(axis);
    return { kind: "lightness", value: isWithin ? lightness! : middle };
  }

  /** Set the slider and its label; returns the text of the present value. */
  private label(cut: Cut, name: string, box: Box3, lightness: number): string {
    const span = box.max.getComponent(lightness) - box.min.getComponent(lightness);
    const fine = 10 ** Math.round(Math.log10(span / 100));
    const [low, high, step] = {
      lightness: [box.min.getComponent(lightness), box.max.getComponent(lightness), fine] as const,
      hue: [0, 360, 1] as const,
    }[cut.kind];
    const [from, to] = [Math.ceil(low / step), Math.floor(high / step)];
    const digits = Math.max(0, Math.ceil(-Math.log10(step)));
    const [min, max] = [from, to].map((steps) => (steps * step).toFixed(digits));
    Object.assign(this.value, { min, max, step: String(step) });
    Object.assign(this.number, { min, max, step: "any" });
    this.value.value = String(cut.value);
    if (document.activeElement !== this.number) this.number.value = String(cut.value);
    const shown = numberText(cut.value, 4);
    const text = { lightness: `${name} ${shown}`, hue: `Hue ${shown}°` }[cut.kind];
    byId("slice-label").textContent = text;
    return text;
  }

  private chartLabels(cut: Cut, names: string[], lightness: number, others: number[]): [string, string] {
    const light = `_${names[lightness]!}_`;
    if (cut.kind === "lightness") return [`_${names[others[0]!]!}_`, `_${names[others[1]!]!}_`];
    return ["Chroma", light];
  }

  /** Show a colour of the section with its recipe for the first gamut. */
  private read(point: Point): void {
    const subject = this.page.shown[0]!;
    const { gamut } = subject;
    const colour = cssColour(gamutSpace(gamut).linear(Float32Array.from(point), SCREEN));
    if (embedded !== null || !mayHaveRecipes(gamut)) this.recipe.clear();
    else this.recipe.ask((signal) => recipeLines(gamut, point, signal), "Recipe: …");
    this.readout.show({ subject, point, colour, lines: coordinates(axisNames(gamut), point), answer: this.recipe });
  }
}

function readState(state: SliceState, given: URLSearchParams): void {
  const named = given.get("diagram");
  if (named !== null && isDiagram(named)) state.kind = named;
  for (const kind of ["lightness", "hue"] as const) {
    const text = given.get(kind);
    if (text === null || !Number.isFinite(Number(text))) continue;
    state.kind = kind;
    state[kind] = Number(text);
  }
  const half = given.get("cut") as Half | null;
  if (half !== null && ["above", "below", "none"].includes(half)) state.half = half;
}

function entries({ kind, lightness, hue, half }: SliceState): [string, string | null][] {
  if (kind === "off") return [];
  if (isDiagram(kind)) return [["diagram", kind]];
  return [[kind, String(kind === "hue" ? hue : lightness)], ["cut", half === "front" ? null : half]];
}

function isPlane(kind: string): boolean {
  return (PLANES as readonly string[]).includes(kind);
}

function areaText(area: number): string {
  return area >= 100 ? Math.round(area).toLocaleString("en") : numberText(area, 4);
}

function boxOf(gamuts: Gamut[]): Box3 {
  const box = new Box3();
  for (const { bounds } of gamuts) for (const corner of bounds) box.expandByPoint(new Vector3().fromArray(corner));
  return box;
}

/** The lightness of the first cut: half of a scale to 100 or 1, such as L* 50, else the middle of the gamut. */
function middleLightness({ min, max }: Box3, axis: number): number {
  const [low, high] = [min.getComponent(axis), max.getComponent(axis)];
  // White is at the end of the scale, or a little beyond it.
  const end = 10 ** Math.ceil(Math.log10(high / 1.05));
  return high > 0.7 * end && low < 0.5 * end ? end / 2 : Number(((low + high) / 2).toPrecision(2));
}

/** The largest distance of points from an origin, along some axes. */
function farthest(all: Float32Array[], origin: Point, axes: number[]): number {
  let most = 0;
  for (const points of all) {
    for (let i = 0; i < points.length; i += 3) {
      let square = 0;
      for (const axis of axes) square += (points[i + axis]! - origin[axis]!) ** 2;
      most = Math.max(most, square);
    }
  }
  return Math.sqrt(most);
}

/** Room for the section at any value of the slider, so that the drawing does not jump. */
function frameOf(cut: Cut, plane: SectionPlane, box: Box3, reach: number): Frame {
  const around = (low: number, high: number): Place => [low + OUTSIDE * (low - high), high + OUTSIDE * (high - low)];
  const [low, high] = placesIn(plane, [...box.min.toArray(), ...box.max.toArray()]) as [Place, Place];
  return [cut.kind === "hue" ? around(-reach, reach) : around(low[0], high[0]), around(low[1], high[1])];
}

/** The colours of a frame for a screen, row by row from the top. */
function colours(space: Space, plane: SectionPlane, [[left, right], [bottom, top]]: Frame, screen: Screen): Raster {
  const { origin, right: across, up: upwards } = plane;
  const points = new Float32Array(3 * RASTER * RASTER);
  for (let row = 0; row < RASTER; row++) {
    for (let column = 0; column < RASTER; column++) {
      const h = left + ((column + 0.5) / RASTER) * (right - left);
      const v = top - ((row + 0.5) / RASTER) * (top - bottom);
      const start = 3 * (row * RASTER + column);
      for (let axis = 0; axis < 3; axis++) points[start + axis] = origin[axis]! + h * across[axis]! + v * upwards[axis]!;
    }
  }
  return { linear: space.linear(points, screen), columns: RASTER };
}

function pixels({ linear }: Raster): Uint8ClampedArray {
  const made = new Uint8ClampedArray((4 * linear.length) / 3).fill(255);
  for (let i = 0; i < linear.length; i++) made[i + Math.floor(i / 3)] = 255 * encoded(linear[i]!);
  return made;
}
