// The chromaticity diagrams CIE 1931 xy and CIE 1976 u′v′, with the gamuts as polygons.
import { encoded } from "../colours/colours.js";
import { spaceOf } from "../colours/spaces.js";
import { Chart, DASHES, type Point, type Size, type Theme, png } from "./chart.js";
import { FIRST_WAVELENGTH, LOCUS, WAVELENGTH_STEP } from "./locus.js";

export type Diagram = "xy" | "uv";

export interface ChromaticityGamut {
  name: string;
  /** x, y of the corners of a convex polygon. */
  corners: readonly Point[];
  /** Of its line; that of the text without one. */
  colour?: string;
}

export interface White {
  name: string;
  xy: Point;
}

/** CIE 15:2018, table T.3; D50 as in ICC profiles. */
const WHITES: White[] = [
  { name: "D50", xy: [0.34567, 0.35851] },
  { name: "D65", xy: [0.3127, 0.329] },
];

const DIAGRAMS = {
  xy: { name: "CIE 1931", x: [-0.05, 0.8], y: [-0.05, 0.9], labels: ["_x_", "_y_"] },
  uv: { name: "CIE 1976", x: [-0.06, 0.66], y: [-0.04, 0.66], labels: ["_u_′", "_v_′"] },
} as const;

/** Rows and columns of the picture below the lines. */
const RASTER = 128;
/** Pixels between the labels of two wavelengths. */
const LABEL_DISTANCE = 25;
/** Charts that are less wide have no room for names in them. */
const NARROW = 420;

/** u′, v′ of a chromaticity (CIE 15:2018, 8.2.2). */
function placed([x, y]: Point, diagram: Diagram): Point {
  const divisor = -2 * x + 12 * y + 3;
  return diagram === "xy" ? [x, y] : [(4 * x) / divisor, (9 * y) / divisor];
}

/** Return the diagram as SVG. Colours of the area are approximate: no screen shows them all. */
export function chromaticityChart(
  gamuts: readonly ChromaticityGamut[],
  { diagram = "xy", size, theme, whites = WHITES }: { diagram?: Diagram; size: Size; theme: Theme; whites?: readonly White[] },
): string {
  const { name, x, y, labels } = DIAGRAMS[diagram];
  const chart = new Chart({
    size,
    theme,
    title: `Chromaticity, ${name} ${labels.map((label) => label.replaceAll("_", "")).join(" ")}`,
    caption: "The curve is light of one wavelength, in nm. Colours of the area are approximate.",
    x: { range: x, label: labels[0] },
    y: { range: y, label: labels[1] },
    isEqual: true,
    legend: gamuts.map(({ name: text, colour = theme.text }, place) => ({
      name: text,
      style: { stroke: colour, width: 1.8, dash: DASHES[place % DASHES.length]! },
    })),
    // In the corner where the diagram is empty, if there is room.
    legendAt: size.width < NARROW || gamuts.length > 3 ? "below" : diagram === "xy" ? "top" : "bottom",
  });
  const locus = LOCUS.map((point) => placed(point, diagram));
  chart.image(area(diagram), x, y, chart.path(locus), 0.85);
  chart.polygon(locus, { stroke: theme.text, width: 1.2 });
  drawWavelengths(chart, locus, theme);
  gamuts.forEach(({ corners, colour = theme.text }, place) => {
    const points = corners.map((corner) => placed(corner, diagram));
    chart.polygon(points, { stroke: colour, width: 1.8, dash: DASHES[place % DASHES.length]!, rim: true });
  });
  for (const white of whites) {
    const point = placed(white.xy, diagram);
    chart.point(point, {});
    // D50 and D65 are close to each other, so their names are on different sides.
    const isRight = white.xy[0] > 0.325;
    chart.text(point, white.name, [isRight ? 7 : -7, 0], isRight ? "start" : "end");
  }
  return chart.svg();
}

/** Ticks at wavelengths, outside of the locus, with as many labels as there is room for. */
function drawWavelengths(chart: Chart, locus: readonly Point[], theme: Theme): void {
  let last: Point = [-Infinity, -Infinity];
  locus.forEach(([x, y], i) => {
    const wavelength = FIRST_WAVELENGTH + i * WAVELENGTH_STEP;
    if (wavelength % 10 !== 0 || i === 0) return;
    const [before, after] = [locus[i - 1]!, locus[Math.min(i + 1, locus.length - 1)]!];
    const [dx, dy] = [chart.x(after[0]) - chart.x(before[0]), chart.y(after[1]) - chart.y(before[1])];
    const length = Math.hypot(dx, dy);
    // At the ends the curve hardly moves, and labels would be on top of each other.
    const here: Point = [chart.x(x), chart.y(y)];
    if (length < 2 || Math.hypot(here[0] - last[0], here[1] - last[1]) < LABEL_DISTANCE) return;
    last = here;
    const outward: Point = [dy / length, -dx / length];
    chart.point([x, y], { fill: theme.text, stroke: theme.back, width: 0.8 }, 2.5);
    const anchor = outward[0] > 0.35 ? "start" : outward[0] < -0.35 ? "end" : "middle";
    chart.text([x, y], String(wavelength), [7 * outward[0], 9 * outward[1]], anchor, theme.soft);
  });
}

const areas = new Map<Diagram, string>();

/** The brightest colours of a screen at the chromaticities of a diagram, clipped to its gamut. */
function area(diagram: Diagram): string {
  const known = areas.get(diagram);
  if (known !== undefined) return known;
  const { x, y } = DIAGRAMS[diagram];
  const xyz = new Float32Array(3 * RASTER * RASTER);
  for (let i = 0; i < RASTER * RASTER; i++) {
    const across = x[0] + (((i % RASTER) + 0.5) / RASTER) * (x[1] - x[0]);
    const up = y[1] - ((Math.floor(i / RASTER) + 0.5) / RASTER) * (y[1] - y[0]);
    const divisor = 6 * across - 16 * up + 12; // the inverse of u′, v′
    const chromaticity: Point = diagram === "xy" ? [across, up] : [(9 * across) / divisor, (4 * up) / divisor];
    xyz.set([chromaticity[0], chromaticity[1], 1 - chromaticity[0] - chromaticity[1]], 3 * i);
  }
  // Relative to D65, the white of the screen, so that the colours are those of the chromaticities.
  const [, white] = WHITES;
  const [wx, wy] = white!.xy;
  const space = spaceOf({ name: "CIEXYZ", reference_white_xyz: [wx / wy, 1, (1 - wx - wy) / wy] });
  const linear = space.linear(xyz, "srgb", false);
  const pixels = new Uint8ClampedArray(4 * RASTER * RASTER).fill(255);
  for (let i = 0; i < RASTER * RASTER; i++) {
    const colour = linear.subarray(3 * i, 3 * i + 3).map((value) => Math.max(value, 0));
    const most = Math.max(...colour, 1e-6);
    colour.forEach((value, channel) => (pixels[4 * i + channel] = 255 * encoded(value / most)));
  }
  const address = png(pixels, RASTER);
  areas.set(diagram, address);
  return address;
}
