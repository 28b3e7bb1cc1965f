// The list of gamuts: for each its name, whether it is shown, its opacity, and a button that removes it.
import { Chooser } from "../page/chooser.js";
import { byId, element } from "../page/elements.js";
import { embedded } from "../page/embedded.js";
import type { Page } from "../page/page.js";
import { SLOTS, type Slot, tintOf } from "../page/slots.js";
import { volumeText, volumeUnit } from "./conditions.js";

const NAMES: Record<Slot, string> = {
  a: "First gamut",
  b: "Second gamut",
  c: "Third gamut",
  d: "Fourth gamut",
  e: "Fifth gamut",
  f: "Sixth gamut",
};
/** An eye; a line through it is shown while the button is not pressed. */
const EYE = `<svg viewBox="0 0 24 24" width="20" height="20" aria-hidden="true" fill="none" stroke="currentColor" stroke-width="1.8"><path d="M2 12Q12 0 22 12Q12 24 2 12Z"/><circle cx="12" cy="12" r="3.2"/><path class="closed" d="M4 21L20 3"/></svg>`;
/** Rows that are always there. */
const LEAST_ROWS = 2;

interface Row {
  box: HTMLElement;
  chooser: Chooser;
  eye: HTMLButtonElement;
  opacity: HTMLInputElement;
  mark: HTMLElement;
  name: HTMLElement;
  volume: HTMLElement;
}

export class GamutList {
  private readonly rows: Map<Slot, Row>;
  private count = LEAST_ROWS;

  constructor(private readonly page: Page) {
    this.rows = new Map(SLOTS.map((slot) => [slot, this.row(slot)]));
    byId("gamut-list").append(...[...this.rows.values()].map(({ box }) => box));
    byId("add").addEventListener("click", () => {
      this.count = Math.min(SLOTS.length, this.count + 1);
      this.refresh();
      byId(`chooser-${SLOTS[this.count - 1]!}`).focus();
    });
    page.on(["slots", "looks", "requests", "theme"], () => this.refresh());
    this.refresh();
  }

  private row(slot: Slot): Row {
    const box = element("div", "", { className: "gamut-row" });
    const field = element("div", "", { className: "chooser online" });
    box.dataset["slot"] = field.dataset["role"] = slot;
    const chooser = new Chooser(
      field,
      NAMES[slot],
      (entry) => void this.page.show(slot, entry?.key ?? null),
      (error) => this.page.complain(error),
    );
    const mark = element("span", "", { className: "tint" });
    // A saved page has its gamuts' names in place of the fields that choose them.
    const name = element("span", "", { className: "saved-name", hidden: embedded === null });
    (embedded === null ? field.querySelector("label")! : name).prepend(mark);
    const gamut = NAMES[slot].toLowerCase();
    const eye = element("button", "", { id: `eye-${slot}`, type: "button", className: "eye", innerHTML: EYE });
    eye.addEventListener("click", () => this.page.setVisible(slot, !this.page.lookOf(slot).isVisible));
    eye.setAttribute("aria-label", `Show the ${gamut}`);
    const opacity = element("input", "", { id: `opacity-${slot}`, type: "range", min: "0.05", max: "1", step: "0.05", title: "Opacity" });
    opacity.setAttribute("aria-label", `Opacity of the ${gamut}`);
    opacity.addEventListener("input", () => this.page.setOpacity(slot, opacity.valueAsNumber));
    const volume = element("span", "", { className: "volume" });
    box.append(field, name, volume, eye, opacity, element("div", "", { className: "waiting" }));
    return { box, chooser, eye, opacity, mark, name, volume };
  }

  private refresh(): void {
    const { page } = this;
    const isUsed = (slot: Slot) => page.at(slot) !== null || this.rows.get(slot)!.box.querySelector(".work") !== null;
    this.count = Math.max(this.count, SLOTS.findLastIndex(isUsed) + 1);
    SLOTS.forEach((slot, place) => {
      const { box, chooser, eye, opacity, mark, name, volume } = this.rows.get(slot)!;
      const shown = page.at(slot);
      box.hidden = place >= this.count || (embedded !== null && shown === null);
      const look = page.lookOf(slot);
      eye.setAttribute("aria-pressed", String(look.isVisible));
      opacity.value = String(look.opacity);
      eye.disabled = opacity.disabled = shown === null;
      mark.style.backgroundColor = tintOf(slot, page.isDark);
      volume.replaceChildren(...(shown === null ? [] : [volumeText(shown.gamut), element("span", ` ${volumeUnit(shown.gamut)}`, { className: "unit" })]));
      if (embedded !== null) name.replaceChildren(mark, shown?.gamut.name ?? "");
      chooser.show(shown?.gamut.name ?? "");
    });
    byId("add").hidden = this.count >= SLOTS.length;
    byId("legend").replaceChildren(
      ...page.shown.filter(({ slot }) => page.lookOf(slot).isVisible).map(({ slot, gamut }) => {
        const mark = element("span", "", { className: "tint" });
        mark.style.backgroundColor = tintOf(slot, page.isDark);
        const line = element("p", gamut.name, { title: gamut.name });
        line.prepend(mark);
        return line;
      }),
    );
  }
}
