/* A bake by all ranks of an MPI job, and the messages between them.
 *
 *     to rank 0    CLAIM    empty: the rank wants a square
 *                  SQUARE   square_head; then BYTES: of its record, in as many messages as needed
 *                  END      end_note: the rank makes no more squares, and why
 *     from rank 0  TICKET   the number of a square; NO_MORE: no more squares are needed
 *
 * Numbers have 64 bits. Each rank sends END exactly once, even after a failure, and nothing after it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RANKS_H
#define RANKS_H

#include <stdint.h>

#include "formats/vxs_result.h"

enum { TAG_CLAIM = 1, TAG_SQUARE, TAG_BYTES, TAG_END, TAG_TICKET };
enum { BYTES_AT_ONCE = 1 << 30 };

#define NO_MORE UINT64_MAX

/* [HEAD_NUMBERS] of 64 bits */
enum { HEAD_NUMBER, HEAD_MADE, HEAD_KEY_LOW, HEAD_KEY_HIGH, HEAD_BYTES, HEAD_NUMBERS };

typedef struct end_note {
    int32_t result;      /* vxs_result */
    char    error[1024]; /* one line; "": none */
} end_note;

/* vxs bake on rank 0, and on another rank of `ranks`. Return the exit status. On other ranks it is always 0: rank 0 reports
 * errors. */
int bake_first(int ranks, int argc, char **argv);
int bake_other(int argc, char **argv);

#endif
