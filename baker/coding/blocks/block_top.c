/* The top of palette blocks; see block_layout.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/block_layout.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/z_order.h"

enum { CELL_SIDE = 8, CELL_WORDS = 2 * CELL_SIDE * CELL_SIDE };

/* Entries of all squares of a map, two words each, by rows of squares. */
typedef struct map_entries {
    uint32_t *words;
    uint32_t  side;
} map_entries;

static void put_uniform(const layout *l, map_entries *e, const uniform_square *u)
{
    uint32_t node_level = square_level(NODE_PX), side = u->level > node_level ? 1u << (u->level - node_level) : 1;
    for (uint32_t y = u->y * side; y < (u->y + 1) * side; y++)
        for (uint32_t x = u->x * side; x < (u->x + 1) * side; x++)
            e->words[2 * (y * e->side + x)] = ENTRY_UNIFORM | min_u32(u->depth, l->never);
}

static void put_node(const layout *l, map_entries *e, const node_place *n)
{
    const block_node *from   = &l->set->nodes[n->node];
    uint32_t          coarse = l->levels > 8 ? l->levels - 8 : 0, *entry = e->words + 2 * (from->y * e->side + from->x);
    entry[0] = n->page << 16 | n->word;
    entry[1] = n->base | min_u32(from->emin >> coarse, 255) << 16 | min_u32(from->xmax >> coarse, 255) << 24;
}

/* Allocate the next words of the tops. NULL without memory. */
static uint32_t *more_top(layout *l, size_t count)
{
    if (!array_reserve(&l->top, &l->top_capacity, l->top_count + count, sizeof *l->top)) return NULL;
    l->top_count += count;
    return l->top + l->top_count - count;
}

/* Copy the entries of cell (x, y).   Returns 1 if all of them have the same single depth. */
static int copy_cell(const map_entries *e, z_place cell, uint32_t to[CELL_WORDS])
{
    int alike = 1;
    for (uint32_t row = 0; row < CELL_SIDE; row++)
        memcpy(to + 2 * CELL_SIDE * row, e->words + 2 * ((CELL_SIDE * cell.j + row) * e->side + CELL_SIDE * cell.i),
               2 * CELL_SIDE * sizeof *to);
    for (uint32_t n = 0; n < CELL_WORDS; n += 2) alike &= to[n] == to[0] && to[n] & ENTRY_UNIFORM;
    return alike;
}

/* Write the cells, then, in z order, the entries of cells without a single depth. */
static vxs_result put_cells(layout *l, const map_entries *e)
{
    uint32_t cells = e->side / CELL_SIDE, words[CELL_WORDS];
    size_t   start = l->top_count;
    if (!more_top(l, (size_t)cells * cells)) return VXS_E_MEMORY;
    for (uint32_t n = 0; n < cells * cells; n++) {
        z_place  at   = z_order(n);
        uint32_t word = (uint32_t)(HEAD_WORDS + l->page_count + l->top_count);
        if (copy_cell(e, at, words)) {
            word = words[0];
        } else {
            uint32_t *to = more_top(l, CELL_WORDS);
            if (!to) return VXS_E_MEMORY;
            memcpy(to, words, sizeof words);
        }
        l->top[start + at.j * cells + at.i] = word;
    }
    return VXS_OK;
}

static vxs_result put_map(layout *l, uint32_t map, map_entries *e)
{
    size_t words = 2 * (size_t)e->side * e->side;
    memset(e->words, 0, words * sizeof *e->words);
    for (size_t n = 0; n < l->set->uniform_count; n++)
        if (l->set->uniform[n].map == map) put_uniform(l, e, &l->set->uniform[n]);
    for (size_t n = 0; n < l->set->node_count; n++)
        if (l->set->nodes[l->nodes[n].node].map == map) put_node(l, e, &l->nodes[n]);
    l->top_start[map] = (uint32_t)l->top_count;
    if (l->levels >= CELL_LEVELS) return put_cells(l, e);
    uint32_t *to = more_top(l, words);
    if (!to) return VXS_E_MEMORY;
    memcpy(to, e->words, words * sizeof *to);
    return VXS_OK;
}

vxs_result layout_build_top(layout *l)
{
    uint32_t    side    = l->levels > 8 ? 1u << (l->levels - 8) : 1;
    map_entries entries = {malloc(2 * (size_t)side * side * sizeof *entries.words), side};
    vxs_result  r       = entries.words ? VXS_OK : VXS_E_MEMORY;
    for (uint32_t map = 0; map < l->map_count && r == VXS_OK; map++) r = put_map(l, map, &entries);
    free(entries.words);
    return r;
}
