// Sections in the viewer, in Chromium over a real server.
//
//   VIEWER_URL=... CHROMIUM=... FIRST=ID SECOND=ID PRESS=ID FINEST=N PAGE=FILE node --test slices.test.mjs
//
// The first gamut is a ball of radius 40 around L* = 50, the second one of radius 30.
import assert from "node:assert/strict";
import { mkdtemp, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import process from "node:process";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { chromium, close, drawn, open, plot, pixel, violations } from "./pages.mjs";
import { srgb } from "./srgb.mjs";

const { FIRST, SECOND, PRESS, PAGE } = process.env;
const FINEST = Number(process.env.FINEST);

let browser;
before(async () => {
  browser = await chromium();
});
after(() => browser.close());

/** Where a CIELAB colour is in the view, as fractions of its size. */
function placeOf(page, lab) {
  return page.evaluate(([l, a, b]) => {
    const { view } = window.gamutViewer;
    const [x, y] = view.stagePlace(view.camera.position.clone().set(a, l, -b));
    return [x / view.canvas.clientWidth, y / view.canvas.clientHeight];
  }, lab);
}

async function shows(page, lab, tolerance = 4) {
  const seen = await pixel(page, ...(await placeOf(page, lab)));
  const wanted = srgb(lab);
  const isEqual = wanted.every((value, i) => Math.abs(value - seen[i]) <= tolerance);
  assert.ok(isEqual, `${lab}: ${seen} instead of ${wanted.map(Math.round)}`);
}

/** Areas by the legend of the chart. */
async function areas(page) {
  const text = await page.$eval("#section-chart", (chart) => chart.textContent);
  return [...text.matchAll(/(Ball .), area ([\d,]+)(?!.*\1, area)/gs)].map(([, name, area]) => [name, Number(area.replaceAll(",", ""))]);
}

test("a section has the exact colours of its plane, and nothing is in front of it", async () => {
  const page = await open(browser, `/view#a=${FIRST}&lightness=62&axes=off`);
  await drawn(page, FINEST);
  // Seen from the front above, the upper cap of the ball would hide these places.
  for (const [a, b] of [[20, -10], [-20, 15], [5, 22], [-8, -24]]) await shows(page, [62, a, b]);
  const [across, down] = await placeOf(page, [86, 0, 0]);
  const ground = await page.$eval("#stage", (stage) => getComputedStyle(stage).backgroundColor);
  const top = await pixel(page, across, down - 0.01);
  assert.equal(`rgb(${top.join(", ")})`, ground);
  // A screen with more colours sees the same chart, which is sRGB as its files are.
  const chart = (each) => each.waitForSelector("#section-chart image").then((image) => image.evaluate((shown) => shown.getAttribute("href")));
  const wide = await open(browser, `/view#a=${FIRST}&lightness=62&axes=off`, { gamut: "p3" });
  await drawn(wide, FINEST);
  assert.equal(await chart(wide), await chart(page));
  await close(wide);
  // A hue shows the leaf of the opposite one as well.
  await page.select("#slice-kind", "hue");
  for (const chroma of [25, -25]) {
    const angle = (40 * Math.PI) / 180;
    await shows(page, [50, chroma * Math.cos(angle), chroma * Math.sin(angle)]);
  }
  assert.match(await page.$eval("#plane-text", (text) => text.textContent), /^Hue 40°$/);
  assert.match(await page.$eval("#plane-opposite", (text) => text.textContent), /^Hue 220°$/);
  // The other half hides the section, and the colours of the surface are in front of it again.
  await page.click("#slice-open");
  const closed = await pixel(page, ...(await placeOf(page, [50, 0, 0])));
  assert.ok(Math.hypot(...srgb([50, 0, 0]).map((value, i) => value - closed[i])) > 30, String(closed));
  await close(page);
});

test("the plane is dragged in the view, and moved by keys", async () => {
  const page = await open(browser, `/view#a=${FIRST}&lightness=50`);
  await drawn(page, FINEST);
  const lightness = () => page.$eval("#slice-value", (slider) => slider.valueAsNumber);
  const camera = await page.evaluate("window.gamutViewer.view.place");
  const drag = async (dx, dy) => {
    const box = await (await page.$("#plane-handle")).boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + dx, y + dy, { steps: 5 });
    await page.mouse.up();
    const moved = await (await page.$("#plane-handle")).boundingBox();
    return [moved.x - box.x, moved.y - box.y];
  };
  const [, up] = await drag(0, -40);
  assert.ok(Math.abs(up + 40) < 6, `${up}`);
  const dragged = await lightness();
  assert.ok(dragged > 55, `${dragged}`);
  assert.deepEqual(await page.evaluate("window.gamutViewer.view.place"), camera);
  await page.focus("#view");
  await page.keyboard.press("PageDown");
  assert.equal(await lightness(), dragged - 5);
  await page.focus("#plane-handle");
  await page.keyboard.press("ArrowUp");
  assert.equal(await lightness(), dragged - 4);
  await page.waitForFunction(`location.hash.includes("lightness=${dragged - 4}")`);
  await page.select("#slice-kind", "hue");
  const hue = await lightness();
  await drag(-30, 0);
  assert.notEqual(await lightness(), hue);
  await close(page);
});

test("a cut begins at L* 50, and a number moves it anywhere within the gamuts", async () => {
  // The middle of the press is at L* 54.
  const page = await open(browser, `/view#a=${PRESS}`);
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
  await page.select("#slice-kind", "lightness");
  const values = () => page.$$eval("#slice-row input", (fields) => fields.map((field) => field.valueAsNumber));
  assert.deepEqual(await values(), [50, 50]);
  for (const [typed, taken] of [["40.5", 40.5], ["400", 100], ["", 100]]) {
    await page.click("#slice-number", { count: 3 });
    await page.keyboard.press("Backspace");
    await page.keyboard.type(typed);
    await page.keyboard.press("Enter");
    assert.equal((await values())[1], taken);
    await page.waitForFunction((value) => location.hash.includes(`lightness=${value}&`) || location.hash.endsWith(`lightness=${value}`), {}, taken);
  }
  await close(page);
});

test("the pointer reads the colour of the section, in the view and in the chart", async () => {
  const page = await open(browser, `/view#a=${FIRST}&lightness=55`);
  await drawn(page, FINEST);
  const box = await (await page.$("#view")).boundingBox();
  const [x, y] = await placeOf(page, [55, 10, -15]);
  await page.mouse.move(box.x + x * box.width, box.y + y * box.height);
  await page.waitForFunction("/L\\* 55\\.0 +a\\* (9\\.\\d|10\\.\\d) +b\\* −1[45]\\.\\d/.test(document.getElementById('readout').textContent)");
  const chart = await plot(page);
  await page.mouse.move(chart.x + chart.width / 2, chart.y + chart.height / 2);
  await page.waitForFunction("/L\\* 55\\.0 +a\\* −?[01]\\.\\d +b\\* −?[01]\\.\\d/.test(document.getElementById('readout').textContent)");
  await close(page);
});

/** What the page tells screen readers, once it matches. */
function announced(page, pattern) {
  return page.waitForFunction((source) => new RegExp(source).test(document.getElementById("status").textContent), {}, pattern);
}

test("a colour of the chart is announced, and a click keeps it until Escape, another click, or another cut", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}&lightness=50`);
  await drawn(page, FINEST);
  const chart = await plot(page);
  const at = (across, down) => [chart.x + across * chart.width, chart.y + down * chart.height];
  const readout = () => page.$eval("#readout", (box) => (box.hidden ? "" : box.innerText));
  await page.mouse.move(...at(0.5, 0.5));
  await announced(page, "^Ball A, L\\* 50\\.0 +a\\* −?[01]\\.");
  assert.match(await readout(), /^Ball A\n/);
  await page.mouse.click(...at(0.5, 0.5));
  const first = await readout();
  assert.match(first, /Kept until Esc/);
  await announced(page, "Kept until Esc");
  // Neither the chart nor the view replaces it, and the place of the colour is marked in the view.
  await page.mouse.move(...at(0.6, 0.4));
  const view = await (await page.$("#view")).boundingBox();
  await page.mouse.move(view.x + view.width / 2, view.y + view.height / 2);
  await page.mouse.move(view.x + 4, view.y + view.height - 4);
  assert.equal(await readout(), first);
  const mark = await (await page.$("#readout-mark")).boundingBox();
  const [x, y] = await placeOf(page, [50, 0, 0]);
  const apart = Math.hypot(mark.x + mark.width / 2 - view.x - x * view.width, mark.y + mark.height / 2 - view.y - y * view.height);
  assert.ok(apart < 4, `${apart}`);
  assert.deepEqual(await violations(page), []);
  await page.mouse.click(...at(0.6, 0.4));
  const second = await readout();
  assert.ok(second !== first && /Kept/.test(second), second);
  await page.keyboard.press("Escape");
  assert.equal(await readout(), "");
  await page.mouse.click(...at(0.5, 0.4));
  await page.mouse.click(...at(0.5, 0.4));
  assert.equal(await readout(), "");
  await page.mouse.click(...at(0.5, 0.4));
  await page.focus("#slice-value");
  await page.keyboard.press("ArrowRight");
  await page.waitForSelector("#readout[hidden]");
  await page.waitForSelector("#readout-mark[hidden]");
  await close(page);
});

/** The file that a button saves. */
function saved(page, button) {
  return page.evaluate(async (id) => {
    const made = new Promise((resolve) => {
      const create = URL.createObjectURL;
      URL.createObjectURL = (blob) => {
        // A PNG file is made from the SVG file, which is the first one.
        if (id.endsWith(blob.type.includes("svg") ? "svg" : "png")) resolve(blob);
        return create.call(URL, blob);
      };
    });
    document.getElementById(id).click();
    const blob = await made;
    const picture = await createImageBitmap(blob).catch(() => null);
    return { type: blob.type, text: await blob.text(), width: picture?.width };
  }, button);
}

test("the chart is beside the view, has readable text, can be resized, and is saved as SVG and PNG", async () => {
  for (const given of [{ width: 1280, height: 720 }, { width: 820, height: 1100 }, { width: 390, height: 780, scheme: "dark" }]) {
    const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}&hue=40`, given);
    await drawn(page, FINEST);
    await page.waitForSelector("#section-chart svg");
    const layout = await page.evaluate(() => {
      const [view, section] = ["stage", "section"].map((id) => document.getElementById(id).getBoundingClientRect());
      const texts = [...document.querySelectorAll("#section-chart text")];
      return {
        apart: section.left >= view.right - 1 || section.top >= view.bottom - 1,
        beyond: document.documentElement.scrollWidth - innerWidth,
        smallest: Math.min(...texts.map((text) => Number.parseFloat(getComputedStyle(text).fontSize))),
        view: [view.width, view.height],
      };
    });
    assert.ok(layout.apart && layout.smallest >= 11 && Math.min(...layout.view) > 300, JSON.stringify(layout));
    assert.equal(layout.beyond, 0);
    if (given.scheme === "dark") assert.deepEqual(await violations(page), []);
    await close(page);
  }
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}&hue=40`, { width: 1280, height: 720 });
  await drawn(page, FINEST);
  await page.waitForSelector("#section-chart svg");
  const width = () => page.$eval("#section-chart svg", (chart) => chart.width.baseVal.value);
  const before = await width();
  await page.focus("#section-size");
  await page.keyboard.press("ArrowLeft");
  await page.waitForFunction(`document.querySelector("#section-chart svg").width.baseVal.value === ${before + 20}`);
  const { type, text } = await saved(page, "section-svg");
  assert.match(type, /^image\/svg/);
  const isValid = await page.evaluate((source) => {
    const parsed = new DOMParser().parseFromString(source, "image/svg+xml");
    return parsed.querySelector("parsererror") === null && parsed.querySelector("image") !== null;
  }, text);
  assert.ok(isValid && text.includes("Ball A") && text.includes("Ball B") && text.includes("Hue 40°"));
  const picture = await saved(page, "section-png");
  assert.equal(picture.type, "image/png");
  assert.equal(picture.width, 3 * (before + 20));
  await page.click("#section-close");
  await page.waitForSelector("#section[hidden]");
  await close(page);
});

test("a page in one file has sections", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}&lightness=50`, { scheme: "dark" });
  await page.waitForFunction("/Ball A[^]*Ball B/.test(document.querySelector('#section-chart svg')?.textContent)");
  assert.deepEqual(await violations(page), []);
  const file = await savedPage(page);
  await close(page);
  const kept = await open(browser, file, { isOffline: true });
  await kept.waitForFunction("/Ball A[^]*Ball B/.test(document.querySelector('#section-chart svg')?.textContent)");
  await close(kept);
  const offline = await open(browser, `${PAGE}#lightness=50&axes=off`, { isOffline: true });
  await drawn(offline, FINEST);
  await shows(offline, [50, 20, 10]);
  await close(offline);
});

/** The address of the page as a file. */
async function savedPage(page) {
  await page.click("#save");
  await page.select("#save-kind", "html");
  const text = await page.evaluate(() => {
    const made = new Promise((resolve) => {
      const create = URL.createObjectURL;
      URL.createObjectURL = (blob) => {
        resolve(blob.text());
        return create.call(URL, blob);
      };
    });
    document.getElementById("save-file").click();
    return made;
  });
  const path = join(await mkdtemp(join(tmpdir(), "viewer-")), "saved.html");
  await writeFile(path, text);
  return pathToFileURL(path).href;
}

test("the plane is within the gamuts of another space, and of an address", async () => {
  const page = await open(browser, `/view#a=${FIRST}&lightness=50`);
  await drawn(page, FINEST);
  await page.waitForSelector("#section-chart image");
  await page.evaluate(`window.gamutViewer.show("a", "srgb?space=Oklab")`);
  await page.waitForFunction("/area 0\\.\\d*[1-9]/.test(document.getElementById('section-chart').textContent)");
  const lightness = await page.$eval("#slice-value", (slider) => slider.valueAsNumber);
  assert.ok(lightness > 0.4 && lightness < 0.6, `${lightness}`);
  const far = await open(browser, `/view#a=srgb?space=Oklab&lightness=50`);
  await far.waitForFunction("/area 0\\.\\d*[1-9]/.test(document.getElementById('section-chart').textContent)");
  await close(far);
  // X, Y and Z have no hue; CIELAB has one again, also while nothing is drawn.
  await page.evaluate(`window.gamutViewer.show("a", "srgb?space=CIEXYZ")`);
  await page.waitForSelector("#slice-hue[disabled]");
  await page.click("#section-close");
  await page.evaluate(`window.gamutViewer.show("a", "${FIRST}")`);
  await page.waitForSelector("#slice-hue:not([disabled])");
  await close(page);
});
