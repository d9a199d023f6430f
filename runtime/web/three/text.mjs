// Text of shaders that read words and constants from the textures of words.mjs.
// SPDX-License-Identifier: MIT
import { vxs_air, vxs_air_light, vxs_air_path, vxs_air_ray, vxs_depths, vxs_fog, vxs_intervals, vxs_lookup, vxs_lookup_blocks, vxs_space, vxs_tables } from 'vxs/shaders';
import { FOG_TEXELS, TEXELS } from './words.mjs';

const UNIFORMS = 'uniform highp usampler2D vxsWords;\nuniform highp usampler2D vxsLights;';

const texels = (first, count, row) => Array.from({ length: count }, (_, n) => `texelFetch( vxsLights, ivec2( ${first + n}, ${row} ), 0 )`).join(', ');

const lights = (macros, wide, uniforms) => `
${Object.entries(macros).map(([name, value]) => `#define ${name} ${value}`).join('\n')}
${uniforms}
uint vxs_fetch( uint at ) { return texelFetch( vxsWords, ivec2( int( at & ${wide - 1}u ), int( at / ${wide}u ) ), 0 ).r; }
#define vxs_word(dag, i) vxs_fetch( ( dag ) + ( i ) )
${macros.VXS_GL_TABLES ? vxs_tables : ''}
${vxs_lookup}
${vxs_lookup_blocks}
${vxs_space}
vxs_light_constants vxsLight( int row ) {
  return vxs_light_of_texels( ${texels(0, TEXELS, 'row')} );
}
`;

/** Text that reads words and constants: behind it a shader calls vxsLit(row, position, normal). */
export const readers = (macros, wide, uniforms = UNIFORMS) => `${lights(macros, wide, uniforms)}
float vxsLit( int row, vec3 position, vec3 normal ) {
  vxs_light_constants light = vxsLight( row );
  if ( light.coding == 0u ) return 1.0; // no baked light
  float lit = vxs_lit( light.first_word, light, position, normal, vxs_box( 1 ) ); // macros say which filter it is
  return lit < 0.0 ? 1.0 : lit; // beyond the map
}
`;

/** Text of fog: behind it a shader calls vxsFog(eye, direction, metres) for the airlight of a ray. */
export const airReaders = (macros, wide, uniforms = UNIFORMS) => `${lights(macros, wide, uniforms)}
${vxs_depths}
${vxs_intervals}
${vxs_air_light}
${vxs_air_ray}
${vxs_air}
${vxs_air_path}
${vxs_fog}
vec3 vxsFog( vec3 eye, vec3 direction, float metres ) {
  return vxs_fog( vxsLight( 0 ), ${Array.from({ length: FOG_TEXELS }, (_, n) => `uintBitsToFloat( ${texels(TEXELS + n, 1, 0)} )`).join(', ')}, eye, direction, metres );
}
`;

// The same in WGSL, of which naga made `wgsl` (wgsl.mjs, wgsl_fog.mjs).
const wgslTexels = (first, count, row) => Array.from({ length: count }, (_, n) => `textureLoad(vxsLights, vec2i(${first + n}, ${row}), 0)`).join(', ');

const wgslLights = (wgsl, wide) => `
fn vxs_word_at(at: u32) -> u32 { return textureLoad(vxsWords, vec2u(at & ${wide - 1}u, at / ${wide}u), 0).r; }
${wgsl}
fn vxsLight(row: i32) -> vxs_light_constants { return vxs_light_of_texels(${wgslTexels(0, TEXELS, 'row')}); }`;

export const wgslReaders = (wgsl, { VXS_ONLY_WIDTH, VXS_ONLY_SMOOTH }, wide) => `${wgslLights(wgsl, wide)}
fn vxsLit(row: i32, position: vec3f, normal: vec3f) -> f32 {
  let light = vxsLight(row);
  let lit = vxs_lit(light.first_word, light, position, normal, ${VXS_ONLY_SMOOTH ? 'vxs_smooth' : 'vxs_box'}(${VXS_ONLY_WIDTH}));
  return select(lit, 1.0, lit < 0.0);
}`;

export const wgslAirReaders = (wgsl, wide) => `${wgslLights(wgsl, wide)}
fn vxsFog(eye: vec3f, direction: vec3f, metres: f32) -> vec3f {
  return vxs_fog(vxsLight(0), ${Array.from({ length: FOG_TEXELS }, (_, n) => `bitcast<vec4f>(${wgslTexels(TEXELS + n, 1, 0)})`).join(', ')}, eye, direction, metres);
}`;
