// `vxs/three/webgpu`: exact lookups for WebGPURenderer, with its WebGPU and its WebGL 2 backend: light.shadow.shadowNode of each light.
// SPDX-License-Identifier: MIT
import { Vector3 } from 'three';
import { Node, NodeUpdateType } from 'three/webgpu';
import { cameraWorldMatrix, code, cross, dFdx, dFdy, glslFn, int, pointShadow, positionView, shadow, texture, vec4, wgslFn } from 'three/tsl';
import { Binding } from './binding.mjs';
import { VXSShadowsPlugin as Plugin } from './gltf.mjs';
import { ShadowLoader } from './loader.mjs';
import { readers, wgslReaders } from './text.mjs';
import { NodeDepths, setShadowNode } from './webgpu_depth.mjs';
import { wgsl } from './wgsl.mjs';
import { TEXELS, commonMacros, integerTexture, writeConstants } from './words.mjs';

// How much of a baked light reaches a fragment.
class LitNode extends Node {
  static get type() { return 'VXSLitNode'; }

  constructor(lookups, row) {
    super('float');
    Object.assign(this, { lookups, row, updateBeforeType: NodeUpdateType.RENDER });
  }

  updateBefore({ camera }) { this.lookups.update(camera); }

  setup(builder) {
    const position = cameraWorldMatrix.mul(vec4(positionView, 0)).xyz.toVar(), normal = cross(dFdx(position), dFdy(position)).normalize();
    const lit = builder.renderer.backend.isWebGPUBackend ? this.lookups.wgsl : this.lookups.glsl;
    return lit(int(this.row), position, normal);
  }
}

class NodeLookups {
  live = 'always'; // lights without castShadow have no shadow nodes

  constructor(pairs, { shadows, kernel, fromRoot, movers, renderer }) {
    this.baked = new Map(pairs.map(({ light, baked }) => [light, baked]));
    this.lights = [...this.baked.values()];
    this.templates = this.lights.map((light) => light.constants());
    this.first = this.lights.map((light) => shadows.words.first.get(light));
    this.fromRoot = fromRoot;
    this.wide = shadows.words.wide;
    this.constants = integerTexture(new Uint32Array(4 * TEXELS * this.lights.length), TEXELS, this.lights.length, 4);
    this.bindings = [[shadows.words.texture, 'vxsWords'], [this.constants, 'vxsLights']].map(([it, name]) => new Binding(texture(it).setName(name)));
    if (renderer) renderer.shadowMap.enabled = true;
    this.compose(kernel, movers.length > 0);
  }

  compose(kernel, moves) {
    const macros = commonMacros(this.lights, kernel), text = (words, language) => [...this.bindings, code(words, [], language)];
    this.glsl = glslFn('float vxsShadow( int row, vec3 position, vec3 normal ) { return vxsLit( row, position, normal ); }',
      text(readers(macros, this.wide, ''), 'glsl'));
    this.wgsl = wgslFn('fn vxsShadow(row: i32, position: vec3f, normal: vec3f) -> f32 { return vxsLit(row, position, normal); }',
      text(wgslReaders(wgsl, macros, this.wide), 'wgsl'));
    this.moves = moves;
    [...this.baked.keys()].forEach((light, row) => {
      const lit = new LitNode(this, row);
      const live = light.isPointLight ? pointShadow : shadow;
      setShadowNode(light, moves ? live(light).mul(lit) : lit);
    });
  }

  update(camera) {
    const origin = new Vector3().setFromMatrixPosition(camera.matrixWorld);
    if (this.origin?.equals(origin)) return;
    this.origin = origin;
    this.lights.forEach((light, n) => writeConstants(this.constants.image.data, 4 * TEXELS * n, light, this.templates[n], this.first[n], origin, this.fromRoot));
    this.constants.needsUpdate = true;
  }

  setFilter(kernel) { this.compose(kernel, this.moves); }
  add() {} // shadow nodes are part of the lights

  dispose() {
    for (const light of this.baked.keys()) setShadowNode(light, null);
    this.constants.dispose();
  }
}

export class VXSLoader extends ShadowLoader {
  static ways = { lookup: NodeLookups, depth: NodeDepths };
}
export class VXSShadowsPlugin extends Plugin {
  static Loader = VXSLoader;
}
export { FogNode } from './webgpu_fog.mjs';
export { BakedShadows, StreamedShadows } from './loader.mjs';
export { lightOf } from './names.mjs';
export { VXSError } from 'vxs';
