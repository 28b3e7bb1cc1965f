// How everything is displayed: projection, axes, and the colour scheme of the page.
import { SCREEN } from "../colours/colours.js";
import { byId } from "../page/elements.js";
import type { Page } from "../page/page.js";
import { surfaceUniforms } from "../scene/materials.js";
import type { Projection } from "../scene/scene.js";

export function connectDisplay(page: Page): void {
  const projection = byId<HTMLSelectElement>("projection");
  const axes = byId<HTMLInputElement>("axes");
  const mark = byId<HTMLInputElement>("mark");
  const name = SCREEN === "srgb" ? "sRGB" : "Display P3";
  mark.parentElement!.title = `This screen shows the colours of ${name}. Stripes are on the others: they look less colourful here than they are.`;
  const setMarks = () => {
    surfaceUniforms.marked.value = mark.checked;
    page.view.draw();
  };
  page.address.add({
    read: (given) => {
      mark.checked = given.get("mark") === "on";
      setMarks();
      projection.value = given.get("projection") === "orthographic" ? "orthographic" : "perspective";
      axes.checked = given.get("axes") !== "off";
      page.view.setProjection(projection.value as Projection);
      page.hasAxes = axes.checked;
      setTheme(given.get("theme") ?? undefined);
    },
    write: () => [
      ["projection", page.view.projection],
      ["axes", page.hasAxes ? null : "off"],
      ["mark", mark.checked ? "on" : null],
      ["theme", document.documentElement.dataset["theme"] ?? null],
    ],
  });
  projection.addEventListener("change", () => page.view.setProjection(projection.value as Projection));
  axes.addEventListener("change", () => page.setAxes(axes.checked));
  mark.addEventListener("change", () => {
    setMarks();
    page.address.save();
  });
  byId("theme").addEventListener("click", () => {
    const next = { undefined: "light", light: "dark", dark: undefined }[String(document.documentElement.dataset["theme"])];
    setTheme(next);
    page.emit("theme");
  });
}

/** Light, dark, or as the system has it. */
function setTheme(theme: string | undefined): void {
  const { dataset } = document.documentElement;
  if (theme === "light" || theme === "dark") dataset["theme"] = theme;
  else delete dataset["theme"];
  const button = byId("theme");
  button.textContent = { light: "Light", dark: "Dark" }[dataset["theme"] ?? ""] ?? "Auto";
  button.setAttribute("aria-label", `Colour scheme: ${button.textContent}`);
}
