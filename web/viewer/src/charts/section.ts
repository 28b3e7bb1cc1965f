// The section of gamuts by a plane: filled with its colours, with the outlines of all gamuts.
import type { Place } from "../scene/sections.js";
import { Chart, DASHES, type Point, type Size, type Style, type Theme } from "./chart.js";

/** Bounds in the plane: to the right, then upwards. */
export type Frame = [Place, Place];

export interface SectionOutline {
  name: string;
  outlines: Place[][];
  isFilled: boolean;
  colour: string;
  /** Place of the gamut in the list, which chooses the dashes. */
  order: number;
}

export interface SectionOptions {
  size: Size;
  theme: Theme;
  title: string;
  /** Names of the axis to the right and of the one upwards. */
  labels: [string, string];
  frame: Frame;
}

/** Draw a section. The picture has the colours of its own frame, as a data address. */
export function sectionChart(
  { labels: [across, upward], frame: [x, y], ...options }: SectionOptions,
  layers: SectionOutline[],
  picture: { address: string; frame: Frame },
): { svg: string; placeAt: (x: number, y: number) => Place | null } {
  const style = ({ colour, order }: SectionOutline): Style => ({ stroke: colour, width: 2, dash: DASHES[order]! });
  const legend = layers.map((layer) => ({ name: layer.name, style: style(layer) }));
  const axes = { x: { range: x, label: across }, y: { range: y, label: upward } };
  const chart = new Chart({ ...options, ...axes, isEqual: true, legend, legendAt: "below" });
  const path = (outlines: Place[][]) => outlines.map((outline) => chart.path(outline)).join("");
  const filled = layers.filter(({ isFilled }) => isFilled).map(({ outlines }) => path(outlines));
  for (const each of filled) chart.image(picture.address, ...picture.frame, each);
  for (const layer of layers.toReversed()) chart.draw(path(layer.outlines), { ...style(layer), rim: true });
  const [left, bottom] = [chart.x(0), chart.y(0)];
  const placeAt = (pixel: number, row: number): Place | null => {
    const place: Point = [(pixel - left) / (chart.x(1) - left), (row - bottom) / (chart.y(1) - bottom)];
    const isWithin = ([low, high]: Place, value: number) => value >= low && value <= high;
    return isWithin(x, place[0]) && isWithin(y, place[1]) ? [...place] : null;
  };
  return { svg: chart.svg(), placeAt };
}
