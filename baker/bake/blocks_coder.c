/* Lights as palette blocks; see blocks_coder.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/blocks_coder.h"

#include <stdlib.h>

#include "baker/coding/blocks/blocks.h"

static vxs_result begin(void *data, const vxs_light *light)
{
    blocks_coder *c = data;
    c->light        = light;
    return VXS_OK;
}

static vxs_result add_map(void *data, uint32_t map, const column_map *columns, bake_context *ctx)
{
    blocks_coder *c          = data;
    vxs_result    r          = block_build_map(&c->set, map, columns, ctx);
    c->stats.mask_tiles      = c->set.tile_count;
    c->stats.squares_fetched = c->set.squares_fetched;
    return r;
}

static palette_counts count_words(const block_words *w)
{
    const block_counts *c = &w->counts;
    return (palette_counts){.pages     = c->pages,
                            .nodes     = c->nodes,
                            .blocks    = c->blocks,
                            .tiles     = c->tiles,
                            .own_tiles = c->own_tiles,
                            .patterns  = (uint64_t)c->patterns + c->own_patterns + w->common_count};
}

static void free_words(void *owned)
{
    block_words_free(owned);
    free(owned);
}

static vxs_result finish(void *data, coded_light *out)
{
    blocks_coder *c = data;
    block_words  *w = calloc(1, sizeof *w);
    vxs_result    r = w ? block_words_lay_out(w, &c->set, c->light->levels, vxs_map_count(c->light), c->threads) : VXS_E_MEMORY;
    block_set_free(&c->set);
    if (r != VXS_OK) {
        free(w);
        return r;
    }
    c->counts = count_words(w);
    *out      = (coded_light){
             .written      = {.light = *c->light, .blocks = {w->words, w->count, w->common_kinds, w->common_count, c->packing}},
             .memory_bytes = 4 * (uint64_t)w->count,
             .owned        = w,
             .free         = free_words,
    };
    out->written.light.coding = VXS_CODING_BLOCKS;
    return VXS_OK;
}

light_coder blocks_coder_seam(blocks_coder *c)
{
    return (light_coder){.data = c, .begin = begin, .add_map = add_map, .finish = finish};
}

void blocks_coder_free(blocks_coder *c)
{
    block_set_free(&c->set);
}
