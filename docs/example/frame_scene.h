/* What is there in frame.c beside the level: a screen, a column of smoke, rubble before the screen, a board over the ground; and
 * how the ground is lit. Places are metres from the eye, which is 10 m above the ground and looks along z.
 * SPDX-License-Identifier: MIT */
#ifndef FRAME_SCENE_H
#define FRAME_SCENE_H

#include "gl_picture.h"

#include <vxs_area_light.h>
#include <vxs_transmittance.h>

static const vxs_area_rectangle rectangle = {{6, -9.5F, 36}, {-12, 0, 0}, {0, 6, 0}, {0.6F, 1.2F, 2.4F}, NULL, 0, 0};
static const vxs_capsule        column    = {{-4, -10, 22}, 1.5F, {-2, 2, 24}, 0.6F};
static const vxs_area_point     rubble[]  = {{{0, -9, 30}, 2}, {{1, -9, 30}, 2}, {{-3, -9, 31}, 2}, {{4, -9, 29}, 2}};

/* A board of 8 x 8 m in the way of a sun's light, as a depth map of one texel. */
static vxs_moving_casters board_at(const vxs_light *sun, const double eye_ws[3], const double place_ws[3])
{
    static const float depth = 0.5F;
    vxs_moving_casters board = {.depth_texture = gl_texture(1, 1, &depth), .width_px = 1, .height_px = 1, .empty_depth = 1};
    for (int row = 0; row < 3; row++) {
        const double *m = sun->ls_from_ws + 4 * row, scale = (row < 2 ? sun->texel_metres : sun->voxel_metres) / 8;
        board.depth_from_point[12 + row] = 0.5F;
        for (int n = 0; n < 3; n++) {
            board.depth_from_point[4 * n + row] = (float)(scale * m[n]);
            board.depth_from_point[12 + row] += (float)(scale * m[n] * (eye_ws[n] - place_ws[n]));
        }
    }
    board.depth_from_point[15] = 1;
    return board;
}

/* Behind the texts of vxs_gl_texts. */
static const char *const shade =
    "layout(binding = 0) uniform sampler2D depths; layout(binding = 1) uniform sampler2D smoke; layout(binding = 2) uniform "
    "sampler2D screen;"
    "layout(binding = 3) uniform sampler2DArray first_shadow; uniform mat4 point_from_depth; out vec4 colour;\n"
    "void main() { ivec2 pixel = ivec2(gl_FragCoord.xy); float depth = texelFetch(depths, pixel, 0).r;\n"
    "    vec4 at = point_from_depth * vec4(gl_FragCoord.xy / vec2(textureSize(depths, 0)), depth, 1.0);\n"
    "    vec3 ls; vxs_ls_from_ws(vxs_light_at(0u), at.xyz / at.w, 1.0, ls);\n"
    "    vec2 texel = ls.xy / exp2(float(vxs_light_at(0u).levels)) * vec2(textureSize(first_shadow, 0).xy);\n"
    "    float lit = max(vxs_lit_by(0u, at.xyz / at.w, vec3(0, 1, 0), vxs_box(5)), 0.0) * texelFetch(smoke, pixel, 0).r\n"
    "        * step(ls.z, texelFetch(first_shadow, ivec3(texel, 0), 0).r + 1.0 / vxs_light_at(0u).voxel_metres);\n"
    "    vec3 light = vec3(0.1, 0.12, 0.15) + lit * vec3(1.0, 0.95, 0.85) + texelFetch(screen, pixel, 0).rgb;\n"
    "    colour = vec4(depth > 0.0 ? 0.45 * light : vec3(0.3, 0.4, 0.5), 1.0); }\n";

#endif
