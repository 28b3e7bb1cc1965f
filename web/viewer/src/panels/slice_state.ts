// What is beside the view: a section by a lightness or a hue, or a diagram; and how addresses state it.
import type { Half } from "../scene/cut.js";
import { type DiagramKind, isDiagram } from "./diagrams.js";

const PLANES = ["lightness", "hue"] as const;
export type PlaneKind = (typeof PLANES)[number];

export interface SliceState {
  kind: "off" | PlaneKind | DiagramKind;
  /** Null until a gamut tells where its middle is. */
  lightness: number | null;
  hue: number;
  half: Half;
}

export function isPlane(kind: string): kind is PlaneKind {
  return (PLANES as readonly string[]).includes(kind);
}

export function readState(state: SliceState, given: URLSearchParams): void {
  const named = given.get("diagram");
  if (named !== null && isDiagram(named)) state.kind = named;
  for (const kind of PLANES) {
    const text = given.get(kind);
    if (text === null || !Number.isFinite(Number(text))) continue;
    state.kind = kind;
    state[kind] = Number(text);
  }
  const half = given.get("cut") as Half | null;
  if (half !== null && ["above", "below", "none"].includes(half)) state.half = half;
}

export function entries({ kind, lightness, hue, half }: SliceState): [string, string | null][] {
  if (kind === "off") return [];
  if (isDiagram(kind)) return [["diagram", kind]];
  return [[kind, String(kind === "hue" ? hue : lightness)], ["cut", half === "front" ? null : half]];
}
