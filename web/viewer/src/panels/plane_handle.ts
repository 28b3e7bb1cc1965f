// The handle of the section's plane in the view: it moves the plane along its normal, or turns it.
import { byId } from "../page/elements.js";
import type { Page } from "../page/page.js";
import type { Place } from "../scene/sections.js";

/** Distance in pixels that labels keep from the edges of the view. */
const EDGE = { x: 44, y: 22 };
/** Where a value is moved for each pixel if its direction cannot be seen: fewer pixels than this. */
const LEAST_PIXELS = 0.4;

/** Move the slider of the section by steps; a hue begins again after 360°. */
export function stepSection(steps: number): void {
  const slider = byId<HTMLInputElement>("slice-value");
  if (slider.closest("[hidden]") === null) setSlider(slider.valueAsNumber + steps * Number(slider.step));
}

function setSlider(value: number): void {
  const slider = byId<HTMLInputElement>("slice-value");
  const turns = slider.max === "360";
  slider.value = String(turns ? ((value % 360) + 360) % 360 : value);
  slider.dispatchEvent(new Event("input"));
}

export class PlaneHandle {
  private readonly handle = byId("plane-handle");
  private readonly opposite = byId("plane-opposite");
  private placeOf: ((value: number) => Place) | null = null;
  private oppositePlace: () => Place = () => [0, 0];
  private value = 0;

  constructor(page: Page) {
    const { handle } = this;
    let dragged: number | null = null;
    let last: Place = [0, 0];
    handle.addEventListener("pointerdown", (event) => {
      handle.setPointerCapture(event.pointerId);
      dragged = this.value;
      last = [event.clientX, event.clientY];
    });
    handle.addEventListener("pointermove", (event) => {
      if (dragged === null || this.placeOf === null) return;
      dragged += this.along([event.clientX - last[0], event.clientY - last[1]]);
      last = [event.clientX, event.clientY];
      setSlider(dragged);
    });
    for (const end of ["pointerup", "pointercancel"] as const) handle.addEventListener(end, () => (dragged = null));
    handle.addEventListener("keydown", (event) => {
      const steps = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1, PageUp: 5, PageDown: -5 }[event.key];
      if (steps === undefined) return;
      event.preventDefault();
      stepSection(steps);
    });
    page.on(["camera"], () => this.draw());
    new ResizeObserver(() => this.draw()).observe(byId("stage"));
  }

  /**
   * Show the handle. `placeOf` gives the place on the stage of its point for any value; the second
   * label is that of the other side of a hue.
   */
  show(placeOf: (value: number) => Place, text: string, opposite?: { place: () => Place; text: string }): void {
    const { min, max, valueAsNumber } = byId<HTMLInputElement>("slice-value");
    this.value = valueAsNumber;
    this.placeOf = placeOf;
    this.handle.hidden = false;
    byId("plane-text").textContent = text;
    const attributes = { valuemin: min, valuemax: max, valuenow: String(valueAsNumber), valuetext: text };
    for (const [name, value] of Object.entries(attributes)) this.handle.setAttribute(`aria-${name}`, value);
    this.opposite.hidden = opposite === undefined;
    if (opposite !== undefined) {
      this.opposite.textContent = opposite.text;
      this.oppositePlace = opposite.place;
    }
    this.draw();
  }

  hide(): void {
    this.placeOf = null;
    this.handle.hidden = this.opposite.hidden = true;
  }

  private draw(): void {
    if (this.placeOf === null) return;
    const { clientWidth, clientHeight } = byId("stage");
    const put = (label: HTMLElement, [x, y]: Place) => {
      label.style.left = `${Math.min(Math.max(x, EDGE.x), clientWidth - EDGE.x)}px`;
      label.style.top = `${Math.min(Math.max(y, EDGE.y), clientHeight - EDGE.y)}px`;
    };
    put(this.handle, this.placeOf(this.value));
    put(this.opposite, this.oppositePlace());
    const [x, y] = this.way();
    byId("plane-arrow").style.rotate = `${Math.atan2(y, x)}rad`;
  }

  /** Pixels on the stage for each unit of the value. */
  private way(): Place {
    const [from, to] = [this.placeOf!(this.value), this.placeOf!(this.value + 1)];
    return [to[0] - from[0], to[1] - from[1]];
  }

  /** The change of the value for a movement of the pointer. */
  private along([dx, dy]: Place): number {
    let [x, y] = this.way();
    const slider = byId<HTMLInputElement>("slice-value");
    const least = (LEAST_PIXELS * byId("stage").clientHeight) / (2 * (Number(slider.max) - Number(slider.min)));
    // Along the line of sight nothing would move: upwards is more.
    if (Math.hypot(x, y) < least) [x, y] = [0, -least / LEAST_PIXELS];
    return (dx * x + dy * y) / (x * x + y * y);
  }
}
