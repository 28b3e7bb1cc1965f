// Takes the pictures of the documents with the viewer in Chromium. Each is a crop of the page to a
// few of its elements.
//
//   VIEWER_URL=... CHROMIUM=... FILE=... PHOTO=... FOLDER=... [ONLY=one,two] node pictures.mjs
import process from "node:process";
import { join } from "node:path";
import { chromium, open } from "./tests/pages.mjs";

const { FILE, PHOTO, FOLDER } = process.env;
const ONLY = process.env.ONLY?.split(",");
const SIZE = { width: 1120, height: 700, scale: 1, isOpen: false };
/** Text of a part of the panel is small, so that its crop has more pixels. */
const PANEL = { ...SIZE, height: 1000, scale: 1.5 };
/** With a chart beside the view. */
const WIDE = { ...SIZE, width: 1280, height: 560 };
const browser = await chromium();

const has = (page, id, pattern) =>
  page.waitForFunction((box, text) => new RegExp(text).test(document.getElementById(box).textContent), {}, id, pattern);
const compared = (page) => has(page, "coverage", "ΔE00");
const click = (page, selector) => page.$eval(selector, (box) => box.click());
const openPart = (page, id) => page.$eval(`#${id}`, (part) => (part.open = true));

/** Box around elements, with a margin, inside the window. */
function box(page, selectors, margin) {
  return page.evaluate((all, space) => {
    const places = all.map((selector) => document.querySelector(selector).getBoundingClientRect());
    const x = Math.max(0, Math.min(...places.map(({ left }) => left)) - space);
    const y = Math.max(0, Math.min(...places.map(({ top }) => top)) - space);
    const right = Math.min(innerWidth, Math.max(...places.map((place) => place.right)) + space);
    const bottom = Math.min(innerHeight, Math.max(...places.map((place) => place.bottom)) + space);
    return { x, y, width: right - x, height: bottom - y };
  }, selectors, margin);
}

/** Take a picture of elements of a page once `prepare` has ended. */
async function take(name, path, selectors, prepare = compared, size = SIZE, { pause = 1500, margin = 0 } = {}) {
  if (ONLY?.includes(name) === false) return;
  const page = await open(browser, path, size);
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
  await prepare(page);
  await new Promise((resolve) => setTimeout(resolve, pause));
  await page.$eval(selectors[0], (part) => part.scrollIntoView({ block: "nearest" }));
  // Without a larger viewport, to which the page would scroll.
  const clip = await box(page, selectors, margin);
  await page.screenshot({ path: join(FOLDER, `${name}.png`), clip, captureBeyondViewport: false });
  await page.close();
}

/** Give a file to a button that asks for one. */
async function choose(page, button, path) {
  await page.waitForSelector(`${button}:not([disabled])`);
  const [chooser] = await Promise.all([page.waitForFileChooser(), click(page, button)]);
  await chooser.accept([path]);
}

await take("first", "/", ["#stage"]);
// The row of a file while its gamut is built.
await take("gamuts", "/view#a=srgb&b=press", ["#gamut-list"], async (page) => {
  await compared(page);
  await choose(page, "#upload", FILE);
  await page.waitForFunction("/levels|surface/i.test(document.querySelector('#gamut-list .waiting')?.textContent)");
}, PANEL, { pause: 0, margin: 5 });
await take("comparison", "/view#a=press&b=srgb", ["#answer"], compared, PANEL, { margin: 8 });
await take("outside", "/view#a=press&b=srgb&style-b=hidden&outside=on", ["#stage"]);
await take("lightness", "/view#a=press&b=srgb&lightness=50", ["#stage", "#section"], compared, WIDE);
await take("chromaticity", "/view#a=display-p3&b=bt2020&diagram=uv", ["#section-chart"], compared, WIDE);
await take("colours", "/view#a=press", ["#colours-table", "#stage"], async (page) => {
  await openPart(page, "colours-part");
  await page.$eval("#colours", (field) => {
    field.value = "Brown, 50, 30, 20\nOrange, 66, 60, 90\nGreen, 60, -90, 40\nBlue, 30, 20, -80\nGrey, 60, 0, 0";
  });
  await page.waitForSelector("#check:not([disabled])");
  await click(page, "#check");
  await has(page, "colours-table", "Recipe");
}, { ...SIZE, width: 1210, height: 620 });
await take("picture", "/view#a=press", ["#picture-view"], async (page) => {
  await openPart(page, "picture");
  await choose(page, "#picture-open", PHOTO);
  await has(page, "picture-note", " %");
}, PANEL, { margin: 8 });
await browser.close();
