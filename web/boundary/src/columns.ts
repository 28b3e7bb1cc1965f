// The columns of a group of splits (docs/history-format.md, "Groups").
import { HistoryError } from "./errors.js";
import type { Group } from "./file.js";

/** A column has a row for each split, moved corner or neighbour that moves. */
export interface Column {
  name: string;
  dtype: "i4" | "u4" | "u2";
  width: number;
  rows: "splits" | "moved" | "shifted";
}

const GEOMETRY: [string, Column["dtype"], number, Column["rows"]][] = [
  ["parent", "i4", 1, "splits"],
  ["moved_count", "i4", 1, "splits"],
  ["shifted_count", "i4", 1, "splits"],
  ["middle", "u4", 3, "splits"],
  ["edge", "u4", 3, "splits"],
  ["moved", "i4", 1, "moved"],
  ["shifted", "i4", 1, "shifted"],
  ["shift", "u4", 3, "shifted"],
];

/** Check that the header names the columns of version 3. */
export function checkColumns(value: unknown, channels: number): Column[] {
  const expected = GEOMETRY.map(([name, dtype, width, rows]) => ({ name, dtype, width, rows }));
  if (channels > 0) {
    const device = { dtype: "u2" as const, width: channels };
    expected.push(
      { name: "device_middle", ...device, rows: "splits" },
      { name: "device_edge", ...device, rows: "splits" },
      { name: "device_shift", ...device, rows: "shifted" },
    );
  }
  const columns = Array.isArray(value) ? (value as Column[]) : [];
  const text = ({ name, dtype, width, rows }: Column) => [name, dtype, width, rows].join();
  if (columns.map(text).join(";") !== expected.map(text).join(";")) {
    throw new HistoryError("the columns are not those of version 3");
  }
  return expected;
}

/** The columns of a group by name, row by row; differences are unfolded. */
export class GroupColumns {
  private readonly arrays = new Map<string, Int32Array>();

  constructor(columns: Column[], group: Group, content: Uint8Array) {
    const rows = { splits: group.end - group.start, moved: group.moved, shifted: group.shifted };
    let begin = 0;
    for (const { name, dtype, width, rows: kind } of columns) {
      const count = rows[kind];
      const size = Number(dtype[1]);
      const array = new Int32Array(count * width);
      for (let row = 0; row < count; row++) {
        for (let place = 0; place < width; place++) {
          let number = 0;
          for (let byte = 0; byte < size; byte++) {
            number |= content[begin + (place * size + byte) * count + row]! << (8 * byte);
          }
          array[row * width + place] =
            dtype === "i4" ? number : (number >>> 1) ^ -(number & 1);
        }
      }
      begin += count * width * size;
      this.arrays.set(name, array);
    }
  }

  /** A column; it has all rows of the group. */
  of(name: string): Int32Array {
    return this.arrays.get(name)!;
  }
}
