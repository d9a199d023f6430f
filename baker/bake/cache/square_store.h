/* A folder of squares that were made: vxs bake --resume.
 *
 * Each square is a file of its own, named by its key (kept_square.h), which appears whole or not at all, whatever ends the run. Files are
 * never changed. So any number of runs may share a folder: the worst that one can do to another is to take away what that one would have
 * found. What is there is believed when key and checksum are right; else the square is made again, and its file replaced.
 * A folder is for one bake: at the end of a run that has come to its file, what no square of that run was found in or put into is
 * removed, unless another run has the folder open.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SQUARE_STORE_H
#define SQUARE_STORE_H

#include "baker/base/message.h"
#include "baker/columns/columns.h"
#include "formats/vxs_file.h"

/* Names of what is written into the folder, and removed from it (run_files_add_folder). */
#define SQUARE_STORE_NAMES "*.square|.vxs-*.tmp"

typedef struct square_store {
    char *folder;
    int   descriptor; /* of the folder: a lock that is shared */

    column_key *used; /* [used_count] of squares that were found or kept */
    size_t      used_count, used_capacity;
    int         is_full;  /* 1: one could not be kept, and no other is tried */
    int         is_sound; /* 0: one was found that is not what it was, and it was said */
    size_t      warnings; /* that were given here: they are not of the bake, and are not counted in its file */
} square_store;

/* Open a folder, which is made where it is not there.
 * s  [out] zeroed on failure; ends with square_store_close
 * Returns VXS_OK; VXS_E_WRITE: it is no folder, or cannot be made or read; VXS_E_MEMORY. */
vxs_result square_store_open(square_store *s, const char *folder, message *m);

/* Look for a square. One that is damaged, or for which there is no memory (m->memory_bytes), is not found; that is warned of once.
 * record  [out] where *found is 1; released with free(record->data)
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_STRICT. */
vxs_result square_store_find(square_store *s, const column_key *key, vxs_bytes *record, int *found, message *m);

/* Keep a square. Where it cannot be, there is a warning once, and the run goes on.
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_STRICT. */
vxs_result square_store_keep(square_store *s, const column_key *key, const vxs_bytes *record, message *m);

/* A square of this run that another process has found or kept. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result square_store_use(square_store *s, const column_key *key, message *m);

/* Remove what this run has not used. What is no file of a square stays, whatever its name. */
void square_store_clean(square_store *s);

/* Accepts a zeroed object. */
void square_store_close(square_store *s);

#endif
