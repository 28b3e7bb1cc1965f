/** The bytes are not a history file of version 3, or are damaged. */
export class HistoryError extends Error {
  override name = "HistoryError";
}
