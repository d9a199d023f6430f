/* Palette blocks, as vxs bake --coding blocks makes them; see rival.h. The stages are the baker's.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "formats/vxs_lookup_blocks.h" /* before blocks.h, whose blocks it calls so, too */
#include "runtime/taps_many.h"
#include "runtime/vxs.h"

#include "baker/base/parallel.h"
#include "baker/coding/blocks/blocks.h"
#include "tests/bench/rival.h"
#include "tests/columns/stored_maps.h"

static vxs_result blocks_build(rival_maps *maps, const void *options, vxs_bytes *file)
{
    run_context  m       = {0};
    bake_context ctx     = {.run = &m, .threads = maps->threads};
    column_map   columns = stored_map(&maps->maps);
    block_set    set     = {0};
    block_words  words   = {0};
    (void)options;
    depth_maps_reduce(&maps->maps, maps->threads);
    vxs_result r = block_build_map(&set, 0, &columns, &ctx);
    if (r == VXS_OK) r = block_words_lay_out(&words, &set, maps->levels, 1, maps->threads);
    block_set_free(&set);
    if (r == VXS_OK) {
        vxs_write_light light = {.light  = maps->light,
                                 .blocks = {words.words, words.count, words.common_kinds, words.common_count}};
        vxs_parallel    lent  = parallel_lent(maps->threads);
        vxs_write_desc  desc  = {.lights = &light, .light_count = 1, .zstd_level = RIVAL_ZSTD_LEVEL, .parallel = &lent};
        light.light.coding    = VXS_CODING_BLOCKS;
        r                     = vxs_write(file, &desc);
    }
    block_words_free(&words);
    return r;
}

static vxs_result blocks_open(const rival_maps *maps, const void *options, const vxs_bytes *file, rival_asset *asset)
{
    vxs_asset   *opened = NULL;
    vxs_parallel lent   = parallel_lent(maps->threads);
    vxs_result   r      = vxs_asset_open(&opened, file->data, file->size_bytes, &(vxs_read_desc){.parallel = &lent});
    (void)options;
    if (r == VXS_OK) *asset = (rival_asset){opened, (uint64_t)vxs_asset_light(opened, 0)->word_count * sizeof(uint32_t)};
    return r;
}

static void blocks_count_dark(const void *state, const voxel_at *at, size_t count, vxs_filter filter, uint32_t *dark)
{
    const vxs_baked_light *light = vxs_asset_light(state, 0);
    const uint32_t        *words = light->words, levels = light->light.levels;
    for (size_t n = 0; n < count && filter.is_smooth; n++)
        dark[n] = vxs_blocks_shadow_weight(words, 0, levels, at[n].i, at[n].j, at[n].within & 255, at[n].within >> 8,
                                           (uint32_t)at[n].k, filter.width_px);
    for (size_t n = 0; n < count && !filter.is_smooth; n++)
        dark[n] = filter.width_px == 1
                      ? vxs_blocks_shadow(words, 0, levels, (uint32_t)at[n].i, (uint32_t)at[n].j, (uint32_t)at[n].k)
                      : vxs_blocks_shadow_count(words, 0, levels, at[n].i, at[n].j, (uint32_t)at[n].k, filter.width_px);
}

void asset_count_dark_batch(const void *state, const voxel_at *at, size_t count, vxs_filter filter, uint32_t *dark)
{
    vxs_taps taps;
    vxs_taps_init(&taps, vxs_asset_light(state, 0));
    for (size_t n = 0; n < count && filter.is_smooth; n++)
        dark[n] = vxs_taps_part(&taps, (vxs_place){0, {at[n].i, at[n].j, at[n].k}, at[n].within & 255, at[n].within >> 8},
                                (uint32_t)at[n].k, filter.width_px);
    for (size_t n = 0; n < count && !filter.is_smooth; n++)
        dark[n] = vxs_taps_at(&taps, 0, at[n].i, at[n].j, (uint32_t)at[n].k, filter.width_px);
}

static void blocks_close(void *state)
{
    vxs_asset_close(state);
}

const rival block_rivals[] = {
    {"palette blocks", "--coding blocks: depths of 32 x 32 blocks, and patterns of tiles that use them", NULL, RIVAL_SMOOTH,
     blocks_build, blocks_open, blocks_count_dark, blocks_close},
    {"palette blocks, batch", "the same file, asked as vxs_lookup_batch does: what one lookup needed is kept for the next", NULL,
     RIVAL_SMOOTH, blocks_build, blocks_open, asset_count_dark_batch, blocks_close},
    {.name = NULL},
};
