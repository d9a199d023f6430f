// Words and constants of baked lights as textures, for WebGL 2 and WebGPU alike.
// SPDX-License-Identifier: MIT
import { DataTexture, Matrix4, NearestFilter, RGBAIntegerFormat, RedIntegerFormat, UnsignedIntType, Vector3 } from 'three';
import { VXSError } from 'vxs';
import { tablesOf } from './tables.mjs';

const TEXTURES = { 1: RedIntegerFormat, 4: RGBAIntegerFormat };
export const TEXELS = 6; // of RGBA32UI for the constants of a light: 96 bytes
export const FOG_TEXELS = 5; // behind them, of its fog: arguments of vxs_fog (fog.glsl)
const PADDING = 4; // words that a lookup may read behind the last one

// An integer texture; with other filters than NEAREST it would read 0.
export function integerTexture(data, width, height, channels) {
  const texture = new DataTexture(data, width, height, TEXTURES[channels], UnsignedIntType);
  texture.minFilter = texture.magFilter = NearestFilter;
  texture.generateMipmaps = false;
  texture.unpackAlignment = 4;
  texture.needsUpdate = true;
  return texture;
}

/**
 * Words of some baked lights in one texture, 2048 texels wide as any WebGL 2 has, or wider where they need more rows than that.
 * Returns { texture, wide, first: Map of the first word of each light }.
 */
function textureOf(bakedLights, wordsOf) {
  const words = bakedLights.map(wordsOf), first = new Map();
  let count = 0;
  bakedLights.forEach((light, n) => {
    first.set(light, count);
    count += words[n].length;
  });
  const { data, ...made } = emptyTexture(count);
  bakedLights.forEach((light, n) => data.set(words[n], first.get(light)));
  return { ...made, first };
}

function emptyTexture(count) {
  let wide = 2048;
  while (count + PADDING > wide * wide && wide < 16384) wide *= 2;
  if (count + PADDING > wide * wide) throw new VXSError('memory', `${count} words do not fit into a texture`);
  const data = new Uint32Array(wide * Math.ceil((count + PADDING) / wide));
  return { texture: integerTexture(data, wide, data.length / wide, 1), wide, data };
}

/** The words of a stream, as far as they are there. update(changes) writes more. */
export function streamTexture(stream) {
  const { texture, wide, data } = emptyTexture(stream.wordCount);
  let uploaded = false; // three.js uploads ranges alone, also into a texture that is new
  data.set(stream.words());
  texture.onUpdate = () => {
    uploaded = true;
    texture.clearUpdateRanges?.();
  };
  const update = (changes) => changes.forEach(({ firstWord, words }) => {
    data.set(words, firstWord);
    texture.needsUpdate = true;
    const end = firstWord + words.length; // a range lies in one row, and is counted as if texels had four channels
    for (let at = firstWord, next; uploaded && at < end; at = next) {
      next = Math.min(end, (Math.floor(at / wide) + 1) * wide);
      texture.addUpdateRange?.(4 * at, 4 * (next - at));
    }
  });
  return { texture, wide, first: new Map(stream.lights.map((light) => [light, light.firstWord])), update };
}

export const wordsTexture = (bakedLights) => textureOf(bakedLights, (light) => light.words());
export const tablesTexture = (light) => ({ ...textureOf([light], tablesOf), isTables: true });

const rest = (x) => Math.max(-32768, Math.min(32767, Math.round((x - Math.fround(x)) * 2 ** 20))) & 0xffff;

/**
 * Constants of a baked light (vxs_light_constants, 24 words) for positions relative to `origin`, which is in the world space of
 * three.js. All products are doubles, so that floats in a shader are precise near the origin.
 * template  the light's own constants, Uint8Array(96);   fromRoot  Matrix4: rigid, world space of three.js to that of the file
 */
export function writeConstants(out, at, baked, template, firstWord, origin, fromRoot) {
  const floats = new Float32Array(out.buffer, out.byteOffset), m = fromRoot.elements, l = baked.matrix;
  out.set(new Uint32Array(template.buffer, template.byteOffset, 24), at);
  const file = origin.clone().applyMatrix4(fromRoot).toArray(), there = [0, 0, 0];
  for (let row = 0; row < 3; row++) {
    for (let column = 0; column < 3; column++)
      floats[at + 4 * row + column] = [0, 1, 2].reduce((sum, n) => sum + l[4 * row + n] * m[4 * column + n], 0);
    there[row] = l[4 * row] * file[0] + l[4 * row + 1] * file[1] + l[4 * row + 2] * file[2] + l[4 * row + 3];
    floats[at + 4 * row + 3] = there[row];
  }
  out[at + 20] = firstWord;
  const sun = baked.kind === 'directional';
  out[at + 22] = sun ? rest(there[0]) | (rest(there[1]) << 16) : 0;
  out[at + 23] = sun ? rest(there[2]) : 0;
}

/** World space of three.js to that of the baked file, for a root that was moved or turned as a whole. */
export function fromRootMatrix(root) {
  const inverse = new Matrix4().copy(root.matrixWorld).invert(), scale = new Vector3().setFromMatrixScale(inverse);
  const rigid = Math.max(...scale.toArray().map((s) => Math.abs(s - 1))) < 1e-5 && inverse.determinant() > 0;
  if (!rigid) throw new VXSError('argument', 'the root of the baked scene is scaled: bake it at the size in which it is shown');
  return inverse;
}

/** Macros of vxs_space.h for what all lights have in common: code for others is not compiled. */
export function commonMacros(bakedLights, filter) {
  const kinds = { directional: 1, spot: 2, point: 3 }, common = {};
  const same = (name, of) => {
    const all = new Set(bakedLights.map(of));
    if (all.size === 1) common[name] = [...all][0];
  };
  same('VXS_ONLY_KIND', (light) => kinds[light.kind]);
  same('VXS_ONLY_CUBE', (light) => (light.maps === 6 ? 1 : 0));
  same('VXS_ONLY_CODING', (light) => (light.coding === 'blocks' ? 2 : 1));
  return { ...common, VXS_ONLY_WIDTH: filter.width, VXS_ONLY_SMOOTH: filter.smooth ? 1 : 0 };
}

/** A filter option, { box: 9 }, { smooth: 9 } or 9, as { width, smooth }. */
export function filterOf(option = { box: 9 }) {
  const width = typeof option === 'number' ? option : (option.smooth ?? option.box), smooth = option.smooth !== undefined;
  if (!(Number.isInteger(width) && width >= 1 && width <= 17 && (smooth || width % 2)))
    throw new VXSError('argument', `filter ${JSON.stringify(option)}: { box: K } takes odd K of 1 to 17, { smooth: K } any K of 1 to 17`);
  return { width, smooth };
}
