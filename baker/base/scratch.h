/* Arrays with the same lifetime: allocated one by one, released together.
 *
 *     scratch   memory = {0};
 *     uint32_t *a      = scratch_take(&memory, count, sizeof *a);
 *     double   *b      = scratch_take(&memory, count, sizeof *b);
 *     if (memory.missing) ...
 *     scratch_free(&memory);
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SCRATCH_H
#define SCRATCH_H

#include <stddef.h>

typedef struct scratch {
    struct scratch_block *last;    /* last block of a linked list; owned */
    int                   missing; /* 1: some allocation failed */
} scratch;

/* A zeroed array; NULL without memory. count may be 0. */
void *scratch_take(scratch *s, size_t count, size_t item_bytes);

/* Release all arrays. Accepts a zeroed object; the object is zeroed afterwards. */
void scratch_free(scratch *s);

#endif
