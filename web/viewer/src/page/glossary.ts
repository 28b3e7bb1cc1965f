// A sentence for each term of the page, shown on hover, on focus and on tap.
import { byId, element } from "./elements.js";

/** Terms in lower case, each with its sentence. */
export const TERMS: Record<string, string> = {
  triangles: "The surface of a gamut is made of flat triangles. More of them follow it more closely.",
  "full boundary": "The surface with all triangles, before any were taken away.",
  δe00: "CIEDE2000: how different two colours look. One unit is about what an eye can just see.",
  "rendering intent": "How the white of the paper or display is treated when colours are converted.",
  "ink limit": "Largest sum of all inks that the press may print. Four full inks are 400 %.",
  volume: "The size of the solid in cubic units of its space. × sRGB divides it by that of sRGB in the same space.",
  channels: "Inks or lights of the device, in the order of its values.",
  projection: "Perspective makes near things larger. Orthographic keeps sizes, for measuring by eye.",
  // Titles of the table of colours, or their first words.
  where: "Inside, outside, or on the edge: so close to the surface that it may be either.",
  euclidean: "Euclidean distance from the surface in units of the space of the gamut; below 0 inside.",
  recipe: "Device values, such as amounts of ink, that give the colour.",
  "recipe δe00": "CIEDE2000 between the wanted colour and the colour that the recipe gives.",
  possible: "Least and largest amount of black with which the device gives the colour.",
};

/** The sentence of a title of a table. */
export function sentenceOf(title: string): string | undefined {
  const text = title.toLowerCase();
  return TERMS[text] ?? TERMS[text.split(/[ ,]/)[0]!];
}

/** A term with its sentence; a plain text if there is none. */
export function term(text: string, sentence = TERMS[text.toLowerCase()]): HTMLElement {
  if (sentence === undefined) return element("span", text);
  const button = element("button", text, { type: "button", className: "term" });
  button.dataset["note"] = sentence;
  return button;
}

/** A term, its meaning, and an explanation that is shown on hover or tap. */
export type Definition = [term: string, meaning: string, explanation?: string];

/** A description list. Terms with a sentence, given or of the glossary, show it. */
export function definitions(all: Definition[]): HTMLDListElement {
  const list = element("dl");
  for (const [name, meaning, sentence] of all) {
    const head = element("dt");
    head.append(term(name, sentence));
    list.append(head, element("dd", meaning));
  }
  return list;
}

/** Parts of a text, of which colour differences show their sentence. */
export function withTerms(text: string): (string | HTMLElement)[] {
  return text.split(/(ΔE00)/).map((part, place) => (place % 2 === 1 ? term(part) : part));
}

/** Show sentences of terms, also of those that are made later. Titles and labels of the page become terms. */
export function connectGlossary(): void {
  const box = byId("term-note");
  for (const title of document.querySelectorAll<HTMLElement>("[data-term]")) {
    const made = term(title.textContent, TERMS[title.dataset["term"]!]);
    if (title instanceof HTMLLabelElement) {
      // A button within a label would be pressed instead of its control.
      made.id = `${title.htmlFor}-term`;
      byId(title.htmlFor).setAttribute("aria-labelledby", made.id);
    }
    title.replaceWith(made);
  }
  let shown: HTMLElement | null = null;
  const hide = () => {
    shown?.removeAttribute("aria-describedby");
    shown = null;
    if (box.matches(":popover-open")) box.hidePopover();
  };
  const show = (button: HTMLElement) => {
    if (button === shown) return;
    hide();
    shown = button;
    box.textContent = button.dataset["note"] ?? "";
    button.setAttribute("aria-describedby", box.id);
    box.showPopover();
    const place = button.getBoundingClientRect();
    const { offsetWidth: width, offsetHeight: height } = box;
    box.style.left = `${Math.max(8, Math.min(place.left, innerWidth - width - 8))}px`;
    box.style.top = `${place.bottom + height + 8 > innerHeight ? place.top - height - 4 : place.bottom + 4}px`;
  };
  const termOf = ({ target }: Event) => (target instanceof Element ? target.closest<HTMLElement>("[data-note]") : null);
  for (const event of ["pointerover", "focusin", "click"]) {
    addEventListener(event, (happened) => {
      // A title of a table that was pressed has been replaced by another one, which is shown.
      if ((happened.target as Partial<Node>).isConnected === false) return;
      const button = termOf(happened);
      if (button !== null) show(button);
      else if (shown !== document.activeElement || event === "click") hide();
    });
  }
  addEventListener("keydown", ({ key }) => key === "Escape" && hide());
  addEventListener("scroll", hide, true);
}
