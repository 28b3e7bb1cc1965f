// Oblique lines on the parts of surfaces whose colours the screen cannot show.
import type { Material } from "three";
import { BEYOND } from "../colours/colours.js";

const isMarked = { value: 0 };

/** Show the marks of all surfaces, or hide them. */
export function setMarks(isOn: boolean): void {
  isMarked.value = isOn ? 1 : 0;
}

/** Give a material of a surface with the attribute `beyond` marks, and return it. */
export function withMarks<Kind extends Material>(material: Kind): Kind {
  const period = (9 * Math.min(devicePixelRatio, 2)).toFixed(1);
  material.onBeforeCompile = (shader) => {
    shader.uniforms["isMarked"] = isMarked;
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nattribute float beyond;\nvarying float vBeyond;")
      .replace("#include <begin_vertex>", "#include <begin_vertex>\nvBeyond = beyond;");
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", "#include <common>\nuniform float isMarked;\nvarying float vBeyond;")
      .replace(
        "#include <color_fragment>",
        `#include <color_fragment>
        if (isMarked > 0.5 && vBeyond > ${BEYOND} && mod(gl_FragCoord.x + gl_FragCoord.y, ${period}) < 0.25 * ${period}) {
          diffuseColor.rgb = vec3(dot(diffuseColor.rgb, vec3(0.2126, 0.7152, 0.0722)) > 0.18 ? 0.02 : 0.85);
        }`,
      );
  };
  return material;
}
