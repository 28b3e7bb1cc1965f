// Lists of colours in the viewer, in Chromium over a real server: what is read, refused, and answered.
//
//   VIEWER_URL=... CHROMIUM=... FIRST=ID SECOND=ID FINEST=N node --test colours.test.mjs
//
// The first gamut is a ball of radius 40 around L* = 50, the second one of radius 30.
import assert from "node:assert/strict";
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import process from "node:process";
import { after, before, test } from "node:test";
import { chromium, close, drawn, open, savedCells, violations } from "./pages.mjs";

const { FIRST, SECOND } = process.env;
const FINEST = Number(process.env.FINEST);

let browser, folder;
before(async () => {
  browser = await chromium();
  folder = await mkdtemp(join(tmpdir(), "colours-"));
});
after(async () => {
  await browser.close();
  await rm(folder, { recursive: true });
});

/** What is shown of the list: cells of the table, the note, and the words of a refusal. */
function shown(page) {
  return page.evaluate(() => ({
    rows: [...document.querySelectorAll("#colours-table tbody tr")].map((row) => [...row.children].map((cell) => cell.textContent)),
    note: document.getElementById("colours-note").textContent,
    problem: [...document.querySelectorAll("#colours-problem:not([hidden]) > *")].map((part) => part.textContent),
  }));
}

async function settled(page) {
  await page.waitForSelector("#colours-table table, #colours-problem:not([hidden])");
  return shown(page);
}

/** Check a pasted list. */
async function check(page, text) {
  await page.$eval("#colours", (area, value) => {
    area.value = value;
    area.dispatchEvent(new Event("input"));
  }, text);
  await page.click("#check");
  return settled(page);
}

/** Open a file, which is checked at once. */
async function openFile(page, name, content) {
  const path = join(folder, name);
  await writeFile(path, content);
  const [chooser] = await Promise.all([page.waitForFileChooser(), page.click("#colours-open")]);
  await chooser.accept([path]);
  return settled(page);
}

/** Chromium reports the status of the answers that refuse a list. */
function forgiveRefusals(page) {
  page.complaints = page.complaints.filter((text) => !text.includes("the server responded with a status of 4"));
}

test("a list of colours is checked: three classes, their limits, and the nearest colours", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  await page.focus("#colours");
  await page.keyboard.type("within,50,0,0\nat the edge,50,39.5,0\nbeyond,50,60,0\n52, 0, -61");
  await page.click("#check");
  const { rows, note } = await settled(page);
  assert.deepEqual(rows.map(([name, where]) => [name, where]), [
    ["within", "inside"],
    ["at the edge", "edge"],
    ["beyond", "outside"],
    ["52 0 −61", "outside"],
  ]);
  const heads = await page.$$eval("#colours-table thead th", (all) => all.map((each) => each.textContent));
  assert.deepEqual(heads, ["Colour", "Where", "ΔE00", "Euclidean distance", "Nearest"]);
  assert.equal(rows[0][2], "0.00");
  // Distances from a sphere of radius 40, whose triangles are flat between the colours.
  [-40, -0.5, 20].forEach((distance, i) => assert.ok(Math.abs(Number(rows[i][3].replace("−", "-")) - distance) < 2.5, rows[i][3]));
  assert.ok(Number(rows[2][2]) > 1 && Number(rows[2][2]) < 20, rows[2][2]);
  const nearest = rows[2][4].replaceAll("−", "-").split(" ").map(Number);
  assert.ok(Math.abs(Math.hypot(nearest[0] - 50, nearest[1], nearest[2]) - 40) < 3, rows[2][4]);
  assert.match(note, /^4 colours: 1 inside, 1 edge, 2 outside \(edge: within 1\.0 of the surface; tolerance [\d.]+\)\. .*CIELAB/);
  assert.deepEqual(await violations(page), []);

  const [head, ...lines] = await savedCells(page);
  assert.deepEqual(lines.map((cells) => cells[head.indexOf("position")]), ["inside", "edge", "outside", "outside"]);
  await page.click("#colours-clear");
  await page.waitForSelector("#colours-table[hidden]");
  await close(page);
});

test("sRGB's own white, red, green and blue are at its edge, and not outside", async () => {
  const page = await open(browser, "/view#a=srgb");
  await page.waitForFunction("window.gamutViewer.figures.triangles[0] > 4");
  for (const list of [
    "White #ffffff\nRed #f00\nGreen rgb(0, 255, 0)\nBlue #0000ff",
    "name,R,G,B\nWhite,255,255,255\nRed,255,0,0\nGreen,0,255,0\nBlue,0,0,255",
  ]) {
    const { rows, note } = await check(page, list);
    assert.deepEqual(rows.map((row) => row.slice(0, 3)), ["White", "Red", "Green", "Blue"].map((name) => [name, "edge", "0.00"]));
    assert.match(note, /0 outside .*sRGB/);
    if (list.includes("R,G,B")) assert.match(note, /Columns R, G, B are read as sRGB with white at 255/);
  }
  await close(page);
});

test("tables are read by their columns, and points of the view are the colours in the space of the gamut", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  // C* and h of 30 at 90 degrees are a* = 0 and b* = 30; L* of 200 grey is 80.6 (IEC 61966-2-1).
  const lists = [
    ["name;L;C;h\nYellow;50,0;30;90", "Yellow", /LCHab.*semicolons.*decimal commas/, [50, 0, 30]],
    ["60;10,5;\u22122,5", "60 10.5 −2.5", /decimal commas/, [60, 10.5, -2.5]],
    ["R,G,B\n200,200,200", "80.6 0 0", /sRGB with white at 255/, [80.6, 0, 0]],
    ["name,b,a,L,use\nRed ink,10,20,50,logo", "Red ink", /Columns L, a, b/, [50, 20, 10]],
  ];
  for (const [list, name, reading, point] of lists) {
    const { rows, note } = await check(page, list);
    assert.match(note, reading);
    if (/[a-z]/.test(name)) assert.equal(rows[0][0], name);
    const drawnAt = await page.evaluate(() => {
      const spots = [];
      window.gamutViewer.view.scene.traverse((part) => {
        if (part.isPoints && part.geometry.attributes.color) spots.push([...part.geometry.attributes.position.array]);
      });
      return spots.at(-1);
    });
    point.forEach((value, axis) => assert.ok(Math.abs(drawnAt[axis] - value) < 0.1, `${list}: ${drawnAt}`));
  }
  await close(page);
});

test("what is no colour is refused in the words of the service, with the line and the remedy", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  for (const [list, told] of [
    ["C,M,Y,K\n0,100,100,0", /amounts of ink.*profile of the press/],
    ["Red, 255, 0, 0", /Line 1: .*outside the scale of CIELAB.*R,G,B/],
    ["50 0 0\n\n51 0\n52", /Line 3: The row has 2 cells/],
    ["X,Y,Z,R,G,B\n0.2,0.2,0.2,1,2,3", /several colours in each row: X,Y,Z; R,G,B/],
  ]) {
    const { rows, problem } = await check(page, list);
    assert.deepEqual(rows, []);
    assert.equal(problem.length, 3);
    assert.match(problem.join(" "), told);
    assert.equal(await page.$eval("#colours-reading", (details) => details.open), true);
  }
  assert.deepEqual(await violations(page), []);
  const { problem } = await check(page, "hello");
  assert.match(problem.join(" "), /L,a,b, L,C,h, X,Y,Z/);
  await page.click("#colours-clear");
  await page.waitForSelector("#colours-problem[hidden]");
  forgiveRefusals(page);
  await close(page);
});

test("a bad line is refused with its number and the others are answered, names and notations mixed", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  const { rows, note } = await check(page, "#777777\nBrand green #00a651\nBrand blue #12345\nrgb(120, 118, 119)\nhello\nGrey lab(50 0 0)");
  assert.deepEqual(rows.map(([name, where]) => [name, where]), [
    ["#777777", "inside"],
    ["Brand green", "outside"],
    ["rgb(120, 118, 119)", "inside"],
    ["Grey", "inside"],
  ]);
  assert.match(note, /^4 colours: 3 inside, 0 edge, 1 outside/);
  const told = await page.$eval("#colours-refused", (box) => box.innerText);
  assert.match(told, /2 lines are refused\s+Line 3: .*#12345[^]*Line 5: .*hello/);
  assert.deepEqual(await violations(page), []);
  // Without them nothing is said.
  await check(page, "50 0 0");
  assert.equal(await page.$eval("#colours-refused", (box) => box.hidden), true);
  forgiveRefusals(page);
  await close(page);
});

test("rows and points show each other, by the pointer and by keys, with a label", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  await check(page, "within,50,0,0\nbeyond,50,60,0\nbelow,20,0,0");
  const [view, table] = await page.$$eval("#stage, #colours-table", (all) => all.map((each) => each.getBoundingClientRect().toJSON()));
  assert.ok(table.top >= view.bottom - 1 && Math.abs(table.width - view.width) < 2, "the table is under the view, as wide");
  const label = () => page.$eval("#colour-label", (each) => (each.hidden ? null : each.textContent));
  const marked = (what) => page.$$eval(`#colours-table tr${what} th`, (all) => all.map((each) => each.textContent));
  const middle = () => page.$eval("#colour-label", (each) => {
    const box = each.getBoundingClientRect();
    return [box.left + box.width / 2, box.top + box.height / 2 + (each.style.top === "" ? 0 : 26)];
  });
  await page.hover("#colours-table tbody tr:nth-child(2)");
  assert.equal(await label(), "beyond: outside");
  const at = await middle();
  await page.mouse.move(5, 5);
  await page.waitForSelector("#colour-label[hidden]");
  // The point itself, and a click that keeps it.
  await page.mouse.move(...at);
  await page.waitForFunction("document.getElementById('colour-label').textContent === 'beyond: outside' && !document.getElementById('colour-label').hidden");
  assert.deepEqual(await marked(".hovered"), ["beyond"]);
  await page.mouse.click(...at);
  await page.mouse.move(5, 5);
  assert.deepEqual([await marked("[aria-current]"), await label()], [["beyond"], "beyond: outside"]);
  await page.focus("#colours-table");
  await page.keyboard.press("ArrowDown");
  assert.deepEqual([await marked("[aria-current]"), await label()], [["below"], "below: inside"]);
  await page.click("#colours-table tbody tr:nth-child(1)");
  assert.deepEqual(await marked("[aria-current]"), ["within"]);
  assert.deepEqual(await violations(page), []);
  await page.click("#colours-clear");
  await page.waitForSelector("#colour-label[hidden]");
  await close(page);
});

test("space, scale and columns are stated where a table does not say them", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  const ambiguous = await check(page, "R,G,B\n1,0,1\n0,1,0");
  assert.match(ambiguous.problem.join(" "), /1 or 255/);
  await page.type("#colours-scale", "255");
  await page.keyboard.press("Enter");
  await page.waitForSelector("#colours-table table");
  assert.match((await shown(page)).note, /sRGB with white at 255/);
  assert.equal(await page.$eval("#colours-reading-summary", (text) => text.textContent), "white at 255");
  await page.$eval("#colours-scale", (input) => {
    input.value = "";
    input.dispatchEvent(new Event("change", { bubbles: true }));
  });
  await page.waitForSelector("#colours-problem:not([hidden])");
  const several = await check(page, "name,X,Y,Z,R,G,B\nx,0.2,0.2,0.2,1,2,3");
  assert.match(several.problem.join(" "), /several colours/);
  await page.select("#colours-space", "CIEXYZ");
  await page.waitForSelector("#colours-table table");
  assert.equal((await shown(page)).rows[0][1], "inside");
  forgiveRefusals(page);
  await close(page);
});

test("files are read in any encoding and form, and typing puts them away", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  const utf16 = Buffer.from("\ufeffname\tL\ta\tb\nGrün\t50,5\t-20\t0\n", "utf16le");
  const wide = await openFile(page, "utf16.txt", utf16);
  assert.equal(wide.rows[0][0], "Grün");
  assert.match(wide.note, /^utf16\.txt: 1 colour: 1 inside.*UTF-16/);

  const windows = await openFile(page, "windows.csv", Buffer.from("name;L;a;b\nGrün;50;-20;0\n", "latin1"));
  assert.equal(windows.rows[0][0], "Grün");
  assert.match(windows.note, /Windows-1252/);

  const cgats = ["CGATS.17", "NUMBER_OF_FIELDS 4", "BEGIN_DATA_FORMAT", "SAMPLE_ID LAB_L LAB_A LAB_B", "END_DATA_FORMAT"];
  const data = ["NUMBER_OF_SETS 2", "BEGIN_DATA", "A1 50 0 0", "A2 50 60 0", "END_DATA", ""];
  const measured = await openFile(page, "spots.txt", [...cgats, ...data].join("\n"));
  assert.deepEqual(measured.rows.map(([name, where]) => [name, where]), [["A1", "inside"], ["A2", "outside"]]);

  const swatches = await openFile(page, "brand.ase", ase([["Brand grey", [0.5, 0, 0]], ["Brand red", [0.5, 70, 0]]]));
  assert.deepEqual(swatches.rows.map(([name, where]) => [name, where]), [["Brand grey", "inside"], ["Brand red", "outside"]]);

  const picture = await openFile(page, "picture.png", await readFile(new URL("pictures/solid.png", import.meta.url)));
  assert.match(picture.problem.join(" "), /a picture/);
  await page.type("#colours", "Typed 50 0 0");
  await page.click("#check");
  await page.waitForSelector("#colours-table table");
  assert.match((await shown(page)).note, /^1 colour:/);
  forgiveRefusals(page);
  await close(page);
});

/** A palette of L*a*b* colours (Adobe Swatch Exchange), L* from 0 to 1. */
function ase(colours) {
  const blocks = colours.map(([name, values]) => {
    const block = Buffer.alloc(6 + 2 + 2 * (name.length + 1) + 4 + 12 + 2);
    block.writeUInt16BE(1, 0);
    block.writeUInt32BE(block.length - 6, 2);
    block.writeUInt16BE(name.length + 1, 6);
    for (let i = 0; i < name.length; i++) block.writeUInt16BE(name.charCodeAt(i), 8 + 2 * i);
    const at = 10 + 2 * name.length;
    block.write("LAB ", at, "latin1");
    values.forEach((value, i) => block.writeFloatBE(value, at + 4 + 4 * i));
    return block;
  });
  const head = Buffer.alloc(12);
  head.write("ASEF", 0, "latin1");
  head.writeUInt16BE(1, 4);
  head.writeUInt32BE(colours.length, 8);
  return Buffer.concat([head, ...blocks]);
}

test("a list that is too long is refused with the limit", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  const { problem } = await check(page, Array(10_001).fill("50 0 0").join("\n"));
  assert.match(problem.join(" "), /10001 rows.*at most 10000.*fewer colours/);
  forgiveRefusals(page);
  await close(page);
});

test("a check that is under way is made again for the gamut that takes the place of the first one", async () => {
  const page = await open(browser, `/view#a=${FIRST}&b=${SECOND}`);
  await drawn(page, FINEST);
  await page.waitForFunction("window.gamutViewer.figures.triangles[1] > 4");
  await page.evaluate((second) => {
    const ask = window.fetch;
    // The first question is answered after another gamut has taken the place of the first one.
    window.fetch = async (...given) => {
      if (!given[0].endsWith("/nearest")) return ask(...given);
      window.fetch = ask;
      void window.gamutViewer.show("a", second);
      return ask(...given);
    };
  }, SECOND);
  const { rows } = await check(page, "between,50,35,0");
  assert.equal(await page.$eval("#colours-table caption", (caption) => caption.textContent), "Colours in Ball B");
  assert.equal(rows[0][1], "outside");
  assert.ok(Math.abs(Number(rows[0][3]) - 5) < 2, `distance ${rows[0][3]}`);
  // Points follow the scheme of the page.
  const lines = () => {
    const found = [];
    window.gamutViewer.view.scene.traverse((part) => part.isLineSegments && part.renderOrder === 3 && found.push(part.material.color.getHex()));
    return found.join();
  };
  const before = await page.evaluate(lines);
  assert.notEqual(before, "");
  await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: "dark" }]);
  await page.waitForFunction(`![${JSON.stringify(before)}, ""].includes((${lines})())`);
  await close(page);
});

test("warnings about a list of colours are shown once, above the table", async () => {
  const page = await open(browser, `/view#a=${FIRST}`);
  await drawn(page, FINEST);
  await page.evaluate(() => {
    const ask = window.fetch;
    window.fetch = async (...given) => {
      const response = await ask(...given);
      if (!/\/(contains|nearest)$/.test(given[0])) return response;
      return Response.json({ ...(await response.json()), warnings: ["Relative to paper.", { detail: "Second." }] });
    };
    document.getElementById("colours").value = "50 60 0";
  });
  await page.click("#check");
  await page.waitForSelector("#colours-table table");
  const box = await page.$("#colours-warnings");
  assert.deepEqual(await box.$$eval("p", (all) => all.map((each) => each.textContent).slice(-2)), ["Relative to paper.", "Second."]);
  assert.ok(await box.evaluate((each) => each.compareDocumentPosition(document.getElementById("colours-table")) & 4));
  assert.deepEqual(await violations(page), []);
  await page.click("#colours-clear");
  assert.equal(await box.$("p"), null);
  await close(page);
});
