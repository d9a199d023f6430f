// SPDX-License-Identifier: MIT
// The runtime, with its WebAssembly in a file beside this module. vxs.d.ts describes all of it.
import { loader } from './load.mjs';

export { VXSError } from './instance.mjs';
export const load = loader(() => new URL('./vxs.wasm', import.meta.url));
