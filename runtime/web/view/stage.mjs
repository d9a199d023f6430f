// Drawing a level: its scene with baked shadows, and beside it the same scene with live shadow maps or none.
// SPDX-License-Identifier: MIT
import {
  ACESFilmicToneMapping,
  Box3,
  Color,
  DirectionalLight,
  FloatType,
  Matrix4,
  PCFShadowMap,
  PerspectiveCamera,
  PointLight,
  Scene,
  SpotLight,
  Vector2,
  Vector3,
  WebGLRenderTarget,
  WebGLRenderer,
} from 'three';
import { clone } from 'three/addons/utils/SkeletonUtils.js';
import { Backdrop } from './backdrop.mjs';
import { Fog } from './fog.mjs';

export const LIVE_SIDE_PX = 2048;
/** Lights that can have live shadow maps at once: each needs one of the 16 textures of a material. */
export const LIVE_LIGHTS = 4;

const meshesBelow = (root) => {
  const found = [];
  root.traverse((object) => object.isMesh && found.push(object));
  return found;
};

const isPlain = (material, gltf) => material.userData.vxs_plain || !gltf.parser.associations.get(material);

/** A light that a baked one describes, for lights that were given to the bake alone. */
function lightOf(baked) {
  const row = (n) => new Vector3(...baked.matrix.subarray(4 * n, 4 * n + 3));
  const light =
    baked.kind === 'directional'
      ? new DirectionalLight(0xfff4e5, 3)
      : baked.kind === 'spot'
        ? new SpotLight(0xfff4e5, 100, 0, Math.acos(Math.max(-1, baked.cosOuter)), 0.2)
        : new PointLight(0xfff4e5, 100);
  light.name = baked.name;
  if (baked.kind !== 'directional')
    for (const n of [0, 1, 2]) light.position.addScaledVector(row(n), -baked.matrix[4 * n + 3]);
  if (light.target) light.add(light.target);
  light.target?.position.copy(row(2).normalize());
  return light;
}

/** A copy of a light at its place in the world, whose shadow camera fits a box. */
function liveTwin(light, bounds) {
  const twin = new light.constructor(light.color, light.intensity),
    diameter = bounds.getSize(new Vector3()).length();
  const place = new Vector3().setFromMatrixPosition(light.matrixWorld),
    { shadow } = twin;
  twin.position.copy(place);
  for (const name of ['distance', 'decay', 'angle', 'penumbra']) if (name in light) twin[name] = light[name];
  shadow.mapSize.setScalar(LIVE_SIDE_PX);
  if (light.target) {
    const towards = new Vector3().setFromMatrixPosition(light.target.matrixWorld).sub(place).normalize();
    if (light.isDirectionalLight)
      place.copy(bounds.getCenter(new Vector3())).addScaledVector(towards, -0.5 * diameter);
    twin.position.copy(place);
    twin.target.position.copy(place).add(towards);
  }
  shadow.camera.far = light.distance || diameter;
  shadow.camera.near = light.isDirectionalLight ? 0 : Math.max(0.02, shadow.camera.far / 2000);
  if (!light.isDirectionalLight) {
    shadow.normalBias = 0.02;
    return twin;
  }
  // as tight a box as there is around the corners
  const view = new Matrix4()
    .lookAt(twin.position, twin.target.position, twin.up)
    .setPosition(twin.position)
    .invert();
  const fit = new Box3().copy(bounds).applyMatrix4(view),
    { camera } = shadow;
  Object.assign(camera, {
    left: fit.min.x,
    right: fit.max.x,
    bottom: fit.min.y,
    top: fit.max.y,
    near: Math.min(0, -fit.max.z),
    far: -fit.min.z,
  });
  camera.updateProjectionMatrix();
  shadow.normalBias = (1.5 * Math.max(fit.max.x - fit.min.x, fit.max.y - fit.min.y)) / LIVE_SIDE_PX;
  return twin;
}

export class Stage {
  constructor(canvas) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: 'high-performance' });
    Object.assign(this.renderer, { toneMapping: ACESFilmicToneMapping, autoClear: false });
    Object.assign(this.renderer.shadowMap, { enabled: true, type: PCFShadowMap });
    this.renderer.info.autoReset = false;
    this.camera = new PerspectiveCamera(45, 1, 0.1, 1000);
    this.backdrop = new Backdrop(this.renderer);
    this.fog = new Fog(this.renderer, this.camera);
    this.marks = new Scene(); // drawn over both halves
    this.compare = null; // null, 'live', 'none'
    this.split = 0.5; // where the line is, of the width
    this.exposureStops = 0;
    this.skyShare = 0.5;
    this.#clear();
  }

  #clear() {
    this.scene = new Scene();
    this.beside = null;
    this.shadows = null;
    this.lights = []; // { light, twin, baked, on }
    this.twins = null;
    this.bounds = new Box3();
    this.direct = this.exposure = 1;
  }

  /** Show a scene. shadows: BakedShadows, or null. Returns what attach() returns, with the lights that were added. */
  show(root, gltf, shadows) {
    const before = this.scene,
      target = { scene: root, parser: gltf.parser };
    this.shadows?.dispose();
    before.traverse((object) => object.geometry?.dispose());
    this.#clear();
    this.root = root;
    this.shadows = shadows;
    this.scene.add(root);
    root.updateWorldMatrix(true, true);
    for (const mesh of meshesBelow(root)) {
      // glTF's material of a mesh without one is a white metal, that of `vxs scene` white: this is plaster instead
      for (const material of [mesh.material].flat())
        if (isPlain(material, gltf) && material.isMeshStandardMaterial)
          Object.assign(material, { metalness: 0, roughness: 0.9, color: new Color(0.78, 0.65, 0.49) });
      if (mesh.isSkinnedMesh) mesh.frustumCulled = false;
    }
    this.bounds.setFromObject(root, false);
    if (this.bounds.isEmpty()) this.bounds.set(new Vector3(-1, -1, -1), new Vector3(1, 1, 1));

    let match = shadows?.attach(target, { filter: this.filter }) ?? { matched: [], baked: [] };
    const added = match.baked.map(lightOf);
    if (added.length) {
      root.add(...added);
      match = shadows.attach(target, { filter: this.filter });
    }
    const baked = new Map(match.matched.map((pair) => [pair.light, pair.baked]));
    root.traverse((object) => {
      if (object.isDirectionalLight || object.isSpotLight || object.isPointLight)
        this.lights.push({ light: object, baked: baked.get(object) ?? null, on: object.visible });
    });
    this.moved = match.matched.filter((pair) => pair.moved).map((pair) => pair.baked.name);
    this.skyShare = this.lights.some(({ light }) => light.isDirectionalLight) ? 0.5 : 0.15;
    this.#surroundings();
    this.fog.reset(shadows, Math.max(0.5 * this.bounds.getSize(new Vector3()).length(), 1e-3));
    return { ...match, added };
  }

  /** What the graphics processor had is lost: make anew what three.js does not. */
  restored() {
    if (this.root) this.#surroundings();
  }

  #surroundings() {
    const sun = this.lights.find(({ light }) => light.isDirectionalLight)?.light;
    const place = (object) => new Vector3().setFromMatrixPosition(object.matrixWorld);
    const mirrors = meshesBelow(this.root).some(({ material }) =>
      [material].flat().some(({ metalness, roughness }) => metalness > 0.1 || roughness < 0.3),
    );
    sun?.updateWorldMatrix(true, true);
    this.backdrop.set(
      sun ? { direction: place(sun).sub(place(sun.target)).normalize(), colour: sun.color } : null,
      mirrors,
    );
  }

  set filter(filter) {
    this.chosenFilter = filter;
    this.shadows?.setFilter(filter);
  }

  get filter() {
    return this.chosenFilter ?? { box: 5 };
  }

  /** Luminances of what the camera sees, ascending, without the sky. radiance: of the light from the sky */
  #luminances(radiance) {
    const width = 96,
      height = 54,
      target = new WebGLRenderTarget(width, height, { type: FloatType }),
      { renderer } = this;
    const pixels = new Float32Array(4 * width * height),
      found = [];
    this.backdrop.shine([this.scene], radiance);
    this.#setLights();
    const draw = () => {
      renderer.setClearColor(0, 0);
      renderer.clear();
      renderer.render(this.scene, this.camera);
    };
    renderer.setRenderTarget(target);
    if (radiance) this.#through(draw, radiance, target);
    else draw();
    renderer.readRenderTargetPixels(target, 0, 0, width, height, pixels);
    renderer.setRenderTarget(null);
    target.dispose();
    for (let n = 0; n < pixels.length; n += 4) {
      const luminance = 0.2126 * pixels[n] + 0.7152 * pixels[n + 1] + 0.0722 * pixels[n + 2];
      if (pixels[n + 3] > 0 && luminance > 0 && luminance < Infinity) found.push(luminance);
    }
    return found.sort((a, b) => a - b);
  }

  /** Choose the brightness of the sky, as a share of what the lights light, and the exposure, by what the camera sees. */
  measure() {
    const direct = this.#luminances(0),
      mean = (list) => (list.length ? list.reduce((sum, each) => sum + each, 0) / list.length : 0);
    this.direct = mean(direct.slice(direct.length >> 1)) || 1; // of the brighter half
    const all = this.#luminances(this.skyShare * this.direct),
      at = (share) => all[Math.floor(share * (all.length - 1))] ?? 1;
    this.exposure = Math.min(0.42 / at(0.5), (this.fog.on ? 0.7 : 0.85) / at(0.92));
  }

  /** The scene beside the baked one: the same meshes, with lights of its own. */
  #openBeside() {
    if (this.beside) return;
    const root = clone(this.root),
      copies = new Map();
    const plain = (material) => {
      if (!copies.has(material)) copies.set(material, material.clone());
      return copies.get(material);
    };
    const lights = [];
    root.traverse((object) => object.isLight && lights.push(object));
    lights.forEach((light) => light.removeFromParent());
    for (const mesh of meshesBelow(root)) {
      mesh.material = Array.isArray(mesh.material) ? mesh.material.map(plain) : plain(mesh.material);
      mesh.castShadow = mesh.receiveShadow = true;
    }
    this.beside = new Scene().add(root);
    this.twins = this.lights.map(({ light }) => {
      const twin = liveTwin(light, this.bounds);
      this.beside.add(twin);
      if (twin.target) this.beside.add(twin.target);
      return twin;
    });
  }

  /** Lights that have a live shadow map: the first few that are on. */
  get liveLights() {
    return this.lights.filter(({ on }) => on).slice(0, LIVE_LIGHTS);
  }

  #setLights() {
    const live = new Set(this.compare === 'live' ? this.liveLights : []);
    this.lights.forEach((each, n) => {
      each.light.visible = each.on;
      if (!this.twins) return;
      this.twins[n].visible = each.on;
      this.twins[n].castShadow = live.has(each);
    });
  }

  resize(width, height, ratio) {
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
  }

  render() {
    const { renderer, camera, backdrop } = this,
      sky = this.skyShare * this.direct;
    if (this.compare) this.#openBeside();
    this.#setLights();
    renderer.toneMappingExposure = this.exposure * 2 ** this.exposureStops;
    backdrop.shine([this.scene, this.beside].filter(Boolean), sky);
    renderer.info.reset();
    this.#through((linear) => this.#draw(linear ? 1 / renderer.toneMappingExposure : 0), sky, null);
    renderer.render(this.marks, camera);
  }

  /** Draw through the fog, if there is one.   draw(linear)  into the current target, of linear light or the screen;   output  null: the screen */
  #through(draw, radiance, output) {
    if (!this.fog.on || !this.fog.available) return draw(false);
    const lights = this.lights.filter(({ on, baked }) => on && baked).map(({ light }) => light);
    this.fog.render(() => draw(true), lights, this.backdrop.colour.clone().multiplyScalar(radiance), output);
  }

  /** Both halves into the current target.   brightness  of the backdrop, in a target of linear light; 0: as it is shown */
  #draw(brightness) {
    const { renderer, camera } = this,
      size = renderer.getSize(new Vector2()),
      half = Math.round(this.split * size.x),
      target = renderer.getRenderTarget();
    const ratio = target ? renderer.getPixelRatio() : 1; // a target is cut in its own pixels
    const cut = (...box) =>
      target
        ? target.scissor.set(...box.map((value) => Math.round(value * ratio)))
        : renderer.setScissor(...box);
    const cutting = (on) => {
      if (target) target.scissorTest = on;
      else renderer.setScissorTest(on);
      renderer.setRenderTarget(target);
    };
    cutting(false);
    renderer.clear();
    this.backdrop.render(camera, brightness);
    if (this.compare) {
      cut(0, 0, half, size.y);
      cutting(true);
    }
    renderer.render(this.scene, camera);
    this.drawn = { ...renderer.info.render };
    if (!this.compare) return;
    cut(half, 0, size.x - half, size.y);
    cutting(true);
    renderer.render(this.beside, camera);
    cutting(false);
  }
}
