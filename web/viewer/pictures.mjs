// Takes the pictures of the documents with the viewer in Chromium.
//
//   VIEWER_URL=... CHROMIUM=... PRESS=ID OTHER=ID FILE=... FOLDER=... node pictures.mjs
import process from "node:process";
import { join } from "node:path";
import { chromium, drawn, open } from "./tests/pages.mjs";

const { PRESS, OTHER, FILE, FOLDER } = process.env;
const SIZE = { width: 1120, height: 700 };
const FRAMES = 36;
const MOST_TRIANGLES = 10_000;
const browser = await chromium();

const settled = () => new Promise((resolve) => setTimeout(resolve, 1500));
const file = (name) => join(FOLDER, `${name}.png`);
const compared = (page) =>
  page.waitForFunction("/covers/.test(document.getElementById('coverage').textContent)", { timeout: 60_000 });

async function take(name, path, prepare = async () => {}, size = SIZE) {
  const page = await open(browser, path, size);
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4", { timeout: 60_000 });
  await prepare(page);
  await settled();
  await page.screenshot({ path: file(name) });
  await page.close();
}

async function point(page, across, down) {
  const box = await (await page.$("#view")).boundingBox();
  await page.mouse.move(box.x + across * box.width, box.y + down * box.height);
  await page.waitForSelector("#readout:not([hidden])");
}

await take("one", `/view#a=${PRESS}`, (page) => point(page, 0.55, 0.5));
await take("options", `/view#a=${PRESS}`, async (page) => {
  await page.click("#options summary");
  await page.select("#intent", "absolute");
  await page.type("#ink-limit", "300");
  const [chooser] = await Promise.all([page.waitForFileChooser(), page.click("#upload")]);
  await chooser.accept([FILE]);
  await page.waitForFunction("/^Absolute/.test(document.querySelector('#facts dd').textContent)", { timeout: 60_000 });
  await page.$eval("#panel", (panel) => { panel.scrollTop = 0; });
});
await take("two", `/view#a=${PRESS}&b=srgb`, async (page) => {
  await compared(page);
  await point(page, 0.5, 0.55);
  await page.waitForFunction("/ from sRGB/.test(document.getElementById('readout').textContent)");
});
await take("outside", `/view#a=srgb&b=${PRESS}&style-b=hidden&projection=orthographic`, async (page) => {
  await compared(page);
  await page.click("[data-axis='+L*']");
  await page.click("#highlight");
});
await take("slice", `/view#a=${PRESS}&b=srgb&lightness=50&style-a=shaded`, compared, { ...SIZE, scheme: "dark" });
await take("rings", `/view#a=${PRESS}&b=${OTHER}&rings=on`, async (page) => {
  await page.waitForFunction("/L\\* 100/.test(document.getElementById('section-chart').textContent)", { timeout: 60_000 });
});
await take("colours", `/view#a=${PRESS}&lightness=50`, async (page) => {
  await page.evaluate((text) => {
    document.getElementById("colours").value = text;
  }, "Brown, 50, 30, 20\nOrange, 66, 60, 90\nGreen, 60, -90, 40\nBlue, 30, 20, -80\nGrey, 60, 0, 0");
  await page.click("#check");
  await page.waitForFunction("/Recipe/.test(document.getElementById('colours-table').textContent)", { timeout: 60_000 });
  await page.$eval("#colours-note", (note) => note.scrollIntoView());
  const box = await (await page.$("#section-chart rect[fill=none]")).boundingBox();
  await page.mouse.move(box.x + 0.55 * box.width, box.y + 0.5 * box.height);
  await page.waitForFunction("/ΔE00/.test(document.getElementById('readout').textContent)");
});
await take("phone", `/view#a=${PRESS}&b=srgb`, compared, { width: 390, height: 780 });

// The slider, from four triangles to as many as can be seen.
const page = await open(browser, `/view#a=${PRESS}&style-a=both&axes=off`, { width: 1000, height: 620 });
await page.waitForFunction("window.gamutViewer.figures.withDevice[0]", { timeout: 60_000 });
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
await browser.close();
