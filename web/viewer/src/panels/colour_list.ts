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
import { gamutSpace } from "../colours/spaces.js";
import { blackChannel, blackRange, DEVICE_UNIT, devicePercent, deviceText } from "../colours/device_values.js";
import { byId, element, openPart, problemElements, save, warningTexts } from "../page/elements.js";
import { embedded } from "../page/embedded.js";
import { Latest } from "../page/latest.js";
import { type Page, axisNames } from "../page/page.js";
import { reveal } from "../page/parts.js";
import { orientation } from "../scene/layer.js";
import { type Gamut, ProblemError } from "../service/api.js";
import {
  type CheckedTable,
  type Nearest,
  type Position,
  type Recipes,
  type TableReading,
  type LineRefusal,
  checkLines,
  edgeText,
  mayHaveRecipes,
  nearest,
  recipes,
} from "../service/queries.js";
import { ColourLinks } from "./colour_links.js";
import { type Column, SortedTable } from "./sorted_table.js";

/** Fields of the page that say how a list is read. */
const STATED = ["space", "scale", "edge", "columns"] as const;
/** Longest list that the address keeps: addresses of 2,000 characters pass everywhere. */
const LONGEST_IN_ADDRESS = 1500;

interface Answer {
  checks: CheckedTable;
  near: Nearest;
  /** Recipes of the colours, and of the nearest ones of those outside; null before they are there. */
  made: Recipes | null;
  /** Lines without an answer. */
  refused: LineRefusal[];
}

/** The answer that a saved page has, with the id of its gamut. */
interface SavedList extends Answer {
  gamut: string;
}

export class ColourList {
  /** Called when other colours are there, or none any more. */
  onChange: () => void = () => {};
  private group: Group | null = null;
  /** The check, and after it the recipes of its answer. */
  private readonly asking = new Latest();
  private gamut: Gamut | null = null;
  private answer: Answer | null = null;
  /** Whether the list of the address is still to be checked. */
  private wanted = false;
  /** The opened file. Typing in the list puts it away. */
  private file: File | null = null;
  private readonly table = new SortedTable(byId("colours-table"));
  private readonly links: ColourLinks;
  private readonly text = byId<HTMLTextAreaElement>("colours");
  private readonly reading = byId<HTMLDetailsElement>("colours-reading");

  constructor(private readonly page: Page) {
    this.links = new ColourLinks(page, this.table);
    page.on(["slots"], () => this.show(page.shown[0]?.gamut ?? null));
    page.on(["theme"], () => {
      if (this.answer === null) return;
      this.erase();
      this.draw(this.answer);
    });
    page.kept.set("list", () => this.answer && { ...this.answer, gamut: this.gamut!.id });
    page.address.add({
      read: (given) => {
        this.text.value = given.get("colours") ?? this.text.value;
        for (const name of STATED) {
          const value = given.get(`colours-${name}`);
          if (value !== null) byId<HTMLInputElement | HTMLSelectElement>(`colours-${name}`).value = value;
        }
        this.summarise();
        this.wanted = this.text.value.trim() !== "";
        if (this.wanted) openPart("colours-part");
      },
      write: () => {
        const text = this.text.value.trim();
        if (text === "" || text.length > LONGEST_IN_ADDRESS) return [];
        const { space, columns, table_scale: scale, edge_width: edge } = this.stated();
        const values = { space, scale, edge, columns };
        return [["colours", text], ...STATED.map((name): [string, string | null] => [`colours-${name}`, values[name] || null])];
      },
    });
    byId("check").addEventListener("click", () => {
      page.complain(null);
      void this.check();
    });
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
      input.value = ""; // the same file can be opened again
      this.take(file);
    });
    byId("colours-open").addEventListener("click", () => byId("colours-file").click());
    this.text.addEventListener("input", () => {
      this.file = null;
    });
    this.reading.addEventListener("change", () => {
      this.summarise();
      if (this.list !== null) void this.check();
    });
    this.summarise();
  }

  /** The gamut that lists are checked against. */
  get against(): string | null {
    return this.gamut?.name ?? null;
  }

  /** Check a file, as if it were opened. */
  take(file: File): void {
    reveal("colours-part");
    this.file = file;
    this.text.value = "";
    this.page.complain(null);
    void this.check();
  }

  /** Ask about another gamut. */
  private show(gamut: Gamut | null): void {
    if (gamut?.id === this.gamut?.id) return;
    this.gamut = gamut;
    if (embedded !== null) {
      this.restore(embedded.state?.["list"] as SavedList | null | undefined);
      return;
    }
    byId<HTMLButtonElement>("check").disabled = gamut === null;
    if (this.answer !== null || this.asking.isAsking || this.wanted) void this.check();
  }

  /** Show the answer of a saved page, if it is about this gamut. */
  private restore(saved: SavedList | null | undefined): void {
    this.clear();
    const isThis = saved != null && saved.gamut === this.gamut?.id;
    byId("colours-part").hidden = !isThis;
    if (!isThis) return;
    openPart("colours-part");
    this.answer = saved;
    this.draw(saved);
    this.tabulate(saved);
  }

  /** The list as it is sent: the file, or what is in the field. */
  private get list(): Blob | null {
    return this.file ?? (this.text.value.trim() === "" ? null : new Blob([this.text.value]));
  }

  /** The list if it is answered, and so can be read. */
  get colours(): Blob | null {
    return this.answer === null ? null : this.list;
  }

  stated(): TableReading {
    const value = (name: string) => byId<HTMLInputElement | HTMLSelectElement>(`colours-${name}`).value.trim();
    return { space: value("space"), columns: value("columns"), table_scale: value("scale"), edge_width: value("edge") };
  }

  private summarise(): void {
    const { space, columns, table_scale: scale, edge_width: edge } = this.stated();
    const parts = [space, scale && `white at ${scale}`, columns && `columns ${columns}`, edge && `edge ${edge}`].filter((part) => part !== "");
    byId("colours-reading-summary").textContent = parts.join(", ") || "the table says";
  }

  private async check(): Promise<void> {
    this.clear();
    this.page.address.save();
    const { gamut, list: table } = this;
    // Without a gamut the list waits for the next one.
    this.wanted = gamut === null && table !== null;
    if (gamut === null || table === null) return;
    for (const name of ["scale", "edge"]) {
      const field = byId<HTMLInputElement>(`colours-${name}`);
      if (field.checkValidity()) continue;
      this.reading.open = true;
      field.reportValidity();
      return;
    }
    const reading = this.stated();
    byId("colours-note").textContent = "Checking …";
    await this.asking.ask(
      async (signal) => {
        const { checks, refused } = await checkLines(gamut, table, reading, signal);
        return { checks, near: await nearest(gamut, checks.colours, signal), made: null, refused };
      },
      (answer) => {
        this.answer = answer;
        this.draw(answer);
        this.tabulate(answer);
        this.onChange();
        void this.addRecipes(gamut, answer);
      },
      (error) => this.refuse(error),
    );
  }

  /** Ask for recipes, and show them. Without them, the table stays as it is. */
  private async addRecipes(gamut: Gamut, answer: Answer): Promise<void> {
    if (!mayHaveRecipes(gamut)) return;
    const { checks, near } = answer;
    const note = byId("colours-recipes");
    note.textContent = "The recipes of the colours are on their way.";
    const targets = checks.colours.map((point, i) => (checks.inside[i] ? point : near.point[i]!));
    await this.asking.ask(
      (signal) => recipes(gamut, targets, signal),
      (made) => {
        note.textContent = "";
        answer.made = made;
        this.tabulate(answer);
      },
      (error) => {
        const [, ...words] = problemElements(error);
        note.textContent = ["There are no recipes.", ...words.map((word) => word.textContent)].join(" ");
      },
    );
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
    byId("colours-note").textContent = "";
    const [, ...words] = problemElements(error);
    const title = this.file === null ? "The list is refused" : `${this.file.name} is refused`;
    byId("colours-problem").replaceChildren(element("strong", title), ...words);
    byId("colours-problem").hidden = false;
    this.reading.open = true; // how it is to be read can be stated there
  }

  private draw({ checks, near }: Answer): void {
    const { colours, inside, position } = checks;
    const points = colours.flat();
    const linear = gamutSpace(this.gamut!).linear(Float32Array.from(points), SCREEN);
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
    const placement = orientation(axisNames(this.gamut!));
    this.group.applyMatrix4(placement);
    this.links.show({ colours, placement, label: (row) => `${this.label(checks, row)}: ${position[row]!}` });
    this.page.view.scene.add(this.group);
    this.page.view.draw();
  }

  /** The name of a colour, or its coordinates where its row has none. */
  private label({ labels, lines, colours }: CheckedTable, row: number): string {
    return labels[row] === `line ${lines[row]}` ? rounded(colours[row]!) : labels[row]!;
  }

  private tabulate(answer: Answer): void {
    const { checks, near, made } = answer;
    const { colours, position } = checks;
    const count = (where: Position) => `${position.filter((each) => each === where).length} ${where}`;
    const sentences = [
      this.file === null ? "" : `${this.file.name}: `,
      `${colours.length} ${colours.length === 1 ? "colour" : "colours"}: ${count("inside")}, ${count("edge")}, ${count("outside")} (${edgeText(checks)}).`,
      ` ${checks.reading}`,
    ];
    byId("colours-note").textContent = sentences.join("");
    this.tell(answer.refused ?? []);
    byId("colours-warnings").replaceChildren(
      ...warningTexts([checks, near, made].flatMap((each) => each?.warnings ?? [])).map((warning) =>
        element("p", warning, { className: "warning" }),
      ),
    );
    this.table.show(`Colours in ${this.gamut!.name}`, this.columns(answer), colours.length);
    byId<HTMLButtonElement>("colours-csv").disabled = false;
  }

  /** Say which lines have no answer, and why. */
  private tell(refused: LineRefusal[]): void {
    const box = byId("colours-refused");
    box.hidden = refused.length === 0;
    const count = refused.length === 1 ? "One line is refused" : `${refused.length} lines are refused`;
    const remedies = new Set(refused.map(({ remedy }) => remedy));
    box.replaceChildren(
      element("strong", count),
      ...refused.map(({ line, detail }) => element("p", `Line ${line}: ${detail}`)),
      ...[...remedies].map((remedy) => element("p", remedy)),
    );
  }

  private columns({ checks, near, made }: Answer): Column[] {
    const { colours, inside, position } = checks;
    const { channels } = this.gamut!;
    const linear = gamutSpace(this.gamut!).linear(Float32Array.from(colours.flat()), SCREEN);
    const device = (row: number) => made?.device[row] ?? (inside[row] ? undefined : near.device?.[row]);
    const far = (row: number) => (inside[row] ? 0 : near.delta_e_2000[row]!);
    const named = (row: number) => {
      const cell = element("span", this.label(checks, row), { title: this.label(checks, row) });
      const spot = element("span", "", { className: "spot" });
      spot.style.backgroundColor = cssColour(linear.subarray(3 * row, 3 * row + 3));
      cell.prepend(spot);
      return cell;
    };
    const recipe = made !== null || near.device !== undefined;
    const text = (row: number) => (device(row) === undefined ? "" : deviceText(channels, device(row)!));
    const [least, most] = [made?.black_least, made?.black_most];
    const distance = (row: number) => checks.distance[row]!;
    return [
      { title: "Colour", value: (row) => this.label(checks, row), cell: named },
      {
        title: "Where",
        value: distance, // from the deepest inside to the farthest outside
        cell: (row) => element("span", position[row]!, { className: `where-${position[row]!}` }),
      },
      { title: "ΔE00", value: far, cell: (row) => far(row).toFixed(2) },
      ...(recipe
        ? [{ title: `${made ? "Recipe" : channels.join(" ")}, ${DEVICE_UNIT}`, value: text }]
        : []),
      ...(least && most
        ? [{ title: `Possible ${blackChannel(channels)}, %`, value: (row: number) => most[row] ?? -1, cell: (row: number) => blackRange(made!, row) ?? "" }]
        : []),
      ...(made
        ? [{ title: "Recipe ΔE00", value: (row: number) => made.delta_e_2000[row]!, cell: (row: number) => made.delta_e_2000[row]!.toFixed(2) }]
        : []),
      { title: "Euclidean distance", value: distance, cell: (row) => distance(row).toFixed(2).replace("-", "−") },
      { title: "Nearest", value: (row) => (inside[row] ? "itself" : rounded(near.point[row]!)) },
    ];
  }

  private download(): void {
    if (this.answer === null) return;
    const { checks, near, made } = this.answer;
    const { colours, position } = checks;
    const quoted = (text: string) => (/[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
    const channels = made || near.device ? this.gamut!.channels : [];
    const names = ["c1", "c2", "c3"];
    const head = ["name", ...names, "position", "inside", "Euclidean distance", "ΔE00", ...names.map((name) => `nearest ${name}`), ...channels.map((channel) => quoted(`${channel} ${DEVICE_UNIT}`))];
    if (made) head.push("recipe ΔE00");
    if (made?.black_least) head.push(`least black ${DEVICE_UNIT}`, `most black ${DEVICE_UNIT}`);
    const rows = colours.map((point, i) => {
      const inside = checks.inside[i]!;
      const amounts = made?.device[i] ?? (inside ? undefined : near.device?.[i]);
      const device = amounts === undefined ? channels.map(() => "") : devicePercent(amounts);
      const difference = inside ? 0 : near.delta_e_2000[i]!;
      const row = [quoted(this.label(checks, i)), ...point, position[i], inside, checks.distance[i]!, difference, ...(inside ? point : near.point[i]!), ...device];
      if (made) row.push(made.delta_e_2000[i]!);
      if (made?.black_least) row.push(...[made.black_least[i], made.black_most![i]].map((end) => (end == null ? "" : devicePercent([end])[0]!)));
      return row;
    });
    const blob = new Blob([[head, ...rows].map((row) => row.join(",")).join("\n"), "\n"], { type: "text/csv" });
    save(blob, `colours in ${this.gamut!.name}.csv`);
  }

  /** Take the points out of the view. */
  private erase(): void {
    this.group?.traverse((part) => {
      if (!(part instanceof Points) && !(part instanceof LineSegments)) return;
      part.geometry.dispose();
      (part.material as LineBasicMaterial | PointsMaterial).dispose();
    });
    this.group?.removeFromParent();
    this.group = null;
    this.page.view.draw();
  }

  /** Show no answer, and take none that is on its way. */
  private clear(): void {
    this.asking.end();
    this.erase();
    this.answer = null;
    this.links.clear();
    this.tell([]);
    byId("colours-warnings").replaceChildren();
    byId("colours-recipes").textContent = "";
    byId("colours-problem").hidden = true;
    byId("colours-problem").replaceChildren();
    this.table.clear();
    byId("colours-note").textContent = "";
    byId<HTMLButtonElement>("colours-csv").disabled = true;
    this.onChange();
  }
}

function rounded(point: number[]): string {
  return point.map((value) => Number(value.toFixed(2)).toString().replace("-", "−")).join(" ");
}
