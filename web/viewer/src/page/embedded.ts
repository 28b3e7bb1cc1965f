// The gamuts of a page that was saved as one file: it works without the service.
import type { Gamut } from "../service/api.js";

export interface EmbeddedGamut {
  gamut: Gamut;
  /** The history file. */
  history: Uint8Array<ArrayBuffer>;
}

/** What a saved page restores. Parts of the page may add members. */
export interface SavedState {
  /** As behind the number sign of the address, with ids of gamuts. */
  address?: string;
  [part: string]: unknown;
}

/** Coverage of two gamuts, and sentences with A and B for them. */
export interface Coverage {
  a_covers_b: number;
  b_covers_a: number;
  summary: string[];
}

interface Embedded {
  gamuts: EmbeddedGamut[];
  /** Of the first two gamuts, if the file was written with two. */
  coverage: Coverage | null;
  state: SavedState | null;
}

const STATE = '<script type="application/json" id="page-state">';

function read(): Embedded | null {
  const text = document.getElementById("gamut-file")?.textContent;
  if (text === undefined || text === null) return null;
  const { gamuts, coverage } = JSON.parse(text) as { gamuts: { gamut: Gamut; history: string }[]; coverage?: Coverage };
  const state = document.getElementById("page-state")?.textContent ?? "null";
  return {
    gamuts: gamuts.map(({ gamut, history }) => ({ gamut, history: bytesOf(history) })),
    coverage: coverage ?? null,
    state: JSON.parse(state) as SavedState | null,
  };
}

/** A page of the service as a file that restores a state. */
export function withState(file: string, state: SavedState): string {
  // The script of the page may have the same text; the state is behind everything else.
  const [before, after] = [file.slice(0, file.lastIndexOf(STATE)), file.slice(file.lastIndexOf("</script>"))];
  return `${before}${STATE}${JSON.stringify(state).replaceAll("<", "\\u003c")}${after}`;
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
