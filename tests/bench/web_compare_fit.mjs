// A shadow camera for the pages of tests/bench/web_compare.mjs, with either build of three.js.
// SPDX-License-Identifier: GPL-3.0-or-later
import * as THREE from 'three';

/** The shadow camera of the sun around all casters; returns metres a texel. */
export function fit({ sun, scene }, side) {
  const { camera } = sun.shadow, box = new THREE.Box3(), corner = new THREE.Vector3();
  sun.shadow.mapSize.set(side, side);
  sun.shadow.updateMatrices(sun);
  scene.traverse((object) => {
    if (!object.isMesh) return;
    const toLight = new THREE.Matrix4().multiplyMatrices(camera.matrixWorldInverse, object.matrixWorld), at = object.geometry.attributes.position;
    for (let n = 0; n < at.count; n++) box.expandByPoint(corner.fromBufferAttribute(at, n).applyMatrix4(toLight));
  });
  const { min, max } = box, margin = 0.01 * (max.x - min.x);
  Object.assign(camera, { left: min.x - margin, right: max.x + margin, bottom: min.y - margin, top: max.y + margin, near: -max.z - margin, far: -min.z + margin });
  camera.updateProjectionMatrix();
  return Math.max(camera.right - camera.left, camera.top - camera.bottom) / side;
}
