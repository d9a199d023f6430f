#version 310 es
precision highp float;
precision highp int;
layout(std430, binding = 0) readonly buffer shadow_words { uint words[]; };
#define vxs_word(dag, i) words[(dag) + (i)]

#include "vxs_lookup.h"
#include "vxs_lookup_blocks.h"
#include "vxs_space.h"

layout(std140, binding = 0) uniform shadow_light { vxs_light_constants light; };
in vec3 position_ws;
in vec3 normal_ws;
out float lit;

void main()
{
    lit = vxs_lit(light.first_word, light, position_ws, normal_ws, vxs_box(9));
}
