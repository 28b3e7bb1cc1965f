// The colour of the surface under the pointer.
import type { Object3D } from "three";
import { byId, element } from "../page/elements.js";
import { embedded } from "../page/embedded.js";
import { type Page, type Shown, axisNames } from "../page/page.js";
import { AnswerLines, distanceLines, levelDistance, readout, valuesAt } from "./readout.js";

export function connectPointer(page: Page): void {
  const { canvas, view } = page;
  const distance = new AnswerLines();
  let pointer: PointerEvent | null = null;
  /** What the readout is about. */
  let pointed: Shown[] = [];
  const later = (event: PointerEvent) => {
    if (pointer === null) requestAnimationFrame(read);
    pointer = event;
  };
  canvas.addEventListener("pointermove", later);
  canvas.addEventListener("pointerdown", later);
  page.on("gamuts", () => {
    if (pointed.every(({ gamut }) => page.shown.some((each) => each.gamut === gamut))) return;
    pointed = [];
    byId("readout").hidden = true;
    distance.clear();
  });
  canvas.addEventListener("pointerleave", (event) => {
    // A finger that is lifted leaves as well.
    if (event.pointerType === "mouse") byId("readout").hidden = true;
  });

  function read(): void {
    const event = pointer;
    pointer = null;
    if (event === null || event.buttons > 1) return;
    const readable = page.readable.flatMap((part) => part.targets());
    const pick = (kind: "solid" | "shell", more: Object3D[] = []) =>
      view.pick(event.clientX, event.clientY, [...more, ...page.shown.flatMap(({ layer }) => layer.targets[kind])]);
    const hit = pick("solid", readable) ?? pick("shell");
    const reader = page.readable.find((part) => part.targets().some((mesh) => mesh === hit?.object));
    for (const part of page.readable) if (part !== reader) part.leave();
    pointed = [];
    if (hit !== null && reader !== undefined) {
      distance.clear();
      reader.read(hit);
      return;
    }
    const output = byId("readout");
    output.hidden = hit === null;
    if (hit === null) {
      distance.clear();
      return;
    }
    const shown = page.shown.find(({ layer }) => hit.object.parent === layer.group)!;
    const { gamut, layer } = shown;
    output.replaceChildren(...readout(gamut, axisNames(gamut), layer.level!, hit), distance.element);
    const other = page.shown.find((each) => each !== shown);
    pointed = [shown, ...(other ? [other] : [])];
    // Distances need equal coordinates. A saved page has no service, and asks the level that it shows.
    const point = valuesAt(hit, layer.level!.positions, 3);
    const comparable = other?.gamut.options.space === gamut.options.space ? other : undefined;
    if (comparable !== undefined && embedded === null) {
      distance.ask((signal) => distanceLines(comparable.gamut, point, signal));
    } else {
      distance.clear();
      const text = comparable === undefined ? null : levelDistance(comparable.gamut, comparable.layer.level, point);
      if (text !== null) distance.element.append(element("span", text));
    }
  }
}
