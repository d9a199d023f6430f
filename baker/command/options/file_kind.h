/* What a file is, by its first bytes and not by its name.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FILE_KIND_H
#define FILE_KIND_H

typedef enum file_kind {
    FILE_UNKNOWN, /* nothing below; or no file that can be looked into without taking from it, as a pipe is */
    FILE_SCENE,   /* glTF, binary or text */
    FILE_ASSET,   /* .vxs */
    FILE_JSON,    /* text that begins as JSON does, and neither of the following */
    FILE_REPORT,  /* JSON that vxs wrote, beginning with its version */
    FILE_PICTURE, /* PNG, or Radiance's */
    FILE_PART,    /* of a bake */
    FILE_FOLDER
} file_kind;

/* Looks into a regular file only, at its first 4 KiB. */
file_kind file_kind_of(const char *path);

/* What a regular file of FILE_UNKNOWN is, and what to do with it (baker/files/foreign_file.h); NULL: it is not known.   text
 * [FOREIGN_BYTES] out */
const char *file_kind_foreign(char *text, const char *path);

/* "a .vxs file"; of FILE_UNKNOWN "something else" */
const char *file_kind_text(file_kind kind);

/* 0 when a file that is this cannot be what was expected, which is a scene, an asset, JSON or a picture. What is not known may
 * be anything. */
int file_kind_may_be(file_kind found, file_kind expected);

#endif
