/* A part of a bake: the squares that one of several runs has made, in a file of its own (vxs bake --part I/N, vxs merge).
 *
 *     offset  size  what
 *          0     8  "vxs bake"
 *          8     4  version, 1
 *         12     4  number of the part, [1, parts]
 *         16     4  parts
 *         20     4  0
 *         24        squares, each as kept_square.h has them, in the order of their numbers
 *                   what is common to all parts, as bytes that the bake knows (part_common.h)
 *                   of each square: number, where it begins, size, each 8 bytes
 *    end - 40     8  where what is common begins
 *    end - 32     8  its size
 *    end - 24     8  squares
 *    end - 16     8  XXH64 of the head, and of all that is behind the squares before this number
 *    end -  8     8  "vxs part"
 *
 * All numbers are little-endian. It is written from its begin to its end, and so can be a pipe; parts are those of one version of vxs, and
 * no public format.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PART_FILE_H
#define PART_FILE_H

#include "baker/columns/columns.h"
#include "baker/files/output_file.h"
#include "formats/vxs_file.h"

#define PART_MAGIC "vxs bake"
enum { PARTS_MAX = 65536 };

/* Where a square lies. */
typedef struct part_square {
    uint64_t number; /* over all lights and maps, in the order of their descents */
    uint64_t at, size_bytes;
} part_square;

typedef struct part_squares {
    part_square *items; /* [count] by number */
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
vxs_result part_begin(part_writer *w, const char *path, uint32_t number, uint32_t parts, message *m);

/* Whether a square is this part's: every so many are, because squares that lie beside each other take about the same time. */
static inline int part_has(const part_writer *w, uint64_t square)
{
    return square % w->parts == w->number - 1;
}

/* Write the next square that is this part's. */
vxs_result part_add(part_writer *w, uint64_t square, const column_key *key, const vxs_bytes *record, message *m);

/* Write what is common to all parts, and commit. */
vxs_result part_end(part_writer *w, const vxs_bytes *common, message *m);

/* Accepts a zeroed object, and one that was ended. */
void part_abort(part_writer *w);

/* reading --------------------------------------------------------------------------------------------------------------------- */

typedef struct part_reader {
    const char  *path;
    int          file;  /* -1: all of it is in memory */
    vxs_bytes    whole; /* of what is no regular file */
    uint64_t     size_bytes;
    uint32_t     number, parts;
    vxs_bytes    common;
    part_squares squares;
} part_reader;

/* Open a part, and check all of it but its squares.
 * p  [out] ends with part_close, whatever is returned
 * Returns VXS_OK; VXS_E_READ; VXS_E_NOT_VXS: it is no part; VXS_E_VERSION; VXS_E_TRUNCATED, VXS_E_CORRUPT: it is damaged; VXS_E_MEMORY. One line
 * in m says so. */
vxs_result part_open(part_reader *p, const char *path, message *m);

/* The square of a number. NULL: it is not here. */
const part_square *part_find(const part_reader *p, uint64_t number);

/* Read a square.   record  [out] released with free(record->data)
 * Returns VXS_OK, VXS_E_READ, VXS_E_CORRUPT, VXS_E_MEMORY; one line in m says so. */
vxs_result part_read(const part_reader *p, const part_square *s, const column_key *key, vxs_bytes *record, message *m);

void part_close(part_reader *p);

#endif
