// Prints the Khronos validator's report of each glTF or GLB file named on the command line, as one
// JSON array in their order. Exit code 1 where a report has errors or a file cannot be read, 2
// without a file.
import { readFile } from "node:fs/promises";
import { basename, dirname, resolve } from "node:path";
import process from "node:process";
import { validateBytes } from "gltf-validator";

const files = process.argv.slice(2);
if (files.length === 0) {
  console.error("usage: node validate.mjs FILE...");
  process.exit(2);
}

const reports = [];
for (const file of files) {
  const folder = dirname(resolve(file));
  reports.push(
    await validateBytes(new Uint8Array(await readFile(file)), {
      uri: basename(file),
      maxIssues: 0,
      externalResourceFunction: async (uri) =>
        new Uint8Array(await readFile(resolve(folder, decodeURIComponent(uri)))),
    }),
  );
}
process.stdout.write(`${JSON.stringify(reports)}\n`);
process.exitCode = reports.some((report) => report.issues.numErrors > 0) ? 1 : 0;
