// Two gamuts by hue: how far each reaches, and the volume that only one of them has.
import { cssColour } from "../colours/colours.js";
import type { Space } from "../colours/spaces.js";
import { Chart, DASHES, type Point, type Size, type Theme, niceStep, numberText, shortened } from "./chart.js";

/** Figures by sector of hue, as `sectors` of a comparison. Hues are in degrees. */
export interface HueSectors {
  hue_from: readonly number[];
  hue_to: readonly number[];
  volume_a: readonly number[];
  volume_b: readonly number[];
  intersection: readonly number[];
}

interface Options {
  size: Size;
  theme: Theme;
  space: Space;
}

export interface HueReach {
  name: string;
  /** Largest chroma in equal sectors of hue from 0° on, as `reachByHue` gives it. */
  chroma: readonly number[];
}

/** Lightness of the colours that stand for hues, in parts of the white's. */
const HUE_LIGHTNESS = 0.65;
const SPOKES = 12;
/** Characters of names in sentences. */
const MOST_NAME = 36;

/** CSS colours of hues in degrees at a chroma. */
function hueColours(space: Space, hues: readonly number[], chroma: number): string[] {
  // Of white: 100 in CIELAB, about 1 or less in Oklab, IPT and absolute spaces.
  const white = whiteLightness(space);
  const points = hues.flatMap((hue) => {
    const angle = (hue * Math.PI) / 180;
    return [HUE_LIGHTNESS * white, chroma * Math.cos(angle), chroma * Math.sin(angle)];
  });
  const linear = space.linear(Float32Array.from(points), "srgb");
  return hues.map((_, i) => cssColour(linear.subarray(3 * i, 3 * i + 3), "srgb"));
}

/** Lightness of a neutral with the luminance of white, by bisection. */
function whiteLightness(space: Space): number {
  let [low, high] = [0, 1000];
  for (let i = 0; i < 40; i++) {
    const middle = (low + high) / 2;
    if (space.toXyz(Float32Array.of(middle, 0, 0))[1]! < 1) low = middle;
    else high = middle;
  }
  return low;
}

/** Return a polar chart as SVG: the largest chroma by hue of each gamut, at any lightness. */
export function reachChart(gamuts: readonly HueReach[], { size, theme, space }: Options): string {
  const most = Math.max(1e-9, ...gamuts.flatMap(({ chroma }) => chroma));
  const step = niceStep(most, 4);
  const outer = Math.ceil(most / step - 1e-6) * step;
  const reach = 1.16 * outer;
  const chart = new Chart({
    size,
    theme,
    title: "Largest chroma by hue",
    caption: "Distance from the middle: largest chroma at any lightness. Around: hue.",
    x: { range: [-reach, reach], label: "" },
    y: { range: [-reach, reach], label: "" },
    isEqual: true,
    isBare: true,
    legend: gamuts.map(({ name }, place) => ({
      name,
      style: { stroke: theme.text, width: 1.8, dash: DASHES[place % DASHES.length]! },
    })),
    legendAt: "below",
  });
  const around = (radius: number, degrees: number): Point => {
    const angle = (degrees * Math.PI) / 180;
    return [radius * Math.cos(angle), radius * Math.sin(angle)];
  };
  const ring = (radius: number) => Array.from({ length: 120 }, (_, i) => around(radius, 3 * i));
  const [first] = gamuts;
  if (first !== undefined) {
    // Wedges of the first gamut in the colours of their hues.
    const sector = 360 / first.chroma.length;
    const hues = first.chroma.map((_, i) => (i + 0.5) * sector);
    hueColours(space, hues, 0.5 * most).forEach((colour, i) => {
      const wedge = [[0, 0] as Point, around(first.chroma[i]!, i * sector), around(first.chroma[i]!, (i + 1) * sector)];
      chart.polygon(wedge, { fill: colour, stroke: colour, width: 0.6 });
    });
  }
  for (let radius = step; radius <= outer + step / 2; radius += step) {
    chart.polygon(ring(radius), { stroke: theme.soft, width: 0.8, opacity: 0.5 });
  }
  for (let spoke = 0; spoke < SPOKES; spoke++) {
    const degrees = (360 / SPOKES) * spoke;
    chart.line([[0, 0], around(outer, degrees)], { stroke: theme.soft, width: 0.8, opacity: 0.35 });
    chart.text(around(1.08 * outer, degrees), `${degrees}°`, [0, 0], "middle", theme.soft);
  }
  gamuts.forEach(({ chroma }, place) => {
    const sector = 360 / chroma.length;
    const outline = chroma.map((value, i) => around(value, (i + 0.5) * sector));
    chart.polygon(outline, { stroke: theme.text, width: 1.8, dash: DASHES[place % DASHES.length]!, rim: true });
  });
  for (let radius = step; radius <= outer + step / 2; radius += step) {
    chart.text(around(radius, 75), numberText(radius), [0, 8], "middle");
  }
  return chart.svg();
}

/**
 * Return bars as SVG: upwards the volume that only the first gamut has, downwards that of the second.
 *
 * `unit` names the unit of volumes, such as "cubic ΔE*ab".
 */
export function sectorChart(
  a: string,
  b: string,
  sectors: HueSectors,
  { size, theme, space, unit = "cubic units" }: Options & { unit?: string },
): string {
  const [first, second] = [shortened(a, MOST_NAME), shortened(b, MOST_NAME)];
  const count = sectors.hue_from.length;
  const beyond = (volumes: readonly number[], i: number) => Math.max(0, volumes[i]! - sectors.intersection[i]!);
  const only = Array.from({ length: count }, (_, i) => [beyond(sectors.volume_a, i), beyond(sectors.volume_b, i)] as const);
  const most = Math.max(1e-12, ...only.flat());
  const power = 3 * Math.floor(Math.log10(most) / 3);
  const scale = power >= 3 || power <= -3 ? 10 ** power : 1;
  const upper = Math.max(...only.map(([value]) => value), 0.15 * most) / scale;
  const lower = Math.max(...only.map(([, value]) => value), 0.15 * most) / scale;
  const step = niceStep(upper + lower, 5);
  const ticks = [];
  for (let number = -Math.floor(lower / step); number * step <= upper; number++) {
    ticks.push({ value: number * step, text: numberText(Math.abs(number * step)) });
  }
  const factor = scale === 1 ? "" : scale === 1000 ? "thousand " : scale === 1e6 ? "million " : `10^${numberText(power)}^ `;
  const chart = new Chart({
    size,
    theme,
    title: "Volume of only one gamut, by hue",
    caption: `Above the line: only ${first} has it. Below: only ${second}.`,
    x: { range: [0, 360], label: "Hue", ticks: [0, 60, 120, 180, 240, 300, 360].map((value) => ({ value, text: `${value}°` })) },
    y: { range: [-1.12 * lower, 1.12 * upper], label: `Volume, ${factor}${unit}`, ticks },
  });
  const middles = sectors.hue_from.map((from, i) => (from + sectors.hue_to[i]!) / 2);
  const colours = hueColours(space, middles, 0.5 * whiteLightness(space));
  only.forEach(([above, below], i) => {
    const [from, to] = [sectors.hue_from[i]!, sectors.hue_to[i]!];
    const bar = (height: number): Point[] => [[from, 0], [to, 0], [to, height], [from, height]];
    const style = { fill: colours[i]!, stroke: theme.text, width: 0.6 };
    if (above > 0) chart.polygon(bar(above / scale), style);
    if (below > 0) chart.polygon(bar(-below / scale), style);
  });
  chart.line([[0, 0], [360, 0]], { stroke: theme.text, width: 1.2 });
  chart.text([6, 1.12 * upper], `only ${first}`, [0, 12]);
  chart.text([6, -1.12 * lower], `only ${second}`, [0, -10]);
  return chart.svg();
}

