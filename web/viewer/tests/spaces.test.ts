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
import { type Screen, mediaRelative, spaceOf, type SpaceDescription } from "../src/colours/spaces.js";

interface Case {
  description: SpaceDescription;
  coordinates: number[];
  lab: number[];
  srgb: number[];
  p3: number[];
}

const cases = JSON.parse(readFileSync(process.env["SPACES"]!, "utf8")) as Case[];

function largest(values: Float32Array, expected: number[]): number {
  assert.equal(values.length, expected.length);
  return expected.reduce((most, value, i) => Math.max(most, Math.abs(value - values[i]!)), 0);
}

for (const { description, coordinates, lab, srgb, p3 } of cases) {
  const { name, reference_white: white, adaptation } = description;
  test(`${name}, ${white}, ${adaptation}`, () => {
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

test("a print relative to its paper: paper is white, and each luminance is divided by that of the paper", () => {
  const paper = [95, 0, -2];
  const relative = mediaRelative(Float32Array.of(...paper, 0, 0, 0, 50, 30, -20), paper);
  assert.ok(largest(relative.slice(0, 6), [100, 0, 0, 0, 0, 0]) < 1e-4);
  const luminance = (lightness: number) => ((lightness + 16) / 116) ** 3; // CIE 15:2018, 8.2.1.1
  assert.ok(Math.abs(luminance(relative[6]!) - luminance(50) / luminance(95)) < 1e-6);
});
