// A picture: the share of its pixels that a gamut cannot show, a map of how far they are out of reach,
// and the picture as the gamut shows it.
import { byId, element, problemElements } from "../page/elements.js";
import { withTerms } from "../page/glossary.js";
import { Latest } from "../page/latest.js";
import type { Page } from "../page/page.js";
import { reveal } from "../page/parts.js";
import { request } from "../service/api.js";

/** ΔE00 of a step of the service's heat map. */
const STEP = 0.05;
/** Longest side of the shown picture in pixels: larger ones are measured whole and shown smaller. */
const MOST_SHOWN = 1600;
/**
 * Colours of the map by ΔE00, from just visible to another colour. Their lightness falls, so that
 * readers with any colour vision see the order.
 */
const RAMP = [
  [0, 255, 236, 110],
  [3, 255, 160, 20],
  [6, 226, 40, 50],
  [12, 90, 0, 110],
] as const;
/** Colours in reach are grey and pale in the map: the part of white in them. */
const PALE = 0.45;

const COMPENSATED = " Printed, black is the black of the gamut (black-point compensation).";

type Look = "map" | "original" | "printed";

interface Picture {
  file: File;
  /** What is shown, without marks: the printed picture if the browser cannot draw the original. */
  image: ImageData;
  hasOriginal: boolean;
  /** Steps of ΔE00 of all shown pixels, and how many pixels of the whole picture have each. */
  heat: Uint8ClampedArray;
  counts: number[];
  pixels: number;
  /** The picture as the gamut shows it; null until it is asked for. */
  printed: ImageData | null;
}

export class PicturePanel {
  private readonly file = byId<HTMLInputElement>("picture-file");
  private readonly target = byId<HTMLSelectElement>("picture-gamut");
  private readonly limit = byId<HTMLInputElement>("picture-limit");
  /** Whether the reader chose the gamut. */
  private isChosen = false;
  private given: File | null = null;
  private picture: Picture | null = null;
  private readonly asking = new Latest();
  private readonly printing = new Latest();

  constructor(private readonly page: Page) {
    byId("picture-open").addEventListener("click", () => this.file.click());
    this.file.addEventListener("change", () => {
      const [file] = this.file.files ?? [];
      this.file.value = "";
      if (file === undefined) return;
      this.take(file);
    });
    this.target.addEventListener("change", () => {
      this.isChosen = true;
      void this.ask();
    });
    this.limit.addEventListener("input", () => this.draw());
    byId("picture-look").addEventListener("change", () => this.draw());
    byId("picture-legend").append(
      ...RAMP.map(([difference], place) => element("span", `${difference}${place === RAMP.length - 1 ? "+" : ""}`)),
    );
    byId("picture-ramp").style.background = `linear-gradient(to right, ${RAMP.map(([at, ...colour]) => `rgb(${colour.join(" ")}) ${(100 * at) / RAMP.at(-1)![0]}%`).join(", ")})`;
    const large = byId<HTMLDialogElement>("picture-large");
    byId("picture-enlarge").addEventListener("click", () => large.showModal());
    page.on(["slots"], () => this.offer());
  }

  /** The gamut that pictures are checked against. */
  get against(): string | null {
    return this.target.selectedOptions[0]?.text ?? null;
  }

  /** Check a file, as if it were opened. */
  take(file: File): void {
    reveal("picture");
    this.given = file;
    void this.ask();
  }

  /** The gamuts that may be asked: the smallest one first, which is the press beside a screen. */
  private offer(): void {
    const { shown } = this.page;
    const before = this.target.value;
    const ids = shown.map(({ gamut }) => gamut.id);
    this.target.replaceChildren(...shown.map(({ gamut }) => element("option", gamut.name, { value: gamut.id })));
    const [smallest] = [...shown].sort((one, other) => one.gamut.volume - other.gamut.volume);
    this.target.value = this.isChosen && ids.includes(before) ? before : (smallest?.gamut.id ?? "");
    byId<HTMLButtonElement>("picture-open").disabled = ids.length === 0;
    if (this.target.value !== before && this.given !== null) void this.ask();
  }

  private async ask(): Promise<void> {
    const { given, target: { value: id } } = this;
    this.asking.end();
    this.printing.end();
    this.picture = null;
    this.draw();
    byId("picture-problem").hidden = true;
    if (given === null || id === "") return;
    byId("picture-note").textContent = `${given.name} is compared …`;
    await this.asking.ask(
      async (signal) => {
        const answer = await mapped(id, given, "heat-map", signal);
        return readPicture(given, await answer.blob(), async () => (await mapped(id, given, "picture", signal)).blob());
      },
      (picture) => {
        this.picture = picture;
        this.draw();
      },
      (error) => {
        byId("picture-note").textContent = "";
        this.refuse(given, error);
      },
    );
  }

  private refuse(file: File, error: unknown): void {
    byId("picture-problem").replaceChildren(...problemElements(error, file.name));
    byId("picture-problem").hidden = false;
  }

  private get look(): Look {
    return document.querySelector<HTMLInputElement>("#picture-look :checked")!.value as Look;
  }

  /** Ask for the picture as the gamut shows it. */
  private async print(picture: Picture): Promise<void> {
    if (this.printing.isAsking) return;
    const { width, height } = picture.image;
    await this.printing.ask(
      async (signal) => readImage(await (await mapped(this.target.value, picture.file, "picture", signal)).blob(), width, height),
      (image) => {
        picture.printed = image;
        this.draw();
      },
      (error) => this.refuse(picture.file, error),
    );
  }

  private draw(): void {
    const { picture } = this;
    const original = document.querySelector<HTMLInputElement>("#picture-look [value=original]")!;
    original.parentElement!.hidden = picture?.hasOriginal === false;
    const isMap = this.look === "map";
    byId("picture-view").hidden = byId("picture-look").hidden = picture === null;
    byId("picture-limit-row").hidden = byId("picture-legend-box").hidden = picture === null || !isMap;
    if (picture === null) {
      byId("picture-note").textContent = "";
      return;
    }
    const least = Number(this.limit.value) / STEP;
    byId("picture-limit-text").textContent = `ΔE00 over ${this.limit.value}`;
    const beyond = picture.counts.reduce((sum, count, step) => (step > least ? sum + count : sum), 0);
    const all = picture.counts.reduce((sum, count, step) => (step > 0 ? sum + count : sum), 0);
    const share = (count: number) => `${((100 * count) / picture.pixels).toFixed(1)} %`;
    const name = this.target.selectedOptions[0]?.text ?? "";
    const said =
      `${share(beyond)} of the pixels of ${picture.file.name} are out of reach of ${name} by more than ` +
      `ΔE00 ${this.limit.value}; ${share(all)} by any amount.` +
      (this.page.shown.find(({ gamut }) => gamut.id === this.target.value)?.gamut.provenance.intent === "absolute" ? "" : COMPENSATED);
    byId("picture-note").replaceChildren(...withTerms(said));
    const { width, height } = picture.image;
    const { look } = this;
    const { printed } = picture;
    const isWaiting = look === "printed" && printed === null;
    byId("picture-view").setAttribute("aria-busy", String(isWaiting));
    if (isWaiting) void this.print(picture);
    const shown = look === "map" ? mapOf(picture.image, picture.heat, least) : look === "printed" && printed !== null ? printed : picture.image;
    for (const id of ["picture-canvas", "picture-large-canvas"]) {
      const canvas = byId<HTMLCanvasElement>(id);
      Object.assign(canvas, { width, height });
      canvas.getContext("2d")!.putImageData(shown, 0, 0);
      canvas.setAttribute("aria-label", byId("picture-note").textContent);
    }
  }
}

/** The picture as it is shown, with its heat map. */
async function readPicture(file: File, heatFile: Blob, print: () => Promise<Blob>): Promise<Picture> {
  const whole = await createImageBitmap(heatFile, { colorSpaceConversion: "none" });
  const { width, height } = whole;
  const counts = new Array<number>(256).fill(0);
  const steps = greys(whole, width, height);
  for (const step of steps) counts[step]! += 1;
  const scale = Math.min(1, MOST_SHOWN / Math.max(width, height));
  const size = [Math.max(1, Math.round(scale * width)), Math.max(1, Math.round(scale * height))] as const;
  const heat = scale === 1 ? steps : greys(whole, ...size);
  const original = await readImage(file, ...size).catch(() => null);
  // Browsers draw no TIFF and no OpenEXR. The service's answers are PNG.
  const printed = original === null ? await readImage(await print(), ...size) : null;
  return { file, image: (original ?? printed)!, hasOriginal: original !== null, heat, counts, pixels: width * height, printed };
}

async function readImage(file: Blob, width: number, height: number): Promise<ImageData> {
  // The heat map has the turn of the stored pixels, so that of the metadata is left out as well.
  const picture = await createImageBitmap(file, { imageOrientation: "none" as ImageOrientation });
  const context = new OffscreenCanvas(width, height).getContext("2d")!;
  context.drawImage(picture, 0, 0, width, height);
  return context.getImageData(0, 0, width, height);
}

/** A picture mapped into a gamut, or how much that changes it. */
function mapped(id: string, picture: File, result: "picture" | "heat-map", signal: AbortSignal): Promise<Response> {
  // Compensation moves colours that are in reach as well.
  const compensated = result === "heat-map" ? "&black_point_compensation=false" : "";
  // PNG has no floats, which other formats may have.
  const depth = /jpeg|png/.test(picture.type) ? "" : "&depth=16";
  return request(`/v1/gamuts/${id}/map?method=clip-nearest&result=${result}${compensated}${depth}`, {
    method: "POST",
    body: picture,
    signal,
    headers: { "Content-Type": "image/*", Accept: "image/png" },
  });
}

/** The picture in pale grey, with a colour of the ramp where the step is over the limit. */
function mapOf({ width, height, data }: ImageData, heat: Uint8ClampedArray, least: number): ImageData {
  const map = new ImageData(width, height);
  const ramp = Array.from({ length: 256 }, (_, step) => rampColour(STEP * step));
  for (let i = 0; i < heat.length; i++) {
    const at = 4 * i;
    const grey = 0.2126 * data[at]! + 0.7152 * data[at + 1]! + 0.0722 * data[at + 2]!;
    const pale = PALE * 255 + (1 - PALE) * grey;
    map.data.set(heat[i]! > least ? ramp[heat[i]!]! : [pale, pale, pale], at);
    map.data[at + 3] = data[at + 3]!;
  }
  return map;
}

function rampColour(difference: number): number[] {
  const end = RAMP.findIndex(([at], place) => place > 0 && (at >= difference || place === RAMP.length - 1));
  const [from, ...low] = RAMP[end - 1]!;
  const [to, ...high] = RAMP[end]!;
  const part = Math.min(1, (difference - from) / (to - from));
  return low.map((value, i) => value + part * (high[i]! - value));
}

function greys(picture: ImageBitmap, width: number, height: number): Uint8ClampedArray {
  const context = new OffscreenCanvas(width, height).getContext("2d")!;
  context.imageSmoothingEnabled = false; // a mean of steps is no step of any pixel
  context.drawImage(picture, 0, 0, width, height);
  const { data } = context.getImageData(0, 0, width, height);
  return Uint8ClampedArray.from({ length: width * height }, (_, i) => data[4 * i]!);
}
