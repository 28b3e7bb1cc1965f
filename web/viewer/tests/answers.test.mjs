// Answers of the viewer about colours and pictures, in Chromium over a real server.
//
//   VIEWER_URL=... CHROMIUM=... FIRST=ID node --test answers.test.mjs
//
// The first gamut is a ball of radius 40 around L* = 50, the press FOGRA39L with an ink limit.
import assert from "node:assert/strict";
import process from "node:process";
import { after, before, test } from "node:test";
import { chromium, close, open, violations } from "./pages.mjs";

const { FIRST, PRESS, SAMPLES } = process.env;

let browser;
before(async () => {
  browser = await chromium();
});
after(() => browser.close());

/** Texts of the rows of the list that are elements of the page. */
function rows(page) {
  return page.$$eval("#colours-table tbody tr:not([aria-hidden])", (all) =>
    all.map((row) => [...row.children].map((cell) => cell.textContent)),
  );
}

test("the table of a long list is complete, and is sorted by any column", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  // Colours of growing chroma: from 0 to 79.9 around L* 50.
  const list = ["name,L,a,b", ...Array.from({ length: 800 }, (_, i) => `colour ${i},50,${i / 10},0`)].join("\n");
  await page.evaluate((text) => {
    document.getElementById("colours").value = text;
  }, list);
  await page.waitForSelector("#check:not([disabled])");
  await page.$eval("#check", (button) => button.click());
  await page.waitForSelector("#colours-table:not([hidden]) tbody tr");
  assert.equal((await rows(page))[0][0], "colour 0");
  assert.ok((await rows(page)).length < 100, "only the rows in sight are elements");
  await page.$eval("#colours-table", (box) => {
    box.scrollTop = box.scrollHeight;
  });
  await page.waitForFunction("/colour 799/.test(document.getElementById('colours-table').textContent)");
  const sortBy = (title) =>
    page.$$eval("#colours-table th button", (all, name) => all.find((each) => each.textContent.startsWith(name)).click(), title);
  await sortBy("ΔE00");
  await sortBy("ΔE00");
  assert.equal(await page.$eval("#colours-table th[aria-sort]", (head) => head.ariaSort), "descending");
  // A title says what it means, and still sorts when it is tapped.
  assert.match(await page.$eval("#term-note", (note) => (note.matches(":popover-open") ? note.textContent : "")), /^CIEDE2000/);
  const farthest = await rows(page);
  assert.equal((await page.$eval("#colours-table", (box) => { box.scrollTop = 0; return box.scrollTop; })), 0);
  await page.waitForFunction("document.querySelector('#colours-table tbody th').textContent === 'colour 799'");
  assert.ok(farthest.length > 0);
  // A little way down and back again, all rows in sight are there.
  for (const top of [17 * 30, 0]) {
    await page.$eval("#colours-table", (box, place) => new Promise((done) => {
      box.addEventListener("scroll", () => requestAnimationFrame(done), { once: true });
      box.scrollTop = place;
    }), top);
  }
  assert.equal((await rows(page))[0][0], "colour 799");
  // The edge is as wide as stated: within 5 of radius 40 are the colours from 35 to 45.
  await page.$eval("#colours-reading", (box) => {
    box.open = true;
  });
  await page.type("#colours-edge", "5");
  await page.keyboard.press("Enter");
  await page.waitForFunction("/edge 5/.test(document.getElementById('colours-reading-summary').textContent)");
  await page.waitForFunction("/(9\\d|10\\d) edge/.test(document.getElementById('colours-note').textContent)");
  assert.deepEqual(await violations(page), []);
  await close(page);
});

test("the address restores a short list and how it is read", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await page.evaluate(() => {
    document.getElementById("colours").value = "Half, 0.5, 0.5, 0.5";
    document.getElementById("colours-space").value = "sRGB";
  });
  await page.waitForSelector("#check:not([disabled])");
  await page.$eval("#check", (button) => button.click());
  await page.waitForFunction("location.hash.includes('colours-space=sRGB')");
  const other = await open(browser, new URL(page.url()).pathname + new URL(page.url()).hash);
  await other.waitForSelector("#colours-table:not([hidden])");
  assert.equal((await rows(other))[0][0], "Half");
  assert.match(await other.$eval("#colours-note", (note) => note.textContent), /1 colour: 1 inside/);
  await close(other);
  await close(page);
});

test("the patches of a file are points in its gamut", async () => {
  const page = await open(browser, "/view");
  await page.evaluate((text) => {
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([text], "patches.csv"));
    document.body.dispatchEvent(new DragEvent("drop", { bubbles: true, dataTransfer }));
  }, SAMPLES);
  await page.waitForSelector("#mark-patches:not([disabled])");
  await page.$eval("#mark-patches", (box) => box.click());
  await page.waitForFunction("/patches of the file, 0 of them outside/.test(document.getElementById('marks-note').textContent)");
  await page.$eval("#mark-patches", (box) => box.click());
  assert.equal(await page.$eval("#marks-note", (note) => note.textContent), "");
  await close(page);
});

test("a picture has a share of pixels out of reach, a map of them, and a switch to the printed one", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await page.waitForSelector("#picture-open:not([disabled])");
  // A quarter is a saturated green, far outside of the ball; the rest is grey.
  await page.evaluate(async () => {
    const canvas = new OffscreenCanvas(40, 40);
    const context = canvas.getContext("2d");
    context.fillStyle = "rgb(119 119 119)";
    context.fillRect(0, 0, 40, 40);
    context.fillStyle = "rgb(0 255 0)";
    context.fillRect(0, 0, 20, 20);
    const transfer = new DataTransfer();
    transfer.items.add(new File([await canvas.convertToBlob()], "green corner.png", { type: "image/png" }));
    const input = document.getElementById("picture-file");
    input.files = transfer.files;
    input.dispatchEvent(new Event("change"));
  });
  await page.waitForFunction("/^25\\.0 %/.test(document.getElementById('picture-note').textContent)");
  const pixels = () => page.$eval("#picture-canvas", (canvas) => {
    const copy = new OffscreenCanvas(40, 40).getContext("2d", { willReadFrequently: true });
    copy.drawImage(canvas, 0, 0);
    const { data } = copy.getImageData(0, 0, 40, 40);
    return [[5, 5], [30, 30]].map(([x, y]) => [...data.slice(4 * (40 * y + x), 4 * (40 * y + x) + 3)]);
  });
  // The end of the legend, as the green is far more than 12 away; what is in reach is a neutral grey.
  const [far, near] = await pixels();
  assert.deepEqual(far, [90, 0, 110]);
  assert.equal(new Set(near).size, 1);
  assert.deepEqual(await page.$$eval("#picture-legend span", (all) => all.map((each) => each.textContent)), ["0", "3", "6", "12+"]);
  assert.match(await page.$eval("#picture-note", (note) => note.textContent), /black-point compensation/);
  await page.$eval("#picture-look [value=original]", (button) => button.click());
  assert.deepEqual((await pixels())[0], [0, 255, 0]);
  await page.$eval("#picture-look [value=printed]", (button) => button.click());
  await page.waitForSelector("#picture-view[aria-busy=false]");
  const [printed, grey] = await pixels();
  assert.ok(printed[1] > printed[0] && printed[1] < 250 && printed[0] > 20, `a paler green: ${printed}`);
  assert.ok(grey.every((value) => Math.abs(value - 119) <= 12), `${grey}`);
  await page.$eval("#picture-enlarge", (button) => button.click());
  assert.deepEqual(await violations(page), []);
  await close(page);
});
