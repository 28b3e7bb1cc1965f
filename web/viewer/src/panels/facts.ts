// What is said about the gamuts: facts beside the view, and the texts of the page for everybody.
import { byId, element, definitions, type Definition, warningTexts } from "../page/elements.js";
import type { Page } from "../page/page.js";
import type { Gamut } from "../service/api.js";
import { conditions } from "./conditions.js";

export function connectFacts(page: Page): void {
  page.on("gamuts", () => {
    const blocks = page.shown.flatMap(({ gamut }) => facts(gamut));
    byId("facts").replaceChildren(
      ...(blocks.length > 0 ? blocks : [element("p", "No gamut is shown.", { className: "note" })]),
    );
    describe(page);
  });
  page.on("level", () => describe(page));
}

/** The name of the view for those who do not see it, and the title of the page. */
function describe({ shown, canvas }: Page): void {
  const names = shown.map(({ gamut, layer }) => `${gamut.name}, ${layer.level?.triangles ?? 0} triangles`);
  canvas.setAttribute("aria-label", names.length === 0 ? "No gamut is shown" : names.join("; "));
  document.title = [...shown.map(({ gamut }) => gamut.name), "Gamut viewer"].join(" – ");
}

function facts(gamut: Gamut): HTMLElement[] {
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
