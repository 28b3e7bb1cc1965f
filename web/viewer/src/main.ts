// The viewer: what the controls of the page do.
import { AmbientLight, Box3, type Group, Vector3 } from "three";
import {
  type Entry,
  type Gamut,
  ProblemError,
  type Progress,
  address,
  authorization,
  build,
  cancelJob,
  describe,
  request,
  useKey,
} from "./api.js";
import { type PageState, pageAddress, readState, writeState } from "./address.js";
import { appearanceOf } from "./appearance.js";
import { axes, axesGrid, disposeAxes } from "./axes.js";
import { BuildOptions } from "./build_options.js";
import { Chooser } from "./chooser.js";
import { ColourList } from "./colour_list.js";
import { ComparisonPanel } from "./comparison_panel.js";
import { byId, element, problemElements, save } from "./elements.js";
import { embedded, workerAddress } from "./embedded.js";
import { Layer, Materials, type Style, headLight, orientation } from "./layer.js";
import { countAt, facts, limitNote, placeOf } from "./levels.js";
import { AnswerLines, distanceLines, readout, valuesAt } from "./readout.js";
import { type Projection, View } from "./scene.js";
import { SlicePanel } from "./slice_panel.js";

type Role = "a" | "b";
const ROLES = ["a", "b"] as const;

interface Shown {
  key: string;
  gamut: Gamut;
  layer: Layer;
}

const STYLES: Style[] = ["solid", "shaded", "wire", "both", "hidden"];
const WORKER = workerAddress();
/** The grid is below the gamuts, so the middle of the view is lower than theirs. */
const ROOM_BELOW = 0.1;
const NAMES = { a: "First gamut", b: "Second gamut" };

class Viewer {
  readonly view: View;
  private readonly shown: Record<Role, Shown | null> = { a: null, b: null };
  private readonly opening: Record<Role, AbortController | null> = { a: null, b: null };
  private readonly choosers: Record<Role, Chooser>;
  private readonly canvas = byId<HTMLCanvasElement>("view");
  private readonly slider = byId<HTMLInputElement>("slider");
  private readonly number = byId<HTMLInputElement>("triangles");
  private readonly state: PageState;
  private readonly dark = matchMedia("(prefers-color-scheme: dark)");
  private readonly light = headLight();
  private readonly slice: SlicePanel;
  private readonly colours: ColourList;
  private readonly comparison = new ComparisonPanel(() => this.view.draw());
  private readonly materials: Record<Role, Materials> = { a: new Materials(), b: new Materials() };
  private readonly distance = new AnswerLines();
  private readonly options = new BuildOptions(() => {
    if (this.kept !== undefined) void this.upload(this.kept);
  });
  /** Files of gamuts that were built on this page, by id, and the file whose build failed last. */
  private readonly files = new Map<string, File>();
  private failed: File | undefined;
  private axesKey = "null";
  private axesGroup: Group | null = null;
  private job = "";
  private uploading: AbortController | null = null;
  private saving = 0;
  private pointer: PointerEvent | null = null;
  private levels = 0;
  /** Times in ms since the page was opened, and what was there at the first picture. */
  private readonly marks: Record<string, number> = {};

  constructor() {
    this.view = new View(this.canvas, byId("stage"));
    this.view.scene.add(new AmbientLight(0xffffff, 1.1), this.light);
    this.state = readState();
    this.slice = new SlicePanel(
      this.view.scene,
      () => {
        this.drawSlice();
        this.save();
      },
      (error) => this.complain(error),
    );
    this.slice.state = this.state.slice;
    this.colours = new ColourList(
      this.view.scene,
      () => this.view.draw(),
      (error) => this.complain(error),
    );
    this.view.onMove = () => {
      this.light.position.copy(this.view.camera.position);
      this.save();
    };
    const chooser = (role: Role) =>
      new Chooser(
        document.querySelector<HTMLElement>(`.chooser[data-role="${role}"]`)!,
        NAMES[role],
        (entry) => void this.choose(role, entry),
        (error) => this.complain(error),
      );
    this.choosers = { a: chooser("a"), b: chooser("b") };
    this.connectControls();
    if (embedded === null) this.connectFiles();
    else byId("title").textContent = embedded.gamut.name;
    this.connectPointer();
    void this.restore();
  }

  /** Figures for tests: what is held, and what was drawn. */
  get figures() {
    const { memory } = this.view.renderer.info;
    return {
      frames: this.view.frames,
      levels: this.levels,
      marks: this.marks,
      geometries: memory.geometries,
      textures: memory.textures,
      triangles: ROLES.map((role) => this.shown[role]?.layer.level?.triangles ?? 0),
      available: ROLES.map((role) => this.shown[role]?.layer.available ?? 0),
      withDevice: ROLES.map((role) => this.shown[role]?.layer.level?.device != null),
    };
  }

  /** Show a gamut by its id or slug; null removes it. */
  async show(role: Role, key: string | null): Promise<void> {
    this.opening[role]?.abort();
    const opening = new AbortController();
    this.opening[role] = opening;
    this.complain(null);
    if (key === null) {
      this.remove(role);
      this.fit();
      this.refresh();
      return;
    }
    try {
      const gamut = embedded?.gamut ?? (await describe(key, this.progress, opening.signal));
      const path = `/v1/gamuts/${gamut.id}`;
      const appearance = await appearanceOf(gamut, path, opening.signal);
      if (opening.signal.aborted) return;
      this.remove(role);
      const layer = new Layer(
        WORKER,
        embedded ? { bytes: embedded.history } : { address: address(`${path}/history`), headers: authorization() },
        appearance,
        axisNames(gamut),
        Math.min(this.state.triangles, gamut.counts.triangles),
        this.materials[role],
        {
          level: () => this.levelArrived(role),
          received: (complete) => {
            if (complete) this.marks["complete"] = performance.now();
            this.refreshLevel();
          },
          failed: (message) => this.complain(new Error(message)),
        },
      );
      this.shown[role] = { key, gamut, layer };
      this.view.scene.add(layer.group);
      this.choosers[role].show(gamut.name);
      this.fit();
      this.refresh();
    } catch (error) {
      if (!opening.signal.aborted) this.complain(error);
    } finally {
      if (this.opening[role] === opening) byId("job").hidden = this.uploading === null;
    }
  }

  private async choose(role: Role, entry: Entry | null): Promise<void> {
    this.failed = undefined;
    await this.show(role, entry?.key ?? null);
  }

  private async restore(): Promise<void> {
    const { state } = this;
    for (const role of ROLES) {
      const select = byId<HTMLSelectElement>(`style-${role}`);
      if (STYLES.includes(state.styles[role] as Style)) select.value = state.styles[role]!;
    }
    byId<HTMLInputElement>("axes").checked = state.axes;
    byId<HTMLSelectElement>("projection").value = state.projection;
    const { camera } = state;
    await Promise.all(ROLES.map((role) => state.gamuts[role] && this.show(role, state.gamuts[role])));
    this.view.setProjection(state.projection);
    if (camera !== null) this.view.restore(camera);
    this.refresh();
  }

  private remove(role: Role): void {
    this.shown[role]?.layer.dispose();
    this.shown[role] = null;
  }

  /** Triangles of the finest full boundary that is shown. */
  private get finest(): number {
    return Math.max(4, ...ROLES.map((role) => this.shown[role]?.gamut.counts.triangles ?? 4));
  }

  private setTriangles(triangles: number): void {
    const even = 2 * Math.floor(Math.min(Math.max(triangles, 4), this.finest) / 2);
    this.state.triangles = even;
    for (const role of ROLES) this.shown[role]?.layer.setTriangles(even);
    this.refreshLevel();
    this.save();
  }

  private levelArrived(role: Role): void {
    this.levels += 1;
    const { layer, gamut } = this.shown[role]!;
    const isWhole = layer.level!.triangles === gamut.counts.triangles;
    if (this.levels === 1 || isWhole) {
      this.view.drawNow();
      const now = performance.now();
      if (isWhole) this.marks["whole"] = now;
      if (this.levels === 1) {
        Object.assign(this.marks, { first: now, firstTriangles: layer.level!.triangles, firstBytes: layer.bytes });
      }
    }
    this.drawSlice();
    if (role === "a") {
      this.describeView();
      this.comparison.levelChanged();
    }
    this.refreshLevel();
  }

  private drawSlice(): void {
    const first = this.all()[0];
    this.slice.draw(this.all(), first === undefined ? [] : axisNames(first.gamut));
    this.view.draw();
  }

  /** Move the camera so that everything is in the picture. */
  private fit(): void {
    const box = new Box3();
    for (const { gamut } of this.all()) {
      const turn = orientation(axisNames(gamut));
      const [low, high] = gamut.bounds;
      const part = new Box3(new Vector3().fromArray(low), new Vector3().fromArray(high));
      box.union(part.applyMatrix4(turn));
    }
    if (box.isEmpty()) {
      this.drawAxes(box);
      return;
    }
    const radius = box.getSize(new Vector3()).length() / 2;
    const middle = box.getCenter(new Vector3());
    middle.y -= ROOM_BELOW * radius;
    this.view.setExtent(middle, radius);
    this.drawAxes(box);
  }

  private drawAxes(box?: Box3): void {
    const first = this.all()[0];
    if (box === undefined && first !== undefined) {
      this.fit();
      return;
    }
    let wanted: Parameters<typeof axes> | null = null;
    if (this.state.axes && first !== undefined) {
      const { color } = getComputedStyle(document.body);
      const names = axisNames(first.gamut);
      const ordered: [string, string, string] =
        names[0] === "X" ? [names[0], names[1]!, `−${names[2]!}`] : [names[1]!, names[0]!, names[2]!];
      wanted = [axesGrid(box!.min, box!.max), { names: ordered, line: color, text: color }];
    }
    // Labels are textures, which take longer than anything else of a change of gamut.
    const key = JSON.stringify(wanted);
    if (key === this.axesKey) return;
    this.axesKey = key;
    if (this.axesGroup !== null) disposeAxes(this.axesGroup);
    this.axesGroup = wanted && axes(...wanted);
    if (this.axesGroup !== null) this.view.scene.add(this.axesGroup);
  }

  /** The file that can be built again. */
  private get kept(): File | undefined {
    return this.failed ?? this.files.get(this.shown.a?.gamut.id ?? "");
  }

  private all(): Shown[] {
    return ROLES.flatMap((role) => this.shown[role] ?? []);
  }

  private get isDark(): boolean {
    const theme = document.documentElement.dataset["theme"];
    return theme === undefined ? this.dark.matches : theme === "dark";
  }

  private refresh(): void {
    const any = this.all().length > 0;
    byId("welcome").hidden = any;
    for (const role of ROLES) {
      const select = byId<HTMLSelectElement>(`style-${role}`);
      this.shown[role]?.layer.setStyle(select.value as Style, this.isDark);
    }
    this.fillViews();
    byId("legend").replaceChildren(
      ...ROLES.flatMap((role) => {
        const shown = this.shown[role];
        if (shown === null) return [];
        const style = byId<HTMLSelectElement>(`style-${role}`);
        const text = `${shown.gamut.name} · ${style.selectedOptions[0]!.text.toLowerCase()}`;
        return [element("p", text, { title: text })];
      }),
    );
    const blocks = this.all().flatMap(({ gamut }) => facts(gamut));
    byId("facts").replaceChildren(
      ...(any ? blocks : [element("p", "No gamut is shown.", { className: "note" })]),
    );
    this.slider.disabled = this.number.disabled = !any;
    const { a, b } = this.shown;
    this.comparison.show(a !== null && b !== null ? { a, b } : null);
    const gamut = a?.gamut ?? null;
    byId<HTMLButtonElement>("html").disabled = gamut === null;
    this.options.offer(this.kept, gamut?.name);
    this.colours.show(gamut, gamut === null ? null : orientation(axisNames(gamut)));
    this.refreshLevel();
    this.describeView();
    this.drawSlice();
    this.save();
  }

  private refreshLevel(): void {
    const { finest } = this;
    const wanted = Math.min(this.state.triangles, finest);
    this.slider.value = String(placeOf(wanted, finest));
    this.slider.setAttribute("aria-valuetext", `${wanted} triangles`);
    this.number.max = String(finest);
    if (document.activeElement !== this.number) this.number.value = String(wanted);
    byId("level-note").replaceChildren(
      ...this.all().map(({ gamut, layer }) =>
        element("span", limitNote(gamut, layer.level?.triangles ?? 0, Math.min(wanted, layer.aim))),
      ),
    );
  }

  private describeView(): void {
    const names = this.all().map(({ gamut, layer }) => `${gamut.name}, ${layer.level?.triangles ?? 0} triangles`);
    this.canvas.setAttribute("aria-label", names.length === 0 ? "No gamut is shown" : names.join("; "));
    const title = this.all().map(({ gamut }) => gamut.name);
    document.title = [...title, "Gamut viewer"].join(" – ");
  }

  private fillViews(): void {
    const first = this.all()[0];
    const toolbar = byId("views");
    for (const old of toolbar.querySelectorAll("[data-axis]")) old.remove();
    if (first === undefined) return;
    axisViews(axisNames(first.gamut)).forEach(([name, direction], place) => {
      const button = element("button", name, { type: "button", title: `From ${name} (${place + 1})` });
      button.dataset["axis"] = name;
      button.addEventListener("click", () => this.view.lookAlong(direction));
      toolbar.append(button);
    });
  }

  private save(): void {
    if (this.saving !== 0) return;
    this.saving = setTimeout(() => {
      this.saving = 0;
      const style = (role: Role) => byId<HTMLSelectElement>(`style-${role}`).value;
      writeState({
        ...this.state,
        gamuts: { a: this.shown.a?.key ?? null, b: this.shown.b?.key ?? null },
        styles: { a: style("a"), b: style("b") },
        projection: this.view.projection,
        camera: this.view.place,
      });
    }, 250);
  }

  private announce(text: string): void {
    byId("status").textContent = text;
  }

  /** Show what went wrong, in the words of the service; null clears it. */
  private complain(error: unknown): void {
    const box = byId("problem");
    box.hidden = error === null;
    box.replaceChildren();
    if (error === null) return;
    box.append(...problemElements(error));
    if (error instanceof ProblemError && [401, 403].includes(error.problem.status)) byId("key-field").hidden = false;
  }

  private readonly progress: Progress = (stage, fraction, job) => {
    this.job = job;
    byId("job").hidden = false;
    byId("stage-name").textContent = `Building: ${stage}`;
    byId<HTMLProgressElement>("progress").value = fraction;
    byId<HTMLButtonElement>("cancel").disabled = job === "";
    this.announce(`Building: ${stage}`);
  };

  private async upload(file: File): Promise<void> {
    const options = this.options.chosen();
    if (options === null) return;
    this.uploading?.abort();
    this.failed = undefined;
    const uploading = new AbortController();
    this.uploading = uploading;
    this.complain(null);
    try {
      const id = await build(file, options, this.progress, uploading.signal);
      if (uploading.signal.aborted) return;
      this.files.set(id, file);
      await this.show("a", id);
      this.announce(`${file.name} is shown`);
    } catch (error) {
      if (uploading.signal.aborted) return;
      this.complain(error);
      if (!(error instanceof ProblemError)) return;
      this.failed = file;
      this.options.offer(file, undefined);
      if (error.problem.code === "invalid-option") this.options.open();
    } finally {
      if (this.uploading === uploading) {
        this.uploading = null;
        byId("job").hidden = true;
      }
    }
  }

  private connectFiles(): void {
    const input = byId<HTMLInputElement>("file");
    byId("upload").addEventListener("click", () => {
      if (this.options.chosen() !== null) input.click();
    });
    input.addEventListener("change", () => {
      const [file] = input.files ?? [];
      input.value = "";
      if (file !== undefined) void this.upload(file);
    });
    const drop = byId("drop");
    let depth = 0;
    addEventListener("dragenter", (event) => {
      if (!event.dataTransfer?.types.includes("Files")) return;
      depth += 1;
      drop.hidden = false;
    });
    addEventListener("dragleave", () => {
      depth = Math.max(0, depth - 1);
      drop.hidden = depth === 0;
    });
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", (event) => {
      event.preventDefault();
      depth = 0;
      drop.hidden = true;
      const [file] = event.dataTransfer?.files ?? [];
      if (file !== undefined) void this.upload(file);
    });
    byId("cancel").addEventListener("click", () => {
      cancelJob(this.job).catch((error: unknown) => this.complain(error));
    });
    byId<HTMLInputElement>("key").addEventListener("change", (event) => {
      useKey((event.target as HTMLInputElement).value.trim());
      this.complain(null);
      void this.restore();
    });
  }

  private connectControls(): void {
    this.slider.addEventListener("input", () =>
      this.setTriangles(countAt(Number(this.slider.value), this.finest)),
    );
    this.number.addEventListener("change", () => {
      this.setTriangles(Number(this.number.value));
      this.number.value = String(this.state.triangles);
    });
    for (const role of ROLES) byId(`style-${role}`).addEventListener("change", () => this.refresh());
    byId("projection").addEventListener("change", (event) =>
      this.view.setProjection((event.target as HTMLSelectElement).value as Projection),
    );
    byId("axes").addEventListener("change", (event) => {
      this.state.axes = (event.target as HTMLInputElement).checked;
      this.drawAxes();
      this.refresh();
    });
    byId("swap").addEventListener("click", () => {
      const { a, b } = this.shown;
      void this.show("a", b?.key ?? null);
      void this.show("b", a?.key ?? null);
      for (const [role, shown] of [["a", b], ["b", a]] as const) {
        this.choosers[role].show(shown?.gamut.name ?? "");
      }
    });
    document.querySelector('[data-view="home"]')!.addEventListener("click", () => this.view.home());
    byId("png").addEventListener("click", () => void this.savePicture());
    byId("html").addEventListener("click", () => void this.savePage());
    byId("share").addEventListener("click", () => {
      void navigator.clipboard.writeText(pageAddress()).then(() => this.announce("The link was copied."));
    });
    byId("help").addEventListener("click", () => byId<HTMLDialogElement>("keys").showModal());
    byId("theme").addEventListener("click", () => this.nextTheme());
    this.dark.addEventListener("change", () => this.themeChanged());
    this.canvas.addEventListener("keydown", (event) => this.key(event));
  }

  private nextTheme(): void {
    const { dataset } = document.documentElement;
    const next = { undefined: "light", light: "dark", dark: undefined }[String(dataset["theme"])];
    if (next === undefined) delete dataset["theme"];
    else dataset["theme"] = next;
    const button = byId("theme");
    button.textContent = next === undefined ? "Auto" : next === "light" ? "Light" : "Dark";
    button.setAttribute("aria-label", `Colour scheme: ${button.textContent}`);
    this.themeChanged();
  }

  private themeChanged(): void {
    this.drawAxes();
    this.refresh();
  }

  private connectPointer(): void {
    const { canvas } = this;
    const later = (event: PointerEvent) => {
      if (this.pointer === null) requestAnimationFrame(() => this.readPointer());
      this.pointer = event;
    };
    canvas.addEventListener("pointermove", later);
    canvas.addEventListener("pointerdown", later);
    canvas.addEventListener("pointerleave", (event) => {
      // A finger that is lifted leaves as well.
      if (event.pointerType === "mouse") byId("readout").hidden = true;
    });
  }

  private readPointer(): void {
    const event = this.pointer;
    this.pointer = null;
    if (event === null || event.buttons > 1) return;
    const targets = this.all().flatMap(({ layer }) => layer.targets);
    const hit = this.view.pick(event.clientX, event.clientY, targets);
    const output = byId("readout");
    output.hidden = hit === null;
    if (hit === null) {
      this.distance.clear();
      return;
    }
    const shown = this.all().find(({ layer }) => layer.targets.some((mesh) => mesh === hit.object))!;
    const { gamut, layer } = shown;
    output.replaceChildren(...readout(gamut, axisNames(gamut), layer.level!, hit), this.distance.element);
    const other = this.all().find((each) => each !== shown)?.gamut;
    // Distances need equal coordinates. A page without the service has one gamut.
    if (other?.options.space === gamut.options.space) {
      const point = valuesAt(hit, layer.level!.positions, 3);
      this.distance.ask((signal) => distanceLines(other, point, signal));
    } else this.distance.clear();
  }

  private async savePicture(): Promise<void> {
    const names = this.all().map(({ gamut }) => gamut.name);
    save(await this.view.picture(), `${names.join(" and ") || "gamut"}.png`);
  }

  /** Save the first gamut as one file that shows it without the service. */
  private async savePage(): Promise<void> {
    const gamut = this.shown.a?.gamut;
    if (gamut === undefined) return;
    try {
      const page = await request(`/v1/gamuts/${gamut.id}/viewer.html`, { headers: { Accept: "text/html" } });
      save(await page.blob(), `${gamut.name}.html`);
    } catch (error) {
      this.complain(error);
    }
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { view } = this;
    const turn = Math.PI / 36;
    const first = this.all()[0];
    const views = first === undefined ? [] : axisViews(axisNames(first.gamut));
    const actions: Record<string, () => void> = {
      ArrowLeft: () => view.turn(-turn, 0),
      ArrowRight: () => view.turn(turn, 0),
      ArrowUp: () => view.turn(0, -turn),
      ArrowDown: () => view.turn(0, turn),
      "+": () => view.enlarge(1.15),
      "=": () => view.enlarge(1.15),
      "-": () => view.enlarge(1 / 1.15),
      "0": () => view.home(),
      "[": () => this.setTriangles(this.state.triangles / 2),
      "]": () => this.setTriangles(this.state.triangles * 2),
      p: () => {
        const select = byId<HTMLSelectElement>("projection");
        select.value = select.value === "perspective" ? "orthographic" : "perspective";
        view.setProjection(select.value as Projection);
      },
      w: () => {
        const select = byId<HTMLSelectElement>("style-a");
        select.selectedIndex = (select.selectedIndex + 1) % select.length;
        this.refresh();
      },
      a: () => byId("axes").click(),
      "?": () => byId<HTMLDialogElement>("keys").showModal(),
    };
    const direction = views[Number(event.key) - 1]?.[1];
    const action = direction === undefined ? actions[event.key.length === 1 ? event.key.toLowerCase() : event.key] : () => view.lookAlong(direction);
    if (action === undefined) return;
    event.preventDefault();
    action();
  }
}

function axisNames(gamut: Gamut): string[] {
  const named = gamut.provenance.colour_space?.axes;
  return named ?? gamut.provenance.axes?.split(" ") ?? ["L*", "a*", "b*"];
}

/** Views along the axes: from above, below, and from both ends of the other two. */
function axisViews(names: string[]): [string, Vector3][] {
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

declare global {
  interface Window {
    gamutViewer?: Viewer;
  }
}

try {
  window.gamutViewer = new Viewer();
} catch (error) {
  const box = byId("problem");
  box.hidden = false;
  box.append(element("strong", "This browser cannot show the view"), element("p", String(error)));
}
