// The 3-D view: cameras, turning, views along the axes, axes, and drawing on demand.
import {
  Box3,
  Color,
  MathUtils,
  type Object3D,
  OrthographicCamera,
  PerspectiveCamera,
  type Plane,
  Raycaster,
  type Intersection,
  Scene,
  Spherical,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { SCREEN } from "../colours/colours.js";
import { type AxesBox, type Edges, type Label, LABEL_ROOM, LabelLayer } from "./axes.js";

const FIELD_OF_VIEW = 30;
const HALF_ANGLE = Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
/** Pictures that take longer than this, in ms, are drawn with fewer pixels while things move. */
const SLOW_PICTURE = 20;
const SLOW_PICTURES = 2;
/** One step: each change of the number of pixels waits for the graphics processor. */
const LOW_RESOLUTION = 0.35;
const RESTING_MILLISECONDS = 250;
/** Direction of the start view: from the front right, slightly above. */
const HOME = new Vector3(0.55, 0.42, 1);
/** Room in pixels around the gamuts where there are no axes. */
const PLAIN_ROOM = 16;
/** The least part of the picture that gamuts are fitted into. */
const LEAST_PART = 0.3;
/** Limits of the size, relative to the fitted view. */
const SMALLEST = 1 / 4;
const LARGEST = 12;
/** Distance of the camera in addresses when everything fits: about what it is in radii of the gamuts. */
const FITTED_DISTANCE = 4;
/** How far from the middle the target may be, relative to the radius of the gamuts. */
const REACH = 0.6;
/** The camera stays this far from the middle, relative to the radius of the gamuts. */
const NEAREST = 1.02;
const TURN_MILLISECONDS = 280;
/** Radians per ms: a turn takes 40 s. */
const SPIN = (2 * Math.PI) / 40_000;
/** Azimuths at which a turning box is measured. */
const AZIMUTHS = 24;

export type Projection = "perspective" | "orthographic";

/** Where the camera is: around the target, which moves as well. */
interface Place {
  target: Vector3;
  offset: Spherical;
  zoom: number;
}

const NOTHING: Edges = { left: 0, top: 0, right: 0, bottom: 0 };
const calm = matchMedia("(prefers-reduced-motion: reduce)");

export class View {
  readonly scene = new Scene();
  readonly renderer: WebGLRenderer;
  private readonly perspective = new PerspectiveCamera(FIELD_OF_VIEW);
  private readonly orthographic = new OrthographicCamera();
  private readonly controls: OrbitControls;
  private readonly raycaster = new Raycaster();
  private readonly labels = new LabelLayer();
  private readonly box = new Box3(new Vector3().setScalar(-60), new Vector3().setScalar(60));
  private readonly middle = new Vector3();
  private radius = 100;
  axes: AxesBox | null = null;
  /** Size of the picture in CSS pixels, and what covers it at its edges. */
  private width = 1;
  private height = 1;
  private covered = NOTHING;
  /** The direction of a view that is fitted to the picture; null after the reader moved it. */
  private fitted: Vector3 | null = HOME;
  private turning: { from: Place; to: Place; since: number } | null = null;
  private spinning = false;
  private waiting = 0;
  private resolution = 1;
  private drawnAt = 0;
  /** Number of slow pictures one after the other. */
  private slow = 0;
  private resting = 0;
  /** Number of pictures that were drawn. */
  frames = 0;
  /** The plane in front of which everything is cut away, and nothing can be pointed at. */
  kept: Plane | null = null;
  /** Called after each picture on the screen, also while the view turns by itself. */
  readonly onDraw: (() => void)[] = [];
  /** Called after the camera moved. */
  onMove: () => void = () => {};

  constructor(
    readonly canvas: HTMLCanvasElement,
    private readonly stage: HTMLElement,
  ) {
    this.renderer = new WebGLRenderer({ canvas, alpha: true, antialias: true, stencil: true });
    // Vertex colours are linear RGB of the screen, and both screens have the same curve.
    const buffer = this.renderer.getContext();
    if ("drawingBufferColorSpace" in buffer) buffer.drawingBufferColorSpace = SCREEN;
    // The check waits for the compilation of each shader.
    this.renderer.debug.checkShaderErrors = false;
    canvas.after(this.labels.element);
    this.controls = new OrbitControls(this.perspective, canvas);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("start", () => this.touched());
    this.controls.addEventListener("change", () => {
      this.limit();
      this.centre();
      if (!this.spinning) this.onMove();
      this.draw();
    });
    const observer = new ResizeObserver(() => this.resize());
    for (const part of [stage, ...stage.querySelectorAll("[data-edge]")]) observer.observe(part);
    this.resize();
    this.home();
  }

  get projection(): Projection {
    return this.camera === this.perspective ? "perspective" : "orthographic";
  }

  get camera(): PerspectiveCamera | OrthographicCamera {
    return this.controls.object as PerspectiveCamera | OrthographicCamera;
  }

  /** The start view, which needs no entry in the address. */
  get isHome(): boolean {
    return this.fitted === HOME;
  }

  /** Change the projection and keep the size of what is at the target. */
  setProjection(projection: Projection): void {
    if (projection === this.projection) return;
    const { target } = this.controls;
    const { position, up } = this.camera;
    const size = this.visibleSize();
    const camera = projection === "perspective" ? this.perspective : this.orthographic;
    camera.up.copy(up);
    camera.position.copy(position);
    this.controls.object = camera;
    if (camera === this.perspective) {
      const direction = position.clone().sub(target).setLength(size / HALF_ANGLE);
      camera.position.copy(target).add(direction);
    } else {
      camera.zoom = this.radius / size;
    }
    this.resize();
    this.controls.update();
    this.onMove();
  }

  /** Set what the views show: the box of all gamuts, null to keep it, and the axes around them. */
  setExtent(gamuts: Box3 | null, axes: AxesBox | null): void {
    const { scale } = this;
    const box = gamuts ?? this.box.clone();
    this.axes?.dispose();
    this.axes = axes;
    this.labels.clear();
    if (axes !== null) this.scene.add(axes.group);
    const radius = box.getSize(new Vector3()).length() / 2;
    this.box.copy(box);
    (axes?.box ?? box).getCenter(this.middle);
    this.controls.cursor.copy(this.middle);
    this.controls.maxTargetRadius = REACH * radius;
    if (this.fitted === null) {
      this.camera.position.sub(this.controls.target).add(this.middle);
      this.controls.target.copy(this.middle);
    }
    this.radius = radius;
    this.refit(scale);
    this.controls.update();
  }

  home(): void {
    this.lookAlong(HOME);
  }

  /** Look at the middle from a direction, with everything in the picture. */
  lookAlong(direction: Vector3): void {
    this.touched();
    this.fitted = direction;
    this.moveTo(this.fittedPlace(direction));
  }

  /** Turn slowly until the view is touched; not for readers who prefer less motion. */
  spin(isOn: boolean): void {
    this.spinning = isOn && !calm.matches;
    if (this.spinning && this.fitted !== null) this.moveTo(this.fittedPlace(this.fitted));
    this.draw();
  }

  /** Turn around the target by angles in radians. */
  turn(azimuth: number, elevation: number): void {
    this.touched();
    this.turnBy(azimuth, elevation);
  }

  /** Change the size of the picture by a factor. */
  enlarge(factor: number): void {
    this.touched();
    const { controls, orthographic } = this;
    if (this.camera === orthographic) {
      orthographic.zoom = MathUtils.clamp(orthographic.zoom * factor, controls.minZoom, controls.maxZoom);
      orthographic.updateProjectionMatrix();
    } else {
      this.camera.position.sub(controls.target).divideScalar(factor).add(controls.target);
    }
    controls.update();
    this.onMove();
    this.draw();
  }

  /**
   * Numbers that `restore` takes: position, target and zoom, in any window.
   *
   * The target is relative to the extent; distance and zoom are relative to the fitted view.
   */
  get place(): number[] {
    const { camera, scale } = this;
    const isFlat = camera === this.orthographic;
    const target = this.controls.target.clone().sub(this.middle).divideScalar(this.radius);
    const position = this.towardsCamera.multiplyScalar(FITTED_DISTANCE / (isFlat ? 1 : scale)).add(target);
    const numbers = [...position.toArray(), ...target.toArray(), isFlat ? scale : 1];
    return numbers.map((value) => Number(value.toPrecision(4)));
  }

  restore(place: number[]): void {
    if (place.length !== 7 || !place.every(Number.isFinite) || place[6]! <= 0) return;
    const [target, offset] = [new Vector3().fromArray(place, 3), new Vector3().fromArray(place)];
    offset.sub(target);
    if (offset.length() === 0) return;
    this.touched();
    this.controls.target.copy(target).multiplyScalar(this.radius).add(this.middle);
    this.camera.position.copy(this.controls.target).add(offset);
    this.refit(this.camera === this.orthographic ? place[6]! : FITTED_DISTANCE / offset.length());
    this.controls.update();
    this.draw();
  }

  /** Draw before the next picture of the screen. */
  draw(): void {
    if (this.waiting !== 0) return;
    this.waiting = requestAnimationFrame((now) => {
      this.waiting = 0;
      this.move(now);
      this.adapt(now - this.drawnAt);
      this.drawnAt = now;
      this.drawNow();
      if (this.turning !== null || this.spinning) this.draw();
    });
  }

  /** The nearest surface at a point of the page. */
  pick(clientX: number, clientY: number, objects: Object3D[]): Intersection | null {
    const box = this.canvas.getBoundingClientRect();
    const place = new Vector2(
      (2 * (clientX - box.left)) / box.width - 1,
      1 - (2 * (clientY - box.top)) / box.height,
    );
    this.raycaster.setFromCamera(place, this.camera);
    const isKept = ({ point }: Intersection) => (this.kept?.distanceToPoint(point) ?? 0) > -1e-4 * this.radius;
    return this.raycaster.intersectObjects(objects, false).find(isKept) ?? null;
  }

  /** Where a point of the scene is on the stage, in pixels from the left and the top. */
  stagePlace(point: Vector3): [number, number] {
    this.camera.updateMatrixWorld();
    const { x, y } = point.project(this.camera);
    return [((x + 1) / 2) * this.stage.clientWidth, ((1 - y) / 2) * this.stage.clientHeight];
  }

  /** The direction from the target to the camera. */
  get towardsCamera(): Vector3 {
    return this.camera.position.clone().sub(this.controls.target).normalize();
  }

  /**
   * Draw the view in another size, and let something take the canvas and the labels.
   *
   * `covered` is kept free. With `isClear` there is no ground. The picture on the screen stays as it is.
   */
  at<T>(
    { width, height, ratio, isClear }: { width: number; height: number; ratio: number; isClear: boolean },
    covered: Edges,
    take: (canvas: HTMLCanvasElement, labels: Label[]) => T,
  ): T {
    const { camera, canvas, controls, renderer } = this;
    const kept = camera.clone();
    const screen = { width: this.width, height: this.height, covered: this.covered };
    const { scale } = this;
    Object.assign(this, { width, height, covered });
    try {
      renderer.setDrawingBufferSize(width, height, ratio);
      const buffer = renderer.getContext();
      if (buffer.drawingBufferWidth < Math.floor(width * ratio) || buffer.drawingBufferHeight < Math.floor(height * ratio)) {
        throw new Error("This browser cannot draw so large a picture. Choose a smaller one.");
      }
      const place = this.fittedPlace(this.fitted ?? this.towardsCamera, false);
      const target = this.fitted === null ? controls.target : place.target;
      if (camera === this.orthographic) camera.zoom = scale * place.zoom;
      else place.offset.radius /= scale;
      camera.position.setFromSpherical(place.offset).add(target);
      camera.lookAt(target);
      this.setFrame();
      this.render(isClear);
      return take(canvas, this.axes?.labels(camera, width, height, covered) ?? []);
    } finally {
      camera.position.copy(kept.position);
      camera.quaternion.copy(kept.quaternion);
      camera.zoom = kept.zoom;
      Object.assign(this, screen);
      this.resize();
      this.drawNow();
    }
  }

  /** The view as a PNG file. */
  picture(): Promise<Blob> {
    this.setResolution(1);
    this.drawNow();
    return new Promise((resolve, reject) =>
      this.canvas.toBlob((blob) => (blob === null ? reject(new Error("no picture")) : resolve(blob))),
    );
  }

  drawNow(): void {
    this.render();
    this.labels.show(this.axes?.labels(this.camera, this.width, this.height, this.covered) ?? []);
    this.frames += 1;
    for (const listener of this.onDraw) listener();
  }

  private render(isClear = false): void {
    const { axes, camera, scene } = this;
    scene.background = isClear ? null : new Color(getComputedStyle(this.stage).backgroundColor);
    axes?.turnTo(camera);
    this.renderer.render(scene, camera);
  }

  /** The reader moves the view from now on. */
  private touched(): void {
    this.turning = null;
    this.fitted = null;
    if (!this.spinning) return;
    this.spinning = false;
    this.onMove();
  }

  /** Move the camera that turns by itself. */
  private move(now: number): void {
    const { turning } = this;
    if (turning !== null) {
      turning.since ||= now;
      const part = Math.min(1, (now - turning.since) / TURN_MILLISECONDS);
      if (part === 1) this.turning = null;
      this.setPlace(between(turning.from, turning.to, part * part * (3 - 2 * part)));
    } else if (this.spinning) this.turnBy(-SPIN * Math.min(100, now - this.drawnAt), 0);
  }

  private turnBy(azimuth: number, elevation: number): void {
    const { target } = this.controls;
    const place = new Spherical().setFromVector3(this.camera.position.clone().sub(target));
    place.theta += azimuth;
    place.phi = Math.min(Math.max(place.phi + elevation, 1e-4), Math.PI - 1e-4);
    this.camera.position.setFromSpherical(place).add(target);
    this.controls.update();
  }

  private moveTo(place: Place): void {
    this.turning = null;
    if (calm.matches || this.frames === 0) this.setPlace(place);
    else this.turning = { from: this.currentPlace(), to: place, since: 0 };
    this.draw();
  }

  private currentPlace(): Place {
    const { target } = this.controls;
    const offset = new Spherical().setFromVector3(this.camera.position.clone().sub(target));
    return { target: target.clone(), offset, zoom: this.orthographic.zoom };
  }

  private setPlace({ target, offset, zoom }: Place): void {
    this.controls.target.copy(target);
    this.camera.position.setFromSpherical(offset).add(target);
    this.orthographic.zoom = zoom;
    this.orthographic.updateProjectionMatrix();
    this.limit();
    this.controls.update();
    this.onMove();
  }

  /** The place from which the box of gamuts and axes just fits into the free part of the picture. */
  private fittedPlace(direction: Vector3, isTurning = this.spinning): Place {
    const { middle } = this;
    const [across, down] = this.freePart();
    const shift = this.shiftFor(direction);
    let [distance, size] = [0, 0];
    for (const [x, y, z] of this.corners(direction, isTurning ? AZIMUTHS : 1)) {
      // Half the height of a picture at the middle that has the corner at the end of the room.
      const flat = Math.max(Math.abs(x) / across, Math.abs(y) / down);
      const half = Math.max(Math.abs(x) / across, y > 0 ? y / (down + shift) : -y / (down - shift));
      distance = Math.max(distance, half / HALF_ANGLE + z);
      size = Math.max(size, flat);
    }
    return {
      target: middle.clone(),
      offset: new Spherical().setFromVector3(direction.clone().setLength(distance)),
      zoom: this.radius / size,
    };
  }

  /** Width and height of the free part of the picture, relative to the whole height. */
  private freePart(): [number, number] {
    const { height, width } = this;
    const { left, top, right, bottom } = this.margins();
    return [
      Math.max(LEAST_PART * width, width - left - right) / height,
      Math.max(LEAST_PART * height, height - top - bottom) / height,
    ];
  }

  /** Edges of the picture that are covered, or that labels need. */
  private margins(): Edges {
    const { axes, covered } = this;
    const room = (edge: keyof Edges) => covered[edge] + (axes === null ? PLAIN_ROOM : LABEL_ROOM[edge]);
    return { left: room("left"), top: room("top"), right: room("right"), bottom: room("bottom") };
  }

  /** Corners of the box to the right, up and towards the camera of a direction, at some azimuths. */
  private corners(direction: Vector3, azimuths: number): [number, number, number][] {
    const { min, max } = this.axes?.box ?? this.box;
    const up = new Vector3(0, 1, 0);
    return Array.from({ length: 8 * azimuths }, (_, i) => {
      const back = direction.clone().normalize().applyAxisAngle(up, (2 * Math.PI * (i >> 3)) / azimuths);
      const right = up.clone().cross(back).normalize();
      const point = new Vector3(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z).sub(this.middle);
      return [point.dot(right), point.dot(back.clone().cross(right)), point.dot(back)];
    });
  }

  /**
   * How far the picture is moved up so that the turning box is in its middle, relative to half the height.
   *
   * In perspective the near, lower end of the box is larger. It depends on the elevation only.
   */
  private shiftFor(direction: Vector3): number {
    if (this.camera === this.orthographic) return 0;
    const [, down] = this.freePart();
    const corners = this.corners(direction, AZIMUTHS);
    const distance = Math.max(...corners.map(([, y, z]) => Math.abs(y) / down / HALF_ANGLE + z));
    const heights = corners.map(([, y, z]) => y / (distance - z) / HALF_ANGLE);
    return (Math.max(...heights) + Math.min(...heights)) / 2;
  }

  /** Keep the camera out of the gamuts: the least distance from the target depends on the direction. */
  private limit(): void {
    const { controls, middle } = this;
    const target = controls.target.clone().sub(middle);
    const direction = this.camera.position.clone().sub(controls.target);
    const distance = direction.length();
    const along = target.dot(direction) / distance;
    const square = along ** 2 + (NEAREST * this.radius) ** 2 - target.lengthSq();
    controls.minDistance = Math.max(0, Math.sqrt(Math.max(0, square)) - along);
    if (this.camera === this.perspective && distance < 0.999 * controls.minDistance) controls.update();
  }

  /** Lower the resolution while successive pictures are slow; restore it at rest. */
  private adapt(interval: number): void {
    this.slow = interval > SLOW_PICTURE && interval < RESTING_MILLISECONDS ? this.slow + 1 : 0;
    if (this.slow >= SLOW_PICTURES) this.setResolution(LOW_RESOLUTION);
    clearTimeout(this.resting);
    if (this.resolution === 1) return;
    this.resting = setTimeout(() => {
      this.setResolution(1);
      this.drawNow();
    }, RESTING_MILLISECONDS);
  }

  private setResolution(resolution: number): void {
    if (resolution === this.resolution) return;
    this.resolution = resolution;
    this.setSize();
  }

  /** Set the number of pixels. Equal numbers are not set again: that costs as much as other ones. */
  private setSize(): void {
    const { canvas, height, renderer, width } = this;
    const ratio = this.resolution * Math.min(devicePixelRatio, 2);
    if (canvas.width === Math.floor(width * ratio) && canvas.height === Math.floor(height * ratio)) return;
    renderer.setDrawingBufferSize(width, height, ratio);
  }

  /** Half the height of the picture at the target. */
  private visibleSize(): number {
    if (this.camera === this.orthographic) return this.radius / this.orthographic.zoom;
    return this.camera.position.distanceTo(this.controls.target) * HALF_ANGLE;
  }

  /** Size of the picture relative to the fitted view from the same direction. */
  private get scale(): number {
    if (this.fitted !== null) return 1;
    const { offset, zoom } = this.fittedPlace(this.towardsCamera);
    if (this.camera === this.orthographic) return this.orthographic.zoom / zoom;
    return offset.radius / this.camera.position.distanceTo(this.controls.target);
  }

  /** Take the size of the stage. */
  private resize(): void {
    const { scale } = this;
    this.width = Math.max(1, this.stage.clientWidth);
    this.height = Math.max(1, this.stage.clientHeight);
    this.covered = coveredEdges(this.stage);
    this.refit(scale);
  }

  /** Fit the view again. One that the reader moved keeps its direction, and its size relative to the fitted one. */
  private refit(scale: number): void {
    const { controls, fitted, orthographic } = this;
    this.setSize();
    const place = this.fittedPlace(fitted === null || this.spinning ? this.towardsCamera : fitted);
    controls.maxDistance = place.offset.radius / SMALLEST;
    controls.minZoom = place.zoom * SMALLEST;
    controls.maxZoom = place.zoom * LARGEST;
    this.setFrame();
    if (this.turning !== null) this.turning.to = place;
    else if (fitted !== null) this.setPlace(place);
    else {
      if (this.camera === orthographic) orthographic.zoom = scale * place.zoom;
      this.camera.position.sub(controls.target).setLength(place.offset.radius / (this.camera === orthographic ? 1 : scale)).add(controls.target);
      this.limit();
      this.setFrame();
    }
    this.draw();
  }

  /** Set what the cameras see, with the target in the middle of the free part of the picture. */
  private setFrame(): void {
    const { height, orthographic, perspective, radius, width } = this;
    const aspect = width / height;
    perspective.aspect = aspect;
    perspective.near = radius / 100;
    perspective.far = radius * 100;
    orthographic.top = radius;
    orthographic.bottom = -radius;
    orthographic.right = radius * aspect;
    orthographic.left = -radius * aspect;
    orthographic.near = -radius * 100;
    orthographic.far = radius * 100;
    this.centre();
  }

  /** Show the box in the middle of the free part of the picture. */
  private centre(): void {
    const { camera, height, width } = this;
    const { left, top, right, bottom } = this.margins();
    const shift = this.shiftFor(camera.position.clone().sub(this.controls.target));
    const x = (right - left) / 2;
    const y = (bottom - top - shift * height) / 2;
    camera.setViewOffset(width, height, x, y, width, height);
  }
}

/** Widths of the edges of the stage that are covered by its elements with the attribute data-edge. */
function coveredEdges(stage: HTMLElement): Edges {
  const whole = stage.getBoundingClientRect();
  const covered = { ...NOTHING };
  for (const part of stage.querySelectorAll<HTMLElement>("[data-edge]")) {
    const box = part.getBoundingClientRect();
    if (box.width === 0 || box.height === 0) continue;
    if (part.dataset["edge"] === "top") covered.top = Math.max(covered.top, box.bottom - whole.top);
    else covered.right = Math.max(covered.right, whole.right - box.left);
  }
  return covered;
}

function between(from: Place, to: Place, part: number): Place {
  const mix = (one: number, other: number) => MathUtils.lerp(one, other, part);
  const angle = MathUtils.euclideanModulo(to.offset.theta - from.offset.theta + Math.PI, 2 * Math.PI) - Math.PI;
  return {
    target: from.target.clone().lerp(to.target, part),
    offset: new Spherical(
      mix(from.offset.radius, to.offset.radius),
      mix(from.offset.phi, to.offset.phi),
      from.offset.theta + part * angle,
    ),
    zoom: from.zoom * (to.zoom / from.zoom) ** part,
  };
}
