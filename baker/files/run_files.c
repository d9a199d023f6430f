/* Tracks the files of a run; see run_files.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/files/run_files.h"

#include <dirent.h>
#include <fcntl.h>
#include <fnmatch.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "baker/base/array.h"
#include "baker/base/text.h"

static file_identity identity_of(const struct stat *s)
{
    return (file_identity){!S_ISCHR(s->st_mode) && !S_ISSOCK(s->st_mode), s->st_dev, s->st_ino, NULL};
}

/* Identify a path by its folder and the name in it. */
static file_identity identify_place(const char *path)
{
    struct stat s;
    char        folder[PATH_MAX];
    const char *name = path_split(path, folder);
    return !name || stat(folder, &s) ? (file_identity){0} : (file_identity){1, s.st_dev, s.st_ino, name};
}

/* descriptor  used for the path "-" */
static file_identity identify(const char *path, int descriptor)
{
    struct stat s;
    if (strcmp(path, "-") ? !stat(path, &s) : !fstat(descriptor, &s)) return identity_of(&s);
    return identify_place(path);
}

static int is_same(const file_identity *a, const file_identity *b)
{
    if (!a->is_known || !b->is_known || a->device != b->device || a->inode != b->inode) return 0;
    return a->name && b->name ? !strcmp(a->name, b->name) : a->name == b->name;
}

/* 1 when a name matches one of the patterns "depth.png|lit-*.png". */
static int is_one_of(const char *names, const char *name)
{
    char pattern[64];
    while (*names) {
        size_t length = strcspn(names, "|");
        if (length < sizeof pattern) {
            memcpy(pattern, names, length);
            pattern[length] = 0;
            if (!fnmatch(pattern, name, 0)) return 1;
        }
        names += length + (names[length] == '|');
    }
    return 0;
}

static vxs_result out_of_memory(const char *what, run_context *m)
{
    return fail(m, VXS_E_MEMORY, "out of memory while reading %s", what);
}

/* outputs ---------------------------------------------------------------------------------------------------------------------- */

/* Another output with this identity, or NULL. */
static const run_output *find_output(const run_files *f, const file_identity *identity)
{
    for (const run_output *o = f->outputs; o < f->outputs + f->count; o++)
        if (is_same(&o->identity, identity)) return o;
    return NULL;
}

static vxs_result are_one_file(const run_output *o, const char *option, const char *path, run_context *m)
{
    return fail(m, VXS_E_ARGUMENT, "%s %s and %s %s are one file: expected two names", o->option, o->path, option, path);
}

vxs_result run_files_add_output(const char *option, const char *path, run_context *m)
{
    run_files        *f     = m->files;
    run_output        out   = {option, path, identify(path, STDOUT_FILENO)};
    const run_output *other = find_output(f, &out.identity);
    for (const run_output *o = f->outputs; o < f->outputs + f->count && !strcmp(path, "-"); o++)
        if (!strcmp(o->path, "-"))
            return fail(m, VXS_E_ARGUMENT, "%s - and %s - exclude each other: both would go to standard output", o->option, option);
    if (other) return are_one_file(other, option, path, m);
    if (!array_reserve(&f->outputs, &f->capacity, f->count + 1, sizeof *f->outputs)) return out_of_memory(option, m);
    f->outputs[f->count++] = out;
    return VXS_OK;
}

/* folders ---------------------------------------------------------------------------------------------------------------------- */

/* An output that is a file of the folder, existing or not. NULL: none. */
static const run_output *output_in(const run_files *f, const run_folder *folder)
{
    for (const run_output *o = f->outputs; o < f->outputs + f->count; o++) {
        file_identity place = identify_place(o->path);
        if (!strcmp(o->path, "-") || !place.is_known || !folder->inside.is_known) continue;
        if (place.device == folder->inside.device && place.inode == folder->inside.inode && is_one_of(folder->names, place.name))
            return o;
    }
    return NULL;
}

/* Add an existing file of a folder. Its target must not be an output, nor the target of another name in the folder. */
static vxs_result add_held(run_files *f, size_t folder, const file_identity *identity, const char *name, int is_link,
                           run_context *m)
{
    const run_folder *in    = &f->folders[folder];
    const run_output *other = find_output(f, identity);
    if (other)
        return fail(m, VXS_E_ARGUMENT, "%s %s and %s of %s %s are one file: expected two names", other->option, other->path, name,
                    in->option, in->path);
    f->links |= is_link;
    for (const run_held *h = f->held; h < f->held + f->held_count && f->links; h++)
        if ((h->is_link || is_link) && is_same(&h->identity, identity))
            return fail(m, VXS_E_ARGUMENT, "%s %s: %s and %s of it are one file: expected two", in->option, in->path, h->name,
                        name);
    char *copy = strdup(name);
    if (!copy || !array_reserve(&f->held, &f->held_capacity, f->held_count + 1, sizeof *f->held)) {
        free(copy);
        return out_of_memory(in->option, m);
    }
    f->held[f->held_count++] = (run_held){*identity, folder, copy, is_link};
    return VXS_OK;
}

vxs_result run_files_add_folder(const char *option, const char *path, const char *names, run_context *m)
{
    run_files  *f      = m->files;
    run_folder  folder = {option, path, names, identify(path, -1), {0}};
    struct stat there;
    if (!stat(path, &there)) folder.inside = identity_of(&there);
    const run_output *output = find_output(f, &folder.identity);
    if (output) return are_one_file(output, option, path, m);
    if ((output = output_in(f, &folder)))
        return fail(m, VXS_E_ARGUMENT, "%s %s: is a file that %s %s may write, too: expected another name", output->option,
                    output->path, option, path);
    if (!array_reserve(&f->folders, &f->folder_capacity, f->folder_count + 1, sizeof *f->folders)) return out_of_memory(option, m);
    f->folders[f->folder_count++] = folder;

    /* list the existing files of the folder that match its patterns */
    DIR       *open = opendir(path);
    vxs_result r    = VXS_OK;
    for (struct dirent *entry; open && r == VXS_OK && (entry = readdir(open));) {
        struct stat itself;
        const char *name = entry->d_name;
        if (!is_one_of(names, name) || fstatat(dirfd(open), name, &there, 0)) continue;
        int           is_link = fstatat(dirfd(open), name, &itself, AT_SYMLINK_NOFOLLOW) || S_ISLNK(itself.st_mode);
        file_identity what    = identity_of(&there);
        r                     = add_held(f, f->folder_count - 1, &what, name, is_link, m);
    }
    if (open) closedir(open);
    return r;
}

/* inputs ----------------------------------------------------------------------------------------------------------------------- */

static vxs_result is_the_input(const char *option, const char *path, const char *what, run_context *m)
{
    return fail(m, VXS_E_ARGUMENT, "%s%s%s: is the input itself, %s: expected another name for the output", option,
                *option ? " " : "", path, what);
}

vxs_result run_files_check_input(const char *path, const char *what, run_context *m)
{
    run_files *f = m->files;
    if (!f) return VXS_OK;
    if (f->seen) f->seen(f->seen_user, path);
    file_identity     in = identify(path, STDIN_FILENO), shown = identify("-", STDOUT_FILENO);
    const run_output *o = find_output(f, &in);
    if (o) return is_the_input(o->option, o->path, what, m);
    for (const run_held *h = f->held; h < f->held + f->held_count; h++)
        if (is_same(&h->identity, &in))
            return fail(m, VXS_E_ARGUMENT, "%s %s: %s of it is the input itself, %s: expected another folder",
                        f->folders[h->folder].option, f->folders[h->folder].path, h->name, what);
    if (is_same(&shown, &in))
        return fail(m, VXS_E_ARGUMENT, "standard output goes to the input itself, %s: expected another file", what);

    if (!in.is_known || in.name) return VXS_OK; /* a device, or it does not exist */
    for (const run_input *i = f->inputs; i < f->inputs + f->input_count; i++)
        if (is_same(&i->identity, &in)) return VXS_OK;
    char *copy = strdup(what);
    if (!copy || !array_reserve(&f->inputs, &f->input_capacity, f->input_count + 1, sizeof *f->inputs)) {
        free(copy);
        return out_of_memory(what, m);
    }
    f->inputs[f->input_count++] = (run_input){in, copy};
    return VXS_OK;
}

/* writing ---------------------------------------------------------------------------------------------------------------------- */

static vxs_result check_write(const char *option, const char *path, const file_identity *out, run_context *m)
{
    const run_files *f = m->files;
    for (const run_input *i = f->inputs; i < f->inputs + f->input_count; i++)
        if (is_same(&i->identity, out)) return is_the_input(option, path, i->what, m);
    return VXS_OK;
}

vxs_result run_files_check_write(const char *path, run_context *m)
{
    if (!m->files) return VXS_OK;
    file_identity out = identify(path, -1);
    return check_write("", path, &out, m);
}

vxs_result run_files_check_write_in_folder(const char *option, const char *path, run_context *m)
{
    if (!m->files) return VXS_OK;
    file_identity     out = identify(path, -1);
    const run_output *o   = find_output(m->files, &out);
    return o ? are_one_file(o, option, path, m) : check_write(option, path, &out, m);
}

/* ------------------------------------------------------------------------------------------------------------------------------ */

int is_standard_output(const char *path)
{
    if (!path || !strcmp(path, "-")) return path != NULL;
    file_identity out = identify(path, -1), shown = identify("-", STDOUT_FILENO);
    return is_same(&out, &shown);
}

void run_files_free(run_files *f)
{
    for (size_t n = 0; n < f->held_count; n++) free(f->held[n].name);
    for (size_t n = 0; n < f->input_count; n++) free(f->inputs[n].what);
    free(f->outputs);
    free(f->folders);
    free(f->held);
    free(f->inputs);
    *f = (run_files){0};
}
