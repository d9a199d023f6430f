// What tests/bench/web_compare.mjs does inside a page: pictures of what light reaches each pixel, by ways of three.js to have shadows.
// Each exported function takes and returns plain data.
// SPDX-License-Identifier: GPL-3.0-or-later
import * as THREE from 'three';
import { FogPass } from 'vxs/three';
import { fit } from './web_compare_fit.mjs';
import { floats, loadScene, loadShadows, newCamera, newRenderer } from '/tests/three_page.mjs';

const base64 = (array) => {
  const bytes = new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
  let text = '';
  for (let n = 0; n < bytes.length; n += 0x8000) text += String.fromCharCode(...bytes.subarray(n, n + 0x8000));
  return btoa(text);
};

// White and matt; images stay where their alpha cuts holes.
function whiten(root) {
  const made = new Map();
  const white = (m) => new THREE.MeshLambertMaterial({ flatShading: true, side: m.side, alphaTest: m.alphaTest, map: m.alphaTest > 0 ? m.map : null });
  root.traverse((object) => {
    if (!object.isMesh) return;
    if (!made.has(object.material)) made.set(object.material, white(object.material));
    object.material = made.get(object.material);
    object.castShadow = object.receiveShadow = true;
    if (object.geometry.attributes.normal) return; // the normal bias of three.js needs normals: those of faces, as glTF says
    if (object.geometry.index) object.geometry = object.geometry.toNonIndexed();
    object.geometry.computeVertexNormals();
  });
  return [...made.values()];
}

/** The level, a camera, and a sun of that direction in place of the lights of the file. */
async function stage({ glb, sun, view, size }) {
  const renderer = newRenderer(size), scene = new THREE.Scene(), camera = newCamera(view, size);
  scene.add((await loadScene(glb)).scene);
  const lights = [], materials = whiten(scene);
  scene.traverse((object) => object.isLight && lights.push(object));
  const s = { renderer, scene, camera, lights, materials, size, bounds: new THREE.Box3().setFromObject(scene) };
  if (!sun) return s;
  lights.forEach((light) => light.removeFromParent());
  s.sun = new THREE.DirectionalLight(0xffffff, 3);
  s.sun.name = 'sun';
  s.sun.position.set(...sun).multiplyScalar(-1);
  scene.add(s.sun, s.sun.target);
  scene.updateMatrixWorld();
  return s;
}

const bytesOfTexel = (texture) => (texture.format === THREE.RedFormat || texture.type === THREE.UnsignedShortType ? texture.type === THREE.UnsignedByteType ? 1 : 2 : 4);
const bytesOf = (texture) => (texture ? (texture.image.length ?? 1) * texture.image.width * texture.image.height * bytesOfTexel(texture) : 0);

// The least error among normal biases of 0 to 3 texels is found by the caller: each is a try.
const BIASES = [0, 0.5, 1, 2, 3];

function pcf(side) {
  return async (s) => {
    const texel = fit(s, side);
    s.renderer.shadowMap.enabled = true;
    s.sun.castShadow = true;
    return {
      tries: BIASES.map((texels) => () => { s.sun.shadow.normalBias = texels * texel; }),
      bytes: () => bytesOf(s.sun.shadow.map.texture) + bytesOf(s.sun.shadow.map.depthTexture),
    };
  };
}

function csm(cascades, side) {
  return async (s, { sun, far }) => {
    const { CSM } = await import('three/addons/csm/CSM.js'), size = s.bounds.getSize(new THREE.Vector3()).length();
    s.sun.removeFromParent();
    s.renderer.shadowMap.enabled = true;
    const made = new CSM({
      maxFar: far, cascades, mode: 'practical', parent: s.scene, shadowMapSize: side, lightDirection: new THREE.Vector3(...sun).normalize(),
      camera: s.camera.clone(), lightIntensity: 3, lightMargin: size, lightFar: 3 * size,
    });
    s.materials.forEach((material) => made.setupMaterial(material));
    const place = (steps) => { // the camera that cascades follow: a step is 7 cm to the right, and 0.4 degrees about the vertical
      made.camera.position.copy(s.camera.position).addScaledVector(new THREE.Vector3(1, 0, 0).applyQuaternion(s.camera.quaternion), 0.07 * steps);
      made.camera.quaternion.setFromAxisAngle(new THREE.Vector3(0, 1, 0), (0.4 * steps * Math.PI) / 180).multiply(s.camera.quaternion);
      made.camera.updateMatrixWorld();
      made.update();
    };
    place(0);
    return {
      place,
      tries: BIASES.map((texels) => () => made.lights.forEach(({ shadow }) => { shadow.normalBias = (texels * (shadow.camera.right - shadow.camera.left)) / side; })),
      bytes: () => made.lights.reduce((sum, { shadow }) => sum + bytesOf(shadow.map.texture) + bytesOf(shadow.map.depthTexture), 0),
    };
  };
}

function baked(attach, side = 4096) {
  return async (s, { vxs }) => {
    const shadows = await loadShadows(vxs[side]), { matched } = shadows.attach(s.scene, { renderer: s.renderer, ...attach });
    if (matched.length !== 1 || matched[0].moved) throw new Error('the sun does not match the file');
    const { normalBias } = s.sun.shadow;
    return {
      tries: attach.way === 'depth' ? BIASES.map((texels) => () => { s.sun.shadow.normalBias = (texels / 1.5) * normalBias; }) : undefined,
      bytes: () => (attach.way === 'depth' ? bytesOf(s.sun.shadow.map.texture) : bytesOf(shadows.words.texture)),
    };
  };
}

async function lightmap(s, { lightmap: { url, side, triangles } }) {
  const read = async (what, Type) => new Type(await (await fetch(`${url}.${what}`)).arrayBuffer());
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(await read('positions', Float32Array), 3));
  geometry.setAttribute('uv', new THREE.BufferAttribute(await read('uvs', Uint16Array), 2, true));
  const map = new THREE.DataTexture(await read('texels', Uint8Array), side, side, THREE.RedFormat, THREE.UnsignedByteType);
  Object.assign(map, { minFilter: THREE.LinearFilter, magFilter: THREE.LinearFilter, unpackAlignment: 1, needsUpdate: true });
  const material = new THREE.MeshBasicMaterial({ map, side: THREE.DoubleSide });
  s.scene.clear();
  s.scene.add(new THREE.Mesh(geometry, material));
  return { isLit: true, bytes: () => side * side + 12 * triangles };
}

const WAYS = {
  'three PCF 2048': pcf(2048), 'three PCF 4096': pcf(4096), 'three CSM 4 x 2048': csm(4, 2048), 'vxs 4096, depth': baked({ way: 'depth' }),
  'vxs 4096, 1 x 1': baked({ filter: { box: 1 } }), 'vxs 4096, 3 x 3': baked({ filter: { box: 3 } }), 'vxs 16384, 1 x 1': baked({ filter: { box: 1 } }, 16384),
  'vxs 16384, 3 x 3': baked({ filter: { box: 3 } }, 16384), 'lightmap of the bytes of vxs 4096': lightmap, 'lightmap of the bytes of vxs 16384': lightmap,
};
export const names = () => Object.keys(WAYS);

/** World positions and normals of pixels, [8 * pixels]: x y z, distance along the ray (0: nothing is seen); normal, and light without shadow. */
export async function surfaces(scene) {
  const s = await stage(scene), [width, height] = s.size, out = new Float32Array(8 * width * height);
  const bare = floats(s.renderer, s.scene, s.camera);
  s.renderer.setClearAlpha(0);
  const seen = (text) => new THREE.ShaderMaterial({
    side: THREE.DoubleSide,
    vertexShader: 'out vec3 at; void main() { vec4 p = modelMatrix * vec4(position, 1.0); at = p.xyz; gl_Position = projectionMatrix * viewMatrix * p; }',
    fragmentShader: `in vec3 at; void main() { vec3 n = normalize(cross(dFdx(at), dFdy(at))); gl_FragColor = ${text}; }`,
  });
  const drawn = (text) => { // but for what an image cuts holes into
    const material = seen(text), nothing = seen('vec4(0.0)'), masked = new Set(s.materials.filter((m) => m.alphaTest > 0).concat(nothing));
    s.scene.traverse((object) => { if (object.isMesh) object.material = masked.has(object.material) ? nothing : material; });
    return floats(s.renderer, s.scene, s.camera);
  };
  const at = drawn('vec4(at, distance(at, cameraPosition))'), normal = drawn('vec4(n, 1.0)');
  for (let n = 0; n < width * height; n++) {
    out.set(at.subarray(4 * n, 4 * n + 4), 8 * n);
    out.set(normal.subarray(4 * n, 4 * n + 3), 8 * n + 4);
    out[8 * n + 7] = bare[4 * n + 1];
  }
  return base64(out);
}

/** Directions of the eye rays of pixels, and the metres to what is seen, [4 * pixels]; 0: nothing. */
export async function rays(scene) {
  const seen = decodeFloats(await surfaces(scene)), [width, height] = scene.size, camera = newCamera(scene.view, scene.size), out = new Float32Array(4 * width * height);
  for (let n = 0; n < width * height; n++) {
    const at = new THREE.Vector3(((n % width) + 0.5) / width * 2 - 1, 1 - ((Math.floor(n / width) + 0.5) / height) * 2, 0.5);
    at.unproject(camera).sub(camera.position).normalize().toArray(out, 4 * n);
    out[4 * n + 3] = seen[8 * n + 3];
  }
  return base64(out);
}

/** Corners of all triangles in world space, [9 * triangles]. */
export async function triangles(scene) {
  const s = await stage(scene), parts = [], corner = new THREE.Vector3();
  s.scene.traverse((object) => {
    if (!object.isMesh) return;
    const { index, attributes: { position } } = object.geometry, count = index?.count ?? position.count, out = new Float32Array(3 * count);
    for (let n = 0; n < count; n++) corner.fromBufferAttribute(position, index ? index.getX(n) : n).applyMatrix4(object.matrixWorld).toArray(out, 3 * n);
    parts.push(out);
  });
  const all = new Float32Array(parts.reduce((sum, part) => sum + part.length, 0));
  parts.reduce((at, part) => (all.set(part, at), at + part.length), 0);
  return base64(all);
}

/**
 * What one way lets through at each pixel, as bytes, for each of its tries; what a frame costs; and how much pixels change, on the mean,
 * from one step of a moving camera to the next: the picture is always of the first step.
 */
export async function litPixels({ way, far, ...scene }) {
  const s = await stage(scene), bare = floats(s.renderer, s.scene, s.camera), made = await WAYS[way](s, { far, ...scene });
  const draw = () => {
    const shaded = floats(s.renderer, s.scene, s.camera);
    return Float32Array.from({ length: bare.length / 4 }, (_, n) => (made.isLit ? shaded[4 * n] : bare[4 * n + 1] > 1e-4 ? shaded[4 * n + 1] / bare[4 * n + 1] : 0));
  };
  const tries = (made.tries ?? [() => 0]).map((set) => {
    set();
    return draw();
  });
  const { calls, triangles: drawn } = s.renderer.info.render, biases = made.tries && BIASES;
  let change = 0;
  if (made.place) {
    const steps = 6;
    made.tries[2]();
    for (let n = 0, last = draw(); n < steps; n++) {
      made.place(n + 1);
      const now = draw();
      change += now.reduce((sum, x, k) => sum + Math.abs(x - last[k]), 0) / now.length / steps;
      last = now;
    }
  }
  return { tries: tries.map((lit) => base64(Uint8Array.from(lit, (x) => Math.round(255 * Math.min(Math.max(x, 0), 1))))), calls, triangles: drawn, bytes: made.bytes(), change, biases };
}

/**
 * Many lamps at once: mean error of their light by each way, as a share of the mean light by rays, and a picture of each.
 * lit  url of bytes, [pixels][lamps]: 1 where rays reach the lamp;   live  lamps, the brightest here, that get live shadows of 512 texels
 */
export async function lamps({ lit: url, vxs, live, ...scene }) {
  const s = await stage(scene), lit = new Uint8Array(await (await fetch(url)).arrayBuffer()), pixels = s.size[0] * s.size[1];
  const truth = new Float32Array(pixels), power = [], only = (n) => s.lights.forEach((light, k) => { light.visible = n < 0 || k === n; });
  const light = () => floats(s.renderer, s.scene, s.camera).filter((_, n) => n % 4 === 1);
  s.lights.forEach((_, n) => {
    only(n);
    const own = light();
    power.push(own.reduce((a, b) => a + b, 0));
    own.forEach((x, k) => { truth[k] += x * lit[k * s.lights.length + n]; });
  });
  only(-1);
  const mean = truth.reduce((a, b) => a + b, 0) / pixels, ways = [];
  const add = (way, bytes) => {
    const got = light(), { calls, triangles: drawn } = s.renderer.info.render;
    const off = got.reduce((sum, x, n) => sum + Math.abs(x - truth[n]), 0) / pixels;
    ways.push({ way, error: off / mean, gpu_bytes: bytes(), draw_calls: calls, drawn_triangles: drawn, picture: shown(got) });
  };
  const shown = (values) => base64(Uint8Array.from(values, (x) => Math.round(255 * Math.min(1, (x / (4 * mean)) ** (1 / 2.2)))));
  add('three, no shadows', () => 0);
  const brightest = power.map((x, n) => [x, n]).sort((a, b) => b[0] - a[0]).slice(0, live).map(([, n]) => s.lights[n]);
  s.renderer.shadowMap.enabled = true;
  brightest.forEach((lamp) => {
    lamp.castShadow = true;
    lamp.shadow.mapSize.set(512, 512);
    Object.assign(lamp.shadow.camera, { near: 0.05, far: lamp.distance });
    lamp.shadow.normalBias = 0.02;
  });
  add(`three PCF, ${live} lamps of 512 x 512`, () => brightest.reduce((sum, { shadow }) => sum + bytesOf(shadow.map.texture) + bytesOf(shadow.map.depthTexture), 0));
  brightest.forEach((lamp) => { lamp.castShadow = false; });
  const shadows = await loadShadows(vxs), { matched } = shadows.attach(s.scene, { filter: { box: 3 } });
  add('vxs, 3 x 3', () => bytesOf(shadows.words.texture));
  return { lamps: s.lights.length, matched: matched.length, mean, truth: shown(truth), ways };
}

const MARCH = `uniform highp sampler2D tDepth; uniform highp sampler2DShadow map; uniform mat4 fromClip, toWorld, toLight; uniform float sigma, far; in vec2 at;
void main() {
  vec4 p = fromClip * vec4( 2.0 * at - 1.0, 2.0 * texture2D( tDepth, at ).r - 1.0, 1.0 );
  vec3 end = p.xyz / p.w, eye = toWorld[3].xyz, way = mat3( toWorld ) * normalize( end );
  float metres = min( length( end ), far ), sum = 0.0, whole = 0.0;
  for ( int n = 0; n < STEPS; n ++ ) {
    float t = metres * ( float( n ) + 0.5 ) / float( STEPS ), weight = exp( - sigma * t );
    vec4 l = toLight * vec4( eye + t * way, 1.0 );
    sum += weight * ( all( equal( clamp( l.xyz, 0.0, 1.0 ), l.xyz ) ) ? texture( map, l.xyz ) : 1.0 );
    whole += weight;
  }
  gl_FragColor = vec4( sum / whole );
}`;

/**
 * Fog of extinction sigma: how much of a ray's airlight is lit, at each pixel, by marching over a live map and by the lit intervals of a
 * file; and the time of a frame of each by that of a march of 128 steps.
 */
export async function fog({ vxs, sigma, far, steps, times, ...scene }) {
  const s = await stage(scene), [width, height] = s.size, shadows = await loadShadows(vxs);
  fit(s, 2048);
  s.renderer.shadowMap.enabled = true;
  s.sun.castShadow = true;
  const read = new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType, depthTexture: new THREE.DepthTexture(width, height, THREE.FloatType) });
  const write = new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType }), data = new Float32Array(4 * width * height);
  const black = new THREE.MeshBasicMaterial({ color: 0 });
  s.scene.traverse((object) => { if (object.isMesh) object.material = black; });
  s.renderer.setRenderTarget(read);
  s.renderer.render(s.scene, s.camera);
  const { map: { depthTexture }, matrix } = s.sun.shadow, screen = new THREE.Mesh(new THREE.PlaneGeometry(2, 2)), draws = {}, lit = {}, took = {};
  screen.frustumCulled = false;
  for (const count of steps) {
    const material = new THREE.ShaderMaterial({
      defines: { STEPS: count }, depthTest: false, fragmentShader: MARCH, vertexShader: 'out vec2 at; void main() { at = 0.5 * position.xy + 0.5; gl_Position = vec4( position.xy, 0.0, 1.0 ); }',
      uniforms: Object.fromEntries(Object.entries({
        tDepth: read.depthTexture, map: depthTexture, toLight: matrix, fromClip: s.camera.projectionMatrixInverse, toWorld: s.camera.matrixWorld, sigma, far,
      }).map(([name, value]) => [name, { value }])),
    });
    draws[`march, ${count} steps`] = () => {
      screen.material = material;
      s.renderer.setRenderTarget(write);
      s.renderer.render(screen, s.camera);
    };
  }
  s.sun.castShadow = false;
  shadows.attach(s.scene);
  const pass = new FogPass(shadows, s.camera, { extinction: sigma, anisotropy: 0, transmits: false, farMetres: far });
  const INTERVALS = { 'vxs intervals': false, 'vxs intervals, half resolution': true };
  for (const [name, half] of Object.entries(INTERVALS))
    draws[name] = () => {
      pass.half = half;
      pass.render(s.renderer, write, read);
    };
  for (let n = -1; n < times; n++) // in turn, so that what else this machine does slows all of them; the first compiles
    for (const [name, draw] of Object.entries(draws)) {
      const began = performance.now();
      draw();
      s.renderer.readRenderTargetPixels(write, 0, 0, width, height, data);
      if (n < 0) lit[name] = Float32Array.from({ length: width * height }, (_, k) => data[4 * ((height - 1 - Math.floor(k / width)) * width + (k % width))]);
      else (took[name] ??= []).push(performance.now() - began);
    }
  // airlight by that of a ray that is lit all along
  const surface = decodeFloats(await surfaces(scene));
  for (const name of Object.keys(INTERVALS))
    lit[name] = lit[name].map((x, n) => {
      const metres = surface[8 * n + 3] > 0 ? Math.min(surface[8 * n + 3], far) : far;
      return (x * 4 * Math.PI) / (s.sun.intensity * (1 - Math.exp(-sigma * metres)));
    });
  const median = (values) => values.sort((a, b) => a - b)[values.length >> 1], unit = median(took['march, 128 steps']);
  return { lit: Object.fromEntries(Object.entries(lit).map(([name, values]) => [name, base64(values)])), ratio: Object.fromEntries(Object.entries(took).map(([name, times]) => [name, median(times) / unit])) };
}

const decodeFloats = (text) => new Float32Array(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);

/** A PNG, base64, of bytes: grey, or red, green, blue. */
export async function picture({ bytes, size: [width, height], channels }) {
  const canvas = new OffscreenCanvas(width, height), context = canvas.getContext('2d'), image = context.createImageData(width, height);
  const from = Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0));
  for (let n = 0; n < width * height; n++)
    for (let k = 0; k < 4; k++) image.data[4 * n + k] = k === 3 ? 255 : from[channels === 3 ? 3 * n + k : n];
  context.putImageData(image, 0, 0);
  return base64(new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer()));
}
