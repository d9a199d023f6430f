/* A square's record in a file, with its key, its size and a checksum.
 *
 *     offset  size  what
 *          0     8  "vxs kept"
 *          8     4  version, 1
 *         12     4  0
 *         16    16  key
 *         32     8  size of the record
 *         40        the record (square_record.h)
 *    end - 8     8  XXH64 of all bytes before
 *
 * All numbers are little-endian. The key depends on the version of vxs: other versions make other keys.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef KEPT_SQUARE_H
#define KEPT_SQUARE_H

#include "baker/columns/columns.h"
#include "formats/vxs_file.h"

enum { KEPT_MAGIC_BYTES = 8, KEPT_HEAD_BYTES = 40, KEPT_TRAILER_BYTES = 8 };

/* Append a record. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result kept_square_write(const column_key *key, const vxs_bytes *record, vxs_bytes *out);

/* Whether bytes begin like a record in a file, of any square and version.   head  [KEPT_MAGIC_BYTES] */
int kept_square_begins(const uint8_t *head);

/* Whether a file may hold this square, by its first bytes and its size.   head  [KEPT_HEAD_BYTES] */
int kept_square_may_be(const uint8_t *head, uint64_t file_bytes, const column_key *key);

/* Check the bytes, and reduce them to the record that they contain.
 * Returns VXS_OK; VXS_E_CORRUPT: another square's record, or none. */
vxs_result kept_square_read(vxs_bytes *bytes, const column_key *key);

/* Hash of some bytes and of a hash before: makes keys step by step. */
column_key column_key_with(column_key before, const void *bytes, size_t size_bytes);

#endif
