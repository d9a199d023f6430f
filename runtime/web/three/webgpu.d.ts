// SPDX-License-Identifier: MIT
import type { Camera, Object3D } from 'three';
import type { Node, TextureNode, WebGPURenderer } from 'three/webgpu';
import { VXSLoader as Loader, type BakedShadows as Shadows, type Filter, type FogOptions, type Match } from './index.js';

export { VXSError } from 'vxs';
export { VXSShadowsPlugin, lightOf } from './index.js';

export interface NodeAttachOptions {
  /** 'lookup' (default): exact answers, by light.shadow.shadowNode. 'depth': the map in light.shadow.map, for the filters of three.js. */
  way?: 'lookup' | 'depth';
  /** { box: 9 } by default. */
  filter?: Filter;
  /** Needed by the way 'depth'. Its shadowMap.enabled is set; else set it yourself: without it, three.js has no shadow nodes. */
  renderer?: WebGPURenderer;
  /** As in vxs/three: texels along a side of a depth texture. */
  resolution?: number;
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

/**
 * Fog of one baked light as FogPass draws it, as a node for the output of a RenderPipeline: the picture of `color` in fog. Options are
 * fields and may change at any time. `color` may be another FogNode, of another light; then give it transmits: false. With the WebGPU
 * backend the light must be of palette blocks, with 16384 texels a side or fewer.
 *
 *     const scenePass = pass(scene, camera);
 *     pipeline.outputNode = new FogNode(shadows, camera, scenePass.getTextureNode(), scenePass.getTextureNode('depth'), { light: sun });
 */
export class FogNode extends Node {
  constructor(shadows: BakedShadows, camera: Camera, color: Node, depth: TextureNode, options?: Omit<FogOptions, 'half'>);
  camera: Camera;
  extinction: FogOptions['extinction'];
  scattering: FogOptions['scattering'];
  anisotropy: number;
  transmits: boolean;
  farMetres?: number;
}
