/* Output files that appear complete or not at all.
 *
 * Data goes to an unnamed file (O_TMPFILE) in the folder of the output. The system deletes it if the process ends early. The commit
 * names it ".vxs-PID-N.tmp" and renames it over the old file; POSIX makes this atomic. A kill between the two steps leaves a
 * complete file with the temporary name, which is harmless and can be deleted. On file systems without unnamed files (NFS) the file
 * has the temporary name from the start, and a kill leaves it behind. A reader never sees a partial file, and a failed run leaves
 * the old file unchanged:
 *
 *     output_file out = {0};
 *     if ((r = output_file_open(&out, path, m)) != VXS_OK) goto done;
 *     if ((r = output_file_write(&out, bytes, size_bytes, m)) != VXS_OK) goto done;
 *     r = output_file_commit(&out, m);
 * done:
 *     output_file_abort(&out);      // does nothing after a commit, or when nothing was opened
 *
 * Two kinds of path are written directly, because a rename cannot replace them: "-" (standard output), and existing objects that
 * are neither a regular file nor a folder (a device, a pipe). Data written there cannot be taken back. A symbolic link is followed:
 * its target is replaced and the link stays. A link without a target is an error. The new file gets the attributes of the file it
 * replaces, or the replacement fails (replaced_file.h).
 *
 * Durability: the data is on the disk before the rename, and the new name is on the disk before output_file_commit returns. So
 * outputs that a run has reported survive a power cut.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef OUTPUT_FILE_H
#define OUTPUT_FILE_H

#include <stddef.h>
#include <stdio.h>

#include "baker/base/run_context.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct output_file {
    FILE  *stream;    /* NULL when not open. May also be written with stdio; output_file_commit checks its error flag */
    char  *name;      /* name in messages: the path as given, or "standard output"; owned */
    char  *target;    /* final path, with links resolved; NULL when written directly; owned */
    char  *temporary; /* current name of the file; NULL while it is unnamed, or when written directly; owned */
    char  *memory;    /* with m->access: the bytes until now, which the stream owns until it is closed */
    size_t memory_bytes;
    struct temporary_files *remembered; /* files that a signal handler removes; NULL: none */
    int                     pending;    /* slot in `remembered`; 0: none */
    int unsynced; /* may be set to 1 after opening: skip the flush to the disk (a hundred times faster). The file is still complete
                     or absent after any end of the process, but not after a power cut. For files that are checked when read and can
                     be made again */
} output_file;

/* Start to write `path`. With m->access (file_access.h) the bytes are held in memory, and output_file_commit writes them. A new
 * file has the permissions 0666 & ~umask.
 * f  [out] zeroed on failure; otherwise end with output_file_commit or output_file_abort.
 * Returns VXS_OK; VXS_E_ARGUMENT when this run reads the file (run_files.h); VXS_E_WRITE when the path is empty, a folder or a link
 * without a target, when no file can be created in the folder, or when the existing file must not be replaced; VXS_E_STRICT;
 * VXS_E_MEMORY. On failure m has the reason. */
vxs_result output_file_open(output_file *f, const char *path, run_context *m);

/* The same for a file in an output folder of the run (run_files_add_folder).
 * option  that gives the folder, for messages: "--passes"
 * Also returns VXS_E_ARGUMENT when the file is an output of another option, and VXS_E_WRITE when its path is too long. */
vxs_result output_file_open_in_folder(output_file *f, const char *option, const char *folder, const char *name, run_context *m);

/* Check before long work that the file can be written. Same as output_file_open followed by output_file_abort, but does not open
 * devices or pipes. */
vxs_result output_file_check(const char *path, run_context *m);

/* Append size_bytes bytes (0 is allowed). Buffered: a full disk may be detected only in output_file_commit.
 * Returns VXS_OK or VXS_E_WRITE. After a failure call output_file_abort. */
vxs_result output_file_write(output_file *f, const void *bytes, size_t size_bytes, run_context *m);

/* Flush the buffer to the disk, close the file, and give it its final name. In all cases f is released and zeroed.
 * Returns VXS_OK; VXS_E_WRITE: the old file is unchanged, unless only the last step failed (flushing the name to the disk);
 * VXS_E_STRICT when a warning has become an error: the temporary file is removed and the old file is unchanged. */
vxs_result output_file_commit(output_file *f, run_context *m);

/* Close and remove the temporary file. Accepts a zeroed object, so that one exit path serves all cases. */
void output_file_abort(output_file *f);

#ifdef __cplusplus
}
#endif
#endif
