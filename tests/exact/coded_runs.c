/* The runs of a tile; see coded_runs.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/exact/coded_runs.h"

#include <stdlib.h>

#include "formats/vxs_lookup_blocks.h"

/* DAGs: by their nodes ---------------------------------------------------------------------------------------------------------- */

typedef struct walk {
    const uint32_t *words;
    uint32_t        root, levels;
    uint32_t        x, y; /* of the tile, in tiles of the map */
    coded_run_fn   *found;
    void           *user;
} walk;

static void found_run(const walk *w, uint32_t begin, uint32_t end, uint64_t dark)
{
    int misread = 0;
    for (int last = 0; last < 2; last++) {
        vxs_mask mask = vxs_slice(w->words, w->root, w->levels, w->x, w->y, last ? end - 1 : begin);
        misread |= (mask.low | (uint64_t)mask.high << 32) != dark;
    }
    w->found(w->user, begin, end, dark, misread);
}

/* What child c of a node is (vxs_format.h). */
static uint32_t state_of(const walk *w, uint32_t node, uint32_t c)
{
    return w->words[node] >> 2 * c & 3;
}

/* The eight slices of a slice node, from depth k on. */
static void walk_slices(const walk *w, uint32_t node, uint32_t k)
{
    uint32_t own  = 0;
    uint64_t mask = 0; /* of the last slice that owns one */
    for (uint32_t n = 0; n < 8; n++) {
        uint32_t state = state_of(w, node, n);
        if (state == VXS_CHILD_OWN) {
            uint32_t at = w->words[node + ++own];
            mask        = w->words[at] | (uint64_t)w->words[at + 1] << 32;
        }
        found_run(w, k + n, k + n + 1, state == VXS_CHILD_LIT ? 0 : state == VXS_CHILD_SHADOW ? ~(uint64_t)0 : mask);
    }
}

/* A node of 8 << level voxels a side, from depth k on: its two children along the column, the nearer first. */
static void walk_node(const walk *w, uint32_t node, uint32_t level, uint32_t k)
{
    if (level == 0) {
        walk_slices(w, node, k);
        return;
    }
    uint32_t half = 4u << level;
    uint32_t xy   = (w->x >> (level - 1) & 1) + 2 * (w->y >> (level - 1) & 1);
    for (uint32_t n = 0; n < 2; n++) {
        uint32_t child = state_of(w, node, xy + 4 * n) == VXS_CHILD_SAME ? xy : xy + 4 * n, own = 1;
        uint32_t state = state_of(w, node, child);
        for (uint32_t c = 0; c < child; c++) own += state_of(w, node, c) == VXS_CHILD_OWN;
        if (state == VXS_CHILD_OWN)
            walk_node(w, w->words[node + own], level - 1, k + n * half);
        else
            found_run(w, k + n * half, k + (n + 1) * half, state == VXS_CHILD_SHADOW ? ~(uint64_t)0 : 0);
    }
}

static void dag_runs(const uint32_t *words, const vxs_light *light, uint32_t map, uint32_t x, uint32_t y, coded_run_fn *found,
                     void *user)
{
    uint32_t root = light->flags & VXS_LIGHT_CUBE ? words[map] : 0;
    walk     w    = {words, root, light->levels, x, y, found, user};
    walk_node(&w, root, light->levels - 3, 0);
}

/* palette blocks: by where each texel's shadow begins --------------------------------------------------------------------------- */

typedef struct block_tile_at {
    const uint32_t *words;
    uint32_t        map, levels, x, y;
} block_tile_at;

static uint32_t is_dark(const block_tile_at *t, uint32_t n, uint32_t k)
{
    return vxs_blocks_shadow(t->words, t->map, t->levels, 8 * t->x + n % 8, 8 * t->y + n / 8, k);
}

/* The first voxel in shadow, if all behind it are, and none before. */
static uint32_t first_dark(const block_tile_at *t, uint32_t n)
{
    uint32_t from = 0, to = 1u << t->levels;
    while (from < to) {
        uint32_t middle = (from + to) / 2;
        if (is_dark(t, n, middle))
            to = middle;
        else
            from = middle + 1;
    }
    return from;
}

static int ascending(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

/* What lookups find in slice k. */
static uint64_t slice_of(const block_tile_at *t, uint32_t k)
{
    uint64_t dark = 0;
    for (uint32_t n = 0; n < 64; n++) dark |= (uint64_t)is_dark(t, n, k) << n;
    return dark;
}

static void block_runs(const block_tile_at *t, coded_run_fn *found, void *user)
{
    uint32_t first[64], ends[65], begin = 0;
    for (uint32_t n = 0; n < 64; n++) ends[n] = first[n] = first_dark(t, n);
    ends[64] = 1u << t->levels;
    qsort(ends, 65, sizeof *ends, ascending);
    for (uint32_t run = 0; run < 65; run++) {
        if (ends[run] == begin) continue;
        uint64_t dark = 0;
        for (uint32_t n = 0; n < 64; n++) dark |= (uint64_t)(first[n] <= begin) << n;
        found(user, begin, ends[run], dark, slice_of(t, begin) != dark || slice_of(t, ends[run] - 1) != dark);
        begin = ends[run];
    }
}

void coded_runs(const uint32_t *words, const vxs_light *light, uint32_t map, uint32_t x, uint32_t y, coded_run_fn *found,
                void *user)
{
    if (light->coding == VXS_CODING_BLOCKS)
        block_runs(&(block_tile_at){words, map, light->levels, x, y}, found, user);
    else
        dag_runs(words, light, map, x, y, found, user);
}
