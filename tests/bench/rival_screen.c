/* Pixels of a picture, and the voxels that they look up; see rival_screen.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "formats/vxs_space.h" /* before bake.h, whose structs are called as variables are there */

#include "tests/bench/rival_screen.h"

#include "baker/base/vec3.h"

enum { TILE_PX = 8 };

vxs_result screen_open(screen *out, const rival_maps *maps, const camera_pose *camera, uint32_t width_px, uint32_t height_px,
                       run_context *m)
{
    *out      = (screen){.maps = maps, .camera = *camera, .width_px = width_px, .height_px = height_px};
    out->view = camera_view_of(camera, (double)width_px / height_px);
    return truth_create(&out->rays, &maps->casters, 1, m);
}

int screen_voxel(const screen *s, uint32_t x, uint32_t y, vxs_filter filter, voxel_at *at)
{
    double  way[3], metres, normal_ws[3], point_ws[3];
    int32_t last = (1 << s->maps->levels) - 1;
    camera_direction(&s->view, (x + 0.5) / s->width_px, (y + 0.5) / s->height_px, way);
    if (!truth_first_hit(s->rays, s->camera.eye_ws, way, &metres, normal_ws, NULL)) return 0;
    vec3_mad(s->camera.eye_ws, metres, way, point_ws);
    if (vec3_dot(normal_ws, way) > 0) /* seen from behind */
        for (int n = 0; n < 3; n++) normal_ws[n] = -normal_ws[n];
    vxs_place place = vxs_place_from_ws(&s->maps->light, point_ws, normal_ws, filter);
    if (place.map < 0 || place.voxel[2] < 0) return 0;
    *at = (voxel_at){place.voxel[0], place.voxel[1], place.voxel[2] < last ? place.voxel[2] : last, place.across | place.down << 8};
    return 1;
}

size_t screen_voxels(const screen *s, vxs_filter filter, voxel_at *at)
{
    size_t count = 0;
    for (uint32_t top = 0; top < s->height_px; top += TILE_PX)
        for (uint32_t left = 0; left < s->width_px; left += TILE_PX)
            for (uint32_t y = top; y < top + TILE_PX && y < s->height_px; y++)
                for (uint32_t x = left; x < left + TILE_PX && x < s->width_px; x++)
                    count += (size_t)screen_voxel(s, x, y, filter, &at[count]);
    return count;
}

void screen_close(screen *s)
{
    truth_destroy(s->rays);
}
