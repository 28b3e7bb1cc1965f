// The measured patches of the first gamut's file, as points in the view.
import { BufferGeometry, Float32BufferAttribute, Group, type Material, Points, PointsMaterial } from "three";
import { SCREEN } from "../colours/colours.js";
import { gamutSpace, mediaRelative } from "../colours/spaces.js";
import { byId } from "../page/elements.js";
import { Latest } from "../page/latest.js";
import { type Page, axisNames } from "../page/page.js";
import { orientation } from "../scene/layer.js";
import { type Gamut, ProblemError } from "../service/api.js";
import { findExample } from "../service/examples.js";
import { type Position, checkTable, positionsOf } from "../service/queries.js";

interface Patches {
  colours: number[][];
  position: Position[];
}

export class Marks {
  private readonly box = byId<HTMLInputElement>("mark-patches");
  private readonly asking = new Latest();
  private group: Group | null = null;
  private gamut: Gamut | null = null;

  constructor(private readonly page: Page) {
    this.box.addEventListener("change", () => void this.refresh());
    page.on(["slots"], () => {
      const gamut = page.at("a")?.gamut ?? null;
      if (gamut?.id === this.gamut?.id) return;
      this.gamut = gamut;
      void this.offerPatches(gamut);
      void this.refresh();
    });
    page.on(["theme"], () => void this.refresh());
  }

  /** Patches are those of a file that the page has, or of the file of an example of a device. */
  private async offerPatches(gamut: Gamut | null): Promise<void> {
    const { box } = this;
    // profiles, pictures and meshes have no table of patches; profiles may only carry one
    const isTable = gamut?.provenance.patches !== undefined && gamut.options.source === undefined;
    box.disabled = gamut === null || !isTable || !this.page.files.has(gamut.id);
    if (gamut === null || !box.disabled || gamut.channels.length === 0) return;
    const example = await findExample(this.page.at("a")?.key ?? "");
    if (gamut === this.gamut && example?.file != null) {
      box.disabled = false;
      void this.refresh();
    }
  }

  private async refresh(): Promise<void> {
    this.asking.end();
    this.remove();
    const { box, gamut, page } = this;
    if (gamut === null || !box.checked || box.disabled) return;
    await this.asking.ask(
      (signal) => this.patches(gamut, signal),
      ({ colours, position }) => {
        const group = new Group();
        group.add(...this.points(gamut, colours, position));
        for (const part of group.children) Object.assign(part, { renderOrder: 3, frustumCulled: false });
        group.applyMatrix4(orientation(axisNames(gamut)));
        page.view.scene.add(group);
        this.group = group;
        this.note(patchesText(position));
        page.view.draw();
      },
      (error) => {
        box.checked = false;
        this.note(error instanceof ProblemError ? error.problem.detail : String(error));
      },
    );
  }

  private async patches(gamut: Gamut, signal: AbortSignal): Promise<Patches> {
    const reading = { space: "", columns: "", table_scale: "", edge_width: "" };
    const file = this.page.files.get(gamut.id) ?? (await this.page.sourceOf("a"))!;
    const patches = await checkTable(gamut, file, reading, signal);
    const colours = relativeTo(gamut, patches.colours);
    const { position } = colours === patches.colours ? patches : await positionsOf(gamut, colours, signal);
    return { colours, position };
  }

  /** All patches in their colours, and larger points behind those outside. */
  private points(gamut: Gamut, colours: number[][], position: Position[]): Points[] {
    const outside = colours.filter((_, row) => position[row] === "outside");
    const frame = new PointsMaterial({ color: getComputedStyle(byId("problem")).borderTopColor, size: 9, sizeAttenuation: false });
    const geometry = geometryOf(colours);
    const linear = gamutSpace(gamut).linear(Float32Array.from(colours.flat()), SCREEN);
    geometry.setAttribute("color", new Float32BufferAttribute(linear, 3));
    const material = new PointsMaterial({ vertexColors: true, size: 5, sizeAttenuation: false });
    return [new Points(geometryOf(outside), frame), new Points(geometry, material)];
  }

  private note(text: string): void {
    byId("marks-note").textContent = text;
  }

  private remove(): void {
    this.note("");
    if (this.group === null) return;
    for (const part of this.group.children as Points[]) {
      part.geometry.dispose();
      (part.material as Material).dispose();
    }
    this.group.removeFromParent();
    this.group = null;
    this.page.view.draw();
  }
}

function geometryOf(colours: number[][]): BufferGeometry {
  return new BufferGeometry().setAttribute("position", new Float32BufferAttribute(colours.flat(), 3));
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
