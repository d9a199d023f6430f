/* What pictures are drawn with, and of what; see volumes_bench.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>
#include <stdlib.h>

#include "baker/lab/opengl/gl.h"
#include "tests/bench/volumes_bench.h"

static void say(vxs_severity severity, const char *text, void *user)
{
    (void)severity;
    (void)user;
    fprintf(stderr, "%s\n", text);
}

vxs_result volumes_open_gl(bench *b, run_context *m)
{
    vxs_result r = gl_context_create(&b->gl, b->backend, b->threads, m);
    if (r != VXS_OK) return r;
    vxs_gl_desc words = {.struct_size = sizeof words, .get_proc_address = gl_lookup, .user = b->gl, .asset = b->asset};
    if ((r = vxs_gl_create(&b->shadows, &words)) != VXS_OK)
        return fail(m, r, "the words cannot be uploaded: %s", vxs_result_text(r));
    vxs_gl_upload(b->shadows, SIZE_MAX);
    vxs_gl_origin(b->shadows, b->pose.eye_ws);
    vxs_volumes_desc desc = {.struct_size      = sizeof desc,
                             .get_proc_address = gl_lookup,
                             .user             = b->gl,
                             .shadows          = b->shadows,
                             .width_px         = b->width,
                             .height_px        = b->height,
                             .log              = say,
                             .has_half         = 1};
    if ((r = vxs_volumes_create(&b->volumes, &desc)) != VXS_OK) return fail(m, r, "no fog: %s", vxs_result_text(r));
    b->picture = vxs_volumes_airlight(b->volumes);
    return VXS_OK;
}

void volumes_close_gl(bench *b)
{
    vxs_volumes_destroy(b->volumes);
    vxs_gl_destroy(b->shadows);
    gl_context_destroy(b->gl);
    vxs_asset_close(b->asset);
}

vxs_result volumes_load_scene(bench *b, run_context *m)
{
    scene_choice choice = {0};
    vxs_result   r      = scene_load_gltf(&b->scene, b->scene_path, &choice, m);
    if (r == VXS_OK) r = casters_from_scene(&b->casting, &b->scene, CLOSED_OFF, b->threads, m);
    if (r == VXS_OK) r = truth_create(&b->truth, &b->casting, b->threads, m);
    if (r != VXS_OK) return r;
    box    bounds    = box_of_corners(b->casting.positions_ws, b->casting.indices, 3 * b->casting.triangle_count);
    double size      = box_diagonal(&bounds);
    b->far_metres    = 2 * size;
    b->radius_metres = 5e-4 * size;
    b->medium        = fog_of(&b->fog);
    b->pixels        = (size_t)b->width * b->height;
    b->wanted        = malloc(3 * CAMERAS * b->pixels * sizeof *b->wanted);
    b->classes       = malloc(b->pixels);
    return b->wanted && b->classes ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for a picture");
}

void volumes_free_scene(bench *b)
{
    truth_destroy(b->truth);
    casters_free(&b->casting);
    scene_free(&b->scene);
    free(b->wanted);
    free(b->classes);
}

float *volumes_casters_from_eye(const bench *b)
{
    size_t count = 3 * b->casting.vertex_count;
    float *laid  = malloc(count * sizeof *laid);
    for (size_t n = 0; n < count && laid; n++) laid[n] = (float)(b->casting.positions_ws[n] - b->pose.eye_ws[n % 3]);
    return laid;
}

vxs_result volumes_open_map(const bench *b, uint32_t number, uint32_t side_px, vxs_shadow_depth_map **map)
{
    vxs_shadow_depth_map_desc desc = {.baked_number = vxs_baked_number(number), .side_px = side_px};
    vxs_result                r    = vxs_shadow_depth_map_create(map, b->volumes, &desc);
    while (r == VXS_OK && vxs_shadow_depth_map_fill(*map, 1 << 20)) continue;
    return r;
}
