// The state of the page in its address, behind the number sign: the server never sees it.
import { embedded } from "./embedded.js";

/** A part of the page that the address restores. */
export interface AddressPart {
  /** Take what an address says. It is called before gamuts are shown. */
  read(given: URLSearchParams): void;
  /** What restores the present state; null leaves a name out. */
  write(): [name: string, value: string | null][];
}

const PAUSE = 250;

export class AddressBook {
  private readonly parts: AddressPart[] = [];
  private saving = 0;
  /** Whether the state is left out of the address, as long as nobody has chosen anything. */
  isPaused = false;

  add(part: AddressPart): void {
    this.parts.push(part);
  }

  /** Give all parts what the address says. */
  read(): URLSearchParams {
    const given = new URLSearchParams(location.hash.slice(1) || embedded?.state?.address);
    for (const part of this.parts) part.read(given);
    return given;
  }

  /** The state as text, as it stands behind the number sign. */
  get text(): string {
    return this.parts
      .flatMap((part) => part.write())
      .filter((entry): entry is [string, string] => entry[1] !== null)
      .map(([name, value]) => `${name}=${encodeURIComponent(value).replaceAll("%2C", ",")}`)
      .join("&");
  }

  /** Write the state a moment later, once for many changes. */
  save(): void {
    if (this.saving !== 0) return;
    this.saving = setTimeout(() => {
      this.saving = 0;
      this.saveNow();
    }, PAUSE);
  }

  saveNow(): void {
    // A page in the `srcdoc` of a frame, as in a notebook, has no address of its own.
    if (this.isPaused || location.protocol === "about:") return;
    history.replaceState(null, "", `#${this.text}`);
  }
}
