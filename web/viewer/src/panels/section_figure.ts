// The figure of a section beside the view: its size, its chart, and the chart as a file.
import { saveChart, showChart } from "../charts/save.js";
import { byId, element } from "../page/elements.js";
import type { Size } from "../charts/chart.js";

const FORMATS = ["svg", "png"] as const;
const LEAST_SIZE = 200;
const STEP = 20;
/** Pixels of a PNG file for each CSS pixel. */
const PNG_FACTOR = 3;

export class SectionFigure {
  readonly box = byId("section-chart");
  private readonly figure = byId("section");
  private svg = "";
  private name = "";

  constructor(
    private readonly redraw: () => void,
    close: () => void,
  ) {
    for (const format of FORMATS) {
      byId(`section-${format}`).addEventListener("click", () => void saveChart(this.svg, this.name, format, PNG_FACTOR));
    }
    byId("section-close").addEventListener("click", close);
    this.connectSize();
    new ResizeObserver(() => this.figure.hidden || this.redraw()).observe(this.box);
  }

  get size(): Size {
    return { width: Math.max(LEAST_SIZE, this.box.clientWidth), height: Math.max(LEAST_SIZE, this.box.clientHeight) };
  }

  open(): void {
    this.figure.hidden = false;
  }

  close(): void {
    this.figure.hidden = true;
    this.box.replaceChildren();
  }

  show(svg: string, name: string): void {
    this.keep(svg, name);
    showChart(this.box, svg);
  }

  /** Show a sentence in place of a chart. There is nothing to save. */
  say(sentence: string): void {
    this.keep("", "");
    this.box.replaceChildren(element("p", sentence, { className: "note" }));
  }

  private keep(svg: string, name: string): void {
    this.svg = svg;
    this.name = name;
    for (const format of FORMATS) byId<HTMLButtonElement>(`section-${format}`).disabled = svg === "";
  }

  /** The edge between the view and the figure moves with the pointer and with arrow keys. */
  private connectSize(): void {
    const edge = byId("section-size");
    const isBelow = () => this.figure.getBoundingClientRect().top > byId("stage").getBoundingClientRect().top + 10;
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
