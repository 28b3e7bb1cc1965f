// The keyboard in the view, and the views along the axes.
import { Vector3 } from "three";
import { stepSection } from "../panels/plane_handle.js";
import { orientation } from "../scene/layer.js";
import { type Page, SHELL_OPACITY, axisNames } from "./page.js";
import { byId } from "./elements.js";
import { type AxisView, connectGizmo } from "./gizmo.js";

const TURN = Math.PI / 36;
const ENLARGEMENT = 1.15;

export function connectKeys(page: Page): void {
  const { view, canvas } = page;
  const help = byId<HTMLDialogElement>("keys");
  byId("help").addEventListener("click", () => help.showModal());
  connectGizmo(page, () => axisViews(page));
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
    PageUp: () => stepSection(5),
    PageDown: () => stepSection(-5),
    p: () => {
      const select = byId<HTMLSelectElement>("projection");
      select.value = select.value === "perspective" ? "orthographic" : "perspective";
      select.dispatchEvent(new Event("change"));
    },
    w: () => page.setOpacity("a", page.lookOf("a").opacity < 1 ? 1 : SHELL_OPACITY),
    a: () => byId("axes").click(),
    "?": () => help.showModal(),
  };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const direction = axisViews(page)[Number(event.key) - 1]?.direction;
    const name = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const action = direction === undefined ? actions[name] : () => view.lookAlong(direction);
    if (action === undefined) return;
    event.preventDefault();
    action();
  });
}

/** Sides of the scene at the ends of its axes: the upper end, then the lower one. */
const SIDES = [["the right", "the left"], ["above", "below"], ["the front", "the back"]] as const;

/** Views along the axes: from both ends of each coordinate. */
function axisViews(page: Page): AxisView[] {
  const first = page.shown[0];
  if (first === undefined) return [];
  const names = axisNames(first.gamut);
  const turn = orientation(names);
  return names.flatMap((name, axis) =>
    [1, -1].map((sign): AxisView => {
      const direction = new Vector3().setComponent(axis, sign).applyMatrix4(turn);
      const place = direction.toArray().findIndex((value) => value !== 0);
      const side = SIDES[place]![direction.getComponent(place) > 0 ? 0 : 1]!;
      // Not exactly along the camera's up direction, which would leave the turn open.
      if (place === 1) direction.z += 1e-3;
      return { name: `${sign > 0 ? "+" : "−"}${name}`, side, direction };
    }),
  );
}
