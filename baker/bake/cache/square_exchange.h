/* Shares the squares of one bake among several processes: one process adds all squares and writes the file, the others make squares
 * for it. All processes descend the same maps and give the squares the same numbers (part_file.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SQUARE_EXCHANGE_H
#define SQUARE_EXCHANGE_H

#include "baker/columns/square_record.h"

typedef struct square_exchange {
    void *data;
    int   adds; /* 1: this process adds the squares */

    /* Ask which process makes a square. Numbers ascend.
     * fate  [out] SQUARE_MAKE: this process. SQUARE_LEAVE, only if it does not add: another process. SQUARE_KNOWN, only if it adds:
     *       another process; `take` returns the square
     * Returns VXS_OK; VXS_E_MEMORY; VXS_E_BROKEN_PIPE: no more squares are needed; or the error of another process. */
    vxs_result (*claim)(void *data, uint64_t number, square_fate *fate, message *m);

    /* In the process that adds: wait for the record of a square.
     * key     of the square in this process; a different key of the other process is an error
     * record  [out] released with free(record->data)
     * made    [out] 1: it was made in this run
     * Returns VXS_OK, VXS_E_ARGUMENT, or the error of another process. */
    vxs_result (*take)(void *data, uint64_t number, const column_key *key, vxs_bytes *record, int *made, message *m);

    /* In the other processes: hand over the square that was claimed last. Returns VXS_OK or VXS_E_MEMORY. */
    vxs_result (*give)(void *data, uint64_t number, const column_key *key, const vxs_bytes *record, int made, message *m);
} square_exchange;

#endif
