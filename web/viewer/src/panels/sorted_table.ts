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

  constructor(private readonly box: HTMLElement) {
    const top = element("thead");
    top.append(this.head);
    this.table.append(this.caption, top, this.body);
    box.addEventListener("scroll", () => this.draw(), { passive: true });
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
    this.sorted = null;
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
    made.append(
      ...this.columns.map(({ cell, value }, column) => {
        const shown = cell?.(row) ?? String(value(row));
        const box = element(column === 0 ? "th" : "td");
        if (column === 0) (box as HTMLTableCellElement).scope = "row";
        box.append(shown);
        return box;
      }),
    );
    return made;
  }
}

function compared(one: number | string, other: number | string): number {
  if (typeof one === "number" && typeof other === "number") return one - other;
  return String(one).localeCompare(String(other), "en", { numeric: true });
}
