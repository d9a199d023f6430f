/* Casters of a scene; see casters.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/casters/casters.h"

#include <stdlib.h>

#include "baker/base/box.h"

void casters_free(casters *c)
{
    free(c->positions_ws);
    free(c->indices);
    free(c->double_sided);
    free(c->component_of);
    free(c->edge_mates);
    free(c->kind_of);
    free(c->parts_of);
    free(c->boxes);
    free(c->runs);
    free(c->solid_meets);
    free(c->alpha_masks);
    free(c->alpha_mask_first);
    free(c->hole_uvs);
    *c = (casters){0};
}

vxs_result casters_find_runs(casters *c, run_context *m)
{
    size_t count = casters_run_count(c);
    if (!(c->runs = malloc((count + 1) * sizeof *c->runs))) return fail(m, VXS_E_MEMORY, "out of memory for the reach of lights");
    for (size_t n = 0; n < count; n++) {
        size_t first = n * CASTERS_RUN;
        c->runs[n]   = box_of_corners(c->positions_ws, c->indices + 3 * first, 3 * (casters_run_end(c, n) - first));
    }
    return VXS_OK;
}

box casters_bounds(const casters *c)
{
    box all = box_empty();
    if (c->borders.joined) return box_of_corners(c->positions_ws, c->indices, 3 * c->triangle_count); /* boxes are older */
    for (size_t n = 0; n < casters_component_count(c); n++) {
        box_add(&all, c->boxes[n].min);
        box_add(&all, c->boxes[n].max);
    }
    return all;
}

const char *component_kind_name(component_kind kind)
{
    static const char *const names[COMPONENT_KINDS] = {
        [COMPONENT_SOLID]              = "solid",
        [COMPONENT_SHEET_FORCED]       = "forced",
        [COMPONENT_SHEET_ALPHA_MASK]   = "alpha mask",
        [COMPONENT_SHEET_OPEN]         = "open",
        [COMPONENT_SHEET_DOUBLE_SIDED] = "double sided",
        [COMPONENT_SHEET_INWARD]       = "inward",
        [COMPONENT_SHEET_OCCUPIED]     = "occupied",
    };
    return (unsigned)kind < COMPONENT_KINDS ? names[kind] : "unknown";
}
