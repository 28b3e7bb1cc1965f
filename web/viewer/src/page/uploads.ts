// Files of the reader: dropped or chosen, built in a slot, and built again with other options. Pictures
// and lists of colours that are dropped may be checked against a gamut instead.
import { ProblemError, build, cancelJob, useKey } from "../service/api.js";
import { BuildOptions, type Chosen, optionsOf } from "./build_options.js";
import { byId } from "./elements.js";
import type { Latest } from "./latest.js";
import type { Page } from "./page.js";
import { SLOTS, type Slot } from "./slots.js";

interface Upload {
  file: File;
  options: Chosen;
  /** What the slot showed when the service refused the file. */
  refused?: string | undefined;
  isRefused: boolean;
}

/** A part of the page that checks files against a gamut. */
export interface FileCheck {
  /** Name of the gamut; null if none is shown. */
  readonly against: string | null;
  take(file: File): void;
}

/** What dropped files can be, as far as the browser tells before the drop. */
type Kind = "colours" | "picture";

const KINDS: [Kind, RegExp][] = [
  ["picture", /^image\//],
  ["colours", /^text\/(csv|plain|tab-separated-values)$|application\/vnd.ms-excel/],
];

export class Uploads {
  private readonly options = new BuildOptions((slot, chosen) => void this.change(slot, chosen));
  /** Builds under way or refused, by what `Page.building` has for their slots. */
  private readonly uploads = new Map<Latest, Upload>();
  /** What the next chosen file is for. */
  private purpose: { slot: Slot; options: Chosen } | null = null;

  constructor(
    private readonly page: Page,
    private readonly checks: Record<Kind, FileCheck>,
  ) {
    const input = byId<HTMLInputElement>("file");
    byId("upload").addEventListener("click", () => {
      this.purpose = null;
      input.click();
    });
    input.addEventListener("change", () => {
      const files = [...(input.files ?? [])];
      input.value = "";
      if (this.purpose !== null && files[0] !== undefined) void this.upload(files[0], this.purpose.slot, this.purpose.options);
      else this.take(files, files.length === 1 ? this.free : "a");
    });
    this.connectDrop();
    byId<HTMLInputElement>("key").addEventListener("change", (event) => {
      useKey((event.target as HTMLInputElement).value.trim());
      page.complain(null);
      void page.restore();
    });
    page.on(["slots", "requests"], () => this.refresh());
  }

  /** The first empty row of the list, else the first one. Examples of the first screen count as empty. */
  private get free(): Slot {
    const rows = [...document.querySelectorAll<HTMLElement>(".gamut-row:not([hidden])")].map(({ dataset }) => dataset["slot"] as Slot);
    return rows.find((slot) => (this.page.at(slot) === null || this.page.isTrial) && !this.isBusy(slot)) ?? "a";
  }

  private isBusy(slot: Slot): boolean {
    return this.of(slot)?.isRefused === false;
  }

  private of(slot: Slot): Upload | undefined {
    return this.uploads.get(this.page.building[slot]);
  }

  private refresh(): void {
    for (const slot of SLOTS) {
      const gamut = this.page.at(slot)?.gamut;
      const upload = this.of(slot);
      if (upload?.isRefused && upload.refused !== gamut?.id) this.uploads.delete(this.page.building[slot]);
      this.options.state(slot, gamut === undefined ? null : optionsOf(gamut), this.of(slot)?.options ?? null);
    }
  }

  /** Build files, the first one in a slot and the others in the slots after it. */
  private take(files: File[], first: Slot): void {
    const slots = SLOTS.slice(SLOTS.indexOf(first));
    files.slice(0, slots.length).forEach((file, place) => void this.upload(file, slots[place]!, this.options.chosen));
    if (files.length > slots.length) this.page.board.note(`The page shows ${SLOTS.length} gamuts; the other files are left out.`);
  }

  /** Build the gamut of a slot with other options; its file is asked for if the page does not have it. */
  private async change(slot: Slot, options: Chosen): Promise<void> {
    const { page } = this;
    const gamut = page.at(slot)?.gamut;
    const known = this.of(slot)?.file ?? page.files.get(gamut?.id ?? "");
    const building = page.building[slot];
    await building.ask(
      async () => known ?? page.sourceOf(slot),
      (file) => {
        const slug = gamut?.provenance.reference;
        if (file !== null) void this.upload(file, slot, options);
        else if (slug !== undefined) void page.show(slot, `${slug}?${new URLSearchParams({ intent: options.intent, space: options.space })}`);
        else {
          this.purpose = { slot, options };
          page.board.note(`Choose the file of ${gamut?.name ?? "the gamut"} again: it is built with the new options.`);
          byId("file").click();
        }
      },
      (error) => page.complain(error),
    );
  }

  private async upload(file: File, slot: Slot, options: Chosen): Promise<void> {
    const { page } = this;
    const building = page.building[slot];
    building.end();
    const upload: Upload = { file, options, isRefused: false };
    this.uploads.set(building, upload);
    page.complain(null);
    page.emit("requests");
    await building.ask(
      (signal) => {
        const work = page.board.begin(file.name, slot, (job) => {
          if (job !== "") cancelJob(job).catch(() => {}); // the build may have ended meanwhile
          building.end();
        });
        signal.addEventListener("abort", () => {
          work.end();
          this.uploads.delete(building);
          this.refresh();
        });
        return build(file, options, work.report, signal).finally(() => work.end());
      },
      (id) => {
        page.files.set(id, file);
        this.uploads.delete(building);
        void this.show(slot, id, file.name);
      },
      (error) => {
        page.complain(error, file.name);
        // The file of a refused build is kept, and its options can be changed.
        upload.isRefused = error instanceof ProblemError;
        upload.refused = page.at(slot)?.gamut.id;
        if (!upload.isRefused) this.uploads.delete(building);
        this.refresh();
        if (error instanceof ProblemError && error.problem.code === "invalid-option") this.options.open(slot);
      },
    );
  }

  private async show(slot: Slot, id: string, name: string): Promise<void> {
    await this.page.show(slot, id);
    if (this.page.at(slot)?.key === id) this.page.announce(`${name} is shown`);
  }

  private connectDrop(): void {
    const drop = byId("drop");
    let depth = 0;
    let row: HTMLElement | null = null;
    const text = drop.querySelector("p")!;
    const targets = { check: byId("drop-check"), build: byId("drop-build") };
    /** How the files are checked, if they may be. */
    let check: FileCheck | null = null;
    let target: Element | null = null;
    /** Offer what fits the files. Their names and contents are known after the drop only. */
    const offer = ({ dataTransfer }: DragEvent) => {
      const types = [...(dataTransfer?.items ?? [])].map(({ type }) => type);
      const kind = KINDS.find(([, form]) => types.length === 1 && form.test(types[0]!))?.[0];
      check = kind === undefined || this.checks[kind].against === null ? null : this.checks[kind];
      text.hidden = check !== null;
      targets.check.hidden = targets.build.hidden = check === null;
      targets.check.textContent = check === null ? "" : `Check against ${check.against}`;
    };
    const aim = (aimed: EventTarget | null) => {
      row?.classList.remove("aimed");
      target?.classList.remove("aimed");
      row = aimed instanceof Element ? aimed.closest<HTMLElement>(".gamut-row") : null;
      target = aimed instanceof Element ? aimed.closest(".drop-target") : null;
      row?.classList.add("aimed");
      target?.classList.add("aimed");
      const name = row?.querySelector("label")?.textContent.toLowerCase();
      text.textContent = name ? `Drop to build the ${name}` : "Drop to build the first gamut; more files become the next ones";
    };
    const hasFiles = ({ dataTransfer }: DragEvent) => dataTransfer?.types.includes("Files") ?? false;
    const leave = () => {
      depth = 0;
      drop.hidden = true;
      row?.classList.remove("aimed");
      target?.classList.remove("aimed");
    };
    addEventListener("dragenter", (event) => {
      if (!hasFiles(event)) return;
      depth += 1;
      if (drop.hidden) offer(event);
      drop.hidden = false;
      aim(event.target);
    });
    addEventListener("dragleave", () => {
      depth -= 1;
      if (depth <= 0) leave();
    });
    // Text can be dropped into the fields of the page, as anywhere.
    addEventListener("dragover", (event) => hasFiles(event) && event.preventDefault());
    addEventListener("drop", (event) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      aim(event.target);
      leave();
      const files = [...(event.dataTransfer?.files ?? [])];
      if (target === targets.check && check !== null && files[0] !== undefined) return check.take(files[0]);
      this.take(files, (row?.dataset["slot"] as Slot | undefined) ?? "a");
    });
  }
}
