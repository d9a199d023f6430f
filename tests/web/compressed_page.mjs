// What tests/web/compressed.test.mjs does inside a page: levels whose meshes or textures are compressed.
// SPDX-License-Identifier: GPL-3.0-or-later
import * as THREE from 'three';
import { DRACOLoader } from 'three/addons/loaders/DRACOLoader.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { KTX2Loader } from 'three/addons/loaders/KTX2Loader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { floats, loadShadows, newCamera, newRenderer } from './three_page.mjs';

/** Share of the light of `light` at each pixel, -1 where there is none; and colours of the picture in all of its lights, [3 * pixels]. */
export async function drawn({ glb, vxs, view, size, light, libraries }) {
  const renderer = newRenderer(size), shadows = await loadShadows(vxs), camera = newCamera(view, size);
  const draco = new DRACOLoader().setDecoderPath(`${libraries}/draco/gltf/`);
  const basis = new KTX2Loader().setTranscoderPath(`${libraries}/basis/`).detectSupport(renderer);
  const gltf = await new GLTFLoader().setDRACOLoader(draco).setKTX2Loader(basis).setMeshoptDecoder(MeshoptDecoder).loadAsync(glb);
  draco.dispose();
  basis.dispose();
  const picture = () => floats(renderer, gltf.scene, camera), { matched } = shadows.attach(gltf, { filter: { box: 3 } });
  const colours = picture().filter((_, n) => n % 4 !== 3);
  const white = new THREE.MeshLambertMaterial({ flatShading: true });
  gltf.scene.traverse((object) => {
    if (object.isMesh) object.material = white;
    if (object.isLight && object.name !== light) object.visible = false;
  });
  shadows.detach();
  const bare = picture();
  shadows.attach(gltf, { filter: { box: 3 } });
  const lit = picture(), shares = Array.from({ length: bare.length / 4 }, (_, n) => (bare[4 * n] > 1e-4 ? lit[4 * n] / bare[4 * n] : -1));
  shadows.dispose();
  renderer.dispose();
  return { matched: matched.map(({ baked, moved }) => [baked.name, moved]), shares, colours: Array.from(colours) };
}
