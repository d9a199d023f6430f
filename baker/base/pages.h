/* Large arrays on huge pages: the first use of a map of 64 MiB causes 32 page faults instead of 16384.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PAGES_H
#define PAGES_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Uninitialized memory, released with free(). NULL without memory. */
void *pages_alloc(size_t size_bytes);

#ifdef __cplusplus
}
#endif
#endif
