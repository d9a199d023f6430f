#version 450
layout(std430, set = 0, binding = 0) readonly buffer shadow_words { uint words[]; };
#define vxs_word(dag, i) words[(dag) + (i)]

#include "vxs_lookup.h"
#include "vxs_lookup_blocks.h"
#include "vxs_space.h"

layout(std140, set = 0, binding = 1) uniform shadow_light { vxs_light_constants light; };
layout(location = 0) in vec3 position_ws;
layout(location = 1) in vec3 normal_ws;
layout(location = 0) out float lit;

void main()
{
    lit = vxs_lit(light.first_word, light, position_ws, normal_ws, vxs_box(9));
}
