/* The files that a run writes; see run_files.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/files/run_files.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "baker/base/array.h"
#include "baker/base/text.h"

/* descriptor  what "-" stands for */
static file_identity identify(const char *path, int descriptor)
{
    struct stat s;
    if (strcmp(path, "-") ? !stat(path, &s) : !fstat(descriptor, &s))
        return (file_identity){!S_ISCHR(s.st_mode) && !S_ISSOCK(s.st_mode), s.st_dev, s.st_ino, NULL};

    char        folder[PATH_MAX];
    const char *name = path_split(path, folder);
    return !name || stat(folder, &s) ? (file_identity){0} : (file_identity){1, s.st_dev, s.st_ino, name};
}

static int is_same(const file_identity *a, const file_identity *b)
{
    if (!a->is_known || !b->is_known || a->device != b->device || a->inode != b->inode) return 0;
    return a->name && b->name ? !strcmp(a->name, b->name) : a->name == b->name;
}

vxs_result run_files_add_output(const char *option, const char *path, message *m)
{
    run_files *f   = m->files;
    run_output out = {option, path, identify(path, STDOUT_FILENO)};
    for (const run_output *o = f->outputs; o < f->outputs + f->count; o++) {
        if (!strcmp(path, "-") && !strcmp(o->path, "-"))
            return fail(m, VXS_E_ARGUMENT, "%s - and %s - exclude each other: both would go to standard output", o->option, option);
        if (is_same(&o->identity, &out.identity))
            return fail(m, VXS_E_ARGUMENT, "%s %s and %s %s are one file: expected two names", o->option, o->path, option, path);
    }
    if (!array_reserve(&f->outputs, &f->capacity, f->count + 1, sizeof *f->outputs))
        return fail(m, VXS_E_MEMORY, "out of memory while reading %s", option);
    f->outputs[f->count++] = out;
    return VXS_OK;
}

vxs_result run_files_check_input(const char *path, const char *what, message *m)
{
    const run_files *f = m->files;
    if (!f) return VXS_OK;
    file_identity in = identify(path, STDIN_FILENO), shown = identify("-", STDOUT_FILENO);
    for (const run_output *o = f->outputs; o < f->outputs + f->count; o++)
        if (is_same(&o->identity, &in))
            return fail(m, VXS_E_ARGUMENT, "%s %s: is the input itself, %s: expected another name for the output", o->option,
                        o->path, what);
    if (is_same(&shown, &in))
        return fail(m, VXS_E_ARGUMENT, "standard output goes to the input itself, %s: expected another file", what);
    return VXS_OK;
}

int is_standard_output(const char *path)
{
    if (!path || !strcmp(path, "-")) return path != NULL;
    file_identity out = identify(path, -1), shown = identify("-", STDOUT_FILENO);
    return is_same(&out, &shown);
}

void run_files_free(run_files *f)
{
    free(f->outputs);
    *f = (run_files){0};
}
