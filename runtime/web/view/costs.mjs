// What live shadow maps of all lights would draw in each frame: the casters in the view of each map, as three.js culls them.
// SPDX-License-Identifier: MIT
import { Frustum, Matrix4, PerspectiveCamera, Sphere, Vector3 } from 'three';

const FACES = [
  [1, 0, 0],
  [-1, 0, 0],
  [0, 1, 0],
  [0, -1, 0],
  [0, 0, 1],
  [0, 0, -1],
];

function drawsOf(mesh) {
  const { geometry } = mesh,
    count = geometry.index?.count ?? geometry.attributes.position?.count ?? 0;
  return {
    calls: Array.isArray(mesh.material) ? Math.max(1, geometry.groups.length) : 1,
    triangles: (count / 3) * (mesh.isInstancedMesh ? mesh.count : 1),
  };
}

function frustaOf(light, far) {
  if (light.isDirectionalLight) return [null]; // its map holds the whole level
  const place = new Vector3().setFromMatrixPosition(light.matrixWorld);
  const angle = light.isSpotLight ? (2 * light.angle * 180) / Math.PI : 90,
    camera = new PerspectiveCamera(angle, 1, 0.02, light.distance || far);
  const aims = light.isSpotLight
    ? [new Vector3().setFromMatrixPosition(light.target.matrixWorld).sub(place).toArray()]
    : FACES;
  return aims.map((aim) => {
    camera.position.copy(place);
    camera.up.set(...(Math.abs(aim[1]) > 0.9 ? [0, 0, 1] : [0, 1, 0]));
    camera.lookAt(place.clone().add(new Vector3(...aim)));
    camera.updateMatrixWorld();
    return new Frustum().setFromProjectionMatrix(
      new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse),
    );
  });
}

/** { passes, calls, triangles } of all shadow passes of a frame, for the lights given. */
export function shadowPasses(root, lights, far) {
  const casters = [],
    total = { passes: 0, calls: 0, triangles: 0 };
  root.traverse((object) => {
    if (!object.isMesh || !object.visible) return;
    if (!object.geometry.boundingSphere) object.geometry.computeBoundingSphere();
    casters.push({
      ...drawsOf(object),
      sphere: object.isInstancedMesh
        ? null
        : new Sphere().copy(object.geometry.boundingSphere).applyMatrix4(object.matrixWorld),
    });
  });
  for (const light of lights)
    for (const frustum of frustaOf(light, far)) {
      total.passes++;
      for (const { calls, triangles, sphere } of casters) {
        if (frustum && sphere && !frustum.intersectsSphere(sphere)) continue;
        total.calls += calls;
        total.triangles += triangles;
      }
    }
  return total;
}
