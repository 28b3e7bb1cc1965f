// The slider of levels, and how far a level is from the full boundary.
import { numberText } from "../charts/chart.js";
import { byId, element } from "../page/elements.js";
import type { Page } from "../page/page.js";
import type { Gamut } from "../service/api.js";

const PLACES = 1000;
const COARSEST = 4;

export function connectLevel(page: Page): void {
  const slider = byId<HTMLInputElement>("slider");
  const number = byId<HTMLInputElement>("triangles");
  slider.addEventListener("input", () => page.setTriangles(countAt(Number(slider.value), page.finest)));
  number.addEventListener("change", () => {
    if (number.value !== "") page.setTriangles(Number(number.value));
    number.value = String(page.triangles);
  });
  const refresh = () => {
    const { finest, shown } = page;
    slider.disabled = number.disabled = shown.length === 0;
    const wanted = Math.min(page.triangles, finest);
    slider.value = String(placeOf(wanted, finest));
    slider.setAttribute("aria-valuetext", `${wanted} triangles`);
    number.max = String(finest);
    if (document.activeElement !== number) number.value = String(wanted);
    byId("level-note").replaceChildren(
      ...shown.map(({ gamut, layer, isPart }) =>
        element("span", limitNote(gamut, layer.level?.triangles ?? 0, isPart ? Math.min(wanted, layer.available) : wanted)),
      ),
    );
  };
  page.on(["slots", "level"], refresh);
}

/** Triangles at a place of the slider, 0 to 1000: equal steps are equal factors. */
function countAt(place: number, finest: number): number {
  const count = COARSEST * (finest / COARSEST) ** (place / PLACES);
  return Math.min(finest, 2 * Math.round(count / 2));
}

/** The place of the slider for a number of triangles. */
function placeOf(triangles: number, finest: number): number {
  if (finest <= COARSEST) return PLACES;
  return Math.round((PLACES * Math.log(triangles / COARSEST)) / Math.log(finest / COARSEST));
}

/** What is drawn, and how far it is from the full boundary at most. */
function limitNote(gamut: Gamut, triangles: number, aim: number): string {
  const shown = `${gamut.name}: ${triangles.toLocaleString("en")}`;
  if (triangles < Math.min(aim, gamut.counts.triangles)) return `${shown}, loading`;
  if (triangles === gamut.counts.triangles) return `${shown}, the full boundary`;
  const level = gamut.levels.findLast((each) => each.triangles <= triangles);
  if (level === undefined) return shown;
  const unit = gamut.options.space === "CIELAB" ? " ΔE*ab" : "";
  // the curve has a bound for its own counts only; between them errors may rise a little
  const how = level.triangles === triangles ? "within" : "within about";
  return `${shown}, ${how} ${numberText(level.distance_bound, 2)}${unit}`;
}
