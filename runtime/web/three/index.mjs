// `vxs/three`: baked shadows in three.js with WebGLRenderer.
// SPDX-License-Identifier: MIT
export { BakedShadows, VXSLoader } from './loader.mjs';
export { FogPass } from './fog.mjs';
export { VXSError } from 'vxs';
