// Files of the reader: dropped or chosen, built with the options of the page, with progress.
import { ProblemError, build, cancelJob, useKey } from "../service/api.js";
import { BuildOptions } from "./build_options.js";
import { byId } from "./elements.js";
import type { Page } from "./page.js";

export class Uploads {
  private readonly options = new BuildOptions(() => {
    if (this.kept !== undefined) void this.upload(this.kept);
  });
  /** Files of gamuts that were built on this page, by id, and the file whose build failed last. */
  private readonly files = new Map<string, File>();
  private failed: File | undefined;
  private uploading: AbortController | null = null;
  private job = "";

  constructor(private readonly page: Page) {
    const input = byId<HTMLInputElement>("file");
    byId("upload").addEventListener("click", () => {
      if (this.options.chosen() !== null) input.click();
    });
    input.addEventListener("change", () => {
      const [file] = input.files ?? [];
      input.value = "";
      if (file !== undefined) void this.upload(file);
    });
    this.connectDrop();
    byId("cancel").addEventListener("click", () => {
      cancelJob(this.job).catch((error: unknown) => page.complain(error));
    });
    byId<HTMLInputElement>("key").addEventListener("change", (event) => {
      useKey((event.target as HTMLInputElement).value.trim());
      page.complain(null);
      void page.restore();
    });
    page.onProgress = (stage, fraction, job) => this.show(stage, fraction, job);
    page.on("gamuts", () => this.options.offer(this.kept, page.at("a")?.gamut.name));
  }

  /** The file that can be built again. */
  private get kept(): File | undefined {
    return this.failed ?? this.files.get(this.page.at("a")?.gamut.id ?? "");
  }

  private show(stage: string, fraction: number, job: string): void {
    this.job = job;
    byId("job").hidden = stage === "" && this.uploading === null;
    if (stage === "") return;
    byId("stage-name").textContent = `Building: ${stage}`;
    byId<HTMLProgressElement>("progress").value = fraction;
    byId<HTMLButtonElement>("cancel").disabled = job === "";
    this.page.announce(`Building: ${stage}`);
  }

  private async upload(file: File): Promise<void> {
    const { page } = this;
    const options = this.options.chosen();
    if (options === null) return;
    this.uploading?.abort();
    this.failed = undefined;
    const uploading = new AbortController();
    this.uploading = uploading;
    page.complain(null);
    try {
      const id = await build(file, options, page.onProgress, uploading.signal);
      if (uploading.signal.aborted) return;
      this.files.set(id, file);
      await page.show("a", id);
      page.announce(`${file.name} is shown`);
    } catch (error) {
      if (uploading.signal.aborted) return;
      page.complain(error);
      if (!(error instanceof ProblemError)) return;
      this.failed = file;
      this.options.offer(file, undefined);
      if (error.problem.code === "invalid-option") this.options.open();
    } finally {
      if (this.uploading === uploading) {
        this.uploading = null;
        byId("job").hidden = true;
      }
    }
  }

  private connectDrop(): void {
    const drop = byId("drop");
    let depth = 0;
    addEventListener("dragenter", (event) => {
      if (!event.dataTransfer?.types.includes("Files")) return;
      depth += 1;
      drop.hidden = false;
    });
    addEventListener("dragleave", () => {
      depth = Math.max(0, depth - 1);
      drop.hidden = depth === 0;
    });
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", (event) => {
      event.preventDefault();
      depth = 0;
      drop.hidden = true;
      const [file] = event.dataTransfer?.files ?? [];
      if (file !== undefined) void this.upload(file);
    });
  }
}
