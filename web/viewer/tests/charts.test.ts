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
import { reachChart, sectorChart } from "../src/charts/hues.js";
import { ringsChart } from "../src/charts/rings.js";
import { reachByHue, reachOf, type Surface, unrolledChart } from "../src/charts/unrolled.js";
import { spaceOf } from "../src/colours/spaces.js";

const EVIL = `A_b ^c^ <script>alert("1")</script> & 'x' ${"long ".repeat(30)}`;
const SIZES = { wide: { width: 640, height: 480 }, phone: { width: 320, height: 320 } };
const SRGB = { name: "sRGB", corners: [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06]] as const };
const space = spaceOf();

/** An octahedron around L* 50, with a chroma of so much at its corners. */
function octahedron(name: string, chroma: number): Surface {
  const c = chroma;
  return {
    name,
    positions: Float32Array.of(0, 0, 0, 100, 0, 0, 50, c, 0, 50, 0, c, 50, -c, 0, 50, 0, -c),
    faces: Int32Array.of(1, 2, 3, 1, 3, 4, 1, 4, 5, 1, 5, 2, 0, 3, 2, 0, 4, 3, 0, 5, 4, 0, 2, 5),
  };
}

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
      const [first, second] = [octahedron(EVIL, 60), octahedron("second", 70)];
      const charts = {
        xy: chromaticityChart([SRGB, { ...SRGB, name: EVIL }], { size, theme }),
        uv: chromaticityChart([SRGB], { diagram: "uv", size, theme }),
        none: chromaticityChart([], { size, theme }),
        one: unrolledChart(space, first, null, { size, theme }),
        two: unrolledChart(space, first, second, { size, theme }),
        reach: reachChart([first, second].map((each) => ({ name: each.name, chroma: reachByHue(each) })), { size, theme, space }),
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

test("the reach of an octahedron is that of its equation", () => {
  const rhombus = (hue: number) => 60 / (Math.abs(Math.cos(hue)) + Math.abs(Math.sin(hue)));
  const { columns, rows, chroma } = reachOf(octahedron("", 60), [0, 100]);
  chroma.forEach((value, i) => {
    const hue = (((i % columns) + 0.5) / columns) * 2 * Math.PI;
    const lightness = ((Math.floor(i / columns) + 0.5) / rows) * 100;
    assert.ok(Math.abs(value - rhombus(hue) * (1 - Math.abs(lightness - 50) / 50)) < 1e-3);
  });
  reachByHue(octahedron("", 60), 90).forEach((value, i) => {
    assert.ok(Math.abs(value - rhombus(((i + 0.5) / 90) * 2 * Math.PI)) < 1e-3);
  });
});

test("only what reaches further is hatched", () => {
  const chart = (other: number) => unrolledChart(space, octahedron("one", 60), octahedron("other", other), { size: SIZES.wide, theme: LIGHT });
  const hatched = /<path d="([^"]*)"[^>]*fill="url\(#chart-\d+-hatch/;
  assert.equal(hatched.exec(chart(60)), null);
  assert.equal(hatched.exec(chart(50)), null);
  assert.ok(hatched.exec(chart(90))![1]!.length > 1000);
});

test("bars are as high as the volumes that only one gamut has", () => {
  const svg = sectorChart("one", "other", sectors, { size: SIZES.wide, theme: LIGHT, space });
  const bars = [...svg.matchAll(/d="M([\d.]+),([\d.]+)L[\d.]+,[\d.]+L[\d.]+,([\d.]+)L/g)].map(([, , zero, end]) => Number(zero) - Number(end));
  assert.equal(bars.length, 2);
  assert.ok(Math.abs(bars[0]! / bars[1]! + 3000 / 2000) < 0.01); // one upwards, one downwards
});

test("bands of rings have the colours of the hues of their space", () => {
  // The hue of red in ICtCp is near 113°, where CIELAB has green (ITU-R BT.2100; white at 203 cd/m²).
  const [count, white, red] = [72, 0.58, 113];
  const ictcp = spaceOf({
    name: "ICtCp", axes: ["I", "Ct", "Cp"], reference_white: "D65", reference_white_xyz: [0.95046, 1, 1.08906], luminance: 203,
  });
  const hue = Array.from({ length: count }, (_, i) => (i + 0.5) * (360 / count));
  const rings = { volume: 1, lightness: [white / 2, white], hue, radius: [hue.map(() => 1), hue.map(() => 2)] };
  const look = { size: SIZES.wide, theme: LIGHT, title: "", caption: "", names: [""], colours: ["#000"] };
  const sector = (chart: string) => {
    const fills = [...chart.matchAll(/fill="rgb\((\d+) (\d+) (\d+)\)"/g)].map(([, ...parts]) => parts.map(Number));
    assert.equal(fills.length, 2 * count);
    return fills[Math.round(red / (360 / count))]!;
  };
  const [r, g, b] = sector(ringsChart(rings, { ...look, axes: ictcp.axes, space: ictcp }));
  assert.ok(r! > g! + 40 && g! > b!, `${r} ${g} ${b}`);
  const [red113, green113] = sector(ringsChart(rings, { ...look, axes: space.axes, space }));
  assert.ok(green113! > red113! - 10, `${red113} ${green113}`);
});
