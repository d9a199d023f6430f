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

/* From now on every array of a few megabytes goes back to the system when it is freed. Else glibc keeps such arrays once some were freed,
 * and small ones that lie between them hold their memory: a bake of many lights grew with each. */
void pages_return_large(void);

#ifdef __cplusplus
}
#endif
#endif
