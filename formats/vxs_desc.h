/* Description structs that the caller fills. They grow from version to version, so each begins with its struct_size. And what
 * vxs_read_desc leaves to the library: memory. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_DESC_H
#define VXS_DESC_H

#include <stdlib.h>
#include <string.h>

#include "vxs_file.h"
#include "vxs_result.h"

/* Largest size of a description. A larger struct_size was not initialized. */
enum { VXS_DESC_BYTES_MAX = 4096 };

/* Copy a caller's description into the struct of this library version. Fields that a program built with older headers does
 * not have become zero, the default of every field.
 * to     [size] zeroed; its struct_size becomes `size`, unless `from` is NULL
 * first  size in the first release; used if struct_size is 0
 * from   NULL: all defaults
 * Returns VXS_OK; VXS_E_ARGUMENT if struct_size is less than `first` or was not initialized, or if fields that this library
 * does not know are not zero: the program was built with newer headers and uses a feature that is missing here. */
static inline vxs_result vxs_desc_take(void *to, size_t size, size_t first, const void *from)
{
    size_t given = 0;
    if (!from) return VXS_OK;
    memcpy(&given, from, sizeof given);
    if (!given) given = first;
    if (given < first || given > VXS_DESC_BYTES_MAX) return VXS_E_ARGUMENT;
    for (size_t n = size; n < given; n++)
        if (((const unsigned char *)from)[n]) return VXS_E_ARGUMENT;
    memcpy(to, from, given < size ? given : size);
    /* the size of this version, so that the copy can be taken again without reading memory behind it */
    memcpy(to, &size, sizeof size);
    return VXS_OK;
}

/* defaults of vxs_read_desc for memory ------------------------------------------------------------------------------------------ */

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
