// What is taken away from the page: pictures, one file that works offline, and the link.
import { pageTheme } from "../charts/save.js";
import { SCREEN } from "../colours/colours.js";
import { byId, element, save } from "../page/elements.js";
import { Latest } from "../page/latest.js";
import { type Page, axisNames } from "../page/page.js";
import { tintOf } from "../page/slots.js";
import { type Picture, drawnPicture, pngPicture } from "../scene/picture.js";
import { withState } from "../page/embedded.js";
import { address, hasKey, request } from "../service/api.js";
import type { CoverageBar } from "./comparison_panel.js";
import { volumeText, volumeUnit } from "./conditions.js";
import type { SectionFigure } from "./section_figure.js";

type Kind = "png" | "html";

/** What a picture can have besides the view. */
interface Sources {
  readonly figure: SectionFigure;
  readonly comparison: { readonly bars: CoverageBar[] };
}

const NOTES: Record<Kind, string> = {
  png: "The view with title, legend and scales, and what is open of section and Compare.",
  html: "One file with all that is shown and the list of colours. It works without a network.",
};
/** A picture at 16:9 in CSS pixels, and its pixels for each of them: 1920 × 1080, with text for slides. */
const WIDE = { width: 1280, height: 720, ratio: 1.5 };
/** The part of its width that a chart beside the view has, and the largest height of such a chart relative to its width. */
const CHART_PART = 0.4;
const CHART_HEIGHT = 1.25;

export function connectSaving(page: Page, sources: Sources): void {
  const dialog = byId<HTMLDialogElement>("take-away");
  const kind = byId<HTMLSelectElement>("save-kind");
  const button = byId<HTMLButtonElement>("save-file");
  const close = byId("save-close");
  const preview = byId("save-preview");
  const saving = new Latest();
  const previewing = new Latest();
  const refresh = () => {
    const chosen = kind.value as Kind;
    for (const part of dialog.querySelectorAll<HTMLElement>(".of-picture")) part.hidden = chosen !== "png";
    byId("save-note").textContent = NOTES[chosen];
    byId("save-clear-note").hidden = chosen !== "png" || !isClear();
    button.disabled = page.shown.length === 0 || saving.isAsking;
    close.textContent = saving.isAsking ? "Cancel" : "Close";
  };
  /** Draw what would be saved, as large as the preview is. */
  const look = () => {
    previewing.end();
    if (!dialog.open || kind.value === "html" || page.shown.length === 0) return preview.replaceChildren();
    const picture = pictureOf(page, sources);
    const { width, height, ratio } = picture;
    const size = [width, height].map((pixels) => Math.floor(pixels * ratio)).join(" × ");
    const small = (preview.clientWidth * devicePixelRatio) / width;
    void previewing.ask(
      () => drawnPicture(page.view, { ...picture, ratio: Math.min(ratio, small) }),
      (canvas) => {
        canvas.setAttribute("role", "img");
        canvas.setAttribute("aria-label", `Preview: ${picture.title}`);
        canvas.classList.toggle("clear", picture.isClear);
        preview.replaceChildren(canvas, element("p", `${size} pixels`, { className: "note" }));
      },
      (error) => preview.replaceChildren(element("p", String(error), { className: "note" })),
    );
  };
  byId("save").addEventListener("click", () => {
    refresh();
    dialog.showModal();
    look();
  });
  dialog.addEventListener("change", () => {
    refresh();
    look();
  });
  page.on(["level"], () => dialog.open && look());
  close.addEventListener("click", () => {
    if (!saving.isAsking) return dialog.close();
    saving.end();
    refresh();
  });
  dialog.addEventListener("close", () => {
    saving.end();
    look();
  });
  button.addEventListener("click", () => {
    const name = page.shown.map(({ gamut }) => gamut.name).join(" and ");
    const type = kind.value as Kind;
    void saving.ask(
      (signal) => content(page, type, sources, signal),
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

async function content(page: Page, kind: Kind, sources: Sources, signal: AbortSignal): Promise<Blob> {
  if (kind === "html") {
    const [first, ...others] = page.shown.map(({ gamut }) => gamut.id);
    const state = new URLSearchParams(page.address.text);
    for (const { slot, gamut } of page.shown) state.set(slot, gamut.id);
    const path = `/v1/gamuts/${first!}/viewer.html${others.length === 0 ? "" : `?with=${others.join(",")}`}`;
    const kept = Object.fromEntries([...page.kept].map(([name, value]) => [name, value()]));
    const answer = await request(path, { headers: { Accept: "text/html" }, signal });
    return new Blob([withState(await answer.text(), { address: String(state), ...kept })], { type: "text/html" });
  }
  return pngPicture(page.view, pictureOf(page, sources));
}

function isClear(): boolean {
  return byId<HTMLInputElement>("save-clear").checked;
}

/** What is drawn: the view, and the chart and the figures beside it that are open. */
function pictureOf(page: Page, { figure, comparison }: Sources): Picture {
  const { axes } = page.view;
  const { gamut } = page.shown[0]!;
  const { space } = gamut.options;
  const step = axes === null ? "" : `: lines of the grid are ${axes.step} apart in ${axisNames(gamut).join(", ")}`;
  const cut = byId("plane-handle").hidden ? "" : `; cut at ${byId("plane-text").textContent}`;
  const stage = byId("stage");
  const isWide = byId<HTMLSelectElement>("save-shape").value === "wide";
  const theme = { ...pageTheme(stage, "--stage"), isClear: true };
  const { bars } = comparison;
  const shown = figure.size;
  const isBelow = !isWide && figure.isBelow;
  const frame = isWide ? WIDE : {
    width: stage.clientWidth + (isBelow ? 0 : (shown?.width ?? 0)),
    height: stage.clientHeight + (isBelow ? (shown?.height ?? 0) : 0),
    ratio: 1,
  };
  const width = isWide ? CHART_PART * frame.width : (shown?.width ?? 0);
  const size = isBelow ? shown : shown && { width, height: Math.min(frame.height, CHART_HEIGHT * width) };
  return {
    ...frame,
    ratio: frame.ratio * Number(byId<HTMLSelectElement>("save-ratio").value),
    title: page.shown.map((each) => each.gamut.name).join(" and "),
    legend: page.shown
      .filter(({ slot }) => page.lookOf(slot).isVisible)
      .map(({ slot, gamut: each }) => ({
        text: each.name,
        figure: bars.length === 0 ? "" : `, ${volumeText(each)} ${volumeUnit(each)}`,
        colour: tintOf(slot, page.isDark),
      })),
    note: `${space}${step}${cut}; colours for ${SCREEN === "srgb" ? "sRGB" : "Display P3"} screens`,
    bars: bars.map((bar) => ({ ...bar, colour: tintOf(bar.slot, page.isDark) })),
    chart: size && { svg: figure.svgFor({ size, theme }), ...size, isBelow },
    colour: theme.text,
    line: theme.line,
    ground: theme.back,
    isClear: isClear(),
  };
}
