/* An inclusive scan by OR along segments of 128-bit texels, in a storage buffer. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef OR_SCAN_H
#define OR_SCAN_H

#include "volumes_state.h"

typedef struct or_scan {
    vxs_volumes *volumes;
    gl_name      other; /* a second buffer for passes; 0: a workgroup for each segment, in shared memory */
} or_scan;

/* size_bytes  of the largest buffer that is scanned in passes, which alternate between two buffers; 0: in one dispatch
 * Returns VXS_OK; VXS_E_MEMORY: then there is nothing to destroy. */
vxs_result vxs_or_scan_create(or_scan *scan, vxs_volumes *volumes, uint64_t size_bytes);
void       vxs_or_scan_destroy(or_scan *scan); /* may be all 0 */

/* Replace each texel by the OR of all texels of its segment up to it. Segments are contiguous.
 * texels    a buffer of uvec4;   first  the first texel of the first segment
 * length    texels in a segment, any number;   segments  length * segments is less than 2^32
 * Cost: a read and a write of each texel; in passes, log2(length) of them. Leaves storage bindings as vxs_volumes_use_storage
 * has them.
 * Source: [VSV11], "VSV Implementation", for a scan by OR; its passes are those of Hillis and Steele. */
void vxs_or_scan_run(const or_scan *scan, gl_name texels, uint32_t first, uint32_t length, uint32_t segments);

#endif
