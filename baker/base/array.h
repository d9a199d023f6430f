/* Growing arrays: the capacity doubles. All arrays of unknown length in the baker use this.
 *
 *     if (!array_reserve(&l->items, &l->capacity, l->count + 1, sizeof *l->items)) return VXS_E_MEMORY;
 *     l->items[l->count++] = item;
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef ARRAY_H
#define ARRAY_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Make room for `needed` items.
 * items     address of the pointer to the array; the pointer is NULL while the capacity is 0; released with free()
 * capacity  [items] in and out
 * Returns 1; or 0 without memory, or when the size in bytes exceeds SIZE_MAX. On 0 the array is unchanged. */
int array_reserve(void *items, size_t *capacity, size_t needed, size_t item_bytes);

#ifdef __cplusplus
}
#endif
#endif
