// SPDX-License-Identifier: MIT
// The runtime: load() instantiates the WebAssembly file beside this module, or the one given. vxs.d.ts describes all of it.
import { VXSError, instantiate } from './instance.mjs';
import { newNet, openWith } from './light.mjs';
import { Asset, Light } from './lookups.mjs';
import { Streams, openStream } from './stream.mjs';

/** load() of a build whose WebAssembly comes from `standard()` unless the caller has it. */
export const loader = (standard) => async function load({ wasm } = {}) {
  const streams = new Streams(), heap = await instantiate(wasm ?? standard(), streams.imports), net = newNet();
  return Object.freeze({
    open: (bytes, options) => openWith(heap, net, Asset, Light, bytes, options),
    stream: (url, options) => openStream(heap, net, streams, Light, url, options),
    get memoryBytes() { return heap.size; },
  });
};

export const load = loader(() => new URL('./vxs.wasm', import.meta.url));
export { VXSError };
