/* Palette blocks; see rival.h. The stages are the baker's; a file is what lies in memory, as zstd makes it smaller.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>
#include <zstd.h>

#include "formats/vxs_bytes.h"
#include "formats/vxs_lookup_blocks.h"

#include "baker/blocks/block_build.h"
#include "baker/blocks/block_words.h"
#include "tests/bench/rival.h"

typedef struct blocks_asset {
    uint32_t *words, levels;
} blocks_asset;

static vxs_result blocks_build(light_maps *maps, const void *options, vxs_bytes *file)
{
    message      m       = {.quiet = 1};
    bake_context ctx     = {.message = &m, .threads = 1};
    column_map   columns = depth_maps_map(&maps->maps);
    block_set    set     = {0};
    block_words  words   = {0};
    (void)options;
    depth_maps_reduce(&maps->maps, 1);
    vxs_result r = block_build_map(&set, 0, &columns, &ctx);
    if (r == VXS_OK) r = block_words_lay_out(&words, &set, maps->levels, 1);
    block_set_free(&set);
    if (r != VXS_OK) return r;

    size_t bytes = (size_t)words.count * sizeof *words.words, bound = ZSTD_compressBound(bytes);
    file->data = malloc(4 + bound);
    if (file->data) {
        vxs_store32(file->data, words.count);
        file->size_bytes = 4 + ZSTD_compress(file->data + 4, bound, words.words, bytes, RIVAL_ZSTD_LEVEL);
    }
    block_words_free(&words);
    return file->data ? VXS_OK : VXS_E_MEMORY;
}

static vxs_result blocks_open(const light_maps *maps, const void *options, const vxs_bytes *file, rival_asset *asset)
{
    blocks_asset *a     = calloc(1, sizeof *a);
    size_t        bytes = (size_t)vxs_load32(file->data) * sizeof *a->words;
    (void)options;
    if (a) a->words = calloc(1, bytes + BLOCK_SPARE_WORDS * sizeof *a->words);
    if (!a || !a->words) {
        free(a);
        return VXS_E_MEMORY;
    }
    a->levels = maps->levels;
    *asset    = (rival_asset){a, bytes};
    return ZSTD_decompress(a->words, bytes, file->data + 4, file->size_bytes - 4) == bytes ? VXS_OK : VXS_E_CORRUPT;
}

static void blocks_count_dark(const void *state, const voxel_at *at, size_t count, int32_t filter_px, uint32_t *dark)
{
    const blocks_asset *a = state;
    for (size_t n = 0; n < count; n++)
        dark[n] = filter_px == 1
                      ? vxs_blocks_shadow(a->words, 0, a->levels, (uint32_t)at[n].i, (uint32_t)at[n].j, (uint32_t)at[n].k)
                      : vxs_blocks_shadow_count(a->words, 0, a->levels, at[n].i, at[n].j, (uint32_t)at[n].k, filter_px);
}

static void blocks_close(void *state)
{
    blocks_asset *a = state;
    free(a->words);
    free(a);
}

const rival block_rivals[] = {
    {"palette blocks", "depths of 32 x 32 blocks, and patterns of tiles that use them", NULL, 0, blocks_build, blocks_open,
     blocks_count_dark, blocks_close},
    {.name = NULL},
};
