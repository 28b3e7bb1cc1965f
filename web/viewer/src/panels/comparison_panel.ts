// The first two gamuts: the answer as two bars, volumes and a sentence; in detail words, numbers and
// hues; and the part of the first outside the second.
import { fitChart, pageTheme, saveChart } from "../charts/save.js";
import { sectorChart } from "../charts/hues.js";
import { gamutSpace } from "../colours/spaces.js";
import { byId, element, plainRemedy } from "../page/elements.js";
import { type Definition, definitions, withTerms } from "../page/glossary.js";
import { type Coverage, embedded } from "../page/embedded.js";
import { Latest } from "../page/latest.js";
import { type Page, type Shown, axisNames } from "../page/page.js";
import { type Slot, tintOf } from "../page/slots.js";
import { ProblemError } from "../service/api.js";
import { storedCoverage } from "../service/examples.js";
import { type Comparison, compare } from "../service/queries.js";
import { volumeText, volumeUnit } from "./conditions.js";

interface Pair {
  a: Shown;
  b: Shown;
}

/** A gamut, and how much of another one it covers. */
export interface CoverageBar {
  slot: Slot;
  name: string;
  other: string;
  /** From 0 to 1, and in words. */
  share: number;
  text: string;
}

/** Height of the chart in CSS pixels. */
const CHART_HEIGHT = 280;

export class ComparisonPanel {
  private pair: Pair | null = null;
  private comparison: Comparison | null = null;
  private coverage: Coverage | null = null;
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
    page.on(["slots"], () => {
      const [a, b] = [page.at("a"), page.at("b")];
      this.show(a !== null && b !== null ? { a, b } : null);
    });
    page.on(["looks"], () => this.mark());
    page.on(["theme"], () => {
      this.tint();
      if (this.comparison !== null) this.redraw();
    });
    this.highlight.addEventListener("change", () => {
      // The part outside is a part of a solid.
      if (this.highlight.checked) {
        page.setOpacity("a", 1);
        page.setVisible("a", true);
      }
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
    byId("comparison-more").hidden = pair === null;
    this.mark();
    if (!isNew) return;
    this.asking.end();
    this.comparison = null;
    byId("coverage").replaceChildren();
    byId("comparison-figure").hidden = true;
    if (pair !== null) void this.compare(pair);
    else byId("answer").replaceChildren(element("p", "Choose a second gamut to compare it with the first.", { className: "note" }));
  }

  private async compare({ a, b }: Pair): Promise<void> {
    // A saved page has the answer about its first two gamuts, if there was one.
    const saved = embedded?.state?.["comparison"] as Comparison | null | undefined;
    const say = (text: string) => byId("coverage").replaceChildren(element("p", text, { className: "note" }));
    this.answer(null, { a, b });
    if (embedded === null) say("Comparing …");
    await this.asking.ask(
      async (signal) => {
        const stored = await storedCoverage(a.gamut.id, b.gamut.id);
        if (stored !== undefined && !signal.aborted) this.answer(stored, { a, b });
        if (embedded !== null) return saved;
        return compare(a.gamut.id, b.gamut.id, signal);
      },
      (comparison) => comparison && this.tell(comparison, { a, b }),
      (error) => {
        const text = error instanceof ProblemError ? `${error.problem.detail} ${plainRemedy(error.problem)}` : String(error);
        say(text);
        byId("answer").querySelector(".pending")?.replaceChildren(text);
      },
    );
  }

  /** The bars of the answer while the part is open. */
  get bars(): CoverageBar[] {
    const { coverage, pair } = this;
    if (pair === null || coverage === null || !byId<HTMLDetailsElement>("comparison").open) return [];
    return coverageBars(coverage, pair);
  }

  /** State coverage both ways, both volumes, and who reaches further; null while coverage is computed. */
  private answer(coverage: Coverage | null, { a, b }: Pair): void {
    this.coverage = coverage;
    const volumes = [a, b].map(({ gamut }) => `${gamut.name} ${volumeText(gamut)}`).join(", ");
    const isPending = coverage === null && embedded === null;
    byId("answer").replaceChildren(
      ...(coverage === null ? [] : coverageBars(coverage, { a, b }).map(coverageElement)),
      ...(isPending ? [element("p", "Comparing …", { className: "note pending" })] : []),
      element("p", `Volumes: ${volumes} ${volumeUnit(a.gamut)}.`, { className: "note" }),
      ...(coverage === null ? [] : [element("p", reachSentence(coverage.summary, [a.gamut.name, b.gamut.name]))]),
    );
    this.tint();
  }

  /** Give bars the colours of their gamuts. */
  private tint(): void {
    for (const bar of byId("answer").querySelectorAll<HTMLElement>("[data-slot]")) {
      bar.style.backgroundColor = tintOf(bar.dataset["slot"] as Slot, this.page.isDark);
    }
  }

  private tell(comparison: Comparison, { a, b }: Pair): void {
    const names: [string, string] = [a.gamut.name, b.gamut.name];
    this.answer(comparison, { a, b });
    const list = element("ul", "", { className: "sentences" });
    for (const sentence of comparison.summary) {
      const item = element("li");
      item.append(...withTerms(named(sentence, names)));
      list.append(item);
    }
    const numbers = definitions(facts(comparison, names));
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

function coverageBars(coverage: Coverage, { a, b }: Pair): CoverageBar[] {
  const bar = (one: Shown, other: Shown, share: number) =>
    ({ slot: one.slot, name: one.gamut.name, other: other.gamut.name, share, text: shareText(share) });
  return [bar(a, b, coverage.a_covers_b), bar(b, a, coverage.b_covers_a)];
}

function coverageElement({ slot, name, other, share, text }: CoverageBar): HTMLElement {
  const box = element("div", "", { className: "coverage-bar" });
  const line = element("p", `${name} covers `);
  line.append(element("strong", text), ` of ${other}`);
  const track = element("div");
  const bar = element("div");
  bar.dataset["slot"] = slot;
  bar.style.width = `${100 * share}%`;
  track.append(bar);
  box.append(line, track);
  return box;
}

/** Whole per cent; nothing that is not whole is 0 % or 100 %. */
function shareText(share: number): string {
  if (share > 0 && share < 0.005) return "under 1 %";
  if (share >= 0.995 && share < 0.99995) return "over 99 %";
  return `${Math.round(100 * share)} %`;
}

/** Who reaches further at which hues: sentences of the service in one, without figures. */
export function reachSentence(summary: string[], names: [string, string]): string {
  const parts = summary
    .filter((sentence) => /^(A|B|A and B) reach(es)? /.test(sentence))
    .map((sentence) => named(sentence.replace(/(: by up to .*)?\.$/, "").replaceAll(/\(hue (\d+)° to (\d+)°\)/g, "($1–$2°)"), names));
  return parts.length === 0 ? "" : `${parts.join("; ")}.`;
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
