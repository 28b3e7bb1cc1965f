// Gamuts that come with the page as files: they are shown without the service, which gets them only
// when it is asked a question about them.
import { type Coverage, embedded } from "../page/embedded.js";
import { type Gamut, type Progress, build, describe, provide } from "./api.js";

/** An entry of `index.json`. Its description and the begin of its history are files beside it. */
export interface Example {
  /** As in the address: the slug of a reference, or a name of its own. */
  key: string;
  name: string;
  /** A sentence about it. */
  text: string;
  /** The file that the service builds the gamut from; null for references. */
  file: string | null;
}

/** Figures of a comparison that come with the examples. `a` and `b` are ids of gamuts. */
interface StoredComparison extends Coverage {
  a: string;
  b: string;
}

interface Index {
  examples: Example[];
  comparisons?: StoredComparison[];
}

const folder = new URL("examples/", import.meta.url);
let index: Promise<Index> | null = null;

/** All examples; none if the service has no such files. */
export async function examples(): Promise<Example[]> {
  return (await loadIndex()).examples;
}

/** Coverage of two examples, or of the gamuts of a saved page, which needs no service. */
export async function storedCoverage(a: string, b: string): Promise<Coverage | undefined> {
  if (embedded !== null) {
    const [first, second] = embedded.gamuts;
    return (first?.gamut.id === a && second?.gamut.id === b && embedded.coverage) || undefined;
  }
  return (await loadIndex()).comparisons?.find((each) => each.a === a && each.b === b);
}

function loadIndex(): Promise<Index> {
  if (embedded !== null) return Promise.resolve({ examples: [] });
  index ??= loaded("index.json")
    .then(async (response) => (await response.json()) as Index)
    .catch(() => ({ examples: [] }));
  return index;
}

async function loaded(name: string): Promise<Response> {
  const response = await fetch(new URL(name, folder));
  if (!response.ok) throw new Error(`The file ${name} of the page is missing.`);
  return response;
}

/** The example of a key of the address. */
export async function findExample(key: string): Promise<Example | undefined> {
  return (await examples()).find((each) => each.key === key);
}

/** Its description. `progress` begins to tell how the service gets it, once it is asked about it. */
export async function describeExample(example: Example, progress: () => { report: Progress; end: () => void }): Promise<Gamut> {
  const gamut = (await (await loaded(`${example.key}.json`)).json()) as Gamut;
  provide(gamut.id, async () => {
    const work = progress();
    const { signal } = new AbortController();
    try {
      if (example.file === null) return (await describe(example.key, work.report, signal)).id;
      return await build((await exampleFile(example))!, {}, work.report, signal);
    } finally {
      work.end();
    }
  });
  return gamut;
}

let ids: Promise<Map<string, string>> | null = null;

/** Keys of the examples by the ids of their gamuts: a file of the reader may be one of them. */
export function exampleKeys(): Promise<Map<string, string>> {
  ids ??= examples().then(async (all) => {
    const entries = all.map(async ({ key }): Promise<[string, string]> => [((await (await loaded(`${key}.json`)).json()) as Gamut).id, key]);
    return new Map(await Promise.all(entries));
  });
  return ids;
}

export function historyOf(example: Example): string {
  return new URL(`${example.key}.gamut`, folder).href;
}

/** The file that an example is built from. */
export async function exampleFile({ file }: Example): Promise<File | null> {
  return file === null ? null : new File([await (await loaded(file)).blob()], file);
}
