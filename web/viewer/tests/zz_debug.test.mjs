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
        let [far, count, beyond] = [0, 0, 0]; const list = [];
        for (let i = 1; i < 400; i++) {
          const [x, y] = [Math.floor(((i % 20) / 20) * box.width), Math.floor((Math.floor(i / 20) / 20) * box.height)];
          const hit = view.pick(box.left + x + 0.5, box.top + y + 0.5, shown[0].layer.targets.solid);
          if (hit === null) continue;
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
            list.push([x, y, k, Math.round(Math.abs(data[4 * (y * picture.width + x) + k] - 255 * encoded)), data[4 * (y * picture.width + x) + k], Math.round(255*encoded), light]); far = Math.max(far, Math.abs(data[4 * (y * picture.width + x) + k] - 255 * encoded));
          });
          count += 1;
        }
        const green = Array.from({ length: colours.length / 3 }, (_, i) => [...colours.slice(3 * i, 3 * i + 3)])
          .reduce((one, other) => (other[1] - other[0] - other[2] > one[1] - one[0] - one[2] ? other : one));
        return { list: list.filter((e) => e[3] > 3), far, count, beyond, green };
      }, gamut === "p3" ? "display-p3" : "srgb");
    const seen = await read(); console.log(seen.count, JSON.stringify(seen.list)); await page.screenshot({path: "/tmp/v51/p3.png"});
    assert.ok(seen.count > 50, String(seen.count));
    assert.ok(seen.far <= 3, `${gamut}: ${seen.far}`);
    // The green of Display P3 in linear sRGB, by the matrices of both (IEC 61966-2-1, SMPTE EG 432-1).
    const expected = gamut === "p3" ? [0, 1, 0] : [-0.2249, 1.0421, -0.0786];
    expected.forEach((value, i) => assert.ok(Math.abs(seen.green[i] - value) < 0.004, `${gamut}: ${seen.green}`));
    assert.ok(gamut === "p3" ? seen.beyond === 0 : seen.beyond > 20, `${gamut}: ${seen.beyond}`);
    await close(page);
  }
});

