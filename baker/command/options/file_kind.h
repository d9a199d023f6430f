/* The kind of a file, by its first bytes and not by its name.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FILE_KIND_H
#define FILE_KIND_H

typedef enum file_kind {
    FILE_UNKNOWN, /* none of the following; or not readable without consuming it, such as a pipe */
    FILE_SCENE,   /* glTF, binary or text */
    FILE_ASSET,   /* .vxs */
    FILE_JSON,    /* text that begins like JSON, and is not one of the following */
    FILE_REPORT,  /* JSON from vxs, which begins with its version */
    FILE_PICTURE, /* PNG, or Radiance's */
    FILE_PART,    /* of a bake */
    FILE_FOLDER
} file_kind;

/* Reads the first 4 KiB of regular files; other files are not opened. */
file_kind file_kind_of(const char *path);

/* Text on a regular file of FILE_UNKNOWN: its format, and what to do with it (baker/files/foreign_file.h); NULL: unknown format.
 * text  [FOREIGN_BYTES] out */
const char *file_kind_foreign(char *text, const char *path);

/* "a .vxs file"; for FILE_UNKNOWN "something else" */
const char *file_kind_text(file_kind kind);

/* 0 when a file of kind `found` cannot be of the expected kind (a scene, an asset, JSON or a picture). FILE_UNKNOWN may be any. */
int file_kind_may_be(file_kind found, file_kind expected);

#endif
