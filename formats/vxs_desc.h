/* Description structs that the caller fills. They grow from version to version, so each begins with its struct_size. Not
 * installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_DESC_H
#define VXS_DESC_H

#include <string.h>

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

#endif
