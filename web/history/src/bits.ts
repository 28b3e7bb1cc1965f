// Integers from a stream of bits (docs/history-format.md, "Which codes do the streams use?").
import { HistoryError } from "./errors.js";

/** Number of length classes of a context. */
export const CLASSES = 32;

const ESCAPE_ZEROS = 24;
const HALVING_COUNT = 64;

/** State of the adaptive code: one total and one count for each context. */
export class Contexts {
  readonly totals: Float64Array;
  readonly counts: Float64Array;

  constructor(size: number, total: (context: number) => number) {
    this.totals = Float64Array.from({ length: size }, (_, context) => total(context));
    this.counts = new Float64Array(size).fill(1);
  }
}

/** Reads integers from a stream, the most significant bit of the first byte first. */
export class BitReader {
  private readonly bytes: Uint8Array;
  private readonly end: number;
  private place = 0;

  constructor(stream: Uint8Array) {
    // Four bytes of zeros let `window` read beyond the end; `advance` checks the end.
    this.bytes = new Uint8Array(stream.length + 4);
    this.bytes.set(stream);
    this.end = 8 * stream.length;
  }

  /** Number of `count` bits, 0 to 32. */
  bits(count: number): number {
    if (count > 24) return this.bits(count - 16) * 65536 + this.bits(16);
    const value = count === 0 ? 0 : this.window() >>> (32 - count);
    this.advance(count);
    return value;
  }

  /** Integer from 0 to `limit` − 1 in truncated binary. */
  below(limit: number): number {
    const count = 31 - Math.clz32(limit);
    const short = 2 ** (count + 1) - limit;
    const value = this.bits(count);
    return value < short ? value : 2 * value + this.bits(1) - short;
  }

  /** Integer of at least 0 in a context. */
  adaptive(contexts: Contexts, context: number): number {
    const { totals, counts } = contexts;
    const total = totals[context]!;
    const count = counts[context]!;
    let k = 0;
    while (k < 30 && count * (1 << k) < total) k++;
    const zeros = Math.min(Math.clz32(this.window()), ESCAPE_ZEROS);
    let value: number;
    if (zeros === ESCAPE_ZEROS) {
      this.advance(ESCAPE_ZEROS);
      value = this.bits(32);
    } else {
      this.advance(zeros + 1);
      value = zeros * 2 ** k + this.bits(k);
    }
    totals[context] = total + Math.ceil(value / 2);
    counts[context] = count + 1;
    if (count + 1 === HALVING_COUNT) {
      totals[context] = Math.floor(totals[context]! / 2);
      counts[context] = HALVING_COUNT / 2;
    }
    return value;
  }

  /** Signed integer in a context. */
  signed(contexts: Contexts, context: number): number {
    const value = this.adaptive(contexts, context);
    return value % 2 === 0 ? value / 2 : -(value + 1) / 2;
  }

  /** Check that only the zeros that fill the last byte are left. */
  finish(): void {
    const rest = this.end - this.place;
    if (rest >= 8 || this.bits(rest) !== 0) throw new HistoryError("a stream is too long");
  }

  /** The next 25 bits or more, followed by zeros. */
  private window(): number {
    const { bytes } = this;
    const at = this.place >>> 3;
    const word =
      (bytes[at]! << 24) | (bytes[at + 1]! << 16) | (bytes[at + 2]! << 8) | bytes[at + 3]!;
    return word << (this.place & 7);
  }

  private advance(count: number): void {
    this.place += count;
    if (this.place > this.end) throw new HistoryError("a stream ends early");
  }
}
