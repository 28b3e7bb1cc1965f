// The slider of levels, and what is said about gamuts and levels.
import type { Gamut } from "./api.js";
import { conditions } from "./conditions.js";
import { type Definition, definitions, element, warningTexts } from "./elements.js";

const PLACES = 1000;
const COARSEST = 4;

/** Triangles at a place of the slider, 0 to 1000: equal steps are equal factors. */
export function countAt(place: number, finest: number): number {
  const count = COARSEST * (finest / COARSEST) ** (place / PLACES);
  return Math.min(finest, 2 * Math.round(count / 2));
}

/** The place of the slider for a number of triangles. */
export function placeOf(triangles: number, finest: number): number {
  if (finest <= COARSEST) return PLACES;
  return Math.round((PLACES * Math.log(triangles / COARSEST)) / Math.log(finest / COARSEST));
}

/** What is drawn, and how far it is from the full boundary at most. */
export function limitNote(gamut: Gamut, triangles: number, aim: number): string {
  const shown = `${gamut.name}: ${triangles.toLocaleString("en")}`;
  if (triangles < Math.min(aim, gamut.counts.triangles)) return `${shown}, loading`;
  if (triangles === gamut.counts.triangles) return `${shown}, the full boundary`;
  const level = gamut.levels.findLast((each) => each.triangles <= triangles);
  if (level === undefined) return shown;
  const unit = gamut.options.space === "CIELAB" ? " ΔE*ab" : "";
  // the curve has a bound for its own counts only; between them errors may rise a little
  const how = level.triangles === triangles ? "within" : "within about";
  return `${shown}, ${how} ${level.distance_bound.toPrecision(2)}${unit}`;
}

export function facts(gamut: Gamut): HTMLElement[] {
  const warnings = warningTexts(gamut.provenance.warnings);
  return [
    element("h3", gamut.name),
    definitions([
      ...conditions(gamut),
      ["Volume", Number(gamut.volume.toPrecision(6)).toLocaleString("en")],
      ["Full boundary", `${gamut.counts.triangles.toLocaleString("en")} triangles`],
      ["Method", gamut.options.boundary],
      ...(gamut.channels.length > 0 ? [["Channels", gamut.channels.join(" ")] as Definition] : []),
    ]),
    ...warnings.map((warning) => element("p", warning, { className: "warning" })),
  ];
}
