// One shown gamut: its worker, its buffers on the graphics processor, and its style.
import {
  BackSide,
  BufferAttribute,
  BufferGeometry,
  DecrementWrapStencilOp,
  DoubleSide,
  EqualDepth,
  FrontSide,
  Group,
  IncrementWrapStencilOp,
  LineBasicMaterial,
  LineSegments,
  type Material,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  NotEqualStencilFunc,
  type Plane,
  ReplaceStencilOp,
  type Side,
  Sphere,
  Vector2,
  Vector3,
  type WebGLRenderer,
} from "three";
import { SCREEN } from "../colours/colours.js";
import type { SpaceDescription } from "../colours/spaces.js";
import { Lines, type LineSteps, extend } from "./lines.js";
import { surfaceMaterial } from "./materials.js";
import type { LevelBuffers, Order, Report, Source } from "./messages.js";

/** How a gamut is drawn. */
export interface Look {
  isVisible: boolean;
  /** 1 is a solid; below it the gamut is a translucent shell with its silhouette. */
  opacity: number;
  /** Edges of the triangles of a solid. */
  hasEdges: boolean;
}

/** Scene coordinates of a colour: right, up and towards the viewer, as in the service's glTF. */
export function orientation(axes: readonly string[]): Matrix4 {
  // L*, a*, b* → a*, L*, −b*; spaces whose second axis is the lightness stay.
  if (axes[0] === "X") return new Matrix4();
  return new Matrix4().set(0, 1, 0, 0, 1, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1);
}

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

/** Opacity of the lines of a translucent shell on its far and near side. */
/** A shell that is the limit of a grey part tints it only slightly. */
const LIMIT_OPACITY = 0.08;
const LINE_OPACITY = { far: 0.12, near: 0.4 };
/** Width of the silhouette in CSS pixels. */
const RIM = 1.5;

/** Order among opaque objects: solids, the count of what is in another gamut, the grey part. */
const COUNT_ORDER = 1;
const GREY_ORDER = 2;
/** Order among translucent objects: far sides from this on, near sides after all of them, then silhouettes. */
const SHELL_ORDER = 10;
const RIM_ORDER = 20;

/** Materials of one slot. They outlive the gamuts, so that no shader is compiled again. */
export class Materials {
  readonly lines = new Lines();
  readonly surface = surfaceMaterial(BEHIND_EDGES);
  readonly grey = surfaceMaterial(BEHIND_EDGES);
  readonly edge = new LineBasicMaterial({ transparent: true, color: 0x000000, opacity: 0.35 });
  readonly far = this.shell(BackSide, LINE_OPACITY.far);
  readonly near = this.shell(FrontSide, LINE_OPACITY.near);
  readonly covered = covering();
  readonly rims = RIM_STEPS.map(([x, y]) => rim(x, y));
  readonly countFar = counting(BackSide);
  readonly countNear = counting(FrontSide);

  constructor() {
    turnGrey(this.surface, false);
    turnGrey(this.grey, true);
    Object.assign(this.grey, { depthFunc: EqualDepth, stencilWrite: true, stencilFunc: NotEqualStencilFunc });
  }

  /** Cut off what is beyond planes. The count needs the closed gamut, so it is not cut. */
  set clippingPlanes(planes: Plane[] | null) {
    const { surface, grey, edge, far, near, covered, rims } = this;
    for (const material of [surface, grey, edge, far, near, covered, ...rims]) material.clippingPlanes = planes;
  }

  /** Faces with this opacity under the section lines. */
  setShellOpacity(opacity: number): void {
    this.far.opacity = this.near.opacity = opacity;
  }

  private shell(side: Side, opacity: number): MeshBasicMaterial {
    const material = surfaceMaterial({ transparent: true, depthWrite: false, side });
    this.lines.addTo(material, { value: opacity });
    return material;
  }
}

/**
 * A material that counts, pixel by pixel, the sides of a closed surface behind what is drawn: far sides
 * up, near sides down. What is left is not 0 where the drawn point is inside. Counting behind it
 * ("z-fail") is right wherever the camera is.
 */
function counting(side: Side): MeshBasicMaterial {
  return new MeshBasicMaterial({
    side,
    colorWrite: false,
    depthWrite: false,
    stencilWrite: true,
    stencilZFail: side === BackSide ? IncrementWrapStencilOp : DecrementWrapStencilOp,
    ...BEHIND_EDGES,
  });
}

/** Where the surface is drawn again around its picture, in pixels: the silhouette is what is new. */
const RIM_STEPS = Array.from({ length: 8 }, (_, i) => [Math.cos((i * Math.PI) / 4), Math.sin((i * Math.PI) / 4)] as const);

/** A material that marks the pixels that a surface covers, also behind others. */
function covering(): MeshBasicMaterial {
  return new MeshBasicMaterial({
    side: DoubleSide,
    colorWrite: false,
    depthWrite: false,
    depthTest: false,
    transparent: true, // drawn among the shells
    stencilWrite: true,
    stencilRef: 1,
    stencilZPass: ReplaceStencilOp,
  });
}

/** A material that draws a surface a little beside its place, where `covering` has not marked. */
function rim(x: number, y: number): MeshBasicMaterial {
  const material = new MeshBasicMaterial({
    side: DoubleSide,
    depthWrite: false,
    transparent: true,
    stencilWrite: true,
    stencilRef: 1,
    stencilFunc: NotEqualStencilFunc,
  });
  extend(material, (shader) => {
    shader.uniforms["beside"] = { value: material.userData["beside"] };
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nuniform vec2 beside;")
      .replace("#include <project_vertex>", "#include <project_vertex>\ngl_Position.xy += beside * gl_Position.w;");
  });
  material.userData["beside"] = new Vector2();
  material.userData["step"] = [x, y];
  return material;
}

/** Grey is a uniform: with the same program as in colour, its depths are equal to the last bit. */
function turnGrey(material: Material, isGrey: boolean): void {
  extend(material, (shader) => {
    shader.uniforms["isGrey"] = { value: isGrey };
    // Luminance of linear sRGB (IEC 61966-2-1), compressed towards a middle grey.
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", "#include <common>\nuniform bool isGrey;")
      .replace(
        "#include <opaque_fragment>",
        `if (isGrey) outgoingLight = vec3(0.12 + 0.25 * dot(outgoingLight, vec3(0.2126, 0.7152, 0.0722)));
        #include <opaque_fragment>`,
      );
  });
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
  private readonly far = new Mesh(this.surface);
  private readonly near = new Mesh(this.surface);
  private readonly grey = new Mesh(this.surface);
  private readonly counts = [new Mesh(this.surface), new Mesh(this.surface)];
  private readonly covered = new Mesh(this.surface);
  private readonly rims = RIM_STEPS.map(() => new Mesh(this.surface));
  private look: Look = { isVisible: false, opacity: 1, hasEdges: false };
  private capacity = 0;
  private busy = false;
  private shown = 0;

  constructor(
    workerAddress: string,
    source: Source,
    space: Partial<SpaceDescription>,
    axes: readonly string[],
    private readonly steps: LineSteps,
    private wanted: number,
    private materials: Materials,
    private readonly events: LayerEvents,
  ) {
    this.group.applyMatrix4(orientation(axes));
    this.group.add(this.mesh, this.edges, this.far, this.near, this.grey, ...this.counts, this.covered, ...this.rims);
    for (const part of this.group.children) Object.assign(part, { frustumCulled: false, visible: false });
    for (const shell of [this.far, this.near]) shell.onBeforeRender = (renderer) => this.materials.lines.fit(renderer);
    this.rims.forEach((part, place) => {
      part.onBeforeRender = (renderer) => this.placeRim(renderer, place);
    });
    this.rims.at(-1)!.onAfterRender = (renderer) => renderer.clearStencil();
    this.grey.renderOrder = GREY_ORDER;
    this.grey.onAfterRender = (renderer) => renderer.clearStencil();
    for (const count of this.counts) count.renderOrder = COUNT_ORDER;
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

  /** Draw with a look, the materials of a slot and a colour for lines. */
  setLook(look: Look, tint: string, materials: Materials): void {
    const isSolid = look.isVisible && look.opacity === 1;
    const isShell = look.isVisible && look.opacity < 1;
    this.look = look;
    this.materials = materials;
    this.mesh.visible = isSolid;
    this.mesh.material = materials.surface;
    this.grey.material = materials.grey;
    this.grey.visible &&= isSolid;
    this.edges.visible = isSolid && look.hasEdges;
    this.edges.material = materials.edge;
    this.far.material = materials.far;
    this.near.material = materials.near;
    this.covered.material = materials.covered;
    for (const part of [this.far, this.near, this.covered, ...this.rims]) part.visible = isShell;
    this.rims.forEach((part, place) => (part.material = materials.rims[place]!));
    for (const material of materials.rims) material.color.set(tint);
    [this.counts[0]!.material, this.counts[1]!.material] = [materials.countFar, materials.countNear];
    this.setCounted(this.counts[0]!.visible);
    materials.lines.colour.set(tint);
    materials.lines.steps = this.steps;
  }

  /**
   * Place of a translucent shell among others, by size, 0 for the smallest. Gamuts lie in one another:
   * the far sides are drawn from the largest inwards, then the near sides outwards.
   */
  setRank(rank: number): void {
    this.far.renderOrder = SHELL_ORDER - rank;
    this.near.renderOrder = SHELL_ORDER + 1 + rank;
    this.covered.renderOrder = RIM_ORDER + 2 * rank;
    for (const part of this.rims) part.renderOrder = RIM_ORDER + 2 * rank + 1;
  }

  /** Move the surface beside its place by the width of the silhouette. */
  private placeRim(renderer: WebGLRenderer, place: number): void {
    const material = this.materials.rims[place]!;
    const [x, y] = material.userData["step"] as [number, number];
    const { width, height } = renderer.getDrawingBufferSize(new Vector2());
    const pixels = 2 * RIM * renderer.getPixelRatio();
    (material.userData["beside"] as Vector2).set((pixels * x) / width, (pixels * y) / height);
  }

  /** Cut off what is beyond planes; null shows all. */
  clip(planes: Plane[] | null): void {
    this.materials.clippingPlanes = planes;
  }

  /** Show in grey what is in the gamut whose sides are counted. */
  setGrey(isGrey: boolean): void {
    this.grey.visible = isGrey && this.mesh.visible;
  }

  /** Count the sides of this gamut, visible or not, for the grey part of another one. */
  setCounted(isCounted: boolean): void {
    for (const count of this.counts) count.visible = isCounted;
    this.materials.setShellOpacity(isCounted ? Math.min(LIMIT_OPACITY, this.look.opacity) : this.look.opacity);
  }

  /** Objects that the pointer can hit: a solid, or what can be seen through. */
  get targets(): { solid: Mesh[]; shell: Mesh[] } {
    return { solid: this.mesh.visible ? [this.mesh] : [], shell: this.near.visible ? [this.near] : [] };
  }

  get isVisible(): boolean {
    return this.look.isVisible;
  }

  dispose(): void {
    this.worker.onmessage = this.worker.onerror = null; // a message may be on its way
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
    const triangles = Math.min(this.wanted, this.available);
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
