// What is taken away from the page: pictures, a turntable, one file that works offline, and the link.
import { SCREEN } from "../colours/colours.js";
import { byId, save } from "../page/elements.js";
import { Latest } from "../page/latest.js";
import { type Page, axisNames } from "../page/page.js";
import { tintOf } from "../page/slots.js";
import { type Picture, pngPicture, turntable } from "../scene/picture.js";
import { withState } from "../page/embedded.js";
import { address, hasKey, request } from "../service/api.js";

type Kind = "png" | "webp" | "html";

const NOTES: Record<Kind, string> = {
  png: "The view with its title, legend and scales.",
  webp: "One turn around the upright axis, again and again. Web browsers and slides show it.",
  html: "One file with all gamuts that are shown, as they are shown, and the list of colours. It works without a network.",
};
/** Smallest and largest number of frames of a turn. */
const FRAMES = [36, 90] as const;

export function connectSaving(page: Page): void {
  const dialog = byId<HTMLDialogElement>("take-away");
  const kind = byId<HTMLSelectElement>("save-kind");
  const button = byId<HTMLButtonElement>("save-file");
  const close = byId("save-close");
  const bar = byId<HTMLProgressElement>("save-progress");
  const saving = new Latest();
  const refresh = () => {
    const chosen = kind.value as Kind;
    for (const part of dialog.querySelectorAll<HTMLElement>(".of-picture")) part.hidden = chosen === "html";
    for (const part of dialog.querySelectorAll<HTMLElement>(".of-turning")) part.hidden = chosen !== "webp";
    byId("save-note").textContent = NOTES[chosen];
    button.disabled = page.shown.length === 0 || saving.isAsking;
    bar.hidden = !saving.isAsking || chosen !== "webp";
    close.textContent = saving.isAsking ? "Cancel" : "Close";
  };
  byId("save").addEventListener("click", () => {
    const { clientWidth, clientHeight } = page.canvas;
    byId<HTMLInputElement>("save-width").value = String(clientWidth);
    byId<HTMLInputElement>("save-height").value = String(clientHeight);
    refresh();
    dialog.showModal();
  });
  kind.addEventListener("change", refresh);
  close.addEventListener("click", () => {
    if (!saving.isAsking) return dialog.close();
    saving.end();
    refresh();
  });
  dialog.addEventListener("close", () => saving.end());
  button.addEventListener("click", () => {
    bar.value = 0;
    const name = page.shown.map(({ gamut }) => gamut.name).join(" and ");
    const type = kind.value as Kind;
    void saving.ask(
      (signal) => content(page, type, (part) => (bar.value = part), signal),
      (file) => {
        save(file, `${name}.${type}`);
        dialog.close();
        page.announce("The file was saved.");
      },
      (error) => {
        refresh();
        byId("save-note").textContent = error instanceof Error ? error.message : String(error);
      },
    );
    refresh();
  });
  byId("share").addEventListener("click", () => {
    // Browsers have a clipboard for secure pages only.
    const copied = navigator.clipboard?.writeText(linkTo(page)) ?? Promise.reject(new Error());
    copied
      .then(() => "The link was copied.", () => "This browser does not let the page copy. The link is in the address bar.")
      .then((text) => page.board.note(text));
  });
}

/**
 * The address that restores the page. It is that of the first gamut, which has a picture and facts
 * before the script runs, and in chats. An example may be unknown to the service, so it has none; and
 * without a key, a service that needs one answers with the page of all gamuts only.
 */
export function linkTo(page: Page): string {
  const first = page.at("a");
  if (first === null || first.isPart || hasKey()) return `${address("/view")}#${page.address.text}`;
  const state = page.address.text.split("&").filter((entry) => !entry.startsWith("a="));
  return `${address(`/v1/gamuts/${first.gamut.id}`)}#${state.join("&")}`;
}

async function content(page: Page, kind: Kind, progress: (part: number) => void, signal: AbortSignal): Promise<Blob> {
  const { view } = page;
  if (kind === "html") {
    const [first, ...others] = page.shown.map(({ gamut }) => gamut.id);
    const state = new URLSearchParams(page.address.text);
    for (const { slot, gamut } of page.shown) state.set(slot, gamut.id);
    const path = `/v1/gamuts/${first!}/viewer.html${others.length === 0 ? "" : `?with=${others.join(",")}`}`;
    const kept = Object.fromEntries([...page.kept].map(([name, value]) => [name, value()]));
    const answer = await request(path, { headers: { Accept: "text/html" }, signal });
    return new Blob([withState(await answer.text(), { address: String(state), ...kept })], { type: "text/html" });
  }
  const picture = pictureOf(page);
  if (kind === "png") return pngPicture(view, picture);
  return turntable(view, picture, within("save-frames", ...FRAMES), progress, signal);
}

/** The number of a field, held within its limits. */
function within(id: string, least: number, most: number): number {
  const field = byId<HTMLInputElement>(id);
  const value = Math.round(Math.min(Math.max(Number(field.value) || least, least), most));
  field.value = String(value);
  return value;
}

function pictureOf(page: Page): Picture {
  const size = (id: string) => within(id, Number(byId<HTMLInputElement>(id).min), Number(byId<HTMLInputElement>(id).max));
  const { axes } = page.view;
  const { gamut } = page.shown[0]!;
  const { space } = gamut.options;
  const step = axes === null ? "" : `: lines of the grid are ${axes.step} apart in ${axisNames(gamut).join(", ")}`;
  const cut = byId("plane-handle").hidden ? "" : `; cut at ${byId("plane-text").textContent}`;
  const style = getComputedStyle(byId("stage"));
  return {
    width: size("save-width"),
    height: size("save-height"),
    ratio: Number(byId<HTMLSelectElement>("save-ratio").value),
    title: page.shown.map(({ gamut }) => gamut.name).join(" and "),
    legend: page.shown
      .filter(({ slot }) => page.lookOf(slot).isVisible)
      .map(({ slot, gamut }) => ({ text: gamut.name, colour: tintOf(slot, page.isDark) })),
    note: `${space}${step}${cut}; colours for ${SCREEN === "srgb" ? "sRGB" : "Display P3"} screens`,
    colour: style.color,
    ground: style.backgroundColor,
  };
}
