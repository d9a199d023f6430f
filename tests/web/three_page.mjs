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

/** Remove all lights but one. */
function keepLight(gltf, name) {
  const others = [];
  gltf.scene.traverse((object) => object.isLight && object.name !== name && others.push(object));
  others.forEach((light) => light.removeFromParent());
}

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

/** Lights for baked lights that were given to the bake alone. */
async function addGiven(gltf, shadows) {
  const { lightOf } = await import('vxs/three'), { baked } = shadows.attach(gltf);
  shadows.detach();
  for (const light of baked) gltf.scene.add(lightOf(light));
}

/** What the light of a name lets through at each pixel: rendering with shadows by rendering without; NaN where it does not shine. */
export async function litPixels({ glb, vxs, view, size, light, attach = {}, material = 'MeshLambertMaterial', shown, options, type }) {
  const renderer = newRenderer(size, options), gltf = await loadScene(glb), shadows = await loadShadows(vxs), camera = newCamera(view, size);
  whiten(gltf.scene, THREE[material]);
  await addGiven(gltf, shadows);
  gltf.scene.traverse((object) => { if (object.isLight && light && object.name !== light) object.visible = false; });
  const bare = floats(renderer, gltf.scene, camera);
  if (type) renderer.shadowMap.type = THREE[type];
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

/** A level by ranges: pictures of the whole file, of a stream before and after its pages came, and what its frames did. */
export async function streamed({ glb, vxs, view, size, light }) {
  const gltf = await loadScene(glb), camera = newCamera(view, size), renderer = newRenderer(size), whole = await loadShadows(vxs);
  whiten(gltf.scene);
  gltf.scene.traverse((object) => { if (object.isLight && object.name !== light) object.visible = false; });
  const picture = () => floats(renderer, gltf.scene, camera);
  whole.attach(gltf);
  const wanted = picture();
  whole.dispose();
  const shadows = await new VXSLoader().streamAsync(vxs, { budgetBytes: 64 << 20 }), begin = performance.now();
  shadows.attach(gltf);
  const before = picture();
  let frames = 0, appeared = 0, status;
  do {
    status = shadows.frame([{ position: [0, 0, 0], radius: 1000 }]);
    appeared += status.appeared;
    frames++;
    picture(); // uploads what came
    await new Promise((resolve) => { setTimeout(resolve, 5); });
  } while ((status.pagesMissing || frames < 3) && performance.now() - begin < 60000);
  const after = picture();
  shadows.dispose();
  return { frames, appeared, missing: status.pagesMissing, before: differ(before, wanted, 1e-3), after: differ(after, wanted, 1e-6) };
}

const differ = (a, b, limit) => a.reduce((count, x, n) => count + (Math.abs(x - b[n]) > limit ? 1 : 0), 0) / a.length;

/** The scene far from the origin: the share of pixels that differ from the scene where it was baked. */
export async function farAway({ glb, vxs, view, size, light, offset }) {
  const pictures = [];
  for (const at of [[0, 0, 0], offset]) {
    const renderer = newRenderer(size), gltf = await loadScene(glb), shadows = await loadShadows(vxs);
    const camera = newCamera({ ...view, eye: view.eye.map((x, n) => x + at[n]), target: view.target.map((x, n) => x + at[n]) }, size);
    whiten(gltf.scene);
    gltf.scene.traverse((object) => { if (object.isLight && object.name !== light) object.visible = false; });
    gltf.scene.position.set(...at);
    shadows.attach(gltf);
    pictures.push(floats(renderer, gltf.scene, camera));
    shadows.dispose();
    renderer.dispose();
  }
  return { differ: differ(pictures[0], pictures[1], 1e-3), mean: pictures[0].reduce((s, x) => s + x, 0) / pictures[0].length };
}

/** Voxels of a file: how many answers of a shader differ from those of the runtime, of how many; and how many are not all or nothing. */
export async function voxels({ vxs, light: name, width, smooth = false, side = 64 }) {
  const { readers } = await import('/vxs/three/text.mjs'), { commonMacros, wordsTexture, writeConstants, integerTexture } = await import('/vxs/three/words.mjs');
  const renderer = newRenderer([side, side]), shadows = await loadShadows(vxs), light = shadows.lights.find((l) => l.name === name);
  const words = wordsTexture(shadows.lights), constants = new Uint32Array(24), count = side * side;
  writeConstants(constants, 0, light, light.constants(), words.first.get(light), new THREE.Vector3(), new THREE.Matrix4());
  // texels everywhere, depths about the first shadow of the texel, where answers are neither all lit nor all dark
  let seed = 1;
  const random = (below) => { seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0; return Math.floor((seed / 2 ** 32) * below); };
  const at = new Uint32Array(4 * count);
  for (let n = 0; n < count; n++) {
    const map = random(light.maps), i = random(light.resolution), j = random(light.resolution);
    const k = Math.min(Math.max(light.firstShadow(map, i, j) + random(9) - 4, 0), light.resolution - 1);
    at.set([i, j, k, map], 4 * n);
  }
  const material = new THREE.RawShaderMaterial({
    glslVersion: THREE.GLSL3,
    uniforms: { vxsWords: { value: words.texture }, vxsLights: { value: integerTexture(constants, 6, 1, 4) }, voxels: { value: integerTexture(at, side, side, 4) } },
    vertexShader: 'in vec3 position; void main() { gl_Position = vec4( position.xy * 2.0, 0.0, 1.0 ); }',
    fragmentShader: `precision highp float; precision highp int; uniform highp usampler2D voxels; out vec4 lit;
      ${readers(commonMacros([light], { width, smooth }), words.wide)}
      void main() {
        ivec4 at = ivec4( texelFetch( voxels, ivec2( gl_FragCoord.xy ), 0 ) );
        vxs_light_constants light = vxsLight( 0 );

        lit = vec4( vxs_lit_at_voxel( light.first_word, light, at.w, at.xyz, vxs_box( 1 ) ) );
      }`,
  });
  const scene = new THREE.Mesh(new THREE.PlaneGeometry(), material);
  scene.frustumCulled = false;
  const lit = floats(renderer, scene, new THREE.Camera());
  // compared as sums of texels, or of weights of 1/65536 texel, where a float has a unit more or less after a shader's division
  const sums = (value) => Math.round(value * width * width * (smooth ? 65536 : 1)), least = smooth ? 2 : 0;
  let wrong = 0, partial = 0, outside = 0;
  for (let n = 0; n < count; n++) {
    const [i, j, k, map] = at.subarray(4 * n), row = side - 1 - Math.floor(n / side);
    const point = light.point(map, [i + 0.501, j + 0.501, k + 0.5]), filter = smooth ? { smooth: width } : { box: width };
    const wanted = light.lookup(point, { filter }), got = lit[4 * (row * side + (n % side))];
    if (wanted < 0 || light.voxel(point).map !== map) outside++; // beyond the cone, or beside the face of a cube
    else if (Math.abs(sums(wanted) - sums(got)) > least) wrong++;
    if (wanted > 0 && wanted < 1) partial++;
  }
  renderer.dispose();
  renderer.forceContextLoss(); // a page may have 16
  return { wrong, partial, outside, count };
}

/** All lights in one rendering against the sum of renderings of some lights at a time: the greatest difference, and uniforms. */
export async function manyLights({ glb, vxs, view, size, group = 33, live }) {
  const renderer = newRenderer(size), gltf = await loadScene(glb), shadows = await loadShadows(vxs), camera = newCamera(view, size);
  whiten(gltf.scene, THREE.MeshStandardMaterial);
  const lights = [];
  if (live) { // a lamp with a live shadow, which three.js has before the others
    const lamp = new THREE.PointLight(0xffffff, 20);
    lamp.position.set(-5, 3, 5);
    lamp.castShadow = renderer.shadowMap.enabled = true;
    gltf.scene.add(lamp);
  }
  gltf.scene.traverse((object) => object.isLight && lights.push(object));
  const match = shadows.attach(gltf, { filter: { box: 3 } });
  const draw = (chosen) => {
    lights.forEach((light, n) => { light.visible = chosen(n); });
    return floats(renderer, gltf.scene, camera);
  };
  const all = draw(() => true), sum = new Float32Array(all.length);
  for (let first = 0; first < lights.length; first += group)
    draw((n) => n >= first && n < first + group).forEach((x, n) => { sum[n] += x; });
  shadows.detach();
  const bare = draw(() => true);
  shadows.dispose();
  renderer.dispose();
  return {
    lights: lights.length, matched: match.matched.length, vectors: renderer.getContext().getParameter(0x8dfd),
    apart: all.reduce((most, x, n) => (n % 4 === 3 ? most : Math.max(most, Math.abs(x - sum[n]))), 0),
    mean: all.reduce((s, x) => s + x, 0) / all.length, bare: bare.reduce((s, x) => s + x, 0) / all.length,
  };
}

const KINDS_OF_MESH = {
  mesh: (geometry, material) => new THREE.Mesh(geometry, material),
  instanced: (geometry, material) => {
    const mesh = new THREE.InstancedMesh(geometry, material, 2);
    mesh.setMatrixAt(0, new THREE.Matrix4());
    mesh.setMatrixAt(1, new THREE.Matrix4().makeTranslation(0, -100, 0));
    return mesh;
  },
  skinned: (geometry, material) => { // a bone moves it up to where the others are
    const count = geometry.attributes.position.count, own = geometry.clone().translate(0, -3, 0), bone = new THREE.Bone();
    own.setAttribute('skinIndex', new THREE.Uint16BufferAttribute(new Uint16Array(4 * count), 4));
    own.setAttribute('skinWeight', new THREE.Float32BufferAttribute(Float32Array.from({ length: 4 * count }, (_, n) => (n % 4 ? 0 : 1)), 4));
    const mesh = new THREE.SkinnedMesh(own, material);
    mesh.add(bone);
    mesh.bind(new THREE.Skeleton([bone]));
    bone.position.y = 3;
    mesh.frustumCulled = false;
    return mesh;
  },
  morphed: (geometry, material) => {
    const own = geometry.clone().translate(0, -2, 0);
    own.morphAttributes.position = [geometry.attributes.position.clone()];
    const mesh = new THREE.Mesh(own, material);
    mesh.morphTargetInfluences = [1];
    mesh.frustumCulled = false;
    return mesh;
  },
};

/** A wall across the pillars as each kind of mesh, in each kind of material: the share of pixels whose lit part differs from Lambert's. */
export async function kinds({ glb, vxs, view, size }) {
  const renderer = newRenderer(size), camera = newCamera(view, size), out = {};
  const shadows = await loadShadows(vxs), gltf = await loadScene(glb);
  gltf.scene.traverse((object) => { if (object.isLight && object.name !== 'sun') object.visible = false; });
  const geometry = new THREE.PlaneGeometry(14, 14).rotateX(-Math.PI / 2).translate(0, 0.2, 0);
  const materials = {
    Lambert: new THREE.MeshLambertMaterial(), Standard: new THREE.MeshStandardMaterial({ roughness: 1 }), Phong: new THREE.MeshPhongMaterial({ shininess: 5 }),
    Physical: new THREE.MeshPhysicalMaterial({ roughness: 1, clearcoat: 0.5, clearcoatRoughness: 1, sheen: 0.3 }), Toon: new THREE.MeshToonMaterial(),
    flat: new THREE.MeshStandardMaterial({ roughness: 1, flatShading: true }), transparent: new THREE.MeshLambertMaterial({ transparent: true, side: THREE.DoubleSide }),
  };
  gltf.scene.traverse((object) => { if (object.isMesh) object.visible = false; });
  const litOf = (mesh) => {
    gltf.scene.add(mesh);
    const bare = floats(renderer, gltf.scene, camera);
    shadows.attach(gltf);
    const shaded = floats(renderer, gltf.scene, camera);
    shadows.detach();
    gltf.scene.remove(mesh);
    return Float32Array.from({ length: bare.length / 4 }, (_, n) => (bare[4 * n] > 1e-3 ? shaded[4 * n] / bare[4 * n] : 0));
  };
  const wanted = litOf(new THREE.Mesh(geometry, materials.Lambert));
  for (const [name, material] of Object.entries(materials))
    for (const [kind, make] of Object.entries(KINDS_OF_MESH))
      if (kind === 'mesh' || name === 'Standard') out[`${name} ${kind}`] = differ(litOf(make(geometry, material)), wanted, 2e-3);
  shadows.dispose();
  renderer.dispose();
  return { out, dark: wanted.filter((x) => x === 0).length / wanted.length, lit: wanted.filter((x) => x > 0.99).length / wanted.length };
}

/** A ball that moves above the floor: calls of a frame, and pixels that its live shadow changes. */
export async function moving({ glb, vxs, view, size }) {
  const renderer = newRenderer(size), camera = newCamera(view, size), shadows = await loadShadows(vxs), gltf = await loadScene(glb);
  renderer.shadowMap.enabled = true;
  const ball = new THREE.Mesh(new THREE.SphereGeometry(0.5), new THREE.MeshStandardMaterial());
  ball.position.set(4, 1.2, 4);
  const sun = gltf.scene.getObjectByName('sun');
  gltf.scene.traverse((object) => { if (object.isLight && object !== sun) object.visible = false; });
  whiten(gltf.scene);
  const before = { castShadow: sun.castShadow, right: sun.shadow.camera.right };
  shadows.attach(gltf);
  const still = floats(renderer, gltf.scene, camera), stillCalls = renderer.info.render.calls;
  gltf.scene.add(ball);
  shadows.attach(gltf, { movers: [ball], renderer });
  sun.shadow.mapSize.set(2048, 2048);
  const moved = floats(renderer, gltf.scene, camera), calls = renderer.info.render.calls;
  ball.castShadow = false;
  const flying = floats(renderer, gltf.scene, camera);
  let onlyDarker = true, changed = 0, byBall = 0;
  for (let n = 0; n < still.length; n += 4) {
    if (flying[n] !== still[n]) byBall++; // the ball itself
    else if (moved[n] !== still[n]) {
      changed++;
      onlyDarker &&= moved[n] < still[n];
    }
  }
  const cast = gltf.scene.children.filter((object) => object.castShadow).length;
  shadows.dispose();
  return { stillCalls, calls, changed, byBall, onlyDarker, cast, restored: sun.castShadow === before.castShadow && sun.shadow.camera.right === before.right };
}

/** Hooks of a user on a material stay, before and after. */
export async function chained({ glb, vxs, view, size }) {
  const renderer = newRenderer(size), camera = newCamera(view, size), shadows = await loadShadows(vxs), gltf = await loadScene(glb);
  const material = whiten(gltf.scene), other = new THREE.MeshLambertMaterial({ flatShading: true }), calls = [];
  const own = function (shader) {
    calls.push('compile');
    shader.uniforms.tint = { value: new THREE.Color(1, 0, 0) };
    shader.fragmentShader = `uniform vec3 tint;\n${shader.fragmentShader.replace('#include <opaque_fragment>', '#include <opaque_fragment>\ngl_FragColor.rgb *= tint;')}`;
  };
  material.onBeforeCompile = own;
  const mean = (channel) => floats(renderer, gltf.scene, camera).reduce((sum, x, n) => sum + (n % 4 === channel ? x : 0), 0);
  const bare = [mean(0), mean(1)], key = material.customProgramCacheKey();
  shadows.attach(gltf);
  const meshes = [];
  gltf.scene.traverse((object) => object.isMesh && meshes.push(object));
  const shaded = [mean(0), mean(1)];
  meshes.forEach((mesh) => { mesh.material = other; });
  shadows.add(gltf.scene);
  const untinted = [mean(0), mean(1)];
  meshes.forEach((mesh) => { mesh.material = material; });
  shadows.detach();
  const restored = material.onBeforeCompile === own && material.customProgramCacheKey() === key && !Object.hasOwn(other, 'onBeforeCompile');
  const again = [mean(0), mean(1)];
  shadows.attach(gltf);
  const shadedAgain = [mean(0), mean(1)];
  shadows.dispose();
  return { bare, shaded, untinted, again, shadedAgain, restored };
}

/** Load, attach, draw and dispose again and again: what stays. */
export async function leaks({ glb, vxs, times, way }) {
  const renderer = newRenderer([16, 16]), camera = newCamera({ eye: [9, 9, 9], target: [0, 0, 0] }, [16, 16]), gltf = await loadScene(glb);
  const { load } = await import('vxs'), runtime = await load();
  const loader = new VXSLoader().setRuntime(runtime), bytes = await (await fetch(vxs)).arrayBuffer();
  keepLight(gltf, 'sun');
  const turn = async () => {
    const shadows = await loader.parseAsync(bytes);
    shadows.attach(gltf, { way, renderer, resolution: 64 });
    renderer.render(gltf.scene, camera);
    const during = renderer.info.memory.textures;
    shadows.dispose();
    renderer.render(gltf.scene, camera);
    return during;
  };
  const state = () => ({ ...renderer.info.memory, programs: renderer.info.programs.length, bytes: runtime.memoryBytes });
  for (let n = 0; n < 3; n++) await turn();
  const before = state();
  let during;
  for (let n = 0; n < times; n++) during = await turn();
  return { before, after: state(), during };
}

/** The context is lost and comes back: the picture is the same. */
export async function lost({ glb, vxs, view, size, attach }) {
  const renderer = newRenderer(size), camera = newCamera(view, size), shadows = await loadShadows(vxs), gltf = await loadScene(glb);
  keepLight(gltf, 'sun');
  whiten(gltf.scene);
  shadows.attach(gltf, { renderer, ...attach });
  const before = floats(renderer, gltf.scene, camera), { domElement } = renderer;
  const event = (name) => new Promise((resolve) => domElement.addEventListener(name, resolve, { once: true }));
  const gone = event('webglcontextlost'), back = event('webglcontextrestored');
  renderer.forceContextLoss();
  await gone;
  await new Promise((resolve) => setTimeout(resolve, 100));
  renderer.forceContextRestore();
  await back;
  const after = floats(renderer, gltf.scene, camera);
  return { differ: differ(before, after, 0), mean: before.reduce((s, x) => s + x, 0) / before.length };
}

/** Damaged files, wrong options: errors, and the scene as it was. */
export async function refused({ glb, vxs }) {
  const renderer = newRenderer([16, 16]), gltf = await loadScene(glb), bytes = new Uint8Array(await (await fetch(vxs)).arrayBuffer()), out = {};
  const mesh = gltf.scene.getObjectByProperty('isMesh', true), sun = gltf.scene.getObjectByName('sun');
  const seen = () => JSON.stringify([mesh.receiveShadow, mesh.castShadow, sun.castShadow, sun.shadow.map, Object.keys(mesh.material).length, mesh.material.userData]);
  const before = seen(), { VXSError } = await import('vxs/three');
  const attempt = async (name, act) => {
    try {
      await act();
      out[name] = 'no error';
    } catch (error) {
      out[name] = `${error instanceof VXSError} ${error.code} ${error.finding ?? ''} ${error.message}`;
    }
    if (seen() !== before) out[name] += ': the scene has changed';
  };
  const loader = new VXSLoader(), shadows = await loader.parseAsync(bytes);
  const damaged = bytes.slice();
  damaged[bytes.length >> 1] ^= 255;
  await attempt('damaged', () => loader.parseAsync(damaged));
  await attempt('truncated', () => loader.parseAsync(bytes.subarray(0, 100)));
  await attempt('empty', () => loader.parseAsync(new Uint8Array(0)));
  await attempt('missing', () => loader.loadAsync('/files/nothing.vxs'));
  await attempt('way', () => shadows.attach(gltf, { way: 'magic' }));
  await attempt('filter', () => shadows.attach(gltf, { filter: { box: 4 } }));
  await attempt('renderer', () => shadows.attach(gltf, { way: 'depth' }));
  renderer.shadowMap.type = THREE.VSMShadowMap;
  await attempt('vsm', () => shadows.attach(gltf, { way: 'depth', renderer }));
  gltf.scene.scale.setScalar(2);
  await attempt('scaled', () => shadows.attach(gltf));
  gltf.scene.scale.setScalar(1);
  const other = await loader.parseAsync(bytes);
  other.attach(gltf);
  await attempt('before detach', () => 0);
  out.twice = await Promise.resolve().then(() => shadows.attach(gltf)).catch((error) => error.message);
  other.detach();
  await attempt('after detach', () => 0);
  shadows.dispose();
  return out;
}

/** Airlight of pixels by FogPass, and by lit intervals of the runtime with a sum over many small steps. */
export async function fog({ glb, vxs, view, size, light: name, medium, orthographic, half }) {
  const { FogPass } = await import('vxs/three'), [width, height] = size;
  const renderer = newRenderer(size), gltf = await loadScene(glb), shadows = await loadShadows(vxs);
  let camera = newCamera(view, size);
  if (orthographic) {
    const { position, quaternion } = camera;
    camera = new THREE.OrthographicCamera(-8, 8, 6, -6, 0.1, 60);
    camera.position.copy(position);
    camera.quaternion.copy(quaternion);
  }
  shadows.attach(gltf);
  const { light, baked } = shadows.pairs.find((pair) => pair.baked.name === name);
  light.penumbra = 0; // three.js and glTF fade in different ways
  const target = () => new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType });
  const read = target(), write = target(), data = new Float32Array(4 * width * height);
  read.depthTexture = new THREE.DepthTexture(width, height, THREE.UnsignedIntType);
  const draw = (pass) => {
    renderer.setRenderTarget(read);
    renderer.render(gltf.scene, camera);
    pass.render(renderer, write, read);
    renderer.readRenderTargetPixels(write, 0, 0, width, height, data);
    renderer.setRenderTarget(null);
  };
  gltf.scene.traverse((object) => { if (object.isMesh) object.material = new THREE.MeshBasicMaterial({ color: 0 }); });
  const pass = new FogPass(shadows, camera, { light: name, ...medium });
  draw(pass);

  const caster = new THREE.Raycaster(), { extinction, scattering, anisotropy: g } = medium, errors = [];
  const { position, direction: axis } = (await import('/vxs/three/names.mjs')).placeOf(baked);
  const phase = (cosine) => (1 - g * g) / (4 * Math.PI * (1 + g * g - 2 * g * cosine) ** 1.5);
  const strength = light.intensity, range = baked.rangeMetres;
  gltf.scene.traverse((object) => { if (object.isMesh) object.material.side = THREE.DoubleSide; });
  for (let y = 3; y < height; y += 7)
    for (let x = 2; x < width; x += 9) {
      caster.setFromCamera(new THREE.Vector2((2 * x + 1) / width - 1, (2 * y + 1) / height - 1), camera);
      const { origin, direction } = caster.ray, hit = caster.intersectObject(gltf.scene, true)[0];
      const eye = orthographic ? origin : camera.position, metres = hit ? hit.point.distanceTo(eye) : camera.far;
      let sum = 0;
      for (const { begin, end, state } of baked.intervals(eye.toArray(), direction.toArray(), 0, metres)) {
        if (state === 'shadow' || (state === 'outside' && baked.kind !== 'directional')) continue;
        const last = Math.min(end, begin + 40 / extinction), steps = 4000;
        for (let n = 0; n < steps; n++) {
          const t = begin + ((n + 0.5) / steps) * (last - begin), dt = (last - begin) / steps;
          const at = eye.clone().addScaledVector(direction, t), to = at.clone().sub(position), r = to.length();
          if (baked.kind === 'directional') sum += phase(-direction.dot(axis)) * Math.exp(-extinction * t) * dt;
          else if (!range || r < range) sum += (phase(-direction.dot(to) / r) * Math.exp(-extinction * (t + r)) * (range ? 1 - (r / range) ** 4 : 1) * dt) / (r * r);
        }
      }
      errors.push([sum * scattering * strength, data[4 * (y * width + x) + 1], x, y]);
    }
  pass.half = half;
  if (half) draw(pass);
  const apart = errors.reduce((s, [a, , x, y]) => s + Math.abs(a - data[4 * (y * width + x) + 1]), 0) / errors.reduce((s, [a]) => s + a, 0);
  const wrong = errors.filter(([a, b]) => Math.abs(a - b) > 0.003 * (a + 0.02 * strength * scattering));
  pass.renderToScreen = true;
  gltf.scene.traverse((object) => { if (object.isMesh) object.material = new THREE.MeshStandardMaterial({ flatShading: true }); });
  draw(pass);
  return { count: errors.length, mean: errors.reduce((s, [a]) => s + a, 0) / errors.length, wrong: wrong.length, apart, tables: pass.fog.words.isTables === true, first: wrong.slice(0, 4) };
}

/** Fog of a light over a black scene: one channel of each pixel, rows from the top. */
export async function fogPicture({ glb, vxs, view, size: [width, height], light, medium }) {
  const { FogPass } = await import('vxs/three'), renderer = newRenderer([width, height]), gltf = await loadScene(glb), shadows = await loadShadows(vxs);
  const camera = newCamera(view, [width, height]), data = new Float32Array(4 * width * height);
  gltf.scene.traverse((object) => { if (object.isMesh) object.material = new THREE.MeshBasicMaterial({ color: 0 }); });
  shadows.attach(gltf);
  const [read, write] = [0, 1].map(() => new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType }));
  read.depthTexture = new THREE.DepthTexture(width, height, THREE.UnsignedIntType);
  renderer.setRenderTarget(read);
  renderer.render(gltf.scene, camera);
  new FogPass(shadows, camera, { light, ...medium }).render(renderer, write, read);
  renderer.readRenderTargetPixels(write, 0, 0, width, height, data);
  return Array.from({ length: width * height }, (_, n) => data[4 * ((height - 1 - Math.floor(n / width)) * width + (n % width)) + 1]);
}

/** Lights of the shadows that a glTF file brings along, and how many match. */
export async function fromGltf(url) {
  const { VXSShadowsPlugin } = await import('vxs/three');
  const gltf = await new GLTFLoader().register((parser) => new VXSShadowsPlugin(parser)).loadAsync(url);
  if (!gltf.shadows) return { lights: null };
  const { matched } = gltf.shadows.attach(gltf), lights = gltf.shadows.lights.length;
  gltf.shadows.dispose();
  return { lights, matched: matched.length };
}

/** Points of surfaces at some pixels, their normals, and what a shader's single tap says of them. */
export async function points({ every = 5, ...what }) {
  const { lit } = await litPixels({ ...what, attach: { filter: { box: 1 } } }), [width, height] = what.size;
  const gltf = await loadScene(what.glb), camera = newCamera(what.view, what.size), caster = new THREE.Raycaster(), out = [];
  gltf.scene.updateMatrixWorld();
  for (let y = 2; y < height; y += every)
    for (let x = 2; x < width; x += every) {
      const value = lit[y * width + x];
      if (Number.isNaN(value)) continue;
      caster.setFromCamera(new THREE.Vector2((2 * x + 1) / width - 1, 1 - (2 * y + 1) / height), camera);
      const [hit] = caster.intersectObject(gltf.scene, true);
      if (hit) out.push([...hit.point.toArray(), ...hit.face.normal.transformDirection(hit.object.matrixWorld).toArray(), value]);
    }
  return out;
}

/** What a LoadingManager hears of a file, of a damaged one and of none. */
export async function managed({ vxs }) {
  const { VXSError } = await import('vxs/three'), heard = [], manager = new THREE.LoadingManager();
  const bytes = new Uint8Array(await (await fetch(vxs)).arrayBuffer());
  const damaged = URL.createObjectURL(new Blob([bytes.subarray(0, bytes.length - 9)]));
  for (const url of [vxs, damaged, '/files/nothing.vxs']) {
    let end;
    const done = new Promise((resolve) => { end = resolve; });
    manager.onLoad = () => { heard.push('all'); end(); };
    manager.onError = () => heard.push('failed');
    new VXSLoader(manager).load(url, (shadows) => { heard.push(`${shadows.lights.length} lights`); shadows.dispose(); }, undefined,
      (error) => heard.push(error instanceof VXSError ? error.code : 'no file'));
    await done;
  }
  return heard;
}

/** Names and places: which baked light is whose. */
export async function matching() {
  const { matchLights } = await import('/vxs/three/names.mjs'), root = new THREE.Group();
  const lamp = (name, at) => ({ name, kind: 'point', matrix: Float64Array.of(1, 0, 0, -at[0], 0, 1, 0, -at[1], 0, 0, 1, -at[2]) });
  const sun = { name: 'sun', kind: 'directional', matrix: Float64Array.of(9, 0, 0, 0, 0, 0, 9, 0, 0, -9, 0, 0) };
  const add = (light, name, at, userData = {}) => root.add(Object.assign(light, { name, userData })) && light.position.set(...at);
  add(new THREE.PointLight(), 'lamp_1', [5, 1, 0], { name: 'lamp' });
  add(new THREE.PointLight(), 'lamp', [0, 1, 0], { name: 'lamp' });
  add(new THREE.PointLight(), 'My_Lamp', [0, 0, 7]);
  add(new THREE.PointLight(), '', [3, 3, 3]);
  add(new THREE.PointLight(), 'moved', [1, 2, 4]);
  add(new THREE.PointLight(), 'live', [8, 8, 8]);
  add(new THREE.SpotLight(), 'sun', [0, 9, 0]); // another kind
  const baked = [lamp('lamp', [0, 1, 0]), lamp('lamp#2', [5, 1, 0]), lamp('My Lamp', [0, 0, 7]), lamp('light3', [3, 3, 3]), lamp('moved', [1, 2, 3]), sun];
  const match = matchLights(baked, root, new THREE.Matrix4());
  return {
    matched: match.matched.map(({ light, baked: b, moved }) => [light.name, b.name, moved]).sort(), lights: match.lights.map((l) => l.name), baked: match.baked.map((b) => b.name),
  };
}
