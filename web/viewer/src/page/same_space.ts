// Gamuts of different spaces are never drawn in one set of axes.
import { type Gamut, ProblemError } from "../service/api.js";

/**
 * Parameters that change what coordinates mean. Absolute spaces have the same coordinates whatever the
 * luminance of the white, as in comparisons of the service.
 */
const PARAMETERS = ["reference_white", "adapting_luminance", "background", "surround"] as const;

export function inSameSpace(one: Gamut, two: Gamut): boolean {
  const [a, b] = [one, two].map(({ provenance }) => provenance.colour_space);
  return (
    one.options.space === two.options.space &&
    PARAMETERS.every((name) => a?.[name] === undefined || b?.[name] === undefined || a[name] === b[name])
  );
}

/** Options that build a reference in the space of a gamut. */
export function optionsOfSpace({ options, provenance }: Gamut): Record<string, string> {
  // Numbers of the options are exact, those of the provenance are for people.
  const stated = { ...provenance.colour_space, ...options } as Record<string, unknown>;
  const isPlain = options.space === "CIELAB" && stated["reference_white"] === "D50";
  const chosen = PARAMETERS.filter((name) => !isPlain && stated[name] !== undefined);
  return Object.fromEntries([["space", options.space], ...chosen.map((name) => [name, String(stated[name])])]);
}

/** A space in words, with the parameters in which it differs from that of another gamut. */
function spaceText(gamut: Gamut, other: Gamut): string {
  const [own, others] = [gamut, other].map(({ provenance }) => provenance.colour_space);
  const differing = PARAMETERS.filter((name) => gamut.options.space === other.options.space && own?.[name] !== others?.[name]);
  const parts = differing.map((name) => `${name.replace("_", " ")} ${own?.[name] ?? "not stated"}`);
  return [gamut.options.space, ...parts].join(", ");
}

/** Why a gamut is not shown beside the first one, and what to do. */
export function differentSpaces(gamut: Gamut, first: Gamut): ProblemError {
  const [own, wanted] = [spaceText(gamut, first), spaceText(first, gamut)];
  return new ProblemError({
    title: "Different spaces",
    detail: `${gamut.name} is in ${own}. ${first.name} is in ${wanted}. Their coordinates do not fit one set of axes.`,
    remedy: `Build ${gamut.name} again with the space ${wanted}, or remove ${first.name}.`,
    code: "",
    status: 0,
    where: null,
  });
}
