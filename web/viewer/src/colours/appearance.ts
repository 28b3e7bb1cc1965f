// How the vertices of a gamut are coloured.
import { type Gamut, request } from "../service/api.js";
import { embedded } from "../page/embedded.js";
import type { Appearance } from "../scene/messages.js";

const COLOURED_TRIANGLES = 4000;
const LONGEST_HEADER = 1 << 16;

/** CIELAB is converted on the page. For other spaces, a coarse mesh of the service has colours. */
export async function appearanceOf(gamut: Gamut, path: string, signal: AbortSignal): Promise<Appearance> {
  const space = gamut.provenance.colour_space;
  if (gamut.options.space === "CIELAB") return { kind: "cielab", scale: space?.scale ?? 1 };
  if (embedded?.coloured) return colouredPoints(embedded.coloured.buffer);
  const triangles = Math.min(COLOURED_TRIANGLES, gamut.counts.triangles);
  const address = `${path}/mesh.ply?triangles=${triangles}`;
  const response = await request(address, { signal, headers: { Accept: "*/*" } });
  return colouredPoints(await response.arrayBuffer());
}

/** Positions and colours of a binary little-endian PLY file with properties of one or four bytes. */
export function colouredPoints(file: ArrayBuffer): Appearance {
  const text = new TextDecoder("latin1").decode(file.slice(0, LONGEST_HEADER));
  const begin = text.indexOf("end_header\n") + "end_header\n".length;
  const vertices = Number(/^element vertex (\d+)$/m.exec(text)![1]);
  const section = text.slice(text.indexOf("\nelement vertex"), text.indexOf("\nelement face"));
  const offsets = new Map<string, number>();
  let width = 0;
  for (const [, type, name] of section.matchAll(/^property (\w+) (\w+)$/gm)) {
    offsets.set(name!, width);
    width += type === "uchar" || type === "uint8" ? 1 : 4;
  }
  const view = new DataView(file, begin);
  const positions = new Float32Array(3 * vertices);
  const linear = new Float32Array(3 * vertices);
  for (let i = 0; i < vertices; i++) {
    ["x", "y", "z"].forEach((name, axis) => {
      positions[3 * i + axis] = view.getFloat32(i * width + offsets.get(name)!, true);
    });
    ["red", "green", "blue"].forEach((name, channel) => {
      const encoded = view.getUint8(i * width + offsets.get(name)!) / 255;
      linear[3 * i + channel] =
        encoded <= 0.04045 ? encoded / 12.92 : ((encoded + 0.055) / 1.055) ** 2.4;
    });
  }
  return { kind: "points", positions, linear };
}
