// Builds the viewer into the files that the service serves, or checks that they are up to date.
//
//   node build.mjs [--check]
import { mkdir, readFile, readdir, rm, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import process from "node:process";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const target = join(here, "..", "gamutcore", "export", "viewer");

const common = {
  absWorkingDir: here,
  bundle: true,
  charset: "utf8", // the page states it
  define: { __THREE_DEVTOOLS__: "undefined" }, // a browser extension that three.js would tell of each scene
  legalComments: "none",
  metafile: true,
  minify: true,
  outdir: target,
  target: "es2023",
  write: false,
};
const results = await Promise.all([
  build({
    ...common,
    entryPoints: { viewer: "viewer/src/main.ts", style: "viewer/viewer.css" },
    format: "esm",
  }),
  // A page from disk may start a classic worker only.
  build({ ...common, entryPoints: { worker: "viewer/src/scene/worker.ts" }, format: "iife" }),
]);
const files = new Map(
  results.flatMap(({ outputFiles }) => outputFiles).map(({ path, contents }) => {
    const name = path.split("/").at(-1);
    return [name === "style.css" ? "viewer.css" : name, Buffer.from(contents)];
  }),
);
files.set("index.html", await readFile(join(here, "viewer", "index.html")));
files.set("LICENSE", Buffer.from(await licences(results.flatMap(({ metafile }) => Object.keys(metafile.inputs)))));

const there = await readdir(target).catch(() => []);
if (process.argv.includes("--check")) {
  const differing = [];
  for (const name of new Set([...files.keys(), ...there])) {
    const stored = await readFile(join(target, name)).catch(() => null);
    if (stored === null || !files.get(name)?.equals(stored)) differing.push(name);
  }
  if (differing.length > 0) {
    console.error(`gamutcore/export/viewer is out of date: ${differing.join(", ")}. Run make viewer.`);
    process.exit(1);
  }
} else {
  await mkdir(target, { recursive: true });
  for (const name of there) if (!files.has(name)) await rm(join(target, name));
  for (const [name, content] of files) await writeFile(join(target, name), content);
}

/** The licences of the packages in the bundle. */
async function licences(inputs) {
  const names = new Set();
  for (const input of inputs) {
    const path = /^node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(input);
    if (path) names.add(path[1]);
  }
  let text = "The files of this folder are built from web/ of the project, under the licence of the project.\n";
  text += "They contain parts of these npm packages:\n";
  for (const name of [...names].sort()) {
    const folder = join(here, "node_modules", name);
    const { version, license } = JSON.parse(await readFile(join(folder, "package.json"), "utf8"));
    const licence = await readFile(join(folder, "LICENSE"), "utf8");
    text += `\n--- ${name} ${version} (${license}) ---\n\n${licence.trim()}\n`;
  }
  return text;
}
