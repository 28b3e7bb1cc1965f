// Slices and diagrams: the state, its controls, the cut in the view, and the figure beside it.
import { pageTheme } from "../charts/save.js";
import { SCREEN, cssColour } from "../colours/colours.js";
import { gamutSpace } from "../colours/spaces.js";
import { openPart } from "../page/elements.js";
import { embedded } from "../page/embedded.js";
import { type Page, type Shown, axisNames } from "../page/page.js";
import { CutAway } from "../scene/cut.js";
import type { Point } from "../scene/sections.js";
import type { Gamut } from "../service/api.js";
import { mayHaveRecipes } from "../service/queries.js";
import { diagram, diagramName, isDiagram } from "./diagrams.js";
import { PlaneHandle } from "./plane_handle.js";
import { PlaneSection, middleLightness } from "./plane_section.js";
import { AnswerLines, type PagePlace, type Readout, coordinates, recipeLines } from "./readout.js";
import { SectionFigure } from "./section_figure.js";
import { SliceControls } from "./slice_controls.js";
import { type SliceState, entries, isPlane, readState } from "./slice_state.js";

/** Time in ms for which the pointer rests before a recipe is asked for. */
const REST = 120;
/** Least time in ms between two charts while the plane moves. */
const CHART_MILLISECONDS = 100;

export class SlicePanel {
  private readonly state: SliceState = { kind: "off", lightness: null, hue: 40, half: "front" };
  private readonly cut: CutAway;
  private readonly handle: PlaneHandle;
  private readonly controls: SliceControls;
  readonly figure = new SectionFigure(() => this.change({ kind: "off" }));
  private readonly recipe = new AnswerLines(REST);
  /** What the lightness is in. */
  private space = "";
  /** When the chart of a section was drawn last, and the timer of the next time. */
  private charted = -Infinity;
  private charting = 0;

  constructor(
    private readonly page: Page,
    private readonly readout: Readout,
  ) {
    this.cut = new CutAway(page.view);
    this.handle = new PlaneHandle(page);
    this.controls = new SliceControls((changes) => this.change(changes), () => this.cut.isAboveCut);
    page.address.add({
      read: (given) => {
        readState(this.state, given);
        if (this.state.kind !== "off") openPart("cut");
      },
      write: () => entries(this.state),
    });
    page.on(["slots", "looks", "level", "theme"], () => this.draw());
    page.on(["camera"], () => this.cut.follow());
    page.readable.push({
      targets: () => (isPlane(this.state.kind) ? [this.cut.cap] : []),
      read: ({ point }) => this.read(this.cut.pointOf(point)),
    });
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
    const { cut, controls, figure, handle, page, state } = this;
    const shown = page.shown.filter(({ layer }) => layer.level !== null);
    if (shown.length > 0) this.followSpace(shown[0]!.gamut);
    const isOn = state.kind !== "off" && shown.length > 0;
    controls.show(state, isOn, page.shown.length > 0);
    if (!isOn || !isPlane(state.kind)) {
      cut.hide(shown.map(({ layer }) => layer));
      handle.hide();
    }
    if (!isOn) return figure.close();
    figure.open();
    if (!isDiagram(state.kind)) return this.drawPlane(shown);
    const drawing = diagram(state.kind, shown, page.isDark);
    if (typeof drawing === "string") figure.say(drawing);
    else figure.show(drawing, diagramName(state.kind, page));
  }

  /** X, Y and Z have no hue. The lightness of another space means nothing in this one. */
  private followSpace(gamut: Gamut): void {
    const { state } = this;
    const hasHue = gamutSpace(gamut).lightness === 0;
    this.controls.offerHue(hasHue);
    if (!hasHue && state.kind === "hue") state.kind = "lightness";
    const { space } = gamut.options;
    if (this.space !== "" && this.space !== space) state.lightness = null;
    this.space = space;
    state.lightness ??= middleLightness(gamut);
  }

  private drawPlane(shown: Shown[]): void {
    const { controls, cut, figure, handle, page, state } = this;
    const section = new PlaneSection(shown, page, state);
    const { value } = section.cut;
    controls.setValue(section.cut, section.title, section.box, section.lightness);
    cut.show(section.inView(state.half, pageTheme(figure.box)));
    handle.show(
      (moved) => cut.screen(section.handlePoints(moved)[0]),
      section.title,
      section.cut.kind === "hue" ? { place: () => cut.screen(section.handlePoints(value)[1]), text: `Hue ${(value + 180) % 360}°` } : undefined,
    );
    this.chartLater(() => figure.show(section.chart(), section.name));
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
