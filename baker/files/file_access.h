/* Files of a run that are not those of the system: a table of callbacks in run_context.access. Code that reads or writes files by
 * name uses input_file.h, output_file.h and gltf_container.cc, which call these functions where there is a table. Without one
 * (NULL) the files are those of the system.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FILE_ACCESS_H
#define FILE_ACCESS_H

#include <stddef.h>
#include <stdint.h>

#define FILE_ACCESS_MISSING UINT64_MAX

typedef struct file_access {
    uint64_t (*size)(void *user, const char *name); /* size of a file in bytes; FILE_ACCESS_MISSING: there is no such file */
    int (*read)(void *user, const char *name, void *bytes, size_t size_bytes);        /* the whole file. Returns 0 or an errno */
    int (*write)(void *user, const char *name, const void *bytes, size_t size_bytes); /* the same; replaces a file */
    void *user;
} file_access;

#endif
