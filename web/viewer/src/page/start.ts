// The first screen: examples that turn until they are touched, chips for more of them, and what the
// service is preparing meanwhile.
import { type Example, exampleKeys, examples } from "../service/examples.js";
import { preparation } from "../service/api.js";
import { byId, element } from "./elements.js";
import { embedded } from "./embedded.js";
import type { Page } from "./page.js";

/** Chips of examples that have names of their own, and the examples of the first screen. */
const CHIPS: Record<string, string> = { press: "A press", photo: "A photograph", bt2020: "BT.2020" };
const FIRST = ["press", "srgb"] as const;
const ASKING_MILLISECONDS = 2000;

/** Show what the address says, or the first screen. */
export async function openPage(page: Page): Promise<void> {
  const isFirst = embedded === null && location.hash.length < 2 && !location.pathname.includes("/v1/gamuts/");
  page.address.isPaused = isFirst;
  const all = examples();
  const restored = page.restore();
  fillChips(page, await all);
  await restored;
  if (!isFirst) return inviteWhenEmpty(page);
  const isChosen = () => {
    page.address.isPaused = false;
    page.address.saveNow();
  };
  if (!page.isEmpty) return isChosen();
  const keys = (await all).map(({ key }) => key);
  const [first, second] = keys.includes(FIRST[0]) ? FIRST : [FIRST[1], null];
  const touch = new AbortController();
  const { signal } = touch;
  for (const name of ["pointerdown", "keydown", "wheel", "drop"]) {
    addEventListener(name, () => touch.abort(), { capture: true, passive: true, signal });
  }
  signal.addEventListener("abort", () => {
    page.view.spin(false);
    isChosen();
  });
  await Promise.all([page.show("a", first), second !== null && page.show("b", second)]);
  // The reader may have chosen other gamuts while these came.
  page.isTrial = page.at("a")?.key === first && (page.at("b")?.key ?? null) === second;
  if (!page.isTrial) touch.abort();
  page.view.spin(!signal.aborted);
  inviteWhenEmpty(page);
  void tellPreparation(page);
}

/** Say how to begin while nothing is shown, and that a gamut of the address cannot be shown. */
function inviteWhenEmpty(page: Page): void {
  const invitation = byId("invitation");
  const refresh = () => {
    const isRefused = !byId("problem").hidden;
    invitation.hidden = page.shown.length > 0 || !(page.isEmpty || isRefused);
    invitation.textContent = `${isRefused ? "This gamut cannot be shown. " : ""}Drop a profile, or choose a gamut.`;
    if (!invitation.hidden) document.getElementById("static")?.remove();
  };
  page.on(["slots", "requests"], refresh);
  refresh();
}

/** A chip for each example: it becomes the first gamut, or the second one by its plus. */
function fillChips(page: Page, all: Example[]): void {
  const chips = byId("chips");
  chips.replaceChildren(
    ...all.map(({ key, name, text, file }) => {
      const chip = element("span", "", { className: "chip" });
      const first = element("button", CHIPS[key] ?? name, { type: "button", title: file === null ? text : `${name}. ${text}` });
      const second = element("button", "+", { type: "button", title: `${name} as the second gamut` });
      second.setAttribute("aria-label", `${name} as the second gamut`);
      first.addEventListener("click", ({ shiftKey }) => void page.show(shiftKey ? "b" : "a", key));
      second.addEventListener("click", () => void page.show("b", key));
      first.dataset["key"] = key;
      chip.append(first, second);
      return chip;
    }),
  );
  let keys: ReadonlyMap<string, string> = new Map();
  const mark = () => {
    // The gamut of a dropped file has its id as its key.
    const isOwn = page.shown.some(({ key, gamut }) => key === gamut.id);
    if (isOwn && keys.size === 0 && all.length > 0) {
      void exampleKeys().then(
        (known) => {
          keys = known;
          if (known.size > 0) mark();
        },
        () => {}, // chips without marks
      );
    }
    for (const chip of chips.querySelectorAll<HTMLElement>("[data-key]")) {
      chip.setAttribute("aria-pressed", String(page.shown.some(({ key, gamut }) => [key, keys.get(gamut.id)].includes(chip.dataset["key"]))));
    }
  };
  page.on(["slots"], mark);
  mark();
  chips.hidden = all.length === 0;
}

/** Say what a service that has just started prepares, until it is ready. */
async function tellPreparation(page: Page): Promise<void> {
  const line = byId("preparation");
  for (let text = await preparation(true); text !== null; text = await preparation(true)) {
    const [, done, all] = /(\d+) of (\d+) kernels/.exec(text) ?? [];
    const bar = line.querySelector("progress")!;
    bar.hidden = all === undefined;
    if (all !== undefined) Object.assign(bar, { max: Number(all), value: Number(done) });
    line.querySelector("span")!.textContent = `${text}.`;
    if (line.hidden) page.announce(`${text}. The examples can be looked at meanwhile.`);
    line.hidden = false;
    await new Promise((resolve) => setTimeout(resolve, ASKING_MILLISECONDS));
  }
  if (!line.hidden) page.announce("The service is ready.");
  line.hidden = true;
}
