// Requests to the service: documents, problems, uploads, and the progress of builds.
import type { SpaceDescription } from "../colours/spaces.js";

/** An answer that the service describes as a problem (RFC 9457). */
export interface Problem {
  title: string;
  detail: string;
  code: string;
  status: number;
  where: Record<string, unknown> | null;
  remedy: string;
}

export class ProblemError extends Error {
  override name = "ProblemError";

  constructor(readonly problem: Problem) {
    super(problem.detail);
  }
}

/** Description of a gamut, as far as the viewer uses it. */
export interface Gamut {
  id: string;
  name: string;
  volume: number;
  /** By intent, or `own` for colours without intents; missing in gamuts of older services. */
  volumes?: Partial<Record<"relative" | "absolute" | "own", { volume: number; times_srgb: number }>>;
  area: number;
  counts: { triangles: number; vertices: number };
  channels: string[];
  options: { space: string; boundary: string; adaptation?: string | null; source?: string };
  /** Convex polygon in CIE 1931 xy, before any adaptation; null or missing without chromaticities. */
  chromaticity?: { basis: "primaries" | "colours"; corners: [number, number][] } | null;
  centre: [number, number, number];
  bounds: [number[], number[]];
  /** The error curve: levels from coarse to fine, with a bound of their distance in both directions. */
  levels: { triangles: number; distance_bound: number }[];
  provenance: {
    /** Slug of a reference. */
    reference?: string;
    warnings?: unknown[];
    /** Numbers of measured patches. */
    patches?: object;
    axes?: string;
    intent?: string;
    ink_limits?: { total: number | null; black: number | null };
    medium?: string;
    device_class?: string;
    /** X, Y, Z of the medium's white; its L*, a*, b* for D50. */
    white?: number[] | null;
    white_lab?: number[] | null;
    white_luminance?: number;
    illuminant?: string;
    observer?: string;
    colour_space?: SpaceDescription;
  };
}

export interface Entry {
  /** Id or slug. */
  key: string;
  name: string;
  detail: string;
}

interface Job {
  id: string;
  state: string;
  stage: string | null;
  fraction: number;
  problem: Problem | null;
}

export type Progress = (stage: string, fraction: number, job: string) => void;

const root = document.documentElement.dataset["root"] ?? "";
let key = "";

/** Send an API key with all requests. It is kept in memory only. */
export function useKey(text: string): void {
  key = text;
}

export function hasKey(): boolean {
  return key !== "";
}

export function authorization(): Record<string, string> {
  return key === "" ? {} : { "X-API-Key": key };
}

export function address(path: string): string {
  return new URL(root + path, location.href).href;
}

/** How the service gets gamuts that the page shows from files, by id; each gives the id of the service. */
const provided = new Map<string, () => Promise<string>>();

/** Tell how the service gets a gamut when it is asked about it for the first time. */
export function provide(id: string, make: () => Promise<string>): void {
  let made: Promise<string> | null = null;
  provided.set(id, () => {
    made ??= make().catch((error: unknown) => {
      made = null;
      throw error;
    });
    return made;
  });
}

/** A path of the service, once the service has the gamuts of the path. */
async function answerable(path: string): Promise<string> {
  if (path.startsWith("/v1/jobs/")) return path;
  for (const id of path.match(/\b[0-9a-f]{64}\b/g) ?? []) {
    const known = await provided.get(id)?.();
    if (known !== undefined) path = path.replace(id, known);
  }
  return path;
}

/** Fetch, or throw the problem that the service describes. */
export async function request(asked: string, init: RequestInit = {}): Promise<Response> {
  let response: Response;
  const path = provided.size === 0 ? asked : await answerable(asked);
  const headers = { Accept: "application/json", ...authorization(), ...init.headers };
  try {
    response = await fetch(address(path), { ...init, headers });
  } catch (error) {
    if (init.signal?.aborted) throw error;
    throw new ProblemError(plainProblem("The service does not answer.", 0));
  }
  if (!response.ok) throw await problemOf(response);
  return response;
}

export async function problemOf(response: Response): Promise<ProblemError> {
  const type = response.headers.get("content-type") ?? "";
  if (!type.startsWith("application/problem+json")) {
    return new ProblemError(plainProblem(`The answer has status ${response.status}.`, response.status));
  }
  return new ProblemError((await response.json()) as Problem);
}

function plainProblem(detail: string, status: number): Problem {
  return { title: "No answer", detail, code: "", status, where: null, remedy: "Try again." };
}

/** References that are asked for most, in the order of the list. */
const COMMON = ["srgb", "display-p3", "bt2020", "adobe-rgb-1998"];

/** The common references, stored gamuts, other references, and the spaces of film production. */
function usualOrder(stored: Entry[], known: Entry[]): Entry[] {
  const common = COMMON.flatMap((slug) => known.find(({ key: id }) => id === slug) ?? []);
  const others = known.filter((entry) => !common.includes(entry));
  const isFilm = ({ key: slug }: Entry) => slug.startsWith("aces");
  return [...common, ...stored, ...others.filter((entry) => !isFilm(entry)), ...others.filter(isFilm)];
}

/**
 * Stored gamuts and references that a text may mean in one list, the most likely first; all without a
 * text. The service finds aliases and similar names; exact names and beginnings of names come first.
 */
export async function choices(text: string, signal: AbortSignal): Promise<Entry[]> {
  const named = text === "" ? {} : { name: text };
  const query = new URLSearchParams({ limit: "50", ...named, match: "similar" });
  const [stored, known, entries] = await Promise.all([
    request(`/v1/gamuts?${query}`, { signal }).then((response) => response.json()),
    references(),
    text === "" ? references() : searched(text, signal),
  ]);
  const slugs = new Set(known.map((entry) => entry.name));
  const gamuts = (stored.gamuts as Gamut[])
    .filter((gamut) => !slugs.has(gamut.name))
    .map((gamut) => ({ key: gamut.id, name: gamut.name, detail: `stored · ${gamut.options.space}` }));
  if (text === "") return usualOrder(gamuts, known);
  const rank = ({ key: id, name }: Entry) => {
    const names = [id, name].map(folded);
    if (names.includes(folded(text))) return 0;
    return names.some((each) => each.startsWith(folded(text))) ? 1 : 3;
  };
  // What the service puts first, or before a better rank, is an alias: Rec2020 is ITU-R BT.2020.
  const ranks = entries.map(rank);
  const meant = (place: number) => Math.min(place === 0 ? 2 : 3, ...ranks.slice(place).map((each) => Math.max(1, each)), ranks[place]!);
  const all = [
    ...entries.map((entry, place): [Entry, number] => [entry, meant(place)]),
    ...gamuts.map((entry): [Entry, number] => [entry, rank(entry)]),
  ];
  return all.sort((one, other) => one[1] - other[1]).map(([entry]) => entry);
}

function folded(name: string): string {
  return name.toLowerCase().replaceAll(/[^\p{L}\p{N}]/gu, "");
}

async function searched(text: string, signal: AbortSignal): Promise<Entry[]> {
  const response = await request(`/v1/references?${new URLSearchParams({ name: text })}`, { signal });
  return entriesOf((await response.json()) as References);
}

interface References {
  references: { slug: string; name: string }[];
}

function entriesOf({ references: all }: References): Entry[] {
  return all.map(({ slug, name }) => ({ key: slug, name, detail: `reference · ${slug}` }));
}

let knownReferences: Promise<Entry[]> | null = null;

function references(): Promise<Entry[]> {
  knownReferences ??= request("/v1/references")
    .then((response) => response.json())
    .then(entriesOf)
    .catch((error: unknown) => {
      knownReferences = null;
      throw error;
    });
  return knownReferences;
}

/**
 * Describe a gamut; a reference that is not built yet is waited for. Options of its build follow the
 * slug of a reference as a query, and `options` come before them.
 */
export async function describe(
  name: string,
  progress: Progress,
  signal: AbortSignal,
  options: Record<string, string> = {},
): Promise<Gamut> {
  const [slug, query = ""] = name.split("?");
  const stated = new URLSearchParams(query);
  for (const [option, value] of Object.entries(options)) stated.set(option, value);
  const path = `/v1/gamuts/${encodeURIComponent(slug!)}?${stated}`;
  const get = () => request(path, { signal, headers: { Prefer: "respond-async" } });
  let response = await get();
  if (response.status === 202) {
    await followed(((await response.json()) as Job).id, progress, signal);
    response = await get();
  }
  return (await response.json()) as Gamut;
}

/** Send a file and options, and wait for the gamut. */
export async function build(file: File, options: object, progress: Progress, signal: AbortSignal): Promise<string> {
  // A file that changed after it was chosen, and a folder, cannot be read.
  await file.slice(0, 1).arrayBuffer().catch(() => {
    throw new Error(`${file.name} cannot be read, or it changed. Choose it again.`);
  });
  const body = new FormData();
  body.append("file", file);
  body.append("options", JSON.stringify(options));
  progress("upload", 0, "");
  const response = await sent("/v1/gamuts", body, (fraction) => progress("upload", fraction, ""), signal);
  const document = (await response.json()) as Gamut | Job;
  if (response.status === 202) await followed(document.id, progress, signal);
  return document.id;
}

/** Send a body, with its progress: `fetch` does not tell how much of a body is sent. */
function sent(path: string, body: FormData, progress: (fraction: number) => void, signal: AbortSignal): Promise<Response> {
  signal.throwIfAborted(); // the file may have been read meanwhile
  const call = new XMLHttpRequest();
  call.open("POST", address(path));
  const headers = { Accept: "application/json", Prefer: "respond-async", ...authorization() };
  for (const [name, value] of Object.entries(headers)) call.setRequestHeader(name, value);
  call.upload.onprogress = ({ loaded, total }) => progress(loaded / total);
  return new Promise((resolve, reject) => {
    signal.addEventListener("abort", () => call.abort());
    call.onabort = () => reject(signal.reason);
    call.onerror = () => reject(new ProblemError(plainProblem("The service does not answer.", 0)));
    call.onload = () => {
      const type = call.getResponseHeader("content-type") ?? "";
      const response = new Response(call.responseText, { status: call.status, headers: { "content-type": type } });
      if (response.ok) resolve(response);
      else void problemOf(response).then(reject);
    };
    call.send(body);
  });
}

/**
 * What keeps the service from working, in plain words; null if it is ready or does not answer. Answers
 * need more kernels than builds: these are compiled after the service is ready.
 */
export async function preparation(forAnswers = false): Promise<string | null> {
  try {
    const { state } = (await (await request("/")).json()) as { state: Readiness };
    const kernels = state.probes["kernels"];
    const count = /compiling (\d+ of \d+ kernels)/.exec(kernels?.detail ?? "")?.[1] ?? "kernels";
    if (forAnswers && state.ready && kernels?.detail?.includes("optional: compiling")) {
      return `Preparing answers: ${count} compiled, only once`;
    }
    if (state.ready) return null;
    if (kernels?.status === "failed") return `Preparing the service: ${count} compiled, only once`;
    if (state.workers_warm < state.workers) return "Preparing the service: starting, a few seconds";
  } catch {
    // The request that waits tells what is wrong.
  }
  return null;
}

interface Readiness {
  ready: boolean;
  probes: Record<string, { status: string; detail?: string }>;
  workers: number;
  workers_warm: number;
}

export async function cancelJob(id: string): Promise<void> {
  await request(`/v1/jobs/${id}`, { method: "DELETE" });
}

/** Follow the events of a job until it has succeeded. A lost connection is opened again. */
async function followed(id: string, progress: Progress, signal: AbortSignal): Promise<void> {
  let last = "";
  for (;;) {
    const headers = { Accept: "text/event-stream", ...(last === "" ? {} : { "Last-Event-ID": last }) };
    const response = await request(`/v1/jobs/${id}/events`, { signal, headers });
    for await (const event of events(response)) {
      last = event.id;
      const job = JSON.parse(event.data) as Job;
      if (job.problem !== null) throw new ProblemError(job.problem);
      if (job.state === "succeeded") return;
      progress(job.stage || "waiting", job.fraction, id);
    }
    if (response.status === 204) return;
    await new Promise((resolve) => setTimeout(resolve, 500));
  }
}

/** Events of a stream (WHATWG HTML, section 9.2.6), as far as this service sends them. */
async function* events(response: Response): AsyncGenerator<{ id: string; data: string }> {
  if (response.body === null) return;
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  let text = "";
  for (;;) {
    const { done, value } = await reader.read().catch(() => ({ done: true, value: undefined }));
    if (done) return;
    text += value;
    const blocks = text.split("\n\n");
    text = blocks.pop()!;
    for (const block of blocks) {
      const field = (name: string) => new RegExp(`^${name}: (.*)$`, "m").exec(block)?.[1];
      const data = field("data");
      if (data !== undefined) yield { id: field("id") ?? "", data };
    }
  }
}
