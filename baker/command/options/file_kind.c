/* The kind of a file; see file_kind.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/options/file_kind.h"

#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "baker/bake/cache/part_file.h"
#include "baker/files/foreign_file.h"
#include "formats/vxs_format.h"

enum { LOOKED_AT = FOREIGN_LOOKED_AT };

static int begins(const char *bytes, size_t size, const char *with, size_t with_size)
{
    return size >= with_size && !memcmp(bytes, with, with_size);
}

/* A damaged .vxs file may begin with these four letters; in a GLB, a version follows them. */
static int is_glb(const char *bytes, size_t size)
{
    return begins(bytes, size, "glTF", 4) && size > 8 && (bytes[4] == 1 || bytes[4] == 2) && !bytes[5] && !bytes[6] && !bytes[7];
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

static file_kind kind_of_bytes(char bytes[LOOKED_AT + 1], size_t size)
{
    static const char png[] = "\x89PNG\r\n\x1a\n";
    if (begins(bytes, size, VXS_MAGIC, VXS_MAGIC_BYTES)) return FILE_ASSET;
    if (is_glb(bytes, size)) return FILE_SCENE;
    if (begins(bytes, size, png, sizeof png - 1) || begins(bytes, size, "#?", 2)) return FILE_PICTURE;
    if (begins(bytes, size, PART_MAGIC, sizeof PART_MAGIC - 1)) return FILE_PART;
    bytes[size] = '\0';
    return size > 1 && bytes[0] == '{' && !bytes[1] ? FILE_UNKNOWN : kind_of_text(bytes); /* '{' and 0: UTF-16 */
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

file_kind file_kind_of(const char *path)
{
    struct stat status;
    char        bytes[LOOKED_AT + 1];
    size_t      size = read_beginning(bytes, path, &status);
    if (size) return kind_of_bytes(bytes, size);
    return !stat(path, &status) && S_ISDIR(status.st_mode) ? FILE_FOLDER : FILE_UNKNOWN;
}

const char *file_kind_foreign(char *text, const char *path)
{
    struct stat status;
    char        bytes[LOOKED_AT + 1];
    size_t      size = read_beginning(bytes, path, &status);
    return size ? foreign_file_text(text, bytes, size, (uint64_t)status.st_size) : NULL;
}

const char *file_kind_text(file_kind kind)
{
    static const char *const texts[] = {"something else",  "a glTF scene", "a .vxs file",      "JSON",
                                        "a report of vxs", "a picture",    "a part of a bake", "a folder"};
    return texts[kind];
}

int file_kind_may_be(file_kind found, file_kind expected)
{
    if (found == FILE_JSON) return expected != FILE_ASSET; /* it may be a scene whose "asset" member comes late */
    return found == FILE_UNKNOWN || found == expected || (found == FILE_REPORT && expected == FILE_JSON);
}
