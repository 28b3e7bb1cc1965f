// The viewer in Chromium over a real server, feature by feature.
//
//   VIEWER_URL=... CHROMIUM=... FIRST=ID SECOND=ID FINEST=N SAMPLES=FILE BAD=FILE node --test features.test.mjs
//
// The first gamut is a ball of radius 40 around L* = 50, the second one of radius 30.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import process from "node:process";
import { after, before, test } from "node:test";
import { chromium, drawn, figures, open, pixel } from "./pages.mjs";

const { FIRST, SECOND, SAMPLES, BAD } = process.env;
const FINEST = Number(process.env.FINEST);
const axe = createRequire(import.meta.url).resolve("axe-core/axe.min.js");

let browser;
before(async () => {
  browser = await chromium();
});
after(() => browser.close());

async function violations(page) {
  // The policy of the page allows no injected script, so it is evaluated by the protocol.
  const { readFile } = await import("node:fs/promises");
  await page.evaluate(await readFile(axe, "utf8"));
  const { violations: found } = await page.evaluate("axe.run()");
  return found.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html).join(" | ")}`);
}

async function close(page) {
  assert.deepEqual(page.complaints, []);
  await page.browserContext().close();
}

for (const scheme of ["light", "dark"]) {
  test(`axe-core finds nothing in the ${scheme} scheme, with and without gamuts and lists`, async () => {
    const page = await open(browser, "/view", { scheme });
    assert.deepEqual(await violations(page), []);
    await page.click("#chooser-a");
    await page.waitForSelector("[role=option]");
    assert.deepEqual(await violations(page), []);
    await page.goto(`${page.url().split("#")[0]}#a=${FIRST}&b=${SECOND}`);
    await page.reload();
    await drawn(page, FINEST);
    assert.deepEqual(await violations(page), []);
    await page.click("#help");
    assert.deepEqual(await violations(page), []);
    await close(page);
  });
}

test("a gamut is chosen by name with the keyboard alone", async () => {
  const page = await open(browser, "/view");
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
  await close(page);
});

test("references are offered by name", async () => {
  const page = await open(browser, "/view");
  await page.click("#chooser-b");
  await page.keyboard.type("display-p3");
  await page.waitForFunction("document.querySelectorAll('[role=option]').length === 1");
  assert.match(await page.$eval("[role=option]", (option) => option.textContent), /display-p3/);
  await page.keyboard.press("Escape");
  assert.equal(await page.$eval("#chooser-b", (input) => input.getAttribute("aria-expanded")), "false");
  await close(page);
});

test("the slider shows any level while it moves, and the number any even count", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  await page.focus("#slider");
  await page.keyboard.press("Home");
  await drawn(page, 4);
  await page.keyboard.press("End");
  await drawn(page, FINEST);
  assert.match(await page.$eval("#level-note", (note) => note.textContent), /full boundary/);
  await page.click("#triangles", { count: 3 });
  await page.keyboard.type("101");
  await page.keyboard.press("Enter");
  await drawn(page, 100);
  assert.match(await page.$eval("#level-note", (note) => note.textContent), /100, within about [\d.]+ ΔE/);
  await close(page);
});

test("the keys of the view turn, enlarge and refine it", async () => {
  const page = await open(browser, `/view#a=${FIRST}&triangles=100`);
  await drawn(page, 100);
  await page.focus("#view");
  const place = () => page.evaluate("window.gamutViewer.view.place");
  const start = await place();
  await page.keyboard.press("ArrowLeft");
  assert.notDeepEqual(await place(), start);
  await page.keyboard.press("0");
  assert.deepEqual(await place(), start);
  await page.keyboard.press("+");
  assert.ok(Math.hypot(...(await place()).slice(0, 3)) < Math.hypot(...start.slice(0, 3)));
  await page.keyboard.press("]");
  await drawn(page, 200);
  await page.keyboard.press("[");
  await drawn(page, 100);
  await page.keyboard.press("p");
  assert.equal(await page.$eval("#projection", (select) => select.value), "orthographic");
  await page.keyboard.press("w");
  assert.equal(await page.$eval("#style-a", (select) => select.value), "shaded");
  await page.keyboard.press("a");
  assert.equal(await page.$eval("#axes", (box) => box.checked), false);
  await close(page);
});

test("colours are true: from above, the middle of a ball of radius 40 is the grey of L* 90", async () => {
  const page = await open(browser, `/view#a=${FIRST}&projection=orthographic&axes=off`);
  await drawn(page, FINEST);
  await page.click("[data-axis='+L*']");
  const [x, y] = await page.evaluate(() => {
    const at = window.gamutViewer.view.camera.clone();
    at.updateMatrixWorld();
    const place = at.position.clone().set(0, 90, 0).project(at);
    return [(place.x + 1) / 2, (1 - place.y) / 2];
  });
  // L* 90 is 226 in sRGB: Y = ((90 + 16) / 116)^3, encoded by IEC 61966-2-1.
  for (const value of await pixel(page, x, y)) assert.ok(Math.abs(value - 226) <= 6, String(value));
  const ground = await page.$eval("#stage", (stage) => getComputedStyle(stage).backgroundColor);
  assert.equal(`rgb(${(await pixel(page, 0.01, 0.99)).join(", ")})`, ground);
  await close(page);
});

test("the pointer reads coordinates, chroma and hue", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  const box = await (await page.$("#view")).boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.waitForSelector("#readout:not([hidden])");
  const text = (await page.$eval("#readout", (output) => output.textContent)).replaceAll("−", "-");
  const [l, a, b, chroma, hue] = /L\* (\S+) +a\* (\S+) +b\* (\S+?)C (\S+) +h (\S+)°/.exec(text).slice(1).map(Number);
  assert.ok(Math.abs(Math.hypot(l - 50, a, b) - 40) < 4, text);
  assert.ok(Math.abs(Math.hypot(a, b) - chroma) < 0.2, text);
  assert.ok(Math.abs(Math.cos((hue * Math.PI) / 180) * chroma - a) < 0.3, text);
  await page.mouse.move(box.x + 3, box.y + box.height - 3);
  await page.waitForSelector("#readout[hidden]");
  await close(page);
});

test("a second gamut is a wireframe around or in the first, and they change places", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  await page.click("#chooser-b");
  await page.keyboard.type("ball b");
  await page.waitForFunction("document.querySelectorAll('[role=option]').length === 1");
  await page.click("[role=option]");
  await page.waitForFunction("window.gamutViewer.figures.triangles[1] > 4");
  assert.match(await page.$eval("#legend", (legend) => legend.innerText), /Ball A · solid\n+Ball B · wireframe/);
  await page.click("#swap");
  await page.waitForFunction("/^Ball B · solid/.test(document.getElementById('legend').innerText)");
  await page.click("button.clear[aria-label='Remove second gamut']");
  await page.waitForFunction("window.gamutViewer.figures.triangles[1] === 0");
  await close(page);
});

test("slices show the outlines of both gamuts, and the address keeps them", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}`);
  await drawn(page, FINEST);
  await page.select("#slice-kind", "lightness");
  await page.focus("#slice-value");
  const outline = () =>
    page.evaluate(() => {
      const canvas = document.getElementById("slice");
      const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
      copy.drawImage(canvas, 0, 0);
      const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
      // Coloured pixels: the filled first gamut.
      let count = 0;
      for (let i = 0; i < data.length; i += 4) {
        if (data[i + 3] === 255 && Math.max(data[i], data[i + 1], data[i + 2]) - Math.min(data[i], data[i + 1], data[i + 2]) > 20) count += 1;
      }
      return count / data.length * 4;
    });
  const middle = await outline();
  for (let i = 0; i < 30; i++) await page.keyboard.press("ArrowRight");
  const higher = await outline();
  // The disc shrinks from radius 40 to √(40² − 30²).
  assert.ok(middle > 0.3 && higher > 0.02 && higher < 0.6 * middle, `${middle} ${higher}`);
  assert.match(await page.$eval("#slice-label", (label) => label.textContent), /^L\* 80/);
  await page.waitForFunction("location.hash.includes('lightness=80')");
  await page.select("#slice-kind", "hue");
  assert.match(await page.$eval("#slice", (canvas) => canvas.ariaLabel), /Hue 40°/);
  assert.deepEqual(await violations(page), []);
  await page.select("#slice-kind", "rings");
  await page.waitForFunction("document.getElementById('rings').naturalWidth > 0", { timeout: 60_000 });
  assert.equal(await page.$eval("#rings", (picture) => picture.alt), "Gamut rings of Ball A and Ball B");
  assert.deepEqual(await violations(page), []);
  await page.select("#slice-kind", "off");
  await page.waitForSelector("#section[hidden]");
  await close(page);
});

test("coverage both ways, and only the part outside in colour", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}&style-b=hidden&axes=off`);
  await drawn(page, FINEST);
  await page.waitForFunction("/covers/.test(document.getElementById('coverage').textContent)", { timeout: 60_000 });
  const text = await page.$eval("#coverage", (box) => box.innerText);
  // The balls have the same directions: the ratio of their volumes is (30 / 40)³.
  assert.match(text, /Ball A covers\n100\.00 % of Ball B/);
  assert.match(text, /Ball B covers\n42\.19 % of Ball A/);
  const chroma = ([r, g, b]) => Math.max(r, g, b) - Math.min(r, g, b);
  await page.click("[data-axis='+a*']");
  const coloured = await pixel(page, 0.45, 0.5);
  await page.click("#highlight");
  await page.click("#swap");
  await page.waitForFunction("/^Ball B/.test(document.title)");
  await page.select("#style-b", "hidden");
  // All of the smaller ball is inside the larger one.
  let grey = coloured;
  for (let i = 0; i < 100 && chroma(grey) > 3; i++) {
    await new Promise((resolve) => setTimeout(resolve, 50));
    grey = await pixel(page, 0.45, 0.5);
  }
  assert.ok(chroma(coloured) > 20 && chroma(grey) <= 3, `${coloured} ${grey}`);
  assert.deepEqual(await violations(page), []);
  await close(page);
});

test("a list of colours is checked: table, points and a file", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  await page.focus("#colours");
  await page.keyboard.type("name,L,a,b\nwithin,50,0,0\nbeyond,50,60,0\n52 0 -61");
  await page.click("#check");
  await page.waitForSelector("#colours-table table", { timeout: 60_000 });
  const rows = await page.$$eval("#colours-table tbody tr", (all) =>
    all.map((row) => [...row.children].map((cell) => cell.textContent)),
  );
  assert.deepEqual(rows.map(([name, inside]) => [name, inside]), [
    ["within", "yes"],
    ["beyond", "no"],
    ["52 0 −61", "no"],
  ]);
  assert.equal(rows[0][2], "0");
  assert.ok(Number(rows[1][2]) > 1 && Number(rows[1][2]) < 20, rows[1][2]);
  const nearest = rows[1][3].replaceAll("−", "-").split(" ").map(Number);
  assert.ok(Math.abs(Math.hypot(nearest[0] - 50, nearest[1], nearest[2]) - 40) < 3, rows[1][3]);
  assert.equal(await page.$eval("#colours-note", (note) => note.textContent), "3 colours, 2 outside.");
  assert.deepEqual(await violations(page), []);
  await page.click("#colours-clear");
  await page.waitForSelector("#colours-table[hidden]");
  await close(page);
});

test("a file that is dropped is built, with progress, and shown", async () => {
  const page = await open(browser, "/view");
  await page.evaluate((text) => {
    window.stages = new Set();
    const name = document.getElementById("stage-name");
    new MutationObserver(() => window.stages.add(name.textContent)).observe(name, { childList: true });
    const transfer = new DataTransfer();
    transfer.items.add(new File([text], "dropped colours.csv"));
    for (const type of ["dragenter", "drop"]) {
      document.body.dispatchEvent(new DragEvent(type, { bubbles: true, dataTransfer: transfer }));
    }
  }, SAMPLES);
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4", { timeout: 60_000 });
  assert.match(await page.$eval("#legend", (legend) => legend.innerText), /dropped colours/);
  const stages = await page.evaluate("[...window.stages]");
  assert.ok(stages.length > 1 && stages.every((stage) => stage.startsWith("Building: ")), String(stages));
  await close(page);
});

test("what is wrong with a file is said in the words of the service", async () => {
  const page = await open(browser, "/view");
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

test("an address restores gamuts, level, styles and camera", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}&triangles=200`);
  await drawn(page, 200, 200);
  await page.select("#style-b", "both");
  await page.select("#projection", "orthographic");
  await page.focus("#view");
  for (const key of ["ArrowLeft", "ArrowUp", "+"]) await page.keyboard.press(key);
  const place = await page.evaluate("window.gamutViewer.view.place");
  await page.waitForFunction(`location.hash.includes("${place.join(",")}")`);
  const other = await open(browser, new URL(page.url()).pathname + new URL(page.url()).hash);
  await drawn(other, 200, 200);
  await other.waitForFunction(`window.gamutViewer.view.place.join() === "${place}"`);
  assert.equal(await other.$eval("#style-b", (select) => select.value), "both");
  assert.equal(await other.$eval("#projection", (select) => select.value), "orthographic");
  await close(other);
  await close(page);
});

test("a browser gets the viewer at the address of a gamut", async () => {
  const page = await open(browser, `/v1/gamuts/${SECOND}`);
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
  assert.match(await page.title(), /^Ball B/);
  await close(page);
});

test("the view is a PNG file", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  const head = await page.evaluate(async () => {
    const blob = await window.gamutViewer.view.picture();
    return [blob.type, ...new Uint8Array(await blob.slice(0, 4).arrayBuffer())];
  });
  assert.deepEqual(head, ["image/png", 0x89, 0x50, 0x4e, 0x47]);
  await close(page);
});

test("on a phone everything is within reach", async () => {
  const page = await open(browser, `/view#a=${FIRST}`, { width: 390, height: 780 });
  await drawn(page, FINEST);
  assert.deepEqual(await violations(page), []);
  const layout = await page.evaluate(() => ({
    overflow: document.documentElement.scrollWidth - innerWidth,
    view: document.getElementById("view").getBoundingClientRect().height / innerHeight,
    small: [...document.querySelectorAll("#panel button, #panel select, #panel input[type=range]")]
      .filter((control) => control.checkVisibility())
      .filter((control) => control.getBoundingClientRect().height < 24)
      .map((control) => control.id || control.className),
  }));
  assert.equal(layout.overflow, 0);
  assert.ok(layout.view > 0.4);
  assert.deepEqual(layout.small, []);
  const box = await (await page.$("#view")).boundingBox();
  await page.touchscreen.tap(box.x + box.width / 2, box.y + box.height / 2);
  await page.waitForSelector("#readout:not([hidden])");
  await close(page);
});

test("200 changes of gamut leave nothing behind", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}&triangles=200`);
  await drawn(page, 200, 200);
  const heap = async () => {
    await page.evaluate("gc()");
    return (await page.metrics()).JSHeapUsedSize;
  };
  const change = async (key) => {
    await page.evaluate((id) => window.gamutViewer.show("a", id), key);
    await drawn(page, 200);
  };
  // The part outside is drawn a moment after the gamuts, and a replaced worker ends a moment later: what
  // is there is counted when two seconds change nothing.
  const settled = async () => {
    const count = async () => {
      const { geometries, textures } = await figures(page);
      return { geometries, textures, workers: page.workers().length };
    };
    let [last, same] = [await count(), 0];
    for (let i = 0; i < 150 && same < 10; i++) {
      await new Promise((resolve) => setTimeout(resolve, 200));
      const next = await count();
      same = JSON.stringify(next) === JSON.stringify(last) ? same + 1 : 0;
      last = next;
    }
    return last;
  };
  for (let i = 0; i < 10; i++) await change(i % 2 === 0 ? SECOND : FIRST);
  const [before, bytes] = [await settled(), await heap()];
  assert.equal(before.workers, 2);
  for (let i = 0; i < 200; i++) await change(i % 2 === 0 ? SECOND : FIRST);
  assert.deepEqual(await settled(), before);
  assert.ok((await heap()) < bytes + 4e6, `${bytes} bytes became ${await heap()}`);
  await close(page);
});
