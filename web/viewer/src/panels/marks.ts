// Points and curves of the first gamut in the view: its cusps, the neutral axis, and the file's patches.
import {
  BufferGeometry,
  Float32BufferAttribute,
  Group,
  Line,
  LineBasicMaterial,
  LineLoop,
  type Material,
  Points,
  PointsMaterial,
} from "three";
import { SCREEN } from "../colours/colours.js";
import { isRgb } from "../colours/device_values.js";
import { gamutSpace, mediaRelative } from "../colours/spaces.js";
import { byId } from "../page/elements.js";
import { Latest } from "../page/latest.js";
import { type Page, axisNames } from "../page/page.js";
import { orientation } from "../scene/layer.js";
import { type Gamut, ProblemError } from "../service/api.js";
import { findExample } from "../service/examples.js";
import { type Position, checkTable, cusps, deviceColours, positionsOf } from "../service/queries.js";

const KINDS = ["cusps", "neutral", "patches"] as const;
type Kind = (typeof KINDS)[number];

/** Hues of the curve of cusps: one in 2°, about the width of the pointer on a large gamut. */
const HUES = 180;
/** Colours of the neutral axis. */
const STEPS = 33;

export class Marks {
  private readonly groups = new Map<Kind, Group>();
  private readonly asking = Object.fromEntries(KINDS.map((kind) => [kind, new Latest()])) as Record<Kind, Latest>;
  private readonly notes = new Map<Kind, string>();
  private gamut: Gamut | null = null;

  constructor(private readonly page: Page) {
    page.address.add({
      read: (given) => {
        const marked = given.get("marks")?.split(",") ?? [];
        for (const kind of KINDS) this.box(kind).checked = marked.includes(kind);
      },
      write: () => [["marks", KINDS.filter((kind) => this.box(kind).checked && kind !== "patches").join(",") || null]],
    });
    for (const kind of KINDS) {
      this.box(kind).addEventListener("change", () => {
        page.address.save();
        void this.refresh(kind);
      });
    }
    page.on("gamuts", () => {
      const gamut = page.at("a")?.gamut ?? null;
      if (gamut?.id === this.gamut?.id) return;
      this.gamut = gamut;
      this.box("neutral").disabled = gamut !== null && neutralValues(gamut.channels) === null;
      void this.offerPatches(gamut);
      for (const kind of KINDS) void this.refresh(kind);
    });
    page.on("theme", () => KINDS.forEach((kind) => void this.refresh(kind)));
  }

  /** Patches are those of a file that the page has, or of the file of an example of a device. */
  private async offerPatches(gamut: Gamut | null): Promise<void> {
    const box = this.box("patches");
    box.disabled = gamut === null || !this.page.files.has(gamut.id);
    if (gamut === null || !box.disabled || gamut.channels.length === 0) return;
    const example = await findExample(this.page.at("a")?.key ?? "");
    if (gamut === this.gamut && example?.file != null) {
      box.disabled = false;
      void this.refresh("patches");
    }
  }

  private box(kind: Kind): HTMLInputElement {
    return byId<HTMLInputElement>(`mark-${kind}`);
  }

  private async refresh(kind: Kind): Promise<void> {
    const asking = this.asking[kind];
    asking.end();
    this.remove(kind);
    const { gamut, page } = this;
    const box = this.box(kind);
    if (gamut === null || !box.checked || box.disabled) return;
    await asking.ask(
      (signal) => this.colours(kind, gamut, signal),
      ({ colours, position }) => {
        const group = new Group();
        group.add(...this.parts(kind, gamut, colours, position));
        for (const part of group.children) {
          part.renderOrder = 3;
          part.frustumCulled = false;
        }
        group.applyMatrix4(orientation(axisNames(gamut)));
        page.view.scene.add(group);
        this.groups.set(kind, group);
        if (kind === "patches") this.note(kind, patchesText(position));
        page.view.draw();
      },
      (error) => {
        box.checked = false;
        this.note(kind, error instanceof ProblemError ? error.problem.detail : String(error));
      },
    );
  }

  /** The colours of a kind of marks; patches have positions as well. */
  private async colours(kind: Kind, gamut: Gamut, signal: AbortSignal): Promise<{ colours: number[][]; position: Position[] }> {
    if (kind === "cusps") return { colours: await cusps(gamut, HUES, signal), position: [] };
    if (kind === "neutral") return { colours: await deviceColours(gamut, neutralValues(gamut.channels)!, signal), position: [] };
    const reading = { space: "", columns: "", table_scale: "", edge_width: "" };
    const file = this.page.files.get(gamut.id) ?? (await this.page.sourceOf("a"))!;
    const patches = await checkTable(gamut, file, reading, signal);
    const colours = relativeTo(gamut, patches.colours);
    const { position } = colours === patches.colours ? patches : await positionsOf(gamut, colours, signal);
    return { colours, position };
  }

  private parts(kind: Kind, gamut: Gamut, colours: number[][], position: Position[]): (Line | Points)[] {
    const line = () => new LineBasicMaterial({ color: getComputedStyle(document.body).color, depthTest: false });
    if (kind === "cusps") return [new LineLoop(geometryOf(colours), line())];
    if (kind === "neutral") return [new Line(geometryOf(colours), line()), this.points(gamut, colours, 7)];
    const outside = colours.filter((_, row) => position[row] === "outside");
    const frame = new PointsMaterial({ color: getComputedStyle(byId("problem")).borderTopColor, size: 9, sizeAttenuation: false });
    return [new Points(geometryOf(outside), frame), this.points(gamut, colours, 5)];
  }

  private points(gamut: Gamut, colours: number[][], size: number): Points {
    const geometry = geometryOf(colours);
    const linear = gamutSpace(gamut).linear(Float32Array.from(colours.flat()), SCREEN);
    geometry.setAttribute("color", new Float32BufferAttribute(linear, 3));
    return new Points(geometry, new PointsMaterial({ vertexColors: true, size, sizeAttenuation: false }));
  }

  /** Say something of a kind of marks; nothing clears it. */
  private note(kind: Kind, text = ""): void {
    this.notes.set(kind, text);
    byId("marks-note").textContent = KINDS.map((each) => this.notes.get(each) ?? "").join(" ").trim();
  }

  private remove(kind: Kind): void {
    this.note(kind);
    const group = this.groups.get(kind);
    if (group === undefined) return;
    for (const part of group.children as (Line | Points)[]) {
      part.geometry.dispose();
      (part.material as Material).dispose();
    }
    group.removeFromParent();
    this.groups.delete(kind);
    this.page.view.draw();
  }
}

function geometryOf(colours: number[][]): BufferGeometry {
  return new BufferGeometry().setAttribute("position", new Float32BufferAttribute(colours.flat(), 3));
}

/** Device values along the neutral axis: equal red, green and blue, or black alone; null without either. */
export function neutralValues(channels: string[]): number[][] | null {
  const black = channels.findIndex((name) => /^(k|black|gr[ae]y)$/i.test(name));
  const rgb = channels.length === 3 && isRgb(channels);
  if (!rgb && black < 0) return null;
  return Array.from({ length: STEPS }, (_, step) =>
    channels.map((_name, place) => (rgb || place === black ? step / (STEPS - 1) : 0)),
  );
}

/** Colours as a file has them, relative to the paper if the gamut is. */
function relativeTo(gamut: Gamut, colours: number[][]): number[][] {
  const { intent, medium, white_lab: paper } = gamut.provenance;
  if (intent !== "relative" || medium !== "reflective" || !paper || gamut.options.space !== "CIELAB") return colours;
  const relative = mediaRelative(Float32Array.from(colours.flat()), paper);
  return colours.map((_, row) => [...relative.subarray(3 * row, 3 * row + 3)]);
}

function patchesText(position: Position[]): string {
  const outside = position.filter((where) => where === "outside").length;
  return `${position.length.toLocaleString("en")} patches of the file, ${outside.toLocaleString("en")} of them outside of this gamut.`;
}
