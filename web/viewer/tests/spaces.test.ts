// Formulas of colour spaces against those of `gamutcore`.
//
//   SPACES=FILE node spaces.test.mjs
//
// The file is JSON: for each space its description, coordinates, and the expected CIELAB, linear
// sRGB and linear Display P3, of which the last is not clipped.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import process from "node:process";
import { test } from "node:test";
import { BEYOND, cssColour, excessOf } from "../src/colours/colours.js";
import { type Screen, spaceOf, type SpaceDescription } from "../src/colours/spaces.js";

interface Case {
  description: SpaceDescription;
  coordinates: number[];
  lab: number[];
  srgb: number[];
  p3: number[];
}

const cases = JSON.parse(readFileSync(process.env["SPACES"]!, "utf8")) as Case[];

function largest(found: Float32Array, expected: number[]): number {
  assert.equal(found.length, expected.length);
  return expected.reduce((most, value, i) => Math.max(most, Math.abs(value - found[i]!)), 0);
}

for (const { description, coordinates, lab, srgb, p3 } of cases) {
  const { name, reference_white: white, adaptation, scale } = description;
  test(`${name}, ${white}, ${adaptation}, × ${scale}`, () => {
    const space = spaceOf(description);
    const positions = Float32Array.from(coordinates);
    assert.ok(largest(space.linear(positions), srgb) < 1e-4);
    assert.ok(largest(space.linear(positions, "display-p3", false), p3) < 1e-4);
    assert.ok(largest(space.toLab(positions), lab) < 5e-3);
    assert.deepEqual(space.axes, description.axes);
    // Far from all colours the result is finite as well.
    const far = Float32Array.from([1e4, -1e4, 1e4, -1e4, 1e4, 0, 0, 0, 0]);
    assert.ok(space.linear(far, "srgb", false).every(Number.isFinite));
  });
}

test("CIELAB with D50 is what is meant without a description", () => {
  assert.equal(cssColour(spaceOf().linear(Float32Array.of(100, 0, 0))), "rgb(255 255 255)");
  assert.throws(() => spaceOf({ name: "Munsell" }), /Munsell/);
});

test("a green of Display P3 is beyond sRGB only", () => {
  const lab = Float32Array.of(80, -95, 70, 50, 0, 0);
  const space = spaceOf();
  const isBeyond = (screen: Screen) => [...excessOf(space.linear(lab, screen, false))].map((excess) => excess > BEYOND);
  assert.deepEqual(isBeyond("srgb"), [true, false]);
  assert.deepEqual(isBeyond("display-p3"), [false, false]);
  assert.match(cssColour([0, 1, 0], "display-p3"), /^color\(display-p3 0\.0000 1\.0000 0\.0000\)$/);
});
