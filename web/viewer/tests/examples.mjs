// A stand-in for the service in front of the real one: it has files of examples, and can be as slow
// as a service that has just started.
import { once } from "node:events";
import { createServer, request } from "node:http";
import process from "node:process";

const HISTORY_BYTES = 30_000;

/** Examples made of gamuts of the service: a press from a file of samples, and sRGB. */
async function files({ press, srgb, samples }) {
  const get = (path) => fetch(new URL(path, process.env.VIEWER_URL), { headers: { "Accept-Encoding": "identity" } });
  const made = new Map([["press.csv", Buffer.from(samples)]]);
  for (const [key, id] of [["press", press], ["srgb", srgb]]) {
    made.set(`${key}.json`, Buffer.from(await (await get(`/v1/gamuts/${id}`)).arrayBuffer()));
    made.set(`${key}.gamut`, Buffer.from(await (await get(`/v1/gamuts/${id}/history`)).arrayBuffer()).subarray(0, HISTORY_BYTES));
  }
  const entry = (key, name, file) => ({ key, name, text: `${name}.`, kind: file === null ? "reference" : "file", file });
  const summary = [
    "A reaches further in cyan (hue 170° to 250°): by up to 15 in chroma, in cyan (hue 225°).",
    "B reaches further everywhere else: by up to 79 in chroma, in blue (hue 305°).",
    "A covers 49.2 % of the volume of B, and B covers 99.9 % of the volume of A.",
  ];
  const list = {
    examples: [entry("press", "Ball A", "press.csv"), entry("srgb", "sRGB", null)],
    comparisons: [{ a: press, b: srgb, a_covers_b: 0.4916, b_covers_a: 0.9988, summary }],
  };
  made.set("index.json", Buffer.from(JSON.stringify(list)));
  return made;
}

/** Start the stand-in. `cold.isCold` delays everything under /v1/ until it is false. */
export async function standIn(gamuts) {
  const made = await files(gamuts);
  const cold = { isCold: false, asked: [] };
  const target = new URL(process.env.VIEWER_URL);
  const server = createServer(async (asked, answer) => {
    const name = /\/examples\/(.*)$/.exec(asked.url)?.[1];
    if (made.has(name)) {
      answer.writeHead(200, { "Content-Type": name.endsWith("json") ? "application/json" : "application/octet-stream" });
      answer.end(made.get(name));
      return;
    }
    if (cold.isCold && asked.url === "/" && asked.headers.accept === "application/json") {
      answer.writeHead(200, { "Content-Type": "application/json" });
      answer.end(JSON.stringify({ state: { ready: false, probes: { kernels: { status: "failed", detail: "default: compiling 4 of 9 kernels" } }, workers: 1, workers_warm: 0 } }));
      return;
    }
    if (asked.url.startsWith("/v1/")) cold.asked.push(`${asked.method} ${asked.url}`);
    while (cold.isCold && asked.url.startsWith("/v1/")) await new Promise((resolve) => setTimeout(resolve, 100));
    if (answer.destroyed) return; // the page has given up meanwhile
    const { method, headers, url: path } = asked;
    const forward = request({ host: target.hostname, port: target.port, method, path, headers }, (got) => {
      answer.writeHead(got.statusCode, got.headers);
      got.pipe(answer);
    });
    forward.on("error", () => answer.destroy());
    answer.on("close", () => forward.destroy());
    asked.pipe(forward);
  });
  server.listen(0, "127.0.0.1");
  await once(server, "listening");
  const close = () => {
    server.close();
    server.closeAllConnections();
  };
  return { url: `http://127.0.0.1:${server.address().port}`, cold, close };
}
