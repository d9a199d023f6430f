/* Spheres of a scene, from its triangles; see volumes_bench.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/bench/volumes_bench.h"

#include <stdlib.h>

#include "baker/base/box.h"
#include "baker/base/vec3.h"
#include "baker/light/map_space.h"

static sphere sphere_in(const box *b)
{
    sphere s = {.radius = 0.5 * (b->max[0] - b->min[0])};
    for (int n = 0; n < 3; n++) s.centre[n] = 0.5 * (b->min[n] + b->max[n]);
    return s;
}

static int holds_light(const sphere *s, const light_shape *light)
{
    double to[3];
    vec3_sub(light->position_ws, s->centre, to);
    return light->kind != LIGHT_DIRECTIONAL && vec3_dot(to, to) < s->radius * s->radius;
}

vxs_result volumes_find_spheres(bench *b, run_context *m)
{
    const casters *c     = &b->casting;
    size_t         count = 0, kept = 0;
    for (int kind = 0; kind < COMPONENT_KINDS; kind++) count += c->component_count[kind];
    box    *boxes    = calloc(count, sizeof *boxes);
    sphere *at       = calloc(count, sizeof *at);
    b->spheres.at    = at;
    b->spheres.light = baked_light_shape(&vxs_asset_light(b->asset, b->number)->light);
    if (!boxes || !at) {
        free(boxes);
        return fail(m, VXS_E_MEMORY, "out of memory for spheres");
    }
    for (size_t n = 0; n < count; n++) boxes[n] = box_empty();
    for (size_t n = 0; n < 3 * c->triangle_count; n++)
        box_add(&boxes[c->component_of[n / 3]], &c->positions_ws[3 * (size_t)c->indices[n]]);
    for (size_t n = 0; n < count; n++) {
        at[kept] = sphere_in(&boxes[n]);
        kept += !holds_light(&at[kept], &b->spheres.light);
    }
    b->spheres.count = kept;
    free(boxes);
    return VXS_OK;
}
