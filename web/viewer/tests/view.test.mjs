// What the view does, in Chromium over a real server: levels, keys, colours, pictures, addresses.
//
//   VIEWER_URL=... CHROMIUM=... FIRST=ID SECOND=ID FINEST=N PAGE=FILE OTHER_PAGE=FILE node --test view.test.mjs
//
// The first gamut is a ball of radius 40 around L* = 50, the second one of radius 30.
import assert from "node:assert/strict";
import process from "node:process";
import { after, before, test } from "node:test";
import {
  chromium,
  close,
  difference,
  drawn,
  open,
  openParts,
  pixel,
  smallPicture,
  storedPicture,
  violations,
} from "./pages.mjs";

const { FIRST, SECOND, PAGE, OTHER_PAGE } = process.env;
const FINEST = Number(process.env.FINEST);

let browser;
before(async () => {
  browser = await chromium();
});
after(() => browser.close());

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
  assert.equal(await page.$eval("#opacity-a", (slider) => slider.valueAsNumber), 0.3);
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

test("a click keeps the readout with the name of its gamut; a drag turns the view instead", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  const box = await (await page.$("#view")).boundingBox();
  const middle = [box.x + box.width / 2, box.y + box.height / 2];
  const readout = () => page.$eval("#readout", (output) => (output.hidden ? "" : output.innerText));
  await page.mouse.move(...middle);
  await page.waitForFunction("/^Ball A, L\\* /.test(document.getElementById('status').textContent)");
  await page.mouse.down();
  await page.mouse.move(middle[0] + 30, middle[1], { steps: 3 });
  await page.mouse.up();
  assert.doesNotMatch(await readout(), /Kept/);
  await page.mouse.click(...middle);
  const text = await readout();
  assert.match(text, /^Ball A\nL\* [^]*Kept until Esc/);
  await page.mouse.move(box.x + 3, box.y + box.height - 3);
  await page.mouse.move(middle[0] + 20, middle[1] + 20);
  assert.equal(await readout(), text);
  // The ground has no colour to keep.
  await page.mouse.click(box.x + 3, box.y + box.height - 3);
  assert.equal(await readout(), "");
  // The Enter key reads the middle then.
  await page.focus("#view");
  await page.keyboard.press("Enter");
  assert.match(await readout(), /^Ball A\nL\* [^]*Kept/);
  await page.keyboard.press("Escape");
  assert.equal(await readout(), "");
  await page.keyboard.press("Enter");
  await page.evaluate(`window.gamutViewer.show("a", "${SECOND}")`);
  await page.waitForSelector("#readout[hidden]");
  await close(page);
});

test("the pointer reads the signed distance to the other gamut", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}&style-b=hidden`);
  await drawn(page, FINEST);
  const box = await (await page.$("#view")).boundingBox();
  const distance = async () => {
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.waitForFunction("/ from Ball/.test(document.getElementById('readout').textContent)");
    const text = await page.$eval("#readout", (output) => output.textContent);
    const [, value, where] = /([−\d.]+) from Ball .: (inside|edge|outside) \(edge: within 1\.0 of the surface; tolerance [\d.]+\)/.exec(text);
    return [Number(value.replace("−", "-")), where];
  };
  // The spheres around one middle are 10 apart; their triangles are flat between the colours.
  const [outer, beyond] = await distance();
  assert.ok(Math.abs(outer - 10) < 1.5 && beyond === "outside", `${outer} ${beyond}`);
  await page.mouse.move(box.x + 3, box.y + box.height - 3);
  await page.waitForSelector("#readout[hidden]");
  await page.click("#eye-a");
  await page.click("#eye-b");
  await page.waitForFunction("/^Ball B$/.test(document.getElementById('legend').innerText)");
  const [inner, within] = await distance();
  assert.ok(Math.abs(inner + 10) < 1.5 && within === "inside", `${inner} ${within}`);
  await close(page);
});

test("an address restores gamuts, level, styles and camera", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}&triangles=200`);
  await drawn(page, 200, 200);
  await page.evaluate("window.gamutViewer.setOpacity('b', 0.6)");
  await page.select("#projection", "orthographic");
  await page.focus("#view");
  for (const key of ["ArrowLeft", "ArrowUp", "+"]) await page.keyboard.press(key);
  const place = await page.evaluate("window.gamutViewer.view.place");
  await page.waitForFunction(`location.hash.includes("${place.join(",")}")`);
  const other = await open(browser, new URL(page.url()).pathname + new URL(page.url()).hash);
  await drawn(other, 200, 200);
  await other.waitForFunction(`window.gamutViewer.view.place.join() === "${place}"`);
  assert.equal(await other.$eval("#opacity-b", (slider) => slider.valueAsNumber), 0.6);
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
    beyond: [...document.querySelectorAll("header button, #gizmo")]
      .filter((button) => button.getBoundingClientRect().right > innerWidth)
      .map((button) => button.textContent),
    view: document.getElementById("view").getBoundingClientRect().height / innerHeight,
    small: [...document.querySelectorAll("#panel button, #panel select, #panel input[type=range]")]
      .filter((control) => control.checkVisibility())
      .filter((control) => control.getBoundingClientRect().height < 24)
      .map((control) => control.id || control.className),
  }));
  assert.equal(layout.overflow, 0);
  assert.deepEqual(layout.beyond, []);
  assert.ok(layout.view >= 0.6);
  assert.deepEqual(layout.small, []);
  const box = await (await page.$("#view")).boundingBox();
  await page.touchscreen.tap(box.x + box.width / 2, box.y + box.height / 2);
  await page.waitForSelector("#readout:not([hidden])");
  await close(page);
});

test("a long name stays within the panel, and leaves the view free", async () => {
  const rows = Array.from({ length: 60 }, (_, i) => `${50 + 30 * Math.sin(i)},${40 * Math.cos(i * 1.7)},${40 * Math.sin(i * 2.3)}`);
  const form = new FormData();
  form.set("file", new File([["L*,a*,b*", ...rows].join("\n")], "long.csv"));
  form.set("name", "Long".repeat(45));
  const posted = await fetch(`${process.env.VIEWER_URL}/v1/gamuts`, { method: "POST", body: form, headers: { Prefer: "wait=30" } });
  const { id } = await posted.json();
  for (const width of [360, 1100]) {
    const page = await open(browser, `/view#a=${id}&b=${FIRST}`, { width });
    await page.waitForFunction("/covers/.test(document.getElementById('coverage').textContent)");
    const layout = await page.evaluate(() => ({
      beyond: document.getElementById("panel").scrollWidth - document.getElementById("panel").clientWidth,
      page: document.documentElement.scrollWidth - innerWidth,
      legend: document.getElementById("legend").getBoundingClientRect().height / document.getElementById("view").getBoundingClientRect().height,
    }));
    assert.equal(layout.beyond, 0);
    assert.equal(layout.page, 0);
    assert.ok(layout.legend < 0.3, `${layout.legend}`);
    await close(page);
  }
  await fetch(`${process.env.VIEWER_URL}/v1/gamuts/${id}`, { method: "DELETE" });
});

const PICTURES = {
  solid: [`#a=${FIRST}`, {}],
  "two-dark": [`#a=${FIRST}&b=${SECOND}&lightness=60&opacity-a=0.05&opacity-b=1`, { scheme: "dark" }],
  hue: [`#a=${FIRST}&triangles=400&edges=on&hue=40&projection=orthographic`, {}],
  phone: [`#a=${FIRST}&b=${SECOND}`, { width: 390, height: 780 }],
};

test("pages look like the stored pictures", async () => {
  const seen = [];
  for (const [name, [hash, given]] of Object.entries(PICTURES)) {
    const page = await open(browser, `/view${hash}`, { scale: 1, ...given });
    await drawn(page, hash.includes("triangles=400") ? 400 : FINEST);
    await page.waitForSelector("#chips:not([hidden])");
    if (/lightness|hue/.test(hash)) await page.waitForSelector("#section-chart svg");
    if (hash.includes("&b=")) await page.waitForFunction("/covers/.test(document.getElementById('coverage').textContent)");
    const picture = await smallPicture(page);
    const stored = await storedPicture(name, picture);
    const { mean, far } = await difference(page, picture, stored);
    assert.ok(mean < 4 && far < 0.04, `${name}: mean ${mean}, far ${far}`);
    // The comparison can fail: the others look different.
    for (const other of seen) {
      const { mean: apart } = await difference(page, picture, other);
      assert.ok(apart > 8, `${name}: ${apart}`);
    }
    seen.push(picture);
    await close(page);
  }
});

test("a term shows its sentence when it is tapped, and names its control", async () => {
  const page = await open(browser, `/view#a=${FIRST}`, { width: 390, height: 780 });
  await drawn(page, FINEST);
  for (const [id, name, sentence] of [["projection", "Projection", /^Perspective/], ["slider", "Triangles", /flat triangles/]]) {
    const term = await page.waitForSelector(`#${id}-term`);
    await term.evaluate((button) => button.scrollIntoView({ block: "center" }));
    await term.tap();
    const note = await page.waitForSelector("#term-note:popover-open");
    assert.match(await note.evaluate((box) => box.textContent), sentence);
    assert.equal(await page.$(`aria/${name}[role="${id === "slider" ? "slider" : "combobox"}"]`).then((found) => found.evaluate((control) => control.id)), id);
  }
  assert.deepEqual(await violations(page), []);
  await close(page);
});

for (const [space, file] of [["CIELAB", PAGE], ["another space", OTHER_PAGE]]) {
  test(`a page that was saved shows every level from disk, without a network, in ${space}`, async () => {
    const asked = [];
    const page = await open(browser, file, { isOffline: true });
    page.on("request", (request) => asked.push(new URL(request.url()).protocol));
    await page.reload();
    await page.waitForFunction("window.gamutViewer?.figures.triangles[0] > 4");
    await openParts(page);
    assert.match(await page.title(), /^(Ball A|Oklab sphere)/);
    assert.match(await page.$eval("#gamut-list", (list) => list.innerText), /^(Ball A|Oklab sphere)/);
    await page.focus("#slider");
    await page.keyboard.press("Home");
    await drawn(page, 4);
    await page.keyboard.press("End");
    await page.waitForFunction("((f) => f.triangles[0] === f.available[0] && f.triangles[0] > 4)(window.gamutViewer.figures)");
    assert.match(await page.$eval("#level-note", (note) => note.textContent), /full boundary/);
    const [r, g, b] = await pixel(page, 0.5, 0.5);
    assert.ok(Math.max(r, g, b) - Math.min(r, g, b) > 20, `${r} ${g} ${b}`);
    await page.select("#slice-kind", "lightness");
    await page.waitForSelector("#section:not([hidden])");
    assert.equal(await page.$eval("#chooser-a", (field) => field.checkVisibility()), false);
    assert.deepEqual(await violations(page), []);
    assert.deepEqual(asked.filter((protocol) => !["file:", "blob:", "data:"].includes(protocol)), []);
    assert.equal(await page.evaluate("fetch('https://example.org').then(() => 'sent', () => 'refused')"), "refused");
    page.complaints = page.complaints.filter((text) => !text.includes("example.org"));
    await close(page);
  });
}
