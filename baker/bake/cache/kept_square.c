/* A record in a file; see kept_square.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/cache/kept_square.h"

#define XXH_INLINE_ALL
#include <string.h>
#include <xxhash.h>

#include "baker/base/byte_stream.h"

static const char magic[KEPT_MAGIC_BYTES] = {'v', 'x', 's', ' ', 'k', 'e', 'p', 't'};
enum { KEPT_VERSION = 1 };

vxs_result kept_square_write(const column_key *key, const vxs_bytes *record, vxs_bytes *out)
{
    size_t start = out->size_bytes;
    int    ok    = put_bytes(out, magic, sizeof magic) && put32(out, KEPT_VERSION) && put32(out, 0) && put64(out, key->low) &&
             put64(out, key->high) && put64(out, record->size_bytes) && put_bytes(out, record->data, record->size_bytes);
    return ok && put64(out, XXH64(out->data + start, out->size_bytes - start, 0)) ? VXS_OK : VXS_E_MEMORY;
}

int kept_square_begins(const uint8_t *head)
{
    return !memcmp(head, magic, sizeof magic);
}

int kept_square_may_be(const uint8_t *head, uint64_t file_bytes, const column_key *key)
{
    byte_reader from    = {head + sizeof magic, KEPT_HEAD_BYTES - sizeof magic};
    uint32_t    version = take32(&from), zero = take32(&from);
    int         is_square = take64(&from) == key->low;
    is_square &= take64(&from) == key->high;
    uint64_t size = take64(&from), around = KEPT_HEAD_BYTES + KEPT_TRAILER_BYTES;
    return kept_square_begins(head) && version == KEPT_VERSION && !zero && is_square && file_bytes >= around &&
           size == file_bytes - around;
}

vxs_result kept_square_read(vxs_bytes *bytes, const column_key *key)
{
    if (bytes->size_bytes < KEPT_HEAD_BYTES || !kept_square_may_be(bytes->data, bytes->size_bytes, key)) return VXS_E_CORRUPT;
    size_t hashed = bytes->size_bytes - KEPT_TRAILER_BYTES, size = hashed - KEPT_HEAD_BYTES;
    if (vxs_load64(bytes->data + hashed) != XXH64(bytes->data, hashed, 0)) return VXS_E_CORRUPT;
    memmove(bytes->data, bytes->data + KEPT_HEAD_BYTES, size);
    bytes->size_bytes = size;
    return VXS_OK;
}

column_key column_key_with(column_key before, const void *bytes, size_t size_bytes)
{
    XXH3_state_t state;
    XXH3_128bits_reset(&state);
    XXH3_128bits_update(&state, &before, sizeof before);
    XXH3_128bits_update(&state, bytes, size_bytes);
    XXH128_hash_t hash = XXH3_128bits_digest(&state);
    return (column_key){hash.low64, hash.high64};
}
