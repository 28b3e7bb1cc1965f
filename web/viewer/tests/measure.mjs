// Measures the viewer in Chromium and prints the figures as JSON.
//
//   VIEWER_URL=... CHROMIUM=... GAMUT=ID OTHER=ID GAMUT_FINEST=N OTHER_FINEST=N node measure.mjs
import { readFileSync, readdirSync } from "node:fs";
import process from "node:process";
import { brotliCompressSync } from "node:zlib";
import { chromium, drawn, open } from "./pages.mjs";

const SECONDS = 3;
const DRAGGED = 10_000;
const folder = new URL("../../../gamutcore/export/viewer/", import.meta.url);

const FRAMES = 40;
const browser = await chromium();

/** Times of three visitors of an address, each with an empty cache. */
async function visits(path, ...triangles) {
  const loads = [];
  for (let i = 0; i < 3; i++) {
    const visitor = await browser.createBrowserContext();
    const page = await open(visitor, path);
    await page.waitForFunction("window.gamutViewer.figures.marks.first !== undefined", { timeout: 60_000 });
    await drawn(page, ...triangles);
    loads.push(await page.evaluate("window.gamutViewer.figures.marks"));
    await visitor.close();
  }
  return (name) => loads.map((marks) => marks[name]).sort((a, b) => a - b)[1];
}
const firstScreen = await visits("/");
const median = await visits(`/view#a=${process.env.GAMUT}`, DRAGGED);

/**
 * Milliseconds of the script per picture of two gamuts, the median of 40 frames: while the view
 * turns, or while the slider of a section moves. What the rasteriser takes is not in them.
 */
async function scriptTime(state, triangles, moves) {
  const address = `/view#a=${process.env.GAMUT}&b=${process.env.OTHER}&triangles=${triangles}&${state}`;
  const page = await open(browser, address, { width: 1280, height: 800 });
  await page.waitForFunction(
    (wished, finest) => window.gamutViewer.figures.triangles.every((count, i) => count === Math.min(wished, finest[i])),
    { timeout: 120_000 },
    triangles,
    [Number(process.env.GAMUT_FINEST), Number(process.env.OTHER_FINEST)],
  );
  const time = await page.evaluate(
    async (frames, what) => {
      const { view } = window.gamutViewer;
      const slider = document.getElementById("slice-value");
      let busy = 0;
      const timed = (run) => {
        const begin = performance.now();
        run();
        busy += performance.now() - begin;
      };
      const draw = view.drawNow.bind(view);
      view.drawNow = () => timed(draw);
      const times = [];
      for (let i = 0; i < frames; i++) {
        busy = 0;
        timed(() => {
          if (what === "turn") view.turnBy(0.03, 0);
          else {
            slider.value = String(30 + (i % 40));
            slider.dispatchEvent(new Event("input"));
          }
        });
        await new Promise(requestAnimationFrame); // draws in the frame that begins now
        await new Promise((resolve) => setTimeout(resolve));
        times.push(busy);
      }
      return times.sort((a, b) => a - b)[frames / 2];
    },
    FRAMES,
    moves,
  );
  await page.close();
  return time;
}
const WHOLE = 2 ** 20;
const script = {
  turn_milliseconds: await scriptTime("", DRAGGED, "turn"),
  turn_outside_milliseconds: await scriptTime("outside=on", DRAGGED, "turn"),
  turn_whole_milliseconds: await scriptTime("", WHOLE, "turn"),
  turn_whole_outside_milliseconds: await scriptTime("outside=on", WHOLE, "turn"),
  slice_milliseconds: await scriptTime("lightness=50", DRAGGED, "slice"),
  slice_whole_milliseconds: await scriptTime("lightness=50", WHOLE, "slice"),
};

const page = await open(browser, `/view#a=${process.env.GAMUT}&triangles=${2 ** 20}`, { width: 1280, height: 800 });
await page.waitForFunction(
  "((f) => f.marks.complete && f.triangles[0] === f.available[0])(window.gamutViewer.figures)",
  { timeout: 60_000 },
);
const whole = await page.evaluate("window.gamutViewer.figures");

/**
 * Move the slider at every picture of the screen, up and down below a triangle count.
 *
 * `drawing` is "all"; "nothing", which leaves the script and the worker; or "ground", which only clears
 * the canvas and moves no slider: what the browser and the rasteriser take for any picture.
 */
const drag = (drawing) => page.evaluate(
  async (seconds, most, what) => {
    const slider = document.getElementById("slider");
    const finest = Number(document.getElementById("triangles").max);
    const top = (1000 * Math.log(most / 4)) / Math.log(finest / 4);
    const { gamutViewer } = window;
    const { view } = gamutViewer;
    const { renderer } = view;
    const picture = () => new Promise(requestAnimationFrame);
    const times = [];
    let busy = 0;
    /** Add the time of a function to that of the script. */
    const timed = (target, name, replaced) => {
      const kept = target[name];
      const run = replaced ?? kept;
      target[name] = (...given) => {
        const begin = performance.now();
        run.apply(target, given);
        busy += performance.now() - begin;
      };
      return () => (target[name] = kept);
    };
    const restored = [
      timed(renderer, "render", what === "nothing" ? () => {} : undefined),
      timed(gamutViewer, "levelArrived"),
      timed(gamutViewer, "setTriangles"),
    ];
    const gl = renderer.getContext();
    slider.value = "0";
    slider.dispatchEvent(new Event("input"));
    await new Promise((resolve) => setTimeout(resolve, 1000));
    const before = gamutViewer.figures;
    busy = 0;
    const start = performance.now();
    let last = start;
    for (let i = 0; last - start < 1000 * seconds; i++) {
      // From top to bottom and back in two seconds, at 60 pictures a second.
      if (what === "ground") {
        gl.clearColor(i % 2, 0.5, 0.5, 1);
        gl.clear(gl.COLOR_BUFFER_BIT);
      } else {
        slider.value = String(top * Math.abs(1 - (i % 120) / 60));
        slider.dispatchEvent(new Event("input"));
      }
      await picture();
      times.push(performance.now() - last);
      last = performance.now();
    }
    const after = gamutViewer.figures;
    for (const restore of restored) restore();
    times.sort((a, b) => a - b);
    return {
      pictures_per_second: (1000 * times.length) / (last - start),
      levels_per_second: (1000 * (after.levels - before.levels)) / (last - start),
      slowest_picture_ms: times[Math.floor(0.95 * times.length)],
      script_milliseconds: busy / times.length,
    };
  },
  SECONDS,
  DRAGGED,
  drawing,
);
/** Levels one after the other, which wait for nothing else. */
const level = await page.evaluate(async (most) => {
  const { gamutViewer } = window;
  const shown = async (triangles) => {
    const start = performance.now();
    gamutViewer.setTriangles(triangles);
    while (gamutViewer.figures.triangles[0] !== triangles) await new Promise((resolve) => setTimeout(resolve));
    return performance.now() - start;
  };
  const times = [];
  for (let i = 0; i < 20; i++) times.push(await shown(most - 2000 * (i % 2)));
  return times.sort((a, b) => a - b)[10];
}, DRAGGED);
const dragged = await drag("all");
const undrawn = await drag("nothing");
const ground = await drag("ground");
await browser.close();

const compressed = readdirSync(folder)
  .filter((name) => name !== "LICENSE")
  .reduce((sum, name) => sum + brotliCompressSync(readFileSync(new URL(name, folder))).length, 0);
console.log(
  JSON.stringify({
    bundle_kilobytes: compressed / 1000,
    first_screen_seconds: firstScreen("first") / 1000,
    first_picture_seconds: median("first") / 1000,
    first_picture_triangles: median("firstTriangles"),
    first_picture_kilobytes: median("firstBytes") / 1000,
    whole_triangles: whole.triangles[0],
    level_milliseconds: level,
    ...dragged,
    ...script,
    undrawn_levels_per_second: undrawn.levels_per_second,
    undrawn_pictures_per_second: undrawn.pictures_per_second,
    cleared_pictures_per_second: ground.pictures_per_second,
  }),
);
