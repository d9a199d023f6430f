/* Visibility masks of tiles against the rules as their papers state them, slice by slice, and against the least number that
 * can be (baker/coding/dag/column_tree.h). masks.c is compiled a second time without SIMD: both must give the same runs.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/random.h"
#include "baker/coding/dag/column_tree.h" /* before cmocka, whose fail() is a macro */

#include <cmocka.h>

uint32_t plain_tile_runs(const column_tile *columns, mask_rule rule, mask_run runs[TILE_RUNS_MAX], column_bounds *bounds);

#undef __SSE2__
#define tile_runs plain_tile_runs
#include "baker/coding/dag/masks.c"
#include "tests/unit/repeats.h"
#undef tile_runs

/* tiles that are written down
 * ------------------------------------------------------------------------------------------------- */

enum { TILES = 4 }; /* a side */

/* bounds may be made loose by that many voxels */
typedef struct fixture {
    column_tile tiles[TILES * TILES];
    uint32_t    depth, loose;
} fixture;

static vxs_result fixture_bounds(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *b)
{
    const fixture *f = data;
    *b               = (column_bounds){UINT32_MAX, 0, UINT32_MAX, 0};
    for (uint32_t tile = 0; tile < TILES * TILES; tile++) {
        if ((tile % TILES) >> level != i || (tile / TILES) >> level != j) continue;
        for (int n = 0; n < 64; n++) {
            uint32_t e = f->tiles[tile].e[n], x = f->tiles[tile].x[n];
            b->emin = e < b->emin ? e : b->emin;
            b->emax = e > b->emax ? e : b->emax;
            b->xmin = x < b->xmin ? x : b->xmin;
            b->xmax = x > b->xmax ? x : b->xmax;
        }
    }
    b->emin = b->emin > f->loose ? b->emin - f->loose : 0;
    b->xmin = b->xmin > f->loose ? b->xmin - f->loose : 0;
    b->emax = b->emax + f->loose < f->depth ? b->emax + f->loose : f->depth;
    b->xmax = b->xmax + f->loose < f->depth ? b->xmax + f->loose : f->depth;
    return VXS_OK;
}

static vxs_result fixture_tile(void *data, uint32_t i, uint32_t j, column_tile *out)
{
    *out = ((const fixture *)data)->tiles[j * TILES + i];
    return VXS_OK;
}

static column_square columns_of(fixture *f)
{
    return (column_square){.data = f, .side_px = TILES * 8, .depth_vx = f->depth, .bounds = fixture_bounds, .tile = fixture_tile};
}

/* how a random tile is filled */
typedef enum tile_kind {
    TILE_EMPTY,     /* e = x = depth */
    TILE_DARK,      /* e = x = 0 */
    TILE_NOISE,     /* anything */
    TILE_SHEET,     /* x = e */
    TILE_FEW,       /* four depths, ties everywhere */
    TILE_CLIFF,     /* two groups at either end */
    TILE_AND_EMPTY, /* noise beside texels without a caster */
    TILE_NEAR,      /* all within 16 voxels */
    TILE_FREE,      /* e = 0, x = depth: everything may be anything */
    TILE_KINDS
} tile_kind;

static void fill_tile(column_tile *t, tile_kind kind, uint32_t depth, rng *r)
{
    uint32_t base = rng_below(r, depth > 16 ? depth - 16 : 1);
    for (int n = 0; n < 64; n++) {
        uint32_t e = rng_below(r, depth + 1), x = e + rng_below(r, depth - e + 1);
        switch (kind) {
        case TILE_EMPTY: e = x = depth; break;
        case TILE_DARK: e = x = 0; break;
        case TILE_NOISE: break;
        case TILE_SHEET: x = e; break;
        case TILE_FEW: e = rng_below(r, 4) * (depth / 4), x = e + rng_below(r, 2) * (depth / 4); break;
        case TILE_CLIFF: e = n % 2 ? 0 : depth - rng_below(r, 3), x = n % 2 ? rng_below(r, 3) : depth; break;
        case TILE_AND_EMPTY:
            if (rng_below(r, 2)) e = x = depth;
            break;
        case TILE_NEAR: e = base + rng_below(r, 9), x = e + rng_below(r, 8); break;
        default: e = 0, x = depth; break;
        }
        t->e[n] = e < depth ? e : depth;
        t->x[n] = x < depth ? x : depth;
    }
}

/* the rules, by the book
 * ------------------------------------------------------------------------------------------------------ */

typedef struct run {
    uint64_t mask;
    uint32_t until;
} run;

/* all texels that are beyond their enter depth */
static uint64_t darkest_mask(const column_tile *t, uint32_t k)
{
    uint64_t mask = 0;
    for (int n = 0; n < 64; n++) mask |= (uint64_t)(k >= t->e[n]) << n;
    return mask;
}

static uint32_t nearest_exit(const column_tile *t)
{
    uint32_t least = UINT32_MAX;
    for (int n = 0; n < 64; n++) least = t->x[n] < least ? t->x[n] : least;
    return least;
}

static uint32_t farthest_enter(const column_tile *t)
{
    uint32_t most = 0;
    for (int n = 0; n < 64; n++) most = t->e[n] > most ? t->e[n] : most;
    return most;
}

/* [CPVS16] 3.4: "... this visibility mask can then be re-used for all depths until the closest exit depth of the remaining
 * cells". */
static uint32_t greedy_runs(const column_tile *t, run out[64])
{
    uint32_t count = 0, k = nearest_exit(t), end = farthest_enter(t);
    while (k < end) {
        uint64_t mask  = darkest_mask(t, k);
        uint32_t until = end;
        for (int n = 0; n < 64; n++)
            if (!(mask >> n & 1) && t->x[n] < until) until = t->x[n];
        out[count++] = (run){mask, until};
        k            = until;
    }
    return count;
}

/* [Sintorn 2014], a slice at a time: from the first depth that must not be lit to the last that must not be dark, what may
 * be dark is. Equal neighbours are one run. */
static uint32_t shadow_runs(const column_tile *t, run out[64])
{
    uint32_t count = 0;
    for (uint32_t k = nearest_exit(t); k < farthest_enter(t); k++) {
        uint64_t mask = darkest_mask(t, k);
        if (!count || out[count - 1].mask != mask) out[count++].mask = mask;
        out[count - 1].until = k + 1;
    }
    return count;
}

/* The least number of masks: best[k] for the slices [k, end). One mask serves [a, b) when no texel must be lit at a and dark
 * at b-1. */
static uint32_t least_runs(const column_tile *t)
{
    uint32_t begin = nearest_exit(t), end = farthest_enter(t);
    uint32_t best[257];
    if (begin >= end) return 0;
    best[end - begin] = 0;
    for (uint32_t a = end; a-- > begin;) {
        best[a - begin] = UINT32_MAX;
        for (uint32_t b = a + 1; b <= end; b++) {
            int serves = 1;
            for (int n = 0; n < 64; n++) serves &= !(a < t->e[n] && b - 1 >= t->x[n]);
            if (!serves) break;
            uint32_t with   = best[b - begin] + 1;
            best[a - begin] = with < best[a - begin] ? with : best[a - begin];
        }
    }
    return best[0];
}

/* checks
 * ---------------------------------------------------------------------------------------------------------------------- */

/* A tile's masks, and the depths between which they stand. */
typedef struct tile_masks {
    const mask_run *runs;
    uint32_t        count, xmin, emax;
} tile_masks;

/* What a tree, whose square is `level` and starts at tile (0, 0), knows of a tile. */
static tile_masks masks_of(const column_tree *t, uint32_t x, uint32_t y)
{
    const tree_square *q = &t->squares[0];
    for (uint32_t level = t->level; level > 0 && q->parts != PARTS_UNKNOWN; level--)
        q = &t->squares[q->parts + (x >> (level - 1) & 1) + 2 * (y >> (level - 1) & 1)];
    tile_masks m = {NULL, 0, q->xmin, q->emax};
    for (size_t n = 0; n < t->tile_count; n++)
        if (t->tiles[n].x == x && t->tiles[n].y == y) {
            assert_null(m.runs);
            m.runs  = t->runs + t->tiles[n].first;
            m.count = t->tiles[n].end - t->tiles[n].first;
            assert_true(m.count > 0);
        }
    return m;
}

static void assert_contract(const tile_masks *m, const column_tile *t)
{
    uint32_t k = m->xmin;
    for (uint32_t r = 0; r < m->count; r++) {
        assert_true(m->runs[r].until > k);
        for (int n = 0; n < 64; n++) {
            int dark = m->runs[r].mask >> n & 1;
            assert_false(dark && k < t->e[n]); /* lit voxels end at e: the first of the run is the one to query */
            assert_false(!dark && m->runs[r].until - 1 >= t->x[n]); /* dark ones begin at x: the last */
        }
        k = m->runs[r].until;
    }
    if (m->count) assert_int_equal(k, m->emax);
    if (!m->count) assert_true(m->emax <= m->xmin); /* one depth parts lit from dark */
    for (int n = 0; n < 64; n++) {
        assert_true(m->xmin <= t->x[n]); /* lit before xmin */
        assert_true(m->emax >= t->e[n]); /* dark behind emax */
    }
}

static void assert_runs(const mask_run *found, uint32_t found_count, const run *runs, uint32_t count)
{
    assert_int_equal(found_count, count);
    for (uint32_t n = 0; n < count; n++) {
        assert_true(found[n].mask == runs[n].mask);
        assert_int_equal(found[n].until, runs[n].until);
    }
}

/* One tile, with everything that is known about it. */
static void check_tile(const fixture *f, const column_tile *t, mask_rule rule, const tile_masks *tight, const tile_masks *loose)
{
    run           runs[64];
    mask_run      plain[TILE_RUNS_MAX], fast[TILE_RUNS_MAX];
    column_bounds plain_bounds, bounds;
    uint32_t      count = rule == MASK_RULE_GREEDY ? greedy_runs(t, runs) : shadow_runs(t, runs);
    assert_contract(tight, t);
    assert_contract(loose, t);
    assert_runs(tight->runs, tight->count, runs, count);
    assert_runs(loose->runs, loose->count, runs, count);
    assert_runs(plain, plain_tile_runs(t, rule, plain, &plain_bounds), runs, count);
    assert_runs(fast, tile_runs(t, rule, fast, &bounds), runs, count);
    assert_memory_equal(&plain_bounds, &bounds, sizeof bounds);
    assert_int_equal(bounds.xmin, nearest_exit(t));
    assert_int_equal(bounds.emax, farthest_enter(t));
    if (rule == MASK_RULE_GREEDY && f->depth <= 256) assert_int_equal(count, least_runs(t));
}

enum { WHOLE = 2 }; /* the level of a fixture */

/* Tiles of one kind, or of all kinds mixed. */
static void check_fixture(fixture *f)
{
    column_square s = columns_of(f);
    for (mask_rule rule = MASK_RULE_GREEDY; rule <= MASK_RULE_SHADOW; rule++) {
        column_tree tight, loose;
        f->loose = 0;
        assert_int_equal(column_tree_build(&tight, &s, WHOLE, 0, 0, rule, 0), VXS_OK);
        f->loose = 5;
        assert_int_equal(column_tree_build(&loose, &s, WHOLE, 0, 0, rule, 0), VXS_OK);
        for (uint32_t tile = 0; tile < TILES * TILES; tile++) {
            tile_masks a = masks_of(&tight, tile % TILES, tile / TILES), b = masks_of(&loose, tile % TILES, tile / TILES);
            check_tile(f, &f->tiles[tile], rule, &a, &b);
        }
        column_tree_free(&tight);
        column_tree_free(&loose);
    }
}

static void rules_are_those_of_the_papers(void **state)
{
    static const uint32_t depths[] = {8, 64, 256, 4096};
    (void)state;
    for (int d = 0; d < 4; d++)
        for (uint32_t kind = 0; kind <= TILE_KINDS; kind++)
            for (uint64_t seed = 0; seed < repeats(5, 20); seed++) {
                fixture f = {.depth = depths[d]};
                rng     r = rng_split(seed, kind);
                for (int t = 0; t < TILES * TILES; t++)
                    fill_tile(&f.tiles[t], kind < TILE_KINDS ? kind : (tile_kind)rng_below(&r, TILE_KINDS), f.depth, &r);
                check_fixture(&f);
            }
}

/* 16 bits are not enough for these: both sides of where they end. */
static void cliffs_beyond_16_bits(void **state)
{
    (void)state;
    fixture f = {.depth = 131072};
    rng     r = {9};
    for (uint32_t t = 0; t < TILES * TILES; t++)
        for (int n = 0; n < 64; n++) {
            uint32_t height = 32760 + t + (t > 12 ? 40000 : 0); /* 32760 ... 32775, and more */
            f.tiles[t].x[n] = n == 0 ? 1000 : 1000 + height - rng_below(&r, 3);
            f.tiles[t].e[n] = n == 1 ? 1000 + height : f.tiles[t].x[n] - rng_below(&r, 900);
            if (n == 1) f.tiles[t].x[n] = 1000 + height + rng_below(&r, 30000);
        }
    check_fixture(&f);

    for (int t = 0; t < TILES * TILES; t++) fill_tile(&f.tiles[t], TILE_NOISE, f.depth, &r);
    check_fixture(&f);
    for (int t = 0; t < TILES * TILES; t++) fill_tile(&f.tiles[t], TILE_SHEET, f.depth, &r);
    check_fixture(&f);
}

/* 64 different depths of sheets take 63 masks: the first depth is where the first mask begins. */
static void most_runs_of_a_tile(void **state)
{
    (void)state;
    fixture f = {.depth = 256};
    for (int t = 0; t < TILES * TILES; t++)
        for (uint32_t n = 0; n < 64; n++) f.tiles[t].e[n] = f.tiles[t].x[n] = 3 * ((n * 37 + (uint32_t)t) % 64);
    check_fixture(&f);
    column_square s = columns_of(&f);
    column_tree   t;
    f.loose = 0;
    assert_int_equal(column_tree_build(&t, &s, WHOLE, 0, 0, MASK_RULE_GREEDY, 0), VXS_OK);
    assert_int_equal(t.run_count, TILES * TILES * 63);
    column_tree_free(&t);
}

/* By hand: drawn in masks.c. */
static void an_example(void **state)
{
    (void)state;
    fixture f = {.depth = 64};
    for (int t = 0; t < TILES * TILES; t++)
        for (int n = 0; n < 64; n++) {
            f.tiles[t].e[n] = n == 0 ? 15 : n == 1 ? 18 : 38;
            f.tiles[t].x[n] = n == 0 ? 20 : n == 1 ? 29 : 48;
        }
    column_square s = columns_of(&f);
    for (mask_rule rule = MASK_RULE_GREEDY; rule <= MASK_RULE_SHADOW; rule++) {
        column_tree t;
        assert_int_equal(column_tree_build(&t, &s, 0, 1, 2, rule, 0), VXS_OK);
        assert_int_equal(t.run_count, 1);
        assert_int_equal(t.squares[0].xmin, 20);
        assert_int_equal(t.squares[0].emax, 38);
        assert_int_equal(t.runs[0].mask, 3);
        assert_int_equal(t.runs[0].until, 38);
        column_tree_free(&t);
    }
}

/* A square of a source is what lies there. */
static void squares_of_a_source(void **state)
{
    (void)state;
    fixture f = {.depth = 64};
    rng     r = {4};
    for (int t = 0; t < TILES * TILES; t++) fill_tile(&f.tiles[t], TILE_NOISE, f.depth, &r);
    column_square s = columns_of(&f);
    column_tree   whole, part;
    assert_int_equal(column_tree_build(&whole, &s, WHOLE, 0, 0, MASK_RULE_GREEDY, 0), VXS_OK);
    assert_int_equal(column_tree_build(&part, &s, 1, 1, 1, MASK_RULE_GREEDY, 0), VXS_OK);
    assert_int_equal(part.tile_count, 4);
    for (uint32_t n = 0; n < 4; n++) {
        const tree_tile *t    = &part.tiles[n]; /* in z order, which is the order of rows for four */
        tile_masks       from = masks_of(&whole, 2 + n % 2, 2 + n / 2);
        assert_int_equal(t->x, 2 + n % 2);
        assert_int_equal(t->y, 2 + n / 2);
        assert_int_equal(t->end - t->first, from.count);
        for (uint32_t k = 0; k < from.count; k++) {
            assert_true(part.runs[t->first + k].mask == from.runs[k].mask);
            assert_int_equal(part.runs[t->first + k].until, from.runs[k].until);
        }
        assert_int_equal(part.squares[part.squares[0].parts + n].xmin, from.xmin);
        assert_int_equal(part.squares[part.squares[0].parts + n].emax, from.emax);
    }
    column_tree_free(&whole);
    column_tree_free(&part);
    column_tree_free(&part); /* a zeroed object is accepted */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rules_are_those_of_the_papers), cmocka_unit_test(cliffs_beyond_16_bits),
        cmocka_unit_test(most_runs_of_a_tile),           cmocka_unit_test(an_example),
        cmocka_unit_test(squares_of_a_source),
    };
    return cmocka_run_group_tests_name("masks", tests, NULL, NULL);
}
