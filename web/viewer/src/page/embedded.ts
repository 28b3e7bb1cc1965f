// The gamut of a page that was saved as one file: it works without the service.
import type { Gamut } from "../service/api.js";

export interface EmbeddedGamut {
  gamut: Gamut;
  /** The history file. */
  history: Uint8Array<ArrayBuffer>;
}

function read(): EmbeddedGamut | null {
  const text = document.getElementById("gamut-file")?.textContent;
  if (text === undefined || text === null) return null;
  const { gamut, history } = JSON.parse(text) as { gamut: Gamut; history: string };
  return { gamut, history: bytesOf(history) };
}

function bytesOf(base64: string): Uint8Array<ArrayBuffer> {
  const binary = atob(base64);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** Null on a page of the service. */
export const embedded = read();

/** Address of the worker's script: a file of the service, or the text in the page. */
export function workerAddress(): string {
  const source = document.getElementById("worker-source");
  if (source === null) return new URL("worker.js", import.meta.url).href;
  return URL.createObjectURL(new Blob([source.textContent ?? ""], { type: "text/javascript" }));
}
