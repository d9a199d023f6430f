/* The codings behind the seam of columns and words; see light_coder.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/light_coder.h"

#include <stdlib.h>

#include "baker/coding/blocks/blocks.h"

static vxs_result blocks_begin(void *data, const vxs_light *light)
{
    blocks_coder *c = data;
    c->light        = light;
    c->set.fast     = c->packing == VXS_PACKING_FAST;
    return VXS_OK;
}

static vxs_result blocks_add_map(void *data, uint32_t map, const column_map *columns, bake_context *ctx)
{
    blocks_coder *c          = data;
    vxs_result    r          = block_build_map(&c->set, map, columns, ctx);
    c->stats.mask_tiles      = c->set.tile_count;
    c->stats.squares_fetched = c->set.squares_fetched;
    return r;
}

static void free_words(void *owned)
{
    block_words_free(owned);
    free(owned);
}

static vxs_result blocks_finish(void *data, coded_light *out)
{
    blocks_coder *c = data;
    block_words  *w = calloc(1, sizeof *w);
    vxs_result    r = w ? block_words_lay_out(w, &c->set, c->light->levels, vxs_map_count(c->light), c->threads) : VXS_E_MEMORY;
    block_set_free(&c->set);
    if (r != VXS_OK) {
        free(w);
        return r;
    }
    const block_counts *n  = &w->counts;
    const uint32_t packing = c->packing == VXS_PACKING_SMALL && c->light->levels >= FINE_LEVELS ? VXS_PACKING_FINE : c->packing;
    c->counts              = (palette_counts){.pages         = n->pages,
                                              .nodes         = n->nodes,
                                              .blocks        = n->blocks,
                                              .tiles         = n->tiles,
                                              .private_tiles = n->private_tiles,
                                              .patterns      = (uint64_t)n->patterns + n->private_patterns + w->common_count};
    *out                   = (coded_light){
                          .written      = {.light = *c->light, .blocks = {w->words, w->count, w->common_kinds, w->common_count, packing}},
                          .memory_bytes = 4 * (uint64_t)w->count,
                          .owned        = w,
                          .free         = free_words,
    };
    out->written.light.coding = VXS_CODING_BLOCKS;
    return VXS_OK;
}

static vxs_result dag_begin(void *data, const vxs_light *light)
{
    dag_coder *c = data;
    c->light     = light;
    return dag_merger_init(&c->merger, 1u << light->levels, vxs_map_count(light), c->unify);
}

/* Draw the masks of a square into the picture; check the memory limit after each step. */
static vxs_result after_step(void *user, bake_stage stage, column_tree *tree, dag *d)
{
    const dag_coder *c = user;
    (void)d;
    if (c->picture && stage == STAGE_MASKS) light_picture_add_masks(c->picture, tree, c->map);
    return context_has_memory(c->ctx) ? VXS_OK : VXS_E_MEMORY;
}

static vxs_result dag_add_map(void *data, uint32_t map, const column_map *columns, bake_context *ctx)
{
    dag_coder *c   = data;
    c->map         = map;
    c->ctx         = ctx;
    c->build.after = after_step;
    c->build.user  = c;
    return dag_build_map(&c->merger, map, columns, &c->build, &c->stats, ctx);
}

static void free_dag(void *owned)
{
    dag_free(owned);
    free(owned);
}

static vxs_result dag_finish(void *data, coded_light *out)
{
    dag_coder *c = data;
    dag       *d = malloc(sizeof *d);
    vxs_result r = d ? dag_merger_finish(&c->merger, d) : VXS_E_MEMORY;
    if (r != VXS_OK) {
        free(d);
        return r;
    }
    *out = (coded_light){.written      = dag_to_write(c->light, d),
                         .memory_bytes = 20 * dag_node_count(d) + 8 * (uint64_t)d->mask_count,
                         .owned        = d,
                         .free         = free_dag};
    return VXS_OK;
}

void chosen_coder_init(chosen_coder *c, const bake_options *o, compress_order compress, light_picture *picture)
{
    int is_dag = o->coding == CODING_DAG;
    *c         = (chosen_coder){
                .dags   = {.build = build_options_of(o, compress), .unify = o->stop == STOP_FINAL, .picture = picture},
                .blocks = {.threads = o->threads, .packing = (uint32_t)o->pack},
    };
    c->coder = is_dag ? (light_coder){&c->dags, dag_begin, dag_add_map, dag_finish}
                      : (light_coder){&c->blocks, blocks_begin, blocks_add_map, blocks_finish};
    c->stats = is_dag ? &c->dags.stats : &c->blocks.stats;
}

void chosen_coder_free(chosen_coder *c)
{
    dag_merger_free(&c->dags.merger);
    block_set_free(&c->blocks.set);
}
