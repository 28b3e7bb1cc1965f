// Two gamuts: coverage both ways, and the part of the first one outside the second.
import { byId, definitions, element } from "../page/elements.js";
import type { Page, Shown } from "../page/page.js";
import { ProblemError } from "../service/api.js";
import { type Comparison, compare } from "../service/queries.js";

interface Pair {
  a: Shown;
  b: Shown;
}

export class ComparisonPanel {
  private pair: Pair | null = null;
  private comparing: AbortController | null = null;
  private readonly highlight = byId<HTMLInputElement>("highlight");

  constructor(private readonly page: Page) {
    page.on("gamuts", () => {
      const [a, b] = [page.at("a"), page.at("b")];
      this.show(a !== null && b !== null ? { a, b } : null);
    });
    this.highlight.addEventListener("change", () => this.mark());
  }

  /** Compare what is shown; null if there are not two gamuts. */
  private show(pair: Pair | null): void {
    const same = (one: Pair | null) => one && `${one.a.gamut.id} ${one.b.gamut.id}`;
    const isNew = same(pair) !== same(this.pair) || pair?.a.layer !== this.pair?.a.layer;
    this.pair = pair;
    byId("comparison").hidden = pair === null;
    this.mark();
    if (!isNew) return;
    this.comparing?.abort();
    byId("coverage").replaceChildren();
    if (pair === null) return;
    void this.compare(pair);
  }

  private async compare({ a, b }: Pair): Promise<void> {
    const comparing = new AbortController();
    this.comparing = comparing;
    const box = byId("coverage");
    box.replaceChildren(element("p", "Comparing …", { className: "note" }));
    try {
      const found = await compare(a.gamut.id, b.gamut.id, comparing.signal);
      const percent = (part: number) => `${(100 * part).toFixed(2)} %`;
      box.replaceChildren(
        definitions([
          [`${a.gamut.name} covers`, `${percent(found.a_covers_b)} of ${b.gamut.name}`],
          [`${b.gamut.name} covers`, `${percent(found.b_covers_a)} of ${a.gamut.name}`],
          ["In common", Number(found.intersection.toPrecision(6)).toLocaleString("en")],
          ["Jaccard index", found.jaccard.toFixed(4)],
        ]),
        ...chromaticities(found, a.gamut.name, b.gamut.name),
        ...found.warnings.map((warning) => element("p", warning, { className: "note" })),
      );
    } catch (error) {
      if (comparing.signal.aborted) return;
      box.replaceChildren(element("p", said(error), { className: "note" }));
    }
  }

  /** Show the part of the first gamut inside the second one in grey, or everything in colour. */
  private mark(): void {
    const { pair, page } = this;
    const isMarked = pair !== null && this.highlight.checked;
    for (const { layer } of page.shown) {
      layer.setGrey(isMarked && layer === pair.a.layer);
      layer.setCounted(isMarked && layer === pair.b.layer);
    }
    page.view.draw();
  }
}

/** Areas and coverage without lightness, labelled as chromaticity. */
function chromaticities({ chromaticity }: Comparison, a: string, b: string): HTMLElement[] {
  if (chromaticity === null) return [];
  const percent = (part: number) => `${(100 * part).toFixed(1)} %`;
  const rows = ([["xy", chromaticity.xy], ["u′v′", chromaticity.uv]] as const).flatMap(
    ([diagram, areas]): [string, string][] => [
      [`${diagram}: area`, `${a} has ${percent(areas.area_ratio)} of ${b}`],
      [`${diagram}: ${a} covers`, `${percent(areas.a_covers_b)} of ${b}`],
      [`${diagram}: ${b} covers`, `${percent(areas.b_covers_a)} of ${a}`],
    ],
  );
  const title = element("p", "Chromaticity, without lightness: CIE 1931 xy and CIE 1976 u′v′", { className: "note" });
  return [title, definitions(rows)];
}

function said(error: unknown): string {
  if (error instanceof ProblemError) return `${error.problem.detail} ${error.problem.remedy}`;
  return error instanceof Error ? error.message : String(error);
}
