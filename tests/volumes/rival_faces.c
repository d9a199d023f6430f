/* Marches of faces; see rival_faces.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/rival_faces.h"

#include <stdlib.h>
#include <string.h>

#include "tests/volumes/rival_pass.h"

EMBEDDED(rival_faces_glsl)

struct rival_faces {
    vxs_volumes *v;
    gl_name      march;
};

vxs_result rival_faces_create(rival_faces **out, vxs_volumes *v)
{
    const char    *march   = vxs_volumes_text_march_glsl.text;
    const embedded texts[] = {rival_faces_glsl, {march, march + strlen(march)}};
    rival_faces   *f       = calloc(1, sizeof *f);
    *out                   = f;
    if (!f) return VXS_E_MEMORY;
    *f = (rival_faces){v, rival_program(v, "", &vxs_volumes_text_area_map_glsl, texts, 2)};
    if (f->march) return VXS_OK;
    rival_faces_destroy(f);
    *out = NULL;
    return VXS_E_GL;
}

void rival_faces_destroy(rival_faces *f)
{
    if (!f) return;
    if (f->march) f->v->api.DeleteProgram(f->march);
    free(f);
}

vxs_result rival_faces_march(rival_faces *f, const vxs_vpl *punctual, uint32_t baked, const vxs_shadow_depth_map *map,
                             uint32_t steps)
{
    vxs_volumes_light light = {.baked_number = vxs_baked_number(baked), .radius_metres = punctual->radius_metres};
    memcpy(light.colour, punctual->colour, sizeof light.colour);
    vxs_result result = vxs_volumes_set_light(f->v, &light, map);
    if (result != VXS_OK) return result;
    memcpy(f->v->frame.axis, punctual->normal, sizeof punctual->normal);
    f->v->own.march = (march_block){.steps = steps, .end = steps};
    vxs_volumes_add(f->v, f->march, vxs_shadow_depth_map_texture(map));
    return VXS_OK;
}
