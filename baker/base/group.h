/* Group items by key: a parallel counting sort.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GROUP_H
#define GROUP_H

#include <stddef.h>
#include <stdint.h>

#include "formats/vxs_result.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Group items by key. Items of one key keep their order.
 * first    [out] [key_count + 1] key k owns members[first[k]] .. members[first[k + 1] - 1]
 * members  [out] [count] item numbers
 * key_of   [count] < key_count; count < 2^32
 * Returns VXS_OK or VXS_E_MEMORY. The result does not depend on the number of threads. */
vxs_result group_by_key(uint32_t *first, uint32_t *members, const uint32_t *key_of, size_t count, size_t key_count,
                        uint32_t threads);

#ifdef __cplusplus
}
#endif
#endif
