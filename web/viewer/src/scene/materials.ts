// Materials of surfaces: colours of the screen, soft shading, and a mark of colours that it cannot show.
import { MeshBasicMaterial, type MeshBasicMaterialParameters, type WebGLProgramParametersWithUniforms } from "three";
import { BEYOND } from "../colours/colours.js";

/** Values that all surfaces share: whether colours beyond the screen are marked, and pixels per CSS pixel. */
export const surfaceUniforms = { marked: { value: false }, pixelRatio: { value: 1 } };

/** Light from the camera, slightly from the upper left. */
const LIGHT = "normalize(vec3(-0.3, 0.5, 1.0))";
/** Light of a face that is seen from the side, relative to one that faces the light. Shading only darkens. */
const LEAST_LIGHT = 0.55;
/** Distance and width of the stripes that mark colours, in CSS pixels, and how much they cover. */
const STRIPES = { distance: 7, width: 1.6, opacity: 0.6 };

/** Replaces the chunk that multiplies the vertex colour, linear RGB of the screen without clipping. */
const COLOUR = /* glsl */ `
diffuseColor.rgb *= clamp(vColor.rgb, 0.0, 1.0);
#ifdef SHADED
  vec3 faceNormal = normalize(cross(dFdx(vViewPosition), dFdy(vViewPosition)));
  diffuseColor.rgb *= mix(${LEAST_LIGHT}, 1.0, max(0.0, dot(faceNormal, ${LIGHT})));
#endif
vec3 beyond = max(-vColor.rgb, vColor.rgb - 1.0);
if (marked && max(beyond.r, max(beyond.g, beyond.b)) > ${BEYOND}) {
  float along = mod((gl_FragCoord.x + gl_FragCoord.y) / pixelRatio, ${STRIPES.distance.toFixed(1)});
  float contrast = dot(diffuseColor.rgb, vec3(0.2, 0.7, 0.1)) > 0.18 ? 0.0 : 1.0;
  if (along < ${STRIPES.width}) diffuseColor.rgb = mix(diffuseColor.rgb, vec3(contrast), ${STRIPES.opacity});
}
`;

/** A material for triangles with vertex colours. */
export function surfaceMaterial(isShaded: boolean, given: MeshBasicMaterialParameters = {}): MeshBasicMaterial {
  const material = new MeshBasicMaterial({ vertexColors: true, ...given });
  if (isShaded) material.defines = { SHADED: "" };
  material.onBeforeCompile = addColour;
  return material;
}

function addColour(shader: WebGLProgramParametersWithUniforms): void {
  Object.assign(shader.uniforms, surfaceUniforms);
  shader.vertexShader = shader.vertexShader
    .replace("void main() {", "varying vec3 vViewPosition;\nvoid main() {")
    .replace("#include <project_vertex>", "#include <project_vertex>\nvViewPosition = -mvPosition.xyz;");
  shader.fragmentShader = shader.fragmentShader
    .replace("void main() {", "uniform bool marked;\nuniform float pixelRatio;\nvarying vec3 vViewPosition;\nvoid main() {")
    .replace("#include <color_fragment>", COLOUR);
}
