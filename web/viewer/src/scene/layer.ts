// One shown gamut: its worker, its buffers on the graphics processor, and its style.
import {
  BufferAttribute,
  BufferGeometry,
  DirectionalLight,
  Group,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  Sphere,
  Vector3,
} from "three";
import { SCREEN } from "../colours/colours.js";
import type { SpaceDescription } from "../colours/spaces.js";
import { withMarks } from "./marking.js";
import type { LevelBuffers, Order, Report, Source } from "./messages.js";

export type Style = "solid" | "shaded" | "wire" | "both" | "hidden";

/** Scene coordinates of a colour: right, up and towards the viewer, as in the service's glTF. */
export function orientation(axes: readonly string[]): Matrix4 {
  // L*, a*, b* → a*, L*, −b*; spaces whose second axis is the lightness stay.
  if (axes[0] === "X") return new Matrix4();
  return new Matrix4().set(0, 1, 0, 0, 1, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1);
}

/** More edges than this hide what is behind them. */
const MOST_WIRE_TRIANGLES = 1500;

/** Faces are pushed back so that edges on them are visible. */
const BEHIND_EDGES = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };

/** Vertices that buffers have room for at least: no buffer is made while a slider moves below it. */
const LEAST_ROOM = 8192;

export interface LayerEvents {
  level(): void;
  /** More of the history has arrived. */
  received(complete: boolean): void;
  failed(message: string): void;
}

/** Materials of one role. They outlive the gamuts, so that no shader is compiled again. */
export class Materials {
  readonly flat = withMarks(new MeshBasicMaterial({ vertexColors: true, ...BEHIND_EDGES }));
  readonly lit = withMarks(new MeshLambertMaterial({ vertexColors: true, flatShading: true, ...BEHIND_EDGES }));
  readonly line = new LineBasicMaterial({ transparent: true });
}

export class Layer {
  readonly group = new Group();
  /** The level that is drawn; null before the first one. */
  level: LevelBuffers | null = null;
  /** Triangles of the finest level that has arrived. */
  available = 0;
  /** Bytes of the history that have arrived. */
  bytes = 0;
  private readonly worker: Worker;
  private readonly surface = new BufferGeometry();
  private readonly lines = new BufferGeometry();
  private readonly mesh: Mesh = new Mesh(this.surface);
  private readonly edges = new LineSegments(this.lines);
  private capacity = 0;
  private busy = false;
  private shown = 0;
  private limit = Infinity;

  constructor(
    workerAddress: string,
    source: Source,
    space: Partial<SpaceDescription>,
    axes: readonly string[],
    private wanted: number,
    private readonly materials: Materials,
    private readonly events: LayerEvents,
  ) {
    this.group.applyMatrix4(orientation(axes));
    this.group.add(this.mesh, this.edges);
    this.mesh.frustumCulled = this.edges.frustumCulled = false;
    this.worker = new Worker(workerAddress);
    this.worker.onmessage = ({ data }: MessageEvent<Report>) => this.receive(data);
    this.worker.onerror = () => events.failed("The reader of histories could not be loaded.");
    this.order({ kind: "open", source, space, screen: SCREEN });
  }

  /** Show a number of triangles, or the nearest that has arrived. */
  setTriangles(triangles: number): void {
    this.wanted = triangles;
    this.ask();
  }

  setStyle(style: Style, isDark: boolean): void {
    this.mesh.visible = style === "solid" || style === "shaded" || style === "both";
    const { flat, lit, line } = this.materials;
    this.mesh.material = style === "shaded" ? lit : flat;
    this.edges.material = line;
    this.edges.visible = style === "wire" || style === "both";
    line.color.set(isDark && style === "wire" ? 0xffffff : 0x000000);
    line.opacity = style === "wire" ? 0.6 : 0.35;
    this.limit = style === "wire" ? MOST_WIRE_TRIANGLES : Infinity;
    this.ask();
  }

  /** Show vertices inside another gamut in grey; null shows all in colour. */
  setInside(inside: boolean[] | null): void {
    const { level } = this;
    if (level === null) return;
    const attribute = this.surface.getAttribute("color") as BufferAttribute;
    attribute.array.set(level.colours);
    inside?.forEach((isInside, vertex) => {
      if (!isInside) return;
      const [r, g, b] = level.colours.subarray(3 * vertex, 3 * vertex + 3);
      // Luminance of linear sRGB (IEC 61966-2-1), compressed towards a middle grey.
      const grey = 0.12 + 0.25 * (0.2126 * r! + 0.7152 * g! + 0.0722 * b!);
      for (let channel = 0; channel < 3; channel++) attribute.array[3 * vertex + channel] = grey;
    });
    attribute.clearUpdateRanges();
    attribute.addUpdateRange(0, level.colours.length);
    attribute.needsUpdate = true;
  }

  /** Triangles that are shown when everything has arrived. */
  get aim(): number {
    return Math.min(this.wanted, this.limit);
  }

  /** Objects that the pointer can hit. */
  get targets(): Mesh[] {
    return this.mesh.visible ? [this.mesh] : [];
  }

  get isVisible(): boolean {
    return this.mesh.visible || this.edges.visible;
  }

  dispose(): void {
    this.worker.terminate();
    this.group.removeFromParent();
    this.surface.dispose();
    this.lines.dispose();
  }

  private receive(report: Report): void {
    if (report.kind === "failed") {
      this.events.failed(report.message);
      return;
    }
    if (report.kind === "received") {
      this.available = report.available;
      this.bytes = report.bytes;
      this.events.received(report.complete);
      if (report.complete) this.shown = 0; // the level has its device values now
      this.ask();
      return;
    }
    this.busy = false;
    this.upload(report.level);
    this.ask();
    this.events.level();
  }

  /** Ask for the wanted level unless an answer is under way: the last wish counts. */
  private ask(): void {
    const triangles = Math.min(this.wanted, this.available, this.limit);
    if (this.busy || this.available === 0 || triangles === this.shown) return;
    this.busy = true;
    this.shown = triangles;
    this.order({ kind: "level", triangles });
  }

  private order(order: Order): void {
    this.worker.postMessage(order);
  }

  private upload(level: LevelBuffers): void {
    this.level = level;
    const vertices = level.positions.length / 3;
    // A change of a buffer that is in use may copy all of it, so buffers are no larger than needed.
    const room = Math.max(LEAST_ROOM, 2 ** Math.ceil(Math.log2(vertices)));
    if (room > this.capacity || room < this.capacity / 2) this.allocate(room);
    const copy = (attribute: BufferAttribute, values: Float32Array | Int32Array) => {
      attribute.array.set(values);
      attribute.clearUpdateRanges();
      attribute.addUpdateRange(0, values.length);
      attribute.needsUpdate = true;
    };
    copy(this.surface.getAttribute("position") as BufferAttribute, level.positions);
    copy(this.surface.getAttribute("color") as BufferAttribute, level.colours);
    copy(this.surface.getAttribute("beyond") as BufferAttribute, level.beyond);
    copy(this.surface.index!, level.faces);
    copy(this.lines.index!, level.edges);
    this.surface.setDrawRange(0, level.faces.length);
    this.lines.setDrawRange(0, level.edges.length);
    this.surface.boundingSphere = boundingSphere(level.positions);
  }

  private allocate(vertices: number): void {
    this.capacity = vertices;
    const triangles = 2 * vertices;
    this.surface.dispose();
    this.lines.dispose();
    const positions = new BufferAttribute(new Float32Array(3 * vertices), 3);
    this.surface.setAttribute("position", positions);
    this.surface.setAttribute("color", new BufferAttribute(new Float32Array(3 * vertices), 3));
    this.surface.setAttribute("beyond", new BufferAttribute(new Float32Array(vertices), 1));
    this.surface.setIndex(new BufferAttribute(new Uint32Array(3 * triangles), 1));
    this.lines.setAttribute("position", positions);
    this.lines.setIndex(new BufferAttribute(new Uint32Array(3 * triangles), 1));
  }
}

function boundingSphere(positions: Float32Array): Sphere {
  const low = new Vector3(Infinity, Infinity, Infinity);
  const high = low.clone().negate();
  const point = new Vector3();
  for (let i = 0; i < positions.length; i += 3) {
    point.fromArray(positions, i);
    low.min(point);
    high.max(point);
  }
  const centre = low.clone().add(high).divideScalar(2);
  return new Sphere(centre, high.distanceTo(low) / 2);
}

/** Light from the camera, for the shaded style. */
export function headLight(): DirectionalLight {
  return new DirectionalLight(0xffffff, Math.PI);
}
