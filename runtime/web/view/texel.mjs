// The texel under the cursor: which surface is there, and why a light reaches it or not.
// SPDX-License-Identifier: MIT
import {
  FloatType,
  MeshBasicMaterial,
  NoBlending,
  PerspectiveCamera,
  Vector3,
  WebGLRenderTarget,
} from 'three';

/** A material that writes positions and normals in view space, with the holes of another material. */
function placesOf(material) {
  const { map = null, alphaMap = null, side, transparent } = material,
    alphaTest = material.alphaTest || (transparent ? 0.5 : 0);
  const places = new MeshBasicMaterial({ map, alphaMap, alphaTest, side, blending: NoBlending });
  places.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', '#include <common>\nvarying vec3 vxsView;')
      .replace('#include <project_vertex>', '#include <project_vertex>\nvxsView = mvPosition.xyz;');
    shader.fragmentShader = shader.fragmentShader
      .replace(
        '#include <common>',
        '#include <common>\nlayout(location = 1) out highp vec4 vxsNormal;\nvarying vec3 vxsView;',
      )
      .replace(
        '#include <dithering_fragment>',
        `#include <dithering_fragment>
        gl_FragColor = vec4( vxsView, 1.0 );
        vxsNormal = vec4( cross( dFdx( vxsView ), dFdy( vxsView ) ), 1.0 );`,
      );
  };
  return places;
}

export class Picker {
  #materials = new WeakMap();

  constructor(renderer) {
    this.renderer = renderer;
    this.target = new WebGLRenderTarget(1, 1, { count: 2, type: FloatType });
  }

  #places(material) {
    if (!this.#materials.has(material)) this.#materials.set(material, placesOf(material));
    return this.#materials.get(material);
  }

  /** Draw a scene with materials that write places into `target`. */
  #draw(scene, camera, target) {
    const { renderer } = this,
      swapped = [],
      { environment } = scene;
    scene.traverse((object) => {
      if (!object.isMesh) return;
      swapped.push([object, object.material]);
      object.material = Array.isArray(object.material)
        ? object.material.map((m) => this.#places(m))
        : this.#places(object.material);
    });
    scene.environment = null;
    renderer.setClearColor(0, 0);
    renderer.setRenderTarget(target);
    renderer.clear();
    renderer.render(scene, camera);
    renderer.setRenderTarget(null);
    scene.environment = environment;
    for (const [object, material] of swapped) object.material = material;
  }

  /** What is around points: for each, [{ direction: Vector3, distance }] of 6 x 64 directions; Infinity where nothing is. */
  around(scene, points) {
    const side = 8,
      count = side * side,
      target = new WebGLRenderTarget(side, side, { count: 2, type: FloatType }),
      view = new Float32Array(4 * count);
    const camera = new PerspectiveCamera(90, 1, 0.01, 1e6),
      found = [];
    for (const point of points) {
      const rays = [];
      for (const aim of [
        [1, 0, 0],
        [-1, 0, 0],
        [0, 0, 1],
        [0, 0, -1],
        [0, 1, 0],
        [0, -1, 0],
      ]) {
        camera.position.copy(point);
        camera.up.set(...(aim[1] ? [0, 0, 1] : [0, 1, 0]));
        camera.lookAt(point.clone().add(new Vector3(...aim)));
        camera.updateMatrixWorld();
        this.#draw(scene, camera, target);
        this.renderer.readRenderTargetPixels(target, 0, 0, side, side, view, undefined, 0);
        for (let n = 0; n < count; n++) {
          const across = new Vector3(
            (2 * (n % side) + 1) / side - 1,
            (2 * Math.floor(n / side) + 1) / side - 1,
            -1,
          ).normalize();
          const hit = new Vector3(...view.subarray(4 * n, 4 * n + 3));
          rays.push({
            direction: across.transformDirection(camera.matrixWorld),
            distance: view[4 * n + 3] ? hit.length() : Infinity,
          });
        }
      }
      found.push(rays);
    }
    target.dispose();
    return found;
  }

  /** The surface at a pixel: { point: [x, y, z] in metres, normal: [x, y, z] towards the eye, unit }; null: there is none. */
  at(scene, camera, x, y, width, height) {
    const { renderer, target } = this,
      view = new Float32Array(4),
      normal = new Float32Array(4);
    camera.setViewOffset(width, height, x, y, 1, 1);
    this.#draw(scene, camera, target);
    camera.clearViewOffset();
    renderer.readRenderTargetPixels(target, 0, 0, 1, 1, view, undefined, 0);
    renderer.readRenderTargetPixels(target, 0, 0, 1, 1, normal, undefined, 1);
    if (!view[3]) return null;
    const unit = new Vector3(...normal).normalize().transformDirection(camera.matrixWorld);
    return { point: new Vector3(...view).applyMatrix4(camera.matrixWorld).toArray(), normal: unit.toArray() };
  }
}

/** Unit vector from a point, [x, y, z] in metres, to a baked light. */
export const towardsLight = (baked, point) => {
  const row = (n) => new Vector3(...baked.matrix.subarray(4 * n, 4 * n + 3));
  if (baked.kind === 'directional') return row(2).normalize().negate();
  const place = new Vector3();
  for (const n of [0, 1, 2]) place.addScaledVector(row(n), -baked.matrix[4 * n + 3]);
  return place.sub(new Vector3(...point)).normalize();
};

const metres = (length) =>
  length >= 10
    ? `${length.toFixed(1)} m`
    : length >= 1
      ? `${length.toFixed(2)} m`
      : `${(100 * length).toFixed(1)} cm`;

/**
 * Why a baked light reaches a surface or not. Everything is as vxs_lookup answers: voxels are those of a lookup with this normal.
 * Returns { light, lit, state: 'lit' | 'shadow' | 'part' | 'away' | 'outside', map, texel: [i, j], depth, firstShadow, caster, why }:
 * lit is the share of light that the filter gives; caster is a point where shadow begins, in metres, or null.
 */
export function explain(baked, point, normal, filter) {
  const at = baked.voxel(point, { normal, filter }),
    lit = baked.lookup(point, { normal, filter }),
    light = baked.name;
  const facing = new Vector3(...normal).dot(towardsLight(baked, point));
  const bare = { light, lit, map: null, texel: null, depth: null, firstShadow: null, caster: null };
  if (!at || lit < 0) {
    const why =
      baked.kind === 'directional'
        ? 'Beside the baked map, where nothing casts: lit.'
        : 'Beyond the cone or the range of the light.';
    return { ...bare, state: 'outside', why };
  }
  const {
      map,
      voxel: [i, j, depth],
    } = at,
    last = baked.resolution - 1;
  const inside = Math.min(i, j) >= 0 && Math.max(i, j) <= last;
  const firstShadow = inside ? baked.firstShadow(map, i, j) : baked.resolution;
  const found = { ...bare, map, texel: [i, j], depth, firstShadow };
  const caster =
    inside && firstShadow < baked.resolution ? baked.point(map, [i + 0.5, j + 0.5, firstShadow]) : null;
  const gap = caster ? Math.hypot(...caster.map((value, axis) => value - point[axis])) : 0;
  if (facing <= 0)
    return { ...found, state: 'away', caster: null, why: 'The surface faces away from the light.' };
  if (depth >= firstShadow && lit < 1) {
    const share = lit > 0 ? `${Math.round(100 * lit)} % of the filter is lit. ` : '';
    return {
      ...found,
      state: lit > 0 ? 'part' : 'shadow',
      caster,
      why: `${share}Shadow of this texel begins at voxel ${firstShadow}, ${metres(gap)} before the surface.`,
    };
  }
  if (lit < 1)
    return {
      ...found,
      state: 'part',
      why: `This texel is lit; ${Math.round(100 * (1 - lit))} % of the filter beside it is in shadow.`,
    };
  const free = caster
    ? `Shadow of this texel begins at voxel ${firstShadow}, not before the surface.`
    : 'Nothing in this texel casts shadow.';
  return {
    ...found,
    state: 'lit',
    why: depth >= firstShadow ? 'Lit through a gap behind the first caster.' : free,
  };
}

/** The corners of a texel at a depth, in metres, for an outline. */
export const outlineOf = (baked, { map, texel: [i, j], depth }) =>
  [
    [0, 0],
    [1, 0],
    [1, 1],
    [0, 1],
  ].map(([u, v]) => baked.point(map, [i + u, j + v, depth]));
