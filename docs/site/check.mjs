// Checks the built site in Chromium: axe-core finds nothing, pictures keep their colours,
// and phones show the whole width.
// Run by `make docs` with the folder of the site.
import { createReadStream, existsSync } from "node:fs";
import { createServer } from "node:http";
import { join, normalize } from "node:path";
import process from "node:process";
import { chromium, violations } from "../../web/viewer/tests/pages.mjs";

const [folder] = process.argv.slice(2);
const PAGES = ["docs/start.html", "docs/gallery.html", "docs/api/gamutcore.results.html"];
const TYPES = { html: "text/html", css: "text/css", js: "text/javascript", svg: "image/svg+xml" };

const server = createServer((request, response) => {
  const path = join(folder, normalize(new URL(request.url, "http://site").pathname));
  const isThere = existsSync(path);
  response.writeHead(isThere ? 200 : 404, { "Content-Type": TYPES[path.split(".").pop()] ?? "application/octet-stream" });
  if (isThere) createReadStream(path).pipe(response);
  else response.end();
});
await new Promise((ready) => server.listen(0, "127.0.0.1", ready));
const site = `http://127.0.0.1:${server.address().port}`;

const browser = await chromium();
const faults = [];
try {
  for (const path of PAGES) {
    for (const [scheme, width] of [["light", 1280], ["dark", 1280], ["light", 390]]) {
      const page = await browser.newPage();
      await page.setViewport({ width, height: 720 });
      await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
      await page.goto(`${site}/${path}`);
      const found = await violations(page);
      const filtered = await page.evaluate(() =>
        [...document.images].filter((each) => getComputedStyle(each).filter !== "none").map((each) => `filter: ${each.src}`),
      );
      const isWider = await page.evaluate("document.documentElement.scrollWidth > innerWidth");
      if (isWider) found.push("the page is wider than the window");
      faults.push(...[...found, ...filtered].map((fault) => `${path}, ${scheme}, ${width}: ${fault}`));
      if (process.env.SCREENSHOTS) {
        await page.screenshot({ path: `${process.env.SCREENSHOTS}/${path.replaceAll("/", "-")}-${scheme}-${width}.png` });
      }
      await page.close();
    }
  }
} finally {
  await browser.close();
  server.close();
}
for (const fault of faults) console.error(fault);
process.exitCode = faults.length ? 1 : 0;
