#version 450
#extension GL_GOOGLE_include_directive : require
/* One point an invocation, for vulkan.c. To SPIR-V:
 *
 *     glslangValidator -V -I"$(pkg-config --variable=includedir vxs)/vxs" vulkan.comp -o vulkan.spv
 *
 * SPDX-License-Identifier: MIT */
layout(local_size_x = 64) in;

/* The program sets these when it makes the pipeline, so that the driver compiles the code of one filter. */
layout(constant_id = 0) const int FILTER_WIDTH_PX = 1;
layout(constant_id = 1) const int FILTER_IS_SMOOTH = 0;
#define VXS_ONLY_WIDTH  FILTER_WIDTH_PX
#define VXS_ONLY_SMOOTH FILTER_IS_SMOOTH

/* the words of all lights, one light after the other */
layout(std430, set = 0, binding = 0) readonly buffer shadow_words { uint words[]; };
#define vxs_word(dag, i) words[(dag) + (i)]

#include "vxs_lookup.h"
#include "vxs_lookup_blocks.h"
#include "vxs_space.h"

struct surface_point {
    vec3 position_ws; /* 16 bytes each: vec3 is aligned like vec4 */
    vec3 normal_ws;
};

layout(std430, set = 0, binding = 1) readonly buffer shadow_lights { vxs_light_constants lights[]; };
layout(std430, set = 0, binding = 2) readonly buffer surface { surface_point points[]; };
layout(std430, set = 0, binding = 3) writeonly buffer answers { float lit[]; };
layout(push_constant) uniform lookup { uint light_index, point_count; };

void main()
{
    uint n = gl_GlobalInvocationID.x;
    if (n >= point_count) return;
    vxs_light_constants light = lights[light_index];
    vxs_filter          pcf   = FILTER_IS_SMOOTH != 0 ? vxs_smooth(FILTER_WIDTH_PX) : vxs_box(FILTER_WIDTH_PX);
    lit[n] = vxs_lit(light.first_word, light, points[n].position_ws, points[n].normal_ws, pcf);
}
