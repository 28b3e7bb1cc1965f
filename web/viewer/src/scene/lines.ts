// Section lines, of constant lightness, drawn by the shader from the raw coordinates.
import { Color, type Material, type WebGLProgramParametersWithUniforms, type WebGLRenderer } from "three";

/** Distance of the lines. Spaces that are not named have a white of 100. */
const STEPS: Record<string, number> = {
  CIEXYZ: 0.2,
  Oklab: 0.2,
  IPT: 0.2,
  ICtCp: 0.2,
  ITP: 100,
  Jzazbz: 0.04,
};
/** Width in pixels of the page. */
const WIDTH = 1.2;

export interface LineSteps {
  /** Which coordinate is the lightness. */
  axis: number;
  lightness: number;
}

/** The lines that fit a space. CIEXYZ has a luminance in place of a lightness. */
export function lineSteps(space: string, axes: readonly string[]): LineSteps {
  return { axis: axes[0] === "X" ? 1 : 0, lightness: STEPS[space] ?? 20 };
}

/** Change a material's shader, after the changes that it has already. */
export function extend(material: Material, change: (shader: WebGLProgramParametersWithUniforms) => void): void {
  const { onBeforeCompile: before } = material;
  const key = material.customProgramCacheKey();
  material.onBeforeCompile = (shader, renderer) => {
    before.call(material, shader, renderer);
    change(shader);
  };
  material.customProgramCacheKey = () => key + String(change);
}

const DECLARATIONS = /* glsl */ `
varying vec3 vRaw;
uniform vec3 lineColour;
uniform float lineOpacity, lineWidth, lightnessStep;
uniform int lightnessAxis;

/** How much of a pixel a line has. Values are in steps; lines that are too dense fade. */
float lineShare(float value, float perPixel) {
  float distance = abs(fract(value - 0.5) - 0.5) / max(perPixel, 1e-6);
  return clamp(0.5 * lineWidth + 0.5 - distance, 0.0, 1.0) * (1.0 - smoothstep(0.05, 0.2, perPixel / lineWidth));
}

float lines(vec3 raw) {
  float lightness = raw[lightnessAxis] / lightnessStep;
  return lineShare(lightness, length(vec2(dFdx(lightness), dFdy(lightness))));
}
`;

/** The lines of one gamut: what its materials share. */
export class Lines {
  readonly colour = new Color();
  private readonly uniforms = {
    lineColour: { value: this.colour },
    lineWidth: { value: WIDTH },
    lightnessStep: { value: 10 },
    lightnessAxis: { value: 0 },
  };

  set steps({ axis, lightness }: LineSteps) {
    this.uniforms.lightnessAxis.value = axis;
    this.uniforms.lightnessStep.value = lightness;
  }

  /** The width follows the number of pixels, which is lower while things move. */
  fit(renderer: WebGLRenderer): void {
    this.uniforms.lineWidth.value = WIDTH * renderer.getPixelRatio();
  }

  /** Draw the lines on a material, over its faces. */
  addTo(material: Material, opacity: { value: number }): void {
    extend(material, (shader) => {
      Object.assign(shader.uniforms, this.uniforms, { lineOpacity: opacity });
      shader.vertexShader = shader.vertexShader
        .replace("#include <common>", "#include <common>\nvarying vec3 vRaw;")
        .replace("#include <begin_vertex>", "#include <begin_vertex>\nvRaw = position;");
      shader.fragmentShader = shader.fragmentShader
        .replace("#include <common>", `#include <common>\n${DECLARATIONS}`)
        .replace(
          "#include <opaque_fragment>",
          `float line = lineOpacity * lines(vRaw);
          float share = line + diffuseColor.a * (1.0 - line);
          outgoingLight = mix(outgoingLight, lineColour, line / max(share, 1e-6));
          diffuseColor.a = share;
          #include <opaque_fragment>`,
        );
    });
  }
}
