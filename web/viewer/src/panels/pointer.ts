// The colour of the surface under the pointer; a click or the Enter key keeps it.
import type { Object3D } from "three";
import { embedded } from "../page/embedded.js";
import type { Page } from "../page/page.js";
import { AnswerLines, type PagePlace, type Readout, distanceLines, isNear, levelDistance, surfaceReading } from "./readout.js";

export function connectPointer(page: Page, readout: Readout): void {
  const { canvas, view } = page;
  const distance = new AnswerLines();
  let pointer: PointerEvent | null = null;
  let down: PagePlace | null = null;
  let hovered: PagePlace | null = null;
  const later = (event: PointerEvent) => {
    hovered = event;
    if (pointer === null) {
      requestAnimationFrame(() => {
        if (pointer !== null && pointer.buttons <= 1 && !readout.isKept) read(pointer);
        pointer = null;
      });
    }
    pointer = event;
  };
  canvas.addEventListener("pointermove", later);
  canvas.addEventListener("pointerdown", (event) => {
    down = event;
    later(event);
  });
  canvas.addEventListener("click", (event) => isNear(down, event) && readout.click(event, () => read(event)));
  canvas.addEventListener("keydown", ({ key }) => {
    if (key !== "Enter") return;
    const { left, top, width, height } = canvas.getBoundingClientRect();
    if (readout.isKept) return readout.release();
    const middle = { clientX: left + width / 2, clientY: top + height / 2 };
    // A pointer that rests on the ground has no colour.
    for (const place of [hovered, middle]) if (place !== null && !readout.isKept) readout.click(place, () => read(place));
  });
  canvas.addEventListener("pointerleave", (event) => {
    // A finger that is lifted leaves as well.
    if (event.pointerType !== "mouse") return;
    hovered = pointer = null;
    readout.leave();
  });

  function read({ clientX, clientY }: PagePlace): void {
    const readable = page.readable.flatMap((part) => part.targets());
    const pick = (kind: "solid" | "shell", more: Object3D[] = []) =>
      view.pick(clientX, clientY, [...more, ...page.shown.flatMap(({ layer }) => layer.targets[kind])]);
    const hit = pick("solid", readable) ?? pick("shell");
    const reader = page.readable.find((part) => part.targets().some((mesh) => mesh === hit?.object));
    if (hit === null) return readout.leave();
    if (reader !== undefined) return reader.read(hit);
    const subject = page.shown.find(({ layer }) => hit.object.parent === layer.group)!;
    const { gamut, layer } = subject;
    const other = page.shown.find((each) => each !== subject);
    const reading = surfaceReading(gamut, layer.level!, hit);
    // Distances need equal coordinates. A saved page has no service, and asks the level that it shows.
    const comparable = other?.gamut.options.space === gamut.options.space ? other : undefined;
    if (comparable !== undefined && embedded === null) {
      distance.ask((signal) => distanceLines(comparable.gamut, reading.point, signal));
    } else {
      distance.clear();
      if (comparable !== undefined) reading.lines.push(...levelDistance(comparable.gamut, comparable.layer.level, reading.point));
    }
    readout.show({ ...reading, subject, other, answer: distance });
  }
}
