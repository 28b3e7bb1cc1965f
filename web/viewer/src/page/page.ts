// The page: its view, the gamuts that it shows, and the events by which its parts follow them.
import { Box3, type Group, Vector3 } from "three";
import { axes, axesGrid, disposeAxes } from "../scene/axes.js";
import { Layer, Materials, type Style, headLight, orientation } from "../scene/layer.js";
import { View } from "../scene/scene.js";
import { type Gamut, ProblemError, type Progress, address, authorization, describe } from "../service/api.js";
import { AddressBook } from "./address.js";
import { byId, problemElements } from "./elements.js";
import { embedded, workerAddress } from "./embedded.js";
import { AmbientLight } from "three";

/** Places of gamuts, in the order of the list. The first one is the subject of all questions. */
export const SLOTS = ["a", "b", "c", "d", "e", "f"] as const;
export type Slot = (typeof SLOTS)[number];

export interface Shown {
  readonly slot: Slot;
  /** Id or slug, as in the address. */
  readonly key: string;
  readonly gamut: Gamut;
  readonly layer: Layer;
}

/**
 * What the parts of the page follow.
 *
 * `gamuts`: other gamuts or styles. `level`: another level of a gamut is drawn. `camera`: the view
 * was turned. `theme`: light or dark.
 */
export type PageEvent = "gamuts" | "level" | "camera" | "theme";

const WORKER = workerAddress();
/** The grid is below the gamuts, so the middle of the view is lower than theirs. */
const ROOM_BELOW = 0.1;
const DEFAULT_TRIANGLES = 10_000;

export class Page {
  readonly canvas = byId<HTMLCanvasElement>("view");
  readonly view = new View(this.canvas, byId("stage"));
  readonly address = new AddressBook();
  readonly styles = Object.fromEntries(SLOTS.map((slot) => [slot, slot === "a" ? "solid" : "wire"])) as Record<Slot, Style>;
  /** Triangles that are wished for, for all gamuts. */
  triangles = DEFAULT_TRIANGLES;
  hasAxes = true;
  /** Called with the progress of a build that a gamut waits for; "" ends it. */
  onProgress: Progress = () => {};
  private readonly gamuts = new Map<Slot, Shown>();
  private readonly opening = new Map<Slot, AbortController>();
  private readonly materials = new Map<Slot, Materials>();
  private readonly listeners = new Map<PageEvent, (() => void)[]>();
  private readonly light = headLight();
  private readonly dark = matchMedia("(prefers-color-scheme: dark)");
  private axesKey = "null";
  private axesGroup: Group | null = null;
  private levels = 0;
  /** Times in ms since the page was opened, and what was there at the first picture. */
  private readonly marks: Record<string, number> = {};

  constructor() {
    this.view.scene.add(new AmbientLight(0xffffff, 1.1), this.light);
    this.view.onMove = () => {
      this.light.position.copy(this.view.camera.position);
      this.emit("camera");
    };
    this.dark.addEventListener("change", () => this.emit("theme"));
    this.on("theme", () => {
      this.drawAxes();
      this.restyle();
    });
    this.address.add({
      read: (given) => {
        const triangles = Number(given.get("triangles"));
        if (Number.isInteger(triangles) && triangles >= 4) this.triangles = triangles;
        for (const slot of SLOTS) {
          const style = given.get(`style-${slot}`);
          if (style !== null && style in STYLE_NAMES) this.styles[slot] = style as Style;
        }
      },
      write: () => [
        ...this.shown.map(({ slot, key }): [string, string] => [slot, key]),
        ["triangles", String(this.triangles)],
        ...this.shown.map(({ slot }): [string, string] => [`style-${slot}`, this.styles[slot]]),
      ],
    });
    this.address.add({
      read: () => {},
      write: () => [["camera", this.view.place.join(",")]],
    });
    for (const event of ["gamuts", "level", "camera"] as const) this.on(event, () => this.address.save());
  }

  on(event: PageEvent, listener: () => void): void {
    this.listeners.set(event, [...(this.listeners.get(event) ?? []), listener]);
  }

  emit(event: PageEvent): void {
    for (const listener of this.listeners.get(event) ?? []) listener();
  }

  /** The gamuts that are shown, in the order of their slots. */
  get shown(): Shown[] {
    return SLOTS.flatMap((slot) => this.gamuts.get(slot) ?? []);
  }

  /** The gamut of a slot. */
  at(slot: Slot): Shown | null {
    return this.gamuts.get(slot) ?? null;
  }

  /** Triangles of the finest full boundary that is shown. */
  get finest(): number {
    return Math.max(4, ...this.shown.map(({ gamut }) => gamut.counts.triangles));
  }

  get isDark(): boolean {
    const theme = document.documentElement.dataset["theme"];
    return theme === undefined ? this.dark.matches : theme === "dark";
  }

  /** Figures for tests: what is held, and what was drawn. */
  get figures() {
    const { memory } = this.view.renderer.info;
    const [a, b, ...others] = SLOTS.map((slot) => this.at(slot)?.layer);
    const layers = [a, b, ...others.filter((layer) => layer !== undefined)];
    return {
      frames: this.view.frames,
      levels: this.levels,
      marks: this.marks,
      geometries: memory.geometries,
      textures: memory.textures,
      triangles: layers.map((layer) => layer?.level?.triangles ?? 0),
      available: layers.map((layer) => layer?.available ?? 0),
      withDevice: layers.map((layer) => layer?.level?.device != null),
    };
  }

  /** Show what the address says. */
  async restore(): Promise<void> {
    const given = this.address.read();
    const camera = given.get("camera")?.split(",").map(Number) ?? null;
    const path = /\/v1\/gamuts\/([^/]+)$/.exec(location.pathname)?.[1];
    const keys = new Map(SLOTS.map((slot) => [slot, given.get(slot)]));
    if (embedded !== null && SLOTS.every((slot) => keys.get(slot) == null)) {
      embedded.gamuts.forEach(({ gamut }, place) => keys.set(SLOTS[place]!, gamut.id));
    } else if (path !== undefined && keys.get("a") == null) keys.set("a", decodeURIComponent(path));
    // The picture of another gamut than the address names would mislead.
    const still = document.getElementById("static");
    if (![path, still?.dataset["gamut"]].includes(keys.get("a") ?? undefined)) still?.remove();
    await Promise.all([...keys].map(([slot, key]) => key !== null && this.show(slot, key)));
    if (this.shown.length === 0) still?.remove();
    if (camera !== null) this.view.restore(camera);
    this.emit("gamuts");
  }

  /** Show a gamut by its id or slug in a slot; null removes the one that is there. */
  async show(slot: Slot, key: string | null): Promise<void> {
    this.opening.get(slot)?.abort();
    const opening = new AbortController();
    this.opening.set(slot, opening);
    this.complain(null);
    if (key === null) {
      this.remove(slot);
      this.fit();
      this.emit("gamuts");
      return;
    }
    try {
      const saved = embedded?.gamuts.find(({ gamut }) => gamut.id === key);
      const gamut = saved?.gamut ?? (await describe(key, this.onProgress, opening.signal));
      const path = `/v1/gamuts/${gamut.id}`;
      if (opening.signal.aborted) return;
      this.remove(slot);
      const materials = this.materials.get(slot) ?? new Materials();
      this.materials.set(slot, materials);
      const layer = new Layer(
        WORKER,
        saved ? { bytes: saved.history } : { address: address(`${path}/history`), headers: authorization() },
        gamut.provenance.colour_space,
        axisNames(gamut),
        Math.min(this.triangles, gamut.counts.triangles),
        materials,
        {
          level: () => this.levelArrived(slot),
          received: (complete) => {
            if (complete) this.marks["complete"] = performance.now();
            this.emit("level");
          },
          failed: (message) => this.complain(new Error(message)),
        },
      );
      this.gamuts.set(slot, { slot, key, gamut, layer });
      this.view.scene.add(layer.group);
      this.fit();
      this.restyle();
    } catch (error) {
      if (!opening.signal.aborted) this.complain(error);
    } finally {
      if (this.opening.get(slot) === opening) this.onProgress("", 1, "");
    }
  }

  setTriangles(triangles: number): void {
    const even = 2 * Math.floor(Math.min(Math.max(triangles, 4), this.finest) / 2);
    this.triangles = even;
    for (const { layer } of this.shown) layer.setTriangles(even);
    this.emit("level");
  }

  /** Draw a gamut in another style. */
  setStyle(slot: Slot, style: Style): void {
    this.styles[slot] = style;
    this.restyle();
  }

  setAxes(hasAxes: boolean): void {
    this.hasAxes = hasAxes;
    this.drawAxes();
    this.view.draw();
    this.address.save();
  }

  announce(text: string): void {
    byId("status").textContent = text;
  }

  /** Show what went wrong, in the words of the service; null clears it. */
  complain(error: unknown): void {
    const box = byId("problem");
    box.hidden = error === null;
    box.replaceChildren();
    if (error === null) return;
    box.append(...problemElements(error));
    if (error instanceof ProblemError && [401, 403].includes(error.problem.status)) byId("key-field").hidden = false;
  }

  private restyle(): void {
    for (const { slot, layer } of this.shown) layer.setStyle(this.styles[slot], this.isDark);
    this.emit("gamuts");
    this.view.draw();
  }

  private remove(slot: Slot): void {
    this.gamuts.get(slot)?.layer.dispose();
    this.gamuts.delete(slot);
  }

  private levelArrived(slot: Slot): void {
    this.levels += 1;
    const { layer, gamut } = this.gamuts.get(slot)!;
    const isWhole = layer.level!.triangles === gamut.counts.triangles;
    if (this.levels === 1 || isWhole) {
      this.view.drawNow();
      const now = performance.now();
      if (isWhole) this.marks["whole"] = now;
      if (this.levels === 1) {
        document.getElementById("static")?.remove();
        Object.assign(this.marks, { first: now, firstTriangles: layer.level!.triangles, firstBytes: layer.bytes });
      }
    }
    this.emit("level");
    this.view.draw();
  }

  /** Move the camera so that everything is in the picture. */
  private fit(): void {
    const box = new Box3();
    for (const { gamut } of this.shown) {
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
    const first = this.shown[0];
    if (box === undefined && first !== undefined) {
      this.fit();
      return;
    }
    let wanted: Parameters<typeof axes> | null = null;
    if (this.hasAxes && first !== undefined) {
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
}

/** Styles of a gamut, with their names on the page. */
export const STYLE_NAMES: Record<Style, string> = {
  solid: "Solid",
  shaded: "Shaded",
  wire: "Wireframe",
  both: "Solid and edges",
  hidden: "Hidden",
};

/** Names of the coordinates of a gamut. */
export function axisNames(gamut: Gamut): string[] {
  const named = gamut.provenance.colour_space?.axes;
  return named ?? gamut.provenance.axes?.split(" ") ?? ["L*", "a*", "b*"];
}
