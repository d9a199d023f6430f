// What shaders of fog read: tables or words of one baked light, and its constants with those of the medium, in one texture.
// SPDX-License-Identifier: MIT
import { Vector3 } from 'three';
import { VXSError } from 'vxs';
import { FOG_TEXELS, TEXELS, commonMacros, integerTexture, writeConstants } from './words.mjs';

/** A number, or one for each of red, green, blue, as three numbers. */
export const perMetre = (value) => (typeof value === 'number' ? [value, value, value] : [...(value.toArray?.() ?? value)]);

export class FogLight {
  /** light  one that attach() has matched, or its name in the file; the first by default */
  constructor(shadows, light) {
    this.pair = shadows.pairs.find((pair) => !light || pair.light === light || pair.baked.name === light);
    if (!this.pair) throw new VXSError('argument', 'fog needs a light that attach() has matched');
    const { baked } = this.pair;
    Object.assign(this, { shadows, words: shadows.tables(baked) ?? shadows.words, template: baked.constants() });
    this.constants = integerTexture(new Uint32Array(4 * (TEXELS + FOG_TEXELS)), TEXELS + FOG_TEXELS, 1, 4);
    this.macros = { VXS_ONLY_EVERYWHERE: 1, ...commonMacros([baked], { width: 1, smooth: false }), ...(this.words.isTables && { VXS_GL_TABLES: 1 }) };
  }

  /** Write the constants of a frame. Positions are relative to the camera. */
  update(camera, { extinction, scattering, anisotropy }) {
    const { pair: { light, baked }, shadows } = this, { data } = this.constants.image;
    camera.updateWorldMatrix(true, false);
    light.updateWorldMatrix(true, false);
    light.target?.updateWorldMatrix(true, false);
    const eye = new Vector3().setFromMatrixPosition(camera.matrixWorld), place = new Vector3().setFromMatrixPosition(light.matrixWorld);
    const axis = light.target ? new Vector3().setFromMatrixPosition(light.target.matrixWorld).sub(place).normalize() : new Vector3();
    const at = baked.kind === 'directional' ? axis.clone().negate() : place.sub(eye);
    const strength = light.visible ? light.intensity : 0, color = light.color.toArray().map((channel) => strength * channel);
    writeConstants(data, 0, baked, this.template, this.words.first.get(baked), eye, shadows.fromRoot);
    new Float32Array(data.buffer, data.byteOffset + 16 * TEXELS).set([
      ...perMetre(extinction), anisotropy, ...perMetre(scattering), baked.kind === 'spot' ? Math.cos(light.angle * (1 - light.penumbra)) : 1,
      ...at.toArray(), 0.01, ...axis.toArray(), 0, ...color, 0,
    ]);
    this.constants.needsUpdate = true;
  }

  dispose() { this.constants.dispose(); }
}
