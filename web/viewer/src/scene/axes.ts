// Axes with labels: a grid of chroma and hue below the gamuts, and a scale of lightness.
import {
  BufferGeometry,
  CanvasTexture,
  Float32BufferAttribute,
  Group,
  LineBasicMaterial,
  LineSegments,
  SRGBColorSpace,
  Sprite,
  SpriteMaterial,
  type Vector3,
} from "three";

/** Labels have the same texts again and again, and a material in use keeps its shader compiled. */
const labelMaterials = new Map<string, SpriteMaterial>();
const MOST_LABELS = 200;
const lineMaterials = new Map<string, LineBasicMaterial>();

const RING_CORNERS = 96;
const SPOKES = 12;

export interface AxesStyle {
  names: readonly [string, string, string];
  line: string;
  text: string;
}

/** A number from 1, 2 or 5 times a power of ten that divides a length into about `parts` parts. */
export function niceStep(length: number, parts: number): number {
  const rough = length / parts;
  const power = 10 ** Math.floor(Math.log10(rough));
  return power * ([1, 2, 5].find((factor) => factor * power >= 0.98 * rough) ?? 10);
}

/** Where the lines of axes are. */
export interface AxesGrid {
  /** Distance of the rings, and radius of the last one. */
  step: number;
  outer: number;
  /** Distance of the ticks of the upright axis, and its ends. */
  rise: number;
  floor: number;
  top: number;
}

/** Return the grid around bounds in scene coordinates: x and z across, y up. */
export function axesGrid(low: Vector3, high: Vector3): AxesGrid {
  const reach = Math.max(Math.abs(low.x), Math.abs(high.x), Math.abs(low.z), Math.abs(high.z));
  const step = niceStep(reach, 4);
  const rise = niceStep(high.y - low.y, 5);
  return {
    step,
    outer: Math.ceil(reach / step) * step,
    rise,
    floor: Math.min(0, Math.floor(low.y / rise) * rise),
    top: Math.ceil(high.y / rise - 0.02) * rise,
  };
}

/** Return axes. `names` are those of the axes to the right, upwards and away from the viewer. */
export function axes({ step, outer, rise, floor, top }: AxesGrid, style: AxesStyle): Group {
  const group = new Group();
  const faint: number[] = [];
  for (let radius = step; radius <= outer + step / 2; radius += step) {
    for (let i = 0; i < RING_CORNERS; i++) {
      for (const corner of [i, i + 1]) {
        const angle = (2 * Math.PI * corner) / RING_CORNERS;
        faint.push(radius * Math.cos(angle), floor, radius * Math.sin(angle));
      }
    }
  }
  for (let i = 0; i < SPOKES; i++) {
    const angle = (2 * Math.PI * i) / SPOKES;
    faint.push(0, floor, 0, outer * Math.cos(angle), floor, outer * Math.sin(angle));
  }
  const strong = [-outer, floor, 0, outer, floor, 0, 0, floor, -outer, 0, floor, outer, 0, floor, 0, 0, top, 0];
  const tick = step / 6;
  for (let y = floor; y <= top + rise / 2; y += rise) {
    strong.push(-tick, y, 0, tick, y, 0);
    if (y > floor) group.add(label(plain(y), -2.2 * tick, y, 0, outer, style.text, 0.8));
  }
  group.add(lines(faint, style.line, 0.28), lines(strong, style.line, 0.85));
  for (let radius = step; radius <= outer + step / 2; radius += step) {
    for (const sign of [-1, 1]) {
      group.add(
        label(plain(sign * radius), sign * radius, floor, tick, outer, style.text, 0.7),
        label(plain(sign * radius), tick, floor, -sign * radius, outer, style.text, 0.7),
      );
    }
  }
  const [right, up, away] = style.names;
  group.add(
    label(right, outer + step / 2, floor, 0, outer, style.text, 1.15),
    label(up, 0, top + 0.8 * rise, 0, outer, style.text, 1.15),
    label(away, 0, floor, -outer - step / 2, outer, style.text, 1.15),
  );
  return group;
}

export function disposeAxes(group: Group): void {
  group.removeFromParent();
  group.traverse((part) => {
    if (part instanceof LineSegments) part.geometry.dispose();
  });
  if (labelMaterials.size <= MOST_LABELS) return;
  for (const material of labelMaterials.values()) {
    material.map?.dispose();
    material.dispose();
  }
  labelMaterials.clear();
}

function plain(value: number): string {
  return String(Number(value.toPrecision(6))).replace("-", "−");
}

function lines(points: number[], colour: string, opacity: number): LineSegments {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
  const key = `${colour} ${opacity}`;
  const material = lineMaterials.get(key) ?? new LineBasicMaterial({ color: colour, transparent: true, opacity });
  lineMaterials.set(key, material);
  return new LineSegments(geometry, material);
}

function label(
  text: string,
  x: number,
  y: number,
  z: number,
  outer: number,
  colour: string,
  size: number,
): Sprite {
  const key = `${colour} ${text}`;
  const material = labelMaterials.get(key) ?? labelMaterial(text, colour);
  labelMaterials.set(key, material);
  const sprite = new Sprite(material);
  const { width, height } = material.map!.image as HTMLCanvasElement;
  const tall = 0.1 * outer * size;
  sprite.scale.set((tall * width) / height, tall, 1);
  sprite.position.set(x, y, z);
  return sprite;
}

function labelMaterial(text: string, colour: string): SpriteMaterial {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d")!;
  const font = "44px system-ui, sans-serif";
  context.font = font;
  canvas.width = Math.ceil(context.measureText(text).width) + 12;
  canvas.height = 60;
  context.font = font;
  context.fillStyle = colour;
  context.textBaseline = "middle";
  context.fillText(text, 6, 32);
  const map = new CanvasTexture(canvas);
  map.colorSpace = SRGBColorSpace;
  return new SpriteMaterial({ map, transparent: true, depthWrite: false });
}
