/* Growing arrays; see array.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/array.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST_CAPACITY = 64 };

int array_reserve(void *items, size_t *capacity, size_t needed, size_t item_bytes)
{
    if (needed <= *capacity) return 1;
    size_t room = *capacity > SIZE_MAX / 2 ? SIZE_MAX : *capacity * 2;
    if (room < FIRST_CAPACITY) room = FIRST_CAPACITY;
    if (room < needed) room = needed;
    if (room > SIZE_MAX / item_bytes) room = needed;
    if (room > SIZE_MAX / item_bytes) return 0;

    void *array; /* a copy of the caller's pointer: reading it through another pointer type would break strict aliasing */
    memcpy(&array, items, sizeof array);
    array = realloc(array, room * item_bytes);
    if (!array) return 0;
    memcpy(items, &array, sizeof array);
    *capacity = room;
    return 1;
}
