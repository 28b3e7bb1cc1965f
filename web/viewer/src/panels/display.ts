// How everything is displayed: projection, axes, and the colour scheme of the page.
import { byId } from "../page/elements.js";
import type { Page } from "../page/page.js";
import type { Projection } from "../scene/scene.js";

export function connectDisplay(page: Page): void {
  const projection = byId<HTMLSelectElement>("projection");
  const axes = byId<HTMLInputElement>("axes");
  const edges = byId<HTMLInputElement>("edges");
  page.address.add({
    read: (given) => {
      projection.value = given.get("projection") === "orthographic" ? "orthographic" : "perspective";
      axes.checked = given.get("axes") !== "off";
      page.view.setProjection(projection.value as Projection);
      page.hasAxes = axes.checked;
      page.hasEdges ||= given.get("edges") === "on";
      setTheme(given.get("theme") ?? undefined);
    },
    write: () => [
      ["projection", page.view.projection],
      ["axes", page.hasAxes ? null : "off"],
      ["edges", page.hasEdges ? "on" : null],
      ["theme", document.documentElement.dataset["theme"] ?? null],
    ],
  });
  projection.addEventListener("change", () => page.view.setProjection(projection.value as Projection));
  axes.addEventListener("change", () => page.setAxes(axes.checked));
  edges.addEventListener("change", () => page.setEdges(edges.checked));
  page.on(["slots", "looks"], () => (edges.checked = page.hasEdges));
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
