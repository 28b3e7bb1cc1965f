// Reader of history files, version 2, as docs/history-format.md specifies them. It was written from
// that page, not from the Python reader. It has no dependencies and runs in browsers and Node.js.
export { HistoryError } from "./errors.js";
export type { DeviceHeader, Header } from "./file.js";
export { History, type Level } from "./history.js";
export { type Loading, type Part, PartError, parts } from "./parts.js";
