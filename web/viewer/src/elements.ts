// Small helpers for elements of the page.

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

/** A description list of terms and meanings. */
export function definitions(pairs: [string, string][]): HTMLDListElement {
  const list = element("dl");
  for (const [term, meaning] of pairs) list.append(element("dt", term), element("dd", meaning));
  return list;
}
