/* Arrays with the same lifetime; see scratch.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/scratch.h"

#include <stdint.h>
#include <stdlib.h>

/* Header of an array: links to the array taken before it. */
struct scratch_block {
    struct scratch_block *before;
    _Alignas(max_align_t) unsigned char items[];
};

void *scratch_take(scratch *s, size_t count, size_t item_bytes)
{
    int                   fits  = count <= (SIZE_MAX - sizeof(struct scratch_block)) / item_bytes;
    struct scratch_block *block = fits ? calloc(1, sizeof *block + count * item_bytes) : NULL;
    s->missing |= !block;
    if (!block) return NULL;
    block->before = s->last;
    s->last       = block;
    return block->items;
}

void scratch_free(scratch *s)
{
    while (s->last) {
        struct scratch_block *before = s->last->before;
        free(s->last);
        s->last = before;
    }
    s->missing = 0;
}
