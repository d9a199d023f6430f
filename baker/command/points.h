/* Points to ask about, read as lines of text.
 *
 *     x y z                 a point
 *     x y z nx ny nz        a point of a surface, and the surface's normal there
 *     # a comment           skipped, like a blank line
 *
 * World space, metres; separated by blanks or tabs; lines end in LF or CRLF, the last one may do without.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef POINTS_H
#define POINTS_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "baker/base/message.h"

#define POINT_LINE_MAX 4096 /* characters, without the line's end */

typedef struct query_point {
    double position_ws[3]; /* metres, finite */
    double normal_ws[3];   /* unit; 0 0 0 when the line has none */
    int    has_normal;
} query_point;

/* Reads ahead of the points that it has given out. */
typedef struct point_reader {
    FILE       *file;   /* borrowed */
    const char *name;   /* for messages: "standard input"; borrowed */
    char       *buffer; /* owned */
    size_t      begin;  /* buffer[begin, end) is read and not yet parsed */
    size_t      end;
    int         at_end; /* the file has no more */
    uint64_t    line;   /* number of the line parsed last, from 1 */
} point_reader;

/* Returns VXS_OK or VXS_E_MEMORY; released with point_reader_free either way. */
vxs_result point_reader_init(point_reader *reader, FILE *file, const char *name, message *m);

/* Accepts a zeroed object. Leaves the file open. */
void point_reader_free(point_reader *reader);

/* Read up to `capacity` points: fewer only at the end of the file, so that 0 means that there are no more.
 * points  [capacity] the first *count are written
 * count   [out] on failure, the points before the bad line
 * Returns VXS_OK, or VXS_E_READ: the file cannot be read, or a line is no point; m says which and why.
 * Threads: none shared.   Cost: some 0.3 us a point. */
vxs_result points_read(point_reader *reader, query_point *points, size_t capacity, size_t *count, message *m);

#endif
