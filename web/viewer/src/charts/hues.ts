// Two gamuts by hue: the volume that only one of them has.
import { cssColour } from "../colours/colours.js";
import type { Space } from "../colours/spaces.js";
import { Chart, type Point, type Size, type Theme, niceStep, numberText, shortened } from "./chart.js";

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

/** Lightness of the colours that stand for hues, in parts of the white's. */
const HUE_LIGHTNESS = 0.65;
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

