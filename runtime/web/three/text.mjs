// Text of shaders that read words and constants from the textures of words.mjs.
// SPDX-License-Identifier: MIT
import { vxs_lookup, vxs_lookup_blocks, vxs_space } from 'vxs/shaders';

const UNIFORMS = 'uniform highp usampler2D vxsWords;\nuniform highp usampler2D vxsLights;';

/** Text that reads words and constants: behind it a shader calls vxsLit(row, position, normal). */
export const readers = (macros, wide, uniforms = UNIFORMS) => `
${Object.entries(macros).map(([name, value]) => `#define ${name} ${value}`).join('\n')}
${uniforms}
uint vxs_fetch( uint at ) { return texelFetch( vxsWords, ivec2( int( at & ${wide - 1}u ), int( at / ${wide}u ) ), 0 ).r; }
#define vxs_word(dag, i) vxs_fetch( ( dag ) + ( i ) )
${vxs_lookup}
${vxs_lookup_blocks}
${vxs_space}
vxs_light_constants vxsLight( int row ) {
  return vxs_light_of_texels( ${[0, 1, 2, 3, 4, 5].map((n) => `texelFetch( vxsLights, ivec2( ${n}, row ), 0 )`).join(', ')} );
}
float vxsLit( int row, vec3 position, vec3 normal ) {
  vxs_light_constants light = vxsLight( row );
  if ( light.coding == 0u ) return 1.0; // no baked light
  float lit = vxs_lit( light.first_word, light, position, normal, vxs_box( 1 ) ); // macros say which filter it is
  return lit < 0.0 ? 1.0 : lit; // beyond the map
}
`;
