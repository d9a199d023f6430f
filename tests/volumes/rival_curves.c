/* Other curves than those of vxs_curve.h; see rival_curves.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/rival_curves.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/volumes/smoke/transmittance_map.h"
#include "tests/volumes/rival_pass.h"

EMBEDDED(moments_glsl)
EMBEDDED(rival_curves_glsl)

enum { HEAD_BYTES = 16, EVENT_BYTES = 16, SEGMENT_BYTES = 16, BUILD, LOOK_UP, PROGRAMS };

struct rival_curves {
    vxs_volumes           *v;
    vxs_transmittance_map *map;
    rival_curve            which;
    uint32_t               knob;
    gl_name                buffer, programs[PROGRAMS];
    float                  block[3]; /* as in rival_curves.glsl */
};

static const char *const names_of[] = {[RIVAL_OPACITY]      = "OPACITY",
                                       [RIVAL_FOURIER]      = "FOURIER",
                                       [RIVAL_MOMENTS]      = "MOMENTS",
                                       [RIVAL_DEEP]         = "DEEP",
                                       [RIVAL_UNCOMPRESSED] = "UNCOMPRESSED"};

static uint64_t texels_of(const rival_curves *r)
{
    return (uint64_t)r->map->side_px * r->map->side_px * r->map->layers;
}

/* In a texel, wherever it is. */
static uint64_t texel_bytes(const rival_curves *r)
{
    static const uint32_t words[] = {[RIVAL_MOMENTS] = 5, [RIVAL_DEEP] = 2, [RIVAL_UNCOMPRESSED] = 1};
    if (r->which == RIVAL_OPACITY) return 4 * (uint64_t)r->knob;
    return r->which == RIVAL_FOURIER ? 8 * (uint64_t)r->knob : 4 * words[r->which];
}

/* Both programs have rival_left; the library's lookup queries it. */
static gl_name program_of(const rival_curves *r, int which)
{
    const char    *pass    = vxs_volumes_text_transmittance_pass_glsl.text;
    const embedded texts[] = {moments_glsl, rival_curves_glsl, {pass, pass + strlen(pass)}};
    char           names[512];
    snprintf(names, sizeof names,
             "#define VXS_CURVE_MOST %u\n#define %s\n#define KNOB %u\n%sfloat rival_left(uint texel, "
             "float depth);\n"
             "#define vxs_curve_left(texel, depth, exponential) rival_left(texel, depth)\n",
             r->map->nodes, names_of[r->which], r->knob, which == BUILD ? "#define BUILD\n" : "");
    return rival_program(r->v, names, &vxs_volumes_text_transmittance_light_glsl, texts, which == BUILD ? 2 : 3);
}

vxs_result rival_curves_create(rival_curves **out, vxs_volumes *v, vxs_transmittance_map *map, rival_curve which, uint32_t knob)
{
    rival_curves *r = calloc(1, sizeof *r);
    *out            = NULL;
    if (!r) return VXS_E_MEMORY;
    *r = (rival_curves){.v = v, .map = map, .which = which, .knob = knob};
    for (int n = BUILD; n < PROGRAMS; n++) r->programs[n] = program_of(r, n);
    r->buffer = vxs_volumes_buffer(v, HEAD_BYTES + texels_of(r) * texel_bytes(r) +
                                          (which == RIVAL_DEEP ? 2 * EVENT_BYTES * (uint64_t)map->segment_room : 0));
    if (r->programs[BUILD] && r->programs[LOOK_UP] && r->buffer) {
        *out = r;
        return VXS_OK;
    }
    vxs_result result = r->buffer ? VXS_E_GL : VXS_E_MEMORY;
    rival_curves_destroy(r);
    return result;
}

void rival_curves_destroy(rival_curves *r)
{
    if (!r) return;
    if (r->buffer) r->v->api.DeleteBuffers(1, &r->buffer);
    for (int n = BUILD; n < PROGRAMS; n++)
        if (r->programs[n]) r->v->api.DeleteProgram(r->programs[n]);
    free(r);
}

static void set(const rival_curves *r)
{
    vxs_transmittance_set(r->map, NULL, 0);
    memcpy(r->v->own.words, r->block, sizeof r->block);
}

void rival_curves_capture(vxs_transmittance_map *map, const vxs_capsules *capsules)
{
    saved_storage saved = vxs_volumes_save_storage(map->volumes);
    vxs_transmittance_capture(map, capsules, NULL);
    vxs_volumes_restore_storage(map->volumes, &saved);
}

void rival_curves_build(rival_curves *r, double nearest, double farthest)
{
    saved_storage saved = vxs_volumes_save_storage(r->v);
    r->block[0]         = (float)nearest;
    r->block[1]         = (float)farthest;
    r->block[2]         = (float)r->knob / 10000;
    set(r);
    r->v->api.ClearNamedBufferSubData(r->buffer, GL_FORMAT_R32UI, 0, HEAD_BYTES, GL_FORMAT_RED_INTEGER, GL_TYPE_UNSIGNED_INT, NULL);
    vxs_volumes_use_storage(r->v, r->map->buffer, r->buffer);
    vxs_transmittance_run(r->map, r->programs[BUILD], NULL);
    vxs_volumes_restore_storage(r->v, &saved);
}

void rival_curves_look_up(rival_curves *r, unsigned texture)
{
    set(r);
    vxs_transmittance_pass(r->map, r->programs[LOOK_UP], r->buffer, texture);
}

uint64_t rival_curves_bytes(const rival_curves *r)
{
    uint32_t used[2] = {0};
    r->v->api.GetNamedBufferSubData(r->buffer, 0, sizeof used, used);
    vxs_transmittance_counts counts = vxs_transmittance_map_counts(r->map);
    uint64_t                 lists  = r->which == RIVAL_DEEP           ? 8 * (uint64_t)used[1]
                                      : r->which == RIVAL_UNCOMPRESSED ? SEGMENT_BYTES * (uint64_t)(counts.segments - counts.merged)
                                                                       : 0;
    return texels_of(r) * texel_bytes(r) + lists;
}
