// What a client in TypeScript does with the types that openapi-typescript generates. Only compiled.
import createClient from "openapi-fetch";
import type { components, paths } from "./api.js";

const client = createClient<paths>({ baseUrl: "http://127.0.0.1:8000" });

export async function build(samples: number[][]): Promise<string> {
  const { data, error } = await client.POST("/v1/gamuts", {
    body: { samples, options: { gamma: 1, centre: [50, 0, 0] } },
  });
  if (error !== undefined) throw new Error(error.detail);
  return data.id;
}

export async function upload(file: Blob): Promise<string> {
  const form = new FormData();
  form.set("file", file, "FOGRA39L.ti3");
  form.set("ink_limit", "300");
  const { data, error } = await client.POST("/v1/gamuts", {
    body: { file: "", ink_limit: 300 },
    bodySerializer: () => form,
  });
  if (error !== undefined) throw new Error(error.detail);
  return data.id;
}

export async function describe(gamut_id: string): Promise<number> {
  const { data, error } = await client.GET("/v1/gamuts/{gamut_id}", { params: { path: { gamut_id } } });
  if (error !== undefined) throw new Error(error.remedy);
  // The job, if the id is the slug of a reference gamut that is still being built.
  if (!("centre" in data)) throw new Error(data.stage);
  const lightness: number | undefined = data.centre[0];
  const levels: number[] = data.levels.map((level) => level.mismatch);
  if (lightness === undefined || levels.length === 0) throw new Error(data.state);
  return lightness;
}

export function options(chosen: components["schemas"]["GamutOptions"]): string {
  return JSON.stringify({ ...chosen, segments: [16, 24] } satisfies typeof chosen);
}

export async function mesh(gamut_id: string): Promise<ArrayBuffer> {
  const { data, error } = await client.GET("/v1/gamuts/{gamut_id}/mesh", {
    params: { path: { gamut_id }, query: { triangles: 500, format: "glb", side: "inside" } },
    parseAs: "arrayBuffer",
  });
  if (error !== undefined) throw new Error(error.code);
  return data;
}
