// Small helpers for elements of the page.
import { type Problem, ProblemError } from "../service/api.js";

export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

/** Open a part of the panel that has something to show. */
export function openPart(id: string): void {
  byId<HTMLDetailsElement>(id).open = true;
}

/** A new element with text and properties. */
export function element<Name extends keyof HTMLElementTagNameMap>(
  name: Name,
  text = "",
  properties: Partial<HTMLElementTagNameMap[Name]> = {},
): HTMLElementTagNameMap[Name] {
  const made = document.createElement(name);
  made.textContent = text;
  return Object.assign(made, properties);
}

/** Save content as a file of the reader. */
export function save(content: Blob, name: string): void {
  const link = element("a", "", { href: URL.createObjectURL(content), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Warnings of the service, each once: texts, or objects with one. */
export function warningTexts(given: unknown): string[] {
  if (!Array.isArray(given)) return [];
  const texts = given.map((each: unknown) => {
    const { message, detail } = (each ?? {}) as { message?: unknown; detail?: unknown };
    const text = typeof each === "string" ? each : String(message ?? detail ?? "");
    // Options of commands and requests, in brackets, mean nothing on the page.
    return text.replaceAll(/ \((?:--|")[^)]*\)/g, "");
  });
  return [...new Set(texts)].filter((text) => text !== "");
}

/** Remedies for people who use the page, where the service names its operations. */
const REMEDIES: Record<string, string> = {
  "invalid-option": "Choose another option, or another value.",
  "unknown-reference": "Choose a reference from the list.",
  "gamut-not-found": "Choose the file again: the same file with the same options gives the same gamut.",
  "api-key-required": "Type a key of this service below.",
  "invalid-parameter": "Choose the gamut from the list.",
};

/** The remedy of a problem, without names of operations and header fields. */
export function plainRemedy({ code, remedy }: Problem): string {
  if (code in REMEDIES) return REMEDIES[code]!;
  if (/Retry-After/.test(remedy)) return "Try again in a moment.";
  if (/\b[Pp]ost\b/.test(remedy)) return "Choose the file again.";
  return /\/v1\/|\b(GET|POST|PUT|DELETE)\b/.test(remedy) ? "Try again with another file or option." : remedy;
}

/** What went wrong, in the words of the service, with the name and the line of a file. */
export function problemElements(error: unknown, file = ""): HTMLElement[] {
  const named = (text: string) => element("strong", file === "" ? text : `${file}: ${text}`);
  if (!(error instanceof ProblemError)) {
    return [named("Error"), element("p", error instanceof Error ? error.message : String(error))];
  }
  const { title, detail, where } = error.problem;
  const line = where?.["line"];
  const place = typeof line === "number" ? `Line ${line}: ` : "";
  return [named(title), element("p", place + detail), element("p", plainRemedy(error.problem))];
}
