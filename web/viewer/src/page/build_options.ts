// Options of the next build: rendering intent, ink limit and space.
import { INTENTS } from "../panels/conditions.js";
import { byId } from "./elements.js";

export class BuildOptions {
  private readonly box = byId<HTMLDetailsElement>("options");
  private readonly intent = byId<HTMLSelectElement>("intent");
  private readonly limit = byId<HTMLInputElement>("ink-limit");
  private readonly space = byId<HTMLSelectElement>("space");

  constructor(rebuild: () => void) {
    this.box.addEventListener("change", () => this.summarise());
    byId("rebuild").addEventListener("click", rebuild);
    this.summarise();
  }

  /** The options as the service takes them; null, and the field is shown, if the ink limit is not valid. */
  chosen(): Record<string, string | number> | null {
    if (!this.limit.checkValidity()) {
      this.open();
      this.limit.reportValidity();
      return null;
    }
    const limit = this.limit.value === "" ? {} : { ink_limit: this.limit.valueAsNumber };
    return { intent: this.intent.value, space: this.space.value, ...limit };
  }

  open(): void {
    this.box.open = true;
  }

  /** Offer to build a file again; without one, say what to do for the gamut that is shown, if any. */
  offer(file: File | undefined, shown: string | undefined): void {
    byId("rebuild").hidden = file === undefined;
    byId("rebuild-note").textContent =
      file !== undefined ? `The file is ${file.name}.`
      : shown !== undefined ? `To build ${shown} with other options, choose its file again.`
      : "The options apply to the next file.";
  }

  private summarise(): void {
    const limit = this.limit.value === "" ? "no ink limit" : `ink limit ${this.limit.value}\u00a0%`;
    byId("options-summary").textContent = `${this.intent.value}, ${limit}, ${this.space.value}`;
    byId("intent-note").textContent = INTENTS[this.intent.value]!;
  }
}
