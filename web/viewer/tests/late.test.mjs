// Answers that arrive after the page has moved on, in Chromium over a real server.
//
//   VIEWER_URL=... CHROMIUM=... FIRST=ID SECOND=ID PRESS=ID SAMPLES=FILE node --test late.test.mjs
//
// The order is forced: a held answer arrives when the test says so, and is not called off before.
import assert from "node:assert/strict";
import process from "node:process";
import { after, before, test } from "node:test";
import { EMPTY, chromium, close, open } from "./pages.mjs";

const { FIRST, SECOND, PRESS, SAMPLES } = process.env;
const REFUSAL = { title: "Late", detail: "Nobody asks any more.", code: "late", status: 500, where: null, remedy: "None." };

let browser;
before(async () => {
  browser = await chromium();
});
after(() => browser.close());

/** Hold the first answer to an address; `body` stands for it, of a refusal with a status. */
function hold(page, address, body = null) {
  return page.evaluate(
    (part, replacement) => {
      const ask = window.fetch;
      window.isHeld = false;
      window.fetch = async (target, given) => {
        if (!String(target).includes(part) || window.isHeld) return ask(target, given);
        window.isHeld = true;
        const { signal: _, ...init } = given;
        const got = replacement === null ? await ask(target, init) : null;
        const text = got === null ? JSON.stringify(replacement) : await got.text();
        const status = got?.status ?? replacement.status ?? 200;
        const type = status < 400 ? "application/json" : "application/problem+json";
        await new Promise((resolve) => {
          window.release = resolve;
        });
        return new Response(text, { status, headers: { "content-type": type } });
      };
    },
    address,
    body,
  );
}

/** Wait until the held answer has been asked for. */
const held = (page) => page.waitForFunction("window.release !== undefined");

/** Let the held answer arrive, and everything that follows from it. */
function arrive(page) {
  return page.evaluate(async () => {
    window.release();
    delete window.release;
    await new Promise((resolve) => setTimeout(resolve, 50));
  });
}

const press = (page, selector) => page.$eval(selector, (button) => button.click());
const shows = (page, ...keys) =>
  page.waitForFunction((wanted) => String(window.gamutViewer.shown.map(({ key }) => key)) === wanted, {}, String(keys));
const show = (page, slot, key) => page.evaluate((...given) => void window.gamutViewer.show(...given), slot, key);
const kept = (page, name) => page.evaluate((part) => window.gamutViewer.kept.get(part)() ?? null, name);
const isVisible = (page, selector) => page.$eval(selector, (box) => box.checkVisibility());

async function check(page, text) {
  await page.$eval("#colours", (area, value) => (area.value = value), text);
  await press(page, "#check");
}

const RECIPES = { device: [[0, 0, 0, 0.5]], delta_e_2000: [0], inside: [true] };
for (const body of [RECIPES, REFUSAL]) {
  test(`recipes of a gamut that is gone change nothing: ${body.title ?? "an answer"}`, async () => {
    const page = await open(browser, `/view#a=${PRESS}`);
    await shows(page, PRESS);
    await hold(page, "/recipes", body);
    await check(page, "60 0 0");
    await held(page);
    assert.ok(await isVisible(page, "#colours-table table"));
    await show(page, "a", null);
    await arrive(page);
    assert.deepEqual([await isVisible(page, "#colours-table"), await page.$eval("#colours-recipes", (note) => note.textContent)], [false, ""]);
    await close(page);
  });

  test(`recipes of a list that was followed by another one change nothing: ${body.title ?? "an answer"}`, async () => {
    const page = await open(browser, `/view#a=${PRESS}`);
    await shows(page, PRESS);
    await hold(page, "/recipes", body);
    await check(page, "60 0 0");
    await held(page);
    await page.$eval("#colours", (area) => (area.value = "")); // a list without colours has no recipes
    await press(page, "#check");
    await arrive(page);
    assert.deepEqual([await isVisible(page, "#colours-table"), await page.$eval("#colours-recipes", (note) => note.textContent)], [false, ""]);
    await close(page);
  });
}

test("a list that was cleared is not shown, and not refused", async () => {
  for (const body of [null, REFUSAL]) {
    const page = await open(browser, `/view#a=${FIRST}`);
    await shows(page, FIRST);
    await hold(page, "/contains", body);
    await check(page, "50 0 0");
    await held(page);
    await press(page, "#colours-clear");
    await arrive(page);
    assert.deepEqual([await kept(page, "list"), await isVisible(page, "#colours-problem")], [null, false]);
    await close(page);
  }
});

test("the comparison of a pair that is gone is dropped", async () => {
  for (const body of [null, REFUSAL]) {
    const page = await open(browser, `/view#a=${FIRST}`);
    await shows(page, FIRST);
    await hold(page, "/v1/comparisons", body);
    await show(page, "b", SECOND);
    await held(page);
    await show(page, "b", null);
    await arrive(page);
    assert.equal(await kept(page, "comparison"), null);
    assert.equal(await page.$eval("#coverage", (box) => box.textContent), "");
    await close(page);
  }
});

test("a gamut that was replaced while it was on its way stays away, and so does its error", async () => {
  for (const body of [null, REFUSAL]) {
    const page = await open(browser, EMPTY);
    await hold(page, `/v1/gamuts/${FIRST}`, body);
    await show(page, "a", FIRST);
    await held(page);
    await show(page, "a", SECOND);
    await shows(page, SECOND);
    await arrive(page);
    await shows(page, SECOND);
    assert.equal(await isVisible(page, "#problem"), false);
    await close(page);
  }
});

test("what the reader chooses while an address is restored stays", async () => {
  const page = await open(browser, EMPTY);
  await hold(page, `/v1/gamuts/${FIRST}`);
  await page.evaluate((a, b) => {
    history.replaceState(null, "", `#a=${a}&b=${b}&c=${b}`);
    void window.gamutViewer.restore();
  }, FIRST, SECOND);
  await held(page);
  await show(page, "b", "srgb");
  await show(page, "c", null);
  await shows(page, "srgb");
  await arrive(page);
  await shows(page, FIRST, "srgb");
  await page.waitForFunction("window.gamutViewer.figures.triangles.every((count) => count > 4)");
  await shows(page, FIRST, "srgb");
  await close(page);
});

test("Enter takes the gamut of the present text, not of the text before", async () => {
  const page = await open(browser, EMPTY);
  await hold(page, "/v1/references?name=adobe");
  await page.focus("#chooser-a");
  await page.keyboard.type("adobe");
  await page.keyboard.press("Enter");
  await held(page);
  await page.keyboard.press("Backspace");
  await arrive(page);
  assert.equal(await page.$eval("#chooser-a", (field) => field.value), "adob");
  assert.ok(await page.evaluate("window.gamutViewer.isEmpty"));
  await close(page);
});

/** Hold a file that is sent, which `fetch` does not do, and choose it for the first gamut. */
async function upload(page, name, lightness) {
  await page.evaluate(
    (file, text) => {
      const { send } = XMLHttpRequest.prototype;
      XMLHttpRequest.prototype.abort = () => {}; // an answer that has arrived cannot be called off
      XMLHttpRequest.prototype.send = function (body) {
        XMLHttpRequest.prototype.send = send;
        window.release = () => send.call(this, body);
      };
      const dataTransfer = new DataTransfer();
      dataTransfer.items.add(new File([text], file));
      document.querySelector("[data-slot=a] input").dispatchEvent(new DragEvent("drop", { bubbles: true, dataTransfer }));
    },
    name,
    `${SAMPLES}\n${lightness},0,0`,
  );
  await held(page);
}

test("a file that is built is shown in its row, and is dropped for another choice", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}`);
  await shows(page, FIRST, SECOND);
  await upload(page, "built.csv", 54.5);
  await arrive(page);
  await page.waitForFunction("/^built.csv – Ball B/.test(document.title)");
  await upload(page, "dropped.csv", 55.5);
  await show(page, "a", FIRST);
  await page.waitForFunction("/^Ball A – Ball B/.test(document.title)");
  assert.equal(await page.$(".work"), null);
  const answered = page.waitForResponse((answer) => answer.request().method() === "POST" && answer.url().endsWith("/v1/gamuts"));
  await arrive(page);
  await answered;
  await page.evaluate("new Promise((resolve) => setTimeout(resolve, 50))");
  assert.match(await page.title(), /^Ball A – Ball B/);
  await close(page);
});

test("a file that was cancelled is not saved", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await shows(page, FIRST);
  await page.evaluate(() => {
    window.saved = 0;
    URL.createObjectURL = () => String((window.saved += 1));
  });
  await hold(page, "/viewer.html");
  await page.click("#save");
  await page.select("#save-kind", "html");
  await page.click("#save-file");
  await held(page);
  await page.click("#save-close");
  await arrive(page);
  assert.equal(await page.evaluate("window.saved"), 0);
  assert.deepEqual(await page.$eval("#take-away", (dialog) => [dialog.open, dialog.querySelector("#save-file").disabled]), [true, false]);
  await close(page);
});

test("the refusal of a picture is dropped when its gamut is gone", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await shows(page, FIRST);
  await hold(page, "/map?", REFUSAL);
  await page.evaluate(() => {
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File(["none"], "picture.png"));
    const input = document.getElementById("picture-file");
    input.files = dataTransfer.files;
    input.dispatchEvent(new Event("change"));
  });
  await held(page);
  await show(page, "a", null);
  await arrive(page);
  assert.equal(await page.$eval("#picture-problem", (box) => box.hidden), true);
  await close(page);
});

test("the colour at the pointer leaves with its gamut", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}`);
  await page.waitForFunction("window.gamutViewer.figures.triangles.every((count) => count > 4)");
  const { x, y, width, height } = await (await page.$("#view")).boundingBox();
  await hold(page, "/contains", REFUSAL);
  await page.mouse.move(x + width / 2, y + height / 2);
  await page.mouse.move(x + width / 2 + 3, y + height / 2);
  await held(page);
  assert.ok(await isVisible(page, "#readout"));
  await show(page, "a", null);
  await arrive(page);
  assert.equal(await isVisible(page, "#readout"), false);
  await close(page);
});
