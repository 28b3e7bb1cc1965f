import process from "node:process";
import { chromium, open } from "./pages.mjs";
const browser = await chromium();
const sizes = (process.env.SIZES ?? "820x1180").split(" ");
for (const size of sizes) {
  const [width, height] = size.split("x").map(Number);
  for (const scheme of (process.env.SCHEMES ?? "light").split(" ")) {
    const page = await open(browser, process.env.SHOT_PATH ?? "/view", { width, height, scheme, scale: 1, isOpen: false, isTouch: width < 1000 });
    await page.waitForFunction("window.gamutViewer.figures.triangles.every((count) => count > 4)");
    await new Promise((r) => setTimeout(r, 1500));
    await page.screenshot({ path: `/tmp/v51/${process.env.NAME ?? "first"}-${size}-${scheme}.png` });
    if (process.env.CUT) {
      await page.evaluate("window.gamutViewer.view.turn(0.9, 0.25)");
      await page.evaluate(() => { document.getElementById("cut").open = true; const s = document.getElementById("slice-kind"); s.value = process_kind(); s.dispatchEvent(new Event("change", {bubbles: true})); function process_kind() { return "lightness"; } });
      await page.waitForSelector("#section-chart svg");
      await new Promise((r) => setTimeout(r, 1500));
      await page.screenshot({ path: `/tmp/v51/cut-${size}-${scheme}.png` });
      await page.$eval("#slice-row", (b) => b.scrollIntoView({block: "center"}));
      await new Promise((r) => setTimeout(r, 700));
      await page.screenshot({ path: `/tmp/v51/cutrow-${size}-${scheme}.png` });
    }
    if (page.complaints.length) console.log(size, scheme, page.complaints);
    await page.close();
  }
}
await browser.close();
