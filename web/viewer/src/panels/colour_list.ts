// A list of colours: points in the view, vectors to the nearest colours, and a table.
import {
  BufferGeometry,
  Float32BufferAttribute,
  Group,
  LineBasicMaterial,
  LineSegments,
  Points,
  PointsMaterial,
} from "three";
import { SCREEN, cssColour } from "../colours/colours.js";
import { spaceOf } from "../colours/spaces.js";
import { blackChannel, blackRange, deviceText, deviceUnit } from "../colours/device_values.js";
import { byId, element, problemElements, save, warningTexts } from "../page/elements.js";
import { type Page, axisNames } from "../page/page.js";
import { orientation } from "../scene/layer.js";
import { type Gamut, ProblemError } from "../service/api.js";
import {
  type CheckedTable,
  type Nearest,
  type Position,
  type Recipes,
  type TableReading,
  checkTable,
  edgeText,
  mayHaveRecipes,
  nearest,
  recipes,
} from "../service/queries.js";

const MOST_TABLE_ROWS = 500;

interface Answer {
  found: CheckedTable;
  near: Nearest;
  /** Recipes of the colours, and of the nearest ones of those outside; null before they are there. */
  made: Recipes | null;
}

export class ColourList {
  private group: Group | null = null;
  private asking: AbortController | null = null;
  private gamut: Gamut | null = null;
  private answer: Answer | null = null;
  /** The opened file. Typing in the list puts it away. */
  private file: File | null = null;
  private readonly text = byId<HTMLTextAreaElement>("colours");
  private readonly reading = byId<HTMLDetailsElement>("colours-reading");

  constructor(private readonly page: Page) {
    page.on("gamuts", () => this.show(page.at("a")?.gamut ?? null));
    byId("check").addEventListener("click", () => void this.check());
    byId("colours-clear").addEventListener("click", () => {
      this.text.value = "";
      this.file = null;
      void this.check();
    });
    byId("colours-csv").addEventListener("click", () => this.download());
    byId<HTMLInputElement>("colours-file").addEventListener("change", (event) => {
      const input = event.target as HTMLInputElement;
      const [file] = input.files ?? [];
      if (file === undefined) return;
      this.file = file;
      this.text.value = "";
      void this.check().then(() => {
        input.value = ""; // the same file can be opened again
      });
    });
    byId("colours-open").addEventListener("click", () => byId("colours-file").click());
    this.text.addEventListener("input", () => {
      this.file = null;
    });
    this.reading.addEventListener("change", () => {
      this.summarise();
      if (this.table !== null) void this.check();
    });
    this.summarise();
  }

  /** Ask about another gamut. */
  private show(gamut: Gamut | null): void {
    if (gamut?.id === this.gamut?.id) return;
    this.gamut = gamut;
    byId<HTMLButtonElement>("check").disabled = gamut === null;
    if (this.answer !== null) void this.check();
  }

  /** The list as it is sent: the file, or what is in the field. */
  private get table(): Blob | null {
    return this.file ?? (this.text.value.trim() === "" ? null : new Blob([this.text.value]));
  }

  private stated(): TableReading {
    const value = (name: string) => byId<HTMLInputElement | HTMLSelectElement>(`colours-${name}`).value.trim();
    return { space: value("space"), columns: value("columns"), table_scale: value("scale") };
  }

  private summarise(): void {
    const { space, columns, table_scale: scale } = this.stated();
    const parts = [space, scale && `white at ${scale}`, columns && `columns ${columns}`].filter((part) => part !== "");
    byId("colours-reading-summary").textContent = parts.join(", ") || "the table says";
  }

  private async check(): Promise<void> {
    this.asking?.abort();
    this.clear();
    this.page.complain(null);
    const table = this.table;
    if (this.gamut === null || table === null) return;
    const scale = byId<HTMLInputElement>("colours-scale");
    if (!scale.checkValidity()) {
      this.reading.open = true;
      scale.reportValidity();
      return;
    }
    const asking = new AbortController();
    this.asking = asking;
    try {
      const found = await checkTable(this.gamut, table, this.stated(), asking.signal);
      const near = await nearest(this.gamut, found.colours, asking.signal);
      this.answer = { found, near, made: null };
      this.draw(this.answer);
      this.tabulate(this.answer);
      void this.addRecipes(this.answer, asking.signal);
    } catch (error) {
      if (asking.signal.aborted) return;
      this.refuse(error);
    }
  }

  /** Ask for recipes, and show them. Without them, the table stays as it is. */
  private async addRecipes(answer: Answer, signal: AbortSignal): Promise<void> {
    const { found, near } = answer;
    const gamut = this.gamut!;
    if (!mayHaveRecipes(gamut)) return;
    const note = byId("colours-recipes");
    note.textContent = "The recipes of the colours are on their way.";
    try {
      const targets = found.colours.map((point, i) => (found.inside[i] ? point : near.point[i]!));
      answer.made = await recipes(gamut, targets, signal);
      if (signal.aborted) return;
      note.textContent = "";
    } catch (error) {
      if (signal.aborted) return;
      const [, ...words] = problemElements(error);
      note.textContent = ["There are no recipes.", ...words.map((word) => word.textContent)].join(" ");
    }
    this.tabulate(answer);
  }

  /** Show why the service refuses the list, beside it. */
  private refuse(error: unknown): void {
    if (error instanceof ProblemError && [401, 403].includes(error.problem.status)) {
      this.page.complain(error);
      return;
    }
    if (error instanceof ProblemError && error.problem.code === "too-many-rows") {
      error.problem.remedy = "Check fewer colours at once. The command gamut query takes files of any length.";
    }
    const [, ...words] = problemElements(error);
    byId("colours-problem").replaceChildren(element("strong", "The list is refused"), ...words);
    byId("colours-problem").hidden = false;
    this.reading.open = true; // how it is to be read can be stated there
  }

  private draw({ found, near }: Answer): void {
    const { colours, inside, position } = found;
    const points = colours.flat();
    const linear = spaceOf(this.gamut!.provenance.colour_space).linear(Float32Array.from(points), SCREEN);
    const vectors = colours.flatMap((point, i) => (inside[i] ? [] : [...point, ...near.point[i]!]));
    const ends = near.point.flatMap((point, i) => (inside[i] ? [] : point));
    const beyond = colours.flatMap((point, i) => (position[i] === "outside" ? point : []));
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
    this.group.applyMatrix4(orientation(axisNames(this.gamut!)));
    this.page.view.scene.add(this.group);
    this.page.view.draw();
  }

  /** The name of a colour, or its coordinates where its row has none. */
  private label({ labels, lines, colours }: CheckedTable, row: number): string {
    return labels[row] === `line ${lines[row]}` ? rounded(colours[row]!) : labels[row]!;
  }

  private tabulate({ found, near, made }: Answer): void {
    const { colours, inside, position } = found;
    const count = (where: Position) => `${position.filter((each) => each === where).length} ${where}`;
    const rest = colours.length - MOST_TABLE_ROWS;
    const sentences = [
      this.file === null ? "" : `${this.file.name}: `,
      `${colours.length} ${colours.length === 1 ? "colour" : "colours"}: ${count("inside")}, ${count("edge")}, ${count("outside")} (${edgeText(found)}).`,
      ` ${found.reading}`,
      rest > 0 ? ` The table has the first ${MOST_TABLE_ROWS}, the file all.` : "",
    ];
    byId("colours-note").textContent = sentences.join("");
    byId("colours-warnings").replaceChildren(
      ...warningTexts([found, near, made].flatMap((each) => each?.warnings ?? [])).map((warning) =>
        element("p", warning, { className: "warning" }),
      ),
    );
    const head = element("tr");
    const { channels } = this.gamut!;
    const hasBlack = made?.black_least !== undefined;
    const heads = [
      ...["Colour", "Where", "ΔE00"],
      ...(made ? [`Recipe, ${deviceUnit(channels)}`] : near.device ? [`${channels.join(" ")}, ${deviceUnit(channels)}`] : []),
      ...(hasBlack ? [`Possible ${blackChannel(channels)}, %`] : []),
      ...(made ? ["Recipe ΔE00"] : []),
      "Nearest",
    ];
    for (const text of heads) {
      const cell = element("th", text);
      cell.scope = "col";
      head.append(cell);
    }
    const linear = spaceOf(this.gamut!.provenance.colour_space).linear(Float32Array.from(colours.flat()), SCREEN);
    const rows = colours.slice(0, MOST_TABLE_ROWS).map((_, i) => {
      const row = element("tr");
      const first = element("th", this.label(found, i));
      first.scope = "row";
      const spot = element("span", "", { className: "spot" });
      spot.style.backgroundColor = cssColour(linear.subarray(3 * i, 3 * i + 3));
      first.prepend(spot);
      const device = made?.device[i] ?? (inside[i] ? undefined : near.device?.[i]);
      const cells = [
        ...(made || near.device ? [device === undefined ? "" : deviceText(channels, device)] : []),
        ...(hasBlack ? [blackRange(made!, i) ?? ""] : []),
        ...(made ? [made.delta_e_2000[i]!.toFixed(2)] : []),
        inside[i] ? "itself" : rounded(near.point[i]!),
      ];
      row.append(
        first,
        element("td", position[i]!),
        element("td", inside[i] ? "0" : near.delta_e_2000[i]!.toFixed(2)),
        ...cells.map((text) => element("td", text)),
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
    const { found, near, made } = this.answer;
    const { colours, position } = found;
    const quoted = (text: string) => (/[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
    const channels = made || near.device ? this.gamut!.channels : [];
    const names = ["c1", "c2", "c3"];
    const head = ["name", ...names, "position", "inside", "ΔE00", ...names.map((name) => `nearest ${name}`), ...channels.map(quoted)];
    if (made) head.push("recipe ΔE00");
    if (made?.black_least) head.push("least black", "most black");
    const rows = colours.map((point, i) => {
      const inside = found.inside[i]!;
      const device = made?.device[i] ?? (inside ? undefined : near.device?.[i]) ?? channels.map(() => "");
      const difference = inside ? 0 : near.delta_e_2000[i]!;
      const row = [quoted(this.label(found, i)), ...point, position[i], inside, difference, ...(inside ? point : near.point[i]!), ...device];
      if (made) row.push(made.delta_e_2000[i]!);
      if (made?.black_least) row.push(made.black_least[i] ?? "", made.black_most![i] ?? "");
      return row;
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
    byId("colours-recipes").textContent = "";
    byId("colours-problem").hidden = true;
    byId("colours-problem").replaceChildren();
    byId("colours-table").replaceChildren();
    byId("colours-table").hidden = true;
    byId("colours-note").textContent = "";
    byId<HTMLButtonElement>("colours-csv").disabled = true;
    this.page.view.draw();
  }
}

function rounded(point: number[]): string {
  return point.map((value) => Number(value.toFixed(2)).toString().replace("-", "−")).join(" ");
}
