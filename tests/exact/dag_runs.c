/* The runs of a tile of a DAG; see dag_runs.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/exact/dag_runs.h"

#include "formats/vxs_lookup.h"

typedef struct walk {
    const uint32_t *words;
    uint32_t        root, levels;
    uint32_t        x, y; /* of the tile, in tiles of the map */
    dag_run_fn     *found;
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

void dag_runs(const uint32_t *words, const vxs_light *light, uint32_t map, uint32_t x, uint32_t y, dag_run_fn *found, void *user)
{
    uint32_t root = light->flags & VXS_LIGHT_CUBE ? words[map] : 0;
    walk     w    = {words, root, light->levels, x, y, found, user};
    walk_node(&w, root, light->levels - 3, 0);
}
