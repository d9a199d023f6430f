// SPDX-License-Identifier: MIT
// The part of the runtime that a shader needs: open, words, constants, depth maps. core.d.ts describes it.
import { VXSError, instantiate } from './instance.mjs';
import { CoreAsset, CoreLight, newNet, openWith } from './light.mjs';

export async function load({ wasm = new URL('./core.wasm', import.meta.url) } = {}) {
  const heap = await instantiate(wasm), net = newNet();
  return Object.freeze({
    open: (bytes, options) => openWith(heap, net, CoreAsset, CoreLight, bytes, options),
    get memoryBytes() { return heap.size; },
  });
}
export { VXSError };
