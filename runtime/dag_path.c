/* Walks through a DAG that reuse the last walk; see dag_path.h.
 * SPDX-License-Identifier: MIT */
#include "dag_path.h"

void vxs_dag_path_init(vxs_dag_path *path, const vxs_baked_light *baked, uint32_t map)
{
    path->words  = baked->words;
    path->levels = baked->light.levels;
    path->root   = baked->light.flags & VXS_LIGHT_CUBE ? vxs_face_root(baked->words, map) : 0;
    path->x = path->y = path->z = ~0u; /* no slice has this position, so that the first walk starts at the root */
    path->end                   = path->levels - 3;
    path->state                 = 2;
    path->node[path->end]       = path->root;
}

/* Mask of a slice, as vxs_slice. */
static inline vxs_mask slice(vxs_dag_path *path, uint32_t x, uint32_t y, uint32_t k)
{
    const uint32_t *dag = path->words;
    uint32_t        z = k >> 3, differ = (x ^ path->x) | (y ^ path->y) | (z ^ path->z), level = path->levels - 3;
    while (level > path->end && !(differ >> (level - 1))) level--; /* same child as in the last walk */
    if (level == path->end && path->state < 2 && !(differ >> (level - 1))) return vxs_uniform_mask(path->state);

    uint32_t node = path->node[level], states, state;
    path->x       = x;
    path->y       = y;
    path->z       = z;
    path->state   = 2;
    for (; level > 0; level--) {
        uint32_t bit = level - 1, xy = (x >> bit & 1) | (y >> bit & 1) << 1, c = xy | (z >> bit & 1) << 2;
        path->node[level] = node;
        states            = vxs_word(dag, node);
        state             = states >> 2 * c & 3;
        if (state == VXS_CHILD_SAME) {
            c     = xy;
            state = VXS_CHILD_OWN;
        }
        if (state != VXS_CHILD_OWN) {
            path->end   = level;
            path->state = state;
            return vxs_uniform_mask(state);
        }
        node = vxs_word(dag, node + 1 + vxs_popcount(vxs_own(states) & ((1u << 2 * c) - 1)));
    }

    path->end     = 0;
    path->node[0] = node;
    states        = vxs_word(dag, node);
    state         = states >> 2 * (k & 7) & 3;
    if (state < VXS_CHILD_OWN) return vxs_uniform_mask(state);
    uint32_t at = vxs_word(dag, node + vxs_popcount(vxs_own(states) & ((2u << 2 * (k & 7)) - 1)));
    return (vxs_mask){vxs_word(dag, at), vxs_word(dag, at + 1)};
}

uint32_t vxs_dag_path_shadow(vxs_dag_path *path, uint32_t i, uint32_t j, uint32_t k)
{
    vxs_mask mask = slice(path, i >> 3, j >> 3, k);
    return (j & 4 ? mask.high : mask.low) >> ((i & 7) + 8 * (j & 3)) & 1;
}

uint32_t vxs_dag_path_count(vxs_dag_path *path, int32_t i, int32_t j, uint32_t k, int32_t filter_px)
{
    int32_t  half_px = filter_px / 2, side = 1 << path->levels;
    int32_t  x0 = i < half_px ? 0 : i - half_px, y0 = j < half_px ? 0 : j - half_px;
    int32_t  x1 = i >= side - half_px ? side : i + half_px + 1, y1 = j >= side - half_px ? side : j + half_px + 1;
    uint32_t count = 0;
    for (int32_t y = y0 & ~7; y < y1; y += 8)
        for (int32_t x = x0 & ~7; x < x1; x += 8) {
            vxs_mask mask = slice(path, (uint32_t)x >> 3, (uint32_t)y >> 3, k);
            if (!(mask.low | mask.high)) continue;
            count += vxs_popcount(mask.low & vxs_cover(x0 - x, x1 - x, y0 - y, y1 - y));
            count += vxs_popcount(mask.high & vxs_cover(x0 - x, x1 - x, y0 - y - 4, y1 - y - 4));
        }
    return count;
}

uint32_t vxs_dag_path_weight(vxs_dag_path *path, vxs_smooth_box box, uint32_t k, int32_t width_px)
{
    int32_t  side = 1 << path->levels, x0 = box.x < 0 ? 0 : box.x, y0 = box.y < 0 ? 0 : box.y;
    int32_t  x1 = box.x + width_px + (box.across > 0), y1 = box.y + width_px + (box.down > 0);
    uint32_t sum = 0;
    x1           = x1 < side ? x1 : side;
    y1           = y1 < side ? y1 : side;
    for (int32_t y = y0 & ~7; y < y1; y += 8)
        for (int32_t x = x0 & ~7; x < x1; x += 8) {
            vxs_mask mask = slice(path, (uint32_t)x >> 3, (uint32_t)y >> 3, k);
            if (mask.low | mask.high) sum += vxs_weigh_mask(mask, box, box.x - x, box.y - y, width_px);
        }
    return sum;
}
