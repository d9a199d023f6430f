/* The square cache (baker/columns/square_record.h): words and DAG are the same from squares that are built and stored, from the
 * cache alone, and from some of each; damaged records are found.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/vxs.h"

#include "baker/base/random.h" /* before cmocka, whose fail() is a macro */
#include "baker/coding/dag/build.h"
#include "baker/columns/square_record.h"

#include <cmocka.h>

#include "baker/base/byte_stream.h"
#include "tests/unit/blocks_built.h"
#include "tests/unit/repeats.h"

enum { SQUARES_MAX = 64 };

/* A cache in memory: squares in the order in which the descent looked them up. */
typedef struct shelf {
    vxs_bytes record[SQUARES_MAX];
    uint32_t  asked, stored;
    uint32_t  known;   /* of every so many squares one is known; 0: none */
    vxs_bytes instead; /* of the first one that is known, where there are any */
} shelf;

static vxs_bytes copy_of(const vxs_bytes *b)
{
    vxs_bytes copy = {malloc(b->size_bytes + 1), b->size_bytes, b->size_bytes + 1};
    memcpy(copy.data, b->data, b->size_bytes);
    return copy;
}

static vxs_result shelf_find(void *data, const column_map *columns, uint32_t level, uint32_t i, uint32_t j, square_action *action,
                             vxs_bytes *record, bake_context *ctx)
{
    shelf   *s = data;
    uint32_t n = s->asked++;
    (void)columns;
    (void)level;
    (void)i;
    (void)j;
    (void)ctx;
    assert_true(n < SQUARES_MAX);
    if (!s->known || n % s->known) return VXS_OK;
    *action = SQUARE_KNOWN;
    *record = copy_of(!n && s->instead.data ? &s->instead : &s->record[n]);
    return VXS_OK;
}

static vxs_result shelf_store(void *data, const vxs_bytes *record, bake_context *ctx)
{
    shelf *s = data;
    (void)ctx;
    free(s->record[s->asked - 1].data);
    s->record[s->asked - 1] = copy_of(record);
    s->stored++;
    return VXS_OK;
}

static void shelf_free(shelf *s)
{
    for (int n = 0; n < SQUARES_MAX; n++) free(s->record[n].data);
    free(s->instead.data);
}

/* a map of squares that are fetched one by one ---------------------------------------------------------------------------------- */

typedef struct counted_map {
    const depth_maps *maps;
    column_map        under;
    atomic_uint       fetches;
    atomic_uint       alone; /* of them, by a thread that fetches alone */
} counted_map;

typedef struct window {
    const depth_maps *maps;
    uint32_t          u, v; /* tiles */
} window;

static vxs_result window_bounds(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    const window *w     = data;
    column_square whole = depth_maps_square(w->maps);
    return whole.bounds(whole.data, level, i + (w->u >> level), j + (w->v >> level), out);
}

static vxs_result window_tile(void *data, uint32_t i, uint32_t j, column_tile *out)
{
    const window *w     = data;
    column_square whole = depth_maps_square(w->maps);
    return whole.tile(whole.data, i + w->u, j + w->v, out);
}

static vxs_result counted_bounds(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    (void)level;
    (void)i;
    (void)j;
    *out = bounds_unknown(((counted_map *)data)->maps->depth_vx);
    return VXS_OK;
}

static vxs_result counted_fetch(void *data, uint32_t level, uint32_t i, uint32_t j, column_square *out, bake_context *ctx)
{
    counted_map *c    = data;
    uint32_t     side = 8u << level;
    window      *w    = malloc(sizeof *w);
    c->fetches++;
    c->alone += !ctx;
    *w   = (window){c->maps, i * side / 8, j * side / 8};
    *out = (column_square){w, side, c->maps->depth_vx, i * side, j * side, window_bounds, window_tile};
    return VXS_OK;
}

static void counted_release(void *data, column_square *square)
{
    (void)data;
    free(square->data);
}

static void counted_close(void *data)
{
    (void)data;
}

static column_map counted_columns(counted_map *c, uint32_t fetch_px, const square_cache *cache)
{
    return (column_map){.data     = c,
                        .side_px  = c->maps->side_px,
                        .depth_vx = c->maps->depth_vx,
                        .fetch_px = fetch_px,
                        .bounds   = counted_bounds,
                        .fetch    = counted_fetch,
                        .release  = counted_release,
                        .close    = counted_close,
                        .cache    = cache};
}

/* both codings ---------------------------------------------------------------------------------------------------------------- */

static vxs_bytes words_of(const column_map *m, uint32_t threads)
{
    block_words w;
    vxs_bytes   all = {0};
    assert_int_equal(build_words(&w, m, 1, threads), VXS_OK);
    assert_true(put_bytes(&all, w.words, w.count * sizeof *w.words) && put_bytes(&all, w.common_kinds, w.common_count));
    block_words_free(&w);
    return all;
}

static vxs_bytes dag_file_of(const column_map *m, uint32_t threads)
{
    const build_options o     = {.rule = MASK_RULE_GREEDY, .reuse = 1, .compress = COMPRESS_TOP_DOWN, .share = 1};
    run_context         quiet = {0};
    bake_context        ctx   = {.run = &quiet, .threads = threads};
    build_stats         stats = {0};
    dag_merger          g;
    dag                 d;
    vxs_bytes           file = {0};
    assert_int_equal(dag_merger_init(&g, m->side_px, 1, 1), VXS_OK);
    assert_int_equal(dag_build_map(&g, 0, m, &o, &stats, &ctx), VXS_OK);
    assert_int_equal(dag_merger_finish(&g, &d), VXS_OK);
    const vxs_light sun   = {.name         = "sun",
                             .kind         = VXS_LIGHT_KIND_DIRECTIONAL,
                             .levels       = log2_u32(m->side_px),
                             .ls_from_ws   = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0},
                             .texel_metres = 1,
                             .voxel_metres = 1,
                             .direction_ws = {0, -1, 0}};
    vxs_write_light light = dag_to_write(&sun, &d);
    vxs_write_desc  desc  = {.lights = &light, .light_count = 1, .zstd_level = 1};
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    assert_true(put64(&file, stats.mask_tiles) && put64(&file, stats.inserted_nodes)); /* what is reported of it is the same, too */
    dag_free(&d);
    dag_merger_free(&g);
    return file;
}

typedef vxs_bytes (*build_fn)(const column_map *m, uint32_t threads);

static const build_fn codings[] = {words_of, dag_file_of};

static void assert_equal_and_free(const vxs_bytes *want, vxs_bytes got)
{
    assert_int_equal(want->size_bytes, got.size_bytes);
    assert_memory_equal(want->data, got.data, got.size_bytes);
    free(got.data);
}

/* Built without a cache, built and stored, from the cache alone, and half from the cache. */
static void cached_squares_are_what_was_built(void **state)
{
    const uint32_t sides[] = {8, 64, 256, 512, 1024};
    (void)state;
    for (size_t s = 0; s < sizeof sides / sizeof *sides; s++)
        for (map_kind kind = 0; kind<MAP_KINDS; kind += sides[s]> 512 ? 5 : sides[s] > 64 ? repeats(3, 1) : 1)
            for (int coding = 0; coding < 2; coding++) {
                uint32_t     side = sides[s], least = coding ? sub_dag_side(side) : block_square_side(side);
                depth_maps   d      = random_maps(side, side, kind, side + kind);
                counted_map  c      = {.maps = &d};
                shelf        cached = {.known = 0};
                square_cache k      = {&cached, 0, NULL, shelf_find, shelf_store};
                uint32_t     px     = min_u32(side, 2 * least);
                column_map   bare = counted_columns(&c, px, NULL), m = counted_columns(&c, px, &k);
                vxs_bytes    want = codings[coding](&bare, 1);
                assert_equal_and_free(&want, codings[coding](&m, 2));
                assert_int_equal(cached.stored, (side / px) * (side / px));
                for (cached.known = 1; cached.known < 3; cached.known++) {
                    cached.asked = c.fetches = 0;
                    assert_equal_and_free(&want, codings[coding](&m, cached.known));
                    assert_int_equal(c.fetches, cached.known == 1 ? 0 : (side / px) * (side / px) / 2);
                }
                free(want.data);
                shelf_free(&cached);
                depth_maps_free(&d);
            }
}

/* Stored only: nothing is added; another process makes the same words from the records. */
static void squares_stored_only(void **state)
{
    (void)state;
    for (int coding = 0; coding < 2; coding++) {
        depth_maps   d      = random_maps(1024, 1024, MAPS_BOXES, 3);
        counted_map  c      = {.maps = &d};
        shelf        cached = {.known = 0};
        square_cache apart = {&cached, 1, NULL, shelf_find, shelf_store}, here = {&cached, 0, NULL, shelf_find, shelf_store};
        column_map   bare = counted_columns(&c, 256, NULL), m = counted_columns(&c, 256, &apart),
                   all = counted_columns(&c, 256, &here);
        vxs_bytes want = codings[coding](&bare, 1), nothing = codings[coding](&m, 2);
        assert_true(nothing.size_bytes < want.size_bytes / 2);
        assert_int_equal(cached.stored, 16);
        cached.known = 1;
        cached.asked = 0;
        assert_equal_and_free(&want, codings[coding](&all, 2));
        free(want.data);
        free(nothing.data);
        shelf_free(&cached);
        depth_maps_free(&d);
    }
}

/* Squares that threads fetch are those that are fetched on one thread; the same holds for stored squares. */
static void squares_fetched_by_threads(void **state)
{
    const uint32_t sides[] = {8, 64, 512, 1024};
    (void)state;
    for (size_t s = 0; s < sizeof sides / sizeof *sides; s++)
        for (map_kind kind = 0; kind<MAP_KINDS; kind += sides[s]> 512 ? repeats(5, 3) : sides[s] > 64 ? repeats(3, 1) : 1)
            for (int coding = 0; coding < 2; coding++) {
                uint32_t     side = sides[s], least = coding ? sub_dag_side(side) : block_square_side(side);
                depth_maps   d      = random_maps(side, side, kind, side + kind);
                counted_map  c      = {.maps = &d};
                shelf        cached = {.known = 0};
                square_cache k      = {&cached, 0, NULL, shelf_find, shelf_store};
                uint32_t     px     = min_u32(side, 2 * least);
                column_map   whole = counted_columns(&c, px, NULL), parts = whole, both = counted_columns(&c, px, &k);
                vxs_bytes    want = codings[coding](&whole, 1);
                assert_int_equal(c.alone, 0);
                parts.parallel_px = both.parallel_px = least;
                assert_equal_and_free(&want, codings[coding](&parts, 1));
                assert_int_equal(c.alone, (side / least) * (side / least));
                assert_equal_and_free(&want, codings[coding](&parts, 3));
                assert_equal_and_free(&want, codings[coding](&both, 2));
                both.parallel_px = 0;
                cached.known     = 2;
                cached.asked     = 0;
                assert_equal_and_free(&want, codings[coding](&both, 2));
                free(want.data);
                shelf_free(&cached);
                depth_maps_free(&d);
            }
}

/* Damage ---------------------------------------------------------------------------------------------------------------------- */

typedef struct damaged {
    depth_maps   d;
    counted_map  c;
    shelf        cached;
    square_cache k;
    column_map   m;
    vxs_bytes    want;
    build_fn     build;
} damaged;

static void damaged_begin(damaged *t, int coding, uint32_t side, map_kind kind)
{
    *t              = (damaged){.d = random_maps(side, side, kind, 11), .build = codings[coding]};
    t->c            = (counted_map){.maps = &t->d};
    t->k            = (square_cache){&t->cached, 0, NULL, shelf_find, shelf_store};
    t->m            = counted_columns(&t->c, side, &t->k);
    t->want         = t->build(&t->m, 1);
    t->cached.known = 1;
    assert_int_equal(t->cached.stored, 1);
}

/* What comes of other bytes in the place of the record. 1: the square was made again, and all is as it was. */
static int remade(damaged *t, vxs_bytes instead)
{
    run_context   quiet = {0};
    bake_context  ctx   = {.run = &quiet, .threads = 1};
    block_set     set   = {0};
    dag_merger    g     = {0};
    build_stats   stats = {0};
    build_options o     = {.rule = MASK_RULE_GREEDY, .reuse = 1, .compress = COMPRESS_TOP_DOWN, .share = 1};
    t->cached.instead   = instead;
    t->cached.asked = t->c.fetches = 0;
    vxs_result r;
    if (t->build == words_of) {
        block_words w = {0};
        r             = block_build_map(&set, 0, &t->m, &ctx);
        if (r == VXS_OK) r = block_words_lay_out(&w, &set, log2_u32(t->m.side_px), 1, 1);
        block_words_free(&w);
    } else {
        dag d = {.level_count = 0};
        r     = dag_merger_init(&g, t->m.side_px, 1, 1);
        if (r == VXS_OK) r = dag_build_map(&g, 0, &t->m, &o, &stats, &ctx);
        if (r == VXS_OK) r = dag_merger_finish(&g, &d);
        dag_free(&d);
    }
    assert_true(r == VXS_OK || r == VXS_E_VERSION);
    block_set_free(&set);
    dag_merger_free(&g);
    run_free(&quiet);
    t->cached.instead = (vxs_bytes){0};
    return t->c.fetches == 1;
}

static void damaged_end(damaged *t)
{
    free(t->want.data);
    shelf_free(&t->cached);
    depth_maps_free(&t->d);
}

/* A record that was cut, or has a byte more, is no record; one of which a byte is another is none, or can be built from. */
static void records_that_are_damaged(void **state)
{
    (void)state;
    for (int coding = 0; coding < 2; coding++) {
        damaged   t;
        rng       r = {5};
        vxs_bytes whole;
        damaged_begin(&t, coding, 128, MAPS_BOXES);
        whole = copy_of(&t.cached.record[0]);
        for (size_t size = 0; size <= whole.size_bytes + 1; size += size < 64 || size + 64 > whole.size_bytes ? 1 : 61) {
            if (size == whole.size_bytes) continue;
            vxs_bytes cut              = copy_of(&whole);
            cut.data[whole.size_bytes] = 0;
            cut.size_bytes             = size;
            assert_true(remade(&t, cut));
            free(cut.data);
        }
        uint32_t again = 0;
        for (int n = 0; n < 400; n++) {
            vxs_bytes other = copy_of(&whole);
            other.data[n < 200 ? (size_t)n % 68 : rng_below(&r, (uint32_t)other.size_bytes)] ^= (uint8_t)(1u << rng_below(&r, 8));
            again += (uint32_t)remade(&t, other);
            free(other.data);
        }
        assert_true(again > 200);
        free(whole.data);
        t.cached.asked = 0;
        assert_equal_and_free(&t.want, t.build(&t.m, 1));
        damaged_end(&t);
    }
}

/* What was built, with another byte, as whole and well packed as it was: no index leads out of it. */
static void built_bytes_of_another(void **state)
{
    (void)state;
    for (int coding = 0; coding < 2; coding++)
        for (map_kind kind = MAPS_NOISE; kind < MAP_KINDS; kind++) {
            damaged       t;
            rng           r      = {kind};
            square_record record = {0};
            damaged_begin(&t, coding, 64, kind);
            vxs_bytes whole = copy_of(&t.cached.record[0]);
            assert_int_equal(record_read(&record, whole.data, whole.size_bytes, square_level(64), 0, 0, 64), VXS_OK);
            uint32_t built_count = record.built_count, again = 0;
            for (int n = 0; n < 60 && built_count; n++) {
                vxs_bytes frames[SQUARES_MAX] = {{0}}, bytes = {0};
                uint64_t  sizes[SQUARES_MAX];
                uint32_t  spoilt = rng_below(&r, built_count), at = 0;
                for (const record_step *s = record.steps; s < record.steps + record.count; s++) {
                    vxs_bytes built = {0};
                    if (!s->is_built) continue;
                    assert_int_equal(record_unpack(s, &built), VXS_OK);
                    if (at == spoilt)
                        built.data[rng_below(&r, (uint32_t)(n < 30 ? min_u64(80, built.size_bytes) : built.size_bytes))] ^=
                            (uint8_t)(1u << rng_below(&r, 8));
                    assert_int_equal(record_pack(&built, &frames[at]), VXS_OK);
                    sizes[at++] = built.size_bytes;
                    free(built.data);
                }
                assert_int_equal(record_write(&record, frames, sizes, &bytes), VXS_OK);
                again += (uint32_t)remade(&t, bytes);
                for (uint32_t f = 0; f < at; f++) free(frames[f].data);
                free(bytes.data);
            }
            assert_true(!built_count || again > 10);
            record_free(&record);
            free(whole.data);
            damaged_end(&t);
        }
}

/* One of many that is not what it was, whichever: none of the others was added before that was seen. */
static void one_unsound_square_of_many(void **state)
{
    (void)state;
    for (int coding = 0; coding < 2; coding++) {
        damaged       t;
        square_record record = {0};
        damaged_begin(&t, coding, 1024, MAPS_NOISE);
        vxs_bytes whole = copy_of(&t.cached.record[0]);
        assert_int_equal(record_read(&record, whole.data, whole.size_bytes, square_level(1024), 0, 0, 1024), VXS_OK);
        assert_int_equal(record.built_count, 16);
        for (size_t spoilt = repeats(10, 0); spoilt < 16; spoilt += repeats(16, 5)) {
            vxs_bytes other = copy_of(&whole);
            memset(other.data + (record.steps[spoilt].frame - whole.data), 0, 4);
            t.cached.instead = other;
            t.cached.asked = t.c.fetches = 0;
            assert_equal_and_free(&t.want, t.build(&t.m, 2));
            assert_int_equal(t.c.fetches, 1);
            t.cached.instead = (vxs_bytes){0};
            free(other.data);
        }
        record_free(&record);
        free(whole.data);
        damaged_end(&t);
    }
}

/* Steps that are not in the order of the Z, lie outside the square, or leave a part of it out. */
static void steps_tile_the_square(void **state)
{
    const column_bounds b = {1, 2, 3, 4};
    const struct {
        uint32_t level, i, j;
    } steps[4]            = {{1, 4, 6}, {1, 5, 6}, {1, 4, 7}, {1, 5, 7}};
    const int orders[][5] = {{0, 1, 2, 3, -1}, {1, 0, 2, 3, -1}, {0, 1, 2, -1}, {0, 1, 2, 2, -1}, {-1}, {0, 1, 3, 2, -1}};
    (void)state;
    for (size_t n = 0; n < sizeof orders / sizeof *orders; n++) {
        square_record r = {0}, back = {0};
        vxs_bytes     bytes = {0};
        for (const int *at = orders[n]; *at >= 0; at++)
            assert_int_equal(record_add_settled(&r, steps[*at].level, steps[*at].i, steps[*at].j, &b), VXS_OK);
        assert_int_equal(record_write(&r, NULL, NULL, &bytes), VXS_OK);
        assert_int_equal(record_read(&back, bytes.data, bytes.size_bytes, 2, 2, 3, 8), n ? VXS_E_CORRUPT : VXS_OK);
        record_free(&back);
        if (!n) assert_int_equal(record_read(&back, bytes.data, bytes.size_bytes, 2, 3, 3, 8), VXS_E_CORRUPT);
        record_free(&back);
        if (!n)
            assert_int_equal(record_read(&back, bytes.data, bytes.size_bytes, 2, 2, 3, 3), VXS_E_CORRUPT); /* deeper than the map */
        record_free(&back);
        record_free(&r);
        free(bytes.data);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cached_squares_are_what_was_built),
        cmocka_unit_test(squares_stored_only),
        cmocka_unit_test(squares_fetched_by_threads),
        cmocka_unit_test(records_that_are_damaged),
        cmocka_unit_test(built_bytes_of_another),
        cmocka_unit_test(one_unsound_square_of_many),
        cmocka_unit_test(steps_tile_the_square),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
