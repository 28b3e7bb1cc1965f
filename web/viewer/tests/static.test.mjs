// What a page shows before its script has drawn, and without it.
import assert from "node:assert/strict";
import process from "node:process";
import { after, test } from "node:test";
import { chromium, close, open } from "./pages.mjs";

const { FIRST, SECOND, VIEWER_URL } = process.env;
const browser = await chromium();
after(() => browser.close());

test("without scripts there are a picture and facts", async () => {
  const page = await browser.newPage();
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
