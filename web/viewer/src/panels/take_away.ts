// What is taken away from the page: a picture, one file that works offline, and the link.
import { byId, save } from "../page/elements.js";
import type { Page } from "../page/page.js";
import { request } from "../service/api.js";

export function connectSaving(page: Page): void {
  byId("png").addEventListener("click", () => {
    const names = page.shown.map(({ gamut }) => gamut.name);
    void page.view.picture().then((picture) => save(picture, `${names.join(" and ") || "gamut"}.png`));
  });
  byId("html").addEventListener("click", () => void savePage(page));
  byId("share").addEventListener("click", () => {
    void navigator.clipboard.writeText(location.href).then(() => page.announce("The link was copied."));
  });
  page.on("gamuts", () => {
    byId<HTMLButtonElement>("html").disabled = page.shown.length === 0;
  });
}

/** Save the first gamut as one file that shows it without the service. */
async function savePage(page: Page): Promise<void> {
  const gamut = page.shown[0]?.gamut;
  if (gamut === undefined) return;
  try {
    const answer = await request(`/v1/gamuts/${gamut.id}/viewer.html`, { headers: { Accept: "text/html" } });
    save(await answer.blob(), `${gamut.name}.html`);
  } catch (error) {
    page.complain(error);
  }
}
