// What a page shows before its script has drawn, and without it.
import assert from "node:assert/strict";
import process from "node:process";
import { after, test } from "node:test";
import { PATIENCE, chromium, close, open, violations } from "./pages.mjs";

const { FIRST, SECOND, VIEWER_URL } = process.env;
const browser = await chromium();
after(() => browser.close());

test("without scripts there are a picture and facts", async () => {
  const page = await browser.newPage();
  page.setDefaultTimeout(PATIENCE);
  await page.setJavaScriptEnabled(false);
  await page.goto(`${VIEWER_URL}/v1/gamuts/${FIRST}`, { waitUntil: "networkidle0" });
  await page.setJavaScriptEnabled(true);
  const [width, text] = await page.$eval("#static", (figure) => [
    figure.querySelector("img").naturalWidth,
    figure.innerText,
  ]);
  assert.equal(width, 640);
  assert.match(text, /Ball A[^]*Volume[^]*triangles[^]*Allow scripts/);
  await page.close();
});

test("the picture goes when the gamut is drawn", async () => {
  const page = await open(browser, `/v1/gamuts/${FIRST}`);
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
  assert.equal(await page.$("#static"), null);
  await close(page);
});

test("a copied link is the page of the gamut, and restores what is beside it", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}&lightness=50`);
  await page.waitForFunction("window.gamutViewer.figures.triangles[1] > 4");
  const link = await page.evaluate(async () => {
    const copied = new Promise((resolve) => {
      navigator.clipboard.writeText = async (text) => resolve(text);
    });
    document.getElementById("share").click();
    return copied;
  });
  const { pathname, hash } = new URL(link);
  assert.equal(pathname, `/v1/gamuts/${FIRST}`);
  const other = await open(browser, pathname + hash);
  await other.waitForFunction("window.gamutViewer.figures.triangles[1] > 4");
  assert.match(await other.title(), /^Ball A – Ball B/);
  assert.equal(await other.$eval("#slice-kind", (select) => select.value), "lightness");
  await close(other);
  await close(page);
});
const PAGES = {
  "/": "window.gamutViewer?.figures.triangles.every((count) => count > 4)",
  "/status": "true",
  "/problems/invalid-option": "true",
  "/docs": "document.querySelectorAll('.opblock').length > 20",
};

/** What Swagger UI itself writes, and neither HTML nor styles around it can mend: a link within the
 * button of each operation; headings of groups two levels below the title; and the title outside of
 * its main element. */
const FOREIGN = {
  "nested-interactive": ".opblock-summary-control",
  "heading-order": "h3.opblock-tag",
  region: ".information-container",
};

for (const [path, ready] of Object.entries(PAGES)) {
  test(`axe-core finds nothing at ${path}, in both schemes`, async () => {
    const page = await open(browser, path, { ready });
    assert.deepEqual(await violations(page, null, path === "/docs" ? FOREIGN : {}), []);
    await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: "dark" }]);
    assert.deepEqual(await violations(page, ["color-contrast"]), []);
    await close(page);
  });
}
