// The axes in a corner of the view: they turn with it, and a click on an end looks along the axis.
import type { Vector3 } from "three";
import { byId } from "./elements.js";
import type { Page } from "./page.js";

export interface AxisView {
  name: string;
  /** The side from which the gamut is seen. */
  side: string;
  direction: Vector3;
}

const NAMESPACE = "http://www.w3.org/2000/svg";
/** Length of an axis, and radii of its upper and lower end, in a square of 100. */
const LENGTH = 36;
const RADII = [12, 8] as const;

/** Draw the ends of axes. The button behind them is the start view. */
export function connectGizmo(page: Page, views: () => AxisView[]): void {
  const picture = byId("gizmo").querySelector("svg")!;
  let shown = "";
  let ends: { mark: SVGGElement; line: SVGLineElement | null; direction: Vector3 }[] = [];
  const fill = () => {
    const axes = views();
    const names = axes.map(({ name }) => name).join();
    if (names === shown) return;
    shown = names;
    ends = axes.map(({ name, side, direction }, place) => {
      const mark = document.createElementNS(NAMESPACE, "g");
      const isUpper = place % 2 === 0;
      mark.dataset["axis"] = name;
      mark.append(
        svg("title", {}, `From ${side} (${name}), key ${place + 1}`),
        svg("circle", { r: RADII[isUpper ? 0 : 1] }),
        ...(isUpper ? [svg("text", { dy: "0.35em" }, name.slice(1))] : []),
      );
      mark.addEventListener("click", () => page.view.lookAlong(direction));
      return { mark, line: isUpper ? svg("line", { x1: 50, y1: 50 }) : null, direction };
    });
    draw();
  };
  const draw = () => {
    const { camera } = page.view;
    camera.updateMatrixWorld();
    const places = ends.map((end) => ({ ...end, at: end.direction.clone().normalize().transformDirection(camera.matrixWorldInverse) }));
    places.sort((one, other) => one.at.z - other.at.z);
    for (const { mark, line, at } of places) {
      const [x, y] = [50 + LENGTH * at.x, 50 - LENGTH * at.y];
      mark.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)})`);
      line?.setAttribute("x2", x.toFixed(1));
      line?.setAttribute("y2", y.toFixed(1));
    }
    picture.replaceChildren(...places.flatMap(({ mark, line }) => (line === null ? [mark] : [line, mark])));
  };
  byId("home").addEventListener("click", () => page.view.home());
  page.on(["slots"], fill);
  page.view.onDraw.push(draw);
}

function svg<Name extends keyof SVGElementTagNameMap>(name: Name, attributes: Record<string, string | number>, text = ""): SVGElementTagNameMap[Name] {
  const made = document.createElementNS(NAMESPACE, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
  made.textContent = text;
  return made;
}
