/* Write little-endian numbers to a growing byte array, and read them from untrusted bytes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BYTE_STREAM_H
#define BYTE_STREAM_H

#include <stdlib.h>

#include "baker/base/array.h"
#include "formats/vxs_bytes.h"
#include "formats/vxs_write_file.h"

/* Append. Each returns 0 without memory. */
static inline int put_bytes(vxs_bytes *out, const void *bytes, size_t size_bytes)
{
    if (!array_reserve(&out->data, &out->capacity_bytes, out->size_bytes + size_bytes, 1)) return 0;
    if (size_bytes) memcpy(out->data + out->size_bytes, bytes, size_bytes);
    out->size_bytes += size_bytes;
    return 1;
}

static inline int put32(vxs_bytes *out, uint32_t value)
{
    uint8_t bytes[4];
    vxs_store32(bytes, value);
    return put_bytes(out, bytes, sizeof bytes);
}

static inline int put64(vxs_bytes *out, uint64_t value)
{
    uint8_t bytes[8];
    vxs_store64(bytes, value);
    return put_bytes(out, bytes, sizeof bytes);
}

static inline int put32s(vxs_bytes *out, const uint32_t *values, size_t count)
{
    int ok = 1;
    for (size_t n = 0; n < count && ok; n++) ok = put32(out, values[n]);
    return ok;
}

typedef struct byte_reader {
    const uint8_t *at;
    size_t         left; /* bytes */
} byte_reader;

/* 1 when `count` items of `bytes` bytes each are left. */
static inline int has(const byte_reader *r, uint64_t count, uint64_t bytes)
{
    return count <= r->left / bytes;
}

/* Read the next bytes. The caller must have checked with has() that they are there. */
static inline const uint8_t *take_bytes(byte_reader *r, size_t size_bytes)
{
    const uint8_t *at = r->at;
    r->at += size_bytes;
    r->left -= size_bytes;
    return at;
}

static inline uint32_t take32(byte_reader *r)
{
    return vxs_load32(take_bytes(r, 4));
}

static inline uint64_t take64(byte_reader *r)
{
    return vxs_load64(take_bytes(r, 8));
}

static inline void take32s(byte_reader *r, uint32_t *values, size_t count)
{
    for (size_t n = 0; n < count; n++) values[n] = take32(r);
}

#endif
