// SPDX-License-Identifier: MIT
import type { Object3D } from 'three';
import type { WebGPURenderer } from 'three/webgpu';
import { VXSLoader as Loader, type BakedShadows as Shadows, type Filter, type Match } from './index.js';

export { VXSError } from 'vxs';
export { VXSShadowsPlugin, lightOf } from './index.js';

export interface NodeAttachOptions {
  /** Exact lookups through light.shadow.shadowNode; the only way here. */
  way?: 'lookup';
  /** { box: 9 } by default. */
  filter?: Filter;
  /** Its shadowMap.enabled is set; else set it yourself: without it, three.js has no shadow nodes. */
  renderer?: WebGPURenderer;
  /** Objects that move: they alone cast into live maps, whose answer is multiplied with the baked one. */
  movers?: Object3D[];
}

/**
 * As BakedShadows of vxs/three, for WebGPURenderer with either backend. Far from the world's origin set renderer.highPrecision.
 * Tested with three.js r187; before r172 there is no build with shadow nodes.
 */
export interface BakedShadows extends Omit<Shadows, 'attach'> {
  attach(target: Object3D | { scene: Object3D; parser?: unknown }, options?: NodeAttachOptions): Match;
}

export class VXSLoader extends Loader<BakedShadows> {}
