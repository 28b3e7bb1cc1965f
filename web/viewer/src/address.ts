// The state of the page in its address, behind the number sign: the server never sees it.
import { embedded } from "./embedded.js";
import type { Projection } from "./scene.js";
import type { SliceState } from "./slice_panel.js";

const DEFAULT_TRIANGLES = 10_000;

export interface PageState {
  /** Ids or slugs. */
  gamuts: { a: string | null; b: string | null };
  triangles: number;
  styles: { a: string | null; b: string | null };
  projection: Projection;
  axes: boolean;
  slice: SliceState;
  /** As `View.place`; null for the start view. */
  camera: number[] | null;
}

export function readState(): PageState {
  const given = new URLSearchParams(location.hash.slice(1));
  const gamut = /\/v1\/gamuts\/([^/]+)$/.exec(location.pathname)?.[1];
  const triangles = Number(given.get("triangles"));
  return {
    gamuts: { a: embedded?.gamut.id ?? given.get("a") ?? (gamut === undefined ? null : decodeURIComponent(gamut)), b: embedded ? null : given.get("b") },
    triangles: Number.isInteger(triangles) && triangles >= 4 ? triangles : DEFAULT_TRIANGLES,
    styles: { a: given.get("style-a"), b: given.get("style-b") },
    projection: given.get("projection") === "orthographic" ? "orthographic" : "perspective",
    axes: given.get("axes") !== "off",
    slice: sliceState(given),
    camera: given.get("camera")?.split(",").map(Number) ?? null,
  };
}

function sliceState(given: URLSearchParams): SliceState {
  const state: SliceState = { kind: "off", lightness: null, hue: 40 };
  if (given.has("rings")) state.kind = "rings";
  for (const kind of ["lightness", "hue"] as const) {
    const text = given.get(kind);
    if (text === null || !Number.isFinite(Number(text))) continue;
    state.kind = kind;
    state[kind] = Number(text);
  }
  return state;
}

function sliceEntries({ kind, lightness, hue }: SliceState): [string, string | null][] {
  if (kind === "off") return [];
  return [[kind, kind === "rings" ? "on" : String(kind === "hue" ? hue : lightness)]];
}

export function writeState(state: PageState): void {
  const entries: [string, string | null][] = [
    ["a", state.gamuts.a],
    ["b", state.gamuts.b],
    ["triangles", String(state.triangles)],
    ["style-a", state.styles.a],
    ["style-b", state.styles.b],
    ["projection", state.projection],
    ["axes", state.axes ? null : "off"],
    ...sliceEntries(state.slice),
    ["camera", state.camera?.join(",") ?? null],
  ];
  const given = entries.filter((entry): entry is [string, string] => entry[1] !== null);
  const text = given.map(([name, value]) => `${name}=${encodeURIComponent(value).replaceAll("%2C", ",")}`);
  // A page in the `srcdoc` of a frame, as in a notebook, has no address of its own.
  if (location.protocol !== "about:") history.replaceState(null, "", `#${text.join("&")}`);
}

/** The address that restores the view. */
export function pageAddress(): string {
  return location.href;
}
