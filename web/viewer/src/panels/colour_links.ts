// Rows of the list of colours and their points in the view: each shows the other, and a label.
import { type Matrix4, Vector3 } from "three";
import { byId } from "../page/elements.js";
import type { Page } from "../page/page.js";
import type { SortedTable } from "./sorted_table.js";

/** A pointer this near to a point, in CSS pixels, is at it. */
const REACH = 10;
/** A pointer that moved farther than this between down and up turned the view. */
const CLICK_REACH = 4;

/** Points of a list as they are drawn. */
export interface Points {
  colours: number[][];
  /** From the space of the gamut to the scene. */
  placement: Matrix4;
  label(row: number): string;
}

export class ColourLinks {
  private places: Vector3[] = [];
  private label: (row: number) => string = String;
  private hovered: number | null = null;
  private chosen: number | null = null;
  private down: [number, number] | null = null;
  private pointer: PointerEvent | null = null;
  private readonly output = byId("colour-label");

  constructor(
    private readonly page: Page,
    private readonly table: SortedTable,
  ) {
    table.onHover = (row) => this.mark(row, this.chosen, null);
    table.onChoose = (row) => this.mark(null, row, row);
    page.view.onDraw.push(() => this.place());
    const { canvas } = page;
    canvas.addEventListener("pointermove", (event) => {
      if (this.places.length === 0 || event.buttons !== 0) return;
      if (this.pointer === null) requestAnimationFrame(() => this.follow());
      this.pointer = event;
    });
    canvas.addEventListener("pointerleave", () => {
      this.pointer = null; // a move that still waits for its frame
      this.mark(null, this.chosen, null);
    });
    canvas.addEventListener("pointerdown", ({ clientX, clientY }) => (this.down = [clientX, clientY]));
    canvas.addEventListener("pointerup", ({ clientX, clientY }) => {
      const { down } = this;
      this.down = null;
      if (down === null || Math.hypot(clientX - down[0], clientY - down[1]) > CLICK_REACH) return;
      const row = this.nearest(clientX, clientY);
      if (row !== null) this.mark(this.hovered, row === this.chosen ? null : row, row);
    });
  }

  show({ colours, placement, label }: Points): void {
    this.places = colours.map((colour) => new Vector3().fromArray(colour).applyMatrix4(placement));
    this.label = label;
    this.mark(null, null, null);
  }

  clear(): void {
    this.places = [];
    this.mark(null, null, null);
  }

  private follow(): void {
    const { pointer } = this;
    this.pointer = null;
    if (pointer === null) return;
    const row = this.nearest(pointer.clientX, pointer.clientY);
    if (row !== this.hovered) this.mark(row, this.chosen, row);
  }

  private mark(hovered: number | null, chosen: number | null, inSight: number | null): void {
    this.hovered = hovered;
    this.chosen = chosen;
    this.table.mark(hovered, chosen, inSight);
    this.place();
  }

  /** The point under the pointer; the one in front if several are as near. */
  private nearest(clientX: number, clientY: number): number | null {
    const box = this.page.canvas.getBoundingClientRect();
    let nearest: number | null = null;
    let least = REACH;
    this.places.forEach((place, row) => {
      const [x, y] = this.page.view.stagePlace(place.clone());
      const away = Math.hypot(x - (clientX - box.left), y - (clientY - box.top));
      if (away >= least) return;
      least = away;
      nearest = row;
    });
    return nearest;
  }

  /** Put the label at its point, which moves with the camera. */
  private place(): void {
    const row = this.hovered ?? this.chosen;
    const place = row === null ? undefined : this.places[row];
    this.output.hidden = place === undefined;
    if (place === undefined) return;
    const [x, y] = this.page.view.stagePlace(place.clone());
    const text = this.label(row!);
    if (this.output.textContent !== text) this.output.textContent = text;
    // The label stays within the view, also of points at its edge.
    const half = this.output.offsetWidth / 2 + 6;
    const { clientWidth } = this.page.canvas;
    this.output.style.left = `${Math.min(Math.max(x, half), Math.max(half, clientWidth - half))}px`;
    this.output.style.top = `${y < 60 ? y + 26 : y - 26}px`;
  }
}
