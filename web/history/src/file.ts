// The container of a history: a safetensors file of which a growing prefix is known
// (docs/history-format.md, "How is the file structured?").
import { HistoryError } from "./errors.js";

const LONGEST_HEADER = 1 << 24;
const LEAST_BITS_OF_A_SPLIT = 10;
const MOST_CHANNELS = 64;
const LARGEST_SCALE = 32767;

interface Entry {
  dtype: string;
  shape: number[];
  data_offsets: [number, number];
}

/** How device values are stored. */
export interface DeviceHeader {
  /** Names of the channels. */
  channels: string[];
  /** The integer of full scale. */
  steps: number;
  /** Levels with fewer vertices have corrections. */
  corrected: number;
}

/** Content of the header and the coarsest level. */
export interface Header {
  /** Vertices of the full boundary. */
  vertices: number;
  /** Number of groups of splits. */
  groups: number;
  /** Size of the grid of all positions. */
  step: number;
  centre: [number, number, number];
  positions: Int32Array;
  faces: Int32Array;
  device: DeviceHeader | null;
  /** Description of the gamut; null if the file has none. */
  gamut: Record<string, unknown> | null;
  /** Length of the prefix with the geometry, and of the file, in bytes. */
  geometryBytes: number;
  bytes: number;
}

/** A prefix of a history file. */
export class HistoryFile {
  private bytes = new Uint8Array(1 << 16);
  private length = 0;
  private entries: Record<string, Entry> = {};
  private start = 0;
  private known: Header | null = null;

  /** Number of bytes that are there. */
  get size(): number {
    return this.length;
  }

  /** Append the bytes that follow. */
  append(chunk: Uint8Array): void {
    if (this.length + chunk.length > this.bytes.length) {
      const larger = new Uint8Array(Math.max(2 * this.bytes.length, this.length + chunk.length));
      larger.set(this.bytes.subarray(0, this.length));
      this.bytes = larger;
    }
    this.bytes.set(chunk, this.length);
    this.length += chunk.length;
  }

  /** The header; null until the coarsest level is there. */
  get header(): Header | null {
    this.known ??= this.parse();
    return this.known;
  }

  /** The stream of a group of splits, or of its device values; null if it is not all there. */
  stream(kind: "splits" | "device", group: number): Uint8Array | null {
    return this.header === null ? null : this.array(streamName(kind, group));
  }

  /** Device values of slots 0 to 3 at the coarsest level; null if they are not there. */
  get deviceBase(): Int32Array | null {
    const count = this.header?.device?.channels.length ?? 0;
    return count === 0 ? null : this.integers("device.base", [4, count]);
  }

  private parse(): Header | null {
    if (this.length < 8) return null;
    const view = new DataView(this.bytes.buffer, 0, this.length);
    const size = view.getUint32(0, true);
    if (size > LONGEST_HEADER || view.getUint32(4, true) !== 0) {
      throw new HistoryError("not a gamut history");
    }
    this.start = 8 + size;
    if (this.length < this.start) return null;
    this.entries = parsedJson(this.bytes.subarray(8, this.start)) as Record<string, Entry>;
    const metadata = this.entries["__metadata__"] as unknown as Record<string, string> | undefined;
    if (metadata?.["format"] !== "gamut-history" || metadata["version"] !== "2") {
      throw new HistoryError("not a gamut history of version 2");
    }
    const vertices = Number(metadata["vertices"]);
    if (!Number.isSafeInteger(vertices) || vertices < 4 || vertices > 2 ** 31) {
      throw new HistoryError("the number of vertices is not valid");
    }
    const positions = this.integers("base.positions", [4, 3]);
    const faces = this.integers("base.faces", [4, 3]);
    const [step] = this.doubles("step", [1]) ?? [];
    const centre = this.doubles("centre", [3]);
    if (!positions || !faces || step === undefined || !centre) return null;
    const exponent = Math.log2(step);
    if (!Number.isInteger(exponent) || exponent < -149 || exponent > 103) {
      throw new HistoryError("the step is no power of two");
    }
    checkTetrahedron(faces);
    const device = metadata["device"] === undefined ? null : deviceHeader(metadata["device"]);
    const { groups, geometryBytes } = this.checkStreams(vertices, device);
    const gamut = metadata["gamut"];
    return {
      vertices,
      groups,
      step,
      centre: centre as [number, number, number],
      positions,
      faces,
      device,
      gamut: gamut === undefined ? null : (JSON.parse(gamut) as Record<string, unknown>),
      geometryBytes,
      bytes: this.start + Math.max(...Object.values(this.entries).map(end)),
    };
  }

  /** Check that every group has a stream that is long enough, before memory is allocated. */
  private checkStreams(vertices: number, device: DeviceHeader | null) {
    let groups = 0;
    let geometryBytes = 0;
    for (let first = 4; first < vertices; first *= 2, groups++) {
      const splits = Math.min(first, vertices - first);
      const bytes = this.bytesOf(streamName("splits", groups));
      if (8 * bytes < LEAST_BITS_OF_A_SPLIT * splits + 1) {
        throw new HistoryError("a group of splits is too short");
      }
      geometryBytes = this.start + end(this.entries[streamName("splits", groups)]!);
      if (device === null) continue;
      if (8 * this.bytesOf(streamName("device", groups)) < device.channels.length * splits) {
        throw new HistoryError("a group of device values is too short");
      }
    }
    return { groups, geometryBytes };
  }

  private bytesOf(name: string): number {
    const entry = this.entries[name];
    const [from, to] = entry?.data_offsets ?? [];
    const right = Number.isSafeInteger(from) && Number.isSafeInteger(to) && from! >= 0 && to! >= from!;
    if (!right || entry!.dtype !== "U8" || entry!.shape.length !== 1) {
      throw new HistoryError(`${name} is missing`);
    }
    return to! - from!;
  }

  private array(name: string): Uint8Array | null {
    const entry = this.entries[name];
    if (entry === undefined) throw new HistoryError(`${name} is missing`);
    const [from, to] = entry.data_offsets;
    if (this.start + to > this.length) return null;
    return this.bytes.slice(this.start + from, this.start + to);
  }

  private numbers(name: string, dtype: string, width: number, shape: number[]): DataView | null {
    const entry = this.entries[name];
    if (entry?.dtype !== dtype || String(entry.shape) !== String(shape)) {
      throw new HistoryError(`${name} is missing`);
    }
    const data = this.array(name);
    if (data === null) return null;
    if (data.length !== width * shape.reduce((product, count) => product * count, 1)) {
      throw new HistoryError(`${name} has another size`);
    }
    return new DataView(data.buffer);
  }

  private integers(name: string, shape: number[]): Int32Array | null {
    const data = this.numbers(name, "I32", 4, shape);
    if (data === null) return null;
    return Int32Array.from({ length: data.byteLength / 4 }, (_, i) => data.getInt32(4 * i, true));
  }

  private doubles(name: string, shape: number[]): number[] | null {
    const data = this.numbers(name, "F64", 8, shape);
    if (data === null) return null;
    return Array.from({ length: data.byteLength / 8 }, (_, i) => data.getFloat64(8 * i, true));
  }
}

function streamName(kind: string, group: number): string {
  return `${kind}.${String(group).padStart(2, "0")}`;
}

function end(entry: Entry): number {
  return entry.data_offsets?.[1] ?? 0;
}

function parsedJson(bytes: Uint8Array): unknown {
  try {
    return JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes));
  } catch (error) {
    throw new HistoryError("the header is no JSON", { cause: error });
  }
}

function deviceHeader(text: string): DeviceHeader {
  const header = JSON.parse(text) as DeviceHeader;
  const { channels, steps } = header;
  const count = Array.isArray(channels) ? channels.length : 0;
  if (count < 1 || count > MOST_CHANNELS || !(steps >= 1 && steps <= LARGEST_SCALE)) {
    throw new HistoryError("the description of device values is not valid");
  }
  return header;
}

/** Four faces of slots 0 to 3 are a tetrahedron if their twelve directed edges are different. */
function checkTetrahedron(faces: Int32Array): void {
  const edges = new Set<number>();
  for (let corner = 0; corner < 12; corner++) {
    const from = faces[corner]!;
    const to = faces[corner % 3 === 2 ? corner - 2 : corner + 1]!;
    if (from >= 0 && from < 4 && to >= 0 && to < 4 && from !== to) edges.add(4 * from + to);
  }
  if (edges.size !== 12) throw new HistoryError("the coarsest level is no tetrahedron");
}
