// Gamuts together in the viewer: what is inside another one, translucent shells, tints and spaces.
//
//   VIEWER_URL=... CHROMIUM=... node --test layers.test.mjs
import assert from "node:assert/strict";
import process from "node:process";
import { after, before, test } from "node:test";
import { chromium, close, drawn, open, pixels } from "./pages.mjs";

const TRIANGLES = 600;
// Small pictures are quick without a graphics processor.
const SIZE = { width: 800, height: 420 };
const LOOK = "&axes=off&projection=orthographic";
const balls = {};
let browser;

/** A ball of points in all directions (Fibonacci's spiral), as a gamut of the service. */
async function ball(name, centre, radius, options = {}) {
  const samples = Array.from({ length: 900 }, (_, i) => {
    const height = 1 - (2 * (i + 0.5)) / 900;
    const angle = i * Math.PI * (3 - Math.sqrt(5));
    const width = Math.sqrt(1 - height * height);
    const direction = [height, width * Math.cos(angle), width * Math.sin(angle)];
    return direction.map((value, axis) => centre[axis] + radius * value);
  });
  const answer = await fetch(`${process.env.VIEWER_URL}/v1/gamuts`, {
    method: "POST",
    body: JSON.stringify({ samples, name, options }),
    headers: { "Content-Type": "application/json", Prefer: "wait=60" },
  });
  return (await answer.json()).id;
}

before(async () => {
  browser = await chromium();
  [balls.large, balls.small, balls.far, balls.oklab] = await Promise.all([
    ball("Large", [50, 0, 0], 40),
    ball("Small", [50, 30, 0], 30),
    ball("Far", [50, -30, 0], 25),
    ball("Other space", [0.5, 0, 0], 0.3, { space: "Oklab" }),
  ]);
});
after(() => browser.close());

const chroma = ([r, g, b]) => Math.max(r, g, b) - Math.min(r, g, b);

/** Look from +b*: a* is to the right. Returns the place of a* and L* as fractions of the picture. */
async function fromFront(page) {
  await page.click("[data-axis='−b*']");
  return page.evaluate(() => {
    const { view } = window.gamutViewer;
    const { camera } = view;
    camera.updateMatrixWorld();
    const position = camera.position.clone();
    const place = (a, lightness) => {
      const { x, y } = position.clone().set(a, lightness, 0).project(camera);
      return [(x + 1) / 2, (1 - y) / 2];
    };
    const [x0, y0] = place(0, 0);
    const [x1, y1] = place(1, 1);
    return { x0, y0, dx: x1 - x0, dy: y1 - y0 };
  });
}

/** Colours of the view at a* and L*. */
const colours = (page, { x0, y0, dx, dy }, places) =>
  pixels(page, places.map(([a, lightness]) => [x0 + a * dx, y0 + lightness * dy]));

test("the part inside the second gamut ends where the surfaces meet, at a coarse level, without a request", async () => {
  // The balls meet in the plane a* = (40² − 30² + 30²) / (2 · 30) = 26.67.
  const page = await open(browser, `/view#a=${balls.large}&b=${balls.small}&style-b=hidden&triangles=${TRIANGLES}${LOOK}`, SIZE);
  await drawn(page, TRIANGLES, TRIANGLES);
  const frame = await fromFront(page);
  await page.waitForFunction("/covers/.test(document.getElementById('coverage').textContent)");
  const asked = await page.evaluate("performance.getEntriesByType('resource').length");
  await page.click("#highlight");
  const check = async (triangles, distance) => {
    const heights = [35, 50, 65];
    const side = (sign) => colours(page, frame, heights.map((lightness) => [26.67 + sign * distance, lightness]));
    const [outside, inside] = [await side(-1), await side(1)];
    const isRight = outside.every((colour) => chroma(colour) > 12) && inside.every((colour) => chroma(colour) <= 3);
    assert.ok(isRight, `${triangles} triangles: ${outside.join("; ")} and ${inside.join("; ")}`);
  };
  await check(TRIANGLES, 1);
  await page.click("#eye-b");
  await page.click("#eye-b");
  await page.evaluate("window.gamutViewer.setTriangles(200)");
  await drawn(page, 200, 200);
  await check(200, 3);
  assert.equal(await page.evaluate("performance.getEntriesByType('resource').length"), asked);
  await close(page);
});

test("three gamuts: shells show what is behind them, with a tint each", async () => {
  const page = await open(browser, `/view#a=${balls.large}&b=${balls.small}&c=${balls.far}&triangles=${TRIANGLES}${LOOK}`, SIZE);
  await drawn(page, TRIANGLES, TRIANGLES, TRIANGLES);
  const frame = await fromFront(page);
  assert.equal(await page.$eval("#opacity-c", (slider) => slider.valueAsNumber), 0.3);
  const tints = await page.$$eval("#legend .tint", (marks) => marks.map((mark) => mark.style.backgroundColor));
  assert.equal(new Set(tints).size, 3);
  // Inside the outline of the first one, left of the others' lines, the solid shines through the shell.
  const sample = async () => (await colours(page, frame, [[-52, 53]]))[0];
  const both = await sample();
  await page.click("#eye-c");
  const ground = await sample();
  await page.evaluate("window.gamutViewer.setVisible('c', true), window.gamutViewer.setOpacity('c', 1)");
  const solid = await sample();
  const between = (i) => (both[i] - ground[i]) / (solid[i] - ground[i]);
  const shares = [0, 1, 2].filter((i) => Math.abs(solid[i] - ground[i]) > 40).map(between);
  assert.ok(shares.length > 0 && shares.every((share) => share > 0.2 && share < 0.8), `${both} ${ground} ${solid}`);
  await close(page);
});

test("gamuts of different spaces are refused, and references follow the space of the first gamut", async () => {
  const page = await open(browser, `/view#a=${balls.oklab}&b=srgb`, SIZE);
  const spaces = () => page.evaluate("window.gamutViewer.shown.map(({ gamut }) => gamut.options.space).join()");
  await page.waitForFunction("window.gamutViewer.figures.triangles[1] > 4");
  assert.equal(await spaces(), "Oklab,Oklab");
  await page.evaluate((key) => window.gamutViewer.show("c", key), balls.small);
  const sentence = await page.$eval("#problem", (box) => box.innerText);
  assert.match(sentence, /Small is in CIELAB\. Other space is in Oklab\./);
  assert.match(sentence, /Build Small again with the space Oklab/);
  assert.equal(await spaces(), "Oklab,Oklab");
  await page.evaluate((key) => window.gamutViewer.show("a", key), balls.small);
  await page.waitForFunction("window.gamutViewer.shown[1]?.gamut.options.space === 'CIELAB'");
  await page.evaluate((key) => window.gamutViewer.show("a", key), balls.oklab);
  await page.waitForFunction("window.gamutViewer.shown[1]?.gamut.options.space === 'Oklab'");
  // What cannot follow is taken away, and the page says so.
  await page.evaluate((key) => window.gamutViewer.show("b", key), balls.oklab);
  await page.evaluate(() => window.gamutViewer.show("a", null));
  await page.evaluate((key) => window.gamutViewer.show("a", key), balls.small);
  assert.equal(await spaces(), "CIELAB");
  assert.match(await page.$eval("#problem", (box) => box.innerText), /Other space is in Oklab/);
  await close(page);
});
