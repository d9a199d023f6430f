// Baked maps as depth textures in the shadow slots of three.js: its own shaders filter them, and no shadow pass runs.
//
// A directional light has one orthographic map with linear depth. A spot has logarithmic depth, which becomes that of a perspective
// camera. A point light has a cube texture. Before r182 three.js packs depths into colours and has no cube textures for shadows.
// SPDX-License-Identifier: MIT
import {
  BasicShadowMap, CubeTexture, DataTexture, DepthFormat, GreaterEqualCompare, LessEqualCompare, LinearFilter, Matrix4, NearestFilter,
  REVISION, RGBAFormat, UnsignedByteType, UnsignedIntType, UnsignedShortType, VSMShadowMap, Vector3,
} from 'three';
import { VXSError } from 'vxs';
import { placeOf } from './names.mjs';

const PACKS = Number.parseInt(REVISION, 10) < 182;
const SLOT = ['autoUpdate', 'needsUpdate', 'bias', 'normalBias', 'updateMatrices'];

const farOf = (baked) => baked.nearMetres * Math.exp(baked.resolution * baked.voxelMetres);
// depth of a perspective camera at z metres, as A + B / z
const perspective = (near, far) => ({ a: far / (far - near), b: (-far * near) / (far - near) });

// Depths of [0, 1] as texels of three.js.
const PACK = {
  packed(depths) { // unpackRGBAToDepth of its shaders
    const out = new Uint8Array(4 * depths.length);
    depths.forEach((depth, n) => {
      let rest = Math.min(depth, 1 - 2 ** -24);
      for (let byte = 0; byte < 3; byte++) {
        rest *= 256;
        out[4 * n + byte] = Math.floor(rest);
        rest -= Math.floor(rest);
      }
      out[4 * n + 3] = Math.floor(255 * rest);
    });
    return { data: out, format: RGBAFormat, type: UnsignedByteType, internalFormat: 'RGBA8' };
  },
  short(depths) {
    return { data: Uint16Array.from(depths, (d) => Math.round(0xffff * d)), format: DepthFormat, type: UnsignedShortType, internalFormat: 'DEPTH_COMPONENT16' };
  },
  long(depths) {
    return { data: Uint32Array.from(depths, (d) => Math.round(0xffffffff * d)), format: DepthFormat, type: UnsignedIntType, internalFormat: 'DEPTH_COMPONENT24' };
  },
};

/** World space of three.js to texture coordinates and depth, for the shaders of three.js. */
function matrixOf(baked, fromRoot, reversed) {
  const row = (n) => baked.matrix.subarray(4 * n, 4 * n + 4), side = baked.resolution;
  const add = (a, x, b, y) => Array.from(a, (value, n) => x * value + y * b[n]);
  const one = [0, 0, 0, 1];
  let rows = [0, 1, 2].map((n) => add(row(n), 1 / side, one, 0)), w = one;
  if (baked.kind === 'spot') {
    const { a, b } = perspective(baked.nearMetres, farOf(baked)), across = 1 / (side * baked.texelMetres);
    w = row(2);
    rows = [add(row(0), across, w, 0.5), add(row(1), across, w, 0.5), add(w, a, one, b)];
  }
  if (reversed) rows[2] = add(w, 1, rows[2], -1);
  return new Matrix4().set(...rows.flat(), ...w).multiply(fromRoot);
}

// Depth at the first shadowed voxel of each texel; lit to the end: 1.
function flatDepths(baked, resolution) {
  const { data } = baked.depthMap({ resolution });
  if (baked.kind === 'directional') return data;
  const near = baked.nearMetres, { a, b } = perspective(near, farOf(baked)), reach = baked.resolution * baked.voxelMetres;
  return data.map((depth) => (depth < 1 ? a + b / (near * Math.exp(depth * reach)) : 1));
}

// Directions of texels of the six faces of a cube texture: the vector of the face, across (s) and down (t).
const FACES = [
  [[1, 0, 0], [0, 0, -1], [0, -1, 0]], [[-1, 0, 0], [0, 0, 1], [0, -1, 0]], [[0, 1, 0], [1, 0, 0], [0, 0, 1]],
  [[0, -1, 0], [1, 0, 0], [0, 0, -1]], [[0, 0, 1], [1, 0, 0], [0, -1, 0]], [[0, 0, -1], [-1, 0, 0], [0, -1, 0]],
].map((face) => face.map((v) => new Vector3(...v)));

/** Six faces of perspective depth; the maps of the file are read at the nearest texel. */
function cubeDepths(baked, resolution, fromRoot) {
  const turn = new Matrix4().set(...baked.matrix, 0, 0, 0, 1).multiply(fromRoot), near = baked.nearMetres;
  const maps = Array.from({ length: baked.maps }, (_, map) => baked.depthMap({ map, resolution }).data);
  const { a, b } = perspective(near, farOf(baked)), reach = baked.resolution * baked.voxelMetres;
  const perZ = resolution / (baked.resolution * baked.texelMetres);
  return FACES.map((face) => {
    const [ahead, across, down] = face.map((v) => v.clone().transformDirection(turn).toArray()), out = new Float32Array(resolution ** 2);
    for (let y = 0, n = 0; y < resolution; y++)
      for (let x = 0; x < resolution; x++, n++) {
        const s = (2 * x + 1) / resolution - 1, t = (2 * y + 1) / resolution - 1;
        const ls = ahead.map((value, axis) => value + s * across[axis] + t * down[axis]);
        let axis = Math.abs(ls[1]) > Math.abs(ls[0]) ? 1 : 0;
        if (Math.abs(ls[2]) > Math.abs(ls[axis])) axis = 2;
        const z = Math.abs(ls[axis]), back = ls[axis] < 0 ? 1 : 0;
        const at = [1, 2].map((step) => Math.floor(resolution / 2 + (ls[(axis + step) % 3] / z) * perZ));
        if (back) at.reverse();
        const [i, j] = at.map((texel) => Math.min(Math.max(texel, 0), resolution - 1));
        const depth = maps[2 * axis + back][i + resolution * j];
        out[n] = depth < 1 ? a + (b * z) / (near * Math.exp(depth * reach)) : 1;
      }
    return out;
  });
}

/**
 * Fill the shadow slot of a light for a map of that many texels, with more fields of a LightShadow. Returns a function that puts back what
 * was there.
 */
export function fillSlot(light, baked, resolution, fromRoot, reversed, fields) {
  const { shadow } = light, had = [...SLOT, ...Object.keys(fields)].map((name) => [name, Object.hasOwn(shadow, name), shadow[name]]);
  const before = { castShadow: light.castShadow, matrix: shadow.matrix.clone(), size: shadow.mapSize.clone() }, { near, far } = shadow.camera;
  Object.assign(shadow, fields, { autoUpdate: false, needsUpdate: false });
  shadow.updateMatrices = () => {}; // spots with a texture call it each frame
  shadow.mapSize.set(resolution, resolution);
  shadow.bias = -1.5 / baked.resolution;
  light.castShadow = true;
  if (baked.kind === 'directional') shadow.normalBias = 2 * baked.texelMetres * (baked.resolution / resolution);
  else {
    const reach = (light.distance || farOf(baked)) / 4; // where bias and normal bias are right
    shadow.normalBias = 2 * baked.texelMetres * (baked.resolution / resolution) * reach;
    shadow.bias = (-1.5 * baked.voxelMetres * baked.nearMetres) / reach;
  }
  if (baked.kind === 'point') {
    shadow.camera.near = baked.nearMetres;
    shadow.camera.far = farOf(baked);
    const place = placeOf(baked).position.applyMatrix4(fromRoot.clone().invert());
    shadow.matrix.makeTranslation(-place.x, -place.y, -place.z);
  } else shadow.matrix.copy(matrixOf(baked, fromRoot, reversed));
  return () => {
    for (const [name, own, value] of had)
      if (own) shadow[name] = value;
      else delete shadow[name];
    shadow.matrix.copy(before.matrix);
    shadow.mapSize.copy(before.size);
    Object.assign(shadow.camera, { near, far });
    light.castShadow = before.castShadow;
  };
}

/** Depths of one map, or of six faces. reversed: 1 is near. mirrored: faces of a cube that is sampled at -x, as WebGPU does. */
export function depthsOf(baked, resolution, fromRoot, reversed, mirrored = false) {
  const turn = mirrored ? fromRoot.clone().scale(new Vector3(-1, 1, 1)) : fromRoot;
  const faces = baked.kind === 'point' ? cubeDepths(baked, resolution, turn) : [flatDepths(baked, resolution)];
  return reversed ? faces.map((depths) => depths.map((depth) => 1 - depth)) : faces;
}

/** Whether 16 bits hold each depth. */
export const isShort = (baked) => baked.kind === 'directional' && baked.levels <= 12;

export class DepthMaps {
  /**
   * renderer    WebGLRenderer;   resolution  of a map, a power of two
   * Throws VXSError for VSMShadowMap, and before r182 for point lights.
   */
  constructor(pairs, { renderer, fromRoot, resolution = 4096 }) {
    if (!renderer) throw new VXSError('argument', "way 'depth' needs the option renderer");
    const { type } = renderer.shadowMap, point = pairs.find(({ baked }) => baked.kind === 'point');
    if (type === VSMShadowMap) throw new VXSError('unsupported', 'VSMShadowMap blurs moments of a map of its own: use PCFShadowMap, or way lookup');
    if (PACKS && point) throw new VXSError('unsupported', `point light '${point.baked.name}': three.js r${REVISION} has no cube maps of depth: use r182 or later, or way lookup`);
    const wanted = Math.min(resolution, renderer.capabilities.maxTextureSize);
    const reversed = renderer.state.buffers.depth.getReversed?.() ?? false;
    const made = pairs.map(({ baked }) => this.#texture(baked, fromRoot, Math.min(baked.resolution, wanted), type, reversed));
    renderer.shadowMap.enabled = true;
    this.baked = new Map(pairs.map(({ light, baked }) => [light, baked]));
    this.restore = pairs.map(({ light, baked }, n) => {
      const texture = made[n], side = texture.image.width ?? texture.image[0].image.width;
      const map = { texture, depthTexture: PACKS ? null : texture, width: side, height: side, setSize() {}, dispose() {} };
      const restore = fillSlot(light, baked, side, fromRoot, reversed, { map });
      return () => {
        texture.dispose();
        restore();
      };
    });
  }

  #texture(baked, fromRoot, resolution, type, reversed) {
    const pack = PACK[PACKS ? 'packed' : isShort(baked) ? 'short' : 'long'];
    const texels = depthsOf(baked, resolution, fromRoot, reversed).map(pack);
    const { data: first, ...format } = texels[0];
    const images = texels.map(({ data }) => new DataTexture(data, resolution, resolution, format.format, format.type));
    const texture = texels.length === 6 ? new CubeTexture(images) : images[0];
    Object.assign(texture, format, { name: `${baked.name}.vxs`, generateMipmaps: false, flipY: false, unpackAlignment: 1 });
    const filters = !PACKS && type !== BasicShadowMap;
    texture.minFilter = texture.magFilter = filters ? LinearFilter : NearestFilter;
    if (filters) texture.compareFunction = reversed ? GreaterEqualCompare : LessEqualCompare;
    texture.needsUpdate = true;
    return texture;
  }

  add() {} // materials of three.js need nothing
  setFilter() {
    throw new VXSError('argument', "way 'depth' has the filters of three.js: renderer.shadowMap.type and light.shadow.radius");
  }

  dispose() {
    this.restore.splice(0).forEach((put) => put());
  }
}
