// Levels of a history: splits are read once, then undone and applied in place
// (docs/history-format.md, "Groups").
import { GroupColumns } from "./columns.js";
import { HistoryError } from "./errors.js";
import { type Group, type Header, HistoryFile } from "./file.js";
import { Timeline, grown } from "./timeline.js";

const LARGEST_COORDINATE = 2 ** 24;

/** A triangle mesh: x, y, z of each vertex, and three vertices for each face. */
export interface Level {
  positions: Float32Array;
  faces: Int32Array;
}

/**
 * A gamut boundary at any number of triangles, from a growing prefix of its history file.
 *
 * `append` takes the bytes of the file in order. `refineTo` moves to a level that the prefix
 * holds, finer or coarser than the present one. The first visit of a level reads its splits. Later
 * visits take time proportional to the difference of the levels.
 */
export class History {
  private readonly file = new HistoryFile();
  private opened: Opened | null = null;
  private received: Promise<void> = Promise.resolve();

  /** The history of a file, or of its beginning. */
  static async from(bytes: Uint8Array): Promise<History> {
    const history = new History();
    await history.append(bytes);
    return history;
  }

  /**
   * Append the bytes of the file that follow, and inflate the groups that are complete.
   *
   * Damage rejects this and all later calls. The levels before it remain.
   */
  append(chunk: Uint8Array): Promise<void> {
    const bytes = chunk.slice(); // the caller may reuse its buffer meanwhile
    this.received = this.received.then(() => this.receive(bytes));
    return this.received;
  }

  /** Whether the prefix holds the coarsest level. */
  get ready(): boolean {
    return this.opened !== null;
  }

  /** Number of bytes that are there. */
  get size(): number {
    return this.file.size;
  }

  get header(): Header {
    return this.open.header;
  }

  /** Vertices of the finest level that the prefix holds. */
  get vertices(): number {
    return this.open.available;
  }

  /** Triangles of the present level. */
  get triangles(): number {
    return 2 * this.open.count - 4;
  }

  /** Move to a number of triangles, 4 to 2 · vertices − 4. Odd numbers are rounded up. */
  refineTo(triangles: number): void {
    const target = Math.ceil(triangles / 2) + 2;
    if (!(target >= 4 && target <= this.open.available)) {
      throw new RangeError(`there is no level of ${triangles} triangles`);
    }
    this.open.moveTo(target);
  }

  /** The present level. */
  get level(): Level {
    const { positions, corners, count, header } = this.open;
    const scaled = new Float32Array(3 * count);
    for (let i = 0; i < scaled.length; i++) scaled[i] = positions.values[i]! * header.step;
    return { positions: scaled, faces: corners.slice(0, 6 * count - 12) };
  }

  /** Device values of the present level in 0 to 1, slot by slot; null if the gamut has none. */
  get deviceValues(): Float32Array | null {
    const { device, count, header } = this.open;
    if (device === null) return null;
    const scale = header.device!.steps;
    return Float32Array.from(device.values.subarray(0, device.width * count), (v) => v / scale);
  }

  private get open(): Opened {
    if (this.opened === null) throw new HistoryError("the coarsest level is not there yet");
    return this.opened;
  }

  private async receive(bytes: Uint8Array): Promise<void> {
    this.file.append(bytes);
    const { header } = this.file;
    if (header === null) return;
    this.opened ??= new Opened(header);
    for (;;) {
      const next = await this.file.nextGroup();
      if (next === null) return;
      this.opened.receive(next.group, next.content);
    }
  }
}

/** The state of a history whose coarsest level is known. */
class Opened {
  /** Vertices of the present level. */
  count = 4;
  /** Vertices of the finest level that the prefix holds. */
  available = 4;
  /** The slot at each corner. */
  corners: Int32Array<ArrayBuffer>;
  readonly positions: Timeline;
  readonly device: Timeline | null;
  /** Vertices of the finest level that was read. */
  private decoded = 4;
  /** Groups that were inflated and not read. */
  private readonly inflated: { group: Group; content: Uint8Array }[] = [];
  private reader: GroupReader | null = null;
  /** By split: the parent, and the end of its part of the moved corners. */
  private parents = new Int32Array(0);
  private ends = new Int32Array(1);
  private moved = new Int32Array(0);

  constructor(readonly header: Header) {
    this.positions = new Timeline(3, header.positions);
    this.corners = Int32Array.from(header.faces);
    const { device } = header;
    this.device = device === null ? null : new Timeline(device.channels.length, device.base);
  }

  receive(group: Group, content: Uint8Array): void {
    if (this.available < group.start) return; // behind a split that is not valid
    this.inflated.push({ group, content });
    this.available = group.end;
  }

  moveTo(count: number): void {
    while (this.count < count) this.refine();
    while (this.count > count) this.coarsen();
  }

  private refine(): void {
    const slot = this.count;
    const split = slot - 4;
    if (slot === this.decoded) {
      try {
        this.readSplit(slot);
      } catch (error) {
        this.cancel(slot);
        throw error;
      }
    } else {
      this.positions.apply(split);
      this.device?.apply(split);
      for (let i = this.ends[split]!; i < this.ends[split + 1]!; i++) {
        this.corners[this.moved[i]!] = slot;
      }
    }
    this.addFaces(slot);
    this.count += 1;
  }

  /** Return to the level before a split that is not valid, which is then the finest one. */
  private cancel(slot: number): void {
    const split = slot - 4;
    for (let corner = 0; corner < 6 * slot - 12; corner++) {
      if (this.corners[corner] === slot) this.corners[corner] = this.parents[split]!;
    }
    this.positions.cancel(split);
    this.device?.cancel(split);
    this.available = slot;
  }

  private coarsen(): void {
    const slot = --this.count;
    const split = slot - 4;
    for (let i = this.ends[split]!; i < this.ends[split + 1]!; i++) {
      this.corners[this.moved[i]!] = this.parents[split]!;
    }
    this.positions.undo(split);
    this.device?.undo(split);
  }

  private addFaces(slot: number): void {
    const { corners, moved, ends } = this;
    const split = slot - 4;
    const parent = this.parents[split]!;
    const left = corners[previousCorner(moved[ends[split + 1]! - 1]!)]!;
    const right = corners[nextCorner(moved[ends[split]!]!)]!;
    corners.set([parent, slot, left, slot, parent, right], 6 * slot - 12);
  }

  /** Read a split, check it, and apply it to all but the new faces. */
  private readSplit(slot: number): void {
    const split = slot - 4;
    if (this.reader === null || this.reader.group.end === slot) this.openGroup();
    const reader = this.reader!;
    const row = slot - reader.group.start;
    const parent = reader.parent[row]!;
    if (parent < 0 || parent >= slot) throw new HistoryError("a parent does not exist");
    this.parents[split] = parent;
    this.readFan(reader, row, slot, parent);
    const shifted = reader.shiftedOf(row);
    shifted.forEach((neighbour, i) => {
      const before = i > 0 ? shifted[i - 1]! : -1;
      if (neighbour <= before || neighbour >= slot || neighbour === parent) {
        throw new HistoryError("a neighbour that moves does not exist");
      }
    });
    const first = reader.shiftedEnd - shifted.length;
    const far = LARGEST_COORDINATE;
    write(this.positions, reader.positions, row, split, parent, shifted, first, -far, far);
    if (this.device !== null) {
      const most = this.header.device!.steps;
      write(this.device, reader.device!, row, split, parent, shifted, first, 0, most);
    }
    this.decoded += 1;
  }

  /** Give the corners of a split that move to the new slot; they must be a fan of the parent. */
  private readFan(reader: GroupReader, row: number, slot: number, parent: number): void {
    const { corners, ends } = this;
    const split = slot - 4;
    const begin = ends[split]!;
    const fan = reader.movedOf(row);
    let last = -1;
    for (const corner of fan) {
      // a corner that has moved is no longer at the parent, so none moves twice
      if (corner < 0 || corner >= 6 * slot - 12 || corners[corner] !== parent) {
        throw new HistoryError("a corner that moves is not at the parent");
      }
      if (last >= 0 && corners[previousCorner(last)] !== corners[nextCorner(corner)]) {
        throw new HistoryError("the corners that move are no fan");
      }
      corners[corner] = slot;
      last = corner;
    }
    const left = corners[previousCorner(last)];
    if (fan.length === 0 || left === corners[nextCorner(fan[0]!)]) {
      throw new HistoryError("the parent keeps no face, or all");
    }
    this.moved = grown(this.moved, begin + fan.length, true);
    this.moved.set(fan, begin);
    ends[split + 1] = begin + fan.length;
  }

  private openGroup(): void {
    const { group, content } = this.inflated.shift()!;
    this.reader = new GroupReader(group, new GroupColumns(this.header.columns, group, content));
    this.positions.reserve(group.end);
    this.device?.reserve(group.end);
    this.corners = grown(this.corners, 6 * group.end - 12);
    this.parents = grown(this.parents, group.end - 4);
    this.ends = grown(this.ends, group.end - 3);
  }
}

/** Columns of values at slots: positions or device values. */
interface ValueColumns {
  middle: Int32Array;
  edge: Int32Array;
  shift: Int32Array;
}

/** Reads the splits of a group in order. */
class GroupReader {
  readonly parent: Int32Array;
  readonly positions: ValueColumns;
  readonly device: ValueColumns | null;
  /** End of the rows of neighbours that were read. */
  shiftedEnd = 0;
  private movedEnd = 0;

  constructor(
    readonly group: Group,
    private readonly columns: GroupColumns,
  ) {
    this.parent = columns.of("parent");
    const values = (kind: string) => ({
      middle: columns.of(`${kind}middle`),
      edge: columns.of(`${kind}edge`),
      shift: columns.of(`${kind}shift`),
    });
    this.positions = values("");
    this.device = columns.of("device_edge") === undefined ? null : values("device_");
    for (const name of ["moved", "shifted"] as const) {
      const sum = columns.of(`${name}_count`).reduce((total, count) => total + count, 0);
      if (sum !== group[name]) throw new HistoryError("the counts are not those of the rows");
    }
  }

  movedOf(row: number): Int32Array {
    const begin = this.movedEnd;
    this.movedEnd += this.columns.of("moved_count")[row]!;
    return this.columns.of("moved").subarray(begin, Math.max(begin, this.movedEnd));
  }

  shiftedOf(row: number): Int32Array {
    const begin = this.shiftedEnd;
    this.shiftedEnd += this.columns.of("shifted_count")[row]!;
    return this.columns.of("shifted").subarray(begin, Math.max(begin, this.shiftedEnd));
  }
}

/** Write and record the values of a split. */
function write(
  timeline: Timeline,
  { middle, edge, shift }: ValueColumns,
  row: number,
  split: number,
  parent: number,
  shifted: Int32Array,
  first: number,
  least: number,
  most: number,
): void {
  const { values, width } = timeline;
  const put = (slot: number, place: number, value: number) => {
    if (value < least || value > most) throw new HistoryError("a value is out of range");
    values[width * slot + place] = value;
  };
  timeline.remember(parent);
  for (let place = 0; place < width; place++) {
    const long = edge[width * row + place]!;
    const fine = values[width * parent + place]! + middle[width * row + place]! - (long >> 1);
    put(parent, place, fine);
    put(split + 4, place, fine + long);
  }
  shifted.forEach((slot, i) => {
    timeline.remember(slot);
    for (let place = 0; place < width; place++) {
      put(slot, place, values[width * slot + place]! + shift[width * (first + i) + place]!);
    }
  });
  timeline.close(split);
}

/** The next corner of the face of a corner. */
function nextCorner(corner: number): number {
  return corner % 3 === 2 ? corner - 2 : corner + 1;
}

/** The corner before a corner in its face. */
function previousCorner(corner: number): number {
  return corner % 3 === 0 ? corner + 2 : corner - 1;
}
