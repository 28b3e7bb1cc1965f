// What is said about the gamuts: facts beside the view, and the texts of the page for everybody.
import { byId, element, definitions, type Definition, warningTexts } from "../page/elements.js";
import type { Page } from "../page/page.js";
import { embedded } from "../page/embedded.js";
import { type Gamut, describe as gamutOf } from "../service/api.js";
import { conditions } from "./conditions.js";

/** Volumes of sRGB by space and intent; null while the service is asked, or if it has none. */
const volumes = new Map<string, number | null>();

export function connectFacts(page: Page): void {
  const list = () => {
    const blocks = page.shown.flatMap(({ gamut }) => facts(gamut, relativeVolume(gamut, list)));
    byId("facts").replaceChildren(
      ...(blocks.length > 0 ? blocks : [element("p", "No gamut is shown.", { className: "note" })]),
    );
  };
  page.on("gamuts", () => {
    list();
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

/** The volume in volumes of sRGB, in the same space and with the same intent. `arrived` is called once it is known. */
function relativeVolume({ options, provenance, volume }: Gamut, arrived: () => void): string | null {
  const intent = provenance.intent === "absolute" ? "absolute" : "relative";
  const key = `srgb?${new URLSearchParams({ intent, space: options.space })}`;
  if (provenance.reference === "srgb" && !volumes.get(key)) volumes.set(key, volume);
  const known = volumes.get(key);
  if (known) return `${Number((volume / known).toPrecision(3))} × sRGB, ${intent}`;
  if (known === undefined && embedded === null) {
    volumes.set(key, null);
    gamutOf(key, () => {}, new AbortController().signal)
      .then((reference) => {
        volumes.set(key, reference.volume);
        arrived();
      })
      .catch(() => volumes.delete(key));
  }
  return null;
}

function facts(gamut: Gamut, relative: string | null): HTMLElement[] {
  const warnings = warningTexts(gamut.provenance.warnings);
  const { space } = gamut.options;
  const unit = space === "CIELAB" ? "cubic ΔE*ab" : space === "CIEXYZ" ? "cubic units of X Y Z" : `cubic ΔE of ${space}`;
  return [
    element("h3", gamut.name),
    definitions([
      ...conditions(gamut),
      ["Volume", `${Number(gamut.volume.toPrecision(6)).toLocaleString("en", { maximumSignificantDigits: 6 })} ${unit}`],
      ...(relative === null ? [] : [["Relative volume", relative] as Definition]),
      ["Full boundary", `${gamut.counts.triangles.toLocaleString("en")} triangles`],
      ...(gamut.options.boundary === "auto" ? [] : [["Method", gamut.options.boundary] as Definition]),
      ...(gamut.channels.length > 0 ? [["Channels", gamut.channels.join(" ")] as Definition] : []),
    ]),
    ...warnings.map((warning) => element("p", warning, { className: "warning" })),
  ];
}
