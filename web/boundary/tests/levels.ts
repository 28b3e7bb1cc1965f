// Writes levels of a history file to standard output, one after the other: positions as float32,
// then faces as int32, then device values as float32 if --device is given; all little-endian.
//
//   node levels.mjs [--device] FILE TRIANGLES...
//
// The file may be the beginning of one. "all" stands for all counts that are there.
import { readFileSync, writeSync } from "node:fs";
import process from "node:process";
import { History } from "../src/index.js";

const device = process.argv[2] === "--device";
const [file, ...counts] = process.argv.slice(device ? 3 : 2);
const history = await History.from(new Uint8Array(readFileSync(file!)));
const all = Array.from({ length: history.vertices - 3 }, (_, i) => 4 + 2 * i);

/** Write all of it: a pipe takes what fits. */
function write(array: Float32Array | Int32Array): void {
  const data = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
  for (let sent = 0; sent < data.length; ) {
    try {
      sent += writeSync(1, data, sent);
    } catch (error) {
      if ((error as NodeJS.ErrnoException).code !== "EAGAIN") throw error;
    }
  }
}

for (const triangles of counts[0] === "all" ? all : counts.map(Number)) {
  history.refineTo(triangles);
  if (history.triangles !== triangles) throw new RangeError(`no level of ${triangles} triangles`);
  const { positions, faces } = history.level;
  write(positions);
  write(faces);
  if (device) write(history.deviceValues!);
}
