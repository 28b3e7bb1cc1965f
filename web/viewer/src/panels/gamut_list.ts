// The list of gamuts: for each its name, its style, and a button that removes it.
import { Chooser } from "../page/chooser.js";
import { byId, element } from "../page/elements.js";
import { embedded } from "../page/embedded.js";
import { type Page, STYLE_NAMES } from "../page/page.js";
import { SLOTS, type Slot, tintOf } from "../page/slots.js";
import type { Style } from "../scene/layer.js";
import { volumeText, volumeUnit } from "./conditions.js";

const NAMES: Record<Slot, string> = {
  a: "First gamut",
  b: "Second gamut",
  c: "Third gamut",
  d: "Fourth gamut",
  e: "Fifth gamut",
  f: "Sixth gamut",
};
/** Rows that are always there. */
const LEAST_ROWS = 2;

interface Row {
  box: HTMLElement;
  chooser: Chooser;
  style: HTMLSelectElement;
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
    page.on("gamuts", () => this.refresh());
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
    const style = element("select", "", { id: `style-${slot}` });
    style.setAttribute("aria-label", `Style of the ${NAMES[slot].toLowerCase()}`);
    style.append(...Object.entries(STYLE_NAMES).map(([value, text]) => element("option", text, { value })));
    style.addEventListener("change", () => this.page.setStyle(slot, style.value as Style));
    const volume = element("span", "", { className: "volume" });
    box.append(volume, field, name, style, element("div", "", { className: "waiting" }));
    return { box, chooser, style, mark, name, volume };
  }

  private refresh(): void {
    const { page } = this;
    const isUsed = (slot: Slot) => page.at(slot) !== null || this.rows.get(slot)!.box.querySelector(".work") !== null;
    this.count = Math.max(this.count, SLOTS.findLastIndex(isUsed) + 1);
    SLOTS.forEach((slot, place) => {
      const { box, chooser, style, mark, name, volume } = this.rows.get(slot)!;
      const shown = page.at(slot);
      box.hidden = place >= this.count || (embedded !== null && shown === null);
      style.value = page.styles[slot];
      mark.style.backgroundColor = tintOf(slot, page.isDark);
      volume.textContent = shown === null ? "" : `${volumeText(shown.gamut)} ${volumeUnit(shown.gamut)}`;
      if (embedded !== null) name.replaceChildren(mark, shown?.gamut.name ?? "");
      chooser.show(shown?.gamut.name ?? "");
    });
    byId("add").hidden = this.count >= SLOTS.length;
    byId("legend").replaceChildren(
      ...page.shown.map(({ slot, gamut }) => {
        const text = `${gamut.name} · ${STYLE_NAMES[page.styles[slot]].toLowerCase()}`;
        const mark = element("span", "", { className: "tint" });
        mark.style.backgroundColor = tintOf(slot, page.isDark);
        const line = element("p", text, { title: text });
        line.prepend(mark);
        return line;
      }),
    );
  }
}
