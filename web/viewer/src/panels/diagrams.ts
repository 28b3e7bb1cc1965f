// Chromaticity diagrams of the shown gamuts beside the view.
import type { Point } from "../charts/chart.js";
import { chromaticityChart } from "../charts/chromaticity.js";
import type { Page, Shown } from "../page/page.js";
import { tintOf } from "../page/slots.js";
import type { SectionDraw } from "./section_figure.js";

/** Diagrams with their names, as the page offers and the address keeps them. */
export const DIAGRAMS = {
  xy: "Chromaticity diagram x, y",
  uv: "Chromaticity diagram u′, v′",
} as const;
export type DiagramKind = keyof typeof DIAGRAMS;

export function isDiagram(kind: string): kind is DiagramKind {
  return kind in DIAGRAMS;
}

/** What draws a diagram, or a sentence that says why there is none. */
export function diagram(kind: DiagramKind, shown: Shown[], isDark: boolean): SectionDraw | string {
  const gamuts = shown.flatMap(({ slot, gamut }) => {
    const corners = gamut.chromaticity?.corners;
    return corners ? [{ name: gamut.name, corners: corners as Point[], colour: tintOf(slot, isDark) }] : [];
  });
  if (gamuts.length === 0) return "The chromaticities of this gamut are not known: its colours are relative to no stated white.";
  return (options) => ({ svg: chromaticityChart(gamuts, { diagram: kind, ...options }) });
}

/** What is drawn, in words. */
export function diagramName(kind: DiagramKind, { shown }: Page): string {
  return `${DIAGRAMS[kind]}: ${shown.map(({ gamut }) => gamut.name).join(" and ")}`;
}
