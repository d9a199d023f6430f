// SPDX-License-Identifier: MIT
// The runtime, with its WebAssembly as base64 in a module: where a separate file is in the way. vxs.d.ts describes all of it.
import { loader } from './load.mjs';
import { base64 } from './vxs-base64.mjs';

export { VXSError } from './instance.mjs';
export const load = loader(() => Uint8Array.from(atob(base64), (c) => c.charCodeAt(0)));
