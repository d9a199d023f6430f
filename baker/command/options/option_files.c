/* The files that a command's line names, before any work; see options.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <ctype.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "baker/bake/cache/part_file.h"
#include "baker/command/options/option_table.h"
#include "baker/command/options/options.h"
#include "baker/files/foreign_file.h"
#include "baker/files/input_file.h"
#include "baker/files/output_file.h"
#include "formats/vxs_format.h"

enum { LOOKED_AT = FOREIGN_LOOKED_AT };

static int begins(const char *bytes, size_t size, const char *with, size_t with_size)
{
    return size >= with_size && !memcmp(bytes, with, with_size);
}

/* text  ended by a NUL */
static file_kind kind_of_text(const char *text)
{
    if (!strncmp(text, "\xef\xbb\xbf", 3)) text += 3;
    text += strspn(text, " \t\r\n");
    if (*text++ != '{') return FILE_UNKNOWN;
    text += strspn(text, " \t\r\n");
    if (!strncmp(text, "\"vxs\"", 5)) return FILE_REPORT;
    return strstr(text, "\"asset\"") ? FILE_SCENE : FILE_JSON;
}

/* Read the beginning of a regular file. A pipe is not opened, since closing it would end its writer.
 * Returns the number of bytes, 0 for other kinds of files. */
static size_t read_beginning(char bytes[LOOKED_AT + 1], const char *path, struct stat *status)
{
    if (stat(path, status) || !S_ISREG(status->st_mode)) return 0;
    int     file = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    ssize_t size = file < 0 ? 0 : read(file, bytes, LOOKED_AT);
    if (file >= 0) close(file);
    return size > 0 ? (size_t)size : 0;
}

/* Reads the first 4 KiB of regular files; other files are not opened. */
static file_kind file_kind_of(const char *path)
{
    struct stat status;
    char        bytes[LOOKED_AT + 1];
    size_t      size = read_beginning(bytes, path, &status);
    if (size) {
        static const char png[] = "\x89PNG\r\n\x1a\n";
        if (begins(bytes, size, VXS_MAGIC, VXS_MAGIC_BYTES)) return FILE_ASSET;
        /* a damaged .vxs file may begin with these four letters; in a GLB, a version follows them */
        if (begins(bytes, size, "glTF", 4) && size > 8 && (bytes[4] == 1 || bytes[4] == 2) && !bytes[5] && !bytes[6] && !bytes[7])
            return FILE_SCENE;
        if (begins(bytes, size, png, sizeof png - 1) || begins(bytes, size, "#?", 2)) return FILE_PICTURE;
        if (begins(bytes, size, PART_MAGIC, sizeof PART_MAGIC - 1)) return FILE_PART;
        bytes[size] = '\0';
        return size > 1 && bytes[0] == '{' && !bytes[1] ? FILE_UNKNOWN : kind_of_text(bytes); /* '{' and 0: UTF-16 */
    }
    return !stat(path, &status) && S_ISDIR(status.st_mode) ? FILE_FOLDER : FILE_UNKNOWN;
}

/* Text on a regular file of FILE_UNKNOWN: its format, and what to do with it (baker/files/foreign_file.h); NULL: unknown format.
 * text  [FOREIGN_BYTES] out */
static const char *file_kind_foreign(char *text, const char *path)
{
    struct stat status;
    char        bytes[LOOKED_AT + 1];
    size_t      size = read_beginning(bytes, path, &status);
    return size ? foreign_file_text(text, bytes, size, (uint64_t)status.st_size) : NULL;
}

/* "a .vxs file"; for FILE_UNKNOWN "something else" */
static const char *file_kind_text(file_kind kind)
{
    static const char *const texts[] = {"something else",  "a glTF scene", "a .vxs file",      "JSON",
                                        "a report of vxs", "a picture",    "a part of a bake", "a folder"};
    return texts[kind];
}

/* 0 when a file of kind `found` cannot be of the expected kind (a scene, an asset, JSON or a picture). FILE_UNKNOWN may be any. */
static int file_kind_may_be(file_kind found, file_kind expected)
{
    if (found == FILE_JSON) return expected != FILE_ASSET; /* it may be a scene whose "asset" member comes late */
    return found == FILE_UNKNOWN || found == expected || (found == FILE_REPORT && expected == FILE_JSON);
}

static const char *output_of(const option *o)
{
    return o->kind == OPTION_OUTPUT ? *(const char **)o->target : NULL;
}

/* The n-th file of an input row, NULL after the last. */
static const char *input_of(const option *o, size_t n)
{
    const text_list *list = o->target;
    if (o->kind == OPTION_INPUT) return n ? NULL : *(const char **)o->target;
    return o->kind == OPTION_INPUTS && n < list->count ? list->items[n] : NULL;
}

/* An input must not be an output, and standard input can be read only once.
 * piped  the row that reads standard input so far, or NULL */
static vxs_result check_input(const option *o, const char *path, const option **piped, run_context *m)
{
    if (is_standard_input(path) && *piped)
        return fail(m, VXS_E_ARGUMENT, "%s - and %s -: standard input can be read once: expected a file or <(command) for one",
                    (*piped)->name, o->name);
    if (is_standard_input(path)) *piped = o;
    return run_files_check_input(path, o->name, m);
}

/* The value of an operand that was swapped with that of o: each has the kind that the other expects. NULL when there is none. */
static const char *swapped_with(const command_line *c, const option *o, file_kind found)
{
    for (const option *other = c->options; other < c->options + c->option_count; other++) {
        const char *path = other != o && is_operand(other) ? input_of(other, 0) : NULL;
        if (path && found == (file_kind)other->min && file_kind_of(path) == (file_kind)o->min) return path;
    }
    return NULL;
}

static vxs_result check_kind(const command_line *c, const option *o, const char *path, run_context *m)
{
    char        foreign[FOREIGN_BYTES];
    file_kind   found = file_kind_of(path), expected = (file_kind)o->min;
    const char *text = found == FILE_UNKNOWN && expected != FILE_UNKNOWN ? file_kind_foreign(foreign, path) : NULL;
    if (text && expected == FILE_PICTURE && strstr(text, " picture"))
        text = NULL; /* the picture's reader has a better error for
                        this */
    if (text && is_operand(o))
        return fail(m, VXS_E_READ, "'%s' is %s, expected %s: usage is vxs %s %s", path, text, file_kind_text(expected), c->name,
                    c->synopsis);
    if (text) return fail(m, VXS_E_READ, "%s %s: is %s, expected %s", o->name, path, text, file_kind_text(expected));
    if (file_kind_may_be(found, expected)) return VXS_OK;
    const char *swapped = is_operand(o) ? swapped_with(c, o, found) : NULL;
    if (swapped)
        return fail(m, VXS_E_READ, "'%s' is %s and '%s' is %s: they are swapped: usage is vxs %s %s", path, file_kind_text(found),
                    swapped, file_kind_text(expected), c->name, c->synopsis);
    if (!is_operand(o))
        return fail(m, VXS_E_READ, "%s %s: is %s, expected %s", o->name, path, file_kind_text(found), file_kind_text(expected));
    return fail(m, VXS_E_READ, "'%s' is %s, expected %s: usage is vxs %s %s", path, file_kind_text(found), file_kind_text(expected),
                c->name, c->synopsis);
}

/* The extension of an output's name, when it does not match the format written. Names without an extension, devices and pipes
 * are not checked.
 * lower  [out] the extension's beginning, in lower case
 * Returns NULL when it matches or is not checked. */
static const char *other_extension(const option *output, char lower[16])
{
    const char *path = output_of(output), *slash = path ? strrchr(path, '/') : NULL, *name = slash ? slash + 1 : path;
    const char *dot    = path ? strrchr(name, '.') : NULL;
    size_t      length = dot && dot > name ? strlen(dot) : 0;
    struct stat status;
    if (!length || !strcmp(dot, ".") || (!stat(path, &status) && !S_ISREG(status.st_mode))) return NULL;
    snprintf(lower, 16, "%s", dot);
    for (char *c = lower; *c; c++) *c = (char)tolower((unsigned char)*c);
    return choice_index(output->choices, lower) < 0 ? dot : NULL;
}

static int is_known(const char *extension)
{
    return choice_index(".vxs|.part|.gltf|.glb|.json|.html|.htm|.png|.exr", extension) >= 0; /* formats that vxs reads or writes */
}

static vxs_result check_extension(const option *output, run_context *m)
{
    char        lower[16], written[32];
    const char *other = other_extension(output, lower);
    if (!other || !is_known(lower)) return VXS_OK;
    return fail(m, VXS_E_ARGUMENT, "%s %s: '%s' is the extension of other files: what is written is %s", output->name,
                output_of(output), other, choice_word(written, output->choices, 0));
}

void options_warn_of_names(const command_line *c, run_context *m)
{
    for (const option *o = c->options; o < c->options + c->option_count; o++) {
        char        lower[16], written[32];
        const char *other = other_extension(o, lower);
        if (other && !is_known(lower))
            warn(m, "%s %s: what is written is %s, and '%s' does not say so: rename it", o->name, output_of(o),
                 choice_word(written, o->choices, 0), other);
    }
}

vxs_result options_check_files(const command_line *c, run_context *m)
{
    const option *end = c->options + c->option_count, *piped = NULL;
    vxs_result    r = VXS_OK;
    for (const option *o = c->options; o < end && r == VXS_OK; o++)
        if (output_of(o)) r = run_files_add_output(o->name, output_of(o), m);
    for (const option *o = c->options; o < end && r == VXS_OK; o++) {
        const char *folder = o->kind == OPTION_FOLDER ? *(const char **)o->target : NULL;
        if (folder) r = run_files_add_folder(o->name, folder, o->choices, m);
    }
    for (const option *o = c->options; o < end && r == VXS_OK; o++)
        for (size_t n = 0; input_of(o, n) && r == VXS_OK; n++) r = check_input(o, input_of(o, n), &piped, m);
    for (const option *o = c->options; o < end && r == VXS_OK; o++)
        if (output_of(o) && o->max != OUTPUT_CHECKED_BY_COMMAND) r = output_file_check(output_of(o), m);
    for (const option *o = c->options; o < end && r == VXS_OK; o++)
        for (size_t n = 0; input_of(o, n) && r == VXS_OK; n++) r = check_kind(c, o, input_of(o, n), m);
    for (const option *o = c->options; o < end && r == VXS_OK; o++) r = check_extension(o, m);
    if (r == VXS_OK && m->strict) options_warn_of_names(c, m);
    return r == VXS_OK ? run_check(m) : r;
}
