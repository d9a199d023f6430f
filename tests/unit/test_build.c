/* Whole maps from columns, against formulas (baker/coding/dag/build.h, dag.h): every voxel of small maps, columns of maps of 262144
 * texels, the work that is done for them, merging, and errors of every call.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "formats/vxs_lookup.h"
#include "runtime/vxs.h"

#include "baker/base/random.h" /* before cmocka, whose fail() is a macro */
#include "baker/coding/dag/build.h"
#include "tests/columns/analytic.h"
#include "tests/unit/repeats.h"

#include <cmocka.h>

static const build_options plain = {.rule = MASK_RULE_GREEDY, .reuse = 1, .compress = COMPRESS_TOP_DOWN, .share = 1};

static bake_context context_of(run_context *m, uint32_t threads)
{
    return (bake_context){.run = m, .threads = threads};
}

static vxs_result add_map(dag_merger *g, analytic *a, const build_options *o, uint32_t threads, build_stats *stats)
{
    run_context   m      = {0};
    bake_context  ctx    = context_of(&m, threads);
    column_source source = analytic_source(a);
    column_map    map;
    vxs_result    r = source.open(source.data, 0, &map, &ctx);
    if (r != VXS_OK) return r;
    r = dag_build_map(g, 0, &map, o, stats, &ctx);
    map.close(map.data);
    run_free(&m);
    return r;
}

static vxs_result build(analytic *a, const build_options *o, int unify, uint32_t threads, dag *out)
{
    dag_merger  g;
    build_stats stats = {0};
    memset(out, 0, sizeof *out);
    vxs_result r = dag_merger_init(&g, a->side_px, 1, unify);
    if (r == VXS_OK) r = add_map(&g, a, o, threads, &stats);
    if (r == VXS_OK) r = dag_merger_finish(&g, out);
    dag_merger_free(&g);
    assert_int_equal(atomic_load(&a->open), 0); /* whatever happened, what was opened is closed */
    return r;
}

/* The file of a DAG. */
static vxs_bytes file_of(const dag *d)
{
    const vxs_light sun   = {.name         = "sun",
                             .kind         = VXS_LIGHT_KIND_DIRECTIONAL,
                             .levels       = d->level_count + 2,
                             .ls_from_ws   = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0},
                             .texel_metres = 1,
                             .voxel_metres = 1,
                             .direction_ws = {0, -1, 0}};
    vxs_write_light light = dag_to_write(&sun, d);
    vxs_write_desc  desc  = {.lights = &light, .light_count = 1, .zstd_level = 1};
    vxs_bytes       file  = {0};
    assert_int_equal(vxs_write(&file, &desc), VXS_OK);
    return file;
}

static vxs_asset *asset_of(const dag *d)
{
    vxs_bytes  file = file_of(d);
    vxs_asset *asset;
    assert_int_equal(vxs_asset_open(&asset, file.data, file.size_bytes, NULL), VXS_OK);
    free(file.data);
    return asset;
}

/* 1 when a voxel is neither as the depths say nor free. */
static int is_wrong(const analytic *a, const vxs_baked_light *light, uint32_t i, uint32_t j, uint32_t k)
{
    double enter, exit;
    analytic_depths(a, i + 0.5, j + 0.5, &enter, &exit);
    uint32_t dark = vxs_shadow(light->words, 0, light->light.levels, i, j, k);
    return dark ? k + 1.0 <= enter : k >= exit;
}

static void assert_every_voxel(const analytic *a, const dag *d)
{
    vxs_asset *asset = asset_of(d);
    uint64_t   wrong = 0;
    for (uint32_t k = 0; k < a->side_px; k++)
        for (uint32_t j = 0; j < a->side_px; j++)
            for (uint32_t i = 0; i < a->side_px; i++) wrong += (uint64_t)is_wrong(a, vxs_asset_light(asset, 0), i, j, k);
    assert_int_equal(wrong, 0);
    vxs_asset_close(asset);
}

/* Random columns: around their depths, at both ends, and somewhere. */
static void assert_columns(const analytic *a, const dag *d, uint32_t count)
{
    vxs_asset             *asset = asset_of(d);
    const vxs_baked_light *light = vxs_asset_light(asset, 0);
    rng                    r     = {7};
    uint64_t               wrong = 0, in_shape = 0;
    for (uint32_t n = 0; n < count; n++) {
        uint32_t i = rng_below(&r, a->side_px), j = rng_below(&r, a->side_px);
        double   enter, exit;
        analytic_depths(a, i + 0.5, j + 0.5, &enter, &exit);
        in_shape += enter < a->side_px;
        uint32_t at[] = {0, (uint32_t)enter, (uint32_t)exit, rng_below(&r, a->side_px), a->side_px - 1};
        for (int place = 0; place < 5; place++)
            for (uint32_t k = at[place] > 2 ? at[place] - 2 : 0; k <= at[place] + 2 && k < a->side_px; k++)
                wrong += (uint64_t)is_wrong(a, light, i, j, k);
    }
    assert_int_equal(wrong, 0);
    assert_true(in_shape > count / 20);
    vxs_asset_close(asset);
}

static void every_voxel_of_every_shape(void **state)
{
    (void)state;
    for (uint32_t side = 8; side <= 128; side *= repeats(4, 2))
        for (analytic_kind kind = 0; kind < ANALYTIC_KINDS; kind++)
            for (int way = 0; way < 16; way++) {
                build_options o = {.rule     = way & 1 ? MASK_RULE_SHADOW : MASK_RULE_GREEDY,
                                   .reuse    = way >> 1 & 1,
                                   .share    = way >> 2 & 1,
                                   .compress = (compress_order)(way % 3)};
                analytic      a = analytic_shape(kind, side);
                dag           d;
                a.fetch_px = way & 8 ? sub_dag_side(side) : side;
                assert_int_equal(build(&a, &o, !(way & 4) ? 0 : 1, 1 + (uint32_t)way % 3, &d), VXS_OK);
                assert_every_voxel(&a, &d);
                dag_free(&d);
            }
}

static void assert_same_file(const dag *a, const dag *b)
{
    vxs_bytes x = file_of(a), y = file_of(b);
    assert_int_equal(x.size_bytes, y.size_bytes);
    assert_memory_equal(x.data, y.data, x.size_bytes);
    free(x.data);
    free(y.data);
}

/* Threads, the size of fetched squares, and parts that are kept once make no difference to the bytes. */
static void one_file_however_it_is_built(void **state)
{
    (void)state;
    for (analytic_kind kind = 0; kind < ANALYTIC_KINDS; kind++) {
        analytic a = analytic_shape(kind, 1024);
        dag      first, other;
        a.plane_count = 1; /* perpendicular to the light: all columns alike */
        assert_int_equal(build(&a, &plain, 1, 1, &first), VXS_OK);
        for (int way = 0; way < 12; way++) {
            build_options o = plain;
            o.share         = way & 1;
            o.compress      = (compress_order)(way % 3);
            a.fetch_px      = 1024u >> way % 3;
            assert_int_equal(build(&a, &o, 1, way & 2 ? 4 : 1, &other), VXS_OK);
            assert_same_file(&first, &other);
            dag_free(&other);
        }
        dag_free(&first);
    }
}

/* The largest map that the format has: a box, a sphere, and a plane perpendicular to the light. */
static void maps_of_262144_texels(void **state)
{
    (void)state;
    for (analytic_kind kind = 0; kind < ANALYTIC_KINDS; kind++) {
        analytic a = analytic_shape(kind, 262144);
        dag      d;
        a.plane_count = 1;
        assert_int_equal(build(&a, &plain, 1, 2, &d), VXS_OK);
        assert_columns(&a, &d, 100000);
        dag_free(&d);
    }
}

/* Work follows silhouettes: calls at most double with the side of the map, and are few beside its 10^9 tiles. */
static void work_follows_silhouettes(void **state)
{
    (void)state;
    for (analytic_kind kind = 0; kind < ANALYTIC_PLANES; kind++) {
        uint64_t last = 0;
        for (uint32_t side = 16384; side <= 262144; side *= 2) {
            analytic a = analytic_shape(kind, side);
            dag      d;
            assert_int_equal(build(&a, &plain, 1, 1, &d), VXS_OK);
            uint64_t calls = atomic_load(&a.calls);
            assert_true(calls < 10 * (uint64_t)side);
            assert_true(!last || calls < 2.1 * (double)last);
            last = calls;
            dag_free(&d);
        }
    }
    analytic ground    = analytic_shape(ANALYTIC_PLANES, 262144);
    ground.plane_count = 1;
    dag d;
    assert_int_equal(build(&ground, &plain, 1, 1, &d), VXS_OK);
    assert_true(atomic_load(&ground.calls) < 100); /* all columns are alike */
    dag_free(&d);
}

/* mergers --------------------------------------------------------------------------------------------------------------------- */

/* A quarter of a map as a map of its own would be fetched: the columns of square (i, j) of half the side. */
static void add_quarter(dag_merger *g, analytic *a, uint32_t i, uint32_t j)
{
    run_context   m     = {0};
    bake_context  ctx   = context_of(&m, 1);
    build_stats   stats = {0};
    uint32_t      sub = square_level(sub_dag_side(a->side_px)), half = square_level(a->side_px) - 1, across = 1u << (half - sub);
    column_square square;
    assert_int_equal(analytic_fetch(a, half, i, j, &square, &ctx), VXS_OK);
    for (uint32_t n = 0; n < across * across; n++) {
        dag d;
        assert_int_equal(dag_build_square(&d, &square, sub, n % across, n / across, &plain, &stats), VXS_OK);
        assert_int_equal(dag_merger_add(g, &d, 0, sub, i * across + n % across, j * across + n / across), VXS_OK);
        dag_free(&d);
    }
    analytic_release(a, &square);
}

/* Quarters that are added in any order are the map built at once. */
static void parts_are_merged(void **state)
{
    (void)state;
    for (analytic_kind kind = 0; kind < ANALYTIC_KINDS; kind++)
        for (uint32_t first = 0; first < 4; first++) {
            analytic   a = analytic_shape(kind, 256);
            dag        at_once, merged;
            dag_merger whole;
            assert_int_equal(build(&a, &plain, 1, 1, &at_once), VXS_OK);
            assert_int_equal(dag_merger_init(&whole, 256, 1, 1), VXS_OK);
            for (uint32_t n = 0; n < 4; n++) {
                uint32_t quarter = (n * 3 + first) % 4;
                add_quarter(&whole, &a, quarter % 2, quarter / 2);
            }
            assert_int_equal(dag_merger_finish(&whole, &merged), VXS_OK);
            dag_merger_free(&whole);
            assert_same_file(&at_once, &merged);
            dag_free(&at_once);
            dag_free(&merged);
        }
}

/* A square is added once, within its map. */
static void what_cannot_be_merged(void **state)
{
    analytic   a = analytic_shape(ANALYTIC_SPHERE, 256);
    dag_merger one;
    (void)state;
    assert_int_equal(dag_merger_init(&one, 256, 1, 1), VXS_OK);
    add_quarter(&one, &a, 1, 0);
    assert_int_equal(dag_merger_add_split(&one, 0, square_level(256) - 1, 1, 0, square_level(64), 0), VXS_E_ARGUMENT);
    assert_int_equal(dag_merger_add_split(&one, 0, square_level(256), 0, 0, square_level(64), 0), VXS_E_ARGUMENT);
    assert_int_equal(dag_merger_add_split(&one, 0, square_level(64), 4, 0, square_level(64), 0), VXS_E_ARGUMENT);
    assert_int_equal(dag_merger_add_split(&one, 1, square_level(64), 0, 0, square_level(64), 0), VXS_E_ARGUMENT);
    assert_int_equal(dag_merger_add_split(&one, 0, square_level(64), 0, 0, square_level(64), 5), VXS_E_ARGUMENT);
    dag_merger_free(&one);
}

/* errors ---------------------------------------------------------------------------------------------------------------------- */

/* Each call of a source may fail, and what it returns is what the build returns. */
static void every_call_may_fail(void **state)
{
    static const vxs_result failures[] = {VXS_E_GL, VXS_E_MEMORY, VXS_E_READ};
    (void)state;
    for (uint32_t threads = 1; threads <= 3; threads += 2) {
        analytic a = analytic_shape(ANALYTIC_SPHERE, 256);
        dag      d;
        a.fetch_px = 128;
        assert_int_equal(build(&a, &plain, 1, 1, &d), VXS_OK);
        dag_free(&d);
        uint64_t calls = atomic_load(&a.calls);
        for (uint64_t n = 1; n <= calls; n++) {
            atomic_store(&a.calls, 0);
            a.fail_at = n;
            a.failure = failures[n % 3];
            assert_int_equal(build(&a, &plain, 1, threads, &d), a.failure);
        }
        atomic_store(&a.calls, 0);
        a.fail_at = calls + 1;
        assert_int_equal(build(&a, &plain, 1, 1, &d), VXS_OK);
        dag_free(&d);
    }
}

/* 32-bit references running out is an error of its own, at whatever node or mask it happens. */
static void references_run_out(void **state)
{
    (void)state;
    analytic a = analytic_shape(ANALYTIC_SPHERE, 128);
    dag      d;
    assert_int_equal(build(&a, &plain, 1, 1, &d), VXS_OK);
    uint32_t most = d.mask_count;
    for (uint32_t l = 0; l < d.level_count; l++) most = max_u32(most, d.level[l].count);
    dag_free(&d);
    for (uint32_t limit = 1; limit <= most; limit++) {
        dag_merger  g;
        build_stats stats = {0};
        assert_int_equal(dag_merger_init(&g, 128, 1, 1), VXS_OK);
        g.merged.limit = limit;
        vxs_result r   = add_map(&g, &a, &plain, 1, &stats);
        if (r == VXS_OK) r = dag_merger_finish(&g, &d);
        assert_int_equal(r, limit < most ? VXS_E_REFERENCES : VXS_OK);
        if (r == VXS_OK) dag_free(&d);
        dag_merger_free(&g);
    }
    assert_string_not_equal(vxs_result_text(VXS_E_REFERENCES), vxs_result_text(VXS_E_MEMORY));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_voxel_of_every_shape), cmocka_unit_test(one_file_however_it_is_built),
        cmocka_unit_test(maps_of_262144_texels),      cmocka_unit_test(work_follows_silhouettes),
        cmocka_unit_test(parts_are_merged),           cmocka_unit_test(what_cannot_be_merged),
        cmocka_unit_test(every_call_may_fail),        cmocka_unit_test(references_run_out),
    };
    return cmocka_run_group_tests_name("build", tests, NULL, NULL);
}
