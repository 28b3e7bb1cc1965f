// The colour under the pointer: coordinates, chroma and hue, device values, and the distance to the
// other gamut.
import type { Intersection } from "three";
import type { Gamut } from "./api.js";
import { cssColour, polar } from "./colours.js";
import { element } from "./elements.js";
import type { LevelBuffers } from "./messages.js";
import { edgeText, positionOf, type Positions } from "./queries.js";

/** Interpolate values of vertices, `width` numbers each, at a point of a surface. */
export function valuesAt(hit: Intersection, values: Float32Array, width: number): number[] {
  const { a, b, c } = hit.face!;
  const weights = hit.barycoord!.toArray();
  return Array.from({ length: width }, (_, i) =>
    [a, b, c].reduce((sum, corner, k) => sum + weights[k]! * values[width * corner + i]!, 0),
  );
}

export function readout(
  gamut: Gamut,
  names: string[],
  level: LevelBuffers,
  hit: Intersection,
): HTMLElement[] {
  const mean = (values: Float32Array, width: number) => valuesAt(hit, values, width);
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

/** A line with the signed distance to another gamut, which the service is asked for. */
export class DistanceLine {
  readonly element = element("span");
  private busy = false;
  private wish: { other: Gamut; point: number[] } | null = null;
  private asking = new AbortController();

  /** Ask for the distance of a colour. While an answer is under way, only the last wish counts. */
  ask(other: Gamut, point: number[]): void {
    this.wish = { other, point };
    if (!this.busy) void this.answer();
  }

  /** Show nothing, and drop the answer that is under way. */
  clear(): void {
    this.wish = null;
    this.asking.abort();
    this.element.textContent = "";
  }

  private async answer(): Promise<void> {
    this.busy = true;
    while (this.wish !== null) {
      const { other, point } = this.wish;
      this.wish = null;
      this.asking = new AbortController();
      const { signal } = this.asking;
      const found = await positionOf(other, point, signal).catch(() => null);
      // Colours at which the service fails have no distance: the panel of the comparison tells why.
      if (signal.aborted) continue;
      this.element.textContent = found === null ? "" : distanceText(other.name, found);
    }
    this.busy = false;
  }
}

function distanceText(name: string, found: Positions): string {
  const distance = found.distance[0]!;
  const shown = signed(distance, Math.abs(distance) < 0.1 ? 4 : 2);
  return `${shown} from ${name}: ${found.position[0]!} (${edgeText(found)})`;
}

function signed(value: number, digits: number): string {
  return value.toFixed(digits).replace("-", "−");
}

/** Percent of ink, or an 8-bit code of red, green and blue. */
function deviceText(channel: string, value: number): string {
  return /^[RGB]$/i.test(channel) ? String(Math.round(255 * value)) : `${Math.round(100 * value)} %`;
}
