/* Attributes of a replaced file that the new file must keep: a single hard link, write permission, owner, permissions, access lists
 * and extended attributes. If they cannot be kept, the file is not replaced, unless --force (m->force) is set: then a warning lists
 * the loss.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef REPLACED_FILE_H
#define REPLACED_FILE_H

#include <sys/stat.h>

#include "baker/base/run_context.h"

/* Check that the file may be replaced. Refused for a read-only file, whatever user runs the program, and for a file with several
 * hard links, whose other names would keep the old bytes.
 * old  status of the file
 * Returns VXS_OK, VXS_E_WRITE, VXS_E_STRICT. */
vxs_result replaced_file_check(const char *path, const struct stat *old, run_context *m);

/* Copy the attributes of the old file at `path` to a new file: owner and group, access list, attributes user.*, and permissions.
 * Attributes that the system sets itself (security.*) are not copied. Permissions are the read, write and execute bits;
 * set-user-ID, set-group-ID and sticky bits are dropped, as on a write in place.
 * Returns VXS_OK, VXS_E_WRITE, VXS_E_STRICT. */
vxs_result replaced_file_keep(const char *path, const struct stat *old, int descriptor, run_context *m);

#endif
