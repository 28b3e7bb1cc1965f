// Reader of history files, version 3, as docs/history-format.md specifies them. It has no dependencies
// and runs in browsers and Node.js 18 or later.
export { HistoryError } from "./errors.js";
export type { DeviceHeader, Group, Header } from "./file.js";
export { History, type Level } from "./history.js";
export { type Loading, type Part, PartError, parts } from "./parts.js";
