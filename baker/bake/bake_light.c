/* Baking one light; see bake_light.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/bake_light.h"

#include <stdio.h>

#include "runtime/vxs.h"

static vxs_result bake_map(const light_coder *coder, uint32_t map, const column_source *source, bake_context *ctx)
{
    column_map columns;
    vxs_result r = source->open(source->data, map, &columns, ctx);
    if (r != VXS_OK) return r;
    r = coder->add_map(coder->data, map, &columns, ctx);
    columns.close(columns.data);
    return r;
}

/* Planned seconds of a tile of the light. */
static double tile_seconds(const plan_light *planned)
{
    double light = 0;
    for (int s = STAGE_MAPS; s <= STAGE_MERGE; s++) light += planned->seconds[s];
    return light / (double)planned->tiles;
}

vxs_result bake_light(const plan_light *planned, const column_source *source, const light_coder *coder, coded_light *out,
                      bake_context *ctx)
{
    char doing[sizeof ctx->doing];
    snprintf(doing, sizeof doing, "light %s: tile", planned->name);
    steps_begin(ctx, (uint32_t)planned->tiles, tile_seconds(planned), doing);
    vxs_result r = coder->begin(coder->data, &planned->light);
    for (uint32_t map = 0; map < source->map_count && r == VXS_OK; map++) r = bake_map(coder, map, source, ctx);
    stage_begin(ctx, STAGE_MERGE);
    if (r == VXS_OK && out) r = coder->finish(coder->data, out);
    stage_begin(ctx, STAGE_NONE);
    if (r != VXS_OK) fail(ctx->message, r, "%s while baking light '%s'", vxs_result_text(r), planned->name);
    return r;
}
