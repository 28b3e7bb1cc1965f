// What the reader waits for, in the row of its gamut: its name, the stage in plain words, seconds and
// a bar. Notes that are no faults stand at the lower edge of the stage.
import { type Progress, preparation } from "../service/api.js";
import { byId, element } from "./elements.js";
import type { Slot } from "./slots.js";

/** Stages of a build in plain words, with the part of the whole time at which each begins. */
const STAGES: Record<string, [words: string, begin: number]> = {
  upload: ["Sending the file", 0],
  waiting: ["Waiting for its turn", 0.05],
  characterisation: ["Reading the data", 0.06],
  colours: ["Computing colours", 0.1],
  boundary: ["Finding the surface", 0.3],
  decimation: ["Making all levels of detail", 0.45],
  metric: ["Measuring the levels", 0.85],
  encoding: ["Storing the result", 0.96],
};
/** Milliseconds in a queue after which the service is asked what it is doing. */
const PATIENCE = 1000;
const NOTE_MILLISECONDS = 6000;

/** One thing that is waited for. It is shown from its first report on. */
export class Work {
  /** Take a stage, the completed fraction of the stage, and the id of the job. */
  readonly report: Progress = (stage, fraction, job) => {
    this.job = job;
    const next = STAGES[stage] ?? [stage, 0];
    if (!this.box.isConnected) {
      this.row.querySelector(".waiting")!.append(this.box);
      this.row.hidden = false;
    }
    if (stage !== this.stage) {
      this.stage = stage;
      this.entered = Date.now();
      this.words = next[0];
      this.board.announce(`${this.name}: ${this.words}`);
    }
    const ends = Object.values(STAGES).map(([, begin]) => begin);
    const end = ends.find((begin) => begin > next[1]) ?? 1;
    this.bar.value = next[1] + (end - next[1]) * fraction;
    this.percent = stage === "upload" ? ` ${Math.round(100 * fraction)} %` : "";
    this.isWaiting = stage === "waiting" || (stage === "upload" && fraction === 1);
    this.tell();
  };
  job = "";
  private readonly box: HTMLElement;
  private readonly row: HTMLElement;
  private readonly line = element("span");
  private readonly bar = element("progress", "", { max: 1 });
  private readonly clock = setInterval(() => this.tick(), 500);
  private readonly begun = Date.now();
  private stage = "";
  private words = "";
  private percent = "";
  /** Whether it is the turn of the service, which may have to get ready first. */
  private isWaiting = false;
  private entered = 0;

  /** Without `cancel` it is prepared in the background. */
  constructor(
    private readonly board: Board,
    private readonly name: string,
    slot: Slot,
    cancel: ((job: string) => void) | null,
  ) {
    this.row = document.querySelector<HTMLElement>(`.gamut-row[data-slot="${slot}"]`)!;
    this.box = element("div", "", { className: "work" });
    this.bar.setAttribute("aria-label", `Progress of ${name}`);
    if (cancel === null) {
      this.box.append(element("strong", name), this.line, this.bar);
      return;
    }
    const button = element("button", "Cancel", { type: "button", className: "cancel" });
    button.setAttribute("aria-label", `Cancel ${name}`);
    button.addEventListener("click", () => {
      cancel(this.job);
      this.end();
      board.note(`${name} was cancelled.`);
    });
    this.box.append(element("strong", name), button, this.line, this.bar);
  }

  end(): void {
    clearInterval(this.clock);
    this.box.remove();
  }

  private tick(): void {
    if (this.stage === "") return;
    this.tell();
    if (!this.isWaiting || Date.now() - this.entered < PATIENCE) return;
    void preparation().then((text) => {
      if (!this.isWaiting) return;
      this.words = text ?? STAGES["waiting"]![0];
      const [, done, all] = /(\d+) of (\d+) kernels/.exec(this.words) ?? [];
      if (all !== undefined) this.bar.value = Number(done) / Number(all);
      this.percent = "";
    });
  }

  private tell(): void {
    const seconds = Math.floor((Date.now() - this.begun) / 1000);
    this.line.textContent = `${this.words}${this.percent} · ${seconds} s`;
  }
}

export class Board {
  private leaving = 0;

  constructor(readonly announce: (text: string) => void) {}

  begin(name: string, slot: Slot, cancel: (job: string) => void): Work {
    return new Work(this, name, slot, cancel);
  }

  /** The same for what is prepared in the background. */
  prepare(name: string, slot: Slot): Work {
    return new Work(this, `Preparing answers about ${name}`, slot, null);
  }

  /** A quiet sentence over the view; it leaves after a moment unless it `stays`. Null removes it. */
  note(text: string | null, stays = false): void {
    const box = byId("stage-note");
    clearTimeout(this.leaving);
    box.hidden = text === null;
    if (text !== null && !stays) this.leaving = setTimeout(() => this.note(null), NOTE_MILLISECONDS);
    if (text === null || text === box.textContent) return;
    box.textContent = text;
    this.announce(text);
  }
}
