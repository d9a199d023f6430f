/* Squares of one bake that several processes make together: one of them adds all squares and writes the file, the others make squares for it.
 * All go through the same maps, and number the squares as they come to them (part_file.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SQUARE_EXCHANGE_H
#define SQUARE_EXCHANGE_H

#include "baker/columns/square_keeper.h"

typedef struct square_exchange {
    void *data;
    int   adds; /* 1: this process adds them */

    /* Who sees to a square. Numbers ascend.
     * fate  [out] SQUARE_MAKE: this process. SQUARE_LEAVE, where it does not add: another. SQUARE_KNOWN, where it does: another, and `take` has it
     * Returns VXS_OK; VXS_E_MEMORY; VXS_E_BROKEN_PIPE: nothing is needed any more; what another process failed with. */
    vxs_result (*claim)(void *data, uint64_t number, square_fate *fate, message *m);

    /* Where it adds: the record of a square, when it has come.
     * key     of the square as this process has it: that of another is an error
     * record  [out] released with free(record->data)
     * made    [out] 1: it was made in this run
     * Returns VXS_OK, VXS_E_ARGUMENT, or what another process failed with. */
    vxs_result (*take)(void *data, uint64_t number, const column_key *key, vxs_bytes *record, int *made, message *m);

    /* Where it does not: hand over the square that was claimed last. Returns VXS_OK or VXS_E_MEMORY. */
    vxs_result (*give)(void *data, uint64_t number, const column_key *key, const vxs_bytes *record, int made, message *m);
} square_exchange;

#endif
