// Questions a second of processor time, on one core: node bench.mjs HISTORY [TRIANGLES], after `npm run build`.
import { readFileSync } from "node:fs";
import process from "node:process";
import { Boundary, History } from "./dist/index.js";

const [file, triangles = "1000"] = process.argv.slice(2);
const history = await History.from(new Uint8Array(readFileSync(file)));
const boundary = Boundary.of(history, Number(triangles));
const { positions } = history.level;
const range = [0, 1, 2].map((axis) => {
  const values = positions.filter((_, i) => i % 3 === axis);
  return [Math.min(...values), Math.max(...values)];
});
let state = 1;
const random = () => (state = (state * 48271) % 2147483647) / 2147483647; // MINSTD
const colours = Array.from({ length: 100_000 }, () => range.map(([low, high]) => low + random() * (high - low)));

function rate(ask, count) {
  const rates = [];
  for (let round = 0; round < 5; round++) {
    const start = process.cpuUsage();
    for (let i = 0; i < count; i++) ask(colours[i]);
    const { user, system } = process.cpuUsage(start);
    rates.push((count / (user + system)) * 1e6);
  }
  return rates.sort((a, b) => a - b)[2].toPrecision(2);
}

const out = new Float64Array(3);
console.log(`${boundary.triangles} triangles, Node.js ${process.version}; answers a second of processor time:`);
console.log(`contains, exactly        ${rate((colour) => boundary.contains(colour, 0), 100_000)}`);
console.log(`contains, with tolerance ${rate((colour) => boundary.contains(colour), 100_000)}`);
console.log(`nearest                  ${rate((colour) => boundary.nearest(colour, out), 20_000)}`);
console.log(`clip, chroma             ${rate((colour) => boundary.clip(colour, "chroma", out), 5_000)}`);
