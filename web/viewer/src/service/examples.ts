// Gamuts that come with the page as files: they are shown without the service, which gets them only
// when it is asked a question about them.
import { embedded } from "../page/embedded.js";
import { type Gamut, type Progress, build, describe, provide } from "./api.js";

export interface Example {
  /** As in the address: the slug of a reference, or a name of its own. */
  key: string;
  name: string;
  /** A sentence about it, and where it comes from. */
  note: string;
  /** Names of files beside the list: the description, and the begin of the history. */
  description: string;
  history: string;
  /** The file that the service builds the gamut from; null for references. */
  source: string | null;
}

const folder = new URL("examples/", import.meta.url);
let list: Promise<Example[]> | null = null;

/** All examples; none if the service has no such files. */
export function examples(): Promise<Example[]> {
  if (embedded !== null) return Promise.resolve([]);
  list ??= loaded("index.json")
    .then((response) => response.json() as Promise<Example[]>)
    .catch(() => []);
  return list;
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
  const gamut = (await (await loaded(example.description)).json()) as Gamut;
  provide(gamut.id, async () => {
    const { report, end } = progress();
    const { signal } = new AbortController();
    try {
      if (example.source === null) return (await describe(example.key, report, signal)).id;
      return await build((await exampleFile(example))!, {}, report, signal);
    } finally {
      end();
    }
  });
  return gamut;
}

export function historyOf(example: Example): string {
  return new URL(example.history, folder).href;
}

/** The file that an example is built from. */
export async function exampleFile({ source }: Example): Promise<File | null> {
  return source === null ? null : new File([await (await loaded(source)).blob()], source);
}
