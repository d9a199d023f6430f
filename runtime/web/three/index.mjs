// `vxs/three`: baked shadows in three.js with WebGLRenderer.
// SPDX-License-Identifier: MIT
import { DepthMaps } from './depth.mjs';
import { VXSShadowsPlugin as Plugin } from './gltf.mjs';
import { ShadowLoader } from './loader.mjs';
import { Lookups } from './lookup.mjs';

export class VXSLoader extends ShadowLoader {
  static ways = { lookup: Lookups, depth: DepthMaps };
}
export class VXSShadowsPlugin extends Plugin {
  static Loader = VXSLoader;
}
export { FogPass } from './fog.mjs';
export { BakedShadows, StreamedShadows } from './loader.mjs';
export { lightOf } from './names.mjs';
export { VXSError } from 'vxs';
