// Charts on the page, and as files.
import { save } from "../page/elements.js";
import type { Theme } from "./chart.js";

/** The colours of the page, or of a part with another ground. */
export function pageTheme(part: Element, ground = "--box"): Theme {
  const style = getComputedStyle(part);
  const probe = document.createElement("span");
  part.append(probe);
  // A variable may be a function of the colour scheme, so it is resolved as a colour.
  const colour = (name: string) => {
    probe.style.color = `var(${name})`;
    return getComputedStyle(probe).color;
  };
  const theme = { text: style.color, soft: colour("--soft"), line: colour("--line"), back: colour(ground) };
  probe.remove();
  return theme;
}

/** Show a chart in place of what a box has. */
export function showChart(box: Element, svg: string): void {
  const { documentElement } = new DOMParser().parseFromString(svg, "image/svg+xml");
  box.replaceChildren(document.importNode(documentElement, true));
}

/** Draw a chart for the width of a box, and again when it changes; returns what draws it again. */
export function fitChart(box: HTMLElement, draw: (width: number) => string): () => void {
  let shown = 0;
  const redraw = () => {
    shown = Math.floor(box.clientWidth);
    if (shown > 0) showChart(box, draw(shown));
  };
  new ResizeObserver(() => Math.floor(box.clientWidth) !== shown && redraw()).observe(box);
  return redraw;
}

/** A chart as PNG, larger than it is shown by a factor. */
export async function chartPng(svg: string, factor: number): Promise<Blob> {
  const picture = new Image();
  picture.src = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
  try {
    await picture.decode();
    const canvas = new OffscreenCanvas(Math.round(factor * picture.width), Math.round(factor * picture.height));
    canvas.getContext("2d")!.drawImage(picture, 0, 0, canvas.width, canvas.height);
    return await canvas.convertToBlob();
  } finally {
    URL.revokeObjectURL(picture.src);
  }
}

/** Save a chart as a file: as it is drawn, or as PNG. */
export async function saveChart(svg: string, name: string, format: "svg" | "png", factor = 2): Promise<void> {
  if (format === "svg") save(new Blob([svg], { type: "image/svg+xml" }), `${name}.svg`);
  else save(await chartPng(svg, factor), `${name}.png`);
}
