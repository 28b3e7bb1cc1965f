// Colour spaces: coordinates → X, Y, Z → CIELAB, or linear RGB of a screen.
//
// The inverse formulas of `gamutcore.colours.formulas`, with the parameters that the description of
// a gamut states. Arrays have three numbers per colour. Matrices have nine numbers, row by row.

/** Everything that coordinates depend on, as in `provenance.colour_space` of a gamut. */
export interface SpaceDescription {
  name: string;
  axes: string[];
  /** X, Y, Z with Y = 1. */
  reference_white_xyz: number[];
  adaptation: string;
  reference_white?: string;
  /** Of the white in cd/m², for absolute spaces. */
  luminance?: number;
  /** L_A in cd/m² and Y_b in per cent of the white, for appearance models. */
  adapting_luminance?: number;
  background?: number;
  surround?: string;
}

export type Screen = "srgb" | "display-p3";

export interface Space {
  readonly name: string;
  readonly axes: readonly string[];
  /** The axis of lightness or luminance. */
  readonly lightness: number;
  /** X, Y, Z relative to ICC's D50, Y = 1 for the white. */
  toXyz(positions: Float32Array): Float32Array;
  /** CIELAB relative to ICC's D50. */
  toLab(positions: Float32Array): Float32Array;
  /** Linear RGB of a screen: clipped to 0 to 1, or as it is. */
  linear(positions: Float32Array, screen?: Screen, clipped?: boolean): Float32Array;
}

type Matrix = readonly number[];
/** Replaces coordinates by X, Y, Z relative to the white of the space. */
type Inverse = (colour: Float64Array) => void;

/** ICC.1:2022, 7.2.16. */
const ICC_D50 = [0.9642, 1, 0.8249] as const;
/** x 0.3127, y 0.3290 (ITU-R BT.709, BT.2100; IEC 61966-2-1). */
const D65 = [0.3127 / 0.329, 1, (1 - 0.3127 - 0.329) / 0.329] as const;

/** Chromaticities of red, green and blue: IEC 61966-2-1; SMPTE EG 432-1; ITU-R BT.2020. */
const PRIMARIES = {
  srgb: [0.64, 0.33, 0.3, 0.6, 0.15, 0.06],
  "display-p3": [0.68, 0.32, 0.265, 0.69, 0.15, 0.06],
  bt2020: [0.708, 0.292, 0.17, 0.797, 0.131, 0.046],
} as const;

/** X, Y, Z → responses like those of cones; sources as in `gamutcore.colours.colorimetry`. */
const ADAPTATIONS: Record<string, Matrix> = {
  Bradford: [0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296],
  CAT02: [0.7328, 0.4296, -0.1624, -0.7036, 1.6975, 0.0061, 0.003, 0.0136, 0.9834],
  CAT16: [0.401288, 0.650173, -0.051461, -0.250268, 1.204414, 0.045854, -0.002079, 0.048952, 0.953127],
  "von-Kries": [0.40024, 0.7076, -0.08081, -0.2263, 1.16532, 0.0457, 0, 0, 0.91822],
  "XYZ-scaling": [1, 0, 0, 0, 1, 0, 0, 0, 1],
};

function apply(m: Matrix, c: Float64Array): void {
  // Not destructured: an iterator for every colour takes most of the time.
  const x = c[0]!;
  const y = c[1]!;
  const z = c[2]!;
  c[0] = m[0]! * x + m[1]! * y + m[2]! * z;
  c[1] = m[3]! * x + m[4]! * y + m[5]! * z;
  c[2] = m[6]! * x + m[7]! * y + m[8]! * z;
}

/** `base ** exponent` for a base of 0 or more, in half the time. */
function power(base: number, exponent: number): number {
  return base > 0 ? Math.exp(exponent * Math.log(base)) : 0;
}

function applied(m: Matrix, c: ArrayLike<number>): Float64Array {
  const result = Float64Array.from(c);
  apply(m, result);
  return result;
}

function product(a: Matrix, b: Matrix): Matrix {
  return Array.from({ length: 9 }, (_, i) => {
    const [row, column] = [i - (i % 3), i % 3];
    return a[row]! * b[column]! + a[row + 1]! * b[column + 3]! + a[row + 2]! * b[column + 6]!;
  });
}

function inverse(m: Matrix): Matrix {
  const minor = (i: number) => {
    const [row, column] = [Math.floor(i / 3), i % 3];
    const at = (down: number, across: number) => m[3 * ((row + down) % 3) + ((column + across) % 3)]!;
    return at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1);
  };
  const determinant = m[0]! * minor(0) + m[1]! * minor(1) + m[2]! * minor(2);
  return m.map((_, i) => minor(3 * (i % 3) + Math.floor(i / 3)) / determinant);
}

/** Rows multiplied by numbers. */
function scaled(rows: ArrayLike<number>, m: Matrix): Matrix {
  return m.map((value, i) => value * rows[Math.floor(i / 3)]!);
}

/** Adaptation from one white to another (von Kries), in the space of a matrix. */
function adaptation(source: ArrayLike<number>, target: ArrayLike<number>, cones: Matrix): Matrix {
  const [from, to] = [applied(cones, source), applied(cones, target)];
  return product(inverse(cones), scaled(to.map((value, i) => value / from[i]!), cones));
}

/** Linear RGB → X, Y, Z, with white at equal red, green and blue of 1 (SMPTE RP 177). */
function rgbToXyz([xr, yr, xg, yg, xb, yb]: readonly [number, number, number, number, number, number]): Matrix {
  const z = (x: number, y: number) => (1 - x - y) / y;
  const columns = [xr / yr, xg / yg, xb / yb, 1, 1, 1, z(xr, yr), z(xg, yg), z(xb, yb)];
  const amounts = applied(inverse(columns), D65);
  return columns.map((value, i) => value * amounts[i % 3]!);
}

function fromD50(screen: Screen): Matrix {
  const toD50 = adaptation(D65, ICC_D50, ADAPTATIONS["Bradford"]!);
  return inverse(product(toD50, rgbToXyz(PRIMARIES[screen])));
}

const SCREENS: Record<Screen, Matrix> = { srgb: fromD50("srgb"), "display-p3": fromD50("display-p3") };

/** CIE 15:2018, 8.2.1; the linear part continues below zero. */
function cielab([xn, yn, zn]: ArrayLike<number> & Iterable<number>): Inverse {
  const ratio = (f: number) => (f > 6 / 29 ? f * f * f : ((f - 4 / 29) * 108) / 841);
  return (c) => {
    const middle = (c[0]! + 16) / 116;
    const [x, z] = [middle + c[1]! / 500, middle - c[2]! / 200];
    c[0] = xn! * ratio(x);
    c[1] = yn! * ratio(middle);
    c[2] = zn! * ratio(z);
  };
}

/** CIE 15:2018, 8.2.2. */
function cieluv([xn, yn, zn]: ArrayLike<number> & Iterable<number>): Inverse {
  const total = xn! + 15 * yn! + 3 * zn!;
  const [u0, v0] = [(4 * xn!) / total, (9 * yn!) / total];
  return (c) => {
    const lightness = c[0]!;
    if (!(lightness > 0)) {
      c.fill(0);
      return;
    }
    const u = c[1]! / (13 * lightness) + u0;
    const v = Math.max(c[2]! / (13 * lightness) + v0, 1e-4); // no colour has v′ = 0
    const y = yn! * (lightness > 8 ? ((lightness + 16) / 116) ** 3 : lightness * (3 / 29) ** 3);
    c[0] = (y * 9 * u) / (4 * v);
    c[1] = y;
    c[2] = (y * (12 - 3 * u - 20 * v)) / (4 * v);
  };
}

/** DIN 6176:2018: CIELAB, rotated by 26° and compressed logarithmically. */
function din99o(white: ArrayLike<number> & Iterable<number>): Inverse {
  const [cosine, sine] = [Math.cos((26 * Math.PI) / 180), Math.sin((26 * Math.PI) / 180)];
  const lightnessScale = 100 / Math.log1p(0.39);
  const toXyz = cielab(white);
  return (c) => {
    const length = Math.sqrt(c[1]! * c[1]! + c[2]! * c[2]!);
    const radius = Math.expm1(0.0435 * Math.min(length, 200)) / 0.075;
    const [across, up] = length > 0 ? [c[1]! / length, c[2]! / length] : [1, 0];
    const red = radius * (across * cosine + up * sine);
    const yellow = (radius * (up * cosine - across * sine)) / 0.83;
    c[0] = Math.expm1(Math.min(Math.max(c[0]!, 0), 200) / lightnessScale) / 0.0039;
    c[1] = red * cosine - yellow * sine;
    c[2] = red * sine + yellow * cosine;
    toXyz(c);
  };
}

/** Cone responses raised to a power with their sign, and made opponent by a matrix. */
function powerOpponent(cones: Matrix, exponent: number, opponent: Matrix): Inverse {
  const [toResponses, toXyz] = [inverse(opponent), inverse(cones)];
  return (c) => {
    apply(toResponses, c);
    for (let i = 0; i < 3; i++) c[i] = Math.sign(c[i]!) * power(Math.abs(c[i]!), 1 / exponent);
    apply(toXyz, c);
  };
}

/** Ottosson, A perceptual color space for image processing (2020). */
const OKLAB = powerOpponent(
  [0.8189330101, 0.3618667424, -0.1288597137, 0.0329845436, 0.9293118715, 0.0361456387, 0.0482003018, 0.2643662691, 0.633851707],
  1 / 3,
  [0.2104542553, 0.793617785, -0.0040720468, 1.9779984951, -2.428592205, 0.4505937099, 0.0259040371, 0.7827717662, -0.808675766],
);

/** Ebner and Fairchild, 6th Color Imaging Conference (1998). */
const IPT = powerOpponent(
  [0.4002, 0.7075, -0.0807, -0.228, 1.15, 0.0612, 0, 0, 0.9184],
  0.43,
  [0.4, 0.4, 0.2, 4.455, -4.851, 0.396, 0.8056, 0.3572, -1.1628],
);

/** Luminance in cd/m² of a signal of the perceptual quantizer (ITU-R BT.2100-2, table 4). */
function pqLuminance(signal: number, exponent: number): number {
  const [c1, c2, c3] = [3424 / 4096, (2413 / 4096) * 32, (2392 / 4096) * 32];
  const root = Math.min(power(signal, 1 / exponent), 1.0075); // the pole is at 1.0088
  return 10_000 * power((root - c1) / (c2 - c3 * root), 16384 / 2610);
}

/** ITU-R BT.2100-2, table 7; as ITP, ITU-R BT.2124-0, annex 1, times 720. */
function ictcp(luminance: number, isItp: boolean): Inverse {
  const cones = [1688, 2146, 262, 683, 2951, 462, 99, 309, 3688].map((value) => value / 4096);
  const opponent = [2048, 2048, 0, 6610, -13613, 7003, 17933, -17390, -543].map((value) => value / 4096);
  const toSignals = inverse(isItp ? scaled([720, 360, 720], opponent) : opponent);
  const toXyz = product(rgbToXyz(PRIMARIES.bt2020), inverse(cones));
  return (c) => {
    apply(toSignals, c);
    for (let i = 0; i < 3; i++) c[i] = pqLuminance(c[i]!, (2523 / 4096) * 128) / luminance;
    apply(toXyz, c);
  };
}

/** Safdar et al., Optics Express 25 (2017), equations 8 to 12. */
function jzazbz(luminance: number): Inverse {
  const [b, g, d, d0] = [1.15, 0.66, -0.56, 1.6295499532821566e-11];
  const toSignals = inverse([0.5, 0.5, 0, 3.524, -4.066708, 0.542708, 0.199076, 1.096799, -1.295875]);
  const toShifted = inverse([0.41478972, 0.579999, 0.014648, -0.20151, 1.120649, 0.0531008, -0.0166008, 0.2648, 0.6684799]);
  return (c) => {
    const lightness = Math.min(Math.max(c[0]! + d0, 0), 2);
    c[0] = lightness / (1 + d - d * lightness);
    apply(toSignals, c);
    for (let i = 0; i < 3; i++) c[i] = pqLuminance(c[i]!, (1.7 * 2523) / 32) / luminance;
    apply(toShifted, c);
    c[0] = (c[0]! + (b - 1) * c[2]!) / b;
    c[1] = (c[1]! + (g - 1) * c[0]) / g;
  };
}

/** Factors F, c and N_c (CIE 159:2004, table 1; Li et al. 2017, table A1). */
const SURROUNDS: Record<string, readonly [number, number, number]> = {
  average: [1, 0.69, 1],
  dim: [0.9, 0.59, 0.9],
  dark: [0.8, 0.525, 0.8],
};

/** XYZ → the cones of Hunt, Pointer and Estévez (CIE 159:2004, 8.5). */
const CONES = [0.38971, 0.68898, -0.07868, -0.22981, 1.1834, 0.04641, 0, 0, 1];

/**
 * CAM16-UCS (CAT16) or CAM02-UCS (CAT02), in closed form.
 *
 * CIE 159:2004, 8 and 9; Luo, Cui and Li (2006), table 2; Li et al., Color Research and Application
 * 42 (2017), appendices A and B.
 */
function appearanceModel(space: SpaceDescription, name: "CAT16" | "CAT02"): Inverse {
  const adapting = space.adapting_luminance ?? 64 / Math.PI / 5;
  const [factor, impact, induction] = SURROUNDS[space.surround ?? "average"]!;
  const white = space.reference_white_xyz.map((value) => 100 * value);
  const k = 1 / (5 * adapting + 1);
  const level = k ** 4 * adapting + 0.1 * (1 - k ** 4) ** 2 * Math.cbrt(5 * adapting);
  const ratio = (space.background ?? 20) / white[1]!;
  const backgroundInduction = 0.725 * ratio ** -0.2;
  const exponent = impact * (1.48 + Math.sqrt(ratio));
  const chromaFactor = (1.64 - 0.29 ** ratio) ** 0.73;
  const chromaInduction = (50_000 / 13) * induction * backgroundInduction;
  const degree = Math.min(Math.max(factor * (1 - Math.exp((-adapting - 42) / 92) / 3.6), 0), 1);
  const sharp = ADAPTATIONS[name]!;
  const gains = applied(sharp, white).map((value) => (degree * white[1]!) / value + 1 - degree);
  let adapted = scaled(gains, sharp);
  if (name === "CAT02") adapted = product(product(CONES, inverse(sharp)), adapted);
  const [red, green, blue] = applied(adapted, white).map((value) => {
    const power = ((level * Math.abs(value)) / 100) ** 0.42;
    return (Math.sign(value) * 400 * power) / (power + 27.13) + 0.1;
  });
  const whiteResponse = (2 * red! + green! + blue! / 20 - 0.305) * backgroundInduction;
  const toXyz = inverse(adapted);
  return (c) => {
    const uniform = Math.min(Math.max(c[0]!, 0), 200);
    const root = Math.sqrt(uniform / (1.7 - 0.007 * uniform) / 100);
    const length = Math.sqrt(c[1]! * c[1]! + c[2]! * c[2]!);
    const [cosine, sine] = length > 0 ? [c[1]! / length, c[2]! / length] : [1, 0];
    const chroma = Math.expm1(0.0228 * Math.min(length, 500)) / 0.0228 / level ** 0.25;
    const strength = root > 0 ? power(chroma / (root * chromaFactor), 1 / 0.9) : 0;
    const light = (whiteResponse * power(root, 2 / exponent)) / backgroundInduction;
    const eccentricity = chromaInduction * 0.25 * (cosine * Math.cos(2) - sine * Math.sin(2) + 3.8);
    const divisor = 23 * eccentricity + strength * (11 * cosine + 108 * sine);
    const size = divisor > 1e-6 ? (23 * (light + 0.305) * strength) / divisor : 0;
    const [a, b] = [size * cosine, size * sine];
    c[0] = 460 * light + 451 * a + 288 * b;
    c[1] = 460 * light - 891 * a - 261 * b;
    c[2] = 460 * light - 220 * a - 6300 * b;
    for (let i = 0; i < 3; i++) {
      const compressed = c[i]! / 1403;
      const part = Math.min(Math.abs(compressed), 399);
      c[i] = (Math.sign(compressed) * power((27.13 * part) / (400 - part), 1 / 0.42)) / level;
    }
    apply(toXyz, c);
  };
}

const DEFAULT_LUMINANCE = 203; // ITU-R BT.2408-7, 2.2

const FORMULAS: Record<string, (space: SpaceDescription) => Inverse> = {
  CIELAB: ({ reference_white_xyz: white }) => cielab(white),
  CIELUV: ({ reference_white_xyz: white }) => cieluv(white),
  CIEXYZ: () => () => {},
  "CAM16-UCS": (space) => appearanceModel(space, "CAT16"),
  "CAM02-UCS": (space) => appearanceModel(space, "CAT02"),
  DIN99o: ({ reference_white_xyz: white }) => din99o(white),
  Oklab: () => OKLAB,
  IPT: () => IPT,
  ICtCp: ({ luminance }) => ictcp(luminance ?? DEFAULT_LUMINANCE, false),
  ITP: ({ luminance }) => ictcp(luminance ?? DEFAULT_LUMINANCE, true),
  Jzazbz: ({ luminance }) => jzazbz(luminance ?? DEFAULT_LUMINANCE),
};

/** CIELAB relative to ICC's D50, unless a gamut describes its space. */
const CIELAB: SpaceDescription = {
  name: "CIELAB",
  axes: ["L*", "a*", "b*"],
  reference_white_xyz: [...ICC_D50],
  adaptation: "Bradford",
};

/**
 * CIELAB colours of a print as measured, made relative to its paper: X, Y, Z are scaled by D50 ÷ paper,
 * as ICC.1:2022, 6.3.2.2 has it. All values are relative to ICC's D50.
 */
export function mediaRelative(lab: Float32Array, paper: readonly number[]): Float32Array {
  const space = spaceOf();
  const white = space.toXyz(Float32Array.from(paper));
  const xyz = space.toXyz(lab);
  const f = (value: number) => (value > (6 / 29) ** 3 ? Math.cbrt(value) : (841 / 108) * value + 4 / 29);
  const relative = new Float32Array(lab.length);
  for (let i = 0; i < lab.length; i += 3) {
    const [x, y, z] = [0, 1, 2].map((axis) => f(xyz[i + axis]! / white[axis]!)) as [number, number, number];
    relative.set([116 * y - 16, 500 * (x - y), 200 * (y - z)], i);
  }
  return relative;
}

/** What a gamut says of its space. */
interface InSpace {
  options: { space: string; adaptation?: string | null };
  provenance: { colour_space?: SpaceDescription };
}

/**
 * Return the description of the space of a gamut. Its adaptation is that of the options: the
 * provenance has a sentence for colours that were not adapted.
 */
export function spaceDescription({ options, provenance }: InSpace): Partial<SpaceDescription> {
  return { name: options.space, ...provenance.colour_space, adaptation: options.adaptation ?? "Bradford" };
}

/** The space of a gamut. */
export function gamutSpace(gamut: InSpace): Space {
  return spaceOf(spaceDescription(gamut));
}

/** No colour has larger tristimulus values; a formula far outside of its domain may give any. */
const LARGEST = 1e6;

/**
 * Return the space of a description. Fields that it lacks are those of CIELAB with D50.
 *
 * Colours are seen by an eye adapted to the reference white. They are adapted to D50 by Bradford if
 * the space has no adaptation, as in `ColourSpace.appearance_lab`.
 */
export function spaceOf(description: Partial<SpaceDescription> = {}): Space {
  const space: SpaceDescription = { ...CIELAB, ...description };
  const formula = FORMULAS[space.name];
  if (formula === undefined) throw new Error(`The page does not know the colour space ${space.name}.`);
  const toTristimulus = formula(space);
  const toD50 = adaptation(space.reference_white_xyz, ICC_D50, ADAPTATIONS[space.adaptation] ?? ADAPTATIONS["Bradford"]!);
  const converted = (positions: Float32Array, matrix: Matrix, finish: Inverse) => {
    const result = new Float32Array(positions.length);
    const colour = new Float64Array(3);
    for (let i = 0; i < positions.length; i += 3) {
      for (let axis = 0; axis < 3; axis++) colour[axis] = positions[i + axis]!;
      toTristimulus(colour);
      for (let axis = 0; axis < 3; axis++) {
        const value = colour[axis]!;
        colour[axis] = Number.isNaN(value) ? 0 : Math.min(Math.max(value, -LARGEST), LARGEST);
      }
      apply(matrix, colour);
      finish(colour);
      for (let axis = 0; axis < 3; axis++) result[i + axis] = colour[axis]!;
    }
    return result;
  };
  return {
    name: space.name,
    axes: space.axes,
    lightness: space.name === "CIEXYZ" ? 1 : 0,
    toXyz: (positions) => converted(positions, toD50, () => {}),
    toLab: (positions) => converted(positions, toD50, xyzToLab),
    linear: (positions, screen = "srgb", clipped = true) =>
      converted(positions, product(SCREENS[screen], toD50), clipped ? clip : () => {}),
  };
}

function xyzToLab(c: Float64Array): void {
  const [x, y, z] = [c[0]! / ICC_D50[0], c[1]!, c[2]! / ICC_D50[2]].map((ratio) =>
    ratio > (6 / 29) ** 3 ? Math.cbrt(ratio) : (ratio * 841) / 108 + 4 / 29,
  );
  c[0] = 116 * y! - 16;
  c[1] = 500 * (x! - y!);
  c[2] = 200 * (y! - z!);
}

function clip(c: Float64Array): void {
  for (let i = 0; i < 3; i++) c[i] = Math.min(Math.max(c[i]!, 0), 1);
}
