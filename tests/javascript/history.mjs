// Reads a history file, version 2, as docs/history-format.md describes it: plain JavaScript without
// dependencies, for browsers and Node.js. Written from that page, not from the Python reader.

const LARGEST_COORDINATE = 2 ** 24;
const CLASSES = 32;
const KINDS = 7;
const [KEPT, PARENT_ALONG, PARENT_OFF, ADDED_ALONG, ADDED_OFF, SHIFTED_ALONG, SHIFTED_OFF] =
  Array.from({ length: KINDS }, (_, kind) => CLASSES * kind);

/** Whole numbers from a stream of bits, the most significant bit of the first byte first. */
class BitReader {
  constructor(bytes) {
    this.bytes = bytes;
    this.place = 0;
  }

  bits(count) {
    if (this.place + count > 8 * this.bytes.length) throw new RangeError("the stream ends early");
    let value = 0;
    for (let i = 0; i < count; i++, this.place++) {
      value = 2 * value + ((this.bytes[this.place >> 3] >> (7 - (this.place & 7))) & 1);
    }
    return value;
  }

  below(limit) {
    let count = 0;
    while (2 ** (count + 1) <= limit) count++;
    const short = 2 ** (count + 1) - limit;
    const value = this.bits(count);
    return value < short ? value : 2 * value + this.bits(1) - short;
  }

  adaptive(context) {
    let k = 0;
    while (k < 30 && context.count * 2 ** k < context.total) k++;
    let zeros = 0;
    while (zeros < 24 && this.bits(1) === 0) zeros++;
    const value = zeros === 24 ? this.bits(32) : zeros * 2 ** k + this.bits(k);
    context.total += Math.ceil(value / 2);
    context.count += 1;
    if (context.count === 64) {
      context.total = Math.floor(context.total / 2);
      context.count = 32;
    }
    return value;
  }

  signed(context) {
    const value = this.adaptive(context);
    return value % 2 === 0 ? value / 2 : -(value + 1) / 2;
  }
}

/** The header, and the arrays whose bytes are all there. */
function parse(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const size = Number(view.getBigUint64(0, true));
  const header = JSON.parse(new TextDecoder("utf-8").decode(bytes.subarray(8, 8 + size)));
  const metadata = header.__metadata__;
  if (metadata?.format !== "gamut-history" || metadata.version !== "2") {
    throw new TypeError("not a gamut history of version 2");
  }
  const slice = (name) => {
    const [begin, end] = header[name]?.data_offsets ?? [0, Infinity];
    if (8 + size + end > bytes.length) return null;
    return bytes.slice(8 + size + begin, 8 + size + end);
  };
  const numbers = (name, count, width, get) => {
    const data = slice(name);
    if (data?.length !== count * width) throw new RangeError(`${name} is not there`);
    const values = new DataView(data.buffer);
    return Array.from({ length: count }, (_, i) => values[get](width * i, true));
  };
  const streams = [];
  for (;;) {
    const stream = slice(`splits.${String(streams.length).padStart(2, "0")}`);
    if (stream === null) break;
    streams.push(stream);
  }
  return {
    metadata,
    streams,
    device: deviceSection(metadata, streams.length, slice, numbers),
    vertices: Math.min(Number(metadata.vertices), 4 * 2 ** streams.length),
    step: numbers("step", 1, 8, "getFloat64")[0],
    positions: numbers("base.positions", 12, 4, "getInt32"),
    faces: numbers("base.faces", 12, 4, "getInt32"),
  };
}

/** What the file says of device values; null if there are none, or not all of their groups. */
function deviceSection(metadata, groups, slice, numbers) {
  const name = (group) => `device.${String(group).padStart(2, "0")}`;
  const streams = Array.from({ length: groups }, (_, group) => slice(name(group)));
  if (!metadata.device || streams.includes(null) || slice("device.base") === null) return null;
  const { channels, steps: scale, corrected } = JSON.parse(metadata.device);
  const base = numbers("device.base", 4 * channels.length, 4, "getInt32");
  const contexts = Array.from({ length: 6 * channels.length * CLASSES }, () => ({
    total: 32,
    count: 1,
  }));
  return { channels, scale, corrected, streams, contexts, values: base };
}

/**
 * A level that is refined split by split.
 *
 * rings[s] holds the faces around slot s, counter-clockwise, each as its corner at s and the slot
 * that follows s in it.
 */
export class History {
  /** @param {Uint8Array} bytes A history file, or any part of it that begins with its first byte
   * and holds at least the coarsest level. */
  constructor(bytes) {
    Object.assign(this, parse(bytes));
    const total = this.vertices;
    this.count = 4;
    this.steps = new Int32Array(3 * total);
    this.steps.set(this.positions);
    this.corners = new Int32Array(6 * total - 12);
    this.corners.set(this.faces);
    this.contexts = Array.from({ length: KINDS * CLASSES }, (_, i) => ({
      total: Math.floor(2 ** (i % CLASSES) / 2),
      count: 1,
    }));
    this.rings = Array.from({ length: 4 }, (_, slot) => this.baseRing(slot));
  }

  /** Number of triangles of the present level. */
  get triangles() {
    return 2 * this.count - 4;
  }

  /** Device values of the present level, as float32: those of slot 0, of slot 1, ... */
  get deviceValues() {
    const { values, scale, channels } = this.device;
    return Float32Array.from(values.slice(0, channels.length * this.count), (v) => v / scale);
  }

  /** The present level: x, y, z of each slot as float32, and three slots for each face. */
  get level() {
    const positions = new Float32Array(3 * this.count);
    for (let i = 0; i < positions.length; i++) positions[i] = this.steps[i] * this.step;
    return { positions, faces: this.corners.slice(0, 3 * this.triangles) };
  }

  baseRing(slot) {
    const around = [0, 1, 2, 3].flatMap((face) => {
      const place = this.faces.slice(3 * face, 3 * face + 3).indexOf(slot);
      const next = (offset) => this.faces[3 * face + ((place + offset) % 3)];
      return place < 0 ? [] : [{ corner: 3 * face + place, slot: next(1), end: next(2) }];
    });
    const ring = [around[0]];
    while (ring.length < around.length) {
      ring.push(around.find((entry) => entry.slot === ring.at(-1).end));
    }
    return ring.map(({ corner, slot: neighbour }) => ({ corner, slot: neighbour }));
  }

  /** Refine to so many triangles, at least the present ones and at most 2 · vertices − 4. */
  refineTo(triangles) {
    while (this.triangles < triangles) {
      const group = Math.floor(Math.log2(this.count)) - 2;
      if (this.count === 4 * 2 ** group) {
        this.reader = new BitReader(this.streams[group]);
        this.shifts = this.reader.bits(1) === 1;
        if (this.device) this.device.reader = new BitReader(this.device.streams[group]);
      }
      this.split();
    }
  }

  split() {
    const { reader, contexts, rings, corners, count: slot } = this;
    const parent = reader.below(slot);
    let ring = rings[parent];
    const degree = ring.length;
    const face = ({ corner }) => Math.floor(corner / 3);
    let start = 0;
    ring.forEach((entry, i) => {
      if (face(entry) < face(ring[start])) start = i;
    });
    start = (start + reader.below(degree)) % degree;
    ring = [...ring.slice(start), ...ring.slice(0, start)];
    const code = reader.adaptive(contexts[KEPT]);
    if (code > degree - 2) throw new RangeError("the parent keeps more faces than it has");
    const half = Math.ceil(degree / 2);
    const kept = half + code < degree ? half + code : degree - 1 - code;

    const before = this.place(parent);
    const moved = this.places(parent, slot, ring, kept);
    if (this.device) this.deviceSplit(parent, slot, before, moved);

    const [one, two] = [6 * slot - 12, 6 * slot - 9];
    const [left, right] = [ring[0].slot, ring[kept].slot];
    corners.set([parent, slot, left, slot, parent, right], one);
    for (const entry of ring.slice(kept)) corners[entry.corner] = slot;
    for (const entry of ring.slice(kept + 1)) {
      rings[entry.slot].find((other) => other.slot === parent).slot = slot;
    }
    const at = (around) => rings[around].findIndex((other) => other.slot === parent);
    const [atLeft, atRight] = [at(left), at(right)];
    rings[left][atLeft].slot = slot;
    rings[left].splice(atLeft, 0, { corner: one + 2, slot: parent });
    rings[right].splice(atRight, 0, { corner: two + 2, slot });
    rings[parent] = [
      ...ring.slice(0, kept),
      { corner: two + 1, slot: right },
      { corner: one, slot },
    ];
    rings[slot] = [
      ...ring.slice(kept),
      { corner: one + 1, slot: left },
      { corner: two, slot: parent },
    ];
    this.count += 1;
  }

  /** Where a slot is, in steps. */
  place(slot) {
    return [0, 1, 2].map((axis) => this.steps[3 * slot + axis]);
  }

  /** Read the device values of the parent, of the new slot and of the neighbours that moved. */
  deviceSplit(parent, slot, before, moved) {
    const { values, scale, channels, corrected, reader, contexts } = this.device;
    const count = channels.length;
    const [fine, added] = [this.place(parent), this.place(slot)];
    let [along, square, distance] = [0, 0, 0];
    for (const axis of [0, 1, 2]) {
      const edge = added[axis] - fine[axis];
      along += (before[axis] - fine[axis]) * edge;
      square += edge * edge;
      distance += Math.abs(edge);
    }
    const place = square === 0 ? 0 : Math.min(1, Math.max(0, along / square));
    let length = 0;
    while (length < CLASSES - 1 && !(distance < 2 ** length)) length++;
    const number = (kind, channel, old) => {
      const between = old > 0 && old < scale ? 1 : 0;
      return reader.signed(contexts[((kind * count + channel) * 2 + between) * CLASSES + length]);
    };
    const set = (whose, channel, value) => {
      if (value < 0 || value > scale) throw new RangeError("beyond full scale");
      values[count * whose + channel] = value;
    };
    for (let channel = 0; channel < count; channel++) {
      const old = values[count * parent + channel];
      const change = number(0, channel, old);
      const correction = slot < corrected ? number(1, channel, old) : 0;
      const here = old - correction - Math.floor(place * change + 0.5);
      set(parent, channel, here);
      set(slot, channel, here + change);
    }
    for (const neighbour of slot < corrected ? moved.sort((a, b) => a - b) : []) {
      for (let channel = 0; channel < count; channel++) {
        const old = values[count * neighbour + channel];
        set(neighbour, channel, old + number(2, channel, old));
      }
    }
  }

  /** Read the places of the parent, of the new slot and of the neighbours that move; return the
   * latter. */
  places(parent, slot, ring, kept) {
    const { reader, contexts, steps } = this;
    const degree = ring.length;
    const here = [0, 1, 2].map((axis) => steps[3 * parent + axis]);
    const d = ring.map((entry) => here.map((c, axis) => steps[3 * entry.slot + axis] - c));
    const normal = [0, 0, 0];
    let distance = 0;
    d.forEach((a, i) => {
      const b = d[(i + 1) % degree];
      normal[0] += a[1] * b[2] - a[2] * b[1];
      normal[1] += a[2] * b[0] - a[0] * b[2];
      normal[2] += a[0] * b[1] - a[1] * b[0];
      distance += Math.abs(a[0]) + Math.abs(a[1]) + Math.abs(a[2]);
    });
    let w = Math.abs(normal[1]) > Math.abs(normal[0]) ? 1 : 0;
    if (Math.abs(normal[2]) > Math.abs(normal[w])) w = 2;
    const [u, v] = [(w + 1) % 3, (w + 2) % 3];
    const flat = normal[w] === 0;
    const slopeU = flat ? 0 : -normal[u] / normal[w];
    const slopeV = flat ? 0 : -normal[v] / normal[w];
    let off = 0;
    for (const a of d) off += Math.abs(a[w] - (slopeU * a[u] + slopeV * a[v]));
    const lengthClass = (total) => {
      let n = 0;
      while (n < CLASSES - 1 && !(total < degree * 2 ** n)) n++;
      return n;
    };
    const [size, height] = [lengthClass(distance), lengthClass(off)];

    const mean = (entries, axis) => entries.reduce((sum, a) => sum + a[axis], 0) / entries.length;
    const near = d.slice(0, kept + 1);
    const far = [...d.slice(kept), d[0]];
    const ahead = (axis) => Math.floor((2 * mean(near, axis) - mean(far, axis)) / 5 + 0.5);
    const plane = (along, across) => Math.floor(slopeU * along + slopeV * across + 0.5);
    const differences = (along, across) => [
      reader.signed(contexts[along]),
      reader.signed(contexts[along]),
      reader.signed(contexts[across]),
    ];
    const place = (whose, from, du, dv, dw) => {
      for (const [axis, change] of [[u, du], [v, dv], [w, dw]]) {
        const value = from[axis] + change;
        if (Math.abs(value) > LARGEST_COORDINATE) throw new RangeError("beyond 2^24 steps");
        steps[3 * whose + axis] = value;
      }
    };

    const p = differences(PARENT_ALONG + size, PARENT_OFF + height);
    const [du, dv] = [ahead(u) + p[0], ahead(v) + p[1]];
    place(parent, here, du, dv, plane(du, dv) + p[2]);
    const q = differences(ADDED_ALONG + height, ADDED_OFF + height);
    const [eu, ev] = [q[0] - du, q[1] - dv];
    place(slot, here, eu, ev, plane(eu, ev) + q[2]);

    const moved = [];
    if (!this.shifts || reader.bits(1) === 0) return moved;
    for (const entry of ring) {
      if (reader.bits(1) === 0) continue;
      const s = differences(SHIFTED_ALONG + size, SHIFTED_OFF + height);
      const from = [0, 1, 2].map((axis) => steps[3 * entry.slot + axis]);
      place(entry.slot, from, s[0], s[1], plane(s[0], s[1]) + s[2]);
      moved.push(entry.slot);
    }
    return moved;
  }
}
