/* Hash table of references: open addressing, keyed by a 64-bit hash that the owner stores with each referenced thing. The table
 * never decides equality: the owner compares contents.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef REF_TABLE_H
#define REF_TABLE_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/pages.h"

typedef struct ref_slot {
    uint32_t tag; /* high half of the hash: rejects most slots without reading their contents */
    uint32_t ref; /* 0: empty */
} ref_slot;

typedef struct ref_table {
    ref_slot *slots;
    uint64_t  capacity; /* a power of two, at least twice count */
    uint64_t  count;
} ref_table;

static inline void ref_table_free(ref_table *t)
{
    free(t->slots);
    memset(t, 0, sizeof *t);
}

/* Mix the bits of a mask before it is used as a hash: the mask itself is the content. */
static inline uint64_t ref_hash_mask(uint64_t mask)
{
    mask ^= mask >> 32;
    mask *= 0x9e3779b97f4a7c15u;
    mask ^= mask >> 29;
    mask *= 0xbf58476d1ce4e5b9u;
    return mask ^ mask >> 32;
}

/* Make room for `more` references. This also guarantees an empty slot, so that the loops below end. Returns 0 without memory. */
static inline int ref_table_reserve(ref_table *t, uint64_t more)
{
    uint64_t capacity = t->capacity ? t->capacity : 1024;
    while (capacity < 2 * (t->count + more)) capacity *= 2;
    if (capacity == t->capacity) return 1;
    ref_slot *slots = pages_alloc(capacity * sizeof *slots); /* each lookup touches another page */
    if (!slots) return 0;
    memset(slots, 0, capacity * sizeof *slots);
    /* the slot depends on the tag alone, so that the table can grow without its owner */
    for (uint64_t i = 0; i < t->capacity; i++) {
        if (!t->slots[i].ref) continue;
        uint64_t at = t->slots[i].tag & (capacity - 1);
        while (slots[at].ref) at = (at + 1) & (capacity - 1);
        slots[at] = t->slots[i];
    }
    free(t->slots);
    t->slots    = slots;
    t->capacity = capacity;
    return 1;
}

/* Iterate over the references that may have this hash:
 *     for (uint64_t at = ref_table_first(t, h); (ref = ref_table_match(t, h, &at)); at = ref_table_next(t, at))
 *         if (the contents are equal) found;
 *     not found: ref_table_put(t, h, at, new_ref); */
static inline uint64_t ref_table_first(const ref_table *t, uint64_t hash)
{
    return (hash >> 32) & (t->capacity - 1);
}

static inline uint64_t ref_table_next(const ref_table *t, uint64_t at)
{
    return (at + 1) & (t->capacity - 1);
}

static inline uint32_t ref_table_match(const ref_table *t, uint64_t hash, uint64_t *at)
{
    uint32_t tag = (uint32_t)(hash >> 32);
    while (t->slots[*at].ref && t->slots[*at].tag != tag) *at = ref_table_next(t, *at);
    return t->slots[*at].ref;
}

static inline void ref_table_put(ref_table *t, uint64_t hash, uint64_t at, uint32_t ref)
{
    t->slots[at] = (ref_slot){(uint32_t)(hash >> 32), ref};
    t->count++;
}

#endif
