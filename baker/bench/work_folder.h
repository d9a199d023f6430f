/* A folder for files that nobody needs in the end.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef WORK_FOLDER_H
#define WORK_FOLDER_H

#include "baker/base/message.h"

/* Paths; owned. */
typedef struct work_folder {
    char *folder;
    char *asset, *report, *errors; /* what a child writes, and its standard error */
} work_folder;

/* A new folder in $TMPDIR, or /tmp where that is not set.
 * f  [out] ends with work_folder_remove, whatever is returned
 * Returns VXS_OK, VXS_E_WRITE, VXS_E_MEMORY. */
vxs_result work_folder_make(work_folder *f, message *m);

/* Take the folder away with all files in it (there are no folders in it). Accepts a zeroed object. */
void work_folder_remove(work_folder *f);

#endif
