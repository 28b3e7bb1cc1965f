// A sentence for each term of the page, shown on hover, on focus and on tap.
import { byId, element } from "./elements.js";

/** Terms in lower case, each with its sentence. */
export const TERMS: Record<string, string> = {
  gamut: "All colours that a device can show or print, as a solid in a colour space.",
  reference: "A gamut that is defined by a standard, such as sRGB, instead of a file.",
  level: "A coarser or finer version of the same surface: with fewer triangles it is quicker to draw and a little less exact.",
  triangles: "The surface of a gamut is made of flat triangles. More of them follow it more closely.",
  "full boundary": "The surface with all triangles, before any were taken away.",
  "δe*ab": "Distance of two colours in CIELAB. One unit is about what an eye can just see.",
  δe00: "CIEDE2000: the difference of two colours as people see it. One unit is about what an eye can just see.",
  "recipe δe00": "CIEDE2000 between the wanted colour and the colour that the recipe gives.",
  edge: "A colour so close to the surface that it may be inside or outside, within the accuracy of the data.",
  tolerance: "Distance beyond the surface up to which a colour counts as inside.",
  coverage: "Part of one gamut's volume that the other gamut has as well.",
  "jaccard index": "Volume that both gamuts have in common, divided by the volume of both together: 1 if they are equal.",
  "in common": "Volume of the colours that both gamuts have.",
  comparison: "How much of each gamut the other one has as well.",
  "rendering intent": "How the white of the paper or display is treated when colours are converted.",
  "ink limit, %": "Largest sum of all inks that the press may print. Four full inks are 400 %.",
  "media-relative": "Colours are stated as if the white of the paper or display were the white of the space.",
  space: "The coordinates in which colours are drawn and measured, such as CIELAB.",
  hue: "The kind of a colour, such as red or green, as an angle around the grey axis.",
  chroma: "How far a colour is from grey.",
  lightness: "How light a colour is, from 0 for black to 100 for white.",
  cusp: "The colour with the largest chroma at a hue.",
  cusps: "The colours with the largest chroma at each hue.",
  recipe: "Device values, such as amounts of ink, that give a colour.",
  slice: "The outline of a gamut where a plane cuts it.",
  "gamut rings": "The chroma of a gamut by hue, added up in steps of lightness. The area is the volume (IDMS 1.1).",
  volume: "The size of the solid in cubic units of its space: a measure of how many colours it has. × sRGB divides it by the volume of sRGB in the same space, relative to its white.",
  method: "How the surface was found from the colours of the device.",
  channels: "Inks or lights of the device, in the order of its values.",
  projection: "Perspective makes near things larger, as eyes see them. Orthographic keeps sizes, for measuring by eye.",
};

/** A term with its sentence; a plain text if there is none. */
export function term(text: string, sentence = TERMS[text.toLowerCase()]): HTMLElement {
  if (sentence === undefined) return element("span", text);
  const button = element("button", text, { type: "button", className: "term" });
  button.dataset["note"] = sentence;
  return button;
}

/** Show sentences of terms, also of those that are made later. Titles of the page become terms. */
export function connectGlossary(): void {
  const box = byId("term-note");
  for (const title of document.querySelectorAll<HTMLElement>("[data-term]")) {
    title.replaceWith(term(title.textContent, TERMS[title.dataset["term"]!]));
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
  const termOf = ({ target }: Event) => (target instanceof Element ? target.closest<HTMLElement>(".term") : null);
  for (const event of ["pointerover", "focusin", "click"]) {
    addEventListener(event, (happened) => {
      const button = termOf(happened);
      if (button !== null) show(button);
      else if (shown !== document.activeElement || event === "click") hide();
    });
  }
  addEventListener("keydown", ({ key }) => key === "Escape" && hide());
  addEventListener("scroll", hide, true);
}
