/* Large arrays on huge pages; see pages.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/pages.h"

#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>

void *pages_alloc(size_t size_bytes)
{
    const size_t page = (size_t)2 << 20;
    if (size_bytes < page) return malloc(size_bytes);
    if (size_bytes > SIZE_MAX - page) return NULL;
    size_t size   = (size_bytes + page - 1) / page * page;
    void  *memory = aligned_alloc(page, size);
    if (memory) madvise(memory, size, MADV_HUGEPAGE); /* only a hint: failure costs time alone */
    return memory;
}
