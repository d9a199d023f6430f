/* A folder for files that nobody needs in the end; see work_folder.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bench/work_folder.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char *path_in(const char *folder, const char *name)
{
    char *path;
    return asprintf(&path, "%s/%s", folder, name) < 0 ? NULL : path;
}

vxs_result work_folder_make(work_folder *f, message *m)
{
    const char *parent = getenv("TMPDIR");
    if (!parent || !parent[0]) parent = "/tmp";
    *f         = (work_folder){.folder = path_in(parent, "vxs-bench-XXXXXX")};
    int failed = f->folder && !mkdtemp(f->folder) ? errno : 0;
    if (failed) {
        free(f->folder);
        f->folder = NULL;
        return fail(m, VXS_E_WRITE, "cannot make a folder for temporary files in %s: %s", parent, strerror(failed));
    }
    if (f->folder) {
        f->asset  = path_in(f->folder, "asset.vxs");
        f->report = path_in(f->folder, "report.json");
        f->errors = path_in(f->folder, "errors.txt");
    }
    return f->asset && f->report && f->errors ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory");
}

void work_folder_remove(work_folder *f)
{
    DIR *folder = f->folder ? opendir(f->folder) : NULL;
    if (folder) {
        for (struct dirent *entry; (entry = readdir(folder));) unlinkat(dirfd(folder), entry->d_name, 0);
        closedir(folder);
        rmdir(f->folder);
    }
    free(f->folder);
    free(f->asset);
    free(f->report);
    free(f->errors);
    *f = (work_folder){0};
}
