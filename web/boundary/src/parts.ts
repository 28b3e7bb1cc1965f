// Download of a history in growing parts: the first suffices for a picture.
import { HistoryError } from "./errors.js";

/** Bytes of the first part: about 2,000 triangles. */
const FIRST_PART = 48 * 1024;
const GROWTH = 4;
const LARGEST_PART = 1 << 20;

export interface Loading {
  /** Bytes of the first request. */
  first?: number;
  signal?: AbortSignal;
  fetch?: typeof fetch;
  headers?: Record<string, string>;
}

/** Bytes of the file that follow those of the parts before. */
export interface Part {
  bytes: Uint8Array;
  /** Bytes of the whole file. */
  total: number;
}

/** A request for a part was refused; `response` is the answer. */
export class PartError extends Error {
  override name = "PartError";

  constructor(readonly response: Response) {
    super(`the history was answered with status ${response.status}`);
  }
}

/** Iterate over the file at an address by `Range` requests of growing size. */
export async function* parts(address: string, loading: Loading = {}): AsyncGenerator<Part> {
  const request = loading.fetch ?? fetch;
  let begin = 0;
  let total = Infinity;
  let size = loading.first ?? FIRST_PART;
  let tag: string | null = null;
  while (begin < total) {
    const response = await request(address, {
      headers: {
        ...loading.headers,
        Range: `bytes=${begin}-${begin + size - 1}`,
        ...(tag === null ? {} : { "If-Range": tag }),
      },
      signal: loading.signal ?? null,
    });
    if (!response.ok) throw new PartError(response);
    if (response.status === 200) {
      if (begin > 0) throw new HistoryError("the file changed while it was read");
      yield* wholeFile(response);
      return;
    }
    tag = response.headers.get("etag");
    const range = /^bytes (\d+)-(\d+)\/(\d+)$/.exec(response.headers.get("content-range") ?? "");
    const bytes = new Uint8Array(await response.arrayBuffer());
    if (range === null || Number(range[1]) !== begin || bytes.length === 0) {
      throw new HistoryError("the server sent another part than the requested one");
    }
    total = Number(range[3]);
    begin += bytes.length;
    yield { bytes, total };
    size = Math.min(GROWTH * size, LARGEST_PART);
  }
}

/** A server that ignores `Range` sends the file, which is used while it arrives. */
async function* wholeFile(response: Response): AsyncGenerator<Part> {
  const total = Number(response.headers.get("content-length") ?? 0);
  const reader = response.body!.getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    yield { bytes: value, total };
  }
}
