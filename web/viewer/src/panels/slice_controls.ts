// The controls of sections: what is beside the view, the value of a plane, and which half is shown.
import type { Box3 } from "three";
import { byId, element } from "../page/elements.js";
import type { Cut } from "../scene/sections.js";
import { DIAGRAMS } from "./diagrams.js";
import { type SliceState, isPlane } from "./slice_state.js";

/** What the sections and diagrams are. */
const SENTENCES: Partial<Record<SliceState["kind"], string>> = {
  lightness: "All colours of one lightness.",
  hue: "All colours of one hue: an angle around the grey axis. Chroma is the distance from grey.",
  xy: "Colours without their lightness. The colours of the spectrum are on the curve around them.",
  uv: "Colours without their lightness. The colours of the spectrum are on the curve around them.",
};

export class SliceControls {
  private readonly kind = byId<HTMLSelectElement>("slice-kind");
  private readonly value = byId<HTMLInputElement>("slice-value");
  private readonly number = byId<HTMLInputElement>("slice-number");
  private readonly open = byId<HTMLInputElement>("slice-open");

  /** `change` takes what the reader changes; a turn of the half needs to know which one is away. */
  constructor(change: (changes: Partial<SliceState>) => void, isAboveCut: () => boolean) {
    const { kind, number, open, value } = this;
    const diagrams = element("optgroup", "", { label: "Diagrams" });
    diagrams.append(...Object.entries(DIAGRAMS).map(([name, text]) => element("option", text, { value: name })));
    kind.append(diagrams);
    kind.addEventListener("change", () => change({ kind: kind.value as SliceState["kind"], half: "front" }));
    value.addEventListener("input", () => change({ [kind.value]: value.valueAsNumber }));
    number.addEventListener("change", () => {
      const { max, min, valueAsNumber } = number;
      const typed = Number.isNaN(valueAsNumber) ? value.valueAsNumber : Math.min(Math.max(valueAsNumber, Number(min)), Number(max));
      number.value = String(typed);
      change({ [kind.value]: typed });
    });
    byId("slice-flip").addEventListener("click", () => change({ half: isAboveCut() ? "below" : "above" }));
    open.addEventListener("change", () => change({ half: open.checked ? "front" : "none" }));
  }

  /** Show the state; `isOn` tells whether something is drawn. */
  show({ kind, half }: SliceState, isOn: boolean, hasGamuts: boolean): void {
    const hasPlane = isOn && isPlane(kind);
    const sentence = isOn ? SENTENCES[kind] : undefined;
    this.kind.value = kind;
    this.kind.disabled = !hasGamuts;
    byId("slice-note").hidden = sentence === undefined;
    byId("slice-note").textContent = sentence ?? "";
    byId("slice-row").hidden = byId("slice-half").hidden = !hasPlane;
    this.open.checked = half !== "none";
    byId<HTMLButtonElement>("slice-flip").disabled = half === "none";
  }

  /** Offer sections by hue, or do not. */
  offerHue(hasHue: boolean): void {
    byId<HTMLOptionElement>("slice-hue").disabled = !hasHue;
  }

  /** Set the slider, the number and their label. */
  setValue({ kind, value }: Cut, text: string, box: Box3, lightness: number): void {
    const [bottom, top] = [box.min.getComponent(lightness), box.max.getComponent(lightness)];
    const [low, high, step] = kind === "hue" ? [0, 360, 1] : [bottom, top, 10 ** Math.round(Math.log10((top - bottom) / 100))];
    const digits = Math.max(0, Math.ceil(-Math.log10(step)));
    const [min, max] = [Math.ceil(low / step), Math.floor(high / step)].map((steps) => (steps * step).toFixed(digits));
    Object.assign(this.value, { min, max, step: String(step) });
    Object.assign(this.number, { min, max, step: "any" });
    this.value.value = String(value);
    if (document.activeElement !== this.number) this.number.value = String(value);
    byId("slice-label").textContent = text;
  }
}
