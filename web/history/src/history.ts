// Levels of a history: splits are read once, then undone and applied in place
// (docs/history-format.md, "How is a split read?").
import { BitReader, CLASSES, Contexts } from "./bits.js";
import { DeviceValues } from "./device.js";
import { HistoryError } from "./errors.js";
import { type Header, HistoryFile } from "./file.js";
import { Timeline, grown } from "./timeline.js";

const LARGEST_COORDINATE = 2 ** 24;
const KINDS = 7;
const KEPT = 0;
const PARENT_ALONG = CLASSES;
const PARENT_OFF = 2 * CLASSES;
const ADDED_ALONG = 3 * CLASSES;
const ADDED_OFF = 4 * CLASSES;
const SHIFTED_ALONG = 5 * CLASSES;
const SHIFTED_OFF = 6 * CLASSES;

/** A triangle mesh: x, y, z of each vertex, and three vertices for each face. */
export interface Level {
  positions: Float32Array;
  faces: Int32Array;
}

/**
 * A gamut boundary at any number of triangles, from a growing prefix of its history file.
 *
 * `append` takes the bytes of the file in order. `refineTo` moves to a level that the prefix
 * holds, finer or coarser than the present one. The first visit of a level reads the file. Later
 * visits take time proportional to the difference of the levels.
 */
export class History {
  private readonly file = new HistoryFile();
  private opened: Opened | null = null;

  /** @param bytes The beginning of the file, of any length. */
  constructor(bytes?: Uint8Array) {
    if (bytes !== undefined) this.append(bytes);
  }

  /** Append the bytes of the file that follow. */
  append(chunk: Uint8Array): void {
    this.file.append(chunk);
    const { header } = this.file;
    if (this.opened === null && header !== null) this.opened = new Opened(this.file, header);
    this.opened?.receive();
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

  /**
   * Device values of the present level in 0 to 1, slot by slot.
   *
   * Null if the gamut has none, or if the prefix does not hold those of this level. They are at
   * the end of the file.
   */
  get deviceValues(): Float32Array | null {
    return this.open.deviceValues();
  }

  private get open(): Opened {
    if (this.opened === null) throw new HistoryError("the coarsest level is not there yet");
    return this.opened;
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
  private device: DeviceValues | null = null;
  /** Vertices of the finest level that was read. */
  private decoded = 4;
  private group = 0;
  private reader: BitReader | null = null;
  private groupShifts = false;
  private readonly contexts = new Contexts(KINDS * CLASSES, (context) =>
    Math.floor(2 ** (context % CLASSES) / 2),
  );
  /** The next corner around the slot of each corner, counter-clockwise. */
  private around: Int32Array<ArrayBuffer>;
  /** One corner at each slot. */
  private anyCorner = new Int32Array(4);
  /** By split: the parent, and the corners at it where ring faces 0 and n begin. */
  private parents = new Int32Array(0);
  private firsts = new Int32Array(0);
  private cuts = new Int32Array(0);
  /** The ring of the parent: corners at the parent, and neighbours relative to it. */
  private ring = new Int32Array(16);
  private dx = new Float64Array(16);
  private dy = new Float64Array(16);
  private dz = new Float64Array(16);

  constructor(
    private readonly file: HistoryFile,
    readonly header: Header,
  ) {
    this.positions = new Timeline(3, header.positions);
    this.corners = Int32Array.from(header.faces);
    this.around = new Int32Array(12);
    const byEdge = new Map<number, number>();
    for (let corner = 0; corner < 12; corner++) {
      const slot = this.corners[corner]!;
      this.anyCorner[slot] = corner;
      byEdge.set(4 * slot + this.corners[following(corner)]!, corner);
    }
    for (let corner = 0; corner < 12; corner++) {
      const edge = 4 * this.corners[corner]! + this.corners[preceding(corner)]!;
      this.around[corner] = byEdge.get(edge)!;
    }
  }

  /** Find how far the prefix reaches. */
  receive(): void {
    while (this.group < this.header.groups && this.file.stream("splits", this.group) !== null) {
      this.available = Math.min(this.header.vertices, 4 * 2 ** ++this.group);
    }
    if (this.device === null && this.header.device !== null) {
      const base = this.file.deviceBase;
      if (base !== null) this.device = new DeviceValues(this.header.device, base);
    }
  }

  moveTo(count: number): void {
    while (this.count < count) this.refine();
    while (this.count > count) this.coarsen();
  }

  deviceValues(): Float32Array | null {
    const { device, count } = this;
    if (device === null) return null;
    if (device.decoded < count && (!isPowerOfTwo(device.decoded) || this.deviceStream() !== null)) {
      // They are read along the positions, so the level is passed again.
      this.moveTo(device.decoded);
      this.moveTo(count);
    }
    return device.decoded < count ? null : device.level(count);
  }

  private refine(): void {
    const slot = this.count;
    const split = slot - 4;
    if (slot === this.decoded) {
      this.readSplit(slot);
      this.decoded += 1;
    } else {
      this.positions.apply(split);
    }
    if (this.device !== null) this.refineDevice(this.device, slot);
    this.connect(slot, this.parents[split]!, this.firsts[split]!, this.cuts[split]!);
    this.count += 1;
  }

  private refineDevice(device: DeviceValues, slot: number): void {
    if (slot < device.decoded) {
      device.timeline.apply(slot - 4);
      return;
    }
    if (slot > device.decoded) return;
    if (isPowerOfTwo(slot)) {
      const stream = this.deviceStream();
      if (stream === null) return;
      device.begin(stream, Math.min(2 * slot, this.header.vertices));
    }
    device.read(slot, this.positions);
  }

  /** The stream of the next device values if they begin a group; null if it is not there. */
  private deviceStream(): Uint8Array | null {
    return this.file.stream("device", Math.log2(this.device!.decoded) - 2);
  }

  private coarsen(): void {
    const slot = --this.count;
    const split = slot - 4;
    this.disconnect(slot, this.parents[split]!, this.firsts[split]!, this.cuts[split]!);
    this.positions.undo(split);
    if (this.device !== null && slot < this.device.decoded) this.device.timeline.undo(split);
  }

  private reserve(slots: number): void {
    this.positions.reserve(slots);
    this.corners = grown(this.corners, 6 * slots - 12);
    this.around = grown(this.around, 6 * slots - 12);
    this.anyCorner = grown(this.anyCorner, slots);
    this.parents = grown(this.parents, slots - 4);
    this.firsts = grown(this.firsts, slots - 4);
    this.cuts = grown(this.cuts, slots - 4);
  }

  private readSplit(slot: number): void {
    if (isPowerOfTwo(slot)) {
      this.reader = new BitReader(this.file.stream("splits", Math.log2(slot) - 2)!);
      this.groupShifts = this.reader.bits(1) === 1;
      this.reserve(Math.min(2 * slot, this.header.vertices));
    }
    const reader = this.reader!;
    const split = slot - 4;
    const parent = reader.below(slot);
    const degree = this.readRing(reader, parent);
    const code = reader.adaptive(this.contexts, KEPT);
    if (code > degree - 2) throw new HistoryError("the parent keeps more faces than it has");
    const half = Math.ceil(degree / 2);
    const kept = half + code < degree ? half + code : degree - 1 - code;
    this.readPositions(reader, parent, slot, degree, kept);
    this.parents[split] = parent;
    this.firsts[split] = this.ring[0]!;
    this.cuts[split] = this.ring[kept]!;
    if (isPowerOfTwo(slot + 1) || slot + 1 === this.header.vertices) reader.finish();
  }

  /** Read where the ring of a parent starts, and put it into `ring`. Return the degree. */
  private readRing(reader: BitReader, parent: number): number {
    const { around } = this;
    const begin = this.anyCorner[parent]!;
    let first = begin;
    let degree = 0;
    let corner = begin;
    do {
      if (corner < first) first = corner; // a slot has one corner in a face
      degree += 1;
      corner = around[corner]!;
    } while (corner !== begin);
    corner = first;
    for (let turn = reader.below(degree); turn > 0; turn--) corner = around[corner]!;
    if (degree > this.ring.length) {
      this.ring = new Int32Array(2 * degree);
      [this.dx, this.dy, this.dz] = [0, 1, 2].map(() => new Float64Array(2 * degree)) as Triple;
    }
    for (let i = 0; i < degree; i++, corner = around[corner]!) this.ring[i] = corner;
    return degree;
  }

  private readPositions(
    reader: BitReader,
    parent: number,
    slot: number,
    degree: number,
    kept: number,
  ): void {
    const { contexts, corners, positions, ring, dx, dy, dz } = this;
    const split = slot - 4;
    const { values } = positions;
    const here: [number, number, number] = [
      values[3 * parent]!,
      values[3 * parent + 1]!,
      values[3 * parent + 2]!,
    ];
    for (let i = 0; i < degree; i++) {
      const at = 3 * corners[following(ring[i]!)]!;
      dx[i] = values[at]! - here[0];
      dy[i] = values[at + 1]! - here[1];
      dz[i] = values[at + 2]! - here[2];
    }
    let nx = 0;
    let ny = 0;
    let nz = 0;
    let distance = 0;
    for (let i = 0; i < degree; i++) {
      const j = i + 1 === degree ? 0 : i + 1;
      nx += dy[i]! * dz[j]! - dz[i]! * dy[j]!;
      ny += dz[i]! * dx[j]! - dx[i]! * dz[j]!;
      nz += dx[i]! * dy[j]! - dy[i]! * dx[j]!;
      distance += Math.abs(dx[i]!) + Math.abs(dy[i]!) + Math.abs(dz[i]!);
    }
    const normal = [nx, ny, nz];
    let w = Math.abs(ny) > Math.abs(nx) ? 1 : 0;
    if (Math.abs(nz) > Math.abs(normal[w]!)) w = 2;
    const u = (w + 1) % 3;
    const v = (w + 2) % 3;
    const flat = normal[w] === 0;
    const slopeU = flat ? 0 : -normal[u]! / normal[w]!;
    const slopeV = flat ? 0 : -normal[v]! / normal[w]!;
    const relative = [dx, dy, dz];
    const du = relative[u]!;
    const dv = relative[v]!;
    const dw = relative[w]!;
    let off = 0;
    for (let i = 0; i < degree; i++) {
      off += Math.abs(dw[i]! - (slopeU * du[i]! + slopeV * dv[i]!));
    }
    const size = lengthClass(distance, degree);
    const height = lengthClass(off, degree);

    const plane = (along: number, across: number) =>
      Math.floor(slopeU * along + slopeV * across + 0.5);
    const put = (whose: number, x: number, y: number, z: number, a: number, b: number, c: number) => {
      const from = [x, y, z];
      from[u]! += a;
      from[v]! += b;
      from[w]! += c;
      for (let axis = 0; axis < 3; axis++) {
        const value = from[axis]!;
        if (Math.abs(value) > LARGEST_COORDINATE) throw new HistoryError("a position is too large");
        values[3 * whose + axis] = value;
      }
    };

    positions.remember(parent);
    const a = ahead(du, degree, kept) + reader.signed(contexts, PARENT_ALONG + size);
    const b = ahead(dv, degree, kept) + reader.signed(contexts, PARENT_ALONG + size);
    const c = plane(a, b) + reader.signed(contexts, PARENT_OFF + height);
    put(parent, ...here, a, b, c);
    const a2 = -a + reader.signed(contexts, ADDED_ALONG + height);
    const b2 = -b + reader.signed(contexts, ADDED_ALONG + height);
    const c2 = plane(a2, b2) + reader.signed(contexts, ADDED_OFF + height);
    put(slot, ...here, a2, b2, c2);

    if (this.groupShifts && reader.bits(1) === 1) {
      for (let i = 0; i < degree; i++) {
        if (reader.bits(1) === 0) continue;
        const s = reader.signed(contexts, SHIFTED_ALONG + size);
        const t = reader.signed(contexts, SHIFTED_ALONG + size);
        const q = plane(s, t) + reader.signed(contexts, SHIFTED_OFF + height);
        const moved = corners[following(ring[i]!)]!;
        positions.remember(moved);
        const at = 3 * moved;
        put(moved, values[at]!, values[at + 1]!, values[at + 2]!, s, t, q);
      }
    }
    positions.close(split);
  }

  /** Give ring faces n to D − 1 to the new slot, and add its two faces. */
  private connect(slot: number, parent: number, first: number, cut: number): void {
    const { corners, around } = this;
    const one = 6 * slot - 12;
    const two = one + 3;
    const left = corners[following(first)]!;
    const right = corners[following(cut)]!;
    let lastKept = first;
    while (around[lastKept] !== cut) lastKept = around[lastKept]!;
    let last = cut;
    corners[cut] = slot;
    while (around[last] !== first) {
      last = around[last]!;
      corners[last] = slot;
    }
    corners[one] = parent;
    corners[one + 1] = slot;
    corners[one + 2] = left;
    corners[two] = slot;
    corners[two + 1] = parent;
    corners[two + 2] = right;
    around[lastKept] = two + 1;
    around[two + 1] = one;
    around[one] = first;
    around[last] = one + 1;
    around[one + 1] = two;
    around[two] = cut;
    around[following(first)] = one + 2;
    around[one + 2] = preceding(last);
    around[following(cut)] = two + 2;
    around[two + 2] = preceding(lastKept);
    this.anyCorner[parent] = first;
    this.anyCorner[slot] = cut;
  }

  /** Undo `connect`. */
  private disconnect(slot: number, parent: number, first: number, cut: number): void {
    const { corners, around } = this;
    const one = 6 * slot - 12;
    const two = one + 3;
    let lastKept = first;
    while (around[lastKept] !== two + 1) lastKept = around[lastKept]!;
    let last = cut;
    corners[cut] = parent;
    while (around[last] !== one + 1) {
      last = around[last]!;
      corners[last] = parent;
    }
    around[lastKept] = cut;
    around[last] = first;
    around[following(first)] = preceding(last);
    around[following(cut)] = preceding(lastKept);
    this.anyCorner[parent] = first;
    this.anyCorner[corners[following(first)]!] = following(first);
    this.anyCorner[corners[following(cut)]!] = following(cut);
  }
}

type Triple = [Float64Array<ArrayBuffer>, Float64Array<ArrayBuffer>, Float64Array<ArrayBuffer>];

/** The next corner of the face of a corner. */
function following(corner: number): number {
  return corner % 3 === 2 ? corner - 2 : corner + 1;
}

/** The corner before a corner in its face. */
function preceding(corner: number): number {
  return corner % 3 === 0 ? corner + 2 : corner - 1;
}

function isPowerOfTwo(value: number): boolean {
  return (value & (value - 1)) === 0;
}

/** The smallest class with `total` < degree · 2^class, at most the last. */
function lengthClass(total: number, degree: number): number {
  let found = 0;
  while (found < CLASSES - 1 && !(total < degree * 2 ** found)) found++;
  return found;
}

/** Predicted movement of the parent along one axis. */
function ahead(d: Float64Array, degree: number, kept: number): number {
  let near = 0;
  for (let i = 0; i <= kept; i++) near += d[i]!;
  let far = 0;
  for (let i = kept; i < degree; i++) far += d[i]!;
  far += d[0]!;
  return Math.floor((2 * (near / (kept + 1)) - far / (degree - kept + 1)) / 5 + 0.5);
}
