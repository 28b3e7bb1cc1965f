// The ten tasks of a visitor, in Chromium over a real server, at 1440 × 900.
//
//   VIEWER_URL=... CHROMIUM=... [TASK_PICTURES=FOLDER] node --test tasks.test.mjs
//
// A task takes at most three clicks, and nobody scrolls. A press of the mouse and a drag are one click
// each. So is an entry of a list of choices. To press a field and type into it is one, and so are all
// files of one dialogue or drop. What is pressed is in sight, and so is the answer. With TASK_PICTURES,
// a picture of each answer is saved there.
import assert from "node:assert/strict";
import { mkdtemp, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import process from "node:process";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { chromium, close, open } from "./pages.mjs";
import { srgbGrid } from "./srgb.mjs";

const { TASK_PICTURES, VIEWER_URL } = process.env;
const MOST_CLICKS = 3;
const repository = (path) => fileURLToPath(new URL(`../../../${path}`, import.meta.url));

let browser, folder;
before(async () => {
  browser = await chromium();
  folder = await mkdtemp(join(tmpdir(), "tasks-"));
});
after(async () => {
  await browser.close();
  await rm(folder, { recursive: true });
});

/** Where an element is in the window, and whether all of it is in sight: not cut off and not covered. */
function place(page, selector) {
  return page.$eval(selector, async (element) => {
    const [entry] = await new Promise((resolve) => new IntersectionObserver(resolve).observe(element));
    const { left, top, width, height } = entry.boundingClientRect;
    const [x, y] = [left + width / 2, top + height / 2];
    const front = document.elementFromPoint(x, y);
    // What the pointer goes through is in front of everything.
    const isThrough = getComputedStyle(element).pointerEvents === "none";
    const isInFront = isThrough || (front !== null && (element.contains(front) || front.contains(element)));
    return { left, top, width, height, x, y, isInSight: entry.intersectionRatio >= 0.999 && isInFront };
  });
}

class Visit {
  clicks = 0;

  constructor(page) {
    this.page = page;
  }

  /** Press where an element is, by default in its middle. */
  async click(selector, across = 0.5) {
    this.clicks += 1;
    await this.page.waitForSelector(`${selector}:not([disabled])`);
    const { left, width, y, isInSight } = await place(this.page, selector);
    assert.ok(isInSight, `${selector} is out of sight`);
    await this.page.mouse.click(left + across * width, y);
  }

  async type(selector, text) {
    await this.click(selector);
    await this.page.$eval(selector, (field, value) => {
      field.value = value; // pasted at once
      field.dispatchEvent(new Event("input"));
    }, text);
  }

  async choose(selector, value) {
    this.clicks += 1;
    assert.ok((await place(this.page, selector)).isInSight, `${selector} is out of sight`);
    await this.page.select(selector, value);
  }

  async openFiles(button, ...paths) {
    const [chooser] = await Promise.all([this.page.waitForFileChooser(), this.click(button)]);
    this.clicks += 1;
    await chooser.accept(paths);
  }

  /** The text of an element, once it is there and matches. */
  async read(selector, pattern) {
    const text = await this.page.waitForFunction(
      (where, source) => {
        const { textContent } = document.querySelector(where) ?? { textContent: "" };
        return new RegExp(source).test(textContent) && textContent;
      },
      {},
      selector,
      pattern.source,
    );
    return (await text.jsonValue()).replaceAll("−", "-");
  }

  /** End a task: its answers are in sight, after few clicks and without scrolling. */
  async end(name, ...answers) {
    const { page } = this;
    // A view at rest, so that the picture is what a visitor sees.
    await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
    if (TASK_PICTURES) await page.screenshot({ path: join(TASK_PICTURES, `${name}.png`) });
    for (const selector of answers) assert.ok((await place(page, selector)).isInSight, `${selector} is out of sight`);
    assert.ok(this.clicks <= MOST_CLICKS, `${this.clicks} clicks`);
    assert.equal(await page.evaluate("document.scrollingElement.scrollTop"), 0);
    await close(page);
  }
}

async function visit(path = "/", state = {}) {
  const page = await open(browser, path, { width: 1440, height: 900, isOpen: false, scale: TASK_PICTURES ? 1 : 0.5, ...state });
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
  return new Visit(page);
}

async function get(path) {
  return (await fetch(`${VIEWER_URL}/v1/${path}`)).json();
}

async function post(path, body) {
  const headers = { "Content-Type": "application/json" };
  return (await fetch(`${VIEWER_URL}/v1/${path}`, { method: "POST", body: JSON.stringify(body), headers })).json();
}

/** Ids of the gamuts that a page shows, as the service knows them. */
function ids(page) {
  return page.evaluate("window.gamutViewer.shown.map(({ gamut }) => gamut.id)");
}

/** The share of points that a gamut contains. */
async function contained(id, points) {
  const { inside } = await post(`gamuts/${id}/contains`, { colours: points });
  return inside.filter((each) => each).length / points.length;
}

const number = (text) => Number(text.replaceAll(",", ""));
const near = (value, expected, tolerance, what) =>
  assert.ok(Math.abs(value - expected) <= tolerance, `${what}: ${value} instead of ${expected}`);
const LIGHTNESSES = Array.from({ length: 50 }, (_, i) => 1 + 2 * i);
const steps = (from, to, step) => Array.from({ length: Math.round((to - from) / step) + 1 }, (_, i) => from + i * step);

test("1: the gamut of a profile, and its volume", async () => {
  const task = await visit();
  await task.openFiles("#upload", repository("tests/data/sRGB-v2-magic.icc"));
  await task.page.waitForFunction("window.gamutViewer.at('a')?.gamut.provenance.format === 'icc'");
  const [, volume] = /([\d,]+) cubic/.exec(await task.read(".gamut-row[data-slot=a] .volume", /cubic ΔE\*ab/));
  // The profile is that of sRGB.
  near(number(volume), 8 * srgbGrid(2, LIGHTNESSES).length, 8000, "volume");
  await task.page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
  await task.end("1-profile", ".gamut-row[data-slot=a] .volume", "#view");
});

test("2: two presses, and how much of each the other one has", async () => {
  const task = await visit();
  const files = ["FOGRA39L", "FOGRA29L"].map((name) => repository(`examples/${name}.ti3`));
  await task.openFiles("#upload", ...files);
  await task.read("#coverage", /FOGRA29.*ΔE00/s);
  const text = await task.read("#answer", /FOGRA39L covers .*FOGRA29/s);
  const [both, back] = [...text.matchAll(/covers (?:over )?(\d+) %/g)].map((match) => Number(match[1]) / 100);
  const [coated, uncoated] = await ids(task.page);
  // Points of a grid that both gamuts contain, over those that one contains.
  const points = steps(8, 98, 10).flatMap((l) => steps(-76, 84, 8).flatMap((a) => steps(-60, 100, 8).map((b) => [l, a, b])));
  const within = await Promise.all([coated, uncoated].map(async (id) => (await post(`gamuts/${id}/contains`, { colours: points })).inside));
  const count = (has) => points.filter((_, i) => has(within[0][i], within[1][i])).length;
  const common = count((one, other) => one && other);
  near(both, common / count((_, other) => other), 0.03, "FOGRA39L covers");
  near(back, common / count((one) => one), 0.03, "FOGRA29 covers");
  await task.end("2-presses", "#answer");
});

test("3: brand colours are checked", async () => {
  const task = await visit();
  await task.click("#colours-part > summary");
  // The white of the paper is the white of a relative gamut; the blue of a screen is no ink.
  await task.type("#colours", "House grey lab(50 0 0)\nPaper lab(100 0 0)\n#0000ff");
  await task.click("#check");
  assert.match(await task.read("#colours-note", /inside/), /^3 colours: 1 inside, 1 edge, 1 outside/);
  await task.read("#colours-table", /Recipe/);
  const rows = await task.page.$$eval("#colours-table tbody tr", (all) => all.map((row) => row.children[1].textContent));
  assert.deepEqual(rows, ["inside", "edge", "outside"]);
  await task.end("3-colours", "#colours-note", "#colours-table", "#colours-table tbody tr:last-child");
});

test("4: a gamut of 4 triangles, and of all", async () => {
  const task = await visit("/view#a=srgb");
  const { counts } = await get("gamuts/srgb");
  await task.click("#display > summary");
  await task.click("#slider", 0.01);
  await task.page.waitForFunction("window.gamutViewer.figures.triangles[0] === 4");
  assert.match(await task.read("#level-note", /sRGB: 4,/), /within 1?\d\d ΔE\*ab/);
  assert.ok((await place(task.page, "#level-note")).isInSight);
  await task.click("#slider", 0.99);
  await task.page.waitForFunction((all) => window.gamutViewer.figures.triangles[0] === all, {}, counts.triangles);
  assert.match(await task.read("#level-note", /full/), new RegExp(`^sRGB: ${counts.triangles.toLocaleString("en")}, the full boundary`));
  await task.end("4-triangles", "#level-note", "#triangles");
});

test("5: a cut at a lightness of 50", async () => {
  const task = await visit();
  await task.click("#cut > summary");
  await task.choose("#slice-kind", "lightness");
  const text = await task.read("#section-chart", /sRGB, area [\d,]+/);
  assert.match(text, /L\*? 50/);
  const area = number(/sRGB, area ([\d,]+)/.exec(text)[1]);
  near(area, srgbGrid(1, [50]).length, 0.02 * area, "area of sRGB at L* 50");
  await task.end("5-cut", "#section-chart", "#slice-row");
});

test("6: the recipe of a colour", async () => {
  const task = await visit();
  await task.click("#colours-part > summary");
  await task.type("#colours", "Brown lab(50 30 20)");
  await task.click("#check");
  await task.read("#colours-table tbody", /C \d+ +M \d+ +Y \d+ +K \d+/);
  const cells = await task.page.$$eval("#colours-table tbody td", (all) => all.map((cell) => cell.textContent));
  const recipe = cells.find((cell) => /^C \d/.test(cell));
  const device = [...recipe.matchAll(/[CMYK] +(\d+)/g)].map(([, value]) => Number(value) / 100);
  // The inks, printed, give the colour.
  const [id] = await ids(task.page);
  const { colour } = await post(`gamuts/${id}/colours`, { device: [device] });
  near(Math.hypot(...colour[0].map((value, i) => value - [50, 30, 20][i])), 0, 1.5, `colour of ${device}`);
  await task.end("6-recipe", "#colours-table tbody tr");
});

test("7: a photograph against the press", async () => {
  const task = await visit();
  // A quarter is a green that no press has; the rest is grey.
  const content = await task.page.evaluate(() => {
    const canvas = Object.assign(document.createElement("canvas"), { width: 600, height: 400 });
    const context = canvas.getContext("2d");
    context.fillStyle = "rgb(119 119 119)";
    context.fillRect(0, 0, 600, 400);
    context.fillStyle = "rgb(0 255 0)";
    context.fillRect(0, 0, 300, 200);
    return canvas.toDataURL().split(",")[1];
  });
  const path = join(folder, "photo.png");
  await writeFile(path, Buffer.from(content, "base64"));
  await task.click("#picture > summary");
  await task.openFiles("#picture-open", path);
  assert.match(await task.read("#picture-note", /%/), /^25\.0 % of the pixels of photo\.png are out of reach of FOGRA39L/);
  await task.end("7-photo", "#picture-note", "#picture-canvas");
});

test("8: a picture for slides", async () => {
  const task = await visit();
  const { page } = task;
  await page.evaluate(() => {
    window.savedFile = new Promise((resolve) => {
      const create = URL.createObjectURL;
      URL.createObjectURL = (blob) => {
        if (blob.type === "image/png") resolve(blob);
        return create.call(URL, blob);
      };
      // The browser of the test keeps no file.
      HTMLAnchorElement.prototype.click = function () {
        window.savedName = this.download;
      };
    });
  });
  await task.click("#save");
  await page.waitForSelector("#take-away[open]");
  assert.ok((await place(page, "#take-away")).isInSight);
  await task.choose("#save-shape", "wide");
  if (TASK_PICTURES) await page.screenshot({ path: join(TASK_PICTURES, "8-dialogue.png") });
  await task.click("#save-file");
  const picture = await page.evaluate(async () => {
    const bitmap = await createImageBitmap(await window.savedFile);
    const { width, height } = bitmap;
    const context = new OffscreenCanvas(width, height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, width, height);
    const colours = new Set();
    for (let at = 0; at < data.length; at += 400) colours.add(`${data[at] >> 4} ${data[at + 1] >> 4} ${data[at + 2] >> 4}`);
    return { width, height, colours: colours.size, name: window.savedName };
  });
  assert.deepEqual([picture.width, picture.height], [1920, 1080]);
  assert.ok(picture.colours > 100, `${picture.colours} colours`);
  assert.match(picture.name, /FOGRA39L.*sRGB.*\.png$/);
  await task.end("8-slides", "#view");
});

test("9: a link to what is shown", async () => {
  const task = await visit("/view#a=srgb&b=display-p3&lightness=50");
  await task.page.waitForFunction("window.gamutViewer.figures.triangles[1] > 4");
  await task.page.evaluate(() => {
    window.copiedLink = new Promise((resolve) => {
      navigator.clipboard.writeText = async (text) => resolve(text);
    });
  });
  // The note goes after some seconds, so that the page itself looks at it when it comes.
  await task.page.evaluate(() => {
    const note = document.getElementById("stage-note");
    window.seenNote = new Promise((resolve) => {
      new MutationObserver(() => {
        const { left, top, right, bottom, width } = note.getBoundingClientRect();
        if (width > 0 && /copied/.test(note.textContent)) resolve(left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight);
      }).observe(note, { attributes: true, childList: true });
    });
  });
  await task.click("#share");
  const { pathname, hash } = new URL(await task.page.evaluate("window.copiedLink"));
  assert.ok(await task.page.evaluate("window.seenNote"));
  const other = await visit(pathname + hash);
  await other.page.waitForFunction("window.gamutViewer.figures.triangles[1] > 4");
  assert.deepEqual(await ids(other.page), await ids(task.page));
  const [before, after] = [await task.read("#answer", /of Display P3/), await other.read("#answer", /of Display P3/)];
  assert.equal(after, before);
  assert.match(await other.read("#section-chart", /area/), /L\*? 50/);
  await other.end("9-link", "#answer", "#section-chart");
  await task.end("9-copied");
});

test("10: volume and coverage are read from the page", async () => {
  const task = await visit();
  const text = await task.read("#answer", /reach/);
  const colours = srgbGrid(2, LIGHTNESSES);
  const [, volume] = /sRGB ([\d,]+) cubic ΔE\*ab/.exec(text);
  near(number(volume), 8 * colours.length, 8000, "volume of sRGB");
  const [, share] = /FOGRA39L covers (\d+) % of sRGB/.exec(text);
  const press = await task.page.evaluate("window.gamutViewer.at('a').gamut.id");
  await task.read("#coverage", /ΔE00/); // the service has the press now
  near(Number(share) / 100, await contained(press, colours.filter((_, i) => i % 40 === 0)), 0.03, "coverage");
  assert.equal(task.clicks, 0);
  await task.end("10-answer", "#answer", ".gamut-row[data-slot=a] .volume", ".gamut-row[data-slot=b] .volume");
});
