// Dropped files in the viewer, in Chromium over a real server: what is offered for each kind of file.
//
//   VIEWER_URL=... CHROMIUM=... FIRST=ID SECOND=ID FINEST=N node --test drops.test.mjs
//
// The first gamut is a ball of radius 40 around L* = 50, the second one of radius 30.
import assert from "node:assert/strict";
import process from "node:process";
import { after, before, test } from "node:test";
import { chromium, close, drawn, open } from "./pages.mjs";

const { FIRST, SECOND } = process.env;
const FINEST = Number(process.env.FINEST);

let browser;
before(async () => {
  browser = await chromium();
});
after(() => browser.close());

/** Drag a file over the view, and drop it on a target. Returns the targets that were shown. */
function drag(page, { name, type, content }, target) {
  return page.evaluate((file, aim) => {
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([file.content], file.name, { type: file.type }));
    const fire = (event, element) => element.dispatchEvent(new DragEvent(event, { bubbles: true, dataTransfer }));
    fire("dragenter", document.getElementById("view"));
    const shown = [...document.querySelectorAll("#drop > :not([hidden])")].map((each) => each.textContent);
    const element = document.querySelector(aim);
    fire("dragenter", element);
    fire("drop", element);
    return shown;
  }, { name, type, content }, target);
}

const LIST = { name: "brand.csv", type: "text/csv", content: "name,L,a,b\nGrey,50,0,0\nRed,50,60,0\n" };

test("a list is checked or built, and a profile is only built", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}`, { isOpen: false });
  await drawn(page, FINEST);
  await page.waitForFunction("window.gamutViewer.figures.triangles[1] > 4");
  const targets = await drag(page, LIST, "#drop-check");
  assert.deepEqual(targets, ["Check against Ball A", "Build a gamut"]);
  await page.waitForSelector("#colours-table table");
  assert.match(await page.$eval("#colours-note", (note) => note.textContent), /^brand\.csv: 2 colours: 1 inside, 0 edge, 1 outside/);
  assert.equal(await page.$eval("#colours-part", (part) => part.open), true);
  const bad = { name: "press.icc", type: "", content: "no profile" };
  assert.deepEqual(await drag(page, bad, "#view"), ["Drop to build the first gamut; more files become the next ones"]);
  await page.waitForSelector("#problem:not([hidden])");
  assert.match(await page.$eval("#problem", (box) => box.textContent), /^press\.icc: /);
  page.complaints = page.complaints.filter((text) => !text.includes("the server responded with a status of 4"));
  await close(page);
});

test("a picture is checked against the smaller gamut", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}`, { isOpen: false });
  await drawn(page, FINEST);
  await page.waitForFunction("window.gamutViewer.figures.triangles[1] > 4");
  const broken = { name: "photo.png", type: "image/png", content: "no picture" };
  assert.deepEqual(await drag(page, broken, "#drop-check"), ["Check against Ball B", "Build a gamut"]);
  await page.waitForSelector("#picture-problem:not([hidden])");
  assert.match(await page.$eval("#picture-problem", (box) => box.textContent), /^photo\.png: /);
  page.complaints = page.complaints.filter((text) => !text.includes("the server responded with a status of 4"));
  await close(page);
});
