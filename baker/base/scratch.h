/* Arrays that live equally long: they are taken one by one, and released together.
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
    struct scratch_block *last;    /* of a list; owned */
    int                   missing; /* 1: there was no memory for some array */
} scratch;

/* A zeroed array; NULL without memory. There may be no items. */
void *scratch_take(scratch *s, size_t count, size_t item_bytes);

/* Release all arrays. Accepts a zeroed object, and leaves one. */
void scratch_free(scratch *s);

#endif
