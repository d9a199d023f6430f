/* Marches, and exact intervals; see vxs_volumes.h.
 * SPDX-License-Identifier: MIT */
#include <stdio.h>

#include "transmittance_map.h"
#include "volumes_state.h"

/* Steps of one dispatch. llvmpipe ends all loops of an invocation after 65535 iterations; a step with a lookup in a DAG and four
 * curves of smoke may need 100. */
enum { STEPS_AT_ONCE = 512 };

static void add_steps(vxs_volumes *v, gl_name program, const vxs_shadow_depth_map *map, uint32_t steps)
{
    for (uint32_t first = 0; first < steps; first += STEPS_AT_ONCE) {
        v->own.march.first = first;
        v->own.march.end   = steps - first < STEPS_AT_ONCE ? steps : first + STEPS_AT_ONCE;
        vxs_volumes_add(v, program, map ? vxs_shadow_depth_map_texture(map) : 0);
    }
}

/* The program of a march.   map  NULL: of the asset */
static gl_name march_program(vxs_volumes *v, const vxs_shadow_depth_map *map, int is_dimmed, vxs_steps which)
{
    char all[PROGRAM_NAMES];
    snprintf(all, sizeof all, "%s%s%s", is_dimmed ? VXS_SMOKE_NAMES : "", map ? "" : "#define VXS_ASK_ASSET\n",
             which == VXS_STEPS_EVEN ? "#define VXS_MARCH_EVEN\n" : "");
    const volumes_text *with = is_dimmed ? &vxs_volumes_text_transmittance_light_glsl : NULL;
    return vxs_volumes_light_program(v, &(program_texts){.names = all, .with = with, .body = &vxs_volumes_text_march_glsl});
}

/* March through smoke. */
static void march_dimmed(vxs_volumes *v, const vxs_volumes_light *light, const vxs_shadow_depth_map *map, uint32_t steps,
                         vxs_steps which)
{
    saved_storage saved = vxs_volumes_save_storage(v);
    vxs_transmittance_set_reader(light->smoke, (vxs_curve_lookup)light->smoke_lookup);
    vxs_volumes_use_storage(v, light->smoke->buffer, 0);
    add_steps(v, march_program(v, map, 1, which), map, steps);
    vxs_volumes_restore_storage(v, &saved);
}

vxs_result vxs_volumes_march(vxs_volumes *v, const vxs_volumes_light *light, const vxs_shadow_depth_map *map, uint32_t steps,
                             vxs_steps which)
{
    enum { STEPS_MAX = 65536 };
    if (!steps || steps > STEPS_MAX || (which != VXS_STEPS_EVEN && which != VXS_STEPS_EQUIANGULAR)) return VXS_E_ARGUMENT;
    if (!map && light->constants)
        return vxs_volumes_fail(v, VXS_E_ARGUMENT,
                                "vxs_volumes_march: a light with constants has no asset: pass its shadow depth map");
    vxs_result result = vxs_volumes_set_light(v, light, map);
    if (result != VXS_OK) return result;
    if (light->smoke && !vxs_transmittance_is_of(light->smoke, v, light)) return VXS_E_ARGUMENT;
    v->own.march = (march_block){.steps = steps, .baked_number = light->constants ? 0 : light->baked_number};
    if (light->smoke)
        march_dimmed(v, light, map, steps, which);
    else
        add_steps(v, march_program(v, map, 0, which), map, steps);
    return vxs_volumes_done(v);
}

/* Modes as in intervals.glsl. There, all pieces after the first are INTERVALS_NEXT. */
enum { INTERVALS_WHOLE, INTERVALS_FIRST, INTERVALS_NEXT, PIECES_MAX = 65536 };

static void add_intervals(vxs_volumes *v, int piece)
{
    static const uint32_t none = 0;
    v->own.intervals           = (intervals_block){(uint32_t)piece};
    if (piece != INTERVALS_WHOLE) vxs_volumes_put(v, v->cut_buffer, 0, sizeof none, &none);
    vxs_volumes_add(v, vxs_volumes_light_program(v, &(program_texts){.body = &vxs_volumes_text_intervals_glsl}), 0);
}

static vxs_result intervals(vxs_volumes *v, const vxs_volumes_light *light, int in_pieces)
{
    if (light->constants || light->smoke) return VXS_E_ARGUMENT;
    vxs_result result = vxs_volumes_set_light(v, light, NULL);
    if (result != VXS_OK) return result;
    saved_storage saved = vxs_volumes_save_storage(v);
    vxs_volumes_use_storage(v, v->cut_buffer, 0);
    add_intervals(v, in_pieces ? INTERVALS_FIRST : INTERVALS_WHOLE);
    for (uint32_t n = 0; in_pieces && n < PIECES_MAX && vxs_volumes_cut(v); n++) add_intervals(v, INTERVALS_NEXT);
    vxs_volumes_restore_storage(v, &saved);
    return vxs_volumes_done(v);
}

vxs_result vxs_volumes_intervals(vxs_volumes *v, const vxs_volumes_light *light)
{
    return intervals(v, light, 0);
}

vxs_result vxs_volumes_intervals_in_pieces(vxs_volumes *v, const vxs_volumes_light *light)
{
    return intervals(v, light, 1);
}

uint32_t vxs_volumes_cut(const vxs_volumes *v)
{
    uint32_t rays = 0;
    v->api.GetNamedBufferSubData(v->cut_buffer, 0, sizeof rays, &rays);
    return rays;
}
