// Device values of slots (docs/history-format.md, "Device values").
import { BitReader, CLASSES, Contexts } from "./bits.js";
import { HistoryError } from "./errors.js";
import type { DeviceHeader } from "./file.js";
import { Timeline } from "./timeline.js";

const KINDS = 3;

/** Device values at the present level; read along the positions of the same splits. */
export class DeviceValues {
  readonly timeline: Timeline;
  /** Vertices of the finest level that was read. */
  decoded = 4;
  private reader: BitReader | null = null;
  private end = 4;
  private readonly contexts: Contexts;

  constructor(
    private readonly header: DeviceHeader,
    base: Int32Array,
  ) {
    this.timeline = new Timeline(header.channels.length, base);
    this.contexts = new Contexts(2 * KINDS * header.channels.length * CLASSES, () => 32);
  }

  /** Begin a group that ends before slot `end`. */
  begin(stream: Uint8Array, end: number): void {
    this.reader = new BitReader(stream);
    this.end = end;
    this.timeline.reserve(end);
  }

  /** Values in 0 to 1 of the first slots. */
  level(count: number): Float32Array {
    const { values, width } = this.timeline;
    const scale = this.header.steps;
    return Float32Array.from(values.subarray(0, width * count), (value) => value / scale);
  }

  /** Read a split whose positions have been applied. */
  read(slot: number, positions: Timeline): void {
    const { header, timeline, contexts } = this;
    const reader = this.reader!;
    const split = slot - 4;
    const count = header.channels.length;
    const changed = positions.changed(split);
    const parent = changed[0]!;
    const { place, length } = placement(positions, split, parent, slot);
    const number = (kind: number, channel: number, old: number) => {
      const between = old > 0 && old < header.steps ? 1 : 0;
      const context = ((kind * count + channel) * 2 + between) * CLASSES + length;
      return reader.signed(contexts, context);
    };
    const put = (whose: number, channel: number, value: number) => {
      if (value < 0 || value > header.steps) {
        throw new HistoryError("a device value is beyond full scale");
      }
      timeline.values[count * whose + channel] = value;
    };
    const isCorrected = slot < header.corrected;
    timeline.remember(parent);
    for (let channel = 0; channel < count; channel++) {
      const old = timeline.values[count * parent + channel]!;
      const change = number(0, channel, old);
      const correction = isCorrected ? number(1, channel, old) : 0;
      const here = old - correction - Math.floor(place * change + 0.5);
      put(parent, channel, here);
      put(slot, channel, here + change);
    }
    if (isCorrected) {
      for (const neighbour of changed.slice(1).sort()) {
        timeline.remember(neighbour);
        for (let channel = 0; channel < count; channel++) {
          const old = timeline.values[count * neighbour + channel]!;
          put(neighbour, channel, old + number(2, channel, old));
        }
      }
    }
    timeline.close(split);
    this.decoded += 1;
    if (this.decoded === this.end) reader.finish();
  }
}

/** Where the old position of the parent projects onto the new edge, and the class of its length. */
function placement(positions: Timeline, split: number, parent: number, slot: number) {
  const before = positions.parentBefore(split);
  let along = 0;
  let square = 0;
  let distance = 0;
  for (let axis = 0; axis < 3; axis++) {
    const fine = positions.values[3 * parent + axis]!;
    const edge = positions.values[3 * slot + axis]! - fine;
    along += (before[axis]! - fine) * edge;
    square += edge * edge;
    distance += Math.abs(edge);
  }
  let length = 0;
  while (length < CLASSES - 1 && !(distance < 2 ** length)) length++;
  return { place: square === 0 ? 0 : Math.min(1, Math.max(0, along / square)), length };
}
