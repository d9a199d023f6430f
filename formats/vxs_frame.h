/* zstd frames of a file (formats/vxs.md section 2). Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_FRAME_H
#define VXS_FRAME_H

#include <zstd.h>

#include "vxs_bytes.h"

/* Whether the bytes are exactly one frame whose header has this inflated size. The content is not inflated. */
static inline int vxs_is_frame(const uint8_t *bytes, uint64_t size_bytes, uint64_t inflated_bytes)
{
    /* check the magic number first: zstd would also accept skippable frames and frames of older formats */
    return size_bytes >= 4 && vxs_load32(bytes) == ZSTD_MAGICNUMBER &&
           ZSTD_getFrameContentSize(bytes, size_bytes) == inflated_bytes &&
           ZSTD_findFrameCompressedSize(bytes, size_bytes) == size_bytes;
}

/* Inflate one frame to exactly inflated_bytes. 0: it is not such a frame. */
static inline int vxs_inflate_frame(void *to, size_t inflated_bytes, const uint8_t *bytes, size_t size_bytes, ZSTD_DCtx *zstd)
{
    return vxs_is_frame(bytes, size_bytes, inflated_bytes) &&
           ZSTD_decompressDCtx(zstd, to, inflated_bytes, bytes, size_bytes) == inflated_bytes;
}

#endif
