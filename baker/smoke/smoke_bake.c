/* Bakes smoke into an asset; see smoke_bake.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/smoke/smoke_bake.h"

#include <stdlib.h>

#include "baker/base/parallel.h"
#include "runtime/vxs.h"

static vxs_result make_maps(smoke_map *maps, const vxs_contents *contents, const smoke_source *source,
                            const smoke_settings *settings, bake_context *ctx)
{
    vxs_result r = VXS_OK;
    for (uint32_t n = 0; n < contents->light_count && r == VXS_OK; n++) {
        watch_say(ctx->watch, "light %s: smoke", contents->lights[n].light.name);
        r = smoke_map_make(&maps[n], source, &contents->lights[n], settings, ctx);
    }
    return r;
}

/* Replace the file by one with smoke. */
static vxs_result add_maps(vxs_bytes *file, const vxs_contents *contents, const smoke_map *maps, int zstd_level, message *m)
{
    vxs_bytes       with  = {0};
    uint32_t        some  = 0;
    vxs_smoke_view *views = calloc(contents->light_count, sizeof *views);
    for (uint32_t n = 0; views && n < contents->light_count; n++) {
        views[n] = maps[n].view;
        some += maps[n].counts != NULL;
    }
    vxs_result r = !views ? VXS_E_MEMORY
                   : some ? vxs_write_smoke(&with, file->data, file->size_bytes, contents, views, zstd_level)
                          : VXS_OK;
    free(views);
    if (r == VXS_OK && some) {
        free(file->data);
        *file = with;
    } else
        free(with.data);
    return r == VXS_OK ? r
                       : fail(m, r, "smoke cannot be encoded: %s", r == VXS_E_MEMORY ? "out of memory" : "there is too much of it");
}

static void count_maps(smoke_counts *counts, const smoke_map *maps, uint32_t light_count)
{
    for (uint32_t n = 0; n < light_count; n++)
        counts[n] = (smoke_counts){.side_px       = maps[n].counts ? 1u << maps[n].view.levels : 0,
                                   .texels        = maps[n].texel_count,
                                   .curves        = maps[n].curve_count,
                                   .nodes         = maps[n].node_count,
                                   .largest_error = maps[n].largest_error,
                                   .lookups       = maps[n].lookups,
                                   .memory_bytes  = maps[n].word_count * 4};
}

vxs_result smoke_bake(vxs_bytes *file, const smoke_source *source, const smoke_settings *settings, int zstd_level,
                      smoke_counts *counts, bake_context *ctx)
{
    vxs_contents  contents = {0};
    vxs_parallel  threads  = parallel_lent(ctx->threads);
    vxs_read_desc desc     = {.parallel = &threads};
    vxs_result    r        = vxs_read(&contents, file->data, file->size_bytes, &desc);
    if (r != VXS_OK) return fail(ctx->message, r, "the encoded asset cannot be read back for its smoke: %s", vxs_result_text(r));
    smoke_map *maps = calloc(contents.light_count, sizeof *maps);
    if (!maps) r = fail(ctx->message, VXS_E_MEMORY, "out of memory for the smoke of %u lights", contents.light_count);
    if (r == VXS_OK) r = make_maps(maps, &contents, source, settings, ctx);
    if (r == VXS_OK) r = add_maps(file, &contents, maps, zstd_level, ctx->message);
    if (r == VXS_OK) count_maps(counts, maps, contents.light_count);
    for (uint32_t n = 0; maps && n < contents.light_count; n++) smoke_map_free(&maps[n]);
    free(maps);
    vxs_contents_free(&contents);
    return r;
}
