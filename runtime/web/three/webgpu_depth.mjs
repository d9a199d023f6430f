// Baked maps in the shadow maps of WebGPURenderer, which its own shadow nodes filter. WebGPU takes no uploads to most depth textures: in
// place of a shadow pass, a triangle over the whole map writes the depths, once.
// SPDX-License-Identifier: MIT
import { AlwaysDepth, DataTexture, FloatType, RedFormat, UnsignedShortType, VSMShadowMap } from 'three';
import { NodeMaterial, PointShadowNode, QuadMesh, ShadowNode } from 'three/webgpu';
import { int, ivec2, screenCoordinate, textureLoad, vec4 } from 'three/tsl';
import { VXSError } from 'vxs';
import { depthsOf, fillSlot, isShort } from './depth.mjs';

/** Sets or removes the shadow node of a light. three.js keeps the node of a light until the light sends an event. */
export function setShadowNode(light, node) {
  if (node) light.shadow.shadowNode = node;
  else delete light.shadow.shadowNode;
  light.dispatchEvent({ type: 'dispose' });
}

const withDepths = (Base) => class extends Base {
  constructor(light, baked, fromRoot) {
    super(light);
    Object.assign(this, { baked, fromRoot });
  }

  setupRenderTarget(shadow, builder) {
    const made = super.setupRenderTarget(shadow, builder);
    made.shadowMap.texture.format = RedFormat; // a colour that nothing reads
    if (isShort(this.baked)) made.depthTexture.type = UnsignedShortType;
    return made;
  }

  renderShadow({ renderer }) {
    const { shadowMap, baked } = this, side = this.shadow.mapSize.x, downwards = baked.kind === 'point' && renderer.backend.isWebGPUBackend;
    const faces = depthsOf(baked, side, this.fromRoot, renderer.reversedDepthBuffer, downwards), at = ivec2(screenCoordinate);
    const sources = faces.map((depths) => new DataTexture(depths, side, side, RedFormat, FloatType));
    const depth = textureLoad(sources[0], downwards ? at : ivec2(at.x, int(side - 1).sub(at.y))), quad = new QuadMesh(new NodeMaterial());
    Object.assign(quad.material, { fragmentNode: vec4(0), depthNode: depth.x, depthFunc: AlwaysDepth });
    quad.castShadow = true; // others are not drawn into shadow maps
    sources.forEach((source, face) => {
      source.needsUpdate = true;
      depth.value = source;
      renderer.setRenderTarget(shadowMap, face);
      quad.render(renderer);
      source.dispose();
    });
    quad.material.dispose();
  }
};
const FlatNode = withDepths(ShadowNode), CubeNode = withDepths(PointShadowNode);

export class NodeDepths {
  /** As DepthMaps of depth.mjs; renderer: WebGPURenderer. */
  constructor(pairs, { renderer, fromRoot, resolution = 4096 }) {
    if (!renderer) throw new VXSError('argument', "way 'depth' needs the option renderer");
    if (renderer.shadowMap.type === VSMShadowMap)
      throw new VXSError('unsupported', 'VSMShadowMap blurs moments of a map of its own: use PCFShadowMap, or way lookup');
    const { device, gl } = renderer.backend;
    const wanted = Math.min(resolution, device?.limits.maxTextureDimension2D ?? gl?.getParameter(gl.MAX_TEXTURE_SIZE) ?? resolution);
    renderer.shadowMap.enabled = true;
    this.baked = new Map(pairs.map(({ light, baked }) => [light, baked]));
    this.restore = pairs.map(({ light, baked }) => {
      const node = new (baked.kind === 'point' ? CubeNode : FlatNode)(light, baked, fromRoot), side = Math.min(baked.resolution, wanted);
      const restore = fillSlot(light, baked, side, fromRoot, renderer.reversedDepthBuffer, { map: null });
      setShadowNode(light, node);
      return () => {
        restore();
        setShadowNode(light, null);
      };
    });
  }

  add() {} // shadow nodes are part of the lights
  setFilter() {
    throw new VXSError('argument', "way 'depth' has the filters of three.js: renderer.shadowMap.type and light.shadow.radius");
  }

  dispose() {
    this.restore.splice(0).forEach((put) => put());
  }
}
