// Worker of one gamut: loads its history in growing parts, and answers with levels.
import { History, parts } from "@gamut/boundary";
import { spaceOf } from "../colours/spaces.js";
import type { LevelBuffers, Order, Report, Source } from "./messages.js";

/** Bytes of a short file at most: one request reads it, so that a cached copy is never mixed with an answer. */
const SHORT = 1 << 20;

const history = new History();
let colours: (positions: Float32Array) => Float32Array;

self.onmessage = ({ data: order }: MessageEvent<Order>) => {
  try {
    if (order.kind === "open") {
      const space = spaceOf(order.space);
      colours = (positions) => space.linear(positions, order.screen, false);
      load(order.source).catch(fail);
    } else {
      send(order.triangles);
    }
  } catch (error) {
    fail(error);
  }
};

async function load(source: Source): Promise<void> {
  if ("bytes" in source) {
    await history.append(source.bytes);
  } else {
    for await (const { bytes, total } of parts(source.address, { headers: source.headers, ...(source.isShort ? { first: SHORT } : {}) })) {
      await history.append(bytes);
      if (!history.ready) continue;
      const available = 2 * history.vertices - 4;
      report({ kind: "received", bytes: history.size, total, available, complete: false });
      // A message with an order is handled between two parts.
      await new Promise((resolve) => setTimeout(resolve));
    }
  }
  if (!history.ready) throw new Error("The history is incomplete.");
  const available = 2 * history.vertices - 4;
  report({ kind: "received", bytes: history.size, total: history.size, available, complete: true });
}

function send(triangles: number): void {
  history.refineTo(Math.min(triangles, 2 * history.vertices - 4));
  const { positions, faces } = history.level;
  const level: LevelBuffers = {
    triangles: history.triangles,
    positions,
    colours: colours(positions),
    faces,
    edges: edgesOf(faces),
    device: history.deviceValues,
  };
  const buffers = [positions, level.colours, faces, level.edges, level.device];
  report(
    { kind: "level", level },
    buffers.flatMap((array) => (array === null ? [] : [array.buffer as ArrayBuffer])),
  );
}

/** Every edge once: in a closed mesh each edge has one face in which its vertices ascend. */
function edgesOf(faces: Int32Array): Int32Array {
  const edges = new Int32Array(faces.length);
  let count = 0;
  for (let corner = 0; corner < faces.length; corner++) {
    const from = faces[corner]!;
    const to = faces[corner % 3 === 2 ? corner - 2 : corner + 1]!;
    if (from > to) continue;
    edges[count++] = from;
    edges[count++] = to;
  }
  return edges;
}

function fail(error: unknown): void {
  report({ kind: "failed", message: error instanceof Error ? error.message : String(error) });
}

function report(message: Report, transfer: Transferable[] = []): void {
  self.postMessage(message, { transfer });
}
