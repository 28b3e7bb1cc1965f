// A picture: the share of its pixels that a gamut cannot show, and the picture with them marked.
import { byId, element, problemElements } from "../page/elements.js";
import { withTerms } from "../page/glossary.js";
import { Latest } from "../page/latest.js";
import type { Page } from "../page/page.js";
import { request } from "../service/api.js";

/** ΔE00 of a step of the service's heat map. */
const STEP = 0.05;
/** Longest side of the shown picture in pixels: larger ones are measured whole and shown smaller. */
const MOST_SHOWN = 1600;
/** The mark is the colour that is rarest in photographs. */
const MARK = [255, 0, 255] as const;

interface Picture {
  file: File;
  /** What is shown, without marks; null if the browser cannot show the format. */
  image: ImageData | null;
  /** Steps of ΔE00 of all shown pixels, and how many pixels of the whole picture have each. */
  heat: Uint8ClampedArray;
  counts: number[];
  pixels: number;
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

  constructor(private readonly page: Page) {
    byId("picture-open").addEventListener("click", () => this.file.click());
    this.file.addEventListener("change", () => {
      const [file] = this.file.files ?? [];
      this.file.value = "";
      if (file === undefined) return;
      this.given = file;
      void this.ask();
    });
    this.target.addEventListener("change", () => {
      this.isChosen = true;
      void this.ask();
    });
    this.limit.addEventListener("input", () => this.draw());
    const large = byId<HTMLDialogElement>("picture-large");
    byId("picture-enlarge").addEventListener("click", () => large.showModal());
    page.on("gamuts", () => this.offer());
  }

  /** The gamuts that may be asked: the second one first, as a picture is compared with a device. */
  private offer(): void {
    const { shown } = this.page;
    const before = this.target.value;
    const ids = shown.map(({ gamut }) => gamut.id);
    this.target.replaceChildren(...shown.map(({ gamut }) => element("option", gamut.name, { value: gamut.id })));
    this.target.value = this.isChosen && ids.includes(before) ? before : (ids[1] ?? ids[0] ?? "");
    byId<HTMLButtonElement>("picture-open").disabled = ids.length === 0;
    if (this.target.value !== before && this.given !== null) void this.ask();
  }

  private async ask(): Promise<void> {
    const { given, target: { value: id } } = this;
    this.asking.end();
    this.picture = null;
    this.draw();
    byId("picture-problem").hidden = true;
    if (given === null || id === "") return;
    byId("picture-note").textContent = `${given.name} is compared …`;
    await this.asking.ask(
      async (signal) => {
        const answer = await request(`/v1/gamuts/${id}/map?method=clip-nearest&result=heat-map`, {
          method: "POST",
          body: given,
          signal,
          headers: { "Content-Type": "image/*", Accept: "image/png" },
        });
        return readPicture(given, await answer.blob());
      },
      (picture) => {
        this.picture = picture;
        this.draw();
      },
      (error) => {
        byId("picture-note").textContent = "";
        byId("picture-problem").replaceChildren(...problemElements(error));
        byId("picture-problem").hidden = false;
      },
    );
  }

  private draw(): void {
    const { picture } = this;
    byId("picture-view").hidden = picture?.image == null;
    byId("picture-limit-row").hidden = picture === null;
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
      `ΔE00 ${this.limit.value}; ${share(all)} by any amount.`;
    byId("picture-note").replaceChildren(...withTerms(said));
    if (picture.image === null) return;
    const { width, height, data } = picture.image;
    const marked = new ImageData(new Uint8ClampedArray(data), width, height);
    for (let i = 0; i < picture.heat.length; i++) {
      if (picture.heat[i]! > least) marked.data.set(MARK, 4 * i);
    }
    for (const id of ["picture-canvas", "picture-large-canvas"]) {
      const canvas = byId<HTMLCanvasElement>(id);
      Object.assign(canvas, { width, height });
      canvas.getContext("2d")!.putImageData(marked, 0, 0);
      canvas.setAttribute("aria-label", byId("picture-note").textContent);
    }
  }
}

/** The picture as it is shown, with its heat map. */
async function readPicture(file: File, heatFile: Blob): Promise<Picture> {
  const whole = await createImageBitmap(heatFile, { colorSpaceConversion: "none" });
  const { width, height } = whole;
  const counts = new Array<number>(256).fill(0);
  const steps = greys(whole, width, height);
  for (const step of steps) counts[step]! += 1;
  const scale = Math.min(1, MOST_SHOWN / Math.max(width, height));
  const size = [Math.max(1, Math.round(scale * width)), Math.max(1, Math.round(scale * height))] as const;
  const heat = scale === 1 ? steps : greys(whole, ...size);
  // The heat map has the turn of the stored pixels, so that of the metadata is left out as well.
  const shown = await createImageBitmap(file, { imageOrientation: "none" as ImageOrientation }).catch(() => null);
  const context = new OffscreenCanvas(...size).getContext("2d")!;
  if (shown !== null) context.drawImage(shown, 0, 0, ...size);
  return { file, image: shown && context.getImageData(0, 0, ...size), heat, counts, pixels: width * height };
}

function greys(picture: ImageBitmap, width: number, height: number): Uint8ClampedArray {
  const context = new OffscreenCanvas(width, height).getContext("2d")!;
  context.imageSmoothingEnabled = false; // a mean of steps is no step of any pixel
  context.drawImage(picture, 0, 0, width, height);
  const { data } = context.getImageData(0, 0, width, height);
  return Uint8ClampedArray.from({ length: width * height }, (_, i) => data[4 * i]!);
}
