/* Froxels; see rival_froxels.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/rival_froxels.h"

#include <stdlib.h>

#include "tests/volumes/rival_pass.h"

EMBEDDED(rival_froxels_glsl)

enum { FILL, SHOW, PROGRAMS };

struct rival_froxels {
    vxs_volumes *v;
    uint32_t     wide, high, deep;
    gl_name      cells, programs[PROGRAMS];
};

vxs_result rival_froxels_create(rival_froxels **out, vxs_volumes *v, uint32_t wide, uint32_t high, uint32_t deep)
{
    rival_froxels *f = calloc(1, sizeof *f);
    *out             = NULL;
    if (!f) return VXS_E_MEMORY;
    *f = (rival_froxels){.v = v, .wide = wide, .high = high, .deep = deep};
    for (int n = 0; n < PROGRAMS; n++)
        f->programs[n] = rival_program(v, n == FILL ? "#define FILL\n" : "#define SHOW\n", &rival_froxels_glsl, 1);
    f->cells = vxs_volumes_texture(v, GL_FORMAT_RGBA32F, wide, high, deep);
    if (f->programs[FILL] && f->programs[SHOW] && f->cells) {
        *out = f;
        return VXS_OK;
    }
    vxs_result result = f->cells ? VXS_E_GL : VXS_E_MEMORY;
    rival_froxels_destroy(f);
    return result;
}

void rival_froxels_destroy(rival_froxels *f)
{
    if (!f) return;
    if (f->cells) f->v->api.DeleteTextures(1, &f->cells);
    for (int n = 0; n < PROGRAMS; n++)
        if (f->programs[n]) f->v->api.DeleteProgram(f->programs[n]);
    free(f);
}

vxs_result rival_froxels_add(rival_froxels *f, const vxs_volumes_light *light, const vxs_light_map *map)
{
    vxs_volumes *v      = f->v;
    vxs_result   result = vxs_volumes_set_light(v, light, map);
    if (result != VXS_OK) return result;
    rival_run(v, f->programs[FILL], map, f->cells, GL_FORMAT_RGBA32F, rival_groups(f->wide, 8), rival_groups(f->high, 8), 1);
    rival_run(v, f->programs[SHOW], map, f->cells, GL_FORMAT_RGBA32F, rival_groups((uint32_t)v->frame.wide_px, 8),
              rival_groups((uint32_t)v->frame.high_px, 8), 1);
    return VXS_OK;
}
