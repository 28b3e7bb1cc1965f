// A field with a list of gamuts and references: the combobox pattern of WAI-ARIA 1.2.
import { type Entry, choices } from "../service/api.js";
import { Latest } from "./latest.js";

const TYPING_MILLISECONDS = 150;

export class Chooser {
  private readonly input: HTMLInputElement;
  private readonly list: HTMLUListElement;
  private readonly clear: HTMLButtonElement;
  private entries: Entry[] = [];
  private active = -1;
  private typing = 0;
  /** Name of the chosen gamut, and whether the field has a search instead. */
  private name = "";
  private isSearch = false;
  /** Whether the list is the one of the search. */
  private isFresh = false;
  private readonly asking = new Latest();

  constructor(
    container: HTMLElement,
    label: string,
    private readonly choose: (entry: Entry | null) => void,
    private readonly fail: (error: unknown) => void,
  ) {
    const id = `chooser-${container.dataset["role"]}`;
    const text = document.createElement("label");
    text.htmlFor = id;
    text.textContent = label;
    this.input = document.createElement("input");
    Object.assign(this.input, { id, type: "text", autocomplete: "off", spellcheck: false });
    this.input.placeholder = "Choose …";
    this.list = document.createElement("ul");
    this.list.id = `${id}-list`;
    this.list.hidden = true;
    this.set(this.list, { role: "listbox", "aria-label": label });
    this.set(this.input, {
      role: "combobox",
      "aria-expanded": "false",
      "aria-controls": this.list.id,
      "aria-autocomplete": "list",
    });
    this.clear = document.createElement("button");
    Object.assign(this.clear, { type: "button", className: "clear", textContent: "×", hidden: true });
    this.clear.setAttribute("aria-label", `Remove ${label.toLowerCase()}`);
    const field = document.createElement("div");
    field.className = "field";
    field.append(this.input, this.clear);
    container.append(text, field, this.list);

    this.input.addEventListener("focus", () => this.input.select());
    this.input.addEventListener("click", () => this.open());
    this.input.addEventListener("input", () => {
      this.isSearch = this.clear.hidden = true;
      this.isFresh = false;
      this.asking.end(); // the list of the text before is nothing to take from
      clearTimeout(this.typing);
      this.typing = setTimeout(() => this.open(), TYPING_MILLISECONDS);
    });
    this.input.addEventListener("keydown", (event) => this.key(event));
    this.input.addEventListener("blur", () => {
      this.close();
      this.state(this.name);
    });
    // The field keeps the focus while the list is used.
    this.list.addEventListener("pointerdown", (event) => event.preventDefault());
    this.list.addEventListener("click", (event) => {
      const option = (event.target as Element).closest<HTMLElement>("[data-place]");
      if (option !== null) this.take(Number(option.dataset["place"]));
    });
    this.clear.addEventListener("click", () => {
      this.state("");
      this.choose(null);
      this.input.focus();
    });
  }

  /** Show the name of the chosen gamut; none is empty. What the reader types meanwhile stays. */
  show(name: string): void {
    if (this.isSearch) this.name = name;
    else this.state(name);
  }

  private state(name: string): void {
    this.isSearch = false;
    this.name = this.input.value = name;
    this.clear.hidden = name === "";
  }

  /** Ask for the list and show it, or take its first entry at once. */
  private async open(isTaken = false): Promise<void> {
    // A chosen name is no filter: the whole list is more useful.
    const text = this.isSearch ? this.input.value.trim() : "";
    await this.asking.ask(
      (signal) => choices(text, signal),
      (entries) => {
        if (document.activeElement !== this.input) return;
        this.fill(entries);
        if (isTaken) this.take(0);
      },
      this.fail,
    );
  }

  private fill(entries: Entry[]): void {
    this.entries = entries;
    this.isFresh = true;
    this.active = -1;
    const items = entries.map((entry, place) => {
      const option = this.item(entry.name, { role: "option", id: `${this.list.id}-${place}`, "aria-selected": "false" });
      option.dataset["place"] = String(place);
      const detail = document.createElement("small");
      detail.textContent = entry.detail;
      option.append(detail);
      return option;
    });
    if (items.length === 0) items.push(this.item("No gamut has this name.", { role: "presentation" }));
    this.list.replaceChildren(...items);
    this.list.hidden = false;
    for (const each of [this.list, this.input]) each.scrollIntoView({ block: "nearest" });
    this.input.setAttribute("aria-expanded", "true");
  }

  private item(text: string, attributes: Record<string, string>): HTMLElement {
    const item = document.createElement("li");
    item.textContent = text;
    this.set(item, attributes);
    return item;
  }

  private key(event: KeyboardEvent): void {
    if (event.key === "ArrowDown" || event.key === "ArrowUp") {
      event.preventDefault();
      if (this.list.hidden) void this.open();
      else this.activate(this.active + (event.key === "ArrowDown" ? 1 : -1));
    } else if (event.key === "Enter" && this.isSearch && !this.isFresh && this.active < 0) {
      event.preventDefault();
      clearTimeout(this.typing);
      if (this.input.value.trim() !== "") void this.open(true);
    } else if (event.key === "Enter" && !this.list.hidden) {
      event.preventDefault();
      this.take(Math.max(0, this.active));
    } else if (event.key === "Escape") {
      this.close();
    }
  }

  private activate(place: number): void {
    const count = this.entries.length;
    if (count === 0) return;
    this.active = (place + count) % count;
    for (const option of this.list.querySelectorAll<HTMLElement>("[data-place]")) {
      const isActive = Number(option.dataset["place"]) === this.active;
      option.setAttribute("aria-selected", String(isActive));
      if (isActive) {
        option.scrollIntoView({ block: "nearest" });
        this.input.setAttribute("aria-activedescendant", option.id);
      }
    }
  }

  private take(place: number): void {
    const entry = this.entries[place];
    if (entry === undefined) return;
    this.state(entry.name);
    this.close();
    this.choose(entry);
  }

  private close(): void {
    clearTimeout(this.typing);
    this.asking.end();
    this.list.hidden = true;
    this.input.setAttribute("aria-expanded", "false");
    this.input.removeAttribute("aria-activedescendant");
  }

  private set(element: Element, attributes: Record<string, string>): void {
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  }
}
