// What tests of vxs/three do inside a page. Each exported function takes and returns plain data.
// SPDX-License-Identifier: GPL-3.0-or-later
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { VXSLoader } from 'vxs/three';

/** A renderer of its own canvas, without tone mapping. */
export function newRenderer([width, height], options = {}) {
  const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true, ...options });
  renderer.setSize(width, height);
  document.body.append(renderer.domElement);
  return renderer;
}

export const loadScene = async (url) => new GLTFLoader().loadAsync(url);
export const loadShadows = async (url) => new VXSLoader().loadAsync(url);

export function newCamera({ eye, target, fov = 35 }, [width, height]) {
  const camera = new THREE.PerspectiveCamera(fov, width / height, 0.1, 5000);
  camera.position.set(...eye);
  camera.lookAt(...target);
  camera.updateMatrixWorld();
  return camera;
}

/** Linear floats of a rendering, [4 * width * height], rows from the top. */
export function floats(renderer, scene, camera) {
  const { width, height } = renderer.getSize(new THREE.Vector2()), data = new Float32Array(4 * width * height);
  const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType, colorSpace: THREE.NoColorSpace });
  renderer.setRenderTarget(target);
  renderer.render(scene, camera);
  renderer.readRenderTargetPixels(target, 0, 0, width, height, data);
  renderer.setRenderTarget(null);
  target.dispose();
  const out = new Float32Array(data.length);
  for (let y = 0; y < height; y++) out.set(data.subarray(4 * width * y, 4 * width * (y + 1)), 4 * width * (height - 1 - y));
  return out;
}

/** Grey of a PNG, 0 to 1; NaN where it is coloured. */
export async function grey(url) {
  const image = await createImageBitmap(await (await fetch(url)).blob(), { colorSpaceConversion: 'none' });
  const canvas = new OffscreenCanvas(image.width, image.height), context = canvas.getContext('2d');
  context.drawImage(image, 0, 0);
  const { data } = context.getImageData(0, 0, image.width, image.height);
  return Float32Array.from({ length: data.length / 4 }, (_, n) =>
    (data[4 * n] === data[4 * n + 1] && data[4 * n] === data[4 * n + 2] ? data[4 * n] / 255 : NaN));
}

/** Materials of a scene without textures: white, matt, of a kind of three.js. */
export function whiten(scene, Material = THREE.MeshLambertMaterial) {
  const white = new Material({ color: 0xffffff, flatShading: true });
  scene.traverse((object) => {
    if (!object.isMesh) return;
    object.material = white;
    if (!object.geometry.attributes.normal) object.geometry.computeVertexNormals(); // old releases have no shadows without
  });
  return white;
}

/** What the light of a name lets through at each pixel: rendering with shadows by rendering without; NaN where it does not shine. */
export async function litPixels({ glb, vxs, view, size, light, attach = {}, material = 'MeshLambertMaterial', shown }) {
  const renderer = newRenderer(size), gltf = await loadScene(glb), shadows = await loadShadows(vxs), camera = newCamera(view, size);
  whiten(gltf.scene, THREE[material]);
  gltf.scene.traverse((object) => { if (object.isLight && light && object.name !== light) object.visible = false; });
  const bare = floats(renderer, gltf.scene, camera);
  const match = shadows.attach(gltf, { renderer, ...attach });
  const began = performance.now(), shaded = floats(renderer, gltf.scene, camera), ms = performance.now() - began;
  const calls = renderer.info.render.calls, meshes = [];
  gltf.scene.traverse((object) => object.isMesh && meshes.push(object));
  const lit = Float32Array.from({ length: bare.length / 4 }, (_, n) => (bare[4 * n + 1] > 1e-4 ? shaded[4 * n + 1] / bare[4 * n + 1] : NaN));
  renderer.render(gltf.scene, camera);
  if (!shown) {
    shadows.dispose();
    renderer.dispose();
  }
  return { lit, ms, calls, meshes: meshes.length, matched: match.matched.map((m) => [m.light.name, m.baked.name, m.moved]) };
}

/** litPixels against a picture of a pass of `vxs render`: shares of pixels that differ by more than each limit. */
export async function compared({ pass, limits = [0.01, 0.1, 0.5], ...what }) {
  const { lit, ...more } = await litPixels(what), truth = await grey(pass);
  let pixels = 0, sum = 0;
  const beyond = limits.map(() => 0);
  lit.forEach((value, n) => {
    if (Number.isNaN(value) || Number.isNaN(truth[n])) return;
    pixels++;
    const apart = Math.abs(value - truth[n]);
    sum += apart;
    limits.forEach((limit, k) => { if (apart > limit) beyond[k]++; });
  });
  return { pixels, mean: sum / pixels, beyond: beyond.map((count) => count / pixels), ...more };
}
