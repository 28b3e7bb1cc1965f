// Pages of the viewer in Chromium, driven over the DevTools protocol.
import process from "node:process";
import puppeteer from "puppeteer-core";

const url = process.env.VIEWER_URL;

/** Start Chromium; it draws without a graphics processor. */
export function chromium() {
  return puppeteer.launch({
    executablePath: process.env.CHROMIUM,
    args: [
      ...(process.getuid() === 0 ? ["--no-sandbox"] : []), // a container's root cannot use it
      "--disable-dev-shm-usage",
      "--enable-unsafe-swiftshader",
      "--use-angle=swiftshader",
      "--js-flags=--expose-gc",
    ],
  });
}

/** Open an address of the service. The page collects what the browser complains of. */
export async function open(browser, path, { width = 1100, height = 700, scheme = "light" } = {}) {
  const context = await browser.createBrowserContext();
  const page = await context.newPage();
  page.complaints = [];
  page.on("console", (message) => {
    if (["error", "warn"].includes(message.type())) page.complaints.push(message.text());
  });
  page.on("pageerror", (error) => page.complaints.push(error.message));
  await page.setViewport({ width, height, hasTouch: width < 600, isMobile: width < 600 });
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
  await page.goto(`${url}${path}`);
  await page.waitForFunction("window.gamutViewer !== undefined");
  return page;
}

export function figures(page) {
  return page.evaluate("window.gamutViewer.figures");
}

/** Wait until the first gamut, or both, are drawn with so many triangles. */
export async function drawn(page, ...triangles) {
  await page.waitForFunction(
    (wanted) => wanted.every((count, i) => window.gamutViewer.figures.triangles[i] === count),
    { timeout: 60_000 },
    triangles,
  );
}

/** Colour of the view at a place, as fractions of its size from the left and the top. */
export function pixel(page, x, y) {
  return page.evaluate(
    async (across, down) => {
      const picture = await createImageBitmap(await window.gamutViewer.view.picture());
      const canvas = new OffscreenCanvas(picture.width, picture.height);
      const context = canvas.getContext("2d");
      context.drawImage(picture, 0, 0);
      const at = [Math.floor(across * picture.width), Math.floor(down * picture.height)];
      return [...context.getImageData(...at, 1, 1).data.slice(0, 3)];
    },
    x,
    y,
  );
}
