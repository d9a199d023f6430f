/* Froxels; see rival_froxels.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/rival_froxels.h"

#include <stdlib.h>

#include "tests/volumes/rival_pass.h"

EMBEDDED(rival_froxels_glsl)
EMBEDDED(rival_rectangle_glsl)

enum { FILL, SHOW, PROGRAMS };

struct rival_froxels {
    vxs_volumes *v;
    uint32_t     wide, high, deep;
    gl_name      cells, programs[PROGRAMS];
};

/* texts  [count] the rectangle's before the froxels', or those alone */
static vxs_result create(rival_froxels **out, vxs_volumes *v, uint32_t wide, uint32_t high, uint32_t deep, const embedded *texts,
                         size_t count)
{
    rival_froxels *f = calloc(1, sizeof *f);
    *out             = NULL;
    if (!f) return VXS_E_MEMORY;
    *f = (rival_froxels){.v = v, .wide = wide, .high = high, .deep = deep};
    for (int n = 0; n < PROGRAMS; n++)
        f->programs[n] = rival_program(v, n == FILL ? "#define FILL\n" : "#define SHOW\n", NULL, texts, count);
    f->cells = vxs_volumes_texture(v, GL_FORMAT_RGBA32F, wide, high, deep);
    if (f->programs[FILL] && f->programs[SHOW] && f->cells) {
        *out = f;
        return VXS_OK;
    }
    vxs_result result = f->cells ? VXS_E_GL : VXS_E_MEMORY;
    rival_froxels_destroy(f);
    return result;
}

vxs_result rival_froxels_create(rival_froxels **out, vxs_volumes *v, uint32_t wide, uint32_t high, uint32_t deep)
{
    return create(out, v, wide, high, deep, &rival_froxels_glsl, 1);
}

vxs_result rival_froxels_create_rectangle(rival_froxels **out, vxs_volumes *v, uint32_t wide, uint32_t high, uint32_t deep)
{
    const embedded texts[] = {rival_rectangle_glsl, rival_froxels_glsl};
    return create(out, v, wide, high, deep, texts, 2);
}

void rival_froxels_destroy(rival_froxels *f)
{
    if (!f) return;
    if (f->cells) f->v->api.DeleteTextures(1, &f->cells);
    for (int n = 0; n < PROGRAMS; n++)
        if (f->programs[n]) f->v->api.DeleteProgram(f->programs[n]);
    free(f);
}

/* Of the light that is set. */
static void add(const rival_froxels *f, const vxs_shadow_depth_map *map)
{
    vxs_volumes *v = f->v;
    rival_run(v, f->programs[FILL], map, f->cells, GL_FORMAT_RGBA32F, rival_groups(f->wide, 8), rival_groups(f->high, 8), 1);
    rival_run(v, f->programs[SHOW], map, f->cells, GL_FORMAT_RGBA32F, rival_groups((uint32_t)v->frame.wide_px, 8),
              rival_groups((uint32_t)v->frame.high_px, 8), 1);
}

vxs_result rival_froxels_add(rival_froxels *f, const vxs_volumes_light *light, const vxs_shadow_depth_map *map)
{
    vxs_result result = vxs_volumes_set_light(f->v, light, map);
    if (result == VXS_OK) add(f, map);
    return result;
}

static float mean_of(const vxs_area_rectangle *r, uint32_t channel)
{
    double sum = 0, count = (double)r->wide_px * r->high_px;
    if (!r->texture) return 1;
    for (size_t n = 0; n < (size_t)r->wide_px * r->high_px; n++) sum += (double)r->texture[3 * n + channel];
    return (float)(sum / count);
}

vxs_result rival_froxels_add_rectangle(rival_froxels *f, const vxs_area_rectangle *rectangle, const vxs_volumes_light *centre,
                                       const vxs_shadow_depth_map *map)
{
    vxs_result   result = vxs_volumes_set_light(f->v, centre, map);
    frame_block *frame  = &f->v->frame;
    if (result != VXS_OK) return result;
    for (uint32_t n = 0; n < 3; n++) {
        frame->colour[n]       = rectangle->radiance[n] * mean_of(rectangle, n);
        f->v->own.words[n]     = rectangle->corner[n];
        f->v->own.words[4 + n] = rectangle->across[n];
        f->v->own.words[8 + n] = rectangle->up[n];
    }
    add(f, map);
    return VXS_OK;
}
