// Recipes in the viewer, in Chromium over a real server: in the list of colours, and in a slice.
//
//   VIEWER_URL=... CHROMIUM=... PRESS=ID FIRST=ID node --test recipes.test.mjs
//
// The press has the inks C, M, Y and K, and 300 % at most. The first gamut is of colours only.
import assert from "node:assert/strict";
import process from "node:process";
import { after, before, test } from "node:test";
import { chromium, close, open, plot, savedCells, violations } from "./pages.mjs";

const { PRESS, FIRST, VIEWER_URL } = process.env;
const LIST = "Brown, 50, 30, 20\nOrange, 50, 0, 110";

let browser;
before(async () => {
  browser = await chromium();
});
after(() => browser.close());

/** Check a list, and wait for its table; the recipes come later. */
async function check(page, text) {
  await page.$eval("#colours", (area, value) => {
    area.value = value;
  }, text);
  await page.click("#check");
  await page.waitForSelector("#colours-table table");
}

/** Cells of each row by the heads of their columns. */
function table(page) {
  return page.$eval("#colours-table table", (all) => {
    const [head, ...rows] = [...all.rows].map((row) => [...row.cells].map((cell) => cell.textContent));
    return rows.map((cells) => Object.fromEntries(head.map((name, i) => [name, cells[i]])));
  });
}

async function withRecipes(page) {
  await page.waitForFunction("/Recipe/.test(document.getElementById('colours-table').textContent)");
  return table(page);
}

async function ask(path, body) {
  const response = await fetch(`${VIEWER_URL}/v1/gamuts/${PRESS}/${path}`, {
    method: "POST",
    body: JSON.stringify(body),
    headers: { "Content-Type": "application/json" },
  });
  return response.json();
}

/** Inks in per cent of a text such as C 15 M 62 Y 55 K 21. */
function inks(text) {
  return Object.fromEntries([...text.matchAll(/([CMYK]) +(\d+)/g)].map(([, name, value]) => [name, Number(value)]));
}

test("a list has the recipe of each colour, inside and outside, with the range of black", async () => {
  const page = await open(browser, `/view#a=${PRESS}`, { scheme: "dark" });
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
  // The answer waits, so that the list without recipes can be seen.
  await page.evaluate(() => {
    const ask = window.fetch;
    window.fetch = async (...given) => {
      if (/\/recipes$/.test(given[0])) await new Promise((resolve) => { window.letRecipesCome = resolve; });
      return ask(...given);
    };
  });
  await check(page, LIST);
  assert.match(await page.$eval("#colours-recipes", (note) => note.textContent), /on their way/);
  assert.deepEqual((await table(page)).map((row) => row.Where), ["inside", "outside"]);
  await page.evaluate(() => window.letRecipesCome());
  const [brown, orange] = await withRecipes(page);
  assert.equal(await page.$eval("#colours-recipes", (note) => note.textContent), "");
  assert.deepEqual(await violations(page), []);

  // The device model, asked itself, gives the colours of the printed recipes: rounded to 1 %.
  const device = [brown, orange].map((row) => Object.values(inks(row["Recipe, %"])).map((value) => value / 100));
  const { colour } = await ask("colours", { device });
  const distance = (a, b) => Math.hypot(...a.map((value, i) => value - b[i]));
  assert.ok(distance(colour[0], [50, 30, 20]) < 1.5, colour[0]);
  const nearest = orange.Nearest.replaceAll("−", "-").split(" ").map(Number);
  assert.ok(distance(colour[1], nearest) < 2.5, `${colour[1]} ${nearest}`);
  for (const row of [brown, orange]) {
    const values = Object.values(inks(row["Recipe, %"]));
    assert.equal(values.length, 4);
    assert.ok(values.reduce((sum, value) => sum + value, 0) <= 302);
  }
  assert.ok(Number(brown["Recipe ΔE00"]) <= 0.1, brown["Recipe ΔE00"]);
  const [least, most] = brown["Possible K, %"].split("–").map(Number);
  const { K } = inks(brown["Recipe, %"]);
  assert.ok(least <= K && K <= most && most - least > 10, `${K} ${least} ${most}`);
  const ends = await Promise.all(["none", "maximum"].map((black) => ask("recipes", { colours: [[50, 30, 20]], black })));
  assert.deepEqual(ends.map((end) => Math.round(100 * end.device[0][3])), [least, most]);

  const [head, ...lines] = await savedCells(page);
  const saved = lines.map((cells) => Object.fromEntries(head.map((name, i) => [name, cells[i]])));
  // The table is rounded to 1 %, the file is not.
  saved.forEach((row, i) => ["C %", "M %", "Y %", "K %"].forEach((name, ink) => assert.ok(Math.abs(Number(row[name]) - 100 * device[i][ink]) < 0.51, `${name}: ${row[name]}`)));
  assert.deepEqual(["least black %", "most black %"].map((name) => Math.round(saved[0][name])), [least, most]);

  await page.click("#colours-clear");
  await page.waitForSelector("#colours-table[hidden]");
  await close(page);
});

test("device values of a display are per cent as well, and it has no black", async () => {
  const page = await open(browser, "/view#a=srgb");
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
  await check(page, "Olive rgb(120, 130, 40)");
  const [olive] = await withRecipes(page);
  assert.equal(olive["Recipe, %"], "R 47 G 51 B 16");
  assert.deepEqual(Object.keys(olive), ["Colour", "Where", "ΔE00", "Recipe, %", "Recipe ΔE00", "Euclidean distance", "Nearest"]);
  await close(page);
});

test("colours alone have no recipes and no fault, and what fails leaves the list as it is", async () => {
  let page = await open(browser, `/view#a=${FIRST}`);
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
  await check(page, "50,0,0\n50,60,0");
  assert.deepEqual(Object.keys((await table(page))[0]), ["Colour", "Where", "ΔE00", "Euclidean distance", "Nearest"]);
  assert.equal(await page.$eval("#colours-recipes", (note) => note.textContent), "");
  await close(page);

  page = await open(browser, `/view#a=${PRESS}`);
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
  await page.evaluate(() => {
    const ask = window.fetch;
    const problem = { title: "No model", detail: "The data is gone.", remedy: "Post it again.", code: "no-device-model", status: 422 };
    const headers = { "Content-Type": "application/problem+json" };
    window.fetch = (...given) =>
      /\/recipes$/.test(given[0]) ? Promise.resolve(Response.json(problem, { status: 422, headers })) : ask(...given);
  });
  await check(page, LIST);
  await page.waitForFunction("/There are no recipes/.test(document.getElementById('colours-recipes').textContent)");
  assert.match(await page.$eval("#colours-recipes", (note) => note.textContent), /The data is gone\. Choose the file again\.$/);
  assert.deepEqual((await table(page)).map((row) => Object.keys(inks(row["C M Y K, %"])).length), [0, 4]);
  for (const box of ["#problem", "#colours-problem"]) assert.ok(await page.$eval(box, (each) => each.hidden));
  await close(page);
});

test("the pointer in a slice shows the colour and its recipe, inside and outside", async () => {
  const page = await open(browser, `/view#a=${PRESS}&lightness=50`);
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
  const box = await plot(page);
  const text = () => page.$eval("#readout", (output) => output.textContent.replaceAll("−", "-"));
  const shows = (pattern) => page.waitForFunction((source) => new RegExp(source).test(document.getElementById("readout").textContent), {}, pattern);
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.5 * box.height);
  await shows("ΔE00");
  const [, a, b] = /L\* 50\.0 +a\* (\S+) +b\* (\S+?)C /.exec(await text()).slice(0, 3).map(Number);
  const { device: [expected] } = await ask("recipes", { colours: [[50, a, b]] });
  const line = /Recipe: ΔE00 0\.0\d; K can be \d+–\d+ %(C .*) %/.exec(await text());
  Object.values(inks(line[1])).forEach((value, i) => assert.ok(Math.abs(value - 100 * expected[i]) < 1.5, `${line[1]} ${expected}`));
  assert.deepEqual(await violations(page), []);
  await page.mouse.move(box.x + 0.12 * box.width, box.y + 0.12 * box.height);
  await shows("Outside; recipe of the nearest colour: ΔE00 [1-9]");
  await page.mouse.move(box.x - 200, box.y - 200);
  await page.waitForFunction("!/Outside/.test(document.getElementById('readout').textContent) || document.getElementById('readout').hidden");
  await close(page);
});
