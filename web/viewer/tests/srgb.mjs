// sRGB by other formulas than the page's: an independent figure for tests.

/** sRGB, 0 to 255, of a CIELAB colour: D50 → D65 by the matrix of CSS Color 4. */
export function srgb([l, a, b]) {
  const f = [(l + 16) / 116 + a / 500, (l + 16) / 116, (l + 16) / 116 - b / 200];
  const white = [0.3457 / 0.3585, 1, (1 - 0.3457 - 0.3585) / 0.3585];
  const xyz = f.map((value, i) => white[i] * (value ** 3 > 216 / 24389 ? value ** 3 : (116 * value - 16) / (24389 / 27)));
  const times = (m, v) => m.map((row) => row.reduce((sum, value, i) => sum + value * v[i], 0));
  const d65 = times(
    [[0.955473421, -0.023098451, 0.063259306], [-0.028369709, 1.009995398, 0.021041441], [0.012314015, -0.020507649, 1.330365926]],
    xyz,
  );
  const linear = times(
    [[3.2409699, -1.5373832, -0.4986108], [-0.9692436, 1.8759675, 0.0415551], [0.0556301, -0.203977, 1.0569715]],
    d65,
  );
  return linear.map((value) => 255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055));
}

/** Colours of a grid in CIELAB that sRGB has, by their distance and the lightnesses. */
export function srgbGrid(step, lightnesses) {
  const points = [];
  for (const l of lightnesses) {
    for (let a = -100; a <= 110; a += step) {
      for (let b = -120; b <= 110; b += step) {
        if (srgb([l, a, b]).every((value) => value >= 0 && value <= 255)) points.push([l, a, b]);
      }
    }
  }
  return points;
}
