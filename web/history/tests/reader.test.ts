// The reader beyond single levels: growing prefixes, coarsening, parts over HTTP, damaged files.
//
//   HISTORY=FILE node reader.test.mjs
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import type { AddressInfo } from "node:net";
import process from "node:process";
import { test } from "node:test";
import { History, HistoryError, parts } from "../src/index.js";

const file = new Uint8Array(readFileSync(process.env["HISTORY"]!));
const whole = new History(file);
const finest = 2 * whole.vertices - 4;
const counts = [4, 6, 64, 66, 500, 1000, finest - 2, finest].filter((count) => count <= finest);

function levelAt(history: History, triangles: number) {
  history.refineTo(triangles);
  return { ...history.level, device: history.deviceValues };
}

test("a level is the same from above and from below", () => {
  const history = new History(file);
  const rising = counts.map((count) => levelAt(history, count));
  const falling = counts.toReversed().map((count) => levelAt(history, count));
  assert.deepEqual(falling.toReversed(), rising);
  const jumps = [finest, 4, 1000, 64, finest, 500].filter((count) => count <= finest);
  for (const count of jumps) {
    assert.deepEqual(levelAt(history, count), rising[counts.indexOf(count)], String(count));
  }
});

test("a prefix gives its levels while it grows, and the end gives the device values", () => {
  const history = new History();
  let known = 0;
  for (let begin = 0; begin < file.length; begin += 1500) {
    history.append(file.subarray(begin, begin + 1500));
    if (!history.ready) continue;
    assert.ok(history.vertices >= known);
    known = history.vertices;
    history.refineTo(2 * known - 4);
    whole.refineTo(2 * known - 4);
    assert.deepEqual(history.level, whole.level);
  }
  assert.equal(known, whole.vertices);
  assert.ok(history.deviceValues);
  assert.deepEqual(history.deviceValues, whole.deviceValues);
});

test("there is no level beyond the prefix", () => {
  const history = new History(file.subarray(0, file.length / 3));
  assert.ok(history.vertices < whole.vertices);
  for (const count of [2, 2 * history.vertices, Number.NaN]) {
    assert.throws(() => history.refineTo(count), RangeError);
  }
  assert.throws(() => new History().triangles, HistoryError);
});

for (const ranges of [true, false]) {
  test(`a server ${ranges ? "with" : "without"} ranges sends the same bytes`, async (context) => {
    const asked: string[] = [];
    const server = createServer((request, response) => {
      asked.push(request.headers.range ?? "");
      const [, from, to] = /bytes=(\d+)-(\d+)/.exec(request.headers.range!)!;
      if (!ranges) return response.end(file);
      const end = Math.min(Number(to), file.length - 1);
      response.writeHead(206, {
        ETag: '"a"',
        "Content-Range": `bytes ${from}-${end}/${file.length}`,
      });
      return response.end(file.subarray(Number(from), end + 1));
    });
    await new Promise<void>((resolve) => server.listen(0, "127.0.0.1", resolve));
    context.after(() => server.close());
    const { port } = server.address() as AddressInfo;
    const history = new History();
    for await (const { bytes, total } of parts(`http://127.0.0.1:${port}/`, { first: 4096 })) {
      assert.equal(total === 0 ? file.length : total, file.length);
      history.append(bytes);
    }
    assert.equal(history.size, file.length);
    assert.equal(history.vertices, whole.vertices);
    assert.equal(asked[0], "bytes=0-4095");
    assert.equal(asked.length > 1, ranges);
  });
}

test("files of another kind are refused", () => {
  const size = 8 + Number(new DataView(file.buffer).getBigUint64(0, true));
  const text = new TextDecoder().decode(file.subarray(0, size));
  const changed = (from: string, to: string) => {
    assert.ok(text.includes(from) && from.length === to.length, from);
    const bytes = file.slice();
    bytes.set(new TextEncoder().encode(text.slice(8).replace(from, to)), 8);
    return bytes;
  };
  const another = [
    new TextEncoder().encode("glTF\u0002\u0000\u0000\u0000 not a history"),
    changed("gamut-history", "gamut-mystery"),
    changed('"version":"2"', '"version":"3"'),
    changed('"I32"', '"I16"'),
    changed('"splits.00"', '"splots.00"'),
    changed(`"vertices":"${whole.vertices}"`, `"vertices":"${9}${String(whole.vertices).slice(1)}"`),
  ];
  for (const bytes of another) {
    assert.throws(() => new History(bytes).refineTo(finest), HistoryError);
  }
});

test("a damaged stream gives a valid mesh or an error, never a hang or another exception", () => {
  const start = 8 + Number(new DataView(file.buffer).getBigUint64(0, true)) + 200;
  let refused = 0;
  for (let i = 0; i < 60; i++) {
    const bytes = file.slice();
    const at = start + Math.floor(((file.length - start) * i) / 60);
    bytes[at] = bytes[at]! ^ (1 << (i % 8));
    try {
      const history = new History(bytes);
      history.refineTo(finest);
      const { faces } = history.level;
      const edges = new Set<number>();
      for (let corner = 0; corner < faces.length; corner++) {
        const next = corner % 3 === 2 ? corner - 2 : corner + 1;
        edges.add(faces[corner]! * whole.vertices + faces[next]!);
      }
      assert.equal(edges.size, faces.length);
    } catch (error) {
      if (!(error instanceof HistoryError)) throw error;
      refused += 1;
    }
  }
  assert.ok(refused > 0);
});
