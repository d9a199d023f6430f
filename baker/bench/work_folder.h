/* A folder for files that nobody needs in the end.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef WORK_FOLDER_H
#define WORK_FOLDER_H

#include "baker/base/message.h"

/* A new folder in $TMPDIR, or /tmp where that is not set.
 * path  [out] NULL on failure; ends with work_folder_remove
 * Returns VXS_OK, VXS_E_WRITE, VXS_E_MEMORY. */
vxs_result work_folder_make(char **path, message *m);

/* "FOLDER/NAME", or NULL without memory; released with free(). */
char *work_folder_file(const char *path, const char *name);

/* Take the folder away with all files in it (there are no folders in it), and release the path. NULL: nothing. */
void work_folder_remove(char *path);

#endif
