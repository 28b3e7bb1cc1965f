// The container of a history, of which a growing prefix is known: header, checksums, groups
// (docs/history-format.md, "Structure").
import { type Column, checkColumns } from "./columns.js";
import { HistoryError } from "./errors.js";

const LARGEST_HEADER = 1 << 24;
const LARGEST_VERTICES = 2 ** 25;
const LARGEST_COORDINATE = 2 ** 24;
const MOST_CHANNELS = 64;
const LARGEST_SCALE = 32767;
const MOVED_PER_VERTEX = 24;

/** How device values are stored. */
export interface DeviceHeader {
  /** Names of the channels. */
  channels: string[];
  /** The integer of full scale. */
  steps: number;
  /** Values of slots 0 to 3 at the coarsest level. */
  base: Int32Array;
}

/** A group of splits; it adds slots `start` to `end` − 1. */
export interface Group {
  start: number;
  end: number;
  /** Rows for moved corners and for neighbours that move. */
  moved: number;
  shifted: number;
  bytes: number;
  crc32: number;
}

/** Content of the header. */
export interface Header {
  /** Vertices of the full boundary. */
  vertices: number;
  /** Size of the grid of all positions. */
  step: number;
  centre: [number, number, number];
  positions: Int32Array;
  faces: Int32Array;
  columns: Column[];
  groups: Group[];
  device: DeviceHeader | null;
  /** Description of the gamut; null if the file has none. */
  gamut: Record<string, unknown> | null;
}

/** A prefix of a history file. */
export class HistoryFile {
  header: Header | null = null;
  private bytes = new Uint8Array(1 << 16);
  private length = 0;
  /** Where the next group begins. */
  private begin = 0;
  private next = 0;

  /** Number of bytes that are there. */
  get size(): number {
    return this.length;
  }

  /** Append the bytes that follow, and read the header when it is there. */
  append(chunk: Uint8Array): void {
    if (this.length + chunk.length > this.bytes.length) {
      const larger = new Uint8Array(Math.max(2 * this.bytes.length, this.length + chunk.length));
      larger.set(this.bytes.subarray(0, this.length));
      this.bytes = larger;
    }
    this.bytes.set(chunk, this.length);
    this.length += chunk.length;
    if (this.header === null && this.length >= 8) this.readHeader();
  }

  /** Check the next group, and return its columns as bytes; null if it is not all there. */
  async nextGroup(): Promise<{ group: Group; content: Uint8Array } | null> {
    const group = this.header?.groups[this.next];
    if (group === undefined || this.begin + group.bytes > this.length) return null;
    const deflated = this.bytes.slice(this.begin, this.begin + group.bytes);
    const place = `group ${this.next} of the history`;
    this.begin += group.bytes;
    this.next += 1;
    if (crc32(deflated) !== group.crc32) throw new HistoryError(`${place} is damaged`);
    const rows = { splits: group.end - group.start, moved: group.moved, shifted: group.shifted };
    const size = this.header!.columns.reduce(
      (sum, { rows: kind, width, dtype }) => sum + rows[kind] * width * Number(dtype[1]),
      0,
    );
    return { group, content: await inflated(deflated, size, place) };
  }

  private readHeader(): void {
    const view = new DataView(this.bytes.buffer, 0, this.length);
    const size = view.getUint32(0, true);
    if (size < 2 || size > LARGEST_HEADER) throw new HistoryError("not a gamut history");
    this.begin = 8 + size;
    if (this.length < this.begin) return;
    const text = this.bytes.subarray(8, this.begin);
    if (crc32(text) !== view.getUint32(4, true)) {
      throw new HistoryError("the header is damaged, or this is no gamut history of version 3");
    }
    this.header = parsedHeader(text);
  }
}

function parsedHeader(text: Uint8Array): Header {
  let facts: Record<string, unknown>;
  try {
    facts = JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(text));
  } catch (error) {
    throw new HistoryError("the header is no JSON", { cause: error });
  }
  if (facts?.["format"] !== "gamut-history" || facts["version"] !== 3) {
    throw new HistoryError("not a gamut history of version 3");
  }
  const vertices = whole(facts["vertices"], 4, LARGEST_VERTICES, "vertices");
  const centre = facts["centre"];
  if (!Array.isArray(centre) || centre.length !== 3 || !centre.every(Number.isFinite)) {
    throw new HistoryError("the centre is no point");
  }
  const step = Number(facts["step"]);
  const exponent = Math.log2(step);
  if (!Number.isInteger(exponent) || exponent < -149 || exponent > 103) {
    throw new HistoryError("the step is no power of two");
  }
  const base = facts["base"] as Record<string, unknown> | undefined;
  const faces = rowsOf(base?.["faces"], 3, 0, 3, "base.faces");
  checkTetrahedron(faces);
  const device = facts["device"] === undefined ? null : deviceHeader(facts["device"]);
  return {
    vertices,
    step,
    centre: centre as [number, number, number],
    positions: rowsOf(base?.["positions"], 3, -LARGEST_COORDINATE, LARGEST_COORDINATE, "base"),
    faces,
    columns: checkColumns(facts["columns"], device?.channels.length ?? 0),
    groups: groupsOf(facts["groups"], vertices),
    device,
    gamut: (facts["gamut"] as Record<string, unknown> | undefined) ?? null,
  };
}

function groupsOf(lines: unknown, vertices: number): Group[] {
  const groups: Group[] = [];
  for (let start = 4; start < vertices; start *= 2) {
    const end = Math.min(2 * start, vertices);
    const line = (Array.isArray(lines) ? lines[groups.length] : null) as Record<string, unknown>;
    const name = `groups.${String(groups.length).padStart(2, "0")}`;
    const fact = (key: string, most: number) => whole(line?.[key], 0, most, name);
    if (fact("vertices", end) !== end) throw new HistoryError(`${name} is not valid`);
    groups.push({
      start,
      end,
      moved: fact("moved", MOVED_PER_VERTEX * end),
      shifted: fact("shifted", MOVED_PER_VERTEX * end),
      bytes: fact("bytes", Number.MAX_SAFE_INTEGER),
      crc32: fact("crc32", 2 ** 32 - 1),
    });
  }
  return groups;
}

function deviceHeader(value: unknown): DeviceHeader {
  const { channels, steps, base } = (value ?? {}) as Record<string, unknown>;
  const count = Array.isArray(channels) ? channels.length : 0;
  if (count < 1 || count > MOST_CHANNELS) {
    throw new HistoryError("the description of device values is not valid");
  }
  const scale = whole(steps, 1, LARGEST_SCALE, "device.steps");
  return {
    channels: channels as string[],
    steps: scale,
    base: rowsOf(base, count, 0, scale, "device.base"),
  };
}

function whole(value: unknown, least: number, most: number, name: string): number {
  if (!Number.isSafeInteger(value) || (value as number) < least || (value as number) > most) {
    throw new HistoryError(`${name} is not valid`);
  }
  return value as number;
}

/** Four rows of whole numbers. */
function rowsOf(
  value: unknown,
  width: number,
  least: number,
  most: number,
  name: string,
): Int32Array {
  const rows = Array.isArray(value) && value.length === 4 ? value : [];
  const numbers = rows.flatMap((row) => (Array.isArray(row) && row.length === width ? row : []));
  if (numbers.length !== 4 * width) throw new HistoryError(`${name} is not valid`);
  return Int32Array.from(numbers, (number) => whole(number, least, most, name));
}

/** Four faces of slots 0 to 3 are a tetrahedron if their twelve directed edges are different. */
function checkTetrahedron(faces: Int32Array): void {
  const edges = new Set<number>();
  for (let corner = 0; corner < 12; corner++) {
    const from = faces[corner]!;
    const to = faces[corner % 3 === 2 ? corner - 2 : corner + 1]!;
    if (from !== to) edges.add(4 * from + to);
  }
  if (edges.size !== 12) throw new HistoryError("the coarsest level is no tetrahedron");
}

/** Inflate a zlib stream of known length. */
async function inflated(
  deflated: Uint8Array<ArrayBuffer>,
  size: number,
  place: string,
): Promise<Uint8Array> {
  const content = new Uint8Array(size);
  let length = 0;
  try {
    const stream = new Blob([deflated]).stream().pipeThrough(new DecompressionStream("deflate"));
    const reader = stream.getReader();
    for (;;) {
      const { done, value } = await reader.read();
      if (done) break;
      content.set(value, length); // fails beyond the end
      length += value.length;
    }
  } catch (error) {
    throw new HistoryError(`${place} holds no columns`, { cause: error });
  }
  if (length !== size) throw new HistoryError(`${place} is too short`);
  return content;
}

const CRC_TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
  let code = byte;
  for (let bit = 0; bit < 8; bit++) code = code & 1 ? (code >>> 1) ^ 0xedb88320 : code >>> 1;
  return code;
});

function crc32(bytes: Uint8Array): number {
  let code = 0xffffffff;
  for (const byte of bytes) code = CRC_TABLE[(code ^ byte) & 255]! ^ (code >>> 8);
  return ~code >>> 0;
}
