/* Large arrays on large pages: a map of 64 MiB is touched in 32 steps instead of 16384.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PAGES_H
#define PAGES_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Memory without contents, released with free(); NULL when there is none. */
void *pages_alloc(size_t size_bytes);

#ifdef __cplusplus
}
#endif
#endif
