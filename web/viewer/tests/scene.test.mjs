// Axes, camera and pictures of the view, in Chromium over a real server.
//
//   VIEWER_URL=... CHROMIUM=... FIRST=ID SECOND=ID FINEST=N node --test scene.test.mjs
//
// The first gamut is a ball of radius 40 around L* = 50, the second one of radius 30.
import assert from "node:assert/strict";
import { writeFile } from "node:fs/promises";
import process from "node:process";
import { after, before, test } from "node:test";
import { chromium, close, drawn, open, pictures, violations } from "./pages.mjs";

const { FIRST, SECOND, VIEWER_URL } = process.env;
const FINEST = Number(process.env.FINEST);

let browser;
before(async () => {
  browser = await chromium();
});
after(() => browser.close());

/** The id of a ball in another space. */
async function ball(space) {
  const rows = Array.from({ length: 200 }, (_, i) => {
    const [z, angle] = [1 - (2 * i + 1) / 200, 2.4 * i];
    const across = Math.sqrt(1 - z * z);
    return [50 + 40 * z, 40 * across * Math.cos(angle), 40 * across * Math.sin(angle)].join(",");
  });
  const form = new FormData();
  form.set("file", new File([["L*,a*,b*", ...rows].join("\n")], "ball.csv"));
  form.set("options", JSON.stringify({ space }));
  const posted = await fetch(`${VIEWER_URL}/v1/gamuts`, { method: "POST", body: form, headers: { Prefer: "wait=60" } });
  return (await posted.json()).id;
}

/** Texts of the labels that are seen, and what is wrong with where they are, at first and after each of some steps. */
function labels(page, steps = 0) {
  return page.evaluate((count) => {
    const { view } = window.gamutViewer;
    const faults = [];
    const found = () => {
      const stage = document.getElementById("stage").getBoundingClientRect();
      const seen = [...document.querySelectorAll(".labels text:not([display])")];
      const boxes = seen.map((label) => [label.firstChild.textContent, label.getBoundingClientRect()]);
      boxes.forEach(([text, box], i) => {
        if (box.left < stage.left || box.right > stage.right || box.top < stage.top || box.bottom > stage.bottom) faults.push(`${text} leaves the stage`);
        for (const [other, { left, right, top, bottom }] of boxes.slice(0, i)) {
          if (box.left < right && left < box.right && box.top + 1 < bottom && top + 1 < box.bottom) faults.push(`${text} is over ${other}`);
        }
      });
      return boxes.map(([text]) => text);
    };
    const texts = found();
    for (let step = 0; step < count; step++) {
      view.turn(0.7, 0.9 * Math.sin(2 * step));
      if (step % 7 === 3) view.enlarge(1.3);
      if (step === 15) view.setProjection("orthographic");
      view.drawNow();
      if (found().length < 5 && step < 3) faults.push(`few labels at step ${step}`);
    }
    return { texts, faults };
  }, steps);
}

/** Corners of the box of the first gamut, in pixels from the left and the top of the stage. */
function corners(page) {
  return page.evaluate(() => {
    const { shown, view } = window.gamutViewer;
    const { camera, canvas } = view;
    camera.updateMatrixWorld();
    const [low, high] = shown[0].gamut.bounds;
    return Array.from({ length: 8 }, (_, i) => {
      const [l, a, b] = [0, 1, 2].map((axis) => ((i >> axis) & 1 ? high : low)[axis]);
      const place = camera.position.clone().set(a, l, -b).project(camera);
      return [((place.x + 1) * canvas.clientWidth) / 2, ((1 - place.y) * canvas.clientHeight) / 2];
    });
  });
}

test("labels of the axes are apart and within the stage, seen from anywhere, in every space", async () => {
  for (const space of ["CIELAB", "CIEXYZ", "ICtCp"]) {
    const page = await open(browser, `/view#style-a=hidden&a=${space === "CIELAB" ? FIRST : await ball(space)}`, { width: 900, height: 560 });
    await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
    const { faults, texts } = await labels(page, 30);
    const names = { CIELAB: ["L*", "a*", "b*"], CIEXYZ: ["X", "Y", "Z"], ICtCp: ["I", "Ct", "Cp"] }[space];
    for (const name of names) assert.ok(texts.includes(name), `${name}: ${texts}`);
    assert.ok(texts.length > 10, String(texts));
    assert.deepEqual(faults, []);
    await close(page);
  }
});

test("the start view has everything in the free part of the stage, in any shape and projection", async () => {
  for (const [width, height] of [[1280, 720], [820, 1100], [390, 780], [844, 390]]) {
    const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}`, { width, height });
    await drawn(page, FINEST);
    for (const projection of ["perspective", "orthographic"]) {
      await page.select("#projection", projection);
      await page.evaluate("window.gamutViewer.view.drawNow()");
      const { faults, texts } = await labels(page);
      assert.deepEqual(faults, []);
      for (const name of ["L*", "a*", "b*"]) assert.ok(texts.includes(name), `${width}: ${texts}`);
      const { clientWidth, clientHeight } = await page.evaluate(() => {
        const { clientWidth, clientHeight } = window.gamutViewer.canvas;
        return { clientWidth, clientHeight };
      });
      const all = await corners(page);
      const [across, down] = [0, 1].map((axis) => all.map((corner) => corner[axis]));
      assert.ok(Math.min(...across) > 0 && Math.max(...across) < clientWidth, `${width}: ${across}`);
      assert.ok(Math.min(...down) > 0 && Math.max(...down) < clientHeight, `${width}: ${down}`);
      const filled = Math.max((Math.max(...across) - Math.min(...across)) / clientWidth, (Math.max(...down) - Math.min(...down)) / clientHeight);
      assert.ok(filled > 0.3, `${width} ${projection}: ${filled}`);
    }
    await close(page);
  }
});

test("a view that was turned by hand is whole in any window, and an enlarged one keeps its size", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}`, { width: 1280, height: 720 });
  await drawn(page, FINEST);
  const place = () => page.evaluate("window.gamutViewer.view.place.join()");
  const resize = async (width, height) => {
    await page.setViewport({ ...page.viewport(), width, height });
    await page.waitForFunction((...size) => String([innerWidth, innerHeight]) === String(size), {}, width, height);
    await pictures(page, 2);
  };
  for (const projection of ["perspective", "orthographic"]) {
    await page.select("#projection", projection);
    await page.evaluate("window.gamutViewer.view.home(), window.gamutViewer.view.turn(1.1, -0.2)");
    const turned = await place();
    for (const size of [[1280, 420], [760, 1000], [1000, 720], [1440, 900]]) {
      await resize(...size);
      const { clientWidth, clientHeight } = await page.$eval("#view", ({ clientWidth, clientHeight }) => ({ clientWidth, clientHeight }));
      const isWithin = ([x, y]) => x > 0 && x < clientWidth && y > 0 && y < clientHeight;
      const all = await corners(page);
      assert.ok(all.every(isWithin), `${projection} ${size}: ${all.map((corner) => corner.map(Math.round)).join(" ")}`);
      const filled = Math.max(...[clientWidth, clientHeight].map((length, axis) => (Math.max(...all.map((corner) => corner[axis])) - Math.min(...all.map((corner) => corner[axis]))) / length));
      assert.ok(filled > 0.3, `${projection} ${size}: ${filled}`);
      assert.equal(await place(), turned);
    }
    await page.evaluate("window.gamutViewer.view.enlarge(2)");
    const enlarged = await place();
    assert.notEqual(enlarged, turned);
    await resize(1280, 720);
    assert.equal(await place(), enlarged);
  }
  await close(page);
});

test("neither wheel nor keys lead into the gamut or lose it", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  const distance = () =>
    page.evaluate(() => window.gamutViewer.view.camera.position.clone().sub({ x: 0, y: 50, z: 0 }).length());
  const box = await (await page.$("#view")).boundingBox();
  await page.mouse.move(box.x + 0.4 * box.width, box.y + 0.6 * box.height);
  for (let i = 0; i < 40; i++) await page.mouse.wheel({ deltaY: -600 });
  assert.ok((await distance()) > 41, String(await distance()));
  await page.evaluate("window.gamutViewer.view.enlarge(1000)");
  assert.ok((await distance()) > 41, String(await distance()));
  await page.keyboard.down("Shift"); // moves the view sideways
  for (let i = 0; i < 6; i++) {
    await page.mouse.move(box.x + 10, box.y + 0.5 * box.height);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width - 10, box.y + 0.5 * box.height, { steps: 3 });
    await page.mouse.up();
  }
  await page.keyboard.up("Shift");
  assert.ok((await distance()) > 41, String(await distance()));
  for (const projection of ["perspective", "orthographic"]) {
    await page.select("#projection", projection);
    await page.evaluate("window.gamutViewer.view.enlarge(1e-6)");
    const across = (await corners(page)).map(([x]) => x);
    const seen = Math.max(...across) - Math.min(...across);
    assert.ok(seen > 40 && Math.min(...across) < box.width && Math.max(...across) > 0, `${projection}: ${across}`);
  }
  await close(page);
});

test("views turn smoothly, and the view spins until it is touched, unless less motion is preferred", async () => {
  const place = (page) => page.evaluate("window.gamutViewer.view.place.join()");
  const page = await open(browser, `/view#a=${FIRST}`, { motion: "no-preference" });
  await drawn(page, FINEST);
  const start = await place(page);
  assert.equal(await page.$eval("[data-axis='+L*'] title", (title) => title.textContent), "From above (+L*), key 1");
  const first = await page.evaluate(() => {
    document.querySelector("[data-axis='+L*']").dispatchEvent(new MouseEvent("click"));
    return window.gamutViewer.view.place.join();
  });
  assert.equal(first, start); // a turn takes its time
  await page.waitForFunction("window.gamutViewer.view.turning === null");
  const [x, y, z] = (await place(page)).split(",").map(Number);
  assert.ok(y > 2 && Math.abs(x) < 0.1 && Math.abs(z) < 0.1, `${x} ${y} ${z}`);
  await page.evaluate("window.gamutViewer.view.home()");
  await page.waitForFunction(`window.gamutViewer.view.place.join() === "${start}"`);
  await page.evaluate("window.gamutViewer.view.spin(true)");
  await page.waitForFunction(`window.gamutViewer.view.place[0] !== ${start.split(",")[0]}`);
  await page.click("#view");
  const stopped = await place(page);
  await pictures(page, 3);
  assert.equal(await place(page), stopped);
  await close(page);
  const calm = await open(browser, `/view#a=${FIRST}`);
  await drawn(calm, FINEST);
  const before = await place(calm);
  await calm.evaluate("window.gamutViewer.view.spin(true)");
  await pictures(calm, 3);
  assert.equal(await place(calm), before);
  await close(calm);
});

test("colours are exact on screens of both kinds, but for the shading", async () => {
  for (const gamut of ["srgb", "p3"]) {
    const page = await open(browser, "/view#a=display-p3&axes=off", { gamut, scale: 1 });
    await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
    const read = () =>
      page.evaluate(async (colorSpace) => {
        const { shown, view } = window.gamutViewer;
        const { colours, positions } = shown[0].layer.level;
        const picture = await createImageBitmap(await view.picture());
        const context = new OffscreenCanvas(picture.width, picture.height).getContext("2d", { colorSpace });
        context.drawImage(picture, 0, 0);
        const { data } = context.getImageData(0, 0, picture.width, picture.height);
        const box = view.canvas.getBoundingClientRect();
        let [far, count, beyond] = [0, 0, 0];
        for (let i = 1; i < 400; i++) {
          const [x, y] = [Math.floor(((i % 20) / 20) * box.width), Math.floor((Math.floor(i / 20) / 20) * box.height)];
          const pick = (dx, dy) => view.pick(box.left + x + dx, box.top + y + dy, shown[0].layer.targets.solid);
          const hit = pick(0.5, 0.5);
          // Pixels at the outline have a part of the ground.
          if (hit === null || [-1, 2].some((dx) => [-1, 2].some((dy) => pick(dx, dy) === null))) continue;
          const { a, b, c } = hit.face;
          const weights = hit.barycoord.toArray();
          const linear = [0, 1, 2].map((k) => [a, b, c].reduce((sum, corner, j) => sum + weights[j] * colours[3 * corner + k], 0));
          if (Math.max(...linear) > 1.02 || Math.min(...linear) < -0.02) beyond += 1;
          // Light from the camera and the upper left, at least 0.72: it changes no hue and no chromaticity.
          const [p, q, r] = [a, b, c].map((corner) => hit.object.localToWorld(hit.point.clone().fromArray(positions, 3 * corner)));
          const normal = q.sub(p).cross(r.sub(p)).normalize().transformDirection(view.camera.matrixWorldInverse);
          const light = Math.min(1, Math.max(0, -0.3 * normal.x + 0.5 * normal.y + normal.z));
          linear.forEach((value, k) => {
            const clipped = Math.min(Math.max(value, 0), 1) * (0.72 + 0.28 * light);
            const encoded = clipped <= 0.0031308 ? 12.92 * clipped : 1.055 * clipped ** (1 / 2.4) - 0.055;
            far = Math.max(far, Math.abs(data[4 * (y * picture.width + x) + k] - 255 * encoded));
          });
          count += 1;
        }
        const green = Array.from({ length: colours.length / 3 }, (_, i) => [...colours.slice(3 * i, 3 * i + 3)])
          .reduce((one, other) => (other[1] - other[0] - other[2] > one[1] - one[0] - one[2] ? other : one));
        return { far, count, beyond, green };
      }, gamut === "p3" ? "display-p3" : "srgb");
    const seen = await read();
    assert.ok(seen.count > 50, String(seen.count));
    assert.ok(seen.far <= 3, `${gamut}: ${seen.far}`);
    // The green of Display P3 in linear sRGB, by the matrices of both (IEC 61966-2-1, SMPTE EG 432-1).
    const expected = gamut === "p3" ? [0, 1, 0] : [-0.2249, 1.0421, -0.0786];
    expected.forEach((value, i) => assert.ok(Math.abs(seen.green[i] - value) < 0.004, `${gamut}: ${seen.green}`));
    assert.ok(gamut === "p3" ? seen.beyond === 0 : seen.beyond > 20, `${gamut}: ${seen.beyond}`);
    await close(page);
  }
});

/** What the dialog saves, as an array of bytes, with its type and name. */
async function saved(page, kind, fields = {}) {
  await page.click("#save");
  await page.select("#save-kind", kind);
  const file = await page.evaluate(async (values) => {
    for (const [id, value] of Object.entries(values)) {
      const control = document.getElementById(id);
      if (control.type === "checkbox") control.checked = value;
      else control.value = value;
      control.dispatchEvent(new Event("change", { bubbles: true }));
    }
    const made = new Promise((resolve) => {
      const create = URL.createObjectURL;
      URL.createObjectURL = (blob) => {
        URL.createObjectURL = create;
        resolve(blob);
        return create.call(URL, blob);
      };
    });
    document.getElementById("save-file").click();
    const blob = await made;
    const url = await new Promise((resolve) => {
      const reader = new FileReader();
      reader.onload = () => resolve(reader.result);
      reader.readAsDataURL(blob);
    });
    return { type: blob.type, data: url.split(",")[1] };
  }, fields);
  await page.waitForFunction("!document.getElementById('take-away').open");
  const bytes = Buffer.from(file.data, "base64");
  if (process.env.PICTURES) await writeFile(`${process.env.PICTURES}/saved.${kind}`, bytes);
  return { type: file.type, bytes };
}

/** Size of a PNG file, and its pixels at places, as fractions of its size, with their opacity. */
function pngPixels(page, bytes, places) {
  return page.evaluate(
    async (base64, all) => {
      const data = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
      const picture = await createImageBitmap(new Blob([data]));
      const context = new OffscreenCanvas(picture.width, picture.height).getContext("2d", { willReadFrequently: true });
      context.drawImage(picture, 0, 0);
      const at = (part, size) => Math.min(size - 1, Math.floor(part * size));
      return {
        size: [picture.width, picture.height],
        pixels: all.map(([x, y]) => [...context.getImageData(at(x, picture.width), at(y, picture.height), 1, 1).data]),
      };
    },
    bytes.toString("base64"),
    places,
  );
}

const CORNERS = [[0, 0], [1, 0], [0, 1], [1, 1]];

test("pictures are saved as seen and at 16:9, with a preview, and the view stays as it is", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}`, { scale: 1 });
  await drawn(page, FINEST);
  // The legend has two lines then, for which the view makes room.
  await page.waitForFunction("window.gamutViewer.figures.triangles[1] > 4");
  const [before, seen, ground] = await page.evaluate(() => {
    const { view, canvas } = window.gamutViewer;
    const { backgroundColor } = getComputedStyle(document.getElementById("stage"));
    return [view.place.join(), [canvas.clientWidth, canvas.clientHeight], backgroundColor.match(/\d+/g).map(Number)];
  });
  const twice = await saved(page, "png", { "save-shape": "seen", "save-ratio": "2" });
  assert.equal(twice.type, "image/png");
  const filled = await pngPixels(page, twice.bytes, [...CORNERS, [0.5, 0.5]]);
  assert.deepEqual(filled.size, seen.map((pixels) => 2 * pixels));
  for (const corner of filled.pixels.slice(0, 4)) assert.deepEqual(corner, [...ground, 255]);
  const clear = await saved(page, "png", { "save-shape": "wide", "save-ratio": "1", "save-clear": true });
  const { size, pixels } = await pngPixels(page, clear.bytes, [...CORNERS, [0.5, 0.5]]);
  assert.deepEqual(size, [1920, 1080]);
  assert.deepEqual(pixels.map(([, , , opacity]) => opacity), [0, 0, 0, 0, 255]);
  assert.equal(await page.evaluate("window.gamutViewer.view.place.join()"), before);
  const { width, clientWidth } = await page.evaluate(() => {
    const { width, clientWidth } = window.gamutViewer.canvas;
    return { width, clientWidth };
  });
  assert.equal(width, clientWidth);
  await page.click("#save");
  // The preview has the shape of the file, and follows each change.
  const shape = () => page.$eval("#save-preview canvas", (canvas) => canvas.width / canvas.height);
  await page.waitForFunction("/1920 × 1080/.test(document.getElementById('save-preview').textContent)");
  assert.ok(Math.abs((await shape()) - 16 / 9) < 0.02);
  await page.select("#save-shape", "seen");
  await page.waitForFunction(`document.getElementById("save-preview").textContent.includes("${seen.join(" × ")}")`);
  assert.ok(Math.abs((await shape()) - seen[0] / seen[1]) < 0.02);
  assert.deepEqual(await violations(page), []);
  await page.click("#save-close");
  await close(page);
});

test("a picture has the section and the bars of the comparison while they are open", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}&lightness=50`, { scale: 1, width: 1200 });
  await drawn(page, FINEST);
  await page.waitForSelector("#answer .coverage-bar");
  await page.waitForSelector("#section-chart svg");
  const [view, section] = await page.evaluate(() => ["stage", "section"].map((id) => document.getElementById(id).clientWidth));
  const both = await saved(page, "png", { "save-ratio": "1" });
  assert.ok(Math.abs(both.bytes.readUInt32BE(16) - view - section) <= 1);
  // Rows at the bottom left have the bars: the first one is black, as its gamut is in a light page.
  const column = Array.from({ length: 60 }, (_, i) => [0.25, 1 - i / both.bytes.readUInt32BE(20)]);
  const isBlack = ([r, g, b]) => r + g + b === 0;
  assert.ok((await pngPixels(page, both.bytes, column)).pixels.some(isBlack));
  await page.click("#section-close");
  await page.click("#comparison > summary");
  const alone = await saved(page, "png", { "save-ratio": "1" });
  const whole = await page.$eval("#stage", (stage) => stage.clientWidth);
  assert.equal(alone.bytes.readUInt32BE(16), whole);
  assert.ok(!(await pngPixels(page, alone.bytes, column)).pixels.some(isBlack));
  await close(page);
});
