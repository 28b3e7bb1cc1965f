// Colours on the screen: in spaces other than CIELAB, and marks of those that it cannot show.
import assert from "node:assert/strict";
import process from "node:process";
import { after, before, test } from "node:test";
import { chromium, close, difference, drawn, open, smallPicture } from "./pages.mjs";

let browser;
before(async () => {
  browser = await chromium();
});
after(() => browser?.close());

test("colours that the screen cannot show are marked, and the address keeps it", async () => {
  const page = await open(browser, `/view#a=${process.env.PRESS}&triangles=2000`);
  await drawn(page, 2000);
  const before = await smallPicture(page);
  await page.click("#marks");
  const { far } = await difference(page, before, await smallPicture(page));
  assert.ok(far > 0.002 && far < 0.3, String(far)); // a press has greens and cyans beyond sRGB
  await page.waitForFunction("location.hash.includes('marks=on')");
  await page.reload();
  await page.waitForFunction("document.getElementById('marks')?.checked === true");
  await close(page);
});

test("a slice in Oklab has colours, without a request for a mesh", async () => {
  const page = await open(browser, `/view#a=${process.env.OKLAB}&hue=40`);
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 0");
  const colours = await page.evaluate(() => {
    const canvas = document.getElementById("slice");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let found = 0;
    for (let i = 0; i < data.length; i += 4) found += data[i + 3] > 0 && data[i] - data[i + 2] > 40 ? 1 : 0;
    return found;
  });
  assert.ok(colours > 500, String(colours)); // hue 40° is orange
  const requests = await page.evaluate(() => performance.getEntriesByType("resource").map(({ name }) => name));
  assert.deepEqual(requests.filter((name) => name.includes("mesh")), []);
  await close(page);
});
