// Which of three or more gamuts print the list of colours: a row for each colour, a column for each gamut.
import { SCREEN, cssColour } from "../colours/colours.js";
import { gamutSpace } from "../colours/spaces.js";
import { byId, element, problemElements, warningTexts } from "../page/elements.js";
import { embedded } from "../page/embedded.js";
import { Latest } from "../page/latest.js";
import type { Page } from "../page/page.js";
import { request } from "../service/api.js";
import type { Position, TableReading } from "../service/queries.js";
import type { ColourList } from "./colour_list.js";
import { type Column, SortedTable } from "./sorted_table.js";

/** Fewest gamuts of a table: two are compared as a pair. */
const FEWEST = 3;

interface MatchedGamut {
  name: string;
  share: number;
  mean_delta_e_2000: number;
  position: Position[];
  delta_e_2000: number[];
}

interface Match {
  colours: { name: string[]; point: number[][]; printed_by: number[]; best: string[] };
  gamuts: MatchedGamut[];
  together: { gamuts: string[]; printed: number; exact: boolean }[];
  warnings: unknown[];
}

export class MatchTable {
  private readonly asking = new Latest();
  private readonly section = byId("match-section");
  private readonly table = new SortedTable(byId("match-table"));
  /** Ids of the gamuts that the table is of. */
  private asked = "";

  constructor(private readonly page: Page, private readonly list: ColourList) {
    if (embedded !== null) return;
    list.onChange = () => this.update();
    page.on(["slots"], () => this.ids.join() !== this.asked && this.update());
  }

  private get ids(): string[] {
    return this.page.shown.map(({ gamut }) => gamut.id);
  }

  /** Ask about the gamuts and the list as they are now. */
  private update(): void {
    const { ids, list } = this;
    this.asking.end();
    this.table.clear();
    this.asked = ids.join();
    const { colours } = list;
    this.section.hidden = ids.length < FEWEST || colours === null;
    byId("match-shares").replaceChildren();
    byId("match-note").replaceChildren();
    if (this.section.hidden || colours === null) return;
    void this.asking.ask(
      (signal) => matched(ids, colours, list.stated(), signal),
      (match) => this.show(match),
      (error) => byId("match-note").replaceChildren(...problemElements(error)),
    );
  }

  private show({ colours, gamuts, together, warnings }: Match): void {
    const count = colours.name.length;
    byId("match-shares").replaceChildren(
      ...gamuts.flatMap(({ name, share, mean_delta_e_2000: mean }) => [
        element("dt", name),
        element("dd", `prints ${Math.round(share * count)} of ${count} (${(100 * share).toFixed(0)} %), mean ΔE00 ${mean.toFixed(2)}`),
      ]),
    );
    const groups = together.map(
      ({ gamuts: names, printed, exact }) => `${inWords(names)} together print ${printed}${exact ? "" : " or more"}.`,
    );
    byId("match-note").replaceChildren(
      element("p", groups.join(" "), { className: "note" }),
      ...warningTexts(warnings).map((warning) => element("p", warning, { className: "warning" })),
    );
    const linear = gamutSpace(this.page.shown[0]!.gamut).linear(Float32Array.from(colours.point.flat()), SCREEN);
    const named = (row: number) => {
      const cell = element("span", colours.name[row]!, { title: colours.name[row]! });
      const spot = element("span", "", { className: "spot" });
      spot.style.backgroundColor = cssColour(linear.subarray(3 * row, 3 * row + 3));
      cell.prepend(spot);
      return cell;
    };
    const columns: Column[] = [
      { title: "Colour", value: (row) => colours.name[row]!, cell: named },
      ...gamuts.map(({ name, position, delta_e_2000: difference }) => ({
        title: name,
        value: (row: number) => difference[row]!,
        cell: (row: number) =>
          element("span", `${position[row]!} ${difference[row]!.toFixed(1)}`, { className: `where-${position[row]!}` }),
      })),
      { title: "Printed by", value: (row) => colours.printed_by[row]! },
      { title: "Best", value: (row) => colours.best[row]! },
    ];
    this.table.show("Position and ΔE00 from the nearest colour of each gamut", columns, count);
  }
}

async function matched(ids: string[], table: Blob, reading: TableReading, signal: AbortSignal): Promise<Match> {
  const stated = Object.entries(reading).filter(([, value]) => value !== "");
  const query = new URLSearchParams([["gamuts", ids.join(",")], ...stated]);
  const response = await request(`/v1/matches?${query}`, {
    method: "POST",
    body: table,
    signal,
    headers: { "Content-Type": "application/octet-stream" }, // the service recognises the form
  });
  return (await response.json()) as Match;
}

function inWords(names: string[]): string {
  return `${names.slice(0, -1).join(", ")} and ${names.at(-1)}`;
}
