/* Interning: equal things are stored once and share a number. Equal hashes are always verified by comparing contents.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef INTERN_H
#define INTERN_H

#include <stddef.h>
#include <stdint.h>

#include "baker/base/ref_table.h"
#include "formats/vxs_result.h"

/* Zero it. */
typedef struct intern {
    uint8_t  *bytes; /* all things, each aligned to 8 bytes */
    size_t   *start; /* [count + 1] byte offset of each thing */
    size_t    count, byte_capacity, start_capacity;
    ref_table table;
} intern;

/* Number of a thing, [0, count): that of an equal thing, or a new one. Returns VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES. */
vxs_result intern_find(intern *t, const void *thing, size_t size_bytes, uint32_t *number);

/* The same in two steps: intern_prefetch requests the memory that intern_find_prefetched reads, so that other work can be done
 * meanwhile.
 * Returns the hash. */
uint64_t   intern_prefetch(const intern *t, const void *thing, size_t size_bytes);
vxs_result intern_find_prefetched(intern *t, uint64_t hash, const void *thing, size_t size_bytes, uint32_t *number);

static inline void *intern_at(const intern *t, uint32_t number)
{
    return t->bytes + t->start[number];
}

/* Size in bytes, rounded up to a multiple of 8. */
static inline size_t intern_size(const intern *t, uint32_t number)
{
    return t->start[number + 1] - t->start[number];
}

void intern_free(intern *t);

#endif
