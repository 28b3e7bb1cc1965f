// Takes the pictures of the documents with the viewer in Chromium.
//
//   VIEWER_URL=... CHROMIUM=... FILE=... PHOTO=... FOLDER=... [ONLY=one,two] node pictures.mjs
import process from "node:process";
import { join } from "node:path";
import { chromium, drawn, open } from "./tests/pages.mjs";

const { FILE, PHOTO, FOLDER } = process.env;
const ONLY = process.env.ONLY?.split(",");
const SIZE = { width: 1120, height: 700 };
/** With a chart beside the view. */
const WIDE = { width: 1180, height: 660 };
const FRAMES = 24;
const MOST_TRIANGLES = 8000;
const browser = await chromium();

const settled = (milliseconds = 1500) => new Promise((resolve) => setTimeout(resolve, milliseconds));
const file = (name) => join(FOLDER, `${name}.png`);
const has = (page, id, pattern) =>
  page.waitForFunction((box, text) => new RegExp(text).test(document.getElementById(box).textContent), {}, id, pattern);
const compared = (page) => has(page, "coverage", "ΔE00");
const scrollTo = (page, selector) => page.$eval(selector, (box) => box.scrollIntoView());
const click = (page, selector) => page.$eval(selector, (box) => box.click());

async function take(name, path, prepare = async () => {}, size = SIZE) {
  if (ONLY?.includes(name) === false) return;
  const page = await open(browser, path, size);
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
  await prepare(page);
  await settled(size.pause);
  await page.screenshot({ path: file(name) });
  await page.close();
}

async function point(page, selector, across, down) {
  const box = await (await page.$(selector)).boundingBox();
  await page.mouse.move(box.x + across * box.width, box.y + down * box.height);
  await page.waitForSelector("#readout:not([hidden])");
}

/** Give a file to a button that asks for one. */
async function choose(page, button, path) {
  await page.waitForSelector(`${button}:not([disabled])`);
  const [chooser] = await Promise.all([page.waitForFileChooser(), click(page, button)]);
  await chooser.accept([path]);
}

await take("first", "/", compared);
await take("phone", "/", compared, { width: 390, height: 780 });
await take("dark", "/view#a=press&b=srgb&hue=20", compared, { ...WIDE, scheme: "dark" });
await take("two", "/view#a=srgb&b=press&c=display-p3", async (page) => {
  await compared(page);
  await point(page, "#view", 0.5, 0.55);
  await has(page, "readout", " from ");
});
await take("outside", "/view#a=srgb&b=press&style-b=hidden&outside=on", compared);
await take("lightness", "/view#a=press&b=srgb&lightness=50", compared, WIDE);
await take("hue", "/view#a=press&b=srgb&hue=40", compared, WIDE);
await take("chromaticity", "/view#a=display-p3&b=bt2020&diagram=uv", compared, WIDE);
await take("comparison", "/view#a=press&b=srgb", async (page) => {
  await compared(page);
  await page.waitForSelector("#comparison-chart svg");
  await scrollTo(page, "#comparison");
}, { width: 1000, height: 900 });
await take("colours", "/view#a=press&lightness=50", async (page) => {
  await page.evaluate((text) => {
    document.getElementById("colours").value = text;
  }, "Brown, 50, 30, 20\nOrange, 66, 60, 90\nGreen, 60, -90, 40\nBlue, 30, 20, -80\nGrey, 60, 0, 0");
  await page.waitForSelector("#check:not([disabled])");
  await click(page, "#check");
  await has(page, "colours-table", "Recipe");
  await scrollTo(page, "#colours-note");
  await point(page, "#section-chart rect[fill=none]", 0.55, 0.5);
  await has(page, "readout", "ΔE00");
}, WIDE);
await take("picture", "/view#a=photo&b=press", async (page) => {
  await page.$eval("#picture-gamut", (select) => {
    select.value = [...select.options].at(-1).value;
    select.dispatchEvent(new Event("change"));
  });
  await choose(page, "#picture-open", PHOTO);
  await has(page, "picture-note", " %");
  await scrollTo(page, "[aria-labelledby=picture-title]");
});
await take("options", "/view#a=press", async (page) => {
  await page.waitForSelector(".options-line button");
  await click(page, ".options-line button");
  await page.select("#intent", "absolute");
  await page.$eval("#ink-limit", (input) => (input.value = "300"));
  await page.$eval("#options", (box) => box.scrollIntoView({ block: "center" }));
});
await take("build", "/view#a=srgb", async (page) => {
  await choose(page, "#upload", FILE);
  await has(page, "job", "levels|surface");
}, { ...SIZE, pause: 0 });

// The slider, from four triangles to as many as can be seen.
if (ONLY?.includes("slider") !== false) {
  const page = await open(browser, "/view#a=press&edges=on&axes=off", { width: 1000, height: 620 });
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
  await page.focus("#view");
  await page.keyboard.press("+");
  await page.evaluate(() => document.activeElement.blur());
  const top = await page.evaluate((most) => {
    const finest = Number(document.getElementById("triangles").max);
    return (1000 * Math.log(most / 4)) / Math.log(finest / 4);
  }, MOST_TRIANGLES);
  for (let frame = 0; frame < FRAMES; frame++) {
    const triangles = await page.evaluate((place) => {
      const slider = document.getElementById("slider");
      slider.value = String(place);
      slider.dispatchEvent(new Event("input"));
      return Number(document.getElementById("triangles").value);
    }, (top * frame) / (FRAMES - 1));
    await drawn(page, triangles);
    await page.evaluate(() => window.gamutViewer.view.picture());
    await page.screenshot({ path: file(`slider-${String(frame).padStart(2, "0")}`) });
  }
}
await browser.close();
