#version 300 es
precision highp float;
precision highp int;
uniform highp usampler2D words; /* R32UI, NEAREST, 2048 texels wide: the words of all lights, one after the other */
uint shadow_word(uint at) { return texelFetch(words, ivec2(int(at & 2047u), int(at >> 11)), 0).r; }
#define vxs_word(dag, i) shadow_word((dag) + (i))

#include "vxs_lookup.h"
#include "vxs_lookup_blocks.h"
#include "vxs_space.h"

layout(std140) uniform shadow_light { vxs_light_constants light; };
in vec3 position_ws;
in vec3 normal_ws;
out float lit;

void main()
{
    lit = vxs_lit(light.first_word, light, position_ws, normal_ws, vxs_box(9));
}
