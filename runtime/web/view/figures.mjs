// What the page of vxs view states about a level: warnings, sizes, times, and what baked shadows save.
// SPDX-License-Identifier: MIT
import { bytesText, countText } from './panel.mjs';

/** missing: addresses of images; added: lights that are in the .vxs file alone. */
export function warningsOf(level, stage, missing, added) {
  const warnings = [
    ...level.warnings,
    ...missing.map((uri) => `The image ${uri} is not here: its material is drawn without it.`),
  ];
  if (added.length)
    warnings.push(
      `${added.map(({ name }) => name).join(', ')}: in the .vxs file alone, so its brightness is a guess.`,
    );
  if (stage.moved.length)
    warnings.push(
      `${stage.moved.join(', ')}: not where it was when it was baked, so its shadow does not fit.`,
    );
  const without = stage.lights.filter(({ baked }) => !baked).length;
  if (level.asset && without)
    warnings.push(`${without} of ${stage.lights.length} lights have no baked shadow.`);
  if (!level.asset) warnings.push('There is no .vxs file: drop one, or bake the scene with vxs bake.');
  return warnings;
}

export function subtitleOf(level, stage) {
  if (!level.asset) return 'no baked shadows';
  const baked = stage.lights.flatMap((each) => each.baked ?? []);
  const [{ resolution } = {}] = baked;
  const lights = baked.length === 1 ? `${resolution} x ${resolution} texels` : `${baked.length} lights`;
  return `${lights}, ${bytesText(level.asset.bytes.length)} of baked shadows`;
}

const msText = (time) => `${time.toFixed(time < 10 ? 1 : 0)} ms`;

/** times: of opening, ms; passes: what live shadow maps would draw. */
export function numbersOf(level, stage, times, passes) {
  const { asset } = level,
    baked = stage.lights.flatMap((each) => each.baked ?? []);
  const depth16 = baked.reduce((sum, { maps, resolution }) => sum + 2 * maps * resolution ** 2, 0);
  const words = baked.reduce((sum, { wordCount }) => sum + 4 * wordCount, 0);
  return {
    Scene: bytesText(
      [...level.files.values()].reduce((sum, { length }) => sum + length, level.scene.bytes.length),
    ),
    ...(asset && {
      'Baked shadows': bytesText(asset.bytes.length),
      '16-bit depth maps': bytesText(depth16),
      'In graphics memory': bytesText(words),
      'Opened in': msText(times.asset),
    }),
    'Scene read in': msText(times.scene),
    ...(stage.drawn && {
      'Draws a frame': countText(stage.drawn.calls),
      'Triangles a frame': countText(stage.drawn.triangles),
    }),
    ...(asset && {
      'Shadow passes saved': countText(passes.passes),
      'Draws saved': countText(passes.calls),
      'Triangles saved': countText(passes.triangles),
    }),
  };
}
