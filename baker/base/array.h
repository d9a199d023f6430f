/* Arrays that grow by doubling; every array of unknown length in the baker grows this way.
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
 * items     the address of the pointer to the array, which is NULL while it has no capacity; released with free()
 * capacity  [items] in and out
 * Returns 1; or 0 without memory, or where the size in bytes is beyond SIZE_MAX: the array is then as it was. */
int array_reserve(void *items, size_t *capacity, size_t needed, size_t item_bytes);

#ifdef __cplusplus
}
#endif
#endif
