// SPDX-License-Identifier: MIT
/**
 * vxs/shaders: texts of headers, for GLSL ES 3.00, GLSL 3.30 and later, and HLSL, without comments and includes. What they declare
 * and what the includer defines before them is described in formats/*.h and runtime/volumes/*.h of the project.
 *
 *     import { vxs_lookup, vxs_lookup_blocks, vxs_space } from 'vxs/shaders';
 *     const shader = `#version 300 es
 *     uniform highp usampler2D words;
 *     #define vxs_word(first, i) texelFetch(words, ivec2(((first) + (i)) & 2047u, ((first) + (i)) >> 11), 0).x
 *     ${vxs_lookup}${vxs_lookup_blocks}${vxs_space}${body}`;
 */
/** Walks of DAGs, masks; each of the others needs it. */
export const vxs_lookup: string;
/** Palette blocks. */
export const vxs_lookup_blocks: string;
/** World space to voxels; vxs_lit, the whole lookup. Needs the two above. */
export const vxs_space: string;
/** First shadow of texels. */
export const vxs_depths: string;
/** Lit intervals of rays; needs vxs_space and vxs_depths. */
export const vxs_intervals: string;
/** Tables of palette blocks in place of words, for shaders that define VXS_GL_TABLES; before vxs_lookup. */
export const vxs_tables: string;
/** Baked smoke; needs vxs_space. */
export const vxs_smoke: string;
/** Light in the air along a ray. */
export const vxs_air_light: string;
export const vxs_air_ray: string;
export const vxs_air: string;
export const vxs_air_path: string;
/** Airlight of a baked light along an eye ray; needs vxs_intervals and vxs_air_path. */
export const vxs_fog: string;
