// What tests of vxs/three/webgpu do inside a page, whose `three` is the build with WebGPURenderer.
// SPDX-License-Identifier: GPL-3.0-or-later
import * as THREE from 'three/webgpu';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { pass } from 'three/tsl';
import { FogNode, VXSLoader } from 'vxs/three/webgpu';

async function grey(url) {
  const image = await createImageBitmap(await (await fetch(url)).blob(), { colorSpaceConversion: 'none' });
  const canvas = new OffscreenCanvas(image.width, image.height), context = canvas.getContext('2d');
  context.drawImage(image, 0, 0);
  const { data } = context.getImageData(0, 0, image.width, image.height);
  return Float32Array.from({ length: data.length / 4 }, (_, n) => (data[4 * n] === data[4 * n + 2] ? data[4 * n] / 255 : NaN));
}

async function newRenderer(backend, [width, height], options = {}) {
  const renderer = new THREE.WebGPURenderer({ forceWebGL: backend === 'webgl', antialias: false, ...options });
  await renderer.init();
  renderer.setSize(width, height);
  document.body.append(renderer.domElement);
  return renderer;
}

function newCamera({ eye, target, fov }, [width, height]) {
  const camera = new THREE.PerspectiveCamera(fov, width / height, 0.1, 5000);
  camera.position.set(...eye);
  camera.lookAt(...target);
  return camera;
}

/** One channel of the pixels of a target, rows from the top. */
async function read(renderer, target) {
  const { width, height } = target, data = await renderer.readRenderTargetPixelsAsync(target, 0, 0, width, height);
  const pitch = Math.floor(data.length / height), down = renderer.backend.isWebGPUBackend;
  return Float32Array.from({ length: width * height }, (_, n) => data[(down ? Math.floor(n / width) : height - 1 - Math.floor(n / width)) * pitch + 4 * (n % width) + 1]);
}

/** As fogPicture() of three_page.mjs. */
export async function fogPicture({ glb, vxs, view, size, light, medium, backend, lights = [light] }) {
  const renderer = await newRenderer(backend, size), gltf = await new GLTFLoader().loadAsync(glb), shadows = await new VXSLoader().loadAsync(vxs);
  const camera = newCamera(view, size), scene = new THREE.Scene().add(gltf.scene), target = new THREE.RenderTarget(...size, { type: THREE.FloatType });
  gltf.scene.traverse((object) => { if (object.isMesh) object.material = new THREE.MeshBasicMaterial({ color: 0 }); });
  shadows.attach(gltf, { renderer });
  const scenePass = pass(scene, camera), depth = scenePass.getTextureNode('depth'), pipeline = new THREE.RenderPipeline(renderer), nodes = [];
  for (const name of lights) nodes.push(new FogNode(shadows, camera, nodes.at(-1) ?? scenePass.getTextureNode(), depth, { light: name, ...medium }));
  pipeline.outputNode = nodes.at(-1);
  pipeline.outputColorTransform = false;
  renderer.setRenderTarget(target);
  pipeline.render();
  const picture = Array.from(await read(renderer, target));
  nodes.forEach((node) => node.dispose());
  shadows.dispose();
  return picture;
}

/** A scene with one light, white and matt, and what draws it: one channel of its pixels. */
async function whiteScene({ glb, vxs, view, size, light, backend, type, options }) {
  const renderer = await newRenderer(backend, size, options), gltf = await new GLTFLoader().loadAsync(glb), shadows = await new VXSLoader().loadAsync(vxs);
  const camera = newCamera(view, size), scene = new THREE.Scene().add(gltf.scene), target = new THREE.RenderTarget(...size, { type: THREE.FloatType });
  const white = new THREE.MeshLambertMaterial({ flatShading: true });
  gltf.scene.traverse((object) => {
    if (object.isMesh) object.material = white;
    if (object.isLight && object.name !== light) object.visible = false;
  });
  if (type) renderer.shadowMap.type = THREE[type];
  return { renderer, gltf, shadows, light: gltf.scene.getObjectByName(light), async draw() {
    renderer.setRenderTarget(target);
    renderer.render(scene, camera);
    return read(renderer, target);
  } };
}

/** The share of light at each pixel, as litPixels() of three_page.mjs. */
export async function litPixels({ attach, ...what }) {
  const { renderer, gltf, shadows, draw } = await whiteScene(what), bare = await draw();
  shadows.attach(gltf, { renderer, ...attach });
  return Array.from(await draw(), (x, n) => (bare[n] > 1e-4 ? x / bare[n] : NaN));
}

/** Sums of pictures of attach() and setFilter() one behind the other. */
export async function changes(what) {
  const { renderer, gltf, shadows, light, draw } = await whiteScene(what), sums = {};
  const picture = async (name) => { sums[name] = (await draw()).reduce((sum, x, n) => sum + x * (1 + (n % 7)), 0); };
  await picture('none');
  shadows.attach(gltf, { renderer, filter: { box: 1 } });
  await picture('narrow');
  shadows.setFilter({ box: 17 });
  await picture('wide');
  shadows.attach(gltf, { renderer, way: 'depth' });
  await picture('depth');
  shadows.attach(gltf, { renderer, filter: { box: 1 } });
  await picture('narrow again');
  shadows.detach();
  await picture('none again');
  light.castShadow = true;
  gltf.scene.traverse((object) => { if (object.isMesh) object.castShadow = object.receiveShadow = true; });
  await picture('live');
  shadows.attach(gltf, { renderer, filter: { box: 1 } });
  await picture('narrow over live');
  shadows.attach(gltf, { renderer, way: 'depth' });
  await picture('depth over live');
  shadows.detach();
  await picture('live again');
  return sums;
}

/** What a light lets through at each pixel, against a pass of `vxs render`: see compared() of three_page.mjs. */
export async function compared({ glb, vxs, view: { eye, target, fov }, size: [width, height], light, pass, filter, backend, movers, shown }) {
  const renderer = await newRenderer(backend, [width, height]);
  const gltf = await new GLTFLoader().loadAsync(glb), shadows = await new VXSLoader().loadAsync(vxs);
  const camera = newCamera({ eye, target, fov }, [width, height]);
  const white = new THREE.MeshStandardMaterial({ roughness: 1, flatShading: true });
  gltf.scene.traverse((object) => {
    if (object.isMesh) object.material = white;
    if (object.isLight && light && object.name !== light) object.visible = false;
  });
  const scene = new THREE.Scene().add(gltf.scene), picture = new THREE.RenderTarget(width, height, { type: THREE.FloatType });
  const draw = async () => {
    renderer.setRenderTarget(picture);
    renderer.render(scene, camera);
    const values = await read(renderer, picture);
    renderer.setRenderTarget(null);
    return values;
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
