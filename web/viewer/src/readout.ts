// The colour under the pointer: coordinates, chroma and hue, device values.
import type { Intersection } from "three";
import type { Gamut } from "./api.js";
import { cssColour, polar } from "./colours.js";
import { element } from "./elements.js";
import type { LevelBuffers } from "./messages.js";

export function readout(
  gamut: Gamut,
  names: string[],
  level: LevelBuffers,
  hit: Intersection,
): HTMLElement[] {
  const { a, b, c } = hit.face!;
  const corners = [a, b, c];
  const weights = hit.barycoord!.toArray();
  const mean = (values: Float32Array, width: number) =>
    Array.from({ length: width }, (_, i) =>
      corners.reduce((sum, corner, k) => sum + weights[k]! * values[width * corner + i]!, 0),
    );
  const point = mean(level.positions, 3);
  const swatch = element("span", "", { className: "swatch" });
  swatch.style.backgroundColor = cssColour(mean(level.colours, 3));
  const digits = Math.max(...point.map(Math.abs)) < 5 ? 4 : 1;
  const lines = [names.map((name, i) => `${name} ${signed(point[i]!, digits)}`).join("  ")];
  if (names[0] !== "X") {
    const [chroma, hue] = polar(point[1]!, point[2]!);
    lines.push(`C ${chroma.toFixed(digits)}  h ${hue.toFixed(1)}°`);
  }
  if (level.device !== null) {
    const values = mean(level.device, gamut.channels.length);
    lines.push(gamut.channels.map((name, i) => `${name} ${deviceText(name, values[i]!)}`).join("  "));
  }
  return [swatch, ...lines.map((line) => element("span", line))];
}

function signed(value: number, digits: number): string {
  return value.toFixed(digits).replace("-", "−");
}

/** Percent of ink, or an 8-bit code of red, green and blue. */
function deviceText(channel: string, value: number): string {
  return /^[RGB]$/i.test(channel) ? String(Math.round(255 * value)) : `${Math.round(100 * value)} %`;
}
