// Gamut rings: the area within a ring is the volume of the gamut up to its lightness (IDMS 1.1, 5.32).
import { cssColour, polar } from "../colours/colours.js";
import { type Space, spaceOf } from "../colours/spaces.js";
import { Chart, DASHES, type Point, type Size, type Theme, numberText } from "./chart.js";

/** What the service answers: radii by ring and sector, and the middles of the sectors in degrees. */
export interface Rings {
  volume: number;
  lightness: number[];
  hue: number[];
  radius: number[][];
  reference_radius?: number[][];
  intersection_radius?: number[][];
}

export interface RingsOptions {
  size: Size;
  theme: Theme;
  title: string;
  caption: string;
  /** Names of the gamut and of the reference, and the colours of their lines. */
  names: string[];
  colours: string[];
  axes: readonly string[];
  /** Of the rings. */
  space: Space;
}

/** Bands stand for hues, not for colours: dark within, light outside, as in `gamutcore.questions.plotting`. */
const BAND_LIGHTNESS: Point = [22, 88];
const BAND_CHROMA = 42;
const WEDGES = 72;
/** Chroma of the colours whose CIELAB hues stand for hues of a space, relative to their lightness: as there. */
const SAMPLE_CHROMA = 0.8;

/** Draw the rings, the outer ring of the reference, and the outer ends of the intersection. */
export function ringsChart(answer: Rings, { names, colours, axes, space, ...options }: RingsOptions): string {
  const curves = (radius: number[][]) => radius.map((ring) => ring.map((length, i) => onCircle(length, answer.hue[i]!)));
  const rings = curves(answer.radius);
  const outer = rings.length - 1;
  const reference = curves(answer.reference_radius ?? []).at(-1);
  const all = [...rings[outer]!, ...(reference ?? [])];
  const range = (axis: 0 | 1): Point => {
    const values = [0, ...all.map((point) => point[axis])];
    const [low, high] = [Math.min(...values), Math.max(...values)];
    return [low - 0.04 * (high - low), high + 0.04 * (high - low)];
  };
  const lines = [rings[outer]!, ...(reference === undefined ? [] : [reference])];
  const styles = lines.map((_, i) => ({ stroke: colours[i]!, width: 2, dash: DASHES[i]! }));
  const both = { stroke: options.theme.soft, width: 1.4, dash: "3 2" };
  const chart = new Chart({
    ...options,
    x: { range: range(0), label: `_${axes[1]}_~RSS~` },
    y: { range: range(1), label: `_${axes[2]}_~RSS~` },
    isEqual: true,
    legend: [
      ...styles.map((style, i) => ({ name: names[i]!, style })),
      ...(answer.intersection_radius === undefined ? [] : [{ name: "What both have of each band", style: both }]),
    ],
    legendAt: "below",
  });
  const hues = answer.hue.map((hue) => labHue(space, answer.lightness.at(-1)! / 2, hue));
  drawBands(chart, rings, hues);
  const within = curves(answer.intersection_radius ?? []).map((curve) => chart.path(curve));
  chart.draw(within.join(""), { ...both, stroke: "#fff" });
  for (const ring of rings.slice(0, -1)) chart.polygon(ring, { stroke: "#111", width: 0.7 });
  lines.forEach((line, i) => chart.polygon(line, { ...styles[i]!, rim: true }));
  chart.point([0, 0], { stroke: "#111", fill: "#fff" }, 2.5);
  // The labels are where the rings are farthest apart.
  const middle = Math.max(Math.floor(rings.length / 2) - 1, 0);
  const room = answer.radius[outer]!.map((length, i) => length - answer.radius[middle]![i]!);
  const at = room.indexOf(Math.max(...room));
  for (const ring of new Set([0, middle, outer])) {
    chart.text(rings[ring]![at]!, `${axes[0]} ${numberText(answer.lightness[ring]!, 3)}`, [0, 0], "middle");
  }
  return chart.svg();
}

function onCircle(radius: number, degrees: number): Point {
  const angle = (degrees * Math.PI) / 180;
  return [radius * Math.cos(angle), radius * Math.sin(angle)];
}

/** The CIELAB hue of colours with a hue of a space, in degrees. */
function labHue(space: Space, lightness: number, hue: number): number {
  const [, a, b] = space.toLab(Float32Array.of(lightness, ...onCircle(SAMPLE_CHROMA * lightness, hue)));
  return polar(a!, b!)[1];
}

/** Fill the bands between rings with the hues that they stand for, in CIELAB. */
function drawBands(chart: Chart, rings: Point[][], hue: number[]): void {
  const [low, high] = BAND_LIGHTNESS;
  const lab = spaceOf();
  const count = hue.length;
  const width = Math.max(1, Math.floor(count / WEDGES));
  // From outside inwards: whole wedges, so that no seam shows between two bands.
  for (let band = rings.length - 1; band >= 0; band--) {
    const light = low + ((high - low) * band) / Math.max(1, rings.length - 1);
    for (let begin = 0; begin < count; begin += width) {
      const places = Array.from({ length: width + 2 }, (_, i) => (begin + i) % count);
      const [a, b] = onCircle(BAND_CHROMA, hue[places[width >> 1]!]!);
      chart.polygon([[0, 0], ...places.map((i) => rings[band]![i]!)], { fill: cssColour(lab.linear(Float32Array.of(light, a, b)), "srgb") });
    }
  }
}
