// God rays of WebGPURenderer, for tests/bench/web_compare.mjs: GodraysNode of three.js, FogNode of vxs, and a march as web_compare_page.mjs
// has it. With the WebGL 2 backend, so that times are those of the same renderer in software.
// SPDX-License-Identifier: GPL-3.0-or-later
import * as THREE from 'three/webgpu';
import {
  Fn, Loop, exp, float, getViewPosition, length, min, normalize, select, texture, uniform, uv, vec3, vec4, viewZToPerspectiveDepth,
} from 'three/tsl';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import GodraysNode from 'three/addons/tsl/display/GodraysNode.js';
import { FogNode, VXSLoader } from 'vxs/three/webgpu';
import { fit } from './web_compare_fit.mjs';

const STEPS = 128, DENSITY = 0.2; // of GodraysNode: of 100 metres

/** A picture of the scene with a live map for the sun, which is drawn once: { renderer, camera, sun, depth }. */
async function stage({ glb, sun: towards, view: { eye, target, fov = 35 }, size: [width, height] }) {
  const renderer = new THREE.WebGPURenderer({ forceWebGL: true, antialias: false }), scene = new THREE.Scene();
  await renderer.init();
  renderer.setSize(width, height);
  renderer.shadowMap.enabled = true;
  const camera = new THREE.PerspectiveCamera(fov, width / height, 0.1, 5000), lights = [];
  const white = new THREE.MeshLambertMaterial({ flatShading: true });
  camera.position.set(...eye);
  camera.lookAt(...target);
  camera.updateMatrixWorld();
  const { scene: level } = await new GLTFLoader().loadAsync(glb);
  level.traverse((object) => {
    if (object.isLight) lights.push(object);
    if (object.isMesh) Object.assign(object, { material: white, castShadow: true, receiveShadow: true });
  });
  lights.forEach((light) => light.removeFromParent());
  const sun = new THREE.DirectionalLight(0xffffff, 3);
  sun.name = 'sun';
  sun.position.set(...towards).multiplyScalar(-1000); // GodraysNode wants a near plane before the camera
  sun.castShadow = true;
  scene.add(level, sun, sun.target);
  scene.updateMatrixWorld();
  fit({ sun, scene }, 2048);
  sun.shadow.camera.near = 1; // what is above the roofs is in its volume
  sun.shadow.camera.updateProjectionMatrix();
  const picture = new THREE.RenderTarget(width, height, { depthTexture: new THREE.DepthTexture(width, height, THREE.FloatType) });
  renderer.setRenderTarget(picture);
  renderer.render(scene, camera);
  sun.shadow.autoUpdate = false;
  return { renderer, scene, camera, sun, depth: texture(picture.depthTexture) };
}

// The share of an eye ray's airlight that is lit: a function that draws it.
function march({ renderer, camera, sun, depth }, sigma, far) {
  const target = new THREE.RenderTarget(...renderer.getSize(new THREE.Vector2()), { type: THREE.FloatType, depthBuffer: false });
  const { map: { depthTexture }, matrix } = sun.shadow, quad = new THREE.QuadMesh(new THREE.NodeMaterial());
  const [toLight, toWorld, fromClip] = [matrix, camera.matrixWorld, camera.projectionMatrixInverse].map((it) => uniform(it));
  quad.material.fragmentNode = Fn(() => {
    const end = getViewPosition(uv(), depth.sample(uv()).r, fromClip).toVar(), metres = min(length(end), far).toVar();
    const way = toWorld.mul(vec4(normalize(end), 0)).xyz.toVar(), eye = toWorld.mul(vec4(0, 0, 0, 1)).xyz;
    const sum = float(0).toVar(), whole = float(0).toVar();
    Loop(STEPS, ({ i }) => {
      const t = metres.mul(float(i).add(0.5)).div(STEPS).toVar(), weight = exp(t.mul(-sigma)).toVar();
      const at = toLight.mul(vec4(eye.add(way.mul(t)), 1)).xyz.toVar(), inside = at.clamp(0, 1).equal(at).all();
      const lit = texture(depthTexture, vec3(at.x, at.y.oneMinus(), at.z).xy).compare(at.z).r;
      sum.addAssign(weight.mul(select(inside, lit, float(1))));
      whole.addAssign(weight);
    });
    return vec4(vec3(sum.div(whole)), 1);
  })();
  return () => {
    renderer.setRenderTarget(target);
    quad.render(renderer);
  };
}

// GodraysNode without falloff, along rays of at most `far` metres.
function godrays({ camera, sun, depth }, far, resolutionScale, steps) {
  const fromClip = uniform(camera.projectionMatrixInverse), short = (at) => {
    const end = getViewPosition(at, depth.sample(at).r, fromClip), z = end.z.mul(min(float(far).div(length(end)), 1));
    return { r: viewZToPerspectiveDepth(z, float(camera.near), float(camera.far)) };
  };
  const node = Object.assign(new GodraysNode({ sample: short }, camera, sun), { resolutionScale });
  const values = { raymarchSteps: steps, density: DENSITY, maxDensity: 1, distanceAttenuation: 0 };
  for (const [name, value] of Object.entries(values)) node[name].value = value;
  node._godraysRenderTarget.texture.type = THREE.HalfFloatType; // 8 bits are too few for a share of the light
  return node;
}

const base64 = (array) => {
  const bytes = new Uint8Array(array.buffer);
  let text = '';
  for (let n = 0; n < bytes.length; n += 0x8000) text += String.fromCharCode(...bytes.subarray(n, n + 0x8000));
  return btoa(text);
};

/** As fog() of web_compare_page.mjs, for nodes. metres: of the eye rays, at each pixel. */
export async function fogNodes({ vxs, sigma, far, times, metres, ...scene }) {
  const s = await stage(scene), { renderer } = s, [width, height] = scene.size, shadows = await new VXSLoader().loadAsync(vxs);
  const target = new THREE.RenderTarget(width, height, { type: THREE.FloatType }), pipeline = new THREE.RenderPipeline(renderer);
  pipeline.outputColorTransform = false;
  const picture = async (node) => {
    pipeline.outputNode = node;
    pipeline.needsUpdate = true;
    renderer.setRenderTarget(target);
    pipeline.render();
    const data = await renderer.readRenderTargetPixelsAsync(target, 0, 0, width, height), rowOf = (n) => height - 1 - Math.floor(n / width);
    return Float32Array.from({ length: width * height }, (_, n) => data[4 * (rowOf(n) * width + (n % width)) + 1]);
  };
  const UNIT = `march, ${STEPS} steps`, draws = { [UNIT]: march(s, sigma, far) }, lit = {}, took = {};
  draws[UNIT]();
  for (const [name, scale, steps] of [['half resolution, 60 steps', 0.5, 60], [`${STEPS} steps`, 1, STEPS]]) {
    const node = godrays(s, far, scale, steps), got = await picture(node.getTextureNode()), way = `three GodraysNode, ${name}`;
    draws[way] = () => node.updateBefore({ renderer });
    lit[way] = got.map((x, n) => Math.min(1, (-100 * Math.log(1 - x)) / (DENSITY * metres[n])));
  }
  shadows.attach(s.scene, { renderer });
  const options = { extinction: sigma, anisotropy: 0, transmits: false, farMetres: far };
  const node = new FogNode(shadows, s.camera, vec4(0, 0, 0, 1), s.depth, options);
  lit['vxs FogNode'] = (await picture(node)).map((x, n) => (x * 4 * Math.PI) / (s.sun.intensity * (1 - Math.exp(-sigma * metres[n]))));
  draws['vxs FogNode'] = () => node.updateBefore({ renderer });
  const { gl } = renderer.backend, one = new Uint8Array(4);
  const finish = () => { // an answer of the graphics processor comes behind all that it was given to draw
    const bound = gl.getParameter(gl.READ_FRAMEBUFFER_BINDING);
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, one);
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, bound);
  };
  for (let n = 0; n < times; n++)
    for (const [name, draw] of Object.entries(draws)) {
      const began = performance.now();
      draw();
      finish();
      (took[name] ??= []).push(performance.now() - began);
    }
  if (gl.getError()) throw new Error('the graphics processor did not answer: there are no times');
  const median = (values) => values.sort((a, b) => a - b)[values.length >> 1];
  const ratioOf = (list) => median(list.map((ms, n) => ms / took[UNIT][n]));
  const each = (of, change) => Object.fromEntries(Object.entries(of).map(([name, values]) => [name, change(values)]));
  return { lit: each(lit, base64), ratio: each(took, ratioOf) };
}
