// Fog in the light of one baked sun or lamp for WebGPURenderer, with either backend: exact lit parts of each eye ray, as FogPass has
// them. Airlight is drawn into a texture of its own, so that fog of several lights can follow each other.
// SPDX-License-Identifier: MIT
import { Matrix3, Matrix4, Vector2, Vector3 } from 'three';
import { HalfFloatType, Node, NodeMaterial, NodeUpdateType, QuadMesh, RenderTarget, RendererUtils } from 'three/webgpu';
import { code, exp, float, getViewPosition, glslFn, length, min, texture, uniform, uv, vec3, vec4, wgslFn } from 'three/tsl';
import { VXSError } from 'vxs';
import { FogLight, perMetre } from './fog_light.mjs';
import { airReaders, wgslAirReaders } from './text.mjs';
import { wgsl } from './wgsl_fog.mjs';
import { Binding } from './binding.mjs';

export class FogNode extends Node {
  static get type() { return 'VXSFogNode'; }

  /** color, depth  texture nodes of the picture without fog. webgpu.d.ts describes options, which are those of FogPass */
  constructor(shadows, camera, color, depth, { light, extinction = 0.01, scattering, anisotropy = 0.4, transmits = true, farMetres } = {}) {
    super('vec4');
    Object.assign(this, { camera, color, depth, extinction, scattering: scattering ?? extinction, anisotropy, transmits, farMetres });
    this.updateBeforeType = NodeUpdateType.FRAME;
    this.fog = new FogLight(shadows, light);
    this.target = new RenderTarget(1, 1, { type: HalfFloatType, depthBuffer: false });
    this.air = texture(this.target.texture);
    this.fromClip = uniform(new Matrix4());
    this.toWorld = uniform(new Matrix3());
    this.lost = uniform(new Vector3());
    this.far = uniform(1);
    this.quad = new QuadMesh(new NodeMaterial());
  }

  #update() {
    const { camera, fromClip, toWorld, lost, far } = this;
    this.fog.update(camera, this);
    fromClip.value.copy(camera.projectionMatrixInverse);
    toWorld.value.setFromMatrix4(new Matrix4().extractRotation(camera.matrixWorld));
    lost.value.set(...(this.transmits ? perMetre(this.extinction) : [0, 0, 0]));
    far.value = this.farMetres ?? camera.far;
  }

  updateBefore({ renderer }) {
    const { width, height } = renderer.getDrawingBufferSize(new Vector2());
    this.#update();
    this.target.setSize(width, height);
    const state = RendererUtils.resetRendererState(renderer);
    renderer.setRenderTarget(this.target);
    this.quad.render(renderer);
    RendererUtils.restoreRendererState(renderer, state);
  }

  /** The eye ray of a pixel. */
  #ray({ renderer }) {
    const flat = this.camera.isOrthographicCamera, at = getViewPosition(uv(), this.depth.sample(uv()).r, this.fromClip);
    const near = getViewPosition(uv(), float(renderer.reversedDepthBuffer ? 1 : 0), this.fromClip), eye = flat ? vec3(near.xy, 0) : vec3(0);
    return { eye, ahead: flat ? vec3(0, 0, -1) : near.normalize(), metres: min(length(at.sub(eye)), this.far) };
  }

  setup(builder) {
    const { words, constants, macros } = this.fog, onGpu = builder.renderer.backend.isWebGPUBackend;
    if (onGpu && !words.isTables) throw new VXSError('unsupported', 'fog with WebGPU needs a light of palette blocks, with 16384 texels a side or fewer');
    const bindings = [[words.texture, 'vxsWords'], [constants, 'vxsLights']].map(([it, name]) => new Binding(texture(it).setName(name)));
    const air = onGpu
      ? wgslFn('fn vxsAir(eye: vec3f, direction: vec3f, metres: f32) -> vec3f { return vxsFog(eye, direction, metres); }',
        [...bindings, code(wgslAirReaders(wgsl, words.wide), [], 'wgsl')])
      : glslFn('vec3 vxsAir( vec3 eye, vec3 direction, float metres ) { return vxsFog( eye, direction, metres ); }',
        [...bindings, code(airReaders(macros, words.wide, ''), [], 'glsl')]);
    const { eye, ahead, metres } = this.#ray(builder);
    this.quad.material.fragmentNode = vec4(air(this.toWorld.mul(eye), this.toWorld.mul(ahead), metres), 1);
    return vec4(this.color.rgb.mul(exp(this.lost.mul(metres).negate())).add(this.air.rgb), this.color.a);
  }

  dispose() {
    this.target.dispose();
    this.quad.material.dispose();
    this.fog.dispose();
    super.dispose();
  }
}
