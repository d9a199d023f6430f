// Exact lookups in the materials of a WebGLRenderer: each light's colour is multiplied by its baked shadow, in the loops over lights of
// three.js. The words of all lights lie in one integer texture, their constants in another, in the order in which three.js has the
// lights: directional, spot, point, those that cast a live shadow first.
// SPDX-License-Identifier: MIT
import { Material, ShaderChunk, Vector3 } from 'three';
import { VXSError } from 'vxs';
import { readers } from './text.mjs';
import { TEXELS, commonMacros, integerTexture, writeConstants } from './words.mjs';

const BASE = { Directional: '0', Spot: 'NUM_DIR_LIGHTS', Point: 'NUM_DIR_LIGHTS + NUM_SPOT_LIGHTS' };
// lights that have samplers of their own, in arrays which only constants may index: three.js has them first
const UNROLLED = { Directional: 'NUM_DIR_LIGHT_SHADOWS', Spot: 'NUM_SPOT_LIGHT_COORDS', Point: 'NUM_POINT_LIGHT_SHADOWS' };
const LOOP = /#pragma unroll_loop_start\s+for \( int i = 0; i < NUM_(?:DIR|SPOT|POINT)_LIGHTS; i \+\+ \) \{([\s\S]+?\bget(Directional|Spot|Point)LightInfo\([^;]*\);)([\s\S]+?)\}\s+#pragma unroll_loop_end/g;

// The position relative to the camera, in axes of the world, and the normal of the triangle towards the camera. Derivatives are taken
// before any discard.
const SURFACE = `
  vec3 vxsPosition = ( vec4( - vViewPosition, 0.0 ) * viewMatrix ).xyz;
  vec3 vxsNormal = cross( dFdx( vxsPosition ), dFdy( vxsPosition ) );
  vxsNormal *= inversesqrt( max( dot( vxsNormal, vxsNormal ), 1e-30 ) );
`;

// A loop over lights in two: lights with samplers unrolled as before, all others in one loop whose body is compiled once.
function splitLoop(all, head, kind, tail) {
  const shaded = (row) => `${head}
    if ( receiveShadow && directLight.visible ) directLight.color *= vxsLit( ${BASE[kind]} + ${row}, vxsPosition, vxsNormal );${tail}`;
  return `#pragma unroll_loop_start
  for ( int i = 0; i < ${UNROLLED[kind]}; i ++ ) {${shaded('UNROLLED_LOOP_INDEX')}}
  #pragma unroll_loop_end
  for ( int i = ${UNROLLED[kind]}; i < NUM_${kind === 'Directional' ? 'DIR' : kind.toUpperCase()}_LIGHTS; i ++ ) {
    ${shaded('i').replaceAll('UNROLLED_LOOP_INDEX', '1000000')}}`;
}

/** The fragment shader of a lit material with lookups; null if it has no loop over lights that is known. */
export function withLookups(fragmentShader, text) {
  let loops = 0;
  const shader = fragmentShader
    .replace('#include <lights_fragment_begin>', () => ShaderChunk.lights_fragment_begin)
    .replace(LOOP, (...match) => {
      loops++;
      return splitLoop(...match);
    })
    .replace('#include <lights_pars_begin>', () => `#include <lights_pars_begin>\n${text}`)
    .replace('void main() {', `void main() {\n${SURFACE}`);
  return loops === 3 && shader.includes(text) && shader.includes(SURFACE) && shader.includes('vViewPosition') ? shader : null;
}

// Lights that three.js will shade with, in its order: that of the scene, lights with live shadows and with textures first.
function lightsInOrder(scene, camera) {
  const lights = [];
  const visit = (object) => {
    if (!object.visible) return;
    if (object.isLight && object.layers.test(camera.layers)) lights.push(object);
    for (const child of object.children) visit(child);
  };
  visit(scene);
  lights.sort((a, b) => (b.castShadow ? 2 : 0) - (a.castShadow ? 2 : 0) + (b.map ? 1 : 0) - (a.map ? 1 : 0));
  const kind = (is) => lights.filter((light) => light[is] && !light.isSunLight);
  return [...kind('isDirectionalLight'), ...kind('isSpotLight'), ...kind('isPointLight')];
}

// Uniforms of a material live as long as it does: three.js keeps its programs, and uses them again after a detach and another attach.
const UNIFORMS = new WeakMap();
function uniformsOf(material) {
  if (!UNIFORMS.has(material)) UNIFORMS.set(material, { vxsWords: { value: null }, vxsLights: { value: null } });
  return UNIFORMS.get(material);
}

const LIT = ['isMeshStandardMaterial', 'isMeshPhongMaterial', 'isMeshLambertMaterial', 'isMeshToonMaterial'];

export class Lookups {
  live = true; // a live shadow map of three.js goes with it, of what moves

  /** pairs  [{ light, baked }];   kernel  { width, smooth };   fromRoot  Matrix4 */
  constructor(pairs, { shadows, kernel, fromRoot }) {
    this.baked = new Map(pairs.map(({ light, baked }) => [light, baked]));
    this.lights = [...new Set(this.baked.values())];
    this.templates = new Map(this.lights.map((light) => [light, light.constants()]));
    this.fromRoot = fromRoot;
    this.words = shadows.words;
    this.materials = new Map();
    this.origin = new Vector3();
    this.rows = null;
    this.#texture(8);
    this.setFilter(kernel);
  }

  setFilter(filter) {
    this.text = readers(commonMacros(this.lights, filter), this.words.wide);
    this.key = `vxs ${filter.width} ${filter.smooth} ${this.text.length}`;
    for (const material of this.materials.keys()) material.needsUpdate = true;
  }

  /** Patch the lit materials of a mesh. */
  add(mesh) {
    for (const material of [mesh.material].flat())
      if (LIT.some((is) => material?.[is]) && !this.materials.has(material)) this.patch(material);
  }

  patch(material) {
    const { onBeforeCompile, onBeforeRender, customProgramCacheKey } = material, lookups = this;
    if (material.userData.vxs) throw new VXSError('argument', `material '${material.name}' has shadows of another file: detach those first`);
    const own = {
      onBeforeCompile(shader, renderer) {
        onBeforeCompile.call(this, shader, renderer);
        if (!lookups.materials.has(material)) return;
        const { maxTextureSize } = renderer.capabilities, { width, height } = lookups.words.texture.image;
        if (Math.max(width, height) > maxTextureSize)
          throw new VXSError('memory', `the words need a texture of ${width} x ${height}, and this device has ${maxTextureSize}`);
        const text = withLookups(shader.fragmentShader, lookups.text);
        if (!text) throw new VXSError('unsupported', `the shader of material '${material.name}' is none that vxs knows`);
        shader.fragmentShader = text;
        Object.assign(shader.uniforms, uniformsOf(material));
      },
      onBeforeRender(renderer, scene, camera, ...others) {
        onBeforeRender.call(this, renderer, scene, camera, ...others);
        lookups.update(renderer, scene, camera);
        // a program that three.js kept runs with the uniforms of the program that was compiled last, which may be without lookups
        const { uniforms } = renderer.properties.get(this);
        if (uniforms && !uniforms.vxsWords) Object.assign(uniforms, uniformsOf(material));
      },
      customProgramCacheKey() {
        const before = customProgramCacheKey === Material.prototype.customProgramCacheKey
          ? onBeforeCompile.toString() : customProgramCacheKey.call(this);
        return lookups.materials.has(material) ? `${lookups.key} ${before}` : before;
      },
    };
    const had = Object.fromEntries(Object.keys(own).map((name) => [name, Object.hasOwn(material, name) ? material[name] : undefined]));
    Object.assign(material, own);
    Object.defineProperty(material.userData, 'vxs', { value: true, configurable: true, enumerable: false });
    this.materials.set(material, { own, had });
    this.#show(material);
    material.needsUpdate = true;
  }

  // The texture of constants, for so many lights.
  #texture(height) {
    this.constants?.dispose();
    this.constants = integerTexture(new Uint32Array(4 * TEXELS * height), TEXELS, height, 4);
    for (const material of this.materials.keys()) this.#show(material);
  }

  #show(material) {
    const uniforms = uniformsOf(material);
    uniforms.vxsWords.value = this.words.texture;
    uniforms.vxsLights.value = this.constants;
  }

  /** Once a rendering: constants of the lights relative to the camera, in the order of three.js. */
  update(renderer, scene, camera) {
    const { frame } = renderer.info.render;
    if (this.frame === frame && this.scene === scene && this.camera === camera && this.renderer === renderer) return;
    Object.assign(this, { frame, scene, camera, renderer });
    const rows = lightsInOrder(scene, camera).map((light) => this.baked.get(light));
    const origin = new Vector3().setFromMatrixPosition(camera.matrixWorld);
    if (this.rows && origin.equals(this.origin) && rows.length === this.rows.length && rows.every((row, n) => row === this.rows[n])) return;
    Object.assign(this, { rows, origin });
    if (this.constants.image.height < rows.length) this.#texture(2 ** Math.ceil(Math.log2(rows.length)));
    const { data } = this.constants.image;
    data.fill(0);
    rows.forEach((baked, n) => {
      const at = 4 * TEXELS * n;
      if (baked) writeConstants(data, at, baked, this.templates.get(baked), this.words.first.get(baked), origin, this.fromRoot);
    });
    this.constants.needsUpdate = true;
  }

  dispose() {
    for (const [material, { own, had }] of this.materials) {
      for (const name of Object.keys(own)) {
        if (material[name] !== own[name]) continue; // another one is chained behind: it stays, and does nothing of ours
        if (had[name]) material[name] = had[name];
        else delete material[name];
      }
      delete material.userData.vxs;
      for (const uniform of Object.values(uniformsOf(material))) uniform.value = null;
      material.needsUpdate = true;
    }
    this.materials.clear();
    this.constants.dispose();
  }
}
