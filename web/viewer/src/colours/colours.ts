// Appearance of colours on an sRGB display, as `gamutcore.colours.spaces` computes it.

/** XYZ relative to ICC's D50 → linear sRGB (Bradford, IEC 61966-2-1). */
const D50_TO_LINEAR_SRGB = [
  [3.134186364, -1.617208959, -0.490694064],
  [-0.978748504, 1.916130097, 0.033433399],
  [0.071963928, -0.228993873, 1.405753733],
] as const;

/** ICC.1:2022, 7.2.16. */
const WHITE_X = 0.9642;
const WHITE_Z = 0.8249;

function inverseF(value: number): number {
  return value > 6 / 29 ? value ** 3 : ((value - 4 / 29) * 108) / 841;
}

/** Linear sRGB of CIELAB colours, clipped; `lab` and the result have three numbers per colour. */
export function linearSrgb(lab: Float32Array): Float32Array {
  const result = new Float32Array(lab.length);
  for (let i = 0; i < lab.length; i += 3) {
    const middle = (lab[i]! + 16) / 116;
    const x = WHITE_X * inverseF(middle + lab[i + 1]! / 500);
    const y = inverseF(middle);
    const z = WHITE_Z * inverseF(middle - lab[i + 2]! / 200);
    for (let channel = 0; channel < 3; channel++) {
      const row = D50_TO_LINEAR_SRGB[channel]!;
      const value = row[0] * x + row[1] * y + row[2] * z;
      result[i + channel] = Math.min(Math.max(value, 0), 1);
    }
  }
  return result;
}

/** CSS colour of linear sRGB. */
export function cssColour(linear: ArrayLike<number>): string {
  const parts = Array.from(linear, (value) => {
    const encoded = value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055;
    return Math.round(255 * Math.min(Math.max(encoded, 0), 1));
  });
  return `rgb(${parts.join(" ")})`;
}

/** Chroma and hue in degrees of two opponent coordinates. */
export function polar(a: number, b: number): [number, number] {
  return [Math.hypot(a, b), ((Math.atan2(b, a) * 180) / Math.PI + 360) % 360];
}
