// The first two gamuts: in words, in numbers and by hue, and the part of the first outside the second.
import { fitChart, pageTheme, saveChart } from "../charts/save.js";
import { sectorChart } from "../charts/hues.js";
import { gamutSpace } from "../colours/spaces.js";
import { byId, element, plainRemedy } from "../page/elements.js";
import { type Definition, definitions, withTerms } from "../page/glossary.js";
import { embedded } from "../page/embedded.js";
import { Latest } from "../page/latest.js";
import { type Page, type Shown, axisNames } from "../page/page.js";
import type { Style } from "../scene/layer.js";
import { ProblemError } from "../service/api.js";
import { type Comparison, compare } from "../service/queries.js";
import { volumeUnit } from "./conditions.js";

interface Pair {
  a: Shown;
  b: Shown;
}

const SOLIDS: Style[] = ["solid", "shaded", "both"];
/** Height of the chart in CSS pixels. */
const CHART_HEIGHT = 280;

export class ComparisonPanel {
  private pair: Pair | null = null;
  private comparison: Comparison | null = null;
  private readonly asking = new Latest();
  private chart = "";
  private readonly highlight = byId<HTMLInputElement>("highlight");
  private readonly redraw: () => void;

  constructor(private readonly page: Page) {
    this.redraw = fitChart(byId("comparison-chart"), (width) => {
      this.chart = this.sectors(width);
      return this.chart;
    });
    page.address.add({
      read: (given) => {
        this.highlight.checked = given.get("outside") === "on";
      },
      write: () => [["outside", this.highlight.checked ? "on" : null]],
    });
    page.kept.set("comparison", () => this.comparison);
    page.on("gamuts", () => {
      const [a, b] = [page.at("a"), page.at("b")];
      this.show(a !== null && b !== null ? { a, b } : null);
    });
    page.on("theme", () => this.comparison !== null && this.redraw());
    this.highlight.addEventListener("change", () => {
      // The part outside is a part of a solid.
      if (this.highlight.checked && !SOLIDS.includes(page.styles.a)) page.setStyle("a", "solid");
      this.mark();
      page.address.save();
    });
    for (const format of ["svg", "png"] as const) {
      byId(`comparison-${format}`).addEventListener("click", () => {
        const { a, b } = this.pair!;
        void saveChart(this.chart, `${a.gamut.name} and ${b.gamut.name} by hue`, format, 3);
      });
    }
  }

  /** Compare what is shown; null if there are not two gamuts. */
  private show(pair: Pair | null): void {
    const same = (one: Pair | null) => one && `${one.a.gamut.id} ${one.b.gamut.id}`;
    const isNew = same(pair) !== same(this.pair) || pair?.a.layer !== this.pair?.a.layer;
    this.pair = pair;
    byId("comparison").hidden = pair === null;
    this.mark();
    if (!isNew) return;
    this.asking.end();
    this.comparison = null;
    byId("coverage").replaceChildren();
    byId("comparison-figure").hidden = true;
    if (pair !== null) void this.compare(pair);
  }

  private async compare({ a, b }: Pair): Promise<void> {
    // A saved page has the answer about its first two gamuts, if there was one.
    const saved = embedded?.state?.["comparison"] as Comparison | null | undefined;
    const say = (text: string) => byId("coverage").replaceChildren(element("p", text, { className: "note" }));
    if (embedded === null) say("Comparing …");
    await this.asking.ask(
      async (signal) => (embedded === null ? compare(a.gamut.id, b.gamut.id, signal) : saved),
      (comparison) => comparison && this.tell(comparison, { a, b }),
      (error) => say(error instanceof ProblemError ? `${error.problem.detail} ${plainRemedy(error.problem)}` : String(error)),
    );
  }

  private tell(comparison: Comparison, { a, b }: Pair): void {
    const names: [string, string] = [a.gamut.name, b.gamut.name];
    const list = element("ul", "", { className: "sentences" });
    for (const sentence of comparison.summary) {
      const item = element("li");
      item.append(...withTerms(named(sentence, names)));
      list.append(item);
    }
    const numbers = element("details");
    numbers.append(element("summary", "Numbers"), definitions(facts(comparison, names)));
    const warnings = comparison.warnings.map((warning) => element("p", warning, { className: "warning" }));
    byId("coverage").replaceChildren(list, numbers, ...warnings);
    this.comparison = comparison;
    const hasHue = axisNames(a.gamut)[0] !== "X";
    byId("comparison-figure").hidden = !hasHue;
    if (hasHue) this.redraw();
  }

  private sectors(width: number): string {
    const { pair, comparison } = this;
    if (pair === null || comparison === null) return "<svg xmlns='http://www.w3.org/2000/svg'/>";
    const { a, b } = pair;
    return sectorChart(a.gamut.name, b.gamut.name, comparison.sectors, {
      size: { width, height: CHART_HEIGHT },
      theme: pageTheme(byId("comparison-chart"), "--back"),
      space: gamutSpace(a.gamut),
      unit: volumeUnit(a.gamut),
    });
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

/** A sentence of the service with the names of the gamuts instead of A and B. */
export function named(sentence: string, [a, b]: [string, string]): string {
  return sentence.replaceAll(/\b[AB]\b/g, (letter) => (letter === "A" ? a : b));
}

function facts(comparison: Comparison, [a, b]: [string, string]): Definition[] {
  const percent = (part: number) => `${(100 * part).toFixed(2)} %`;
  const colour = (values: number[]) => values.map((value) => Number(value.toFixed(value < 5 && value > -5 ? 3 : 1))).join(" ").replaceAll("-", "−");
  const rows: Definition[] = [
    [`${a} covers`, `${percent(comparison.a_covers_b)} of ${b}`, "The volume that both have, relative to the volume of the covered gamut."],
    [`${b} covers`, `${percent(comparison.b_covers_a)} of ${a}`],
  ];
  for (const [loss, name, other] of [[comparison.lost_a, a, b], [comparison.lost_b, b, a]] as const) {
    if (loss == null) continue;
    rows.push([
      `${name} loses in ${other}`,
      `ΔE00 ${loss.mean.toFixed(2)} on average, ${loss.percentile_95.toFixed(1)} at the 95th percentile`,
      "Colour difference CIEDE2000 between the surface and the nearest colours of the other gamut; 0 where it has them.",
    ]);
  }
  rows.push(
    ["White points", `${a} ${colour(comparison.white_a)}; ${b} ${colour(comparison.white_b)}`, "Lightest colours."],
    ["Black points", `${a} ${colour(comparison.black_a)}; ${b} ${colour(comparison.black_b)}`, "Darkest colours."],
    ["In common", Number(comparison.intersection.toPrecision(6)).toLocaleString("en"), "Volume that both have, in cubic units of the space."],
    ["Jaccard index", comparison.jaccard.toFixed(4), "The volume that both have, relative to the volume that at least one has; 1 for equal gamuts."],
  );
  if (comparison.chromaticity !== null) {
    for (const [diagram, areas] of [["x, y", comparison.chromaticity.xy], ["u′, v′", comparison.chromaticity.uv]] as const) {
      rows.push(
        [`${diagram}: ${a} covers`, `${percent(areas.a_covers_b)} of ${b}; area ${percent(areas.area_ratio)}`, "Areas in the chromaticity diagram, without lightness."],
        [`${diagram}: ${b} covers`, `${percent(areas.b_covers_a)} of ${a}`],
      );
    }
  }
  return rows;
}
