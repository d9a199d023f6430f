/* What a file that is replaced has, and the new one shall have: a name of its own, leave to be written, owner, permissions, access
 * lists and attributes. They are kept, or the file is left alone; --force (m->force) replaces it all the same, with a warning of what
 * is lost.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef REPLACED_FILE_H
#define REPLACED_FILE_H

#include <sys/stat.h>

#include "baker/base/message.h"

/* May it be replaced? Not one that its owner made read-only, whoever asks, nor one with further names, which would keep the old bytes.
 * old  its status
 * Returns VXS_OK, VXS_E_WRITE, VXS_E_STRICT. */
vxs_result replaced_file_check(const char *path, const struct stat *old, message *m);

/* Give a new file what the old one at `path` has: owner and group, access list, attributes user.*, and permissions. What the system
 * itself gives to files (security.*) is left to it. Permissions are to read, write and execute: set-user-ID, set-group-ID and sticky bits go, as
 * they do when a file is written in place.
 * Returns VXS_OK, VXS_E_WRITE, VXS_E_STRICT. */
vxs_result replaced_file_keep(const char *path, const struct stat *old, int descriptor, message *m);

#endif
