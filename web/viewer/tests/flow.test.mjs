// The way through the viewer in Chromium: first screen, chips, several files, cancel, search, layouts.
//
//   VIEWER_URL=... CHROMIUM=... FIRST=ID SECOND=ID FINEST=N SAMPLES=FILE node --test flow.test.mjs
import assert from "node:assert/strict";
import process from "node:process";
import { after, afterEach, before, test } from "node:test";
import { standIn } from "./examples.mjs";
import { EMPTY, chromium, close, drawn, figures, open, violations } from "./pages.mjs";

const { FIRST, SECOND, SAMPLES } = process.env;
const FINEST = Number(process.env.FINEST);

let browser;
let service;
before(async () => {
  service = await standIn({ press: FIRST, srgb: SECOND, samples: SAMPLES });
  browser = await chromium();
});
after(async () => {
  await browser.close();
  service.close();
});

afterEach(() => {
  service.cold.isCold = false;
});

const textOf = (page, selector) => page.$eval(selector, (box) => box.innerText);

test("a service that has just started shows examples at once, and says what it prepares", async () => {
  service.cold.isCold = true;
  service.cold.asked.length = 0;
  const page = await open(browser, "/view", { url: service.url, motion: "no-preference" });
  await page.waitForFunction("window.gamutViewer.figures.triangles.every((count) => count > 4)");
  const start = await page.evaluate("window.gamutViewer.view.place");
  await page.waitForFunction((from) => window.gamutViewer.view.place.some((value, i) => Math.abs(value - from[i]) > 0.05), {}, start);
  await page.waitForFunction("/Preparing the service: 4 of 9 kernels compiled/.test(document.getElementById('preparation').innerText)");
  assert.equal(await page.$eval("#preparation progress", (bar) => bar.value / bar.max), 4 / 9);
  // The answer about examples comes with them.
  assert.match(await textOf(page, "#answer"), /^Ball A covers 49 % of Ball B\n+Ball B covers over 99 % of Ball A\n+Volumes: Ball A [\d,]+, Ball B [\d,]+ cubic ΔE\*ab\.\n+Ball A reaches further in cyan \(170–250°\); Ball B reaches further everywhere else\.$/);
  assert.equal(await page.$eval("#problem", (box) => box.checkVisibility()), false);
  assert.match(await textOf(page, "#legend"), /Ball A\s+Ball B/);
  // The pictures need no history of the service, and nothing is in the address until somebody acts.
  assert.deepEqual(service.cold.asked.filter((asked) => asked.includes("/history")), []);
  assert.equal(new URL(page.url()).hash, "");
  service.cold.isCold = false;
  await page.waitForFunction("/covers/.test(document.getElementById('coverage').textContent)");
  await page.click("#view");
  assert.match(new URL(page.url()).hash, /^#a=press&b=srgb/);
  const [place, later] = await page.evaluate(async () => {
    const { view } = window.gamutViewer;
    const now = view.place;
    view.draw();
    for (let i = 0; i < 3; i++) await new Promise(requestAnimationFrame);
    return [now, view.place];
  });
  assert.deepEqual(later, place);
  await close(page);
});

test("the first gamut is five stops of the Tab key from the top, and parts open and close", async () => {
  const page = await open(browser, "/view", { url: service.url, isOpen: false });
  await page.waitForFunction("window.gamutViewer.figures.triangles.every((count) => count > 4)");
  const stops = [];
  for (let i = 0; i < 5 && stops.at(-1) !== "chooser-a"; i++) {
    await page.keyboard.press("Tab");
    stops.push(await page.evaluate("document.activeElement.id || document.activeElement.textContent.trim()"));
  }
  assert.equal(stops.at(-1), "chooser-a", stops.join());
  const parts = () => page.$$eval(".part", (all) => all.map(({ open, firstElementChild }) => [firstElementChild.innerText.toLowerCase(), open]));
  assert.deepEqual(await parts(), [["gamuts", true], ["compare", true], ["cut", false], ["colours", false], ["picture", false]]);
  assert.deepEqual(await violations(page), []);
  await page.click("#cut > summary");
  await page.select("#slice-kind", "lightness");
  await page.waitForFunction("location.hash.includes('lightness=')");
  await page.reload();
  await page.waitForSelector("#section-chart svg");
  assert.deepEqual((await parts())[2], ["cut", true]);
  await close(page);
});

test("a chip shows its example as the first gamut, and by its plus as the second", async () => {
  const page = await open(browser, EMPTY, { url: service.url });
  await page.waitForSelector("[data-key=srgb]");
  await page.click("[data-key=srgb]");
  await page.waitForFunction("/^Ball B/.test(document.title)");
  await page.click("[data-key=press] + button");
  await page.waitForFunction("/Ball B\\s+Ball A/.test(document.getElementById('legend').innerText)");
  assert.equal(await page.$eval("[data-key=press]", (chip) => chip.ariaPressed), "true");
  await close(page);
});

function drop(page, files, selector = "body") {
  return page.evaluate(
    (given, place) => {
      const dataTransfer = new DataTransfer();
      for (const [name, text] of given) dataTransfer.items.add(new File([text], name));
      for (const type of ["dragenter", "drop"]) {
        document.querySelector(place).dispatchEvent(new DragEvent(type, { bubbles: true, dataTransfer }));
      }
    },
    files,
    selector,
  );
}

/** Other samples: the same with another first colour. */
const samples = (lightness) => `${SAMPLES}\n${lightness},0,0`;

test("several files fill the rows in order, and a file on a row replaces that one", async () => {
  const page = await open(browser, EMPTY);
  await drop(page, [["one.csv", samples(50.5)], ["two.csv", samples(51.5)]]);
  await page.waitForFunction("/^one.csv – two.csv/.test(document.title)");
  await drop(page, [["three.csv", samples(52.5)]], "[data-slot=b] input");
  await page.waitForFunction("/^one.csv – three.csv/.test(document.title)");
  assert.equal(await page.$eval("#drop", (box) => box.checkVisibility()), false);
  await close(page);
});

test("a build that is cancelled leaves the view as it was, without an error", async () => {
  const page = await open(browser, `/view#a=${FIRST}`, { url: service.url });
  await drawn(page, FINEST);
  service.cold.isCold = true;
  await drop(page, [["slow.csv", samples(53.5)]]);
  await page.waitForFunction("/slow.csv.*Preparing the service: 4 of 9 kernels compiled, only once · \\d+ s/s.test(document.querySelector('.waiting').innerText)");
  assert.deepEqual(await violations(page), []);
  assert.match(await textOf(page, ".options-line span"), /colours as given · no ink limit · CIELAB$/);
  await page.click(".work .cancel");
  assert.equal(await page.$(".work"), null);
  assert.match(await textOf(page, "#stage-note"), /slow\.csv was cancelled/);
  service.cold.isCold = false;
  assert.equal(await page.$eval("#problem", (box) => box.checkVisibility()), false);
  assert.equal((await figures(page)).triangles[0], FINEST);
  assert.match(await page.title(), /^Ball A/);
  await close(page);
});

test("the options of a reference are changed without a file", async () => {
  const page = await open(browser, "/view#a=srgb");
  await page.waitForFunction("/^sRGB/.test(document.title)");
  await page.click(".options-line button");
  await page.select("#space", "Oklab");
  await page.click("#rebuild");
  await page.waitForFunction("/Oklab/.test(document.querySelector('.options-line span').textContent)");
  await page.waitForFunction("/, 1 × sRGB$/m.test(document.getElementById('facts').innerText)");
  await page.waitForFunction("decodeURIComponent(location.hash).includes('a=srgb?intent=relative&space=Oklab')");
  await close(page);
});

test("the list of gamuts is as wide as the panel, and each name and detail stands on one line", async () => {
  for (const [width, height] of [[1440, 900], [820, 1180], [390, 844]]) {
    for (const scheme of ["light", "dark"]) {
      const page = await open(browser, EMPTY, { width, height, scheme });
      await page.click("#chooser-b");
      await page.keyboard.type("adobe");
      await page.waitForFunction("/Adobe/.test(document.querySelector('[role=option]')?.textContent)");
      const { list, row, lines } = await page.evaluate(() => {
        const box = document.querySelector("[role=listbox]:not([hidden])");
        const texts = document.createTreeWalker(box, NodeFilter.SHOW_TEXT);
        const found = [];
        for (let text = texts.nextNode(); text !== null; text = texts.nextNode()) {
          const range = document.createRange();
          range.selectNode(text);
          const tops = new Set([...range.getClientRects()].map(({ top }) => Math.round(top)));
          found.push([text.data, tops.size]);
        }
        return { list: box.clientWidth, row: box.closest(".gamut-row").clientWidth, lines: found };
      });
      assert.ok(list > row - 4, `${list} of ${row} pixels at ${width}`);
      assert.ok(lines.length >= 4);
      assert.deepEqual(lines.filter(([text, count]) => text.length < 36 && count > 1), [], `at ${width}`);
      await close(page);
    }
  }
});

test("the list of gamuts begins with the common references, and ends with those of film production", async () => {
  const page = await open(browser, EMPTY);
  await page.click("#chooser-a");
  await page.waitForSelector("[role=option]");
  const names = await page.$$eval("[role=option]", (options) => options.map(({ firstChild }) => firstChild.data));
  assert.deepEqual(names.slice(0, 4), ["sRGB", "Display P3", "ITU-R BT.2020", "Adobe RGB (1998)"]);
  const [own, other] = [names.indexOf("Ball A"), names.indexOf("ProPhoto RGB")];
  assert.ok(own >= 4 && own < other, `Ball A at ${own}, ProPhoto RGB at ${other}`);
  const film = names.findIndex((name) => name.startsWith("ACES"));
  assert.ok(film > other && names.slice(film).every((name) => name.startsWith("ACES")), names.slice(-6).join());
  await close(page);
});

test("the distance of a level is a number without an exponent", async () => {
  const page = await open(browser, "/view#a=srgb&triangles=4");
  await page.waitForFunction("/sRGB: 4, /.test(document.getElementById('level-note').textContent)");
  // Four triangles are more than 99.5 from the surface of sRGB.
  assert.match(await textOf(page, "#level-note"), /^sRGB: 4, within \d{3} ΔE\*ab$/);
  await close(page);
});

test("the search ranks exact names first, and names with aliases before similar ones", async () => {
  const page = await open(browser, EMPTY);
  for (const [typed, first] of [["Rec2020", "bt2020"], ["bt2020", "bt2020"], ["AdobeRGB", "adobe-rgb"], ["ball b", "Ball B"], ["prophoto", "prophoto"], ["display-p3", "display-p3"], ["P3", "display-p3"], ["srgb", "srgb"]]) {
    await page.click("#chooser-b", { count: 3 });
    await page.keyboard.press("Backspace");
    await page.keyboard.type(typed);
    await page.waitForFunction(
      (wanted) => document.querySelector("[role=option]")?.textContent.includes(wanted),
      {},
      first,
    );
    await page.keyboard.press("Escape");
  }
  await close(page);
});

/** Faults of the layout that no picture is needed for. */
function faults(page) {
  return page.evaluate(() => {
    const found = [];
    const isTouch = matchMedia("(pointer: coarse)").matches;
    const words = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    for (let node = words.nextNode(); node !== null; node = words.nextNode()) {
      const box = node.parentElement;
      if (node.textContent.trim() === "" || !box.checkVisibility() || box.closest(".hidden-text, script, style")) continue;
      if (parseFloat(getComputedStyle(box).fontSize) < 11) found.push(`small text: ${node.textContent.trim().slice(0, 40)}`);
    }
    for (const control of document.querySelectorAll("button, select, input, textarea, summary, nav a")) {
      // Terms are parts of lines of text, and the label of a box is pressed with it.
      if (!control.checkVisibility() || control.matches("input[type=file]")) continue;
      const { width, height } = (control.closest("label") ?? control).getBoundingClientRect();
      const least = isTouch && !control.matches(".term") ? 44 : 24;
      if (height < least - 0.5 || width < 24 - 0.5) found.push(`small control: ${control.id || control.textContent} ${width} × ${height}`);
    }
    const { left, top, width, height } = document.getElementById("view").getBoundingClientRect();
    for (const across of [0.35, 0.5, 0.65]) {
      for (const down of [0.35, 0.5, 0.65]) {
        const hit = document.elementFromPoint(left + across * width, top + down * height);
        if (hit?.id !== "view" && hit?.closest(".labels, #plane-handle") === null) found.push(`over the view: ${hit?.id || hit?.className || hit?.tagName}`);
      }
    }
    if (document.documentElement.scrollWidth > innerWidth) found.push("wider than the window");
    for (const button of document.querySelectorAll("header button")) {
      const { right, bottom } = button.getBoundingClientRect();
      if (right > innerWidth || bottom > innerHeight) found.push(`outside: ${button.id}`);
    }
    return [...new Set(found)];
  });
}

const SIZES = {
  "a mouse": [[1280, 720], [1440, 900]],
  "a finger": [[820, 1180], [390, 844], [844, 390]],
};

for (const [pointer, sizes] of Object.entries(SIZES)) {
  test(`with ${pointer}, nothing covers the solids, and everything can be read and pressed`, async () => {
    const isTouch = pointer === "a finger";
    const [width, height] = sizes[0];
    const page = await open(browser, "/view", { url: service.url, width, height, isTouch });
    await page.waitForFunction("window.gamutViewer.figures.triangles.every((count) => count > 4)");
    await page.click("#view");
    for (const [width, height] of sizes) {
      await page.setViewport({ ...page.viewport(), width, height });
      for (const kind of ["off", "lightness"]) {
        await page.select("#slice-kind", kind);
        await page.waitForSelector(kind === "off" ? "#section[hidden]" : "#section-chart svg");
        for (const scheme of ["light", "dark"]) {
          await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
          // The view follows the window at the next picture.
          await page.waitForFunction(
            (wide) => innerWidth === wide && (({ width, height, clientWidth, clientHeight }) =>
              width === Math.floor(clientWidth * devicePixelRatio) && height === Math.floor(clientHeight * devicePixelRatio))(window.gamutViewer.canvas),
            {},
            width,
          );
          assert.deepEqual(await faults(page), [], `${width} × ${height}, ${scheme}, section: ${kind}`);
        }
      }
    }
    assert.deepEqual(await violations(page), []);
    await close(page);
  });
}
