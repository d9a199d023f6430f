/* Depths in a DAG; see dag_depths.h.
 * SPDX-License-Identifier: MIT */
#include "dag_depths.h"

#include "vxs_lookup.h"

static uint32_t state_of(uint32_t states, uint32_t c)
{
    return states >> 2 * c & 3;
}

/* Address of own child c of a node. */
static uint32_t child_of(const uint32_t *dag, uint32_t node, uint32_t c)
{
    return dag[node + 1 + vxs_popcount(vxs_own(dag[node]) & ((1u << 2 * c) - 1))];
}

static uint64_t mask_at(const uint32_t *dag, uint32_t at)
{
    return dag[at] | (uint64_t)dag[at + 1] << 32;
}

/* first shadows --------------------------------------------------------------------------------------------------------------- */

/* State of a walk down the columns of a tile. */
typedef struct column_walk {
    const uint32_t *dag;
    uint32_t        tile_x, tile_y;
    uint64_t        wanted; /* texels that have met no shadow yet */
    int32_t        *depth;
} column_walk;

/* Set the depth of wanted texels that are in shadow from k on. */
static void meet(column_walk *w, uint64_t mask, int32_t k)
{
    uint64_t met = mask & w->wanted;
    w->wanted &= ~mask;
    for (int n = 0; met; n++, met >>= 1)
        if (met & 1) w->depth[n] = k;
}

/* Walk a node of side 8 << level at depth k: its two children over the tile, the nearer first. A child that repeats the nearer
 * one adds no shadow and is skipped. */
static void walk_column(column_walk *w, uint32_t node, uint32_t level, int32_t k)
{
    if (level == 0) {
        /* Walk the slices of a node of side 8 at depth k. A slice that repeats the mask of the one before it adds no shadow and
         * is skipped. */
        for (uint32_t slice = 0; slice < 8 && w->wanted; slice++) {
            uint32_t state = state_of(w->dag[node], slice);
            if (state == VXS_CHILD_SHADOW) meet(w, ~(uint64_t)0, k + (int32_t)slice);
            if (state == VXS_CHILD_OWN) meet(w, mask_at(w->dag, child_of(w->dag, node, slice)), k + (int32_t)slice);
        }
        return;
    }
    uint32_t bit = level - 1, xy = (w->tile_x >> bit & 1) | (w->tile_y >> bit & 1) << 1;
    for (uint32_t z = 0; z < 2 && w->wanted; z++) {
        uint32_t c = xy | z << 2, state = state_of(w->dag[node], c);
        int32_t  from = k + (int32_t)(z << (bit + 3));
        if (state == VXS_CHILD_SHADOW) meet(w, ~(uint64_t)0, from);
        if (state == VXS_CHILD_OWN) walk_column(w, child_of(w->dag, node, c), bit, from);
    }
}

void vxs_dag_first_shadows(const vxs_baked_light *baked, uint32_t map, uint32_t tile_x, uint32_t tile_y, uint64_t wanted,
                           int32_t depth[64])
{
    column_walk w = {baked->words, tile_x, tile_y, wanted, depth};
    walk_column(&w, baked->light.flags & VXS_LIGHT_CUBE ? vxs_face_root(baked->words, map) : 0, baked->light.levels - 3, 0);
    meet(&w, ~(uint64_t)0, 1 << baked->light.levels);
}
