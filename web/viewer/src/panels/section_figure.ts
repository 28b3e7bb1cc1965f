// The figure of a section beside the view: its size, its chart, and the chart as a file.
import type { Size, Theme } from "../charts/chart.js";
import { pageTheme, saveChart, showChart } from "../charts/save.js";
import { byId, element } from "../page/elements.js";
import type { Point } from "../scene/sections.js";

const FORMATS = ["svg", "png"] as const;
const LEAST_SIZE = 200;
const STEP = 20;
/** Pixels of a PNG file for each CSS pixel. */
const PNG_FACTOR = 3;

export interface SectionDrawing {
  svg: string;
  /** The colour at a pixel of a section. */
  pointAt?: (x: number, y: number) => Point | null;
}

/** Draws the chart in a size. */
export type SectionDraw = (options: { size: Size; theme: Theme }) => SectionDrawing;

export class SectionFigure {
  readonly box = byId("section-chart");
  private readonly figure = byId("section");
  private draw: SectionDraw | null = null;
  private svg = "";
  private name = "";
  /** The colour at a pixel of the chart; null where there is none. */
  pointAt: (x: number, y: number) => Point | null = () => null;

  constructor(close: () => void) {
    for (const format of FORMATS) {
      byId(`section-${format}`).addEventListener("click", () => void saveChart(this.svg, this.name, format, PNG_FACTOR));
    }
    byId("section-close").addEventListener("click", close);
    this.connectSize();
    new ResizeObserver(() => this.redraw()).observe(this.box);
  }

  /** Whether the figure is under the view, and not beside it. */
  get isBelow(): boolean {
    return this.figure.getBoundingClientRect().top > byId("stage").getBoundingClientRect().top + 10;
  }

  /** Size of the figure on the page; null while it has no chart. */
  get size(): Size | null {
    return this.draw && { width: this.figure.offsetWidth, height: this.figure.offsetHeight };
  }

  /** The chart in another size and other colours. */
  svgFor(options: { size: Size; theme: Theme }): string {
    return this.draw?.(options).svg ?? "";
  }

  open(): void {
    this.figure.hidden = false;
  }

  close(): void {
    this.figure.hidden = true;
    this.draw = null;
    this.pointAt = () => null;
    this.box.replaceChildren();
  }

  show(draw: SectionDraw, name: string): void {
    this.draw = draw;
    this.name = name;
    this.redraw();
  }

  /** Show a sentence in place of a chart. There is nothing to save. */
  say(sentence: string): void {
    this.draw = null;
    this.pointAt = () => null;
    this.box.replaceChildren(element("p", sentence, { className: "note" }));
    this.enableSaving();
  }

  private redraw(): void {
    if (this.draw === null) return;
    const { clientWidth, clientHeight } = this.box;
    const size = { width: Math.max(LEAST_SIZE, clientWidth), height: Math.max(LEAST_SIZE, clientHeight) };
    const { svg, pointAt = () => null } = this.draw({ size, theme: pageTheme(this.box) });
    Object.assign(this, { svg, pointAt });
    showChart(this.box, svg);
    this.enableSaving();
  }

  private enableSaving(): void {
    for (const format of FORMATS) byId<HTMLButtonElement>(`section-${format}`).disabled = this.draw === null;
  }

  /** The edge between the view and the figure moves with the pointer and with arrow keys. */
  private connectSize(): void {
    const edge = byId("section-size");
    const isBelow = () => this.isBelow;
    const resize = (size: number) => {
      const room = this.figure.parentElement!.getBoundingClientRect();
      const most = 0.6 * (isBelow() ? room.height : room.width);
      const pixels = Math.round(Math.min(Math.max(size, LEAST_SIZE + 40), most));
      document.documentElement.style.setProperty("--section", `${pixels}px`);
      edge.setAttribute("aria-valuenow", String(pixels));
      edge.setAttribute("aria-valuemax", String(Math.round(most)));
    };
    const turn = () => edge.setAttribute("aria-orientation", isBelow() ? "horizontal" : "vertical");
    new ResizeObserver(turn).observe(this.figure);
    const present = () => (isBelow() ? this.figure.offsetHeight : this.figure.offsetWidth);
    let end: number | null = null;
    edge.addEventListener("pointerdown", (event) => {
      edge.setPointerCapture(event.pointerId);
      end = present() + (isBelow() ? event.clientY : event.clientX);
    });
    edge.addEventListener("pointermove", (event) => {
      if (end !== null) resize(end - (isBelow() ? event.clientY : event.clientX));
    });
    for (const up of ["pointerup", "pointercancel"] as const) edge.addEventListener(up, () => (end = null));
    edge.addEventListener("keydown", (event) => {
      const steps = { ArrowLeft: 1, ArrowUp: 1, ArrowRight: -1, ArrowDown: -1 }[event.key];
      if (steps === undefined) return;
      event.preventDefault();
      resize(present() + steps * STEP);
    });
  }
}
