// What a user of the types may write, for tsc --noEmit; lines after @ts-expect-error must be errors.
// SPDX-License-Identifier: GPL-3.0-or-later
import { VXSError, load, type Interval, type Light, type Stream } from 'vxs';
import { load as loadCore } from 'vxs/core';
import { load as loadInline } from 'vxs/inline';
import { vxs_lookup, vxs_space } from 'vxs/shaders';
import { bake, BakeError, type BakeResult } from 'vxs/bake';

export async function use(bytes: ArrayBuffer): Promise<string> {
  const vxs = await load({ wasm: new URL('https://example.org/vxs.wasm') });
  const asset = vxs.open(new Uint8Array(bytes), { memoryLimit: 1 << 20 });
  const light: Light = asset.light('sun');
  const lit: number = light.lookup({ x: 1, y: 2, z: 3 }, { normal: [0, 1, 0], filter: { smooth: 4 } });
  const many: Float32Array = light.lookupMany(new Float64Array(3), { filter: 9, out: new Float32Array(1) });
  const depths: Float32Array = light.depthMap({ resolution: 256, which: 'least' }).data;
  const voxels: Uint32Array = light.depthMap({ voxels: true }).data;
  const parts: Interval[] = light.intervals([0, 0, 0], [0, 1, 0]);
  const stream: Stream = await vxs.stream('level.vxs', { budgetBytes: 4 << 20, lights: ['sun'] });
  stream.frame({ position: [0, 0, 0], radius: 200 });
  for (const { firstWord, words } of stream.changes()) words.fill(firstWord);
  asset.points?.unpack([1, 2, 3]);
  // @ts-expect-error: a name of no option
  light.lookup([0, 0, 0], { filters: 9 });
  // @ts-expect-error: a budget is needed
  await vxs.stream('level.vxs', {});
  const core = await loadCore();
  // @ts-expect-error: without lookups
  core.open(bytes).light(0).lookup([0, 0, 0]);
  (await loadInline()).open(bytes).dispose();
  const error = new Error() as VXSError;
  return [lit, many, depths, voxels, parts, error.finding, vxs_lookup, vxs_space].join();
}

export async function baked(glb: Uint8Array, signal: AbortSignal): Promise<BakeResult | number> {
  // @ts-expect-error: pages are small or fast
  await bake(glb, { pack: 'tiny' });
  try {
    const onProgress = ({ share, doing }: { share?: number; doing: string }) => console.log(doing, share ?? 0);
    return await bake(glb, { resolution: 4096, light: ['sun'], ifChanged: true }, { onProgress, signal, files: { 'a.bin': glb } });
  } catch (error) {
    return error instanceof BakeError ? error.status : 0;
  }
}
