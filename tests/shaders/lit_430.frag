#version 430 core
/* the words of all lights, one after the other */
layout(std430, binding = 0) readonly buffer shadow_words { uint words[]; };
#define vxs_word(dag, i) words[(dag) + (i)]

#include "vxs_lookup.h"
#include "vxs_lookup_blocks.h"
#include "vxs_space.h"

layout(std140, binding = 0) uniform shadow_light { vxs_light_constants light; };
in vec3 position_ws; /* metres from the origin that the constants were made for */
in vec3 normal_ws;   /* of the triangle, not of a normal map; (0, 0, 0) in the air */
out float lit;       /* 0 dark to 1 lit; VXS_OUTSIDE where the light's map does not reach: the engine decides */

void main()
{
    lit = vxs_lit(light.first_word, light, position_ws, normal_ws, vxs_box(9));
}
