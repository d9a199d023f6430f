/* Sets that are joined (union-find): items are numbers, and each set is named by its lowest, whoever joins first.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_JOIN_H
#define MESH_JOIN_H

#include <stdint.h>

/* Several threads may find and join at once. What one reads may be old, but is an ancestor still: only roots are hung onto others, by
 * exchange, and all else is hung higher.
 * parents  parents[i] = i before anything is joined */
static inline uint32_t mesh_find(uint32_t *parents, uint32_t i)
{
    for (;;) {
        uint32_t up = __atomic_load_n(&parents[i], __ATOMIC_RELAXED), top = __atomic_load_n(&parents[up], __ATOMIC_RELAXED);
        if (up == top) return up;
        __atomic_store_n(&parents[i], top, __ATOMIC_RELAXED);
        i = top;
    }
}

/* Once nothing is joined any more: hang an item onto its root. Several threads may do so, each to items of its own. */
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

/* The same with items that may be turned: turned[i] is 1 when i is turned against its parent. */
static inline uint32_t mesh_find_turned(uint32_t *parents, uint8_t *turned, uint32_t i, int *is_turned)
{
    *is_turned = 0;
    while (parents[i] != i) {
        uint32_t up = parents[i];
        if (parents[up] != up) { /* halve the path: i hangs on its grandparent */
            turned[i] ^= turned[up];
            parents[i] = parents[up];
        }
        *is_turned ^= turned[i];
        i = parents[i];
    }
    return i;
}

/* Join a and b, turned against each other or not. Returns 0 when they are joined already, the other way. */
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
