// The keyboard in the view, and the buttons of the points of view.
import { Vector3 } from "three";
import { orientation } from "../scene/layer.js";
import { STYLE_NAMES, type Page, axisNames } from "./page.js";
import { byId, element } from "./elements.js";
import type { Style } from "../scene/layer.js";

const TURN = Math.PI / 36;
const ENLARGEMENT = 1.15;

export function connectKeys(page: Page): void {
  const { view, canvas } = page;
  const help = byId<HTMLDialogElement>("keys");
  byId("help").addEventListener("click", () => help.showModal());
  document.querySelector('[data-view="home"]')!.addEventListener("click", () => view.home());
  page.on("gamuts", () => fillViews(page));
  const actions: Record<string, () => void> = {
    ArrowLeft: () => view.turn(-TURN, 0),
    ArrowRight: () => view.turn(TURN, 0),
    ArrowUp: () => view.turn(0, -TURN),
    ArrowDown: () => view.turn(0, TURN),
    "+": () => view.enlarge(ENLARGEMENT),
    "=": () => view.enlarge(ENLARGEMENT),
    "-": () => view.enlarge(1 / ENLARGEMENT),
    "0": () => view.home(),
    "[": () => page.setTriangles(page.triangles / 2),
    "]": () => page.setTriangles(page.triangles * 2),
    p: () => {
      const select = byId<HTMLSelectElement>("projection");
      select.value = select.value === "perspective" ? "orthographic" : "perspective";
      select.dispatchEvent(new Event("change"));
    },
    w: () => {
      const styles = Object.keys(STYLE_NAMES) as Style[];
      page.setStyle("a", styles[(styles.indexOf(page.styles.a) + 1) % styles.length]!);
    },
    a: () => byId("axes").click(),
    "?": () => help.showModal(),
  };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const direction = axisViews(page)[Number(event.key) - 1]?.[1];
    const name = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const action = direction === undefined ? actions[name] : () => view.lookAlong(direction);
    if (action === undefined) return;
    event.preventDefault();
    action();
  });
}

function fillViews(page: Page): void {
  const toolbar = byId("views");
  for (const old of toolbar.querySelectorAll("[data-axis]")) old.remove();
  axisViews(page).forEach(([name, direction], place) => {
    const button = element("button", name, { type: "button", title: `From ${name} (${place + 1})` });
    button.dataset["axis"] = name;
    button.addEventListener("click", () => page.view.lookAlong(direction));
    toolbar.append(button);
  });
}

/** Views along the axes: from above, below, and from both ends of the other two. */
function axisViews(page: Page): [string, Vector3][] {
  const first = page.shown[0];
  if (first === undefined) return [];
  const names = axisNames(first.gamut);
  const turn = orientation(names);
  return names.flatMap((name, axis) =>
    [1, -1].map((sign): [string, Vector3] => {
      const direction = new Vector3().setComponent(axis, sign).applyMatrix4(turn);
      // Not exactly along the camera's up direction, which would leave the turn open.
      if (Math.abs(direction.y) > 0.5) direction.z += 1e-3;
      return [`${sign > 0 ? "+" : "−"}${name}`, direction];
    }),
  );
}
