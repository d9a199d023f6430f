// Which baked light belongs to which light of a three.js scene.
// SPDX-License-Identifier: MIT
import { DirectionalLight, PointLight, SpotLight, Vector3 } from 'three';

const KINDS = { directional: 'isDirectionalLight', spot: 'isSpotLight', point: 'isPointLight' };

// Position and direction of a baked light in world space: its matrix has the rows of a rotation, scaled for a sun.
export function placeOf(baked) {
  const row = (n) => new Vector3(...baked.matrix.subarray(4 * n, 4 * n + 3));
  const position = new Vector3();
  if (baked.kind !== 'directional')
    for (const n of [0, 1, 2]) position.addScaledVector(row(n), -baked.matrix[4 * n + 3]);
  return { position, direction: row(2).normalize() };
}

/** A light of three.js that a baked one describes, at its place: for a scene whose lights were given to the bake alone. */
export function lightOf(baked, color = 0xffffff, intensity = baked.kind === 'directional' ? 3 : 100) {
  const { position, direction } = placeOf(baked), range = baked.rangeMetres;
  const light = baked.kind === 'directional' ? new DirectionalLight(color, intensity)
    : baked.kind === 'spot' ? new SpotLight(color, intensity, range, Math.acos(baked.cosOuter)) : new PointLight(color, intensity, range);
  light.name = baked.name;
  light.position.copy(position);
  if (light.target) light.add(light.target.translateOnAxis(direction, 1));
  return light;
}

// What differs between a light of the scene and a baked light: metres, plus the length of the difference of unit directions.
function distance(light, baked, fromRoot) {
  const there = placeOf(baked);
  const position = new Vector3().setFromMatrixPosition(light.matrixWorld).applyMatrix4(fromRoot);
  let apart = baked.kind === 'directional' ? 0 : position.distanceTo(there.position);
  if (baked.kind !== 'point' && light.target) {
    const target = new Vector3().setFromMatrixPosition(light.target.matrixWorld).applyMatrix4(fromRoot);
    apart += target.sub(position).normalize().distanceTo(there.direction);
  }
  return apart;
}

// Names that a baker may have given to a light: of its definition or of its node. three.js removes spaces and some signs from
// names and keeps the original in userData; a glTF result has the definitions.
function namesOf(light, gltf) {
  const names = new Set();
  for (const object of [light, light.parent]) {
    if (!object || (object !== light && object.type === 'Scene')) continue;
    names.add(object.name).add(object.userData?.name);
    const at = gltf?.parser?.associations?.get(object);
    const node = gltf?.parser?.json.nodes?.[at?.nodes];
    const lit = node?.extensions?.KHR_lights_punctual?.light;
    names.add(node?.name).add(gltf?.parser?.json.extensions?.KHR_lights_punctual?.lights?.[lit]?.name);
  }
  for (const none of ['', undefined]) names.delete(none);
  return names;
}

const plain = (name) => name.replace(/\s/g, '_').replace(/[[\].:/]/g, '');

/**
 * Pair the lights below `root` with baked lights: by name (vxs appends '#2' to a second light of a name), of several the nearest;
 * else the only one of its kind at the same place.
 * fromRoot  Matrix4: world space of three.js to that of the file
 * Returns { matched: [{ light, baked, moved }], lights: without shadow, baked: without light }; moved is true if the light is no
 * longer where it was when it was baked.
 */
export function matchLights(bakedLights, root, fromRoot, gltf) {
  const lights = [];
  root.updateWorldMatrix(true, true);
  root.traverse((o) => o.isLight && Object.values(KINDS).some((is) => o[is]) && !o.isSunLight && lights.push(o));
  const pairs = [];
  for (const light of lights) {
    const names = namesOf(light, gltf), plainNames = new Set([...names].map(plain));
    for (const baked of bakedLights) {
      if (!light[KINDS[baked.kind]]) continue;
      const name = baked.name.replace(/#\d+$/, '');
      const named = names.has(baked.name) || names.has(name) ? 2 : plainNames.has(plain(name)) ? 1 : 0;
      pairs.push({ light, baked, named, apart: distance(light, baked, fromRoot) });
    }
  }
  pairs.sort((a, b) => b.named - a.named || a.apart - b.apart);
  const matched = [], used = new Set();
  for (const { light, baked, named, apart } of pairs) {
    if (used.has(light) || used.has(baked) || (!named && apart > 0.01)) continue;
    used.add(light).add(baked);
    matched.push({ light, baked, moved: apart > 0.01 });
  }
  return { matched, lights: lights.filter((l) => !used.has(l)), baked: bakedLights.filter((b) => !used.has(b)) };
}
