/* Baking one light; see bake_light.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/bake_light.h"

#include <stdio.h>

#include "runtime/vxs.h"

/* Masks on their way to a picture. */
typedef struct picture_of_map {
    light_picture *picture;
    uint32_t       map;
} picture_of_map;

static vxs_result show_masks(void *user, bake_stage stage, column_tree *tree, dag *d)
{
    const picture_of_map *p = user;
    (void)d;
    if (stage == STAGE_MASKS) light_picture_add_masks(p->picture, tree, p->map);
    return VXS_OK;
}

static vxs_result bake_map(dag_merger *merger, uint32_t map, const column_source *source, const build_options *build,
                           light_picture *picture, build_stats *stats, bake_context *ctx)
{
    picture_of_map shown = {picture, map};
    build_options  o     = *build;
    column_map     columns;
    vxs_result     r = source->open(source->data, map, &columns, ctx);
    if (r != VXS_OK) return r;
    if (picture) {
        o.after = show_masks;
        o.user  = &shown;
    }
    r = dag_build_map(merger, map, &columns, &o, stats, ctx);
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

vxs_result bake_light(const plan_light *planned, const column_source *source, const build_options *build, int unify,
                      light_picture *picture, dag *out, build_stats *stats, bake_context *ctx)
{
    dag_merger merger;
    char       doing[sizeof ctx->doing];
    vxs_result r;
    snprintf(doing, sizeof doing, "light %s: tile", planned->name);
    steps_begin(ctx, (uint32_t)planned->tiles, tile_seconds(planned), doing);
    r = dag_merger_init(&merger, 1u << planned->light.levels, source->map_count, unify);
    for (uint32_t map = 0; map < source->map_count && r == VXS_OK; map++)
        r = bake_map(&merger, map, source, build, picture, stats, ctx);
    stage_begin(ctx, STAGE_MERGE);
    if (r == VXS_OK) r = dag_merger_finish(&merger, out);
    stage_begin(ctx, STAGE_NONE);
    dag_merger_free(&merger);
    if (r != VXS_OK) fail(ctx->message, r, "%s while baking light '%s'", vxs_result_text(r), planned->name);
    return r;
}
