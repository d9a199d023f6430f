/* Palette blocks built from random depth maps and from formulas, for tests. Include after <cmocka.h>.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BLOCKS_BUILT_H
#define BLOCKS_BUILT_H

#include "baker/base/integer.h"
#include "baker/coding/blocks/blocks.h"
#include "tests/columns/analytic.h"
#include "tests/columns/stored_maps.h"
#include "tests/unit/random_maps.h"

static inline vxs_result build_words_for(block_words *out, const column_map *maps, uint32_t map_count, uint32_t threads, int fast)
{
    run_context  m   = {0};
    bake_context ctx = {.run = &m, .threads = threads};
    block_set    set = {.fast = fast};
    vxs_result   r   = VXS_OK;
    memset(out, 0, sizeof *out);
    for (uint32_t map = 0; map < map_count && r == VXS_OK; map++) r = block_build_map(&set, map, &maps[map], &ctx);
    if (r == VXS_OK) r = block_words_lay_out(out, &set, log2_u32(maps[0].side_px), map_count, threads);
    block_set_free(&set);
    run_free(&m);
    return r;
}

static inline vxs_result build_words(block_words *out, const column_map *maps, uint32_t map_count, uint32_t threads)
{
    return build_words_for(out, maps, map_count, threads, 0);
}

static inline depth_maps random_maps(uint32_t side, uint32_t depth, map_kind kind, uint64_t seed)
{
    depth_maps  d;
    run_context m = {0};
    rng         r = {seed};
    assert_int_equal(depth_maps_init(&d, side, depth, 0, 1, &m), VXS_OK);
    fill_maps(&d, kind, &r);
    depth_maps_reduce(&d, 1);
    return d;
}

/* Words of random maps of one kind. */
static inline block_words words_of_maps(uint32_t levels, uint32_t map_count, map_kind kind, uint64_t seed)
{
    depth_maps  d[VXS_CUBE_FACES];
    column_map  m[VXS_CUBE_FACES];
    block_words w;
    for (uint32_t map = 0; map < map_count; map++) {
        d[map] = random_maps(1u << levels, 1u << levels, kind, seed + map);
        m[map] = stored_map(&d[map]);
    }
    assert_int_equal(build_words(&w, m, map_count, 2), VXS_OK);
    for (uint32_t map = 0; map < map_count; map++) depth_maps_free(&d[map]);
    return w;
}

static inline vxs_result build_analytic(block_words *w, analytic *a, uint32_t threads)
{
    run_context   m      = {0};
    bake_context  ctx    = {.run = &m, .threads = threads};
    column_source source = analytic_source(a);
    column_map    map;
    vxs_result    r = source.open(source.data, 0, &map, &ctx);
    memset(w, 0, sizeof *w);
    if (r != VXS_OK) return r;
    r = build_words(w, &map, 1, threads);
    map.close(map.data);
    assert_int_equal(atomic_load(&a->open), 0);
    return r;
}

#endif
