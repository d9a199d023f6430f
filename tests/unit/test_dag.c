/* Insertion, compression and merge of DAGs: expanded back to voxels against the columns, counted against brute force
 * (baker/coding/dag/dag.h). SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "baker/bake/bake.h" /* before cmocka, whose fail() is a macro */
#include "baker/base/ref_table.h"
#include "baker/lab/opengl/depth_gl.h"
#include "scenes/generate.h"

#include <cmocka.h>

#include "tests/unit/random_maps.h"
#include "tests/unit/repeats.h"

typedef struct insert_way {
    mask_rule rule;
    int       reuse;
} insert_way;

static const insert_way ways[] = {{MASK_RULE_GREEDY, 1}, {MASK_RULE_GREEDY, 0}, {MASK_RULE_SHADOW, 1}, {MASK_RULE_SHADOW, 0}};

/* --- making and reading DAGs
 * ------------------------------------------------------------------------------------------------- */

static void make_maps(depth_maps *d, uint32_t side, uint32_t depth, map_kind kind, uint64_t seed)
{
    run_context m = {0};
    rng         r = rng_split(seed, kind);
    assert_int_equal(depth_maps_init(d, side, depth, 0, 1, &m), VXS_OK);
    fill_maps(d, kind, &r);
    depth_maps_reduce(d, 1);
}

/* The DAG of the square of `side` texels at (i, j). */
static dag insert_columns(const column_square *s, uint32_t side, uint32_t i, uint32_t j, insert_way o)
{
    build_options options = {.rule = o.rule, .reuse = o.reuse};
    build_stats   stats   = {0};
    dag           d;
    assert_int_equal(dag_build_square(&d, s, square_level(side), i, j, &options, &stats), VXS_OK);
    assert_int_equal(d.level_count, square_level(side) + 1);
    assert_int_equal(d.root_count, s->depth_vx / side);
    return d;
}

static dag insert(const depth_maps *maps, uint32_t side, uint32_t i, uint32_t j, insert_way o)
{
    column_square s = depth_maps_square(maps);
    return insert_columns(&s, side, i, j, o);
}

/* The slice of 8 x 8 texels that voxel (i, j, k) is in: bit i % 8 + 8 * (j % 8), 1 for shadow. */
static uint64_t slice(const dag *d, uint32_t i, uint32_t j, uint32_t k)
{
    uint32_t level = d->level_count - 1;
    uint32_t ref   = d->roots[k >> (level + 3)];
    for (; ref >= REF_FIRST; level--) {
        assert_true(ref - REF_FIRST < d->level[level].count);
        const uint32_t *child = d->level[level].nodes[ref - REF_FIRST].child;
        if (!level) {
            ref = child[k & 7];
            break;
        }
        ref = child[(i >> (level + 2) & 1) + 2 * (j >> (level + 2) & 1) + 4 * (k >> (level + 2) & 1)];
    }
    if (ref < REF_FIRST) return 0 - (uint64_t)(ref == REF_SHADOW);
    assert_true(ref - REF_FIRST < d->mask_count);
    return d->masks[ref - REF_FIRST];
}

static int voxel(const dag *d, uint32_t i, uint32_t j, uint32_t k)
{
    return (int)(slice(d, i, j, k) >> ((i & 7) + 8 * (j & 7)) & 1);
}

/* Every voxel of a DAG whose first texel is (i0, j0) of the maps. */
static void assert_exact(const dag *d, const depth_maps *maps, uint32_t i0, uint32_t j0)
{
    uint32_t side  = 4u << d->level_count;
    size_t   wrong = 0;
    for (uint32_t k = 0; k < maps->depth_vx; k++)
        for (uint32_t j = 0; j < side; j += 8)
            for (uint32_t i = 0; i < side; i += 8) {
                uint64_t found = slice(d, i, j, k);
                for (uint32_t n = 0; n < 64; n++) {
                    int want = wanted(maps, i0 + i + n % 8, j0 + j + n / 8, k);
                    wrong += want >= 0 && (int)(found >> n & 1) != want;
                }
            }
    assert_int_equal(wrong, 0);
}

static void assert_same_voxels(const dag *a, const dag *b, uint32_t side, uint32_t depth)
{
    for (uint32_t k = 0; k < depth; k++)
        for (uint32_t j = 0; j < side; j += 8)
            for (uint32_t i = 0; i < side; i += 8) assert_true(slice(a, i, j, k) == slice(b, i, j, k));
}

/* --- counting by brute force
 * ------------------------------------------------------------------------------------------------- */

/* Distinct subtrees by level that the roots reach: count[0] masks, count[1 + level] nodes. Every subtree is named by the
 * first one that is equal to it, found by comparing with all before it. */
typedef struct census {
    uint32_t count[DAG_LEVELS_MAX + 1];
} census;

static void reach(const dag *d, uint32_t level, uint32_t ref, uint8_t **seen)
{
    if (ref < REF_FIRST || seen[level][ref - REF_FIRST]) return;
    seen[level][ref - REF_FIRST] = 1;
    for (int c = 0; c < 8 && level; c++) reach(d, level - 1, d->level[level - 1].nodes[ref - REF_FIRST].child[c], seen);
}

static census take_census(const dag *d)
{
    uint8_t  *seen[DAG_LEVELS_MAX + 1];
    uint32_t *name[DAG_LEVELS_MAX + 1];
    census    result = {{0}};
    for (uint32_t l = 0; l <= d->level_count; l++) {
        uint32_t count = l ? d->level[l - 1].count : d->mask_count;
        seen[l]        = calloc(count + 1, 1);
        name[l]        = calloc(count + 1, sizeof **name);
        assert_non_null(seen[l]);
        assert_non_null(name[l]);
    }
    for (uint32_t n = 0; n < d->root_count; n++) reach(d, d->level_count, d->roots[n], seen);

    for (uint32_t l = 0; l <= d->level_count; l++) {
        uint32_t  count = l ? d->level[l - 1].count : d->mask_count;
        dag_node *named = calloc(count + 1, sizeof *named);
        uint32_t *kept = calloc(count + 1, sizeof *kept), kept_count = 0;
        assert_non_null(named);
        assert_non_null(kept);
        for (uint32_t n = 0; n < count; n++) {
            if (!seen[l][n]) continue;
            for (int c = 0; c < 8 && l; c++) {
                uint32_t child    = d->level[l - 1].nodes[n].child[c];
                named[n].child[c] = child < REF_FIRST ? child : name[l - 1][child - REF_FIRST];
            }
            if (!l) memcpy(&named[n], &d->masks[n], sizeof *d->masks);
            uint32_t at = 0;
            while (at < kept_count && memcmp(&named[kept[at]], &named[n], sizeof *named)) at++;
            if (at == kept_count) kept[kept_count++] = n;
            name[l][n] = REF_FIRST + kept[at];
        }
        result.count[l] = kept_count;
        free(named);
        free(kept);
    }
    for (uint32_t l = 0; l <= d->level_count; l++) {
        free(seen[l]);
        free(name[l]);
    }
    return result;
}

/* Nothing twice and nothing that is not reached. */
static void assert_minimal(const dag *d, census least)
{
    assert_int_equal(d->mask_count, least.count[0]);
    for (uint32_t l = 0; l < d->level_count; l++) assert_int_equal(d->level[l].count, least.count[1 + l]);
    census now = take_census(d);
    assert_memory_equal(&now, &least, sizeof now);
}

static void assert_hashes(const dag *d)
{
    for (uint32_t l = 0; l < d->level_count; l++)
        for (uint32_t n = 0; n < d->level[l].count; n++)
            assert_true(d->level[l].hash[n] == dag_node_hash(d, l, &d->level[l].nodes[n]));
}

/* Spoil all hashes alike: equal subtrees still have equal ones, but so have others. */
static void lie(dag *d, uint64_t keep)
{
    for (uint32_t l = 0; l < d->level_count; l++)
        for (uint32_t n = 0; n < d->level[l].count; n++) d->level[l].hash[n] &= keep;
}

static const uint64_t lies[] = {~(uint64_t)0, 0, 0xf, (uint64_t)0xf << 32};

/* --- insertion and compression
 * ----------------------------------------------------------------------------------------------- */

static void check_square(const depth_maps *maps)
{
    for (int way = 0; way < 4; way++) {
        dag    inserted = insert(maps, maps->side_px, 0, 0, ways[way]);
        census least    = take_census(&inserted);
        assert_exact(&inserted, maps, 0, 0);
        assert_hashes(&inserted);
        dag_free(&inserted);
        for (compress_order order = COMPRESS_TOP_DOWN; order <= COMPRESS_BOTTOM_UP; order++) {
            dag d = insert(maps, maps->side_px, 0, 0, ways[way]);
            assert_int_equal(dag_compress(&d, order), VXS_OK);
            assert_exact(&d, maps, 0, 0);
            assert_minimal(&d, least);
            assert_hashes(&d);
            assert_int_equal(dag_compress(&d, order), VXS_OK);
            assert_minimal(&d, least); /* once more changes nothing */
            dag_free(&d);
        }
    }
}

static void every_voxel_of_random_fields(void **state)
{
    (void)state;
    for (uint32_t side = 8; side <= 32; side *= 2)
        for (map_kind kind = 0; kind < MAP_KINDS; kind++)
            for (uint64_t seed = 0; seed < 128 / side; seed++) {
                depth_maps maps;
                make_maps(&maps, side, side, kind, seed);
                check_square(&maps);
                depth_maps_free(&maps);
            }
}

static void every_voxel_of_larger_fields(void **state)
{
    (void)state;
    for (map_kind kind = 0; kind < MAP_KINDS; kind++) {
        depth_maps maps;
        make_maps(&maps, 64, 64, kind, 7);
        check_square(&maps);
        depth_maps_free(&maps);
    }
}

/* A sub-DAG is as wide as its square and as deep as the map: slabs refer to each other's nodes. */
static void slabs_of_a_deep_map(void **state)
{
    (void)state;
    for (map_kind kind = 0; kind < MAP_KINDS; kind++) {
        depth_maps maps;
        make_maps(&maps, 16, 256, kind, 3);
        check_square(&maps);
        depth_maps_free(&maps);
    }
}

/* Reuse only refers to what would have been built again: the voxels, free ones too, are the same, with fewer nodes. */
static void reuse_changes_no_voxel(void **state)
{
    (void)state;
    uint64_t with = 0, without = 0;
    for (map_kind kind = 0; kind < MAP_KINDS; kind++)
        for (mask_rule rule = MASK_RULE_GREEDY; rule <= MASK_RULE_SHADOW; rule++) {
            depth_maps maps;
            make_maps(&maps, 32, 128, kind, 5);
            dag on = insert(&maps, 32, 0, 0, (insert_way){rule, 1}), off = insert(&maps, 32, 0, 0, (insert_way){rule, 0});
            assert_same_voxels(&on, &off, 32, 128);
            assert_true(dag_node_count(&on) <= dag_node_count(&off));
            assert_true(on.mask_count <= off.mask_count);
            with += dag_node_count(&on);
            without += dag_node_count(&off);
            dag_free(&on);
            dag_free(&off);
            depth_maps_free(&maps);
        }
    assert_true(with < without);
}

static vxs_result loose_bounds(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *b)
{
    const depth_maps *d  = data;
    uint32_t          by = (i + j + level) % 11;
    assert_int_equal(depth_maps_square(d).bounds(data, level, i, j, b), VXS_OK);
    b->emin = b->emin > by ? b->emin - by : 0;
    b->xmin = b->xmin > by ? b->xmin - by : 0;
    b->emax = b->emax + by < d->depth_vx ? b->emax + by : d->depth_vx;
    b->xmax = b->xmax + by < d->depth_vx ? b->xmax + by : d->depth_vx;
    return VXS_OK;
}

/* A source may bound its squares loosely, as long as it is not wrong. */
static void loose_bounds_are_right(void **state)
{
    (void)state;
    for (map_kind kind = 0; kind < MAP_KINDS; kind++)
        for (int way = 0; way < 4; way++) {
            depth_maps maps;
            make_maps(&maps, 32, 64, kind, 11);
            column_square s = depth_maps_square(&maps);
            s.bounds        = loose_bounds;
            dag    d        = insert_columns(&s, 32, 0, 0, ways[way]);
            census least    = take_census(&d);
            assert_exact(&d, &maps, 0, 0);
            assert_int_equal(dag_compress(&d, COMPRESS_TOP_DOWN), VXS_OK);
            assert_exact(&d, &maps, 0, 0);
            assert_minimal(&d, least);
            dag_free(&d);
            depth_maps_free(&maps);
        }
}

/* Contents decide: with hashes that say little or nothing, the result is as exact and as small. */
static void lying_hashes_do_not_matter(void **state)
{
    (void)state;
    for (map_kind kind = 0; kind < MAP_KINDS; kind++)
        for (int n = 0; n < 4; n++)
            for (compress_order order = COMPRESS_TOP_DOWN; order <= COMPRESS_BOTTOM_UP; order++) {
                depth_maps maps;
                make_maps(&maps, 32, 64, kind, 13);
                dag    d     = insert(&maps, 32, 0, 0, ways[n % 2]);
                census least = take_census(&d);
                lie(&d, lies[n]);
                assert_int_equal(dag_compress(&d, order), VXS_OK);
                assert_exact(&d, &maps, 0, 0);
                assert_minimal(&d, least);
                dag_free(&d);
                depth_maps_free(&maps);
            }
}

/* The same for graphs that no scene gives: small, with few different nodes, each many times. */
static void random_graphs_with_lying_hashes(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 300; seed++)
        for (compress_order order = COMPRESS_TOP_DOWN; order <= COMPRESS_BOTTOM_UP; order++) {
            rng r   = rng_split(seed, 17);
            dag d   = {.level_count = 2, .root_count = 12}, before;
            d.roots = malloc(12 * sizeof *d.roots);
            assert_non_null(d.roots);
            for (int copy = 0; copy < 2; copy++) {
                uint32_t masks[6], slices[10];
                for (int n = 0; n < 6; n++) masks[n] = dag_add_mask(&d, 1 + rng_below(&r, 3));
                for (int n = 0; n < 10; n++) {
                    dag_node node = {{masks[rng_below(&r, 6)], masks[rng_below(&r, 6)], 1, 1, 1, 1, 1, 1}};
                    slices[n]     = dag_add_node(&d, 0, &node);
                }
                for (int n = 0; n < 6; n++) {
                    dag_node node         = {{slices[rng_below(&r, 10)], 0, slices[rng_below(&r, 10)], 0, 0, 0, 1, 1}};
                    d.roots[6 * copy + n] = dag_add_node(&d, 1, &node);
                }
            }
            before       = d;
            before.roots = memcpy(malloc(12 * sizeof *d.roots), d.roots, 12 * sizeof *d.roots);
            before.masks = memcpy(malloc(12 * sizeof *d.masks), d.masks, 12 * sizeof *d.masks);
            for (int l = 0; l < 2; l++) {
                size_t bytes          = d.level[l].count * sizeof(dag_node);
                before.level[l].nodes = memcpy(malloc(bytes), d.level[l].nodes, bytes);
                before.level[l].hash  = NULL;
            }
            census least = take_census(&d);
            lie(&d, lies[seed % 4]);
            assert_int_equal(dag_compress(&d, order), VXS_OK);
            census now = take_census(&d); /* bottom-up keeps what no root reaches: insertion leaves nothing such */
            assert_memory_equal(&now, &least, sizeof now);
            if (order == COMPRESS_TOP_DOWN) assert_minimal(&d, least);
            assert_same_voxels(&d, &before, 16, 12 * 16);
            dag_free(&d);
            dag_free(&before);
        }
}

typedef struct tagged_mask {
    uint64_t hash, mask;
} tagged_mask;

static int by_hash(const void *a, const void *b)
{
    uint64_t x = ((const tagged_mask *)a)->hash, y = ((const tagged_mask *)b)->hash;
    return x < y ? -1 : x > y;
}

/* Pairs of different masks whose hashes a table cannot distinguish: of 300 000 masks about ten pairs share 32 bits. */
static void masks_whose_hashes_meet(void **state)
{
    enum { COUNT = 300000 };
    (void)state;
    tagged_mask *all = malloc(COUNT * sizeof *all);
    rng          r   = {1};
    assert_non_null(all);
    for (int n = 0; n < COUNT; n++) {
        all[n].mask = (uint64_t)rng_u32(&r) << 32 | rng_u32(&r);
        all[n].hash = ref_hash_mask(all[n].mask);
    }
    qsort(all, COUNT, sizeof *all, by_hash);
    int pairs = 0;
    for (int n = 1; n < COUNT; n++) {
        if (all[n].hash >> 32 != all[n - 1].hash >> 32) continue;
        pairs++;
        for (int merging = 0; merging < 2; merging++) {
            dag      d    = {.level_count = 1, .root_count = 1}, merged;
            dag_node node = {{0, 0, 0, 0, 0, 0, 0, 1}};
            node.child[2] = dag_add_mask(&d, all[n - 1].mask);
            node.child[3] = dag_add_mask(&d, all[n].mask);
            d.roots       = malloc(sizeof *d.roots);
            assert_non_null(d.roots);
            d.roots[0] = dag_add_node(&d, 0, &node);
            if (merging) {
                dag_merger merger;
                assert_int_equal(dag_merger_init(&merger, 8, 1, 1), VXS_OK);
                assert_int_equal(dag_merger_add(&merger, &d, 0, 0, 0, 0), VXS_OK);
                assert_int_equal(dag_merger_finish(&merger, &merged), VXS_OK);
                dag_merger_free(&merger);
                dag_free(&d);
                d = merged;
            } else {
                assert_int_equal(dag_compress(&d, COMPRESS_TOP_DOWN), VXS_OK);
            }
            assert_int_equal(d.mask_count, 2);
            for (uint32_t t = 0; t < 64; t++) {
                assert_int_equal(voxel(&d, t % 8, t / 8, 2), all[n - 1].mask >> t & 1);
                assert_int_equal(voxel(&d, t % 8, t / 8, 3), all[n].mask >> t & 1);
            }
            dag_free(&d);
        }
    }
    assert_true(pairs > 0);
    free(all);
}

/* A level by hand: a mask, a node and a subtree twice each. */
static void equal_subtrees_are_kept_once(void **state)
{
    (void)state;
    for (compress_order order = COMPRESS_TOP_DOWN; order <= COMPRESS_BOTTOM_UP; order++) {
        dag      d = {.level_count = 2, .root_count = 3};
        uint32_t a = dag_add_mask(&d, 5), b = dag_add_mask(&d, 5), c = dag_add_mask(&d, 6);
        dag_node x = {{a, a, b, 1, 1, 1, 1, 1}}, y = {{b, b, a, 1, 1, 1, 1, 1}}, z = {{b, b, c, 1, 1, 1, 1, 1}};
        uint32_t p = dag_add_node(&d, 0, &x), q = dag_add_node(&d, 0, &y), r = dag_add_node(&d, 0, &z);
        dag_node s = {{p, q, 0, 1, p, q, 0, 1}}, t = {{q, p, 0, 1, q, q, 0, 1}}, u = {{r, p, 0, 1, q, q, 0, 1}};
        d.roots = malloc(3 * sizeof *d.roots);
        assert_non_null(d.roots);
        d.roots[0] = dag_add_node(&d, 1, &s);
        d.roots[1] = dag_add_node(&d, 1, &t);
        d.roots[2] = dag_add_node(&d, 1, &u);
        assert_int_equal(dag_compress(&d, order), VXS_OK);
        assert_int_equal(d.mask_count, 2);
        assert_int_equal(d.level[0].count, 2);
        assert_int_equal(d.level[1].count, 2);
        assert_int_equal(d.root_count, 3);
        assert_int_equal(d.roots[0], d.roots[1]);
        assert_int_not_equal(d.roots[0], d.roots[2]);
        dag_free(&d);
        dag_free(&d); /* a zeroed object is accepted */
    }
}

/* --- merging
 * ----------------------------------------------------------------------------------------------------------------- */

/* The map of maps->side_px texels from sub-DAGs of `sub` texels. compress: 0 as inserted, else before merging. */
static dag merge(const depth_maps *maps, uint32_t sub, insert_way o, int compress, int unify, int backwards, uint64_t keep)
{
    dag_merger merger;
    dag        d;
    uint32_t   side = maps->side_px / sub;
    assert_int_equal(dag_merger_init(&merger, maps->side_px, 1, unify), VXS_OK);
    for (uint32_t n = 0; n < side * side; n++) {
        uint32_t at = backwards ? side * side - 1 - n : n;
        dag      s  = insert(maps, sub, at % side, at / side, o);
        if (compress) assert_int_equal(dag_compress(&s, COMPRESS_TOP_DOWN), VXS_OK);
        lie(&s, keep);
        assert_exact(&s, maps, at % side * sub, at / side * sub);
        assert_int_equal(dag_merger_add(&merger, &s, 0, square_level(sub), at % side, at / side), VXS_OK);
        dag_free(&s);
    }
    assert_int_equal(dag_merger_finish(&merger, &d), VXS_OK);
    dag_merger_free(&merger);
    assert_int_equal(d.root_count, 1);
    assert_true(d.roots[0] >= REF_FIRST);
    return d;
}

/* Built at once; a root that is all lit or all shadow becomes a node, as in a merged DAG. */
static dag whole(const depth_maps *maps, insert_way o)
{
    dag d = insert(maps, maps->side_px, 0, 0, o);
    assert_int_equal(dag_compress(&d, COMPRESS_BOTTOM_UP), VXS_OK);
    if (d.roots[0] < REF_FIRST) {
        dag_node n;
        for (int c = 0; c < 8; c++) n.child[c] = d.roots[0];
        d.roots[0] = dag_add_node(&d, d.level_count - 1, &n);
    }
    return d;
}

static void merging_is_building_at_once(void **state)
{
    (void)state;
    for (map_kind kind = 0; kind < MAP_KINDS; kind++)
        for (uint32_t sub = 8; sub <= 64; sub *= repeats(4, 2))
            for (int way = 0; way < 4; way++) {
                depth_maps maps;
                make_maps(&maps, 64, 64, kind, sub);
                dag    at_once = whole(&maps, ways[way]);
                census least   = take_census(&at_once);
                for (int variant = 0; variant < 4; variant++) {
                    dag merged = merge(&maps, sub, ways[way], variant & 1, 1, variant >> 1, lies[variant]);
                    assert_exact(&merged, &maps, 0, 0);
                    assert_minimal(&merged, least);
                    if (variant == 0) assert_same_voxels(&merged, &at_once, 64, 64);
                    dag_free(&merged);
                }
                dag_free(&at_once);
                depth_maps_free(&maps);
            }
}

/* One map of a DAG that holds several; borrowed. */
static dag map_of(const dag *d, uint32_t map)
{
    dag one        = *d;
    one.roots      = d->roots + map;
    one.root_count = 1;
    return one;
}

/* Six maps, added map by map, square by square, or backwards: each is what it is alone, and what they have in common is there
 * once. */
static void six_maps_share_one_dag(void **state)
{
    enum { MAPS = 6, SIDE = 32 };
    (void)state;
    for (uint64_t seed = 0; seed < 30; seed++)
        for (int unify = 0; unify < 2; unify++) {
            rng        r   = rng_split(seed, 70);
            uint32_t   sub = 8u << rng_below(&r, 3), side = SIDE / sub, count = MAPS * side * side;
            int        order = (int)(seed % 3), same = seed % 5 == 4, left_out = seed % 7 == 6; /* the fourth map */
            depth_maps maps[MAPS];
            dag_merger merger;
            dag        d, alone[MAPS];
            assert_int_equal(dag_merger_init(&merger, SIDE, MAPS, unify), VXS_OK);
            for (uint32_t m = 0; m < MAPS; m++)
                make_maps(&maps[m], SIDE, SIDE, same ? MAPS_BOXES : (map_kind)rng_below(&r, MAP_KINDS), same ? 1 : seed + m);
            for (uint32_t n = 0; n < count; n++) {
                uint32_t at = order == 2 ? count - 1 - n : n;
                uint32_t m = order == 1 ? at % MAPS : at / (side * side), square = order == 1 ? at / MAPS : at % (side * side);
                if (left_out && m == 3) continue;
                dag part = insert(&maps[m], sub, square % side, square / side, ways[seed % 4]);
                assert_int_equal(dag_compress(&part, COMPRESS_TOP_DOWN), VXS_OK);
                lie(&part, lies[seed % 4]);
                assert_int_equal(dag_merger_add(&merger, &part, m, square_level(sub), square % side, square / side), VXS_OK);
                dag_free(&part);
            }
            assert_int_equal(dag_merger_finish(&merger, &d), VXS_OK);
            dag_merger_free(&merger);

            assert_int_equal(d.root_count, MAPS);
            uint64_t nodes = 0;
            for (uint32_t m = 0; m < MAPS; m++) {
                dag one  = map_of(&d, m);
                alone[m] = merge(&maps[m], sub, ways[seed % 4], 1, 1, 0, lies[0]);
                assert_true(d.roots[m] >= REF_FIRST);
                if (left_out && m == 3) {
                    for (uint32_t k = 0; k < SIDE * SIDE * SIDE; k++)
                        assert_int_equal(voxel(&one, k % SIDE, k / SIDE % SIDE, k / SIDE / SIDE), 0);
                } else {
                    assert_exact(&one, &maps[m], 0, 0);
                    assert_same_voxels(&one, &alone[m], SIDE, SIDE);
                }
                nodes += dag_node_count(&alone[m]);
            }
            if (unify) {
                census least = take_census(&d);
                assert_int_equal(d.mask_count, least.count[0]);
                for (uint32_t l = 0; l + 1 < d.level_count; l++) assert_int_equal(d.level[l].count, least.count[1 + l]);
                assert_in_range(d.level[d.level_count - 1].count, least.count[d.level_count],
                                MAPS); /* a root each where all is lit */
                assert_true(left_out || dag_node_count(&d) <= nodes);
            }
            if (unify && same && !left_out) {
                for (uint32_t m = 0; m < MAPS; m++) assert_int_equal(d.roots[m], d.roots[0]);
                assert_int_equal(dag_node_count(&d), dag_node_count(&alone[0]));
                assert_int_equal(d.mask_count, alone[0].mask_count);
            }
            dag_free(&d);
            for (uint32_t m = 0; m < MAPS; m++) {
                dag_free(&alone[m]);
                depth_maps_free(&maps[m]);
            }
        }
}

static void side_by_side_is_exact(void **state)
{
    (void)state;
    for (map_kind kind = 0; kind < MAP_KINDS; kind++)
        for (int compress = 0; compress < 2; compress++) {
            depth_maps maps;
            make_maps(&maps, 64, 64, kind, 21);
            dag merged = merge(&maps, 16, ways[0], compress, 0, 0, lies[0]);
            dag once   = merge(&maps, 16, ways[0], compress, 1, 0, lies[0]);
            assert_exact(&merged, &maps, 0, 0);
            assert_same_voxels(&merged, &once, 64, 64);
            assert_true(dag_node_count(&merged) >= dag_node_count(&once));
            dag_free(&merged);
            dag_free(&once);
            depth_maps_free(&maps);
        }
}

/* Squares that were never added are lit, none at all too. */
static void missing_squares_are_lit(void **state)
{
    (void)state;
    depth_maps maps;
    make_maps(&maps, 16, 64, MAPS_BOXES, 2); /* the square (1, 2) of a map of 4 x 4 */
    for (int added = 0; added < 2; added++) {
        dag_merger merger;
        dag        d;
        assert_int_equal(dag_merger_init(&merger, 64, 1, 1), VXS_OK);
        if (added) {
            dag s = insert(&maps, 16, 0, 0, ways[0]);
            assert_int_equal(dag_merger_add(&merger, &s, 0, square_level(16), 1, 2), VXS_OK);
            dag_free(&s);
        }
        assert_int_equal(dag_merger_finish(&merger, &d), VXS_OK);
        dag_merger_free(&merger);
        assert_true(d.roots[0] >= REF_FIRST);
        for (uint32_t k = 0; k < 64; k++)
            for (uint32_t j = 0; j < 64; j++)
                for (uint32_t i = 0; i < 64; i++) {
                    int there = added && i / 16 == 1 && j / 16 == 2;
                    int want  = there ? wanted(&maps, i - 16, j - 32, k) : 0;
                    if (want >= 0) assert_int_equal(voxel(&d, i, j, k), want);
                }
        dag_free(&d);
    }
    depth_maps_free(&maps);
    dag_merger nothing = {0};
    dag_merger_free(&nothing);
}

/* --- the same bytes at any thread count
 * -------------------------------------------------------------------------------------- */

static char folder[64];

static const char *in_folder(const char *name)
{
    static char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static int make_city(void **state)
{
    city_options o = {.blocks = 4, .triangles = 3000, .seed = 3, .sun = {-0.5, -1, -0.3}};
    glb_scene    s;
    output_file  out = {0};
    run_context  m   = {0};
    (void)state;
    strcpy(folder, "/tmp/test_dag-XXXXXX");
    if (!mkdtemp(folder)) return -1;
    int ok = generate_city(&s, &o, &m) == VXS_OK && output_file_open(&out, in_folder("city.glb"), &m) == VXS_OK &&
             glb_write(&s, &out, &m) == VXS_OK && output_file_commit(&out, &m) == VXS_OK;
    glb_scene_free(&s);
    return ok ? 0 : -1;
}

static int remove_city(void **state)
{
    (void)state;
    unlink(in_folder("city.glb"));
    unlink(in_folder("city.vxs"));
    return rmdir(folder);
}

static vxs_bytes bake_city(bake_options o)
{
    bake_report report = {0};
    run_context m      = {0};
    vxs_bytes   file   = {0};
    char        scene_path[128], output_path[128];
    strcpy(scene_path, in_folder("city.glb"));
    strcpy(output_path, in_folder("city.vxs"));
    o.scene_path  = scene_path;
    o.output_path = output_path;
    assert_int_equal(bake(&o, NULL, &report, &m), VXS_OK);
    bake_report_free(&report);

    FILE *f = fopen(output_path, "rb");
    assert_non_null(f);
    fseek(f, 0, SEEK_END);
    file.size_bytes = (size_t)ftell(f);
    rewind(f);
    file.data = malloc(file.size_bytes);
    assert_non_null(file.data);
    assert_int_equal(fread(file.data, 1, file.size_bytes, f), file.size_bytes);
    fclose(f);
    return file;
}

static void same_bytes_at_any_thread_count(void **state)
{
    static const uint32_t threads[] = {2, 3, 8};
    (void)state;
    for (stop_stage stop = STOP_INSERT; stop <= STOP_FINAL; stop++)
        for (compress_choice order = COMPRESS_CHOICE_AUTO; order <= COMPRESS_CHOICE_BOTTOM_UP; order++) {
            bake_options o     = {.renderer   = &opengl_renderer,
                                  .resolution = 1024,
                                  .reuse      = 1,
                                  .stop       = stop,
                                  .compress   = order,
                                  .zstd_level = 3,
                                  .threads    = 1};
            vxs_bytes    alone = bake_city(o);
            for (uint32_t n = 0; n < 3; n += repeats(2, 1)) {
                o.threads      = threads[n];
                vxs_bytes many = bake_city(o);
                assert_int_equal(many.size_bytes, alone.size_bytes);
                assert_memory_equal(many.data, alone.data, alone.size_bytes);
                free(many.data);
            }
            free(alone.data);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_voxel_of_random_fields),
        cmocka_unit_test(every_voxel_of_larger_fields),
        cmocka_unit_test(slabs_of_a_deep_map),
        cmocka_unit_test(reuse_changes_no_voxel),
        cmocka_unit_test(loose_bounds_are_right),
        cmocka_unit_test(lying_hashes_do_not_matter),
        cmocka_unit_test(random_graphs_with_lying_hashes),
        cmocka_unit_test(masks_whose_hashes_meet),
        cmocka_unit_test(equal_subtrees_are_kept_once),
        cmocka_unit_test(merging_is_building_at_once),
        cmocka_unit_test(six_maps_share_one_dag),
        cmocka_unit_test(side_by_side_is_exact),
        cmocka_unit_test(missing_squares_are_lit),
        cmocka_unit_test_setup_teardown(same_bytes_at_any_thread_count, make_city, remove_city),
    };
    return cmocka_run_group_tests_name("dag", tests, NULL, NULL);
}
