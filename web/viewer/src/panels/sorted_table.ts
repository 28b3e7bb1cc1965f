// A table of any length that is sorted by a column. Only the rows in sight are elements of the page.
import { element } from "../page/elements.js";
import { sentenceOf } from "../page/glossary.js";

export interface Column {
  title: string;
  /** What the rows are sorted by. */
  value(row: number): number | string;
  /** What a cell shows; by default the value. */
  cell?(row: number): string | Node;
}

/** Height of a row in CSS pixels, as in the style sheet. */
const ROW = 30;
/** Rows above and below those in sight, so that a quick scroll finds them there. */
const MARGIN = 12;

export class SortedTable {
  private order: number[] = [];
  private columns: Column[] = [];
  private sorted: { title: string; ascending: boolean } | null = null;
  private readonly head = element("tr");
  private readonly body = element("tbody");
  private readonly caption = element("caption");
  private readonly table = element("table", "", { className: "sorted" });
  private from = -Infinity;
  /** The rows that are marked: under the pointer, and chosen. */
  private hovered: number | null = null;
  private chosen: number | null = null;
  /** The pointer is at another row, or at none. */
  onHover: (row: number | null) => void = () => {};
  /** Another row is chosen, by a click or a key; null if the chosen one is clicked again. */
  onChoose: (row: number | null) => void = () => {};

  constructor(private readonly box: HTMLElement) {
    const top = element("thead");
    top.append(this.head);
    this.table.append(this.caption, top, this.body);
    box.addEventListener("scroll", () => this.draw(), { passive: true });
    const rowAt = ({ target }: Event) => {
      const row = (target as Element).closest<HTMLElement>("tr[data-row]");
      return row === null ? null : Number(row.dataset["row"]);
    };
    this.body.addEventListener("pointerover", (event) => this.onHover(rowAt(event)));
    this.body.addEventListener("pointerleave", () => this.onHover(null));
    this.body.addEventListener("click", (event) => {
      const row = rowAt(event);
      this.onChoose(row === this.chosen ? null : row);
    });
    box.addEventListener("keydown", (event) => {
      const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
      if (step === undefined || event.target !== box || this.order.length === 0) return;
      event.preventDefault();
      const place = this.chosen === null ? -1 : this.order.indexOf(this.chosen);
      this.onChoose(this.order[Math.min(this.order.length - 1, Math.max(0, place + step))]!);
    });
  }

  /** Mark rows. The row that `inSight` names is scrolled to. */
  mark(hovered: number | null, chosen: number | null, inSight: number | null = null): void {
    this.hovered = hovered;
    this.chosen = chosen;
    const place = inSight === null ? -1 : this.order.indexOf(inSight);
    if (place >= 0) {
      const { box, head } = this;
      const top = (this.caption.offsetHeight || 0) + place * ROW;
      const room = box.clientHeight - head.offsetHeight - ROW;
      if (top < box.scrollTop || top > box.scrollTop + room) box.scrollTop = Math.max(0, top - room / 2);
      this.draw();
    }
    for (const row of this.body.rows) this.markRow(row);
  }

  private markRow(row: HTMLTableRowElement): void {
    const number = Number(row.dataset["row"] ?? NaN);
    row.classList.toggle("hovered", number === this.hovered);
    if (number === this.chosen) row.setAttribute("aria-current", "true");
    else row.removeAttribute("aria-current");
  }

  /** Show rows. The order stays if the column is still there. */
  show(caption: string, columns: Column[], rows: number): void {
    this.caption.textContent = caption;
    this.columns = columns;
    this.order = Array.from({ length: rows }, (_, row) => row);
    this.table.setAttribute("aria-rowcount", String(rows + 1));
    if (columns.every(({ title }) => title !== this.sorted?.title)) this.sorted = null;
    this.box.replaceChildren(this.table);
    this.box.hidden = false;
    this.sort();
  }

  clear(): void {
    this.sorted = this.hovered = this.chosen = null;
    this.order = [];
    this.box.replaceChildren();
    this.box.hidden = true;
  }

  private sort(): void {
    const { sorted, order } = this;
    order.sort((one, other) => one - other);
    if (sorted !== null) {
      const { value } = this.columns.find(({ title }) => title === sorted.title)!;
      const sign = sorted.ascending ? 1 : -1;
      order.sort((one, other) => sign * compared(value(one), value(other)));
    }
    this.head.replaceChildren(...this.columns.map((column, place) => this.title(column, place)));
    this.from = -Infinity;
    this.draw();
  }

  private title({ title }: Column, place: number): HTMLElement {
    const cell = element("th");
    cell.scope = "col";
    const isSorted = this.sorted?.title === title;
    const ascending = isSorted && this.sorted!.ascending;
    if (isSorted) cell.setAttribute("aria-sort", ascending ? "ascending" : "descending");
    const button = element("button", title, { type: "button" });
    const sentence = sentenceOf(title);
    if (sentence !== undefined) button.dataset["note"] = sentence;
    if (isSorted) button.append(element("span", ascending ? " ▲" : " ▼", { ariaHidden: "true" }));
    button.addEventListener("click", () => {
      // Once ascending, once descending, then the order of the list.
      this.sorted = !isSorted ? { title, ascending: true } : ascending ? { title, ascending: false } : null;
      this.sort();
      this.head.querySelectorAll("button")[place]?.focus();
    });
    cell.append(button);
    return cell;
  }

  private draw(): void {
    const count = this.order.length;
    const from = Math.max(0, Math.min(count, Math.floor(this.box.scrollTop / ROW) - MARGIN));
    // The first rows have no rows above them that could stand in.
    if (Math.abs(from - this.from) < MARGIN / 2 && (from > 0 || this.from === 0)) return;
    this.from = from;
    const until = Math.min(count, from + Math.ceil((this.box.clientHeight || 400) / ROW) + 3 * MARGIN);
    const space = (rows: number) => {
      const row = element("tr", "", { ariaHidden: "true" });
      const cell = element("td", "", { colSpan: this.columns.length });
      cell.style.height = `${rows * ROW}px`;
      row.append(cell);
      return row;
    };
    this.body.replaceChildren(
      ...(from > 0 ? [space(from)] : []),
      ...this.order.slice(from, until).map((row, place) => this.row(row, from + place)),
      ...(until < count ? [space(count - until)] : []),
    );
  }

  private row(row: number, place: number): HTMLElement {
    const made = element("tr");
    made.ariaRowIndex = String(place + 2);
    made.dataset["row"] = String(row);
    made.append(
      ...this.columns.map(({ cell, value }, column) => {
        const shown = cell?.(row) ?? String(value(row));
        const box = element(column === 0 ? "th" : "td");
        if (column === 0) (box as HTMLTableCellElement).scope = "row";
        box.append(shown);
        return box;
      }),
    );
    this.markRow(made);
    return made;
  }
}

function compared(one: number | string, other: number | string): number {
  if (typeof one === "number" && typeof other === "number") return one - other;
  return String(one).localeCompare(String(other), "en", { numeric: true });
}
