// Animated WebP from single pictures (RFC 9649, WebP Image Format, section 2).

interface Chunk {
  name: string;
  content: Uint8Array;
}

/** Flags of the chunk VP8X: an ICC profile, and an animation. */
const HAS_PROFILE = 0x20;
const HAS_ANIMATION = 0x02;
/** Flag of the chunk ANMF: a frame replaces what is below it. */
const NO_BLENDING = 0x02;
/** Chunks of a picture that a frame keeps: transparency, and the lossy or lossless picture. */
const OF_FRAMES = ["ALPH", "VP8 ", "VP8L"];

/** One file from WebP pictures of equal size, each shown for some milliseconds, again and again. */
export function animatedWebp(pictures: Uint8Array[], width: number, height: number, milliseconds: number): Blob {
  const frames = pictures.map(chunksOf);
  const profile = frames[0]!.find(({ name }) => name === "ICCP");
  const flags = HAS_ANIMATION | (profile === undefined ? 0 : HAS_PROFILE);
  const size = [...number(width - 1, 3), ...number(height - 1, 3)];
  const body = [
    ...bytesOf("VP8X", [Uint8Array.of(flags, 0, 0, 0, ...size)]),
    ...(profile === undefined ? [] : bytesOf("ICCP", [profile.content])),
    // Background and number of repetitions: none and without end.
    ...bytesOf("ANIM", [new Uint8Array(6)]),
    ...frames.flatMap((frame) => {
      const head = Uint8Array.of(...number(0, 6), ...size, ...number(milliseconds, 3), NO_BLENDING);
      const parts = frame.filter(({ name }) => OF_FRAMES.includes(name));
      return bytesOf("ANMF", [head, ...parts.flatMap(({ name, content }) => bytesOf(name, [content]))]);
    }),
  ];
  const bytes = bytesOf("RIFF", [ascii("WEBP"), ...body]);
  return new Blob(bytes as Uint8Array<ArrayBuffer>[], { type: "image/webp" });
}

function chunksOf(file: Uint8Array): Chunk[] {
  const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
  const chunks: Chunk[] = [];
  for (let at = 12; at + 8 <= file.length; ) {
    const size = view.getUint32(at + 4, true);
    const name = String.fromCharCode(...file.subarray(at, at + 4));
    chunks.push({ name, content: file.subarray(at + 8, at + 8 + size) });
    at += 8 + size + (size % 2);
  }
  return chunks;
}

/** A chunk: its name, its length, its content, and a byte that makes the length even. */
function bytesOf(name: string, content: Uint8Array[]): Uint8Array[] {
  const length = content.reduce((sum, { length: bytes }) => sum + bytes, 0);
  return [ascii(name), Uint8Array.from(number(length, 4)), ...content, new Uint8Array(length % 2)];
}

function ascii(text: string): Uint8Array {
  return Uint8Array.from(text, (character) => character.charCodeAt(0));
}

/** A number in bytes, the lowest first. */
function number(value: number, bytes: number): number[] {
  return Array.from({ length: bytes }, (_, i) => Math.floor(value / 256 ** i) % 256);
}
