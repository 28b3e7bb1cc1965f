// Messages between the page and the worker that reads a history.

/** Where a history comes from: an address, or the bytes of the file. */
export type Source = { address: string; headers: Record<string, string> } | { bytes: Uint8Array };

/** To the worker. */
export type Order =
  | { kind: "open"; source: Source; appearance: Appearance }
  | { kind: "level"; triangles: number };

/** How colours of vertices are found: from CIELAB, or from coloured points of the boundary. */
export type Appearance =
  | { kind: "cielab"; scale: number }
  | { kind: "points"; positions: Float32Array; linear: Float32Array };

/** A level as the page draws it. */
export interface LevelBuffers {
  triangles: number;
  positions: Float32Array;
  /** Linear sRGB. */
  colours: Float32Array;
  faces: Int32Array;
  /** Two vertices for each edge. */
  edges: Int32Array;
  /** Device values in 0 to 1, vertex by vertex; null without any, or before they are loaded. */
  device: Float32Array | null;
}

/** From the worker. */
export type Report =
  | { kind: "level"; level: LevelBuffers }
  | { kind: "received"; bytes: number; total: number; available: number; complete: boolean }
  | { kind: "failed"; message: string };
