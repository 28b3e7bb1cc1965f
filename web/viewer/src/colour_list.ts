// A list of colours: points in the view, vectors to the nearest colours, and a table.
import {
  BufferGeometry,
  Float32BufferAttribute,
  Group,
  LineBasicMaterial,
  LineSegments,
  type Matrix4,
  Points,
  PointsMaterial,
  type Scene,
} from "three";
import type { Gamut } from "./api.js";
import { cssColour, linearSrgb } from "./colours.js";
import { byId, element, save } from "./elements.js";
import { type Nearest, nearest } from "./queries.js";

const MOST_COLOURS = 10_000;
const MOST_TABLE_ROWS = 500;

export interface NamedColour {
  name: string;
  point: number[];
}

/** Fields of a line. Between tabs or semicolons, a comma is a decimal point. */
function fieldsOf(line: string): string[] {
  const separator = line.includes("\t") ? "\t" : line.includes(";") ? ";" : line.includes(",") ? "," : /\s+/;
  const fields = line.trim().split(separator).map((field) => field.trim().replace(/^"|"$/g, ""));
  return separator === "," ? fields : fields.map((field) => field.replace(/^([+\-\u2212]?\d+),(\d+)$/, "$1.$2"));
}

/** The number in a field; the minus may be the sign that the table writes. */
function numberIn(field: string | undefined): number {
  return field === undefined || field === "" ? NaN : Number(field.replace(/^\u2212/, "-"));
}

/** Place of L* in a line that names the columns L*, a*, b*, one after the other; -1 in others. */
function headerPlace(fields: string[]): number {
  const names = fields.map((field) => field.toLowerCase().replace(/^lab_|\*$/g, ""));
  return names.findIndex((name, i) => name === "l" && names[i + 1] === "a" && names[i + 2] === "b");
}

/**
 * Colours of a pasted list, and how many lines have none. A first line may name the columns.
 * Without it, the colour is the last three numbers of a line. The name is what is before it.
 */
export function parsedColours(text: string): { colours: NamedColour[]; leftOut: number } {
  const lines = text.replace(/^\ufeff/, "").split(/\r?\n/).filter((line) => line.trim() !== "").map(fieldsOf);
  const place = headerPlace(lines[0] ?? []);
  const isHeader = place >= 0 || (lines[0] ?? []).every((field) => Number.isNaN(numberIn(field)));
  const rows = isHeader ? lines.slice(1) : lines;
  const colours = rows.flatMap((fields) => {
    const isRow = place >= 0 && fields.length >= place + 3; // else a line that follows no header
    const words = isRow ? fields : fields.filter((field) => field !== "");
    const start = isRow ? place : words.length - 3;
    const point = [0, 1, 2].map((axis) => numberIn(words[start + axis]));
    if (!point.every(Number.isFinite)) return [];
    return [{ name: words.slice(0, start).join(" ").trim(), point }];
  });
  return { colours, leftOut: rows.length - colours.length };
}

export class ColourList {
  private group: Group | null = null;
  private asking: AbortController | null = null;
  private gamut: Gamut | null = null;
  private turn: Matrix4 | null = null;
  private answer: { colours: NamedColour[]; found: Nearest } | null = null;
  private readonly text = byId<HTMLTextAreaElement>("colours");

  constructor(
    private readonly scene: Scene,
    private readonly changed: () => void,
    private readonly fail: (error: unknown) => void,
  ) {
    byId("check").addEventListener("click", () => void this.check());
    byId("colours-clear").addEventListener("click", () => {
      this.text.value = "";
      void this.check();
    });
    byId("colours-csv").addEventListener("click", () => this.download());
    byId<HTMLInputElement>("colours-file").addEventListener("change", (event) => {
      const [file] = (event.target as HTMLInputElement).files ?? [];
      void file?.text().then((text) => {
        this.text.value = text;
        return this.check();
      });
    });
    byId("colours-open").addEventListener("click", () => byId("colours-file").click());
  }

  /** Ask about another gamut. */
  show(gamut: Gamut | null, turn: Matrix4 | null): void {
    if (gamut?.id === this.gamut?.id) return;
    [this.gamut, this.turn] = [gamut, turn];
    byId<HTMLButtonElement>("check").disabled = gamut === null;
    if (this.answer !== null) void this.check();
  }

  private async check(): Promise<void> {
    this.asking?.abort();
    this.clear();
    this.fail(null);
    const parsed = parsedColours(this.text.value);
    const colours = parsed.colours.slice(0, MOST_COLOURS);
    if (this.gamut === null || colours.length === 0) {
      byId("colours-note").textContent = this.text.value.trim() === "" ? "" : "No line ends with three numbers.";
      return;
    }
    const asking = new AbortController();
    this.asking = asking;
    try {
      const points = colours.map(({ point }) => point);
      const found = await nearest(this.gamut, points, asking.signal);
      this.answer = { colours, found };
      this.draw(colours, found);
      this.tabulate(colours, found);
      this.noteRest(parsed.colours.length - colours.length, parsed.leftOut);
    } catch (error) {
      if (!asking.signal.aborted) this.fail(error);
    }
  }

  /** Say what of the list was not asked about. */
  private noteRest(beyond: number, leftOut: number): void {
    const notes = [
      leftOut > 0 ? ` ${leftOut} lines have no three numbers and are left out.` : "",
      beyond > 0 ? ` ${beyond} more colours are left out: at most ${MOST_COLOURS}.` : "",
    ];
    byId("colours-note").append(...notes);
  }

  private draw(colours: NamedColour[], found: Nearest): void {
    const points = colours.flatMap(({ point }) => point);
    const isLab = this.gamut!.options.space === "CIELAB";
    const linear = isLab ? [...linearSrgb(Float32Array.from(points))] : points.map(() => 0.5);
    const vectors = colours.flatMap(({ point }, i) => (found.inside[i] ? [] : [...point, ...found.point[i]!]));
    const ends = colours.flatMap((_, i) => (found.inside[i] ? [] : found.point[i]!));
    const beyond = colours.flatMap(({ point }, i) => (found.inside[i] ? [] : point));
    const line = getComputedStyle(document.body).color;
    const alert = getComputedStyle(byId("problem")).borderTopColor;
    const geometry = (positions: number[]) =>
      new BufferGeometry().setAttribute("position", new Float32BufferAttribute(positions, 3));
    const spots = geometry(points).setAttribute("color", new Float32BufferAttribute(linear, 3));
    const size = (pixels: number) => ({ size: pixels, sizeAttenuation: false, depthTest: false });
    this.group = new Group();
    const parts = [
      new LineSegments(geometry(vectors), new LineBasicMaterial({ color: line, depthTest: false })),
      new Points(geometry(ends), new PointsMaterial({ color: line, ...size(4) })),
      // Colours outside have a wide frame of the colour of problems.
      new Points(geometry(beyond), new PointsMaterial({ color: alert, ...size(15) })),
      new Points(spots, new PointsMaterial({ color: line, ...size(11) })),
      new Points(spots, new PointsMaterial({ vertexColors: true, ...size(8) })),
    ];
    parts.forEach((part, place) => {
      part.renderOrder = 3 + place;
      part.frustumCulled = false;
    });
    this.group.add(...parts);
    this.group.applyMatrix4(this.turn!);
    this.scene.add(this.group);
    this.changed();
  }

  private tabulate(colours: NamedColour[], found: Nearest): void {
    const outside = found.inside.filter((inside) => !inside).length;
    const rest = colours.length - MOST_TABLE_ROWS;
    byId("colours-note").textContent =
      `${colours.length} colours, ${outside} outside.` +
      (rest > 0 ? ` The table has the first ${MOST_TABLE_ROWS}, the file all.` : "");
    byId("colours-warnings").replaceChildren(
      ...found.warnings.map((warning) => element("p", warning, { className: "warning" })),
    );
    const head = element("tr");
    const channels = found.device ? [`${this.gamut!.channels.join(" ")}, %`] : [];
    const heads = ["Colour", "In gamut", "ΔE00", ...channels, "Nearest"];
    for (const text of heads) {
      const cell = element("th", text);
      cell.scope = "col";
      head.append(cell);
    }
    const rows = colours.slice(0, MOST_TABLE_ROWS).map(({ name, point }, i) => {
      const row = element("tr");
      const first = element("th", name === "" ? rounded(point) : name);
      first.scope = "row";
      if (this.gamut!.options.space === "CIELAB") {
        const spot = element("span", "", { className: "spot" });
        spot.style.backgroundColor = cssColour(linearSrgb(Float32Array.from(point)));
        first.prepend(spot);
      }
      const inside = found.inside[i]!;
      const device = found.device?.[i]!.map((value) => Math.round(100 * value)).join(" ");
      row.append(
        first,
        element("td", inside ? "yes" : "no"),
        element("td", inside ? "0" : found.delta_e_2000[i]!.toFixed(2)),
        ...(device === undefined ? [] : [element("td", inside ? "" : device)]),
        element("td", inside ? "itself" : rounded(found.point[i]!)),
      );
      return row;
    });
    const table = element("table");
    const body = element("tbody");
    const top = element("thead");
    top.append(head);
    body.append(...rows);
    table.append(element("caption", `Colours in ${this.gamut!.name}`), top, body);
    byId("colours-table").replaceChildren(table);
    byId("colours-table").hidden = false;
    byId<HTMLButtonElement>("colours-csv").disabled = false;
  }

  private download(): void {
    if (this.answer === null) return;
    const { colours, found } = this.answer;
    const quoted = (text: string) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
    const channels = found.device ? this.gamut!.channels : [];
    const names = ["c1", "c2", "c3"];
    const head = ["name", ...names, "inside", "ΔE00", ...names.map((name) => `nearest ${name}`), ...channels];
    const rows = colours.map(({ name, point }, i) => {
      const inside = found.inside[i]!;
      const device = found.device?.[i] ?? [];
      const difference = inside ? 0 : found.delta_e_2000[i]!;
      return [quoted(name), ...point, inside, difference, ...(inside ? point : found.point[i]!), ...(inside ? device.map(() => "") : device)];
    });
    const blob = new Blob([[head, ...rows].map((row) => row.join(",")).join("\n"), "\n"], { type: "text/csv" });
    save(blob, `colours in ${this.gamut!.name}.csv`);
  }

  private clear(): void {
    this.group?.traverse((part) => {
      if (!(part instanceof Points) && !(part instanceof LineSegments)) return;
      part.geometry.dispose();
      (part.material as LineBasicMaterial | PointsMaterial).dispose();
    });
    this.group?.removeFromParent();
    this.group = null;
    this.answer = null;
    byId("colours-warnings").replaceChildren();
    byId("colours-table").replaceChildren();
    byId("colours-table").hidden = true;
    byId("colours-note").textContent = "";
    byId<HTMLButtonElement>("colours-csv").disabled = true;
    this.changed();
  }
}

function rounded(point: number[]): string {
  return point.map((value) => Number(value.toFixed(2)).toString().replace("-", "−")).join(" ");
}
