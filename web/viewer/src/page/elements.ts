// Small helpers for elements of the page.
import { ProblemError } from "../service/api.js";

export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
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

/** A term, its meaning, and an explanation that is shown on hover. */
export type Definition = [term: string, meaning: string, explanation?: string];

/** A description list. */
export function definitions(all: Definition[]): HTMLDListElement {
  const list = element("dl");
  for (const [term, meaning, title] of all) {
    list.append(element("dt", term, title === undefined ? {} : { title }), element("dd", meaning));
  }
  return list;
}

/** Warnings of the service, each once: texts, or objects with one. */
export function warningTexts(given: unknown): string[] {
  if (!Array.isArray(given)) return [];
  const texts = given.map((each: unknown) => {
    if (typeof each === "string") return each;
    const { message, detail } = (each ?? {}) as { message?: unknown; detail?: unknown };
    return String(message ?? detail ?? "");
  });
  return [...new Set(texts)].filter((text) => text !== "");
}

/** What went wrong, in the words of the service, with the line of a file. */
export function problemElements(error: unknown): HTMLElement[] {
  if (!(error instanceof ProblemError)) {
    return [element("strong", "Error"), element("p", error instanceof Error ? error.message : String(error))];
  }
  const { title, detail, remedy, where } = error.problem;
  const line = where?.["line"];
  const place = typeof line === "number" ? `Line ${line}: ` : "";
  return [element("strong", title), element("p", place + detail), element("p", remedy)];
}
