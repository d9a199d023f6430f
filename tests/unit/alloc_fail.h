/* An allocator whose n-th allocation fails, and that knows whether everything came back with the size it was taken with.
 * What it gives is never zeroed by chance.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef ALLOC_FAIL_H
#define ALLOC_FAIL_H

#include <stdlib.h>
#include <string.h>

#include "formats/vxs_file.h"

typedef struct alloc_fail {
    uint64_t calls, fail_at; /* counted from 1; 0: never */
    uint64_t live_bytes, peak_bytes;
    uint64_t wrong_sizes;
} alloc_fail;

enum { ALLOC_FAIL_HEAD = 16 };

static inline void *alloc_fail_alloc(size_t size, void *user)
{
    alloc_fail *a = user;
    if (++a->calls == a->fail_at) return NULL;
    char *memory = malloc(ALLOC_FAIL_HEAD + size);
    if (!memory) return NULL;
    memset(memory, 0xa5, ALLOC_FAIL_HEAD + size);
    memcpy(memory, &size, sizeof size);
    a->live_bytes += size;
    if (a->live_bytes > a->peak_bytes) a->peak_bytes = a->live_bytes;
    return memory + ALLOC_FAIL_HEAD;
}

static inline void alloc_fail_free(void *memory, size_t size, void *user)
{
    alloc_fail *a     = user;
    char       *start = (char *)memory - ALLOC_FAIL_HEAD;
    size_t      taken;
    memcpy(&taken, start, sizeof taken);
    if (taken != size) a->wrong_sizes++;
    a->live_bytes -= taken;
    free(start);
}

static inline vxs_allocator alloc_fail_allocator(alloc_fail *a)
{
    return (vxs_allocator){alloc_fail_alloc, alloc_fail_free, a};
}

#endif
