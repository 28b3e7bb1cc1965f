// Boundaries of plain arrays whose answers are known.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Boundary } from "../src/index.js";

/** A box of lightness 40 to 60 and a, b of −10 to 10: eight corners, 000 to 111. */
const positions = Array.from({ length: 8 }, (_, i) => [i & 4 ? 60 : 40, i & 2 ? 10 : -10, i & 1 ? 10 : -10]).flat();
const squares = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
const faces = squares.flatMap(([a, b, c, d]) => [a!, b!, c!, a!, c!, d!]);
const box = new Boundary({ positions, faces }, [50, 0, 0]);

test("a box", () => {
  assert.equal(box.volume, 8000);
  assert.equal(box.triangles, 12);
  for (const colour of [[50, 0, 0], [60, 10, 10], [40, -10, 3], [50, 10, 0]]) assert.ok(box.contains(colour));
  for (const colour of [[50, 10.001, 0], [61, 0, 0], [150, 80, 0]]) assert.ok(!box.contains(colour));
  assert.ok(box.contains([50, 11, 0], 1));
  assert.ok(!box.contains([50, 11, 11], 1.41));
  assert.ok(box.contains([50, 11, 11], 1.415));
  assert.equal(box.distance([50, 0, 8]), -2);
  assert.deepEqual([...box.nearest([45, 13, 30])], [45, 10, 10]);
  const out = new Float64Array(3);
  assert.equal(box.nearest([70, 20, -11], out), out);
  assert.deepEqual([...out], [60, 10, -10]);
});

test("chroma of a box", () => {
  const [[from, to] = [NaN, NaN]] = box.chroma(50, 45);
  assert.equal(from, 0);
  assert.ok(Math.abs(to - Math.hypot(10, 10)) < 1e-12);
  assert.deepEqual(box.chroma(70, 45), []);
  assert.equal(box.chroma(50, 0).length, 1); // through an edge between two faces
});

test("two intervals, where the gamut is concave", () => {
  // two wedges that meet below: the notch at a = 0 is open for lightness above 50
  const profile = [[40, -20], [40, 20], [70, 20], [48, 0], [70, -20]];
  const corners = profile.flatMap(([light, a]) => [[light!, a!, -5], [light!, a!, 5]]);
  const strip = profile.flatMap((_, i) => {
    const [p, q, r, s] = [2 * i, 2 * i + 1, (2 * i + 2) % 10, (2 * i + 3) % 10];
    return [p!, s!, q!, p!, r!, s!];
  });
  const caps = [[0, 1, 3], [1, 2, 3], [0, 3, 4]].flatMap(([a, b, c]) => [2 * a!, 2 * c!, 2 * b!, 2 * a! + 1, 2 * b! + 1, 2 * c! + 1]);
  const wedges = new Boundary({ positions: corners.flat(), faces: [...strip, ...caps].toReversed() }, [43, 0, 0]);
  const [interval, ...others] = wedges.chroma(59, 0);
  assert.equal(others.length, 0);
  assert.ok(Math.abs(interval![0] - 10) < 1e-12 && Math.abs(interval![1] - 20) < 1e-12);
  assert.deepEqual(wedges.chroma(45, 0).map(([from, to]) => [from, Math.round(to)]), [[0, 20]]);
  assert.ok(!wedges.contains([59, 5, 0]));
  const raised = wedges.clip([50, 0.5, 0], "chroma");
  assert.ok(wedges.contains(raised));
});

test("colours are clipped", () => {
  assert.deepEqual([...box.clip([45, 3, 4])], [45, 3, 4]);
  const near = (colour: Float64Array, expected: number[]) => expected.forEach((value, i) => assert.ok(Math.abs(colour[i]! - value) < 1e-9, `${colour}`));
  near(box.clip([50, 30, 0], "centre"), [50, 10, 0]);
  near(box.clip([55, 30, 30], "chroma"), [55, 10, 10]);
  near(box.clip([80, 30, 30], "chroma"), [60, 0, 0]);
  near(box.clip([20, 3, 0], "chroma"), [40, 0, 0]);
  near(box.clip([80, 30, 3]), [60, 10, 3]);
});

test("what is wrong is refused", () => {
  for (const ask of [() => box.contains([50, NaN, 0]), () => box.nearest([50, 0]), () => box.chroma(Infinity, 0)]) {
    assert.throws(ask, /three finite numbers/);
  }
  assert.throws(() => new Boundary({ positions, faces: faces.toReversed() }, [50, 0, 0]), /face 0 /);
  assert.throws(() => new Boundary({ positions, faces }, [90, 0, 0]), RangeError);
});
