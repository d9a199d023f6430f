/* Palette blocks from columns (baker/coding/blocks/): every column of random maps against the contract, deep maps of 262144 texels,
 * formulas, the same words at any number of threads and any size of fetched squares, pages, and failing calls.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "formats/vxs_lookup_blocks.h"
#include "formats/vxs_page.h"

#include "baker/base/cpu.h"
#include "baker/base/random.h" /* before cmocka, whose fail() is a macro */
#include "baker/base/simd.h"
#include "baker/coding/blocks/blocks.h"
#include "baker/coding/blocks/patterns.h"
#include "baker/coding/blocks/stabbing_set.h"
#include "tests/columns/analytic.h"

#include <cmocka.h>

#include "tests/columns/stored_maps.h"
#include "tests/unit/blocks_built.h"
#include "tests/unit/page_encoded.h"
#include "tests/unit/repeats.h"

/* a map with depth maps in one place of it ------------------------------------------------------------------------------------ */

/* Depth maps as a part of a larger map that has nothing else. */
typedef struct islet {
    depth_maps *maps;
    uint32_t    side_px, fetch_px, u_px, v_px; /* of the map, and where the maps lie in it: a multiple of their side */
    uint32_t    fetched_u, fetched_v;
} islet;

static vxs_result islet_bounds_at(const islet *s, uint32_t u, uint32_t v, uint32_t side, column_bounds *out)
{
    uint32_t      maps_side = s->maps->side_px;
    column_square maps      = depth_maps_square(s->maps);
    if (u >= s->u_px + maps_side || v >= s->v_px + maps_side || u + side <= s->u_px || v + side <= s->v_px) {
        *out = bounds_empty(s->side_px);
        return VXS_OK;
    }
    if (side <= maps_side) return maps.bounds(maps.data, square_level(side), (u - s->u_px) / side, (v - s->v_px) / side, out);
    maps.bounds(maps.data, square_level(maps_side), 0, 0, out);
    out->emax = out->xmax = s->side_px;
    return VXS_OK;
}

static vxs_result islet_bounds(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    return islet_bounds_at(data, i * (8u << level), j * (8u << level), 8u << level, out);
}

static vxs_result islet_square_bounds(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    const islet *s = data;
    return islet_bounds_at(s, s->fetched_u + i * (8u << level), s->fetched_v + j * (8u << level), 8u << level, out);
}

static vxs_result islet_tile(void *data, uint32_t i, uint32_t j, column_tile *out)
{
    const islet  *s = data;
    uint32_t      u = s->fetched_u + 8 * i - s->u_px, v = s->fetched_v + 8 * j - s->v_px;
    column_square maps = depth_maps_square(s->maps);
    if (u < s->maps->side_px && v < s->maps->side_px) return maps.tile(maps.data, u / 8, v / 8, out);
    for (int n = 0; n < 64; n++) out->e[n] = out->x[n] = s->side_px;
    return VXS_OK;
}

static vxs_result islet_fetch(void *data, uint32_t level, uint32_t i, uint32_t j, column_square *out, bake_context *ctx)
{
    islet   *s    = data;
    uint32_t side = 8u << level;
    (void)ctx;
    s->fetched_u = i * side;
    s->fetched_v = j * side;
    *out         = (column_square){s, side, s->side_px, i * side, j * side, islet_square_bounds, islet_tile};
    return VXS_OK;
}

static void islet_release(void *data, column_square *square)
{
    (void)data;
    memset(square, 0, sizeof *square);
}

static void islet_close(void *data)
{
    (void)data;
}

static column_map islet_map(islet *s)
{
    return (column_map){.data     = s,
                        .side_px  = s->side_px,
                        .depth_vx = s->side_px,
                        .fetch_px = s->fetch_px,
                        .bounds   = islet_bounds,
                        .fetch    = islet_fetch,
                        .release  = islet_release,
                        .close    = islet_close};
}

/* a light of depth maps ---------------------------------------------------------------------------------------------------------- */

/* Every column of the maps, or a third of each row: beside both of its depths, at both ends, and somewhere between.
 * u, v  where the maps lie in map `map` of 2^levels texels */
static void assert_columns(const block_words *w, uint32_t map, uint32_t levels, const depth_maps *d, uint32_t u, uint32_t v)
{
    rng            r     = {5};
    uint64_t       wrong = 0;
    const uint32_t step  = repeats(3, 1);
    for (uint32_t j = 0; j < d->side_px; j++)
        for (uint32_t i = j % step; i < d->side_px; i += step) {
            size_t   n    = (size_t)j * d->side_px + i;
            uint32_t last = d->depth_vx - 1, enter = (uint32_t)(d->enter[n] * (float)last),
                     exit = (uint32_t)(d->exit[n] * (float)last);
            uint32_t at[] = {0, enter - 1, enter, enter + 1, exit - 1, exit, exit + 1, rng_below(&r, last), last};
            for (int k = 0; k < 9; k++) {
                if (at[k] > last) continue;
                int want = wanted(d, i, j, at[k]), got = (int)vxs_blocks_shadow(w->words, map, levels, u + i, v + j, at[k]);
                wrong += want >= 0 && want != got;
            }
        }
    assert_int_equal(wrong, 0);
}

/* The words as bytes, and back: what the baker lays out is in the order that the coder of pages wants.
 * Returns how many bytes they are. */
static size_t assert_coded(const block_words *w, uint32_t levels, uint32_t map_count)
{
    uint32_t           pages = w->counts.pages, common_start = w->words[1], resident_words = pages ? w->words[8] : w->count;
    vxs_page_scratch  *scratch = malloc(vxs_page_scratch_bytes());
    uint32_t          *known   = calloc(w->common_count + 1, sizeof *known);
    vxs_bytes          bytes   = {0};
    vxs_common         common;
    vxs_resident_sizes sizes;
    assert_int_equal(vxs_common_index(&common, known, w->common_kinds, w->common_count, w->words + common_start, w->common_halves),
                     VXS_OK);
    assert_int_equal(resident_encoded(&bytes, w->words, resident_words, levels, map_count, &common), VXS_OK);
    assert_int_equal(vxs_resident_sizes_of(&sizes, bytes.data, bytes.size_bytes), VXS_OK);
    assert_true(sizes.word_count == resident_words && sizes.page_count == pages);

    vxs_resident back = {.words      = calloc(resident_words, 4),
                         .nodes      = calloc(sizes.node_count + 1, sizeof *back.nodes),
                         .page_first = calloc(pages + 1, sizeof *back.page_first),
                         .patterns   = calloc(sizes.pattern_count + 1, sizeof *back.patterns)};
    assert_int_equal(vxs_resident_decode(&back, levels, map_count, common.packing, bytes.data, bytes.size_bytes, scratch), VXS_OK);
    memcpy(back.words + 8, w->words + 8, pages * sizeof *w->words); /* where pages start is not coded */
    assert_memory_equal(back.words, w->words, resident_words * sizeof *w->words);
    for (uint32_t p = 0; p < pages; p++) {
        uint32_t             start = w->words[8 + p], count = (p + 1 < pages ? w->words[9 + p] : w->count) - start;
        const vxs_page_node *nodes      = back.nodes + back.page_first[p];
        uint32_t             node_count = back.page_first[p + 1] - back.page_first[p], *words = malloc(count * sizeof *words);
        size_t               from = bytes.size_bytes;
        assert_int_equal(page_encoded(&bytes, w->words + start, count, nodes, node_count, &back.common), VXS_OK);
        assert_int_equal(vxs_page_word_count(bytes.data + from, bytes.size_bytes - from), count);
        assert_int_equal(
            vxs_page_decode(words, bytes.data + from, bytes.size_bytes - from, nodes, node_count, &back.common, scratch), VXS_OK);
        assert_memory_equal(words, w->words + start, count * sizeof *words);
        free(words);
    }
    size_t size = bytes.size_bytes;
    free(back.words);
    free(back.nodes);
    free(back.page_first);
    free(back.patterns);
    free(bytes.data);
    free(known);
    free(scratch);
    return size;
}

static void every_kind_of_map(void **state)
{
    (void)state;
    for (uint32_t side = 8; side <= 512; side *= 2)
        for (map_kind kind = 0; kind < MAP_KINDS; kind++) {
            depth_maps  d = random_maps(side, side, kind, side + kind);
            column_map  m = stored_map(&d);
            block_words w;
            assert_int_equal(build_words(&w, &m, 1, 1 + kind % 3), VXS_OK);
            assert_columns(&w, 0, log2_u32(side), &d, 0, 0);
            assert_coded(&w, log2_u32(side), 1);
            block_words_free(&w);
            depth_maps_free(&d);
        }
}

/* A node whose slope moves the depths of all blocks behind the end of the map, those of uniform blocks less far than those of mixed
 * blocks: a thick slope, noise behind it in a few blocks, and rows without any caster. */
static void uniform_depths_behind_the_end(void **state)
{
    (void)state;
    const uint32_t side = 256;
    depth_maps     d    = random_maps(side, side, MAPS_EMPTY, 1);
    column_map     m    = stored_map(&d);
    block_words    w;
    for (uint32_t j = 0; j < 192; j++)
        for (uint32_t i = 0; i < side; i++) {
            const int    noise  = j / 32 == 2 && i / 32 % 3 == 0;
            const double behind = noise ? (i + j) % 2 ? 30 : 45 : 0, enter = j + 40.5 + behind;
            set_texel(&d, j * side + i, enter / side, (enter + (noise ? 0 : 20)) / side);
        }
    depth_maps_reduce(&d, 1);
    assert_int_equal(build_words(&w, &m, 1, 1), VXS_OK);
    const uint32_t *entry = w.words + w.words[2], *node = w.words + w.words[8], base = entry[1] & 0xffff;
    assert_int_equal(node[0], 0x490000); /* mixed blocks */
    assert_true(node[4] && base > side && base < 2 * side);
    assert_columns(&w, 0, 8, &d, 0, 0);
    assert_coded(&w, 8, 1);
    block_words_free(&w);
    depth_maps_free(&d);
}

/* Depths of 512 to 262144 voxels in maps as wide, of which one square has anything. */
static void deep_maps(void **state)
{
    (void)state;
    for (uint32_t levels = 9; levels <= 18; levels += levels < 14 ? 5 : repeats(2, 1))
        for (map_kind kind = 0; kind < MAP_KINDS; kind++) {
            uint32_t    side = 1u << levels;
            depth_maps  d    = random_maps(256, side, kind, levels * 100 + kind);
            islet       s    = {.maps = &d, .side_px = side, .fetch_px = min_u32(side, 2048), .u_px = side / 2, .v_px = side - 256};
            column_map  m    = islet_map(&s);
            block_words w;
            assert_int_equal(build_words(&w, &m, 1, 2), VXS_OK);
            assert_columns(&w, 0, levels, &d, s.u_px, s.v_px);
            assert_coded(&w, levels, 1);
            for (uint32_t k = 0; k < side; k += side / 8) { /* nothing casts beside it */
                assert_int_equal(vxs_blocks_shadow(w.words, 0, levels, s.u_px - 1, s.v_px, k), 0);
                assert_int_equal(vxs_blocks_shadow(w.words, 0, levels, 0, 0, k), 0);
            }
            block_words_free(&w);
            depth_maps_free(&d);
        }
}

/* Only pages of VXS_PACKING_FINE, which fine maps have, gain by depths of blocks beside: fast ones have fewer words without. */
static void fast_pages_need_no_depths_beside(void **state)
{
    (void)state;
    for (uint32_t levels = FINE_LEVELS - 1; levels <= FINE_LEVELS; levels++) {
        uint32_t    side = 1u << levels;
        depth_maps  d    = random_maps(256, side, MAPS_BOXES, 5);
        islet       s    = {.maps = &d, .side_px = side, .fetch_px = 2048, .u_px = side / 2, .v_px = side - 256};
        column_map  m    = islet_map(&s);
        block_words fast, fine;
        assert_int_equal(build_words_for(&fast, &m, 1, 1, 1), VXS_OK);
        assert_int_equal(build_words_for(&fine, &m, 1, 1, 0), VXS_OK);
        assert_columns(&fast, 0, levels, &d, s.u_px, s.v_px);
        assert_int_equal(fast.count != fine.count || memcmp(fast.words, fine.words, 4 * (size_t)fine.count), levels >= FINE_LEVELS);
        block_words_free(&fast);
        block_words_free(&fine);
        depth_maps_free(&d);
    }
}

/* The same words, whatever is done at once. */
static void threads_and_fetches(void **state)
{
    const map_kind kinds[] = {MAPS_NOISE, MAPS_BOXES, MAPS_CLIFF, MAPS_BOXES};
    const uint32_t sides[] = {1024, 1024, 1024, 2048}, threads[] = {2, 3, 8};
    (void)state;
    for (size_t n = 0; n < repeats(3, sizeof kinds / sizeof *kinds); n++) {
        uint32_t    side = sides[n];
        depth_maps  d    = random_maps(side, side, kinds[n], 7);
        column_map  m    = stored_map(&d);
        block_words once, again;
        assert_int_equal(build_words(&once, &m, 1, 1), VXS_OK);
        uint32_t first = 0; /* each size of a fetch with one count of threads, or all */
        for (uint32_t fetch = block_square_side(side); fetch <= side; fetch *= 2, first++) {
            islet      s    = {.maps = &d, .side_px = side, .fetch_px = fetch};
            column_map part = islet_map(&s);
            for (uint32_t t = repeats(first % 3, 0); t < 3; t += repeats(3, 1)) {
                assert_int_equal(build_words(&again, &part, 1, threads[t]), VXS_OK);
                assert_int_equal(once.count, again.count);
                assert_memory_equal(once.words, again.words, once.count * sizeof *once.words);
                assert_int_equal(once.common_count, again.common_count);
                assert_memory_equal(once.common_kinds, again.common_kinds, once.common_count);
                block_words_free(&again);
            }
        }
        block_words_free(&once);
        depth_maps_free(&d);
    }
}

/* Six maps share pages and patterns; equal maps cost little more than one. */
static void six_maps(void **state)
{
    (void)state;
    depth_maps  d[6];
    column_map  m[6];
    block_words one, six;
    for (int map = 0; map < 6; map++) {
        d[map] = random_maps(512, 512, MAPS_BOXES, map % 2);
        m[map] = stored_map(&d[map]);
    }
    assert_int_equal(build_words(&one, m, 2, 2), VXS_OK);
    assert_int_equal(build_words(&six, m, 6, 2), VXS_OK);
    for (uint32_t map = 0; map < 6; map++) assert_columns(&six, map, 9, &d[map], 0, 0);
    assert_true(six.count < one.count + 100);
    assert_coded(&six, 9, 6);
    block_words_free(&one);
    block_words_free(&six);
    for (int map = 0; map < 6; map++) depth_maps_free(&d[map]);
}

/* Pages hold what they may, and no more; patterns of several pages are kept once. */
static void pages_are_cut(void **state)
{
    (void)state;
    depth_maps  d = random_maps(2048, 2048, MAPS_NOISE, 3);
    column_map  m = stored_map(&d);
    block_words w;
    for (uint32_t n = 0; n < 2048 * 1024; n++)
        d.exit[n] = d.enter[n] = d.enter[n % (2048 * 256)]; /* repeated, so that there is a lot to share */
    depth_maps_reduce(&d, 1);
    assert_int_equal(build_words(&w, &m, 1, 2), VXS_OK);
    print_message("pages %u common %u\n", w.counts.pages, w.counts.common_words);
    assert_true(w.counts.pages > 4 && w.counts.common_words > 1000 && w.counts.common_words <= VXS_COMMON_HALVES_MAX / 2);
    for (uint32_t p = 0; p < w.counts.pages; p++) {
        uint32_t end = p + 1 < w.counts.pages ? w.words[8 + p + 1] : w.count;
        assert_true(end > w.words[8 + p] && end - w.words[8 + p] <= VXS_PAGE_WORDS_MAX);
    }
    assert_columns(&w, 0, 11, &d, 0, 0);
    assert_coded(&w, 11, 1);
    block_words_free(&w);
    depth_maps_free(&d);
}

/* Where one page is not enough, all have as much, whatever is left of the last. */
static void pages_are_even(void **state)
{
    (void)state;
    depth_maps d = random_maps(2048, 2048, MAPS_NOISE, 3);
    column_map m = stored_map(&d);
    for (uint32_t noisy = 112; noisy >= 48; noisy -= 32) { /* so many texels of each node */
        block_words w;
        for (uint32_t n = 0; n < 2048 * 2048; n++)
            d.exit[n] = d.enter[n] = n % 256 < noisy && n / 2048 % 256 < noisy ? d.enter[n] : 1;
        depth_maps_reduce(&d, 1);
        assert_int_equal(build_words(&w, &m, 1, 2), VXS_OK);
        uint32_t pages = w.counts.pages, average = (w.count - w.words[8]) / pages;
        print_message("pages %u of %u words\n", pages, average);
        assert_true(pages > 1);
        for (uint32_t p = 0; p < pages; p++) {
            uint32_t words = (p + 1 < pages ? w.words[9 + p] : w.count) - w.words[8 + p];
            assert_in_range(words, average * 3 / 4, average * 5 / 4);
        }
        block_words_free(&w);
    }
    depth_maps_free(&d);
}

/* The same tiles of many depths in many squares, each at a depth of its own: one pattern serves them all. */
static void repeated_at_other_depths(void **state)
{
    (void)state;
    const uint32_t side = 1024, period = 64;
    depth_maps     d = random_maps(side, side, MAPS_EMPTY, 1);
    column_map     m = stored_map(&d);
    block_words    w;
    rng            r = {3};
    uint32_t       depth[64 * 64];
    for (uint32_t n = 0; n < period * period; n++) depth[n] = rng_below(&r, 200);
    for (uint32_t j = 0; j < side; j++)
        for (uint32_t i = 0; i < side; i++) {
            uint32_t at           = depth[j % period * period + i % period] + 3 * (i / period) + 40 * (j / period);
            d.enter[j * side + i] = d.exit[j * side + i] = (float)at / (float)side;
        }
    depth_maps_reduce(&d, 1);
    assert_int_equal(build_words(&w, &m, 1, 2), VXS_OK);
    assert_int_equal(w.counts.private_patterns, 64); /* tiles of a period */
    assert_columns(&w, 0, 10, &d, 0, 0);
    block_words_free(&w);
    depth_maps_free(&d);
}

/* formulas -------------------------------------------------------------------------------------------------------------------- */

/* Columns of a map of 262144 texels, at and around the depths of a shape. */
static void shapes_of_formulas(void **state)
{
    const uint32_t points = repeats(20000, 200000);
    (void)state;
    for (uint32_t side = 4096; side <= 1u << 18; side *= 8)
        for (analytic_kind kind = 0; kind < ANALYTIC_KINDS; kind++) {
            if (kind == ANALYTIC_PLANES && side > 4096) continue; /* detail everywhere */
            analytic    a = analytic_shape(kind, side);
            block_words w;
            rng         r     = {1};
            uint64_t    wrong = 0, in_shape = 0;
            a.fetch_px = 1024;
            assert_int_equal(build_analytic(&w, &a, 2), VXS_OK);
            for (uint32_t n = 0; n < points; n++) {
                uint32_t i = rng_below(&r, side), j = rng_below(&r, side);
                double   enter, exit;
                analytic_depths(&a, i + 0.5, j + 0.5, &enter, &exit);
                in_shape += enter < side;
                uint32_t at[] = {(uint32_t)enter - 1, (uint32_t)enter, (uint32_t)exit, (uint32_t)exit + 1, rng_below(&r, side)};
                for (int k = 0; k < 5; k++) {
                    if (at[k] >= side) continue;
                    uint32_t dark = vxs_blocks_shadow(w.words, 0, log2_u32(side), i, j, at[k]);
                    wrong += dark ? at[k] + 1.0 <= enter : at[k] >= exit;
                }
            }
            assert_int_equal(wrong, 0);
            assert_true(in_shape > points / 20);
            block_words_free(&w);
        }
}

/* Each call of a source fails once, with one and with three threads: its result comes back, and all that was taken is given
 * back. */
static void failing_calls(void **state)
{
    (void)state;
    for (uint32_t threads = 1; threads <= 3; threads += 2) {
        analytic    a = analytic_shape(ANALYTIC_SPHERE, 512);
        block_words w;
        assert_int_equal(build_analytic(&w, &a, threads), VXS_OK);
        block_words_free(&w);
        uint64_t calls = atomic_load(&a.calls);
        for (uint64_t n = 1; n <= calls; n += 1 + calls / 100) {
            atomic_store(&a.calls, 0);
            a.fail_at = n;
            a.failure = VXS_E_GL;
            assert_int_equal(build_analytic(&w, &a, threads), VXS_E_GL);
            assert_null(w.words);
        }
    }
}

/* pieces ---------------------------------------------------------------------------------------------------------------------- */

/* The fewest points by trying: intervals sorted by where they end, one after the other. */
static int fewest_points(const int16_t *low, const int16_t *high, int count)
{
    int points = 0;
    for (int last = -1;;) {
        int next = INT32_MAX;
        for (int n = 0; n < count; n++)
            if (low[n] > last && high[n] < next) next = high[n];
        if (next == INT32_MAX) return points;
        points++;
        last = next;
    }
}

static void piercing(void **state)
{
    (void)state;
    rng r = {1};
    for (uint32_t round = 0; round < repeats(1000, 3000); round++) {
        intervals  s = {.count = 1 + (int)rng_below(&r, round % 2 ? 40 : 1040)};
        int16_t    low[1040], high[1040];
        stab_group groups[1040];
        int        count = s.count, range = 1 + (int)rng_below(&r, 32767);
        for (int n = 0; n < count; n++) {
            int a = (int)rng_below(&r, (uint32_t)range), b = (int)rng_below(&r, (uint32_t)(range / (1 + round % 50)) + 1);
            low[n] = s.low[n] = (int16_t)a;
            high[n] = s.high[n] = (int16_t)(a + b > range ? range : a + b);
        }
        int points = 0;
        for (int cpu = CPU_SSE2; cpu <= cpu_level_of_machine(); cpu++) {
            intervals  used = s; /* each use takes it up */
            stab_group same[1040];
            points = minimum_stabbing_set(&used, cpu ? same : groups, 1040, cpu);
            if (cpu) assert_memory_equal(same, groups, (size_t)points * sizeof *groups);
            assert_int_equal(points, fewest_points(low, high, count));
        }
        for (int n = 0; n < count; n++) { /* each interval holds all of some group */
            int in = 0;
            for (int g = 0; g < points; g++) in |= low[n] <= groups[g].low && groups[g].high <= high[n];
            assert_true(in);
        }
    }
}

/* A tile uses as few entries as it can; a mask is dark where a texel has none from the next entry on, lit where it has none up to
 * the last. */
static void needs_of_tiles(void **state)
{
    (void)state;
    rng r = {2};
    for (uint32_t round = 0; round < repeats(1000, 3000); round++) {
        int16_t points[PALETTE_MAX], low[64], high[64], first[64], last[64];
        int     count = 1 + (int)rng_below(&r, PALETTE_MAX), least = count;
        for (int n = 0, at = 0; n < count; n++) points[n] = (int16_t)(at += 1 + (int)rng_below(&r, round % 2 ? 4 : 2000));
        for (int n = 0; n < 64; n++) {
            int from = (int)rng_below(&r, (uint32_t)count), to = rng_between(&r, from, count - 1);
            low[n]   = (int16_t)rng_between(&r, from ? points[from - 1] + 1 : 0, points[from]);
            high[n]  = (int16_t)rng_between(&r, points[to], to + 1 < count ? points[to + 1] - 1 : INT16_MAX);
            first[n] = (int16_t)from;
            last[n]  = (int16_t)to;
            least    = to < least ? to : least;
        }
        for (int cpu = CPU_SSE2; cpu <= cpu_level_of_machine(); cpu++) {
            mask_need needs[PALETTE_MAX - 1];
            uint32_t  used = tile_needs(low, high, points, count, rng_between(&r, 0, least), needs, cpu), rest = used;
            assert_int_equal(__builtin_popcount(used), fewest_points(first, last, 64));
            for (int n = 0; n < 64; n++) assert_true(used >> first[n] & ((2u << (last[n] - first[n])) - 1));
            for (int mask = 0; rest & (rest - 1); mask++) {
                int before = __builtin_ctz(rest), next = __builtin_ctz(rest &= rest - 1);
                for (int n = 0; n < 64; n++) {
                    assert_int_equal(needs[mask].dark >> n & 1, last[n] < next);
                    assert_int_equal(needs[mask].lit >> n & 1, first[n] > before);
                }
            }
        }
    }
}

/* Codes are in the order of depths, and equal only where depths are, whichever the scale. */
static void axes_keep_order(void **state)
{
    (void)state;
    rng r = {1};
    for (uint32_t round = 0; round < repeats(60, 200); round++) {
        depth_axis a;
        int16_t    codes[200];
        int32_t    ends[200], *low = ends, *high = ends + 100, range = round % 2 ? 1 << 18 : 20000, greatest_low = 0,
                           least_high = INT32_MAX;
        for (int n = 0; n < 100; n++) {
            low[n]       = (int32_t)rng_below(&r, (uint32_t)range);
            high[n]      = low[n] + (int32_t)rng_below(&r, 1000);
            greatest_low = low[n] > greatest_low ? low[n] : greatest_low;
            least_high   = high[n] < least_high ? high[n] : least_high;
        }
        int linear = axis_init(&a, least_high, greatest_low);
        assert_int_equal(linear, !(round % 2));
        if (!linear) axis_init_by_depths(&a, ends, codes, 200);
        for (int n = 0; n < 200 && !linear; n++) assert_int_equal(codes[n], axis_code(&a, ends[n]));
        for (int n = 0; n < 5000; n++) {
            int32_t in = rng_below(&r, 2) ? low[n % 100] : high[n % 100], other = in + (int32_t)rng_below(&r, 41) - 20;
            int16_t x = axis_code(&a, in), y = axis_code(&a, other);
            if (linear && (x == 0 || x == INT16_MAX || y == 0 || y == INT16_MAX)) continue; /* clamped */
            assert_int_equal((x > y) - (x < y), (in > other) - (in < other));
            assert_int_equal(axis_depth(&a, x), in);
        }
    }
}

/* A texel's depth in a pattern that tiles have agreed on is one that each of them allows. */
static void patterns_agree(void **state)
{
    (void)state;
    enum { TILES = 3000 };
    static uint8_t  low[TILES][64], high[TILES][64];
    static uint32_t id[TILES];
    rng             r   = {1};
    pattern_set     set = {0};
    for (int depths = 2; depths <= PALETTE_MAX; depths += 4) {
        for (int t = 0; t < TILES; t++) {
            mask_need needs[PALETTE_MAX - 1];
            int       edge = (int)rng_below(&r, 64), slack = (int)rng_below(&r, (uint32_t)depths);
            for (int n = 0; n < 64; n++) {
                int at     = n < edge ? 0 : depths - 1;
                low[t][n]  = (uint8_t)(at - slack < 0 ? 0 : at - slack);
                high[t][n] = (uint8_t)(at + slack > depths - 1 ? depths - 1 : at + slack);
            }
            for (int mask = 0; mask < depths - 1; mask++) {
                needs[mask] = (mask_need){0, 0};
                for (int n = 0; n < 64; n++) {
                    needs[mask].dark |= (uint64_t)(high[t][n] <= mask) << n;
                    needs[mask].lit |= (uint64_t)(low[t][n] > mask) << n;
                }
            }
            assert_int_equal(pattern_find(&set, depths, needs, &id[t]), VXS_OK);
        }
        const pattern_class *c = &set.by_depths[depths];
        assert_true(c->count < TILES / 4);
        for (size_t place = 0; place < c->count; place++) {
            mask_need needs[PALETTE_MAX - 1];
            uint8_t   index[64];
            pattern_needs(&set, depths, place, needs);
            pattern_choose(needs, depths, index);
            for (int t = 0; t < TILES; t++)
                for (int n = 0; n < 64 && id[t] == c->ids[place]; n++) assert_in_range(index[n], low[t][n], high[t][n]);
        }
    }
    pattern_set_free(&set);
}

static uint64_t rng_mask(rng *r)
{
    uint64_t half = rng_u32(r);
    return half << 32 | rng_u32(r);
}

/* What the processor has decides how long a search takes, not what it finds: also beyond the window, and where it begins within
 * 16. */
static void searches_find_the_same(void **state)
{
    (void)state;
    enum { FINDS = 9000, MASKS = 2 };
    pattern_set set[CPU_AVX512 + 1] = {{.cpu = CPU_SSE2}, {.cpu = CPU_AVX2}, {.cpu = CPU_AVX512}};
    rng         r                   = {5};
    for (int n = 0; n < FINDS; n++) {
        mask_need needs[MASKS];
        uint32_t  id[CPU_AVX512 + 1];
        uint64_t  dark = rng_mask(&r), asked = rng_mask(&r) & rng_mask(&r);
        needs[0] = (mask_need){dark & asked, ~dark & asked};
        needs[1] = (mask_need){needs[0].dark, needs[0].lit & rng_mask(&r)};
        for (int cpu = CPU_SSE2; cpu <= cpu_level_of_machine(); cpu++) {
            assert_int_equal(pattern_find(&set[cpu], MASKS + 1, needs, &id[cpu]), VXS_OK);
            assert_int_equal(id[cpu], id[CPU_SSE2]);
        }
    }
    assert_true(set[CPU_SSE2].count > PATTERN_WINDOW && set[CPU_SSE2].count < FINDS);
    for (int cpu = CPU_SSE2; cpu <= CPU_AVX512; cpu++) pattern_set_free(&set[cpu]);
}

/* A quadrant has as few depths as its ranges can do with: those are stabbed one by one, the one that ends first before all
 * others. */
static void quadrants_have_few_depths(void **state)
{
    (void)state;
    rng r = {1};
    for (int round = 0; round < 2000; round++) {
        uint8_t low[64], high[64], index[64];
        for (int n = 0; n < 64; n++) {
            low[n]  = (uint8_t)rng_below(&r, 64);
            high[n] = (uint8_t)(low[n] + rng_below(&r, 64u - low[n]) / (1 + (uint32_t)round % 5));
        }
        pattern_choose_within(low, high, index);
        for (int q = 0; q < 64; q += 16) {
            uint64_t used   = 0;
            int      fewest = 0;
            for (int end = 0, last = -1; end < 64; end++)
                for (int n = q; n < q + 16; n++) {
                    if (high[n] != end || low[n] <= last) continue;
                    last = end;
                    fewest++;
                }
            for (int n = q; n < q + 16; n++) {
                assert_in_range(index[n], low[n], high[n]);
                used |= 1ull << index[n];
            }
            assert_int_equal(__builtin_popcountll(used), fewest);
        }
    }
}

static void find_private(private_set *set, const tile_ranges *t, uint32_t *id, int32_t *base)
{
    private_planes one;
    private_plane(&one, t);
    assert_int_equal(private_find(set, t, &one, id, base), VXS_OK);
}

/* Whether the depths of a pattern lie in all ranges at some base. */
static int fits_somewhere(const private_pattern *p, const tile_ranges *t)
{
    int32_t least = INT32_MIN, most = INT32_MAX;
    for (int n = 0; n < 64; n++) {
        least = max_i32(least, t->low[n] - p->depth[n]);
        most  = min_i32(most, t->high[n] - p->depth[n]);
    }
    return least <= most;
}

/* The depths of an own pattern suit each tile that has it, and so does all that is left of its ranges: at any base, near and far
 * apart. A new one is made where none does. */
static void private_patterns_agree(void **state)
{
    (void)state;
    enum { TILES = 2000, SHAPES = 20 };
    static tile_ranges tiles[TILES];
    static uint32_t    id[TILES];
    static int32_t     base[TILES];
    static uint32_t    plain[TILES]; /* ids without vectors of more than 16 bytes */
    int                cpus = 1 + cpu_level_of_machine();
    for (int round = 0; round < 5 * cpus; round++) {
        int32_t     step = 1 << 4 * (round / cpus);
        private_set set  = {.cpu = round % cpus};
        rng         r    = {(uint64_t)step};
        for (int t = 0; t < TILES; t++) {
            rng     shape = {1 + rng_below(&r, SHAPES)};
            int32_t away = (int32_t)rng_below(&r, 1 << 18), slack = (int32_t)rng_below(&r, 9) * step;
            for (int n = 0; n < 64; n++) {
                int32_t depth    = away + (int32_t)rng_below(&shape, 64) * step;
                tiles[t].low[n]  = depth - (int32_t)rng_below(&r, (uint32_t)slack + 1);
                tiles[t].high[n] = depth + (int32_t)rng_below(&r, (uint32_t)slack + 1);
            }
            size_t known = set.count;
            find_private(&set, &tiles[t], &id[t], &base[t]);
            for (size_t p = 0; p < known && id[t] == known && t < TILES / 4 && step < 256; p++)
                assert_false(fits_somewhere(&set.patterns[p], &tiles[t]));
        }
        if (step < 256) assert_true(set.count < TILES / 2);
        if (set.cpu == CPU_SSE2) memcpy(plain, id, sizeof id);
        assert_memory_equal(id, plain, sizeof id);
        for (int t = 0; t < TILES; t++) {
            const private_pattern *p = &set.patterns[id[t]];
            for (int n = 0; n < 64; n++) {
                assert_true(base[t] + p->depth[n] >= tiles[t].low[n] && base[t] + p->depth[n] <= tiles[t].high[n]);
                assert_true(base[t] + p->may.low[n] >= tiles[t].low[n] && base[t] + p->may.high[n] <= tiles[t].high[n]);
            }
        }
        private_set_free(&set);
    }
}

/* A sheet's ranges: the voxel that it is in, or the one behind. */
static tile_ranges sheet_ranges(double across, double down, double least)
{
    tile_ranges t;
    for (int y = 0; y < 8; y++)
        for (int x = 0; x < 8; x++) {
            int n     = pattern_texel(x, y);
            t.low[n]  = (int32_t)floor(least + across * x + down * y);
            t.high[n] = t.low[n] + 1;
        }
    return t;
}

/* Any sheet is a plane of three halves, with round slopes unless it is steep, and mostly the same one however deep it lies. */
static void sheets_are_planes(void **state)
{
    (void)state;
    rng         r   = {1};
    private_set set = {0};
    uint32_t    id, first, same = 0, round_slopes = 0;
    int32_t     base;
    uint16_t    halves[PRIVATE_HALVES_MAX];
    for (int round = 0; round < 3000; round++) {
        double      steep = round % 3 ? 2 : 200, across = (random_unit(&r) - 0.5) * steep, down = (random_unit(&r) - 0.5) * steep;
        tile_ranges t = sheet_ranges(across, down, 5000 + random_unit(&r));
        find_private(&set, &t, &id, &base);
        assert_int_equal(private_pattern_encode(&set.patterns[id], halves), PRIVATE_PLANE_HALVES);
        for (int n = 0; n < 64; n++) assert_in_range(base + set.patterns[id].depth[n], t.low[n], t.high[n]);
        round_slopes += !((halves[1] | halves[2]) & 7);
        first = id;
        t     = sheet_ranges(across, down, 9000 + random_unit(&r));
        find_private(&set, &t, &id, &base);
        same += id == first;

        /* the fast test lets it pass, with wider ranges too, and no sheet that is bent by more than ranges allow */
        for (int n = 0; n < 64; n++) t.high[n] += (int32_t)rng_below(&r, 3);
        assert_true(tile_may_be_plane(&t));
        for (int n = 0; n < 64; n++) {
            int across_px = 4 * (n >> 4 & 1) + (n & 3), down_px = 4 * (n >> 5) + (n >> 2 & 3);
            int bend = round % 3 == 0 ? across_px * across_px : round % 3 == 1 ? down_px * down_px : across_px * down_px;
            t.low[n] += bend;
            t.high[n] += bend;
        }
        assert_false(tile_may_be_plane(&t));
    }
    assert_true(same > 1900 && round_slopes > 2900);
    private_set_free(&set);
}

/* Two sheets, of which one ends before the other, or that meet, take what two planes take, with round slopes. */
static void two_sheets_are_two_planes(void **state)
{
    (void)state;
    rng         r        = {2};
    private_set set      = {0};
    uint32_t    found[4] = {0}, round_slopes = 0, id;
    int32_t     base;
    uint16_t    halves[PRIVATE_HALVES_MAX];
    for (int round = 0; round < 3000; round++) {
        double      edge_x = random_unit(&r) - 0.5, edge_y = random_unit(&r) - 0.5;
        tile_ranges a = sheet_ranges(random_unit(&r) * 8, random_unit(&r) * 8, 1000 + 3000 * (round % 3 == 2));
        tile_ranges b = sheet_ranges(-random_unit(&r) * 8, random_unit(&r) * 8, 1030), t = a;
        for (int y = 0; y < 8; y++)
            for (int x = 0; x < 8; x++) {
                int n      = pattern_texel(x, y);
                int second = round % 3 == 0   ? b.low[n] < a.low[n]
                             : round % 3 == 1 ? b.low[n] > a.low[n]
                                              : edge_x * (x - 3) > edge_y * (y - 3);
                if (!second) continue;
                t.low[n]  = b.low[n];
                t.high[n] = b.high[n];
            }
        find_private(&set, &t, &id, &base);
        for (int n = 0; n < 64; n++) assert_in_range(base + set.patterns[id].depth[n], t.low[n], t.high[n]);
        uint32_t count = private_pattern_encode(&set.patterns[id], halves);
        found[count == PRIVATE_PLANE_HALVES ? 0 : count == PRIVATE_PAIR_HALVES ? 1 : count == PRIVATE_PLANES_HALVES_MAX ? 2 : 3]++;
        if (count == PRIVATE_PAIR_HALVES) assert_true(halves[0] >> 12 == 8 || halves[0] >> 12 == 9);
        if (count == PRIVATE_PLANES_HALVES_MAX) round_slopes += !((halves[1] | halves[2] | halves[3] | halves[4]) & 7);
    }
    assert_true(found[1] > 1500 && found[2] > 700 && found[3] < 300 && round_slopes > found[2] * 9 / 10);
    private_set_free(&set);
}

/* A slanted sheet over a whole map has few blocks and nodes, on whatever slope it lies: nodes are on one plane as a whole, and equal
 * nodes are one. Tiles that could have one depth are on the plane, too. */
static void sheet_over_a_map(void **state)
{
    (void)state;
    const uint32_t side = 512;
    for (int steep = 0; steep < 2; steep++) {
        depth_maps  d = random_maps(side, side, MAPS_EMPTY, 1);
        column_map  m = stored_map(&d);
        block_words w;
        for (uint32_t n = 0; n < side * side; n++)
            d.enter[n] = d.exit[n] =
                (float)fmin(side, (steep ? 7.3 * (n % side) : 0.613 * (n % side)) + 0.131 * (n / side)) / (float)side;
        depth_maps_reduce(&d, 1);
        assert_int_equal(build_words(&w, &m, 1, 2), VXS_OK);
        assert_columns(&w, 0, 9, &d, 0, 0);
        assert_true(w.count < 320 && w.counts.blocks < 20 && w.counts.nodes < 4);
        block_words_free(&w);
        depth_maps_free(&d);
    }
}

/* Packed and back; where a field is another, bytes are. */
static void packed_blocks(void **state)
{
    rng r = {7};
    (void)state;
    for (uint32_t n = 0; n < repeats(6000, 20000); n++) {
        uint8_t    bytes[BLOCK_PACKED_MAX], others[BLOCK_PACKED_MAX];
        block      b, back;
        block_head head;
        uint32_t   count = 0;
        memset(&b, 0, sizeof b);
        b.depths            = 1 + rng_below(&r, PALETTE_MAX);
        const uint32_t most = 1u << rng_below(&r, 17), shift = rng_below(&r, 3);
        for (uint32_t k = 1; k < b.depths; k++) b.depth[k] = b.depth[k - 1] + (int32_t)((1 + rng_below(&r, most)) << shift);
        if (rng_below(&r, 3) == 0) b.plane = (plane){(int32_t)rng_below(&r, 9) - 4, 0, (int32_t)rng_below(&r, 3) - 1};
        for (block_tile *t = b.tile; t < b.tile + BLOCK_TILES; t++) {
            t->kind = (uint16_t)rng_below(&r, 4);
            if (t->kind == TILE_UNIFORM) t->palette = (uint16_t)rng_below(&r, b.depths);
            if (t->kind == TILE_PATTERN) t->palette = (uint16_t)rng_below(&r, 1 << 14);
            if (tile_has_pattern(t)) t->pattern = rng_below(&r, 1 << 30);
            if (t->kind == TILE_PRIVATE) t->base = (int32_t)rng_below(&r, 5) - 2;
        }
        size_t size = block_pack(&b, bytes);
        assert_true(size <= BLOCK_PACKED_MAX && size % 8 == 0);
        block_unpack(&back, bytes);
        assert_memory_equal(&b, &back, sizeof b);
        const block_parts parts = block_parts_of(bytes);
        head                    = parts.head;
        assert_int_equal(head.mixed_count, __builtin_popcount(head.mixed));
        for (int t = 0; t < BLOCK_TILES; t++) {
            assert_int_equal(head.mixed >> t & 1, tile_has_pattern(&b.tile[t]));
            assert_int_equal(head.own >> t & 1, b.tile[t].kind == TILE_PRIVATE);
            if (tile_has_pattern(&b.tile[t])) assert_memory_equal(parts.pattern + 4 * count++, &b.tile[t].pattern, 4);
        }
        uint32_t shared[8], own[8], at;
        int32_t  private_base[8];
        for (at = 0; at < 8; at++) {
            shared[at]       = rng_u32(&r);
            own[at]          = rng_u32(&r);
            private_base[at] = (int32_t)rng_below(&r, 5) - 2;
        }
        for (block_tile *t = b.tile; t < b.tile + BLOCK_TILES; t++)
            if (tile_has_pattern(t)) t->pattern %= 8;
        block_pack(&b, bytes);
        block_renumber(bytes, shared, own, private_base);
        for (block_tile *t = b.tile; t < b.tile + BLOCK_TILES; t++) {
            if (t->kind == TILE_PRIVATE) t->base += private_base[t->pattern];
            if (tile_has_pattern(t)) t->pattern = t->kind == TILE_PRIVATE ? own[t->pattern] : shared[t->pattern];
        }
        assert_int_equal(block_pack(&b, others), size);
        assert_memory_equal(bytes, others, size);
        block_tile *t = &b.tile[rng_below(&r, BLOCK_TILES)];
        if (t->kind == TILE_PRIVATE)
            t->base++;
        else
            t->kind = t->kind == TILE_PLANE ? TILE_UNIFORM : TILE_PLANE;
        if (t->kind == TILE_PLANE) t->pattern = t->palette = 0;
        assert_true(block_pack(&b, others) != size || memcmp(bytes, others, size));
    }
}

/* Number of blocks of 4 x 4 tiles that have no common depth with a slope. */
static int count_mixed(const int32_t *emax, const int32_t *xmin, node_slope s, uint64_t *blocks)
{
    int count = 0;
    *blocks   = 0;
    for (int b = 0; b < NODE_BLOCKS; b++) {
        int32_t low = INT32_MIN, high = INT32_MAX;
        for (int t = 0; t < BLOCK_TILES; t++) {
            int x = b % 8 * 4 + t % 4, y = b / 8 * 4 + t / 4, n = NODE_TILES * y + x;
            low  = max_i32(low, emax[n] + slope_shift(s, x, y));
            high = min_i32(high, xmin[n] + slope_shift(s, x, y));
        }
        count += low > high;
        *blocks |= (uint64_t)(low > high) << b;
    }
    return count;
}

/* Nodes of slanted ground under other things: a slope that is found saves blocks, and where none may help, none does. */
static void slopes_save_blocks(void **state)
{
    (void)state;
    rng r     = {37};
    int found = 0, ruled_out = 0;
    for (uint32_t n = 0; n < repeats(300, 5000); n++) {
        static int32_t emax[NODE_TILES * NODE_TILES], xmin[NODE_TILES * NODE_TILES];
        int            steep  = 1 << rng_below(&r, 14);
        node_slope     ground = {rng_between(&r, -steep, steep), rng_between(&r, -steep, steep)}, none = {0, 0};
        uint32_t       thick = 3 + rng_below(&r, 30), things = rng_below(&r, 3) * rng_below(&r, 100);
        int32_t        deepest = 0;
        uint64_t       mixed, left;
        for (int t = 0; t < NODE_TILES * NODE_TILES; t++) {
            emax[t] = 2000 - slope_shift(ground, t % NODE_TILES, t / NODE_TILES) + (int32_t)rng_below(&r, 3);
            xmin[t] = emax[t] + (int32_t)thick;
            if (things && !rng_below(&r, things)) xmin[t] = emax[t] - 1 - (int32_t)rng_below(&r, 100);
            deepest = max_i32(deepest, emax[t]);
        }
        int        without = count_mixed(emax, xmin, none, &mixed);
        node_slope slope   = slope_find(emax, xmin, deepest, mixed, rng_below(&r, 2) ? ground : none);
        if (!slope_may_help(emax, xmin, deepest, mixed)) {
            assert_true(!slope.x && !slope.y);
            assert_true(count_mixed(emax, xmin, ground, &left) >= without - 1);
            ruled_out++;
        } else if (slope.x || slope.y) {
            assert_true(count_mixed(emax, xmin, slope, &left) < without - 1);
            found++;
        }
    }
    assert_true(found > 20 && ruled_out > 20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(piercing),
        cmocka_unit_test(slopes_save_blocks),
        cmocka_unit_test(axes_keep_order),
        cmocka_unit_test(repeated_at_other_depths),
        cmocka_unit_test(private_patterns_agree),
        cmocka_unit_test(patterns_agree),
        cmocka_unit_test(every_kind_of_map),
        cmocka_unit_test(uniform_depths_behind_the_end),
        cmocka_unit_test(deep_maps),
        cmocka_unit_test(fast_pages_need_no_depths_beside),
        cmocka_unit_test(threads_and_fetches),
        cmocka_unit_test(six_maps),
        cmocka_unit_test(sheets_are_planes),
        cmocka_unit_test(sheet_over_a_map),
        cmocka_unit_test(two_sheets_are_two_planes),
        cmocka_unit_test(pages_are_cut),
        cmocka_unit_test(pages_are_even),
        cmocka_unit_test(shapes_of_formulas),
        cmocka_unit_test(failing_calls),
        cmocka_unit_test(searches_find_the_same),
        cmocka_unit_test(quadrants_have_few_depths),
        cmocka_unit_test(packed_blocks),
        cmocka_unit_test(needs_of_tiles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
