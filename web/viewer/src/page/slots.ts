// Places in the list of gamuts, and a colour for each: lines in the view, outlines, and the mark at the name.

/** Places of gamuts, in the order of the list. The first one is the subject of all questions. */
export const SLOTS = ["a", "b", "c", "d", "e", "f"] as const;
export type Slot = (typeof SLOTS)[number];

/**
 * The palette of Okabe and Ito (Color Universal Design, 2008), which readers with any colour vision
 * tell apart. Each slot has a colour for light pages and one for dark pages.
 */
const TINTS: Record<Slot, [light: string, dark: string]> = {
  a: ["#000000", "#ffffff"],
  b: ["#0072b2", "#56b4e9"],
  c: ["#d55e00", "#e69f00"],
  d: ["#009e73", "#009e73"],
  e: ["#cc79a7", "#cc79a7"],
  f: ["#e69f00", "#f0e442"],
};

export function tintOf(slot: Slot, isDark: boolean): string {
  return TINTS[slot][isDark ? 1 : 0];
}
