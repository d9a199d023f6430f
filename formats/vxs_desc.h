/* Descriptions that a caller fills, and that grow from version to version: each begins with its struct_size. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_DESC_H
#define VXS_DESC_H

#include <string.h>

#include "vxs_result.h"

/* No description will ever be so large: a size beyond was never set. */
enum { VXS_DESC_BYTES_MAX = 4096 };

/* A caller's description as this library knows it: what a program that was built with older headers does not have is zero, which is every
 * field's default.
 * to     [size] zeroed; its struct_size becomes `size`, unless `from` is NULL
 * first  size that it had when it was released first, which is meant where struct_size is 0
 * from   NULL: all defaults
 * Returns VXS_OK; VXS_E_ARGUMENT for a struct_size below the first, or that nobody set, and for fields this library does not know that are
 * not zero: the program was built with newer headers, and asks for what is not there. */
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
    memcpy(to, &size, sizeof size); /* its own: it may be taken again, and what is behind it in memory is no part of it */
    return VXS_OK;
}

#endif
