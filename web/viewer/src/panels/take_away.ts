// What is taken away from the page: a picture, one file that works offline, and the link.
import { byId, save } from "../page/elements.js";
import { withState } from "../page/embedded.js";
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

/** Save all gamuts and the state as one file that shows them without the service. */
async function savePage(page: Page): Promise<void> {
  const [first, ...others] = page.shown.map(({ gamut }) => gamut);
  if (first === undefined) return;
  const ids = others.map(({ id }) => id).join(",");
  const address = new URLSearchParams(page.address.text);
  for (const { slot, gamut } of page.shown) address.set(slot, gamut.id);
  const path = `/v1/gamuts/${first.id}/viewer.html${ids === "" ? "" : `?with=${ids}`}`;
  try {
    const answer = await request(path, { headers: { Accept: "text/html" } });
    const file = withState(await answer.text(), { address: String(address) });
    const names = [first, ...others].map(({ name }) => name);
    save(new Blob([file], { type: "text/html" }), `${names.join(" and ")}.html`);
  } catch (error) {
    page.complain(error);
  }
}
