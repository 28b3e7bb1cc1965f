// Options of builds: a line in each row of the list, and one form that changes them.
import { INTENTS } from "../panels/conditions.js";
import type { Gamut } from "../service/api.js";
import { byId, element } from "./elements.js";
import type { Slot } from "./slots.js";

/** Options as the service takes them. */
export interface Chosen {
  intent: string;
  space: string;
  ink_limit?: number;
}

/** The options that a gamut was built with. */
export function optionsOf({ options, provenance }: Gamut): Chosen {
  const limit = provenance.ink_limits?.total ?? null;
  return { intent: provenance.intent ?? "", space: options.space, ...(limit === null ? {} : { ink_limit: limit }) };
}

function optionsText({ intent, ink_limit: limit, space }: Chosen): string {
  const white = intent === "" ? "Colours as given" : intent[0]!.toUpperCase() + intent.slice(1);
  return [white, limit === undefined ? "no ink limit" : `ink limit ${limit}\u00a0%`, space].join(" · ");
}

export class BuildOptions {
  private readonly form = byId<HTMLFormElement>("options");
  private readonly intent = byId<HTMLSelectElement>("intent");
  private readonly limit = byId<HTMLInputElement>("ink-limit");
  private readonly space = byId<HTMLSelectElement>("space");
  private readonly lines = new Map<Slot, HTMLElement>();
  private slot: Slot | null = null;

  /** `apply` builds the gamut of a slot again. */
  constructor(private readonly apply: (slot: Slot, chosen: Chosen) => void) {
    for (const row of document.querySelectorAll<HTMLElement>(".gamut-row")) {
      const slot = row.dataset["slot"] as Slot;
      const line = element("p", "", { className: "options-line", hidden: true });
      const button = element("button", "Change", { type: "button", className: "link" });
      button.setAttribute("aria-expanded", "false");
      button.setAttribute("aria-label", `Change the options of the gamut ${slot.toUpperCase()}`);
      button.addEventListener("click", () => (this.slot === slot ? this.close() : this.open(slot)));
      line.append(element("span"), " ", button);
      row.append(line);
      this.lines.set(slot, line);
    }
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      const slot = this.slot!;
      this.close();
      this.apply(slot, this.chosen);
    });
    byId("options-close").addEventListener("click", () => this.close());
    this.intent.addEventListener("change", () => this.explain());
  }

  /** The options of the form, which hold for the next file as well. */
  get chosen(): Chosen {
    const limit = this.limit.value === "" || !this.limit.checkValidity() ? {} : { ink_limit: this.limit.valueAsNumber };
    return { intent: this.intent.value, space: this.space.value, ...limit };
  }

  /** State the options that the gamut of a slot has; the form begins with those that were asked for. */
  state(slot: Slot, options: Chosen | null, asked: Chosen | null): void {
    const line = this.lines.get(slot)!;
    line.hidden = options === null && asked === null;
    if (line.hidden && this.slot === slot) this.close();
    line.dataset["options"] = JSON.stringify(asked ?? options);
    line.firstElementChild!.textContent = options === null ? "" : optionsText(options);
  }

  /** Show the form in the row of a slot. `source` tells what will be built. */
  open(slot: Slot): void {
    this.close();
    this.slot = slot;
    const line = this.lines.get(slot)!;
    const stated = JSON.parse(line.dataset["options"] ?? "null") as Chosen | null;
    if (stated !== null) {
      this.intent.value = stated.intent || "relative";
      this.space.value = stated.space;
      this.limit.value = stated.ink_limit === undefined ? "" : String(stated.ink_limit);
    }
    line.after(this.form);
    this.form.hidden = false;
    line.querySelector("button")!.setAttribute("aria-expanded", "true");
    this.explain();
    this.intent.focus();
  }

  private close(): void {
    if (this.slot === null) return;
    const button = this.lines.get(this.slot)!.querySelector("button")!;
    button.setAttribute("aria-expanded", "false");
    if (this.form.contains(document.activeElement)) button.focus();
    this.form.hidden = true;
    this.slot = null;
  }

  private explain(): void {
    byId("intent-note").textContent = INTENTS[this.intent.value]!;
  }
}
