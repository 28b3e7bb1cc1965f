// Device values for people: per cent of ink, or 8-bit codes of red, green and blue.
import type { Recipes } from "../service/queries.js";

function isRgb(channels: string[]): boolean {
  return channels.every((name) => /^[RGB]$/i.test(name)); // G alone may be a green ink
}

/** The unit of the numbers of `deviceText`. */
export function deviceUnit(channels: string[]): string {
  return isRgb(channels) ? "0–255" : "%";
}

/** Names of channels with their values, such as C 15 M 62 Y 55 K 21. */
export function deviceText(channels: string[], values: number[], separator = " "): string {
  const most = isRgb(channels) ? 255 : 100;
  return channels.map((name, i) => `${name} ${Math.round(most * values[i]!)}`).join(separator);
}

/** The same for a line without a head, with the unit where it is per cent. */
export function deviceLine(channels: string[], values: number[]): string {
  return deviceText(channels, values, "  ") + (isRgb(channels) ? "" : " %");
}

/** The possible range of black of a recipe, such as 0–42; null without black. */
export function blackRange({ black_least: least, black_most: most }: Recipes, row: number): string | null {
  const ends = [least?.[row], most?.[row]].flatMap((end) => (end == null ? [] : [Math.round(100 * end)]));
  return ends.length === 0 ? null : [...new Set(ends)].join("–");
}

/** The channel of black, whose range is stated. */
export function blackChannel(channels: string[]): string {
  return channels.find((name) => /^(k|black)$/i.test(name)) ?? "black";
}
