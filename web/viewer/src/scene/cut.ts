// The section in the 3-D view: solids are clipped at the plane, the cut is filled with its colours.
import {
  BufferGeometry,
  DataTexture,
  DoubleSide,
  Float32BufferAttribute,
  HalfFloatType,
  DataUtils,
  LineBasicMaterial,
  LineSegments,
  LinearFilter,
  type Matrix4,
  Mesh,
  MeshBasicMaterial,
  Group,
  Plane,
  RGBAFormat,
  ShapeUtils,
  Vector2,
  Vector3,
} from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { DASHES } from "../charts/chart.js";
import type { Frame, SectionOutline } from "../charts/section.js";
import type { Layer } from "./layer.js";
import type { View } from "./scene.js";
import { type Place, type Point, type SectionPlane, nested, pointAt } from "./sections.js";

export interface CutLayer extends SectionOutline {
  layer: Layer;
}

/** Which half is cut away: the one that the camera is in, the one above or below, or none. */
export type Half = "front" | "above" | "below" | "none";

/** Colours of a frame, linear RGB of the screen, row by row from the top. */
export interface Raster {
  linear: Float32Array;
  columns: number;
}

export interface CutOptions {
  plane: SectionPlane;
  /** From the space to the scene. */
  turn: Matrix4;
  frame: Frame;
  raster: Raster;
  layers: CutLayer[];
  half: Half;
  /** Colours of the frame and of the halos of outlines. */
  ink: string;
  back: string;
}

const LINE_WIDTH = 2.2;
const HALO_WIDTH = 4.6;
/** Units of the space per pixel of a dash, relative to the width of the frame. */
const DASH_SCALE = 1 / 420;
const BEHIND_LINES = { polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 4 };

export class CutAway {
  readonly cap = new Mesh(new BufferGeometry(), new MeshBasicMaterial({ side: DoubleSide, ...BEHIND_LINES }));
  private readonly group = new Group();
  private readonly frame = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ transparent: true, opacity: 0.55 }));
  private readonly lines = new Group();
  private readonly materials = new Map<string, LineMaterial>();
  /** Keeps what is in front of it. */
  private readonly kept = new Plane();
  private readonly plane = new Plane();
  private half: Half = "front";
  private turn: Matrix4 | null = null;

  constructor(private readonly view: View) {
    view.renderer.localClippingEnabled = true;
    this.group.add(this.cap, this.frame, this.lines);
    this.group.matrixAutoUpdate = false;
    this.cap.frustumCulled = this.frame.frustumCulled = false;
  }

  /** Whether the half above the plane is cut away. */
  get isAboveCut(): boolean {
    if (this.half !== "front") return this.half === "above";
    const { camera } = this.view;
    if (this.view.projection === "perspective") return this.plane.distanceToPoint(camera.position) >= 0;
    return camera.getWorldDirection(new Vector3()).dot(this.plane.normal) <= 0;
  }

  show({ plane, turn, frame, raster, layers, half, ink, back }: CutOptions): void {
    this.half = half;
    this.turn = turn;
    this.group.matrix.copy(turn);
    this.group.matrixWorldNeedsUpdate = true;
    const normal = new Vector3(...plane.normal).transformDirection(turn);
    this.plane.setFromNormalAndCoplanarPoint(normal, new Vector3(...plane.origin).applyMatrix4(turn));
    const isCut = half !== "none";
    for (const { layer } of layers) layer.clip(isCut ? [this.kept] : null);
    this.view.kept = isCut ? this.kept : null;
    this.fill(plane, frame, raster, layers.flatMap(({ outlines, isFilled }) => (isFilled ? nested(outlines) : [])));
    this.drawFrame(plane, frame, ink);
    this.clearLines();
    const scale = DASH_SCALE * (frame[0][1] - frame[0][0]);
    for (const { outlines, colour, order } of layers) {
      const [dash = 0, space = 0] = DASHES[order]!.split(" ").map((length) => scale * Number(length));
      const points = outlines.map((outline) => outline.map((place) => pointAt(plane, place)));
      const ends = points.flatMap((loop) => loop.flatMap((point, i) => [...loop.at(i - 1)!, ...point]));
      if (ends.length === 0) continue;
      const geometry = new LineSegmentsGeometry().setPositions(ends);
      for (const [width, tone, gap] of [[HALO_WIDTH, back, 0], [LINE_WIDTH, colour, space]] as const) {
        const material = this.material(`${tone} ${width} ${order}`, tone, width);
        Object.assign(material, { dashed: gap > 0, dashSize: dash, gapSize: gap });
        const line = new LineSegments2(geometry, material).computeLineDistances();
        line.frustumCulled = false;
        line.renderOrder = width === HALO_WIDTH ? 1 : 2;
        this.lines.add(line);
      }
    }
    this.view.scene.add(this.group);
    this.follow();
  }

  hide(layers: Layer[]): void {
    for (const layer of layers) layer.clip(null);
    this.view.kept = null;
    this.clearLines();
    this.group.removeFromParent();
    this.turn = null;
  }

  /** Cut the half away that the camera is in. */
  follow(): void {
    if (this.turn === null) return;
    const isAboveCut = this.isAboveCut;
    this.kept.copy(this.plane);
    if (isAboveCut) this.kept.negate();
    // What is cut away cannot hide the lines, and the cap is as far away as they are.
    for (const material of this.materials.values()) material.depthTest = this.half !== "front";
  }

  /** The point of the space at a hit of the cap. */
  pointOf(hit: Vector3): Point {
    return hit.clone().applyMatrix4(this.turn!.clone().invert()).toArray() as Point;
  }

  /** Where a point of the space is on the stage, in pixels. */
  screen(point: Point): Place {
    return this.view.stagePlace(new Vector3(...point).applyMatrix4(this.turn!));
  }

  private fill(plane: SectionPlane, [[left, right], [bottom, top]]: Frame, raster: Raster, groups: Place[][][]): void {
    const positions: number[] = [];
    const uvs: number[] = [];
    const index: number[] = [];
    for (const group of groups) {
      const [outer, ...holes] = group.map((outline) => outline.map(([h, v]) => new Vector2(h, v)));
      const begin = positions.length / 3;
      for (const face of ShapeUtils.triangulateShape(outer!, holes)) index.push(...face.map((i) => begin + i));
      for (const { x, y } of [outer!, ...holes].flat()) {
        positions.push(...pointAt(plane, [x, y]));
        uvs.push((x - left) / (right - left), (top - y) / (top - bottom));
      }
    }
    const { geometry, material } = this.cap;
    geometry.dispose();
    geometry.setAttribute("position", new Float32BufferAttribute(positions, 3));
    geometry.setAttribute("uv", new Float32BufferAttribute(uvs, 2));
    geometry.setIndex(index);
    geometry.computeBoundingSphere();
    material.map ??= emptyTexture(raster.columns, raster.linear.length / 3 / raster.columns);
    const data = (material.map as DataTexture).image.data as Uint16Array;
    for (let i = 0; i < raster.linear.length; i++) data[i + Math.floor(i / 3)] = DataUtils.toHalfFloat(raster.linear[i]!);
    material.map.needsUpdate = true;
  }

  private drawFrame(plane: SectionPlane, [[left, right], [bottom, top]]: Frame, ink: string): void {
    const corners: Place[] = [[left, bottom], [right, bottom], [right, top], [left, top]];
    const ends = corners.flatMap((corner, i) => [...pointAt(plane, corner), ...pointAt(plane, corners.at(i - 1)!)]);
    this.frame.geometry.dispose();
    this.frame.geometry.setAttribute("position", new Float32BufferAttribute(ends, 3));
    this.frame.material.color.set(ink);
  }

  private material(key: string, colour: string, width: number): LineMaterial {
    const material = this.materials.get(key) ?? new LineMaterial({ color: colour, linewidth: width });
    this.materials.set(key, material);
    return material;
  }

  private clearLines(): void {
    for (const line of this.lines.children) (line as LineSegments2).geometry.dispose();
    this.lines.clear();
  }
}

function emptyTexture(columns: number, rows: number): DataTexture {
  const one = DataUtils.toHalfFloat(1);
  const texture = new DataTexture(new Uint16Array(4 * columns * rows).fill(one), columns, rows, RGBAFormat, HalfFloatType);
  texture.minFilter = texture.magFilter = LinearFilter;
  return texture;
}
