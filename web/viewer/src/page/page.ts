// The page: its view, the gamuts that it shows, and the events by which its parts follow them.
import { Box3, type Intersection, type Mesh, Vector3 } from "three";
import { spaceDescription } from "../colours/spaces.js";
import { AxesBox, sceneAxes } from "../scene/axes.js";
import { liesInside } from "../scene/containment.js";
import { Layer, type Look, Materials, orientation } from "../scene/layer.js";
import { lineSteps } from "../scene/lines.js";
import type { Source } from "../scene/messages.js";
import { View } from "../scene/scene.js";
import { type Gamut, ProblemError, address, authorization, describe } from "../service/api.js";
import { describeExample, exampleFile, findExample, historyOf } from "../service/examples.js";
import { AddressBook } from "./address.js";
import { byId, problemElements } from "./elements.js";
import { embedded, workerAddress } from "./embedded.js";
import { Latest } from "./latest.js";
import { Board, type Work } from "./progress.js";
import { differentSpaces, inSameSpace, optionsOfSpace } from "./same_space.js";
import { SLOTS, type Slot, tintOf } from "./slots.js";

export interface Shown {
  readonly slot: Slot;
  /** Id or slug, as in the address. */
  readonly key: string;
  readonly gamut: Gamut;
  readonly layer: Layer;
  /** Whether only the begin of the history is loaded, from a file of the page. */
  readonly isPart: boolean;
}

/** A gamut, and where its history is; a part of it for examples. */
interface Found {
  gamut: Gamut;
  source: Source;
  isPart: boolean;
}

/** Something else in the view whose colours the pointer reads. */
export interface Readable {
  targets(): Mesh[];
  read(hit: Intersection): void;
}

/**
 * What the parts of the page follow.
 *
 * `slots`: a gamut was taken in or put away, with the looks that follow from it. `looks`: a gamut is
 * hidden, shown, or drawn in another way. `requests`: a gamut is on its way, or no longer. `level`:
 * another level of a gamut is drawn. `camera`: the view was turned. `theme`: light or dark.
 */
export type PageEvent = "slots" | "looks" | "requests" | "level" | "camera" | "theme";

const WORKER = workerAddress();
const DEFAULT_TRIANGLES = 10_000;
/** Triangles of a level that tells whether a gamut lies inside another one. */
const FINE_TRIANGLES = 1000;
export const SHELL_OPACITY = 0.3;
/** Opacities of the styles that addresses of earlier versions have. */
const STYLE_OPACITIES: Record<string, number> = { solid: 1, shaded: 1, both: 1, shell: SHELL_OPACITY, wire: 0.05 };

export class Page {
  readonly canvas = byId<HTMLCanvasElement>("view");
  readonly view = new View(this.canvas, byId("stage"));
  readonly address = new AddressBook();
  /** What the reader chose of the looks of gamuts. */
  private readonly hidden = new Set<Slot>();
  private readonly opacities = new Map<Slot, number>();
  /** Whether solids show the edges of their triangles. */
  hasEdges = false;
  /** The gamut that is a solid unless the reader chooses an opacity. */
  private solid: Slot = "a";
  /** Whether gamuts lie almost inside others, by their ids. */
  private readonly containment = new Map<string, boolean>();
  /** What parts add to the state of a saved page, by name. */
  readonly kept = new Map<string, () => unknown>();
  /** Files that gamuts were built from on this page, by id. */
  readonly files = new Map<string, File>();
  /** The file that is built for each slot. It ends with another choice for it. */
  readonly building = latestOfSlots();
  /** Triangles that are wished for, for all gamuts. */
  triangles = DEFAULT_TRIANGLES;
  hasAxes = true;
  /** What is waited for, and quiet notes. */
  readonly board = new Board((text) => this.announce(text));
  /** Whether the gamuts are those of the first screen, which nobody has chosen. */
  isTrial = false;
  readonly readable: Readable[] = [];
  private readonly gamuts = new Map<Slot, Shown>();
  /** Keys of gamuts that are on their way, or that could not be shown. The address keeps them. */
  private readonly wanted = new Map<Slot, string>();
  /** The camera of the address, until the gamuts that it is for are there. */
  private camera: number[] | null = null;
  /** The gamut that the page is the address of, without what stands behind the number sign. */
  private readonly own = /\/v1\/gamuts\/([^/]+)$/.exec(location.pathname)?.[1];
  private readonly opening = latestOfSlots();
  private readonly materials = Object.fromEntries(SLOTS.map((slot) => [slot, new Materials()])) as Record<Slot, Materials>;
  private readonly listeners = new Map<PageEvent, (() => void)[]>();
  private readonly dark = matchMedia("(prefers-color-scheme: dark)");
  /** What the extent and the axes of the view were made of. */
  private extentKey = "";
  private levels = 0;
  /** Times in ms since the page was opened, and what was there at the first picture. */
  private readonly marks: Record<string, number> = {};

  constructor() {
    this.view.onMove = () => this.emit("camera");
    this.dark.addEventListener("change", () => this.emit("theme"));
    this.on(["theme"], () => {
      this.fit();
      this.applyLooks();
    });
    this.address.add({
      read: (given) => {
        const triangles = Number(given.get("triangles"));
        if (Number.isInteger(triangles) && triangles >= 4) this.triangles = triangles;
        for (const slot of SLOTS) {
          this.readLook(slot, given.get(`style-${slot}`), Number(given.get(`opacity-${slot}`) ?? NaN));
        }
      },
      write: () => [
        ...SLOTS.map((slot): [string, string | null] => [slot, this.keyOf(slot) ?? (slot === "a" && this.own ? "" : null)]),
        ["triangles", String(this.triangles)],
        ...this.shown.flatMap(({ slot }): [string, string | null][] => [
          [`style-${slot}`, this.hidden.has(slot) ? "hidden" : null],
          [`opacity-${slot}`, this.opacities.get(slot)?.toString() ?? null],
        ]),
      ],
    });
    this.address.add({
      read: () => {},
      write: () => [["camera", (this.view.isHome ? this.camera : this.view.place)?.join(",") ?? null]],
    });
    this.on(["slots", "looks", "requests", "level", "camera"], () => this.address.save());
  }

  on(events: PageEvent[], listener: () => void): void {
    for (const event of events) this.listeners.set(event, [...(this.listeners.get(event) ?? []), listener]);
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

  /** Whether no gamut is shown or on its way. */
  get isEmpty(): boolean {
    return this.gamuts.size === 0 && this.wanted.size === 0;
  }

  private keyOf(slot: Slot): string | undefined {
    return this.at(slot)?.key ?? this.wanted.get(slot);
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
    this.camera = given.get("camera")?.split(",").map(Number) ?? null;
    const path = this.own;
    const keys = new Map(SLOTS.map((slot) => [slot, given.get(slot)]));
    if (embedded !== null && SLOTS.every((slot) => keys.get(slot) == null)) {
      embedded.gamuts.forEach(({ gamut }, place) => keys.set(SLOTS[place]!, gamut.id));
    } else if (path !== undefined && keys.get("a") == null) keys.set("a", decodeURIComponent(path));
    // The picture of another gamut than the address names would mislead.
    const still = document.getElementById("static");
    if (![path, still?.dataset["gamut"]].includes(keys.get("a") ?? undefined)) still?.remove();
    // The others follow the space of the first one.
    this.complain(null);
    this.wanted.clear();
    for (const [slot, key] of keys) if (key) this.wanted.set(slot, key);
    // What the reader chooses for a slot meanwhile stays.
    const [first, ...others] = [...this.wanted].map(([slot, key]) => async () => {
      if (this.wanted.get(slot) === key) await this.load(slot, key);
    });
    await first?.();
    await Promise.all(others.map((load) => load()));
    // A reader who has turned the view meanwhile keeps it.
    if (this.camera !== null && this.view.isHome && this.shown.length > 0) this.view.restore(this.camera);
    this.emit("slots");
  }

  /**
   * Show a gamut in a slot by its id, its slug or the key of an example; null removes the one that is
   * there. Examples are coarse files of the page, or `isWhole`: from the service.
   */
  async show(slot: Slot, key: string | null, isWhole = false): Promise<void> {
    this.isTrial = false;
    this.camera = null;
    this.complain(null);
    this.building[slot].end();
    if (key !== null) return this.load(slot, key, isWhole);
    this.opening[slot].end();
    this.wanted.delete(slot);
    this.remove(slot);
    this.fit();
    this.applyLooks();
    this.emit("slots");
  }

  /** The same for a gamut that nobody has just chosen: what is said about others stays. */
  private async load(slot: Slot, key: string, isWhole = false): Promise<void> {
    const opening = this.opening[slot];
    this.wanted.set(slot, key);
    await opening.ask(
      (signal) => {
        const work = this.board.begin(key.length === 64 ? "The gamut" : key, slot, () => {
          opening.end();
          this.wanted.delete(slot);
          this.emit("requests");
        });
        signal.addEventListener("abort", () => work.end());
        return this.find(slot, key, isWhole, work, signal).finally(() => work.end());
      },
      (gamut) => this.put(slot, key, gamut),
      (error) => {
        this.complain(error);
        this.emit("requests");
      },
    );
  }

  /** Show a gamut in place of the one that a slot has. */
  private put(slot: Slot, key: string, { gamut, source, isPart }: Found): void {
    this.remove(slot);
    const axes = axisNames(gamut);
    const layer: Layer = new Layer(
      WORKER,
      source,
      spaceDescription(gamut),
      axes,
      lineSteps(gamut.options.space, axes),
      Math.min(this.triangles, gamut.counts.triangles),
      this.materials[slot],
      {
        level: () => this.levelArrived(layer),
        received: (complete) => {
          if (complete) this.marks["complete"] = performance.now();
          this.emit("level");
          const isTooShort = isPart && this.triangles > Math.max(DEFAULT_TRIANGLES, layer.available);
          const place = this.shown.find((each) => each.layer === layer)?.slot;
          if (complete && isTooShort && place !== undefined) void this.load(place, key, true);
        },
        failed: (message) =>
          this.complain(new Error(`${gamut.name} could not be loaded. Open the page again. (${message})`)),
      },
    );
    this.wanted.delete(slot);
    this.gamuts.set(slot, { slot, key, gamut, layer, isPart });
    this.view.scene.add(layer.group);
    this.followFirst();
    this.fit();
    this.applyLooks();
    this.emit("slots");
  }

  /** Describe a gamut of a key, and say where its history is. */
  private async find(slot: Slot, key: string, isWhole: boolean, work: Work, signal: AbortSignal): Promise<Found> {
    const saved = embedded?.gamuts.find(({ gamut }) => gamut.id === key);
    if (saved !== undefined) return { gamut: saved.gamut, source: { bytes: saved.history }, isPart: false };
    const example = await findExample(key);
    const given = example && (await describeExample(example, () => this.board.prepare(example.name, slot)));
    const { anchor } = this.beside(slot);
    if (example !== undefined && !isWhole && (anchor === undefined || inSameSpace(given!, anchor))) {
      return { gamut: given!, source: { address: historyOf(example), headers: {}, isShort: true }, isPart: true };
    }
    const name = example?.file ? given!.id : key;
    // Options that the key states are the reader's; without any, a reference follows the space of the others.
    const options = anchor !== undefined && isReference(name) && !name.includes("?") ? optionsOfSpace(anchor) : {};
    const gamut = await describe(name, work.report, signal, options);
    const { anchor: present, isFirst } = this.beside(slot);
    if (present !== undefined && !isFirst && !inSameSpace(gamut, present)) {
      // The gamut beside it has changed meanwhile.
      if (present.id !== anchor?.id) return this.find(slot, key, isWhole, work, signal);
      throw differentSpaces(gamut, present);
    }
    const source = { address: address(`/v1/gamuts/${gamut.id}/history`), headers: authorization() };
    return { gamut, source, isPart: false };
  }

  /** The gamut whose space the one of a slot has to fit, and whether the slot is the first one. */
  private beside(slot: Slot): { anchor: Gamut | undefined; isFirst: boolean } {
    const others = this.shown.filter((each) => each.slot !== slot);
    const isFirst = others.every((each) => each.slot > slot);
    return { anchor: others.find(({ gamut }) => !isFirst || gamut.provenance.reference === undefined)?.gamut, isFirst };
  }

  /** Show the other gamuts in the space of the first one: references are built in it, the rest goes. */
  private followFirst(): void {
    const [first, ...others] = this.shown;
    for (const { slot, key, gamut } of others) {
      if (inSameSpace(gamut, first!.gamut)) continue;
      this.remove(slot);
      if (gamut.provenance.reference !== undefined) void this.load(slot, key.split("?")[0]!);
      else this.complain(differentSpaces(gamut, first!.gamut));
    }
  }

  setTriangles(triangles: number): void {
    const even = 2 * Math.floor(Math.min(Math.max(triangles, 4), this.finest) / 2);
    this.triangles = even;
    for (const { slot, key, layer, isPart } of this.shown) {
      layer.setTriangles(even);
      if (isPart && even > layer.available && layer.available > 0) void this.load(slot, key, true);
    }
    this.emit("level");
  }

  /** How a gamut is drawn: as the reader chose, else one solid among translucent shells. */
  lookOf(slot: Slot): Look {
    const opacity = this.opacities.get(slot) ?? (slot === this.solid ? 1 : SHELL_OPACITY);
    return { isVisible: !this.hidden.has(slot), opacity, hasEdges: this.hasEdges };
  }

  setVisible(slot: Slot, isVisible: boolean): void {
    if (isVisible) this.hidden.delete(slot);
    else this.hidden.add(slot);
    this.changeLooks();
  }

  setOpacity(slot: Slot, opacity: number): void {
    this.opacities.set(slot, Math.min(1, Math.max(0.05, opacity)));
    this.changeLooks();
  }

  setEdges(hasEdges: boolean): void {
    this.hasEdges = hasEdges;
    this.changeLooks();
  }

  /** Take the look of a gamut from an address; links of earlier versions name a style. */
  private readLook(slot: Slot, style: string | null, opacity: number): void {
    if (style === "hidden") this.hidden.add(slot);
    if (style !== null && style in STYLE_OPACITIES) this.opacities.set(slot, STYLE_OPACITIES[style]!);
    if (style === "both") this.hasEdges = true;
    if (opacity > 0 && opacity <= 1) this.opacities.set(slot, opacity);
  }

  /** The solid is the first gamut, or the smallest one inside it: a solid would hide that. */
  private chooseSolid(): Slot {
    const [first, ...others] = this.shown;
    const inner = others.filter((each) => this.isInside(each, first!)).sort((one, other) => one.gamut.volume - other.gamut.volume);
    return inner[0]?.slot ?? first?.slot ?? "a";
  }

  private isInside(one: Shown, other: Shown): boolean {
    const key = `${one.gamut.id} ${other.gamut.id}`;
    const known = this.containment.get(key);
    const isFine = ({ gamut, layer }: Shown) =>
      (layer.level?.triangles ?? 0) >= Math.min(FINE_TRIANGLES, this.triangles, gamut.counts.triangles);
    if (known !== undefined || one.gamut.volume > other.gamut.volume || !isFine(one) || !isFine(other)) return known ?? false;
    const isInside = liesInside(one.layer.level!, other.layer.level!);
    this.containment.set(key, isInside);
    return isInside;
  }

  setAxes(hasAxes: boolean): void {
    this.hasAxes = hasAxes;
    this.fit();
    this.view.draw();
    this.address.save();
  }

  /** The file that a gamut was built from, if the page can have it. */
  async sourceOf(slot: Slot): Promise<File | null> {
    const example = await findExample(this.at(slot)?.key ?? "");
    return example === undefined ? null : exampleFile(example);
  }

  announce(text: string): void {
    byId("status").textContent = text;
  }

  /** Show what went wrong, in the words of the service, and with which file; null clears it. */
  complain(error: unknown, file = ""): void {
    const box = byId("problem");
    box.hidden = error === null;
    box.replaceChildren();
    if (error === null) return;
    box.append(...problemElements(error, file));
    if (isLocked(error)) byId("key-field").hidden = false;
  }

  private changeLooks(): void {
    this.applyLooks();
    this.emit("looks");
  }

  private applyLooks(): void {
    this.solid = this.chooseSolid();
    for (const { slot, layer } of this.shown) {
      layer.setLook(this.lookOf(slot), tintOf(slot, this.isDark), this.materials[slot]);
    }
    const sizes = [...this.shown].sort((one, other) => one.gamut.volume - other.gamut.volume);
    sizes.forEach(({ layer }, rank) => layer.setRank(rank));
    this.view.draw();
  }

  private remove(slot: Slot): void {
    this.gamuts.get(slot)?.layer.dispose();
    this.gamuts.delete(slot);
  }

  private levelArrived(layer: Layer): void {
    this.levels += 1;
    const { gamut } = this.shown.find((each) => each.layer === layer)!;
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
    if (this.chooseSolid() !== this.solid) this.changeLooks();
    this.emit("level");
    this.view.draw();
  }

  /** Set what the view shows: all gamuts, and the axes around them. */
  private fit(): void {
    const box = new Box3();
    for (const { gamut } of this.shown) {
      const turn = orientation(axisNames(gamut));
      const [low, high] = gamut.bounds;
      const part = new Box3(new Vector3().fromArray(low), new Vector3().fromArray(high));
      box.union(part.applyMatrix4(turn));
    }
    const first = this.shown[0];
    const hasAxes = this.hasAxes && first !== undefined;
    const names = first === undefined ? [] : axisNames(first.gamut);
    const { color } = getComputedStyle(document.body);
    const key = JSON.stringify([box, names, hasAxes, color]);
    if (key === this.extentKey) return;
    this.extentKey = key;
    // Without gamuts the view stays as it was, without axes.
    this.view.setExtent(first === undefined ? null : box, hasAxes ? new AxesBox(sceneAxes(names), box, color) : null);
  }
}

function latestOfSlots(): Record<Slot, Latest> {
  return Object.fromEntries(SLOTS.map((slot) => [slot, new Latest()])) as Record<Slot, Latest>;
}

/** Whether the service asks for an API key. */
function isLocked(error: unknown): boolean {
  return error instanceof ProblemError && [401, 403].includes(error.problem.status);
}

/** Whether a key is the slug of a reference, which can be built in any space, and not an id. */
function isReference(key: string): boolean {
  return !/^[0-9a-f]{64}$/.test(key);
}

/** Names of the coordinates of a gamut. */
export function axisNames(gamut: Gamut): string[] {
  const named = gamut.provenance.colour_space?.axes;
  return named ?? gamut.provenance.axes?.split(" ") ?? ["L*", "a*", "b*"];
}
