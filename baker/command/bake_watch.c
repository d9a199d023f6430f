/* Bakes whenever a scene changes; see bake_watch.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/bake_watch.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/command/process/watched_files.h"
#include "baker/files/json_file.h"

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

static int hex_digit(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : (c | 32) >= 'a' && (c | 32) <= 'f' ? (c | 32) - 'a' + 10 : -1;
}

/* Add a file that the scene names by a URI, relative to the scene's folder; data in the URI itself is none. */
static void add_uri(watched *w, const char *scene_path, const char *uri)
{
    const char *slash  = strrchr(scene_path, '/');
    size_t      folder = slash ? (size_t)(slash + 1 - scene_path) : 0, at = folder;
    char       *path = w->count < FILES_MAX && strncmp(uri, "data:", 5) ? malloc(folder + strlen(uri) + 1) : NULL;
    if (!path) return;
    memcpy(path, scene_path, folder);
    for (const char *c = uri; *c; c++) {
        int is_escaped = *c == '%' && hex_digit(c[1]) >= 0 && hex_digit(c[2]) >= 0;
        path[at++]     = is_escaped ? (char)(16 * hex_digit(c[1]) + hex_digit(c[2])) : *c;
        c += is_escaped ? 2 : 0;
    }
    path[at]             = '\0';
    w->paths[w->count++] = path;
}

/* List the scene's file, and what a .gltf names. A file that cannot be read now, half written, names nothing. */
static void list_files(watched *w, const char *scene_path)
{
    static const char *const lists[] = {"buffers", "images"};
    run_context              ignored = {0};
    json_t                  *scene   = NULL, *item;
    size_t                   length  = strlen(scene_path), n;
    if ((w->paths[0] = strdup(scene_path))) w->count = 1;
    if (length < 5 || strcmp(scene_path + length - 5, ".gltf")) return;
    if (json_read(&scene, scene_path, &ignored) == VXS_OK)
        for (int list = 0; list < 2; list++) json_array_foreach(json_object_get(scene, lists[list]), n, item)
            {
                const char *uri = json_string_value(json_object_get(item, "uri"));
                if (uri) add_uri(w, scene_path, uri);
            }
    json_decref(scene);
    run_free(&ignored);
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
