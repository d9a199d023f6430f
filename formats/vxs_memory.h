/* Defaults of vxs_read_desc for memory. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_MEMORY_H
#define VXS_MEMORY_H

#include <stdlib.h>

#include "vxs_desc.h"
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

/* desc  zeroed;   given  the caller's, or NULL */
static inline vxs_result vxs_read_desc_take(vxs_read_desc *desc, const vxs_read_desc *given)
{
    return vxs_desc_take(desc, sizeof *desc, offsetof(vxs_read_desc, parallel) + sizeof desc->parallel, given);
}

static inline vxs_allocator vxs_allocator_of(const vxs_read_desc *desc)
{
    const vxs_allocator standard = {vxs_default_alloc, vxs_default_free, NULL};
    return desc->allocator && desc->allocator->alloc && desc->allocator->free ? *desc->allocator : standard;
}

/* Memory limit for a file. Default: 256 times the file size, but at least 64 MiB. Real files need 6 to 9 times their size,
 * including all working memory. */
static inline uint64_t vxs_memory_limit_of(const vxs_read_desc *desc, uint64_t file_bytes)
{
    const uint64_t least = (uint64_t)64 << 20, times = 256;
    if (desc->memory_limit_bytes) return desc->memory_limit_bytes;
    if (file_bytes > UINT64_MAX / times) return UINT64_MAX;
    return file_bytes * times > least ? file_bytes * times : least;
}

#endif
