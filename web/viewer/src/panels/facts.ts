// What is said about the gamuts: facts beside the view, and the texts of the page for everybody.
import { byId, element, warningTexts } from "../page/elements.js";
import type { Page } from "../page/page.js";
import { type Definition, TERMS, definitions } from "../page/glossary.js";
import type { Gamut } from "../service/api.js";
import { conditions, volumeUnit } from "./conditions.js";

export function connectFacts(page: Page): void {
  const list = () => {
    const blocks = page.shown.flatMap(({ gamut }) => facts(gamut));
    byId("facts").replaceChildren(
      ...(blocks.length > 0 ? blocks : [element("p", "No gamut is shown.", { className: "note" })]),
    );
  };
  page.on(["slots"], () => {
    list();
    describe(page);
  });
  page.on(["level"], () => describe(page));
}

/** The name of the view for those who do not see it, and the title of the page. */
function describe({ shown, canvas }: Page): void {
  const names = shown.map(({ gamut, layer }) => `${gamut.name}, ${layer.level?.triangles ?? 0} triangles`);
  canvas.setAttribute("aria-label", names.length === 0 ? "No gamut is shown" : names.join("; "));
  document.title = [...shown.map(({ gamut }) => gamut.name), "Gamut viewer"].join(" – ");
}

/** The volume with each intent that the gamut has, also in volumes of sRGB. */
function volumes({ volume, volumes: stated = {}, ...gamut }: Gamut): Definition[] {
  const terms = { own: "Volume", relative: "Volume, relative", absolute: "Volume, absolute" } as const;
  const shown = (value: number) => `${rounded(value, 6)} ${volumeUnit(gamut)}`;
  const rows = Object.entries(terms).flatMap(([name, term]): Definition[] => {
    const figures = stated[name as keyof typeof terms];
    return figures ? [[term, `${shown(figures.volume)}, ${rounded(figures.times_srgb, 3)} × sRGB`, TERMS["volume"]!]] : [];
  });
  return rows.length > 0 ? rows : [["Volume", shown(volume)]];
}

function rounded(value: number, digits: number): string {
  return value.toLocaleString("en", { maximumSignificantDigits: digits });
}

function facts(gamut: Gamut): HTMLElement[] {
  const warnings = warningTexts(gamut.provenance.warnings);
  return [
    element("h3", gamut.name),
    definitions([
      ...conditions(gamut),
      ...volumes(gamut),
      ["Full boundary", `${gamut.counts.triangles.toLocaleString("en")} triangles`],
      ...(gamut.options.boundary === "auto" ? [] : [["Method", gamut.options.boundary] as Definition]),
      ...(gamut.channels.length > 0 ? [["Channels", gamut.channels.join(" ")] as Definition] : []),
    ]),
    ...warnings.map((warning) => element("p", warning, { className: "warning" })),
  ];
}
