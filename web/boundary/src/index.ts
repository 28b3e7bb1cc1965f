// Gamut boundaries in any page: history files (docs/history-format.md), and questions about colours.
export { Boundary, type ClipMethod, type Colour, type Interval } from "./boundary.js";
export { HistoryError } from "./errors.js";
export type { DeviceHeader, Group, Header } from "./file.js";
export { History, type Level } from "./history.js";
export { type Loading, type Part, PartError, parts } from "./parts.js";
