/* Interning; see intern.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/intern.h"

#include <xxhash.h>

#include "baker/base/array.h"

static size_t aligned(size_t size_bytes)
{
    return (size_bytes + 7) & ~(size_t)7;
}

uint64_t intern_prefetch(const intern *t, const void *thing, size_t size_bytes)
{
    uint64_t hash = XXH64(thing, size_bytes, 0);
    if (t->table.capacity) __builtin_prefetch(&t->table.slots[ref_table_first(&t->table, hash)]);
    return hash;
}

vxs_result intern_find(intern *t, const void *thing, size_t size_bytes, uint32_t *number)
{
    return intern_find_prefetched(t, XXH64(thing, size_bytes, 0), thing, size_bytes, number);
}

vxs_result intern_find_prefetched(intern *t, uint64_t hash, const void *thing, size_t size_bytes, uint32_t *number)
{
    uint64_t at;
    uint32_t ref;
    if (t->count >= UINT32_MAX - 1) return VXS_E_REFERENCES;
    if (!ref_table_reserve(&t->table, 1) || !array_reserve(&t->start, &t->start_capacity, t->count + 2, sizeof *t->start))
        return VXS_E_MEMORY;
    if (!t->count) t->start[0] = 0;
    for (at = ref_table_first(&t->table, hash); (ref = ref_table_match(&t->table, hash, &at)); at = ref_table_next(&t->table, at)) {
        *number = ref - 1;
        if (t->start[ref] - t->start[*number] == aligned(size_bytes) && !memcmp(intern_at(t, *number), thing, size_bytes))
            return VXS_OK;
    }
    size_t end = t->start[t->count] + aligned(size_bytes);
    if (!array_reserve(&t->bytes, &t->byte_capacity, end, 1)) return VXS_E_MEMORY;
    *number = (uint32_t)t->count;
    memset(t->bytes + end - 8, 0, 8);
    memcpy(intern_at(t, *number), thing, size_bytes);
    t->start[++t->count] = end;
    ref_table_put(&t->table, hash, at, *number + 1);
    return VXS_OK;
}

void intern_free(intern *t)
{
    ref_table_free(&t->table);
    free(t->bytes);
    free(t->start);
    memset(t, 0, sizeof *t);
}
