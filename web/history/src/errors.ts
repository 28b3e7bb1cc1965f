/** The bytes are not a history file of version 2, or are damaged. */
export class HistoryError extends Error {
  override name = "HistoryError";
}
