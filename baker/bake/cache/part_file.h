/* Shard of a bake: the squares that one of several runs has made, in a file (vxs bake --part I/N, vxs merge).
 *
 *     offset  size  what
 *          0     8  "vxs bake"
 *          8     4  version, 1
 *         12     4  number of the part, [1, parts]
 *         16     4  parts
 *         20     4  0
 *         24        squares as in cache_folder.h, sorted by number
 *                   data common to all parts (bake_squares.h)
 *                   for each square: number, offset, size, 8 bytes each
 *    end - 40     8  offset of the common data
 *    end - 32     8  size of the common data
 *    end - 24     8  number of squares
 *    end - 16     8  XXH64 of the head, and of all bytes between the squares and this number
 *    end -  8     8  "vxs part"
 *
 * All numbers are little-endian. The file is written from begin to end, so it can be a pipe. The format belongs to one version of
 * vxs and is not public.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PART_FILE_H
#define PART_FILE_H

#include "baker/columns/columns.h"
#include "baker/files/output_file.h"
#include "formats/vxs_write_file.h"

#define PART_MAGIC "vxs bake"
enum { PARTS_MAX = 65536 };

/* Position of a square in the file. */
typedef struct part_square {
    uint64_t number; /* over all lights and maps, in the order of their descents */
    uint64_t at, size_bytes;
} part_square;

typedef struct part_squares {
    part_square *items; /* [count] sorted by number */
    size_t       count, capacity;
} part_squares;

/* writing --------------------------------------------------------------------------------------------------------------------- */

typedef struct part_writer {
    output_file  out;
    uint32_t     number, parts; /* number of parts */
    uint64_t     at;            /* bytes written */
    part_squares squares;
} part_writer;

/* Begin a part.   w  [out] ends with part_end or part_abort.   Returns what output_file_open and output_file_write return. */
vxs_result part_begin(part_writer *w, const char *path, uint32_t number, uint32_t parts, run_context *m);

/* Whether a square belongs to this part. Squares are dealt out in turn, because adjacent squares take about the same time. */
static inline int part_has(const part_writer *w, uint64_t square)
{
    return square % w->parts == w->number - 1;
}

/* Write the next square of this part. */
vxs_result part_add(part_writer *w, uint64_t square, const column_key *key, const vxs_bytes *record, run_context *m);

/* Write the common data, and commit. */
vxs_result part_end(part_writer *w, const vxs_bytes *common, run_context *m);

/* Accepts a zeroed object, and one that has ended. */
void part_abort(part_writer *w);

/* reading --------------------------------------------------------------------------------------------------------------------- */

typedef struct part_reader {
    const char  *path;
    int          file;  /* -1: the whole file is in memory */
    vxs_bytes    whole; /* contents of a file that is not regular */
    uint64_t     size_bytes;
    uint32_t     number, parts;
    vxs_bytes    common;
    part_squares squares;
} part_reader;

/* Open a part, and check everything except its squares.
 * p  [out] ends with part_close, whatever is returned
 * Returns VXS_OK; VXS_E_READ; VXS_E_NOT_VXS: not a part; VXS_E_VERSION; VXS_E_TRUNCATED, VXS_E_CORRUPT: damaged; VXS_E_MEMORY. On
 * failure m gets one line. */
vxs_result part_open(part_reader *p, const char *path, run_context *m);

/* Find a square by its number. NULL: the part does not have it. */
const part_square *part_find(const part_reader *p, uint64_t number);

/* Report that a part is damaged.   Returns VXS_E_CORRUPT. */
vxs_result part_is_damaged(const part_reader *p, run_context *m);

/* Read a square.   record  [out] released with free(record->data)
 * Returns VXS_OK, VXS_E_READ, VXS_E_CORRUPT, VXS_E_MEMORY; on failure m gets one line. */
vxs_result part_read(const part_reader *p, const part_square *s, const column_key *key, vxs_bytes *record, run_context *m);

void part_close(part_reader *p);

#endif
