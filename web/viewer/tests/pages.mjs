// Pages of the viewer in Chromium, driven over the DevTools protocol.
import assert from "node:assert/strict";
import { readFile, writeFile } from "node:fs/promises";
import { createRequire } from "node:module";
import process from "node:process";
import puppeteer from "puppeteer-core";

const axe = createRequire(import.meta.url).resolve("axe-core/axe.min.js");

/** Milliseconds that end a test that hangs. A slow machine does not come near. */
export const PATIENCE = Number(process.env.PATIENCE ?? 600_000);

/** A page without gamuts: one without any state opens on examples. */
export const EMPTY = "/view#triangles=10000";

/** Start Chromium; it draws without a graphics processor. */
export function chromium() {
  return puppeteer.launch({
    executablePath: process.env.CHROMIUM,
    timeout: PATIENCE,
    protocolTimeout: PATIENCE,
    args: [
      ...(process.getuid() === 0 ? ["--no-sandbox"] : []), // a container's root cannot use it
      "--disable-dev-shm-usage",
      "--enable-unsafe-swiftshader",
      "--use-angle=swiftshader",
      "--js-flags=--expose-gc",
    ],
  });
}

/** Pixels of the canvas per pixel of the page. The processor draws them, which is most of the tests' time. */
const FEW_PIXELS = 0.5;

/** Open an address of the service. The page collects what the browser complains of. */
export async function open(browser, path, { url = process.env.VIEWER_URL, width = 1100, height = 700, scale = FEW_PIXELS, scheme = "light", motion = "reduce", gamut = "srgb", isOffline = false, isTouch = width < 600, isOpen = true, ready = "window.gamutViewer !== undefined" } = {}) {
  // All pages share the browser's cache, which saves loading and compiling the scripts again.
  const page = await browser.newPage();
  page.setDefaultTimeout(PATIENCE);
  page.complaints = [];
  page.on("console", (message) => {
    if (message.location().url?.endsWith("/examples/index.json")) return; // a service without examples
    if (["error", "warn"].includes(message.type())) page.complaints.push(message.text());
  });
  page.on("pageerror", (error) => page.complaints.push(error.message));
  await page.setViewport({ width, height, deviceScaleFactor: scale, hasTouch: isTouch, isMobile: isTouch });
  await page.emulateMediaFeatures([
    { name: "prefers-color-scheme", value: scheme },
    { name: "prefers-reduced-motion", value: motion },
    { name: "color-gamut", value: gamut },
  ]);
  await page.setOfflineMode(isOffline);
  await page.goto(path.startsWith("file:") ? path : `${url}${path}`);
  await page.waitForFunction(ready);
  // Parts that are closed at first have their own tests.
  if (isOpen) await openParts(page);
  return page;
}

/** Open all parts of the panel. */
export async function openParts(page) {
  await page.$$eval("#panel details", (parts) => parts.forEach((part) => (part.open = true)));
}

/** Close a page. Its console must be empty. */
export async function close(page) {
  assert.deepEqual(page.complaints, []);
  await page.close();
}

/** What axe-core finds, by default with all rules. `foreign` has selectors of elements by rules that they may break. */
export async function violations(page, rules = null, foreign = {}) {
  // The policy of the page allows no injected script, so it is evaluated by the protocol.
  if (await page.evaluate("window.axe === undefined")) await page.evaluate(await readFile(axe, "utf8"));
  return page.evaluate(
    async (only, allowed) => {
      const { violations: found } = await axe.run({ resultTypes: ["violations"], ...(only === null ? {} : { runOnly: only }) });
      const isForeign = (id, [selector]) => id in allowed && document.querySelector(selector).matches(allowed[id]);
      return found
        .map(({ id, nodes }) => [id, nodes.filter(({ target }) => !isForeign(id, target))])
        .filter(([, nodes]) => nodes.length > 0)
        .map(([id, nodes]) => `${id}: ${nodes.map(({ html }) => html).join(" | ")}`);
    },
    rules,
    foreign,
  );
}

export function figures(page) {
  return page.evaluate("window.gamutViewer.figures");
}

/** Cells of the file that Save CSV of the list of colours gives. */
export async function savedCells(page) {
  const saved = await page.evaluate(() => {
    const made = new Promise((resolve) => {
      const create = URL.createObjectURL;
      URL.createObjectURL = (blob) => {
        resolve(blob.text());
        return create.call(URL, blob);
      };
    });
    document.getElementById("colours-csv").click();
    return made;
  });
  return saved.trim().split("\n").map((line) => line.split(","));
}

/** Wait until the first gamut, or both, are drawn with so many triangles. */
export async function drawn(page, ...triangles) {
  await page.waitForFunction(
    (wanted) => wanted.every((count, i) => window.gamutViewer.figures.triangles[i] === count),
    {},
    triangles,
  );
}

/** Where the plot of the chart of a section is on the page, once the chart is there. */
export async function plot(page) {
  const found = await page.waitForFunction(() => {
    const place = document.querySelector("#section-chart rect[fill=none]")?.getBoundingClientRect();
    return place?.width > 0 && place.toJSON();
  });
  return found.jsonValue();
}

/** Wait for pictures of the view; each of them moves what turns. */
export function pictures(page, count) {
  return page.evaluate(async (wanted) => {
    const { view } = window.gamutViewer;
    for (const end = view.frames + wanted; view.frames < end; await new Promise(requestAnimationFrame)) view.draw();
  }, count);
}

/** Colours of one picture of the view at places, as fractions of its size from the left and the top. */
export function pixels(page, places) {
  return page.evaluate(async (all) => {
    const picture = await createImageBitmap(await window.gamutViewer.view.picture());
    const canvas = new OffscreenCanvas(picture.width, picture.height);
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(picture, 0, 0);
    return all.map(([across, down]) => {
      const at = [Math.floor(across * picture.width), Math.floor(down * picture.height)];
      return [...context.getImageData(...at, 1, 1).data.slice(0, 3)];
    });
  }, places);
}

export async function pixel(page, x, y) {
  return (await pixels(page, [[x, y]]))[0];
}

const PICTURE_WIDTH = 220;

/**
 * A picture of the page without text, small enough for comparisons, as a PNG in base64.
 *
 * Text is transparent, because machines have different fonts.
 */
export async function smallPicture(page) {
  await page.evaluate(async () => {
    const sheet = new CSSStyleSheet();
    sheet.replaceSync("*, ::placeholder { color: transparent !important; } .labels, svg text { visibility: hidden; }");
    document.adoptedStyleSheets.push(sheet);
    await window.gamutViewer.view.picture();
  });
  const picture = await page.screenshot({ encoding: "base64" });
  return page.evaluate(
    async (source, width) => {
      const bytes = Uint8Array.from(atob(source), (character) => character.charCodeAt(0));
      const bitmap = await createImageBitmap(new Blob([bytes]), { resizeWidth: width, resizeQuality: "high" });
      const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
      canvas.getContext("2d").drawImage(bitmap, 0, 0);
      const small = new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer());
      return btoa(String.fromCharCode(...small));
    },
    picture,
    PICTURE_WIDTH,
  );
}

/** Mean difference of two pictures in base64, in 0 to 255, and the share of pixels that differ by over 40. */
export function difference(page, one, other) {
  return page.evaluate(
    async (...sources) => {
      const [a, b] = await Promise.all(
        sources.map(async (source) => {
          const bytes = Uint8Array.from(atob(source), (character) => character.charCodeAt(0));
          const { width, height } = await createImageBitmap(new Blob([bytes]));
          const context = new OffscreenCanvas(width, height).getContext("2d");
          context.drawImage(await createImageBitmap(new Blob([bytes])), 0, 0);
          return context.getImageData(0, 0, width, height);
        }),
      );
      if (a.width !== b.width || a.height !== b.height) return { mean: 255, far: 1 };
      let sum = 0;
      let far = 0;
      for (let i = 0; i < a.data.length; i += 4) {
        const differences = [0, 1, 2].map((channel) => Math.abs(a.data[i + channel] - b.data[i + channel]));
        sum += differences[0] + differences[1] + differences[2];
        if (Math.max(...differences) > 40) far += 1;
      }
      return { mean: (4 * sum) / (3 * a.data.length), far: (4 * far) / a.data.length };
    },
    one,
    other,
  );
}

/** The stored picture of a name; with UPDATE_PICTURES=1 the given one is stored first. */
export async function storedPicture(name, picture) {
  const path = new URL(`pictures/${name}.png`, import.meta.url);
  if (process.env.UPDATE_PICTURES === "1") await writeFile(path, picture, "base64");
  return readFile(path, "base64");
}
