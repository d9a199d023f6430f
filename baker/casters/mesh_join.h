/* Union-find: items are numbers. The name of a set is its lowest item, so it does not depend on the order of joins.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_JOIN_H
#define MESH_JOIN_H

#include <stdint.h>

/* Lock-free: several threads may find and join at once. A value read may be outdated, but it is still an ancestor: only roots get a
 * new parent, by compare-and-exchange; other items only move up to an ancestor.
 * parents  parents[i] = i at first */
static inline uint32_t mesh_find(uint32_t *parents, uint32_t i)
{
    for (;;) {
        uint32_t up = __atomic_load_n(&parents[i], __ATOMIC_RELAXED), top = __atomic_load_n(&parents[up], __ATOMIC_RELAXED);
        if (up == top) return up;
        __atomic_store_n(&parents[i], top, __ATOMIC_RELAXED);
        i = top;
    }
}

/* Call after all joins: attach an item directly to its root. Several threads may do this for different items. */
static inline void mesh_settle(uint32_t *parents, uint32_t item)
{
    uint32_t i = item, up;
    while ((up = __atomic_load_n(&parents[i], __ATOMIC_RELAXED)) != i) i = up;
    __atomic_store_n(&parents[item], i, __ATOMIC_RELAXED);
}

static inline void mesh_join(uint32_t *parents, uint32_t a, uint32_t b)
{
    for (;;) {
        a = mesh_find(parents, a);
        b = mesh_find(parents, b);
        if (a == b) return;
        uint32_t low = a < b ? a : b, high = a < b ? b : a, root = high;
        if (__atomic_compare_exchange_n(&parents[high], &root, low, 0, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) return;
    }
}

/* The same for items with orientation: turned[i] is 1 when i is reversed relative to its parent. */
static inline uint32_t mesh_find_turned(uint32_t *parents, uint8_t *turned, uint32_t i, int *is_turned)
{
    *is_turned = 0;
    while (parents[i] != i) {
        uint32_t up = parents[i];
        if (parents[up] != up) { /* path halving: attach i to its grandparent */
            turned[i] ^= turned[up];
            parents[i] = parents[up];
        }
        *is_turned ^= turned[i];
        i = parents[i];
    }
    return i;
}

/* Join a and b, with `turn` 1 when they are reversed relative to each other. Returns 0 when they are already joined with the
 * opposite orientation. */
static inline int mesh_join_turned(uint32_t *parents, uint8_t *turned, uint32_t a, uint32_t b, int turn)
{
    int      a_turned, b_turned;
    uint32_t p = mesh_find_turned(parents, turned, a, &a_turned), q = mesh_find_turned(parents, turned, b, &b_turned);
    turn ^= a_turned ^ b_turned;
    if (p == q) return !turn;
    uint32_t low = p < q ? p : q, high = p < q ? q : p;
    parents[high] = low;
    turned[high]  = (uint8_t)turn;
    return 1;
}

#endif
