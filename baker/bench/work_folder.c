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

vxs_result work_folder_make(char **path, message *m)
{
    const char *parent = getenv("TMPDIR");
    if (!parent || !parent[0]) parent = "/tmp";
    *path = work_folder_file(parent, "vxs-bench-XXXXXX");
    if (!*path) return fail(m, VXS_E_MEMORY, "out of memory");
    if (mkdtemp(*path)) return VXS_OK;
    free(*path);
    *path = NULL;
    return fail(m, VXS_E_WRITE, "cannot make a folder for temporary files in %s: %s", parent, strerror(errno));
}

char *work_folder_file(const char *path, const char *name)
{
    char *file;
    return asprintf(&file, "%s/%s", path, name) < 0 ? NULL : file;
}

void work_folder_remove(char *path)
{
    DIR *folder = path ? opendir(path) : NULL;
    if (folder) {
        for (struct dirent *entry; (entry = readdir(folder));) unlinkat(dirfd(folder), entry->d_name, 0);
        closedir(folder);
        rmdir(path);
    }
    free(path);
}
