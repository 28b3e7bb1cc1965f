// Messages between the page and the worker that reads a history.
import type { Screen, SpaceDescription } from "../colours/spaces.js";

/** Where a history comes from: an address, which may be read in parts, or the bytes of the file. */
export type Source = { address: string; headers: Record<string, string>; isShort?: boolean } | { bytes: Uint8Array };

/** To the worker. */
export type Order =
  | { kind: "open"; source: Source; space: Partial<SpaceDescription>; screen: Screen }
  | { kind: "level"; triangles: number };

/** A level as the page draws it. */
export interface LevelBuffers {
  triangles: number;
  positions: Float32Array;
  /** Linear RGB of the screen, not clipped: values beyond 0 to 1 are colours that it cannot show. */
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
