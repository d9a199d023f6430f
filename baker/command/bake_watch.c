/* Bakes whenever a scene changes; see bake_watch.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/bake_watch.h"

#include <stdlib.h>
#include <string.h>

#include "baker/command/process/watched_files.h"
#include "baker/files/run_files.h"
#include "baker/scene/scene.h"

/* An exporter writes several files, one after the other. */
enum { QUIET_MS = 150, FILES_MAX = 4096 };

typedef struct watched {
    char  *paths[FILES_MAX]; /* [count] owned; the scene's first */
    size_t count;
} watched;

static void watched_free(watched *w)
{
    while (w->count) free(w->paths[--w->count]);
}

static void add_path(void *user, const char *path)
{
    watched *w    = user;
    char    *copy = w->count < FILES_MAX ? strdup(path) : NULL;
    if (copy) w->paths[w->count++] = copy;
}

/* List the scene's file, and those that it names. A file that cannot be read now, half written, names nothing. */
static void list_files(watched *w, const char *scene_path)
{
    run_files   files = {.seen = add_path, .seen_user = w};
    run_context quiet = {.files = &files};
    add_path(w, scene_path);
    scene_check_files_gltf(scene_path, &quiet);
    run_files_free(&files);
    run_free(&quiet);
}

vxs_result bake_watch(const char *scene_path, int (*bake)(void *work), void *work, run_context *m)
{
    for (;;) {
        watched files = {.count = 0};
        list_files(&files, scene_path);
        if (!files.count) return fail(m, VXS_E_MEMORY, "out of memory for the names of watched files");
        int descriptor = watched_files_begin((const char *const *)files.paths, files.count);
        int status     = descriptor < 0 ? -1 : run_apart(bake, work);
        int changed    = status >= 0 && watched_files_wait(descriptor, (const char *const *)files.paths, files.count, QUIET_MS);
        watched_free(&files);
        if (status < 0) return fail(m, VXS_E_UNSUPPORTED, "--watch: the folder of %s cannot be watched here", scene_path);
        if (!changed) return fail(m, VXS_E_READ, "--watch: the folder of %s cannot be read any more", scene_path);
    }
}
