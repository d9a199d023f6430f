// SPDX-License-Identifier: MIT
// load() of the whole runtime, whose WebAssembly comes from `standard()` unless the caller has it.
import { instantiate } from './instance.mjs';
import { newNet, openWith } from './light.mjs';
import { Asset, Light } from './lookups.mjs';
import { Streams, openStream } from './stream.mjs';

export const loader = (standard) => async function load({ wasm } = {}) {
  const streams = new Streams(), heap = await instantiate(wasm ?? standard(), streams.imports), net = newNet();
  return Object.freeze({
    open: (bytes, options) => openWith(heap, net, Asset, Light, bytes, options),
    stream: (url, options) => openStream(heap, net, streams, Light, url, options),
    get memoryBytes() { return heap.size; },
  });
};
