// Materials of surfaces: colours of the screen, and soft shading.
import { MeshBasicMaterial, type MeshBasicMaterialParameters, type WebGLProgramParametersWithUniforms } from "three";

/** Light from the camera and the upper left, so strong that faces towards the viewer have their true colours. */
const LIGHT = "vec3(-0.3, 0.5, 1.0)";
/** Light of a face that is seen from the side, relative to one that faces the light. Shading only darkens. */
const LEAST_LIGHT = 0.72;

/** Replaces the chunk that multiplies the vertex colour, linear RGB of the screen without clipping. */
const COLOUR = /* glsl */ `
diffuseColor.rgb *= clamp(vColor.rgb, 0.0, 1.0);
vec3 faceNormal = normalize(cross(dFdx(vViewPosition), dFdy(vViewPosition)));
diffuseColor.rgb *= mix(${LEAST_LIGHT}, 1.0, clamp(dot(faceNormal, ${LIGHT}), 0.0, 1.0));
`;

/** A material for triangles with vertex colours. */
export function surfaceMaterial(given: MeshBasicMaterialParameters = {}): MeshBasicMaterial {
  const material = new MeshBasicMaterial({ vertexColors: true, ...given });
  material.onBeforeCompile = addColour;
  return material;
}

function addColour(shader: WebGLProgramParametersWithUniforms): void {
  shader.vertexShader = shader.vertexShader
    .replace("void main() {", "varying vec3 vViewPosition;\nvoid main() {")
    .replace("#include <project_vertex>", "#include <project_vertex>\nvViewPosition = -mvPosition.xyz;");
  shader.fragmentShader = shader.fragmentShader
    .replace("void main() {", "varying vec3 vViewPosition;\nvoid main() {")
    .replace("#include <color_fragment>", COLOUR);
}
