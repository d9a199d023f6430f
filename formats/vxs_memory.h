/* What a reader's description means where it leaves memory to the library. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_MEMORY_H
#define VXS_MEMORY_H

#include <stdlib.h>

#include "vxs_file.h"

static inline void *vxs_default_alloc(size_t size_bytes, void *user)
{
    (void)user;
    return malloc(size_bytes);
}

static inline void vxs_default_free(void *memory, size_t size_bytes, void *user)
{
    (void)user;
    (void)size_bytes;
    free(memory);
}

/* desc may be NULL, here and below. */
static inline vxs_allocator vxs_allocator_of(const vxs_read_desc *desc)
{
    const vxs_allocator standard = {vxs_default_alloc, vxs_default_free, NULL};
    return desc && desc->allocator && desc->allocator->alloc && desc->allocator->free ? *desc->allocator : standard;
}

static inline uint64_t vxs_memory_limit_of(const vxs_read_desc *desc)
{
    return desc && desc->memory_limit_bytes ? desc->memory_limit_bytes : (uint64_t)4 << 30;
}

#endif
