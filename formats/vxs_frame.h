/* What a frame of a file is (formats/vxs.md section 2). Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_FRAME_H
#define VXS_FRAME_H

#include <zstd.h>

#include "vxs_bytes.h"

/* Whether bytes are exactly one frame that says that it holds so many, as far as that is seen without inflating it. */
static inline int vxs_is_frame(const uint8_t *bytes, uint64_t size_bytes, uint64_t inflated_bytes)
{
    /* the magic number first: zstd would also take frames that it skips, and those of its own past */
    return size_bytes >= 4 && vxs_load32(bytes) == ZSTD_MAGICNUMBER &&
           ZSTD_getFrameContentSize(bytes, size_bytes) == inflated_bytes &&
           ZSTD_findFrameCompressedSize(bytes, size_bytes) == size_bytes;
}

/* Inflate one to exactly so many bytes. 0: it is none. */
static inline int vxs_inflate_frame(void *to, size_t inflated_bytes, const uint8_t *bytes, size_t size_bytes, ZSTD_DCtx *zstd)
{
    return vxs_is_frame(bytes, size_bytes, inflated_bytes) &&
           ZSTD_decompressDCtx(zstd, to, inflated_bytes, bytes, size_bytes) == inflated_bytes;
}

#endif
