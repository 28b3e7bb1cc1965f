// Gamuts in the viewer, in Chromium over a real server: chosen, compared, uploaded, asked, changed.
//
//   VIEWER_URL=... CHROMIUM=... FIRST=ID SECOND=ID FINEST=N SAMPLES=FILE BAD=FILE
//   KEYS_URL=... KEY=... GUARDED=ID node --test gamuts.test.mjs
//
// The first gamut is a ball of radius 40 around L* = 50, the second one of radius 30.
import assert from "node:assert/strict";
import process from "node:process";
import { after, before, test } from "node:test";
import { EMPTY, chromium, close, drawn, figures, open, PATIENCE, pixel, violations } from "./pages.mjs";

const { FIRST, SECOND, SAMPLES, BAD, KEYS_URL, KEY, GUARDED } = process.env;
const FINEST = Number(process.env.FINEST);

let browser;
before(async () => {
  browser = await chromium();
});
after(() => browser.close());

for (const [scheme, rules] of [["light", null], ["dark", ["color-contrast"]]]) {
  test(`axe-core finds nothing in the ${scheme} scheme, with and without gamuts and lists`, async () => {
    const page = await open(browser, EMPTY, { scheme });
    assert.deepEqual(await violations(page, rules), []);
    await page.click("#chooser-a");
    await page.waitForSelector("[role=option]");
    assert.deepEqual(await violations(page, rules), []);
    await page.goto(`${page.url().split("#")[0]}#a=${FIRST}&b=${SECOND}`);
    await page.reload();
    await drawn(page, FINEST);
    await page.click(".options-line button");
    assert.deepEqual(await violations(page, rules), []);
    await page.click("#help");
    assert.deepEqual(await violations(page, rules), []);
    await close(page);
  });
}

test("a gamut is chosen by name with the keyboard alone", async () => {
  const page = await open(browser, EMPTY);
  await page.focus("#chooser-a");
  await page.keyboard.type("BALL A");
  await page.waitForFunction("document.querySelectorAll('[role=option]').length === 1");
  await page.keyboard.press("ArrowDown");
  assert.equal(await page.$eval("#chooser-a", (input) => input.ariaActiveDescendantElement?.role ?? "option"), "option");
  await page.keyboard.press("Enter");
  await drawn(page, FINEST);
  assert.equal(await page.$eval("#chooser-a", (input) => input.value), "Ball A");
  assert.match(await page.$eval("#view", (view) => view.getAttribute("aria-label")), /^Ball A, \d+ triangles$/);
  assert.match(await page.title(), /^Ball A/);
  // Enter takes the first gamut of the search, also before its list is there.
  await page.click("#chooser-b");
  await page.waitForSelector("[role=option]");
  await page.keyboard.type("ball b");
  await page.keyboard.press("Enter");
  await page.waitForFunction("window.gamutViewer.figures.triangles[1] > 4");
  assert.match(await page.title(), /Ball B/);
  // A search that is left gives way to the name of what is shown.
  await page.keyboard.type("nothing of this name");
  await page.keyboard.press("Tab");
  assert.equal(await page.$eval("#chooser-b", (input) => input.value), "Ball B");
  await page.click("#chooser-b");
  await page.waitForSelector("[role=option]");
  await page.keyboard.press("Escape");
  assert.equal(await page.$eval("#chooser-b", (input) => input.getAttribute("aria-expanded")), "false");
  await close(page);
});

test("a link keeps gamuts that cannot be shown, and says why beside those that can", async () => {
  const missing = "0".repeat(64);
  for (const [a, b, place] of [[FIRST, missing, 0], [missing, SECOND, 1]]) {
    const page = await open(browser, `/view#a=${a}&b=${b}&camera=0,0,3,0,0,0,1`);
    await page.waitForFunction((slot) => window.gamutViewer.figures.triangles[slot] > 4, {}, place);
    await page.waitForFunction((keys) => keys.every((key) => location.hash.includes(key)), {}, [`a=${a}`, `b=${b}`, "camera="]);
    assert.match(await page.$eval("#problem", (box) => box.innerText), /no gamut/i);
    page.complaints = page.complaints.filter((text) => !text.includes("the server responded with a status of 404"));
    await close(page);
  }
});

test("a gamut inside another one is the solid, and a row hides its gamut and changes its opacity", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  await page.click("#chooser-b");
  await page.keyboard.type("ball b");
  await page.waitForFunction("document.querySelectorAll('[role=option]').length === 1");
  await page.click("[role=option]");
  await page.waitForFunction("window.gamutViewer.figures.triangles[1] > 4");
  const opacities = () => page.$$eval(".gamut-row:not([hidden]) input[type=range]", (sliders) => sliders.map((slider) => slider.valueAsNumber));
  // The ball of radius 30 is inside that of radius 40, which would hide it.
  await page.waitForFunction("document.getElementById('opacity-b').value === '1'");
  assert.deepEqual(await opacities(), [0.3, 1]);
  await page.click("#eye-a");
  assert.equal(await page.$eval("#eye-a", (eye) => eye.ariaPressed), "false");
  assert.equal(await page.$eval("#legend", (legend) => legend.innerText.trim()), "Ball B");
  await page.click("#eye-a");
  await page.focus("#opacity-a");
  await page.keyboard.press("End");
  assert.deepEqual(await opacities(), [1, 1]);
  await page.waitForFunction("location.hash.includes('opacity-a=1')");
  await page.click("button.clear[aria-label='Remove second gamut']");
  await page.waitForFunction("window.gamutViewer.figures.triangles[1] === 0");
  await close(page);
});

test("coverage both ways, and only the part outside in colour", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}&opacity-a=1&style-b=hidden&axes=off`);
  await drawn(page, FINEST);
  await page.waitForFunction("/covers/.test(document.getElementById('coverage').textContent)");
  const words = await page.$eval("#coverage", (box) => box.innerText);
  // The balls have the same directions: the ratio of their volumes is (30 / 40)³.
  assert.match(words, /Ball A covers 100\.0 % of the volume of Ball B, and Ball B covers 42\.2 % of the volume of Ball A\./);
  assert.match(words, /The whole surface of Ball B is inside Ball A\./);
  const numbers = await page.$eval("#coverage dl", (list) => list.innerText);
  assert.match(numbers, /Ball B covers\n+42\.19 % of Ball A/);
  // The chromaticities of the smaller ball are among those of the larger one.
  assert.match(numbers, /u′, v′: Ball A covers\n+100\.00 % of Ball B/);
  assert.match(await page.$eval("#comparison-chart", (chart) => chart.textContent), /Ball A[^]*Ball B/);
  const chroma = ([r, g, b]) => Math.max(r, g, b) - Math.min(r, g, b);
  await page.click("[data-axis='+a*']");
  const coloured = await pixel(page, 0.45, 0.5);
  await page.click("#highlight");
  await page.evaluate(`Promise.all([window.gamutViewer.show("a", "${SECOND}"), window.gamutViewer.show("b", "${FIRST}")])`);
  await page.waitForFunction("/^Ball B – Ball A/.test(document.title)");
  // All of the smaller ball is inside the larger one.
  let grey = coloured;
  for (const end = Date.now() + PATIENCE; chroma(grey) > 3 && Date.now() < end; ) {
    await new Promise((resolve) => setTimeout(resolve, 50));
    grey = await pixel(page, 0.45, 0.5);
  }
  assert.ok(chroma(coloured) > 20 && chroma(grey) <= 3, `${coloured} ${grey}`);
  assert.deepEqual(await violations(page), []);
  await close(page);
});

test("a file that is dropped is built, with progress, and shown", async () => {
  const page = await open(browser, EMPTY);
  await page.evaluate((text) => {
    window.stages = new Set();
    const box = document.querySelector("[data-slot=a] .waiting");
    const read = () => window.stages.add(box.textContent);
    new MutationObserver(read).observe(box, { childList: true, subtree: true, characterData: true });
    const transfer = new DataTransfer();
    transfer.items.add(new File([text], "dropped colours.csv"));
    for (const type of ["dragenter", "drop"]) {
      document.body.dispatchEvent(new DragEvent(type, { bubbles: true, dataTransfer: transfer }));
    }
  }, `${SAMPLES}\n${50 + Math.random()},0,0`); // the service does not have this gamut yet
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
  assert.match(await page.$eval("#legend", (legend) => legend.innerText), /dropped colours/);
  const stages = await page.evaluate("[...window.stages]");
  assert.ok(stages.some((text) => /^dropped colours\.csvCancelSending the file \d+ % · \d+ s$/.test(text)), String(stages));
  assert.equal(await page.$(".work"), null);
  await close(page);
});

/** A press with the paper white L* 95, a* 0, b* -2 of ISO 12647-2: all 16 combinations of full inks. */
const PRESS = ["C,M,Y,K,L,a,b"];
for (const k of [0, 100]) {
  for (const y of [0, 100]) {
    for (const m of [0, 100]) {
      for (const c of [0, 100]) {
        const dark = 1 - 0.8 * (k / 100);
        const lab = [95 - 0.4 * c - 0.45 * m - 0.06 * y, -0.35 * c + 0.75 * m - 0.05 * y, -2 - 0.48 * c - 0.02 * m + 0.95 * y];
        PRESS.push([c, m, y, k, Math.max(3, lab[0] * dark), lab[1] * dark, lab[2] * dark].join());
      }
    }
  }
}

function drop(page, text, name) {
  return page.evaluate(
    (content, title) => {
      const dataTransfer = new DataTransfer();
      dataTransfer.items.add(new File([content], title));
      document.body.dispatchEvent(new DragEvent("drop", { bubbles: true, dataTransfer }));
    },
    text,
    name,
  );
}

/** The facts by their terms. */
function facts(page) {
  return page.$eval("#facts dl", (list) =>
    Object.fromEntries([...list.querySelectorAll("dt")].map((term) => [term.textContent, term.nextSibling.textContent])),
  );
}

test("a file is built with the options of the page, and again with others, with the keyboard", async () => {
  const page = await open(browser, EMPTY);
  const chosen = () => page.$eval(".options-line span", (text) => text.textContent.replaceAll("\u00a0", " "));
  const described = async () => (await fetch(new URL(`/v1/gamuts/${/a=(\w+)/.exec(page.url())[1]}`, page.url()))).json();
  const shown = async (intent) => {
    await page.waitForFunction((text) => document.querySelector("#facts dd")?.textContent.startsWith(text), {}, intent);
    // The address follows a moment later.
    for (const end = Date.now() + PATIENCE; Date.now() < end; await new Promise((resolve) => setTimeout(resolve, 100))) {
      const gamut = page.url().includes("#a=") ? await described() : null;
      if (gamut?.options.intent === intent.toLowerCase()) return gamut;
    }
    throw new Error(`the address has no gamut of the intent ${intent}`);
  };
  await drop(page, PRESS.join("\n"), "press.csv");
  const relative = await shown("Relative");
  assert.equal(await chosen(), "Relative · no ink limit · CIELAB");
  assert.ok(Math.abs(relative.bounds[1][0] - 100) < 0.1, "paper counts as white");
  assert.equal((await facts(page))["Ink limit"], "None");

  await page.focus(".options-line button");
  await page.keyboard.press("Enter");
  assert.equal(await page.evaluate("document.activeElement.id"), "intent");
  await page.keyboard.type("Abs");
  await page.keyboard.press("Tab"); // the term "Ink limit"
  assert.match(await page.$eval("#term-note", (note) => note.textContent), /sum of all inks/);
  await page.keyboard.press("Tab");
  await page.keyboard.type("250");
  await page.keyboard.press("Tab");
  await page.keyboard.press("Tab");
  assert.equal(await page.evaluate("document.activeElement.id"), "rebuild");
  await page.keyboard.press("Enter");
  const absolute = await shown("Absolute");
  assert.ok(Math.abs(absolute.bounds[1][0] - 95) < 0.1, "paper is as measured");
  assert.equal(absolute.options.ink_limit, 250);
  assert.ok(absolute.volume < relative.volume);
  const stated = await facts(page);
  assert.equal(stated["Ink limit"].replace("\u00a0", " "), "250 %");
  assert.equal(stated["Space"], "CIELAB, white D50");
  const { volumes } = absolute;
  assert.ok(volumes.absolute.volume < volumes.relative.volume);
  for (const [term, of] of [["Volume, relative", volumes.relative], ["Volume, absolute", volumes.absolute]]) {
    const [, volume, times] = /^([\d,]+) cubic ΔE\*ab, ([\d.]+) × sRGB$/.exec(stated[term]);
    assert.ok(Math.abs(Number(volume.replaceAll(",", "")) - of.volume) < 1);
    assert.ok(Math.abs(times / of.times_srgb - 1) < 0.005, "both are divided by sRGB relative to its white");
  }

  // They stay for the next file, and do not change what is shown.
  await drop(page, [...PRESS, "0,0,0,50,60,0,-1"].join("\n"), "other.csv");
  await page.waitForFunction("/other/.test(document.title)");
  assert.equal((await shown("Absolute")).options.ink_limit, 250);
  assert.equal(await chosen(), "Absolute · ink limit 250 % · CIELAB");
  assert.deepEqual(await violations(page), []);

  // A gamut of the service has no file here: it is asked for.
  await page.evaluate(`window.gamutViewer.show("a", "${FIRST}")`);
  await drawn(page, FINEST);
  await page.click(".options-line button");
  await Promise.all([page.waitForFileChooser(), page.click("#rebuild")]);
  assert.match(await page.$eval("#stage-note", (note) => note.textContent), /Choose the file of Ball A again/);
  await close(page);
});

test("an option that does not apply is refused by the service, and the file is built again without it", async () => {
  const page = await open(browser, EMPTY, { width: 390, height: 780 });
  await page.$eval("#intent", (select) => { select.value = "absolute"; });
  await drop(page, SAMPLES, "bare colours.csv");
  await page.waitForSelector("#problem:not([hidden])");
  assert.match(await page.$eval("#problem", (box) => box.textContent), /intent 'absolute' does not apply/);
  // The form is open in the row of the gamut, and refuses what cannot be a limit.
  await page.$eval("#ink-limit", (input) => { input.value = "-1"; });
  await page.$eval("#rebuild", (button) => button.click());
  assert.equal(await page.evaluate("document.activeElement.id"), "ink-limit");
  await page.$eval("#ink-limit", (input) => { input.value = ""; });
  assert.ok(await page.evaluate("document.documentElement.scrollWidth <= innerWidth"));
  assert.deepEqual(await violations(page), []);
  await page.select("#intent", "relative");
  await page.select("#space", "Oklab");
  await page.$eval("#rebuild", (button) => button.click());
  await page.waitForFunction("/bare colours/.test(document.title)");
  const { Intent, Space } = await facts(page);
  assert.match(Intent, /^As given/);
  assert.match(Space, /^Oklab, white D65/);
  page.complaints = page.complaints.filter((text) => !text.includes("the server responded with a status of 4"));
  await close(page);
});

test("what is wrong with a file is said in the words of the service", async () => {
  const page = await open(browser, EMPTY);
  const [chooser] = await Promise.all([page.waitForFileChooser(), page.click("#upload")]);
  await chooser.accept([BAD]);
  await page.waitForSelector("#problem:not([hidden])");
  const text = await page.$eval("#problem", (problem) => problem.innerText);
  assert.equal(text.split("\n").filter(Boolean).length, 3, text);
  assert.equal(await page.$eval("#problem", (problem) => problem.getAttribute("role")), "alert");
  assert.deepEqual(await violations(page), []);
  // Chromium reports the status of the answer.
  page.complaints = page.complaints.filter((text) => !text.includes("the server responded with a status of 4"));
  await close(page);
});

test("50 changes of gamut leave nothing behind", async () => {
  // Small pictures: what is drawn is not the question here, and 60 large ones take a while.
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}&triangles=200`, { width: 640, height: 240 });
  await drawn(page, 200, 200);
  // The service would compare 60 times, for longer than all the rest takes.
  await page.evaluate(() => {
    const ask = window.fetch;
    const known = new Map();
    window.fetch = async (address, init) => {
      if (!address.includes("/v1/comparisons")) return ask(address, init);
      if (!known.has(address)) known.set(address, ask(address, { ...init, signal: null }).then((answer) => answer.json()));
      return Response.json(await known.get(address));
    };
  });
  const heap = async () => {
    await page.evaluate("gc()");
    return (await page.metrics()).JSHeapUsedSize;
  };
  // One call for all changes: each call from here would wait for a picture.
  const change = (times) =>
    page.evaluate(
      async (keys, count) => {
        const { gamutViewer } = window;
        for (let i = 0; i < count; i++) {
          await gamutViewer.show("a", keys[i % 2]);
          while (gamutViewer.figures.triangles[0] !== 200) await new Promise((resolve) => setTimeout(resolve, 2));
        }
      },
      [SECOND, FIRST],
      times,
    );
  // The part outside is drawn a moment after the gamuts, and a replaced worker ends a moment later: what
  // is there is counted when a second changes nothing.
  const settled = async () => {
    const count = async () => {
      const { geometries, textures } = await figures(page);
      return { geometries, textures, workers: page.workers().length };
    };
    let [last, same] = [await count(), 0];
    for (let i = 0; i < 300 && same < 10; i++) {
      await new Promise((resolve) => setTimeout(resolve, 100));
      const next = await count();
      same = JSON.stringify(next) === JSON.stringify(last) ? same + 1 : 0;
      last = next;
    }
    return last;
  };
  await change(10);
  const [before, bytes] = [await settled(), await heap()];
  assert.equal(before.workers, 2);
  await change(50);
  assert.deepEqual(await settled(), before);
  assert.ok((await heap()) < bytes + 1e6, `${bytes} bytes became ${await heap()}`);
  await close(page);
});

test("the API key is asked for when the service needs one, and nothing is shown without it", async () => {
  const page = await open(browser, `/view#a=${GUARDED}`, { url: KEYS_URL });
  await page.waitForSelector("#key-field:not([hidden])");
  assert.equal(await page.$eval("#problem", (box) => box.checkVisibility()), true);
  await page.type("#key", `${KEY.slice(0, -1)}${KEY.endsWith("A") ? "B" : "A"}`);
  await page.keyboard.press("Enter");
  await page.waitForFunction("performance.getEntriesByType('resource').filter(({ name }) => name.includes('/v1/')).length > 1");
  assert.deepEqual((await figures(page)).triangles, [0, 0]);
  assert.deepEqual(await violations(page), []);
  await page.click("#key", { count: 3 });
  await page.type("#key", KEY);
  await page.keyboard.press("Enter");
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
  assert.equal(await page.$eval("#problem", (box) => box.checkVisibility()), false);
  await page.click("#chooser-b");
  await page.waitForSelector("[role=option]");
  // Whoever gets the link has no key yet, and is asked for it by the page that anybody can open.
  const link = await page.evaluate(
    () =>
      new Promise((resolve) => {
        navigator.clipboard.writeText = async (text) => resolve(text);
        document.getElementById("share").click();
      }),
  );
  assert.match(link, new RegExp(`/view#a=${GUARDED}`));
  await page.waitForFunction("/copied/.test(document.getElementById('stage-note').textContent)");
  // Neither the address nor the browser's storage keeps it.
  assert.equal(await page.evaluate("JSON.stringify([location.href, {...localStorage}, {...sessionStorage}, document.cookie])").then((all) => all.includes(KEY)), false);
  page.complaints = page.complaints.filter((text) => !text.includes("the server responded with a status of 401"));
  await close(page);
});
