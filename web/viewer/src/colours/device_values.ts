// Device values for people: always per cent, of inks as of red, green and blue.
import type { Recipes } from "../service/queries.js";

/** Whether channels are red, green and blue. */
export function isRgb(channels: string[]): boolean {
  return channels.every((name) => /^[RGB]$/i.test(name)); // G alone may be a green ink
}

/** The unit of device values on the page and in its files. */
export const DEVICE_UNIT = "%";

/** Device values in per cent, to a tenth. */
export function devicePercent(values: number[]): number[] {
  return values.map((value) => Math.round(1000 * value) / 10);
}

/** Names of channels with their values, such as C 15 M 62 Y 55 K 21. */
export function deviceText(channels: string[], values: number[], separator = " "): string {
  return channels.map((name, i) => `${name} ${Math.round(100 * values[i]!)}`).join(separator);
}

/** The same with the unit, for a line without a head. */
export function deviceLine(channels: string[], values: number[]): string {
  return `${deviceText(channels, values, "  ")} ${DEVICE_UNIT}`;
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
