// Colours on a screen: what it can show, and CSS.
import type { Screen } from "./spaces.js";

/** The wider gamut, where the screen has it. */
export const SCREEN: Screen = globalThis.matchMedia?.("(color-gamut: p3)").matches ? "display-p3" : "srgb";

/** A screen cannot show colours whose linear RGB is further than this from 0 to 1. */
export const BEYOND = 0.005;

/** How far linear RGB that is not clipped is from 0 to 1: a number for each colour. */
export function excessOf(linear: Float32Array): Float32Array {
  const excess = new Float32Array(linear.length / 3);
  for (let i = 0; i < linear.length; i++) {
    const place = Math.floor(i / 3);
    excess[place] = Math.max(excess[place]!, -linear[i]!, linear[i]! - 1);
  }
  return excess;
}

/** Values in 0 to 1, encoded for a screen; both screens have the same curve (IEC 61966-2-1). */
export function encoded(linear: number): number {
  const value = linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055;
  return Math.min(Math.max(value, 0), 1);
}

/** CSS colour of linear RGB of a screen. */
export function cssColour(linear: ArrayLike<number>, screen: Screen = SCREEN): string {
  const parts = Array.from(linear, encoded);
  if (screen === "display-p3") return `color(display-p3 ${parts.map((value) => value.toFixed(4)).join(" ")})`;
  return `rgb(${parts.map((value) => Math.round(255 * value)).join(" ")})`;
}

/** Chroma and hue in degrees of two opponent coordinates. */
export function polar(a: number, b: number): [number, number] {
  return [Math.hypot(a, b), ((Math.atan2(b, a) * 180) / Math.PI + 360) % 360];
}
