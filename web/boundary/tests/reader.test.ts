// The reader beyond single levels: growing prefixes, coarsening, parts over HTTP, damaged files.
//
//   HISTORY=FILE node reader.test.mjs
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import type { AddressInfo } from "node:net";
import process from "node:process";
import { test } from "node:test";
import { deflateSync, inflateSync } from "node:zlib";
import { History, HistoryError, parts } from "../src/index.js";

const file = new Uint8Array(readFileSync(process.env["HISTORY"]!));
const whole = await History.from(file);
const finest = 2 * whole.vertices - 4;
const counts = [4, 6, 64, 66, 500, 1000, finest - 2, finest].filter((count) => count <= finest);

function levelAt(history: History, triangles: number) {
  history.refineTo(triangles);
  return { ...history.level, device: history.deviceValues };
}

test("a level is the same from above and from below", async () => {
  const history = await History.from(file);
  const rising = counts.map((count) => levelAt(history, count));
  const falling = counts.toReversed().map((count) => levelAt(history, count));
  assert.deepEqual(falling.toReversed(), rising);
  const jumps = [finest, 4, 1000, 64, finest, 500].filter((count) => count <= finest);
  for (const count of jumps) {
    assert.deepEqual(levelAt(history, count), rising[counts.indexOf(count)], String(count));
  }
});

test("a prefix gives its levels and device values while it grows", async () => {
  const history = new History();
  let known = 0;
  for (let begin = 0; begin < file.length; begin += 1500) {
    await history.append(file.subarray(begin, begin + 1500));
    if (!history.ready) continue;
    assert.ok(history.vertices >= known);
    known = history.vertices;
    history.refineTo(2 * known - 4);
    whole.refineTo(2 * known - 4);
    assert.deepEqual(history.level, whole.level);
    assert.ok(history.deviceValues);
    assert.deepEqual(history.deviceValues, whole.deviceValues);
  }
  assert.equal(known, whole.vertices);
});

test("appending does not need to be awaited in turn", async () => {
  const history = new History();
  const parts = [0, 1, 2, 3].map((i) => file.subarray((i * file.length) / 4, ((i + 1) * file.length) / 4));
  await Promise.all(parts.map((part) => history.append(part)));
  assert.deepEqual(levelAt(history, finest), levelAt(whole, finest));
});

test("there is no level beyond the prefix", async () => {
  const history = await History.from(file.subarray(0, file.length / 3));
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
      await history.append(bytes);
    }
    assert.equal(history.size, file.length);
    assert.equal(history.vertices, whole.vertices);
    assert.equal(asked[0], "bytes=0-4095");
    assert.equal(asked.length > 1, ranges);
  });
}

const headerEnd = 8 + new DataView(file.buffer).getUint32(0, true);
const header = JSON.parse(new TextDecoder().decode(file.subarray(8, headerEnd)));

/** The file with another header and group, with right checksums. */
function rewritten(facts: object, number = -1, content = new Uint8Array()): Uint8Array {
  const groups = structuredClone(header.groups) as { bytes: number; crc32: number }[];
  let begin = headerEnd;
  const bodies = groups.map((group, i) => {
    const body = i === number ? content : file.subarray(begin, begin + group.bytes);
    begin += group.bytes;
    if (i === number) [group.bytes, group.crc32] = [content.length, crc32(content)];
    return body;
  });
  const text = new TextEncoder().encode(JSON.stringify({ ...header, groups, ...facts }));
  const prefix = new DataView(new ArrayBuffer(8));
  prefix.setUint32(0, text.length, true);
  prefix.setUint32(4, crc32(text), true);
  return new Uint8Array(Buffer.concat([new Uint8Array(prefix.buffer), text, ...bodies]));
}

/** CRC-32 bit by bit, with the polynomial of zlib. */
function crc32(bytes: Uint8Array): number {
  let code = -1;
  for (const byte of bytes) {
    code ^= byte;
    for (let bit = 0; bit < 8; bit++) code = (code >>> 1) ^ (0xedb88320 & -(code & 1));
  }
  return ~code >>> 0;
}

test("files of another kind are refused", async () => {
  assert.deepEqual(await History.from(rewritten({})).then((h) => h.vertices), whole.vertices);
  const another = [
    new TextEncoder().encode("glTF\u0002\u0000\u0000\u0000 not a history"),
    rewritten({ format: "gamut-mystery" }),
    rewritten({ version: 2 }),
    rewritten({ vertices: 2 * whole.vertices }),
    rewritten({ columns: header.columns.slice(1) }),
    rewritten({ groups: header.groups.slice(1) }),
    rewritten({ step: 0.1 }),
    rewritten({ base: { ...header.base, faces: [[0, 1, 2], [0, 1, 2], [0, 2, 3], [1, 3, 2]] } }),
    rewritten({ device: { ...header.device, base: [] } }),
  ];
  for (const bytes of another) await assert.rejects(History.from(bytes), HistoryError);
});

test("a flipped bit is refused, and names the group", async () => {
  for (let i = 0; i < 60; i++) {
    const bytes = file.slice();
    const at = Math.floor((file.length * i) / 60);
    bytes[at]! ^= 1 << (i % 8);
    const history = new History();
    const refusal = await history.append(bytes).catch((error: unknown) => error);
    if (at < 4 && refusal === undefined) {
      assert.ok(!history.ready); // a longer header than the file
      continue;
    }
    assert.ok(refusal instanceof HistoryError, String(at));
    if (at < headerEnd) continue;
    let end = headerEnd;
    const group = header.groups.findIndex(({ bytes: size }: { bytes: number }) => (end += size) > at);
    assert.match(refusal.message, new RegExp(`group ${group} `));
    assert.deepEqual(levelAt(history, 2 * history.vertices - 4), levelAt(whole, 2 * 4 * 2 ** group - 4));
  }
});

test("any columns give valid meshes or an error, and leave the coarser levels", async () => {
  const number = 4;
  const begin = header.groups.slice(0, number).reduce((sum: number, g: { bytes: number }) => sum + g.bytes, headerEnd);
  const content = inflateSync(file.subarray(begin, begin + header.groups[number].bytes));
  let refused = 0;
  for (let i = 0; i < 400; i++) {
    const changed = new Uint8Array(content);
    changed[Math.floor((content.length * i) / 400)]! ^= 1 << (i % 8);
    const history = await History.from(rewritten({}, number, new Uint8Array(deflateSync(changed))));
    const target = 2 * 4 * 2 ** (number + 1) - 4;
    try {
      history.refineTo(target);
    } catch (error) {
      assert.ok(error instanceof HistoryError);
      refused += 1;
      assert.throws(() => history.refineTo(target), RangeError);
      assert.ok(history.vertices >= 4 * 2 ** number);
    }
    const { faces } = history.level;
    const edges = new Set<number>();
    for (let corner = 0; corner < faces.length; corner++) {
      const next = corner % 3 === 2 ? corner - 2 : corner + 1;
      edges.add(faces[corner]! * whole.vertices + faces[next]!);
    }
    assert.equal(edges.size, 3 * history.triangles);
    for (const edge of edges) {
      const [from, to] = [Math.floor(edge / whole.vertices), edge % whole.vertices];
      assert.ok(edges.has(to * whole.vertices + from));
    }
    const coarse = 2 * 4 * 2 ** number - 4;
    assert.deepEqual(levelAt(history, coarse), levelAt(whole, coarse));
  }
  assert.ok(refused > 50);
});
