/* A file that appears complete or not at all.
 *
 * Bytes go to a new file without a name in the folder of the output (O_TMPFILE), so that the system takes it away however this process
 * ends. Commit calls it ".vxs-PID-N.tmp" and renames it over the old file, which POSIX does atomically; a kill between the two leaves
 * a complete file of that name behind, which nothing minds and anyone may delete. Where the file system has no files without names
 * (NFS), it is called so from the start, and a kill leaves it. A reader never sees half a file, and a failed run leaves the old alone:
 *
 *     output_file out = {0};
 *     if ((r = output_file_open(&out, path, m)) != VXS_OK) goto done;
 *     if ((r = output_file_write(&out, bytes, size_bytes, m)) != VXS_OK) goto done;
 *     r = output_file_commit(&out, m);
 * done:
 *     output_file_abort(&out);      // does nothing after a commit, or when nothing was opened
 *
 * Two kinds of path are written directly, because nothing can be renamed over them: "-", which is standard output, and
 * whatever exists and is neither a regular file nor a folder (a device, a pipe). What went there cannot be taken back.
 * A symbolic link is followed: its target is replaced, the link stays. One that leads to no file is an error. What is replaced keeps
 * what it has, or is left alone (replaced_file.h).
 *
 * The bytes are on the disk before the file gets its name, and the name is there before the run goes on: what a run has reported outlives
 * a power cut.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef OUTPUT_FILE_H
#define OUTPUT_FILE_H

#include <stddef.h>
#include <stdio.h>

#include "baker/base/message.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct output_file {
    FILE *stream;    /* NULL when not open. May be written with stdio as well; output_file_commit sees its error flag */
    char *name;      /* how messages call it: the path as given, or "standard output"; owned */
    char *target;    /* where the file goes, links resolved; NULL when written directly; owned */
    char *temporary; /* what the file is called until then; NULL while it has no name, or when written directly; owned */
    struct temporary_files *remembered; /* what a signal removes; NULL: nothing is */
    int                     pending;    /* its slot there; 0: none */
    int unsynced; /* may be set when it is open: 1: whole or not there after any end of the process, but not brought to the disk. For what
                        is checked when it is read, and can be made again after a power cut; a hundredth of the time */
} output_file;

/* Start writing `path`. A new file gets the permissions that umask leaves of 0666.
 * f  [out] zeroed on failure; otherwise ends with output_file_commit or output_file_abort.
 * Returns VXS_OK; VXS_E_ARGUMENT when it is a file that this run reads (run_files.h); VXS_E_WRITE when the path is empty, a folder or a link
 * to nothing, no file can be made beside it, or what is there may not be replaced; VXS_E_STRICT; VXS_E_MEMORY.
 * One line in m says which. */
vxs_result output_file_open(output_file *f, const char *path, message *m);

/* Find out before long work whether a file could be written there: as output_file_open followed by output_file_abort, but never opens
 * a device or a pipe. */
vxs_result output_file_check(const char *path, message *m);

/* Append size_bytes bytes (0 is allowed). Buffered: a full disk may show only in output_file_commit.
 * Returns VXS_OK or VXS_E_WRITE; after a failure only output_file_abort makes sense. */
vxs_result output_file_write(output_file *f, const void *bytes, size_t size_bytes, message *m);

/* Write out what is buffered, to the disk, close, and give the file its name. Either way f is released and zeroed.
 * Returns VXS_OK; VXS_E_WRITE: an older file is as it was, unless the last step failed, which brings the name to the disk; or VXS_E_STRICT when a warning has become an error: then the temporary file is gone and an older file of
 * that name is as it was. */
vxs_result output_file_commit(output_file *f, message *m);

/* Give up: close and remove the temporary file. Accepts a zeroed object, so that one exit serves all. */
void output_file_abort(output_file *f);

#ifdef __cplusplus
}
#endif
#endif
