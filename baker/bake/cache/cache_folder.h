/* Square cache in a folder: vxs bake --resume.
 *
 * Each square is a file named by its key (cache_folder.h). The file appears completely or not at all, however the run ends, and
 * never changes. So any number of runs may share a folder: the worst that one run can do is to remove a file that another run would
 * have found. A square is used if its key and checksum are right; otherwise it is made again, and its file is replaced.
 * A folder serves one bake: a run that has written its output removes the squares that it has neither found nor written, unless
 * another run has the folder open.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CACHE_FOLDER_H
#define CACHE_FOLDER_H

#include "baker/base/run_context.h"
#include "baker/columns/columns.h"
#include "baker/columns/square_record.h"
#include "formats/vxs_write_file.h"

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
 * All numbers are little-endian. The key depends on the version of vxs: other versions make other keys. */

enum { SQUARE_FILE_MAGIC_BYTES = 8, SQUARE_FILE_HEAD_BYTES = 40, SQUARE_FILE_TRAILER_BYTES = 8 };

/* Append a record. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result square_file_write(const column_key *key, const vxs_bytes *record, vxs_bytes *out);

/* Check the bytes, and reduce them to the record that they contain.
 * Returns VXS_OK; VXS_E_CORRUPT: another square's record, or none. */
vxs_result square_file_read(vxs_bytes *bytes, const column_key *key);

/* Hash of some bytes and of a hash before: makes keys step by step. */
column_key column_key_with(column_key before, const void *bytes, size_t size_bytes);

/* Shares the squares of one bake among several processes: one process adds all squares and writes the file, the others make squares
 * for it. All processes descend the same maps and give the squares the same numbers (part_file.h). */

typedef struct square_exchange {
    void *data;
    int   adds; /* 1: this process adds the squares */

    /* Claim a square: decide which process makes it. Numbers ascend.
     * action  [out] SQUARE_MAKE: this process. SQUARE_LEAVE, only if it does not add: another process. SQUARE_KNOWN, only if it
     * adds:
     *       another process; `receive` returns the square
     * Returns VXS_OK; VXS_E_MEMORY; VXS_E_BROKEN_PIPE: no more squares are needed; or the error of another process. */
    vxs_result (*claim)(void *data, uint64_t number, square_action *action, run_context *m);

    /* In the process that adds: wait for the record of a square.
     * key     of the square in this process; a different key of the other process is an error
     * record  [out] released with free(record->data)
     * made    [out] 1: it was made in this run
     * Returns VXS_OK, VXS_E_ARGUMENT, or the error of another process. */
    vxs_result (*receive)(void *data, uint64_t number, const column_key *key, vxs_bytes *record, int *made, run_context *m);

    /* In the other processes: hand over the square that was claimed last. Returns VXS_OK or VXS_E_MEMORY. */
    vxs_result (*send)(void *data, uint64_t number, const column_key *key, const vxs_bytes *record, int made, run_context *m);
} square_exchange;

/* Names of the files that are written into the folder and removed from it (run_files_add_folder). */
#define CACHE_FOLDER_NAMES "*.square|.vxs-*.tmp"

typedef struct cache_folder {
    char *folder;
    int   descriptor; /* of the folder; holds a shared lock */

    column_key *used; /* [used_count] squares that were found or written */
    size_t      used_count, used_capacity;
    int         is_full;  /* 1: a write has failed, and no more are tried */
    int         is_sound; /* 0: a damaged square was found, and reported */
    size_t      warnings; /* warnings of the cache: they do not belong to the bake, and are not counted in its file */
} cache_folder;

/* Open a folder; create it if it does not exist.
 * s  [out] zeroed on failure; ends with cache_folder_close
 * Returns VXS_OK; VXS_E_WRITE: not a folder, or cannot be created or read; VXS_E_MEMORY. */
vxs_result cache_folder_open(cache_folder *s, const char *folder, run_context *m);

/* Look up a square. A square that is damaged, or too large for the memory (m->memory_bytes), counts as not found; the first one
 * gives a warning.
 * record  [out] if *found is 1; released with free(record->data)
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_STRICT. */
vxs_result cache_folder_find(cache_folder *s, const column_key *key, vxs_bytes *record, int *found, run_context *m);

/* Write a square. The first failure gives a warning, and the run goes on.
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_STRICT. */
vxs_result cache_folder_store(cache_folder *s, const column_key *key, const vxs_bytes *record, run_context *m);

/* Mark a square as used that another process has found or written. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result cache_folder_use(cache_folder *s, const column_key *key, run_context *m);

/* Remove the squares that this run has not used. Files that are not squares stay, whatever their names. */
void cache_folder_clean(cache_folder *s);

/* Accepts a zeroed object. */
void cache_folder_close(cache_folder *s);

#endif
