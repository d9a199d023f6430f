// What tests of vxs/three/webgpu do inside a page, whose `three` is the build with WebGPURenderer.
// SPDX-License-Identifier: GPL-3.0-or-later
import * as THREE from 'three/webgpu';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { VXSLoader } from 'vxs/three/webgpu';

async function grey(url) {
  const image = await createImageBitmap(await (await fetch(url)).blob(), { colorSpaceConversion: 'none' });
  const canvas = new OffscreenCanvas(image.width, image.height), context = canvas.getContext('2d');
  context.drawImage(image, 0, 0);
  const { data } = context.getImageData(0, 0, image.width, image.height);
  return Float32Array.from({ length: data.length / 4 }, (_, n) => (data[4 * n] === data[4 * n + 2] ? data[4 * n] / 255 : NaN));
}

/** What a light lets through at each pixel, against a pass of `vxs render`: see compared() of three_page.mjs. */
export async function compared({ glb, vxs, view: { eye, target, fov }, size: [width, height], light, pass, filter, backend, movers, shown }) {
  const renderer = new THREE.WebGPURenderer({ forceWebGL: backend === 'webgl', antialias: false });
  await renderer.init();
  renderer.setSize(width, height);
  document.body.append(renderer.domElement);
  const gltf = await new GLTFLoader().loadAsync(glb), shadows = await new VXSLoader().loadAsync(vxs);
  const camera = new THREE.PerspectiveCamera(fov, width / height, 0.1, 5000);
  camera.position.set(...eye);
  camera.lookAt(...target);
  const white = new THREE.MeshStandardMaterial({ roughness: 1, flatShading: true });
  gltf.scene.traverse((object) => {
    if (object.isMesh) object.material = white;
    if (object.isLight && light && object.name !== light) object.visible = false;
  });
  const scene = new THREE.Scene().add(gltf.scene), picture = new THREE.RenderTarget(width, height, { type: THREE.FloatType });
  const draw = async () => {
    renderer.setRenderTarget(picture);
    renderer.render(scene, camera);
    const data = await renderer.readRenderTargetPixelsAsync(picture, 0, 0, width, height);
    renderer.setRenderTarget(null);
    const pitch = data.length / height, down = renderer.backend.isWebGPUBackend;
    return Float32Array.from({ length: width * height }, (_, n) => {
      const x = n % width, y = Math.floor(n / width);
      return data[(down ? y : height - 1 - y) * Math.floor(pitch) + 4 * x + 1];
    });
  };
  const bare = await draw();
  const ball = new THREE.Mesh(new THREE.SphereGeometry(1), white);
  if (movers) scene.add(ball);
  const match = shadows.attach(gltf, { renderer, filter, movers: movers ? [ball] : [] });
  const began = performance.now(), shaded = await draw(), ms = performance.now() - began;
  ball.castShadow = false;
  const flying = movers ? await draw() : shaded, thrown = shaded.filter((value, n) => value < flying[n] - 1e-4).length;
  shadows.detach();
  ball.removeFromParent();
  const nodes = match.matched.filter((pair) => pair.light.shadow.shadowNode).length, after = await draw();
  const truth = await grey(pass);
  let pixels = 0, sum = 0, most = 0;
  shaded.forEach((value, n) => {
    if (!(bare[n] > 1e-4) || Number.isNaN(truth[n])) return;
    const apart = Math.abs(value / bare[n] - truth[n]);
    pixels++;
    sum += apart;
    if (apart > 0.5) most++;
  });
  const restored = after.every((x, n) => x === bare[n]);
  if (shown) {
    shadows.attach(gltf, { renderer, filter });
    renderer.render(scene, camera);
  }
  return { webgpu: renderer.backend.isWebGPUBackend === true, pixels, mean: sum / pixels, most: most / pixels, ms, restored, thrown, nodes, matched: match.matched.length };
}
