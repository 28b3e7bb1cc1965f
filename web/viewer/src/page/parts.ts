// Parts of the panel: one that opens comes into sight, and stays there while its answer grows.
import { byId } from "./elements.js";

/** The part that the reader used last, until the panel is scrolled. */
let part: HTMLElement | null = null;

const follow = () => part?.scrollIntoView({ block: "nearest" });

/** Open a part and bring it into sight. */
export function reveal(id: string): void {
  part = byId(id);
  (part as HTMLDetailsElement).open = true;
  follow();
}

export function connectParts(): void {
  const panel = byId("panel");
  const sizes = new ResizeObserver(follow);
  for (const each of panel.querySelectorAll<HTMLDetailsElement>(".part")) {
    sizes.observe(each);
    each.firstElementChild!.addEventListener("click", () => {
      part = each.open ? null : each; // it opens after this event
    });
  }
  const release = () => (part = null);
  for (const event of ["wheel", "touchmove"]) panel.addEventListener(event, release, { passive: true });
  // The bar of the panel is no part of its content.
  panel.addEventListener("pointerdown", ({ target }) => target === panel && release());
  panel.addEventListener("keydown", ({ key }) => /^(Page|Home|End|Arrow)/.test(key) && release());
}
