// Values of slots over the splits: positions or device values.

/**
 * Integers of all slots at the present level, with a record of their changes.
 *
 * A split changes its parent and may change neighbours. The record keeps both values of each
 * change, so that the splits can be undone and applied again without reading the file.
 */
export class Timeline {
  /** `width` integers per slot. Those of slots beyond the level are those of their birth. */
  values: Int32Array<ArrayBuffer>;
  private ends = new Int32Array(1);
  private slots = new Int32Array(64);
  private before: Int32Array<ArrayBuffer>;
  private after: Int32Array<ArrayBuffer>;
  private changes = 0;

  constructor(
    readonly width: number,
    base: Int32Array,
  ) {
    this.values = Int32Array.from(base);
    this.before = new Int32Array(64 * width);
    this.after = new Int32Array(64 * width);
  }

  /** Make room for so many slots. */
  reserve(slots: number): void {
    this.values = grown(this.values, this.width * slots);
    this.ends = grown(this.ends, slots - 3);
  }

  /** Record that a value is about to be replaced. */
  remember(slot: number): void {
    if (this.changes === this.slots.length) {
      this.slots = grown(this.slots, 2 * this.changes);
      this.before = grown(this.before, 2 * this.changes * this.width);
      this.after = grown(this.after, 2 * this.changes * this.width);
    }
    this.slots[this.changes] = slot;
    this.copy(this.values, slot, this.before, this.changes++);
  }

  /** Record the new values: the split is complete. */
  close(split: number): void {
    for (let i = this.ends[split]!; i < this.changes; i++) {
      this.copy(this.values, this.slots[i]!, this.after, i);
    }
    this.ends[split + 1] = this.changes;
  }

  /** Undo what was remembered of a split that is not complete. */
  cancel(split: number): void {
    for (let i = this.ends[split]!; i < this.changes; i++) {
      this.copy(this.before, i, this.values, this.slots[i]!);
    }
    this.changes = this.ends[split]!;
  }

  apply(split: number): void {
    for (let i = this.ends[split]!; i < this.ends[split + 1]!; i++) {
      this.copy(this.after, i, this.values, this.slots[i]!);
    }
  }

  undo(split: number): void {
    for (let i = this.ends[split]!; i < this.ends[split + 1]!; i++) {
      this.copy(this.before, i, this.values, this.slots[i]!);
    }
  }

  private copy(source: Int32Array, from: number, target: Int32Array, to: number): void {
    const { width } = this;
    for (let i = 0; i < width; i++) target[width * to + i] = source[width * from + i]!;
  }
}

/** The array with at least so many elements, or twice as many as before if it grows often. */
export function grown(
  array: Int32Array<ArrayBuffer>,
  length: number,
  often = false,
): Int32Array<ArrayBuffer> {
  if (array.length >= length) return array;
  const larger = new Int32Array(often ? Math.max(length, 2 * array.length) : length);
  larger.set(array);
  return larger;
}
