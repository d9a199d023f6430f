/* Square cache in a folder: vxs bake --resume.
 *
 * Each square is a file named by its key (kept_square.h). The file appears completely or not at all, however the run ends, and
 * never changes. So any number of runs may share a folder: the worst that one run can do is to remove a file that another run would
 * have found. A square is used if its key and checksum are right; otherwise it is made again, and its file is replaced.
 * A folder serves one bake: a run that has written its output removes the squares that it has neither found nor written, unless
 * another run has the folder open.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SQUARE_STORE_H
#define SQUARE_STORE_H

#include "baker/base/message.h"
#include "baker/columns/columns.h"
#include "formats/vxs_file.h"

/* Names of the files that are written into the folder and removed from it (run_files_add_folder). */
#define SQUARE_STORE_NAMES "*.square|.vxs-*.tmp"

typedef struct square_store {
    char *folder;
    int   descriptor; /* of the folder; holds a shared lock */

    column_key *used; /* [used_count] squares that were found or written */
    size_t      used_count, used_capacity;
    int         is_full;  /* 1: a write has failed, and no more are tried */
    int         is_sound; /* 0: a damaged square was found, and reported */
    size_t      warnings; /* warnings of the cache: they do not belong to the bake, and are not counted in its file */
} square_store;

/* Open a folder; create it if it does not exist.
 * s  [out] zeroed on failure; ends with square_store_close
 * Returns VXS_OK; VXS_E_WRITE: not a folder, or cannot be created or read; VXS_E_MEMORY. */
vxs_result square_store_open(square_store *s, const char *folder, message *m);

/* Look up a square. A square that is damaged, or too large for the memory (m->memory_bytes), counts as not found; the first one
 * gives a warning.
 * record  [out] if *found is 1; released with free(record->data)
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_STRICT. */
vxs_result square_store_find(square_store *s, const column_key *key, vxs_bytes *record, int *found, message *m);

/* Write a square. The first failure gives a warning, and the run goes on.
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_STRICT. */
vxs_result square_store_keep(square_store *s, const column_key *key, const vxs_bytes *record, message *m);

/* Mark a square as used that another process has found or written. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result square_store_use(square_store *s, const column_key *key, message *m);

/* Remove the squares that this run has not used. Files that are not squares stay, whatever their names. */
void square_store_clean(square_store *s);

/* Accepts a zeroed object. */
void square_store_close(square_store *s);

#endif
