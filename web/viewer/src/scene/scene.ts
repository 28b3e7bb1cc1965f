// The 3-D view: cameras, turning, views along the axes, drawing on demand, and pictures.
import {
  Color,
  type Object3D,
  OrthographicCamera,
  PerspectiveCamera,
  Raycaster,
  type Intersection,
  SRGBColorSpace,
  Scene,
  Spherical,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { SCREEN } from "../colours/colours.js";

const FIELD_OF_VIEW = 30;
const HALF_ANGLE = Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
/** Pictures that take longer than this, in ms, are drawn with fewer pixels while things move. */
const SLOW_PICTURE = 20;
const SLOW_PICTURES = 2;
/** One step: each change of the number of pixels waits for the graphics processor. */
const LOW_RESOLUTION = 0.35;
const RESTING_MILLISECONDS = 250;
/** Half the height of the start view, relative to the radius of what is shown. */
const FILLING = 1.06;
/** Direction of the start view: from the front right, slightly above. */
const HOME = new Vector3(0.55, 0.42, 1);

export type Projection = "perspective" | "orthographic";

export class View {
  readonly scene = new Scene();
  readonly renderer: WebGLRenderer;
  private readonly perspective = new PerspectiveCamera(FIELD_OF_VIEW);
  private readonly orthographic = new OrthographicCamera();
  private readonly controls: OrbitControls;
  private readonly raycaster = new Raycaster();
  private readonly middle = new Vector3();
  private radius = 100;
  private waiting = 0;
  private resolution = 1;
  private drawnAt = 0;
  /** Number of slow pictures one after the other. */
  private slow = 0;
  private resting = 0;
  /** Number of pictures that were drawn. */
  frames = 0;
  /** Called after the camera moved. */
  onMove: () => void = () => {};

  constructor(
    readonly canvas: HTMLCanvasElement,
    private readonly stage: HTMLElement,
  ) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true });
    this.renderer.outputColorSpace = SRGBColorSpace;
    // Vertex colours are linear RGB of the screen, and both screens have the same curve.
    const buffer = this.renderer.getContext();
    if ("drawingBufferColorSpace" in buffer) buffer.drawingBufferColorSpace = SCREEN;
    // The check waits for the compilation of each shader.
    this.renderer.debug.checkShaderErrors = false;
    this.controls = new OrbitControls(this.perspective, canvas);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", () => {
      this.onMove();
      this.draw();
    });
    new ResizeObserver(() => this.resize()).observe(stage);
    this.resize();
    this.home();
  }

  get projection(): Projection {
    return this.camera === this.perspective ? "perspective" : "orthographic";
  }

  get camera(): PerspectiveCamera | OrthographicCamera {
    return this.controls.object as PerspectiveCamera | OrthographicCamera;
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

  /** Set what the views show: the middle and the radius of all gamuts. */
  setExtent(middle: Vector3, radius: number): void {
    const factor = radius / this.radius;
    const offset = this.camera.position.clone().sub(this.controls.target);
    this.middle.copy(middle);
    this.radius = radius;
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).add(offset.multiplyScalar(factor));
    this.resize();
    this.controls.update();
  }

  home(): void {
    this.lookAlong(HOME);
  }

  /** Look at the middle from a direction. */
  lookAlong(direction: Vector3): void {
    this.controls.target.copy(this.middle);
    const distance = (FILLING * this.radius) / HALF_ANGLE / Math.min(1, this.aspect);
    this.camera.position.copy(this.middle).add(direction.clone().setLength(distance));
    this.orthographic.zoom = Math.min(1, this.aspect) / FILLING;
    this.resize();
    this.controls.update();
    this.onMove();
    this.draw();
  }

  /** Turn around the target by angles in radians. */
  turn(azimuth: number, elevation: number): void {
    const { target } = this.controls;
    const place = new Spherical().setFromVector3(this.camera.position.clone().sub(target));
    place.theta += azimuth;
    place.phi = Math.min(Math.max(place.phi + elevation, 1e-4), Math.PI - 1e-4);
    this.camera.position.setFromSpherical(place).add(target);
    this.controls.update();
  }

  /** Change the size of the picture by a factor. */
  enlarge(factor: number): void {
    if (this.camera === this.orthographic) {
      this.orthographic.zoom *= factor;
      this.orthographic.updateProjectionMatrix();
    } else {
      const { target } = this.controls;
      this.camera.position.sub(target).divideScalar(factor).add(target);
    }
    this.controls.update();
    this.onMove();
    this.draw();
  }

  /** Numbers that `restore` takes: position, target and zoom, relative to the extent. */
  get place(): number[] {
    const relative = (point: Vector3) =>
      point.clone().sub(this.middle).divideScalar(this.radius).toArray();
    const numbers = [...relative(this.camera.position), ...relative(this.controls.target), this.camera.zoom];
    return numbers.map((value) => Number(value.toPrecision(4)));
  }

  restore(place: number[]): void {
    if (place.length !== 7 || !place.every(Number.isFinite) || place[6]! <= 0) return;
    const absolute = (at: number) =>
      new Vector3().fromArray(place, at).multiplyScalar(this.radius).add(this.middle);
    this.camera.position.copy(absolute(0));
    this.controls.target.copy(absolute(3));
    this.camera.zoom = place[6]!;
    this.resize();
    this.controls.update();
    this.draw();
  }

  /** Draw before the next picture of the screen. */
  draw(): void {
    if (this.waiting !== 0) return;
    this.waiting = requestAnimationFrame((now) => {
      this.waiting = 0;
      this.adapt(now - this.drawnAt);
      this.drawnAt = now;
      this.drawNow();
    });
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
    const { canvas, renderer, stage } = this;
    const ratio = this.resolution * Math.min(devicePixelRatio, 2);
    const { clientWidth: width, clientHeight: height } = stage;
    if (canvas.width === Math.floor(width * ratio) && canvas.height === Math.floor(height * ratio)) return;
    renderer.setDrawingBufferSize(width, height, ratio);
  }

  /** The nearest surface at a point of the page. */
  pick(clientX: number, clientY: number, objects: Object3D[]): Intersection | null {
    const box = this.canvas.getBoundingClientRect();
    const place = new Vector2(
      (2 * (clientX - box.left)) / box.width - 1,
      1 - (2 * (clientY - box.top)) / box.height,
    );
    this.raycaster.setFromCamera(place, this.camera);
    return this.raycaster.intersectObjects(objects, false)[0] ?? null;
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
    this.scene.background = new Color(getComputedStyle(this.stage).backgroundColor);
    this.renderer.render(this.scene, this.camera);
    this.frames += 1;
  }

  private get aspect(): number {
    return this.stage.clientWidth / Math.max(1, this.stage.clientHeight);
  }

  /** Half the height of the picture at the target. */
  private visibleSize(): number {
    if (this.camera === this.orthographic) return this.radius / this.orthographic.zoom;
    return this.camera.position.distanceTo(this.controls.target) * HALF_ANGLE;
  }

  private resize(): void {
    const { aspect, orthographic, perspective, radius } = this;
    this.setSize();
    perspective.aspect = aspect;
    perspective.near = radius / 100;
    perspective.far = radius * 100;
    perspective.updateProjectionMatrix();
    orthographic.top = radius;
    orthographic.bottom = -radius;
    orthographic.right = radius * aspect;
    orthographic.left = -radius * aspect;
    orthographic.near = -radius * 100;
    orthographic.far = radius * 100;
    orthographic.updateProjectionMatrix();
    this.draw();
  }
}
