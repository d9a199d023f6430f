/* Points, read as lines of text, and answers to them.
 *
 *     x y z                 a point
 *     x y z nx ny nz        a point of a surface, and the surface's normal there
 *     # a comment           skipped, like a blank line
 *
 * World space, metres. The numbers of a line are separated by blanks and tabs, or by commas, or by semicolons. Lines end in LF
 * or CRLF; the last line may have no end. A UTF-8 byte order mark before the first line is skipped.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef POINTS_H
#define POINTS_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "baker/base/run_context.h"

#define POINT_LINE_MAX 4096 /* characters, without the line's end */

typedef struct query_point {
    double position_ws[3]; /* metres, finite */
    double normal_ws[3];   /* unit; 0 0 0 when the line has none */
    int    has_normal;
} query_point;

typedef struct point_reader {
    FILE       *file;              /* borrowed */
    const char *name;              /* for messages: "standard input"; borrowed */
    uint64_t    line;              /* number of the line read last, from 1 */
    char text[POINT_LINE_MAX + 3]; /* the line; with room for a CR, for one character beyond the limit, which shows that the line
                                      is too long, and for a NUL */
} point_reader;

/* Read up to `capacity` points. A smaller count means the end of the file; 0 means that there are no more.
 * reader  its file and name are set, the rest is zero
 * points  [capacity] the first *count are written
 * count   [out] on failure, the points before the bad line
 * Returns VXS_OK, or VXS_E_READ: the file cannot be read, or a line is not a point; m has the line and the reason.
 * Threads: none shared.   Cost: some 0.3 us a point. */
vxs_result points_read(point_reader *reader, query_point *points, size_t capacity, size_t *count, run_context *m);

/* Compute the lit fraction of a point for each light.
 * lit  [out] [light_count] [0, 1]; negative where the point is outside the light's reach
 * Returns 0 on failure, which also ends the following points.
 * Threads: called by several at once. */
typedef int (*point_answer)(void *user, const query_point *point, float *lit);

/* Standard input is used for points: VXS_E_ARGUMENT when an operand, called `name`, is "-" as well. */
vxs_result points_check_input(const char *name, const char *path, run_context *m);

/* Read points from standard input to its end, and print a line for each on standard output, with a column for each light: "0",
 * "1", a number between, or "out". Points are answered in blocks. A block with a bad line, or with a point that `answer` fails
 * on, is not printed.
 * light_count  1 or more
 * Returns VXS_OK, also when `answer` failed on a point (the callback records the error); VXS_E_READ, VXS_E_WRITE, VXS_E_MEMORY,
 * or VXS_E_BROKEN_PIPE: the reader has closed the pipe. */
vxs_result points_answer(point_answer answer, void *user, size_t light_count, uint32_t threads, run_context *m);

#endif
