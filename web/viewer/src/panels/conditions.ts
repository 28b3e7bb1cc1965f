// What the colours of a gamut are relative to, in words: intent, ink limits, medium, white and space.
import { numberText } from "../charts/chart.js";
import type { Gamut } from "../service/api.js";
import type { Definition } from "../page/glossary.js";

/** Rendering intents of the service, each with a sentence. */
export const INTENTS: Record<string, string> = {
  relative: "Relative: the white of the medium counts as the white of the space.",
  absolute: "Absolute: the white of the medium keeps its colour, as in measured spot colours.",
  perceptual: "Perceptual: as an ICC profile renders pictures.",
  saturation: "Saturation: as an ICC profile renders graphics.",
};

const MEDIA: Record<string, string> = {
  reflective: "Print or another reflecting medium",
  unknown: "Not stated",
  output: "Printer or press",
  input: "Scanner or camera",
};

/** The unit of volumes of a gamut, in words. */
export function volumeUnit({ options }: Pick<Gamut, "options">): string {
  return options.space === "CIELAB" ? "cubic ΔE*ab" : `cubic units of ${options.space}`;
}

/** A volume of a gamut to four digits, without its unit. */
export function volumeText({ volume }: Pick<Gamut, "volume">): string {
  return volume.toLocaleString("en", { maximumSignificantDigits: 4 });
}

export function conditions({ options, provenance }: Gamut): Definition[] {
  const { colour_space: space, ink_limits: limits, white, white_lab, medium } = provenance;
  const kind = medium ?? provenance.device_class;
  const facts: Definition[] = [
    [
      "Intent",
      INTENTS[provenance.intent ?? ""] ?? "As given: the colours are not converted.",
      "How the white of the medium is treated. Colours as measured, such as spot colours, need the absolute intent.",
    ],
  ];
  if (limits === undefined) facts.push(["Ink limit", "None", "Largest sum of all inks. Four full inks are 400 %."]);
  else {
    const limit = (value: number | null) => (value === null ? "None" : `${value}\u00a0%`);
    facts.push(["Ink limit", limit(limits.total), "Largest sum of all inks. Four full inks are 400 %."]);
    if (limits.black !== null) facts.push(["Black limit", limit(limits.black), "Largest amount of the black ink."]);
  }
  const carrier = kind ? (MEDIA[kind] ?? kind[0]!.toUpperCase() + kind.slice(1)) : provenance.reference ? "Reference" : "Not stated";
  facts.push(["Medium", carrier, "What shows or carries the colours."]);
  if (white_lab || white) {
    const luminance = provenance.white_luminance;
    const values = white_lab ? `L*a*b* ${numbers(white_lab)}` : `X Y Z ${numbers(white!)}`;
    const seen = [provenance.illuminant, provenance.observer].filter((text) => text && !text.startsWith("none"));
    facts.push([
      "White",
      values + (luminance === undefined ? "" : `, ${numbers([luminance])}\u00a0cd/m²`),
      `White of the medium or display${seen.length > 0 ? ` (${seen.join(", ")})` : ""}.`,
    ]);
  }
  else facts.push(["White", "Not stated", "White of the medium or display."]);
  const viewing: [string, number | string | undefined, string][] = [
    ["luminance", space?.luminance, "\u00a0cd/m²"],
    ["adapting luminance", space?.adapting_luminance, "\u00a0cd/m²"],
    ["background", space?.background, "\u00a0%"],
    ["surround", space?.surround, ""],
  ];
  const parts = viewing.flatMap(([name, value, unit]) =>
    value === undefined ? [] : [`${name} ${typeof value === "number" ? numbers([value]) : value}${unit}`],
  );
  const reference = space?.reference_white;
  facts.push([
    "Space",
    [options.space, ...(reference === undefined ? [] : [`white ${reference}`]), ...parts].join(", "),
    "Coordinates of the boundary, their reference white and viewing conditions.",
  ]);
  return facts;
}

function numbers(values: number[]): string {
  return values.map((value) => numberText(value, 4)).join(" ");
}
