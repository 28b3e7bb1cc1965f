// Charts as SVG: what they show, for data with known answers.
//
//   CHARTS=FOLDER node charts.test.mjs
//
// Writes the charts to the folder, where the test in Python reads them.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import process from "node:process";
import { test } from "node:test";
import { DARK, LIGHT, numberText } from "../src/charts/chart.js";
import { chromaticityChart } from "../src/charts/chromaticity.js";
import { sectorChart } from "../src/charts/hues.js";
import { spaceOf } from "../src/colours/spaces.js";

const EVIL = `A_b ^c^ <script>alert("1")</script> & 'x' ${"long ".repeat(30)}`;
const SIZES = { wide: { width: 640, height: 480 }, phone: { width: 320, height: 320 } };
const SRGB = { name: "sRGB", corners: [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06]] as const };
const space = spaceOf();

const sectors = {
  hue_from: [0, 90, 180, 270],
  hue_to: [90, 180, 270, 360],
  volume_a: [4000, 1000, 0, 500],
  volume_b: [1000, 3000, 0, 500],
  intersection: [1000, 1000, 0, 500],
};

test("numbers have significant digits, and no exponent", () => {
  const texts = [numberText(102.4, 2), numberText(-1234567.8), numberText(0.00000012345, 2), numberText(-0), numberText(99.96, 3)];
  assert.deepEqual(texts, ["100", "−1234570", "0.00000012", "0", "100"]);
});

for (const [name, size] of Object.entries(SIZES)) {
  for (const [scheme, theme] of Object.entries({ LIGHT, DARK })) {
    test(`charts, ${name}, ${scheme}`, () => {
      const charts = {
        xy: chromaticityChart([SRGB, { ...SRGB, name: EVIL }], { size, theme }),
        uv: chromaticityChart([SRGB], { diagram: "uv", size, theme }),
        none: chromaticityChart([], { size, theme }),
        sectors: sectorChart(EVIL, "second", sectors, { size, theme, space }),
      };
      for (const [kind, svg] of Object.entries(charts)) {
        assert.doesNotMatch(svg, /NaN|Infinity|undefined|null|<script/, kind);
        writeFileSync(`${process.env["CHARTS"]}/${kind}-${name}-${scheme}.svg`, svg);
      }
    });
  }
}

function frameOf(svg: string): number[] {
  return /-frame"><rect x="([\d.]+)" y="([\d.]+)" width="([\d.]+)" height="([\d.]+)"/.exec(svg)!.slice(1).map(Number);
}

test("a diagram has its gamuts where their primaries are, in equal scales", () => {
  const svg = chromaticityChart([SRGB], { size: SIZES.wide, theme: LIGHT });
  const [left, top, width, height] = frameOf(svg) as [number, number, number, number];
  assert.ok(Math.abs(width / 0.85 - height / 0.95) < 0.5);
  const corners = SRGB.corners.map(([x, y]) => [left + ((x + 0.05) / 0.85) * width, top + ((0.9 - y) / 0.95) * height]);
  const shown = /d="M([\d.,L]+)Z"[^>]*stroke-width="1.8"/.exec(svg)![1]!.split("L").map((pair) => pair.split(",").map(Number));
  shown.flat().forEach((value, i) => assert.ok(Math.abs(value - corners.flat()[i]!) < 0.2));
});

test("bars are as high as the volumes that only one gamut has", () => {
  const svg = sectorChart("one", "other", sectors, { size: SIZES.wide, theme: LIGHT, space });
  const bars = [...svg.matchAll(/d="M([\d.]+),([\d.]+)L[\d.]+,[\d.]+L[\d.]+,([\d.]+)L/g)].map(([, , zero, end]) => Number(zero) - Number(end));
  assert.equal(bars.length, 2);
  assert.ok(Math.abs(bars[0]! / bars[1]! + 3000 / 2000) < 0.01); // one upwards, one downwards
});
