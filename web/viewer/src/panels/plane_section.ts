// A section of the shown gamuts by a plane: its frame, its colours, the outlines, and its chart.
import { Box3, Vector3 } from "three";
import { type Theme, numberText, png } from "../charts/chart.js";
import { type Frame, sectionChart } from "../charts/section.js";
import { SCREEN, encoded } from "../colours/colours.js";
import { type Screen, type Space, gamutSpace } from "../colours/spaces.js";
import { type Page, type Shown, axisNames } from "../page/page.js";
import { SLOTS, tintOf } from "../page/slots.js";
import type { CutLayer, CutOptions, Half, Raster } from "../scene/cut.js";
import { orientation } from "../scene/layer.js";
import { type Cut, type Place, type Point, type SectionPlane, areaWithin, heightAbove, placesIn, planeOf, pointAt, rightHalf, sectionLoops } from "../scene/sections.js";
import type { Gamut } from "../service/api.js";
import type { SectionDraw } from "./section_figure.js";
import type { SliceState } from "./slice_state.js";

/** Columns and rows of the colours of a section; they are interpolated between. */
const RASTER = 96;
/** Room between a frame and what is in it, relative to its size. */
const OUTSIDE = 0.05;

export class PlaneSection {
  readonly cut: Cut;
  readonly plane: SectionPlane;
  readonly frame: Frame;
  /** The value of the plane, in words, and the gamuts with it. */
  readonly title: string;
  readonly name: string;
  /** Bounds of all gamuts, and the axis that is the lightness. */
  readonly box: Box3;
  readonly lightness: number;
  private readonly space: Space;
  private readonly axes: string[];
  private readonly raster: Raster;
  private readonly layers: CutLayer[];

  constructor(shown: Shown[], page: Page, state: SliceState) {
    const { gamut, slot: first } = shown[0]!;
    this.space = gamutSpace(gamut);
    this.axes = axisNames(gamut);
    this.box = boxOf(shown.map((each) => each.gamut));
    const { lightness } = this.space;
    this.lightness = lightness;
    this.cut = this.cutOf(state, middleLightness(gamut));
    this.plane = planeOf(this.cut, lightness);
    const { kind, value } = this.cut;
    this.title = kind === "hue" ? `Hue ${numberText(value, 4)}°` : `${this.axes[lightness]!} ${numberText(value, 4)}`;
    this.name = `${shown.map((each) => each.gamut.name).join(" and ")}, ${this.title}`;
    this.layers = shown.map(({ slot, gamut: { name }, layer }): CutLayer => {
      const { positions, faces } = layer.level!;
      const loops = sectionLoops(positions, faces, heightAbove(this.plane));
      const { isVisible, opacity } = page.lookOf(slot);
      return {
        layer,
        name,
        outlines: loops.map((loop) => placesIn(this.plane, loop)),
        isFilled: isVisible && (opacity === 1 || slot === first),
        colour: tintOf(slot, page.isDark),
        order: SLOTS.indexOf(slot),
      };
    });
    const reach = farthest(shown.map(({ layer }) => layer.level!.positions), this.otherAxes);
    this.frame = frameOf(this.cut, this.plane, this.box, reach);
    this.raster = colours(this.space, this.plane, this.frame, SCREEN);
  }

  private get otherAxes(): number[] {
    return [0, 1, 2].filter((axis) => axis !== this.lightness);
  }

  /** What the view shows of it. */
  inView(half: Half, { text, back }: Theme): CutOptions {
    const { plane, frame, raster } = this;
    const layers = this.layers.filter(({ layer }) => layer.isVisible);
    return { plane, turn: orientation(this.axes), frame, raster, layers, half, ink: text, back };
  }

  /** The point of the handle for a value of the plane, and the one at the other end of a hue. */
  handlePoints(value: number): [point: Point, opposite: Point] {
    const [[left, right], [bottom, top]] = this.frame;
    const plane = planeOf({ ...this.cut, value }, this.lightness);
    const height = this.cut.kind === "hue" ? (bottom + top) / 2 : bottom;
    return [pointAt(plane, [right, height]), pointAt(plane, [left, height])];
  }

  /** What draws the chart: of a hue, the half to the right. */
  chart(): SectionDraw {
    const { axes, cut, frame, lightness, plane, raster, space, title } = this;
    const isHue = cut.kind === "hue";
    const layers = this.layers.map((layer) => {
      const outlines = isHue ? layer.outlines.map(rightHalf).filter((outline) => outline.length > 0) : layer.outlines;
      return { ...layer, outlines, name: `${layer.name}, area ${areaText(areaWithin(outlines))}` };
    });
    const [across, upward] = this.otherAxes.map((axis) => `_${axes[axis]!}_`) as [string, string];
    const labels: [string, string] = isHue ? ["Chroma", `_${axes[lightness]!}_`] : [across, upward];
    const bounds: Frame = isHue ? [[0, frame[0][1]], frame[1]] : frame;
    // A file without a profile is sRGB, whatever the screen is.
    const address = png(pixels(SCREEN === "srgb" ? raster : colours(space, plane, frame, "srgb")), RASTER);
    return (options) => {
      const { svg, placeAt } = sectionChart({ ...options, title, labels, frame: bounds }, layers, { address, frame });
      const colourAt = (x: number, y: number) => {
        const place = placeAt(x, y);
        return place && pointAt(plane, place);
      };
      return { svg, pointAt: colourAt };
    };
  }

  /** The cut of the state; through the middle if an address has a value far outside of the gamuts. */
  private cutOf({ kind, lightness, hue }: SliceState, middle: number): Cut {
    if (kind === "hue") return { kind, value: hue };
    const [low, high] = [this.box.min, this.box.max].map((corner) => corner.getComponent(this.lightness));
    const isWithin = lightness !== null && lightness >= low! && lightness <= high!;
    return { kind: "lightness", value: isWithin ? lightness : middle };
  }
}

function areaText(area: number): string {
  return area >= 100 ? Math.round(area).toLocaleString("en") : numberText(area, 4);
}

function boxOf(gamuts: Gamut[]): Box3 {
  const box = new Box3();
  for (const { bounds } of gamuts) for (const corner of bounds) box.expandByPoint(new Vector3().fromArray(corner));
  return box;
}

/** The lightness of the first cut: half of a scale to 100 or 1, such as L* 50, else the middle of the gamut. */
export function middleLightness(gamut: Gamut): number {
  const { lightness } = gamutSpace(gamut);
  const [low, high] = gamut.bounds.map((corner) => corner[lightness]!) as [number, number];
  // White is at the end of the scale, or a little beyond it.
  const end = 10 ** Math.ceil(Math.log10(high / 1.05));
  return high > 0.7 * end && low < 0.5 * end ? end / 2 : Number(((low + high) / 2).toPrecision(2));
}

/** The largest distance of points from the origin, along some axes. */
function farthest(all: Float32Array[], axes: number[]): number {
  let most = 0;
  for (const points of all) {
    for (let i = 0; i < points.length; i += 3) {
      let square = 0;
      for (const axis of axes) square += points[i + axis]! ** 2;
      most = Math.max(most, square);
    }
  }
  return Math.sqrt(most);
}

/** Room for the section at any value of the slider, so that the drawing does not jump. */
function frameOf(cut: Cut, plane: SectionPlane, box: Box3, reach: number): Frame {
  const around = (low: number, high: number): Place => [low + OUTSIDE * (low - high), high + OUTSIDE * (high - low)];
  const [low, high] = placesIn(plane, [...box.min.toArray(), ...box.max.toArray()]) as [Place, Place];
  return [cut.kind === "hue" ? around(-reach, reach) : around(low[0], high[0]), around(low[1], high[1])];
}

/** The colours of a frame for a screen, row by row from the top. */
function colours(space: Space, plane: SectionPlane, [[left, right], [bottom, top]]: Frame, screen: Screen): Raster {
  const { origin, right: across, up: upwards } = plane;
  const points = new Float32Array(3 * RASTER * RASTER);
  for (let row = 0; row < RASTER; row++) {
    for (let column = 0; column < RASTER; column++) {
      const h = left + ((column + 0.5) / RASTER) * (right - left);
      const v = top - ((row + 0.5) / RASTER) * (top - bottom);
      const start = 3 * (row * RASTER + column);
      for (let axis = 0; axis < 3; axis++) points[start + axis] = origin[axis]! + h * across[axis]! + v * upwards[axis]!;
    }
  }
  return { linear: space.linear(points, screen), columns: RASTER };
}

function pixels({ linear }: Raster): Uint8ClampedArray {
  const made = new Uint8ClampedArray((4 * linear.length) / 3).fill(255);
  for (let i = 0; i < linear.length; i++) made[i + Math.floor(i / 3)] = 255 * encoded(linear[i]!);
  return made;
}
