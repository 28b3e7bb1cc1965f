// Writes the answers of a level to questions about colours, as JSON.
//
//   node answers.mjs HISTORY TRIANGLES QUESTIONS
//
// QUESTIONS is JSON: `colours`, and `lightness` and `hues` of a table of chroma.
import { readFileSync } from "node:fs";
import process from "node:process";
import { Boundary, type ClipMethod, History } from "../src/index.js";

const [file, triangles, questions] = process.argv.slice(2);
const { colours, lightness, hues } = JSON.parse(readFileSync(questions!, "utf8")) as {
  colours: number[][];
  lightness: number[];
  hues: number[];
};
const history = await History.from(new Uint8Array(readFileSync(file!)));
const boundary = Boundary.of(history, Number(triangles));
const clip = (method: ClipMethod) => colours.map((colour) => [...boundary.clip(colour, method)]);
process.stdout.write(
  JSON.stringify({
    triangles: boundary.triangles,
    volume: boundary.volume,
    tolerance: boundary.tolerance,
    inside: colours.map((colour) => boundary.contains(colour, 0)),
    within: colours.map((colour) => boundary.contains(colour, 2)),
    distance: colours.map((colour) => boundary.distance(colour)),
    nearest: colours.map((colour) => [...boundary.nearest(colour)]),
    centre: clip("centre"),
    chroma: clip("chroma"),
    clipped: [...clip("nearest"), ...clip("centre"), ...clip("chroma")].every((colour) => boundary.contains(colour, 0)),
    table: hues.map((hue) => lightness.map((light) => boundary.chroma(light, hue))),
  }),
);
