/* The files that a run writes: none of them is a file that it reads, and no two are one.
 *
 * The outputs are declared before any work, by the command line. From then on whoever opens an input, or learns of a file that belongs to
 * one, asks here whether it may. Files are told apart by device and inode, links followed; those that are not there yet by their folder's,
 * and their name in it. Devices and sockets are nobody's: any number of inputs and outputs may be /dev/null, or the terminal.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RUN_FILES_H
#define RUN_FILES_H

#include <stddef.h>
#include <sys/types.h>

#include "baker/base/message.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct file_identity {
    int         is_known; /* 0: equals no other */
    dev_t       device;
    ino_t       inode;
    const char *name; /* NULL: the file itself; else device and inode are its folder's; points into the path */
} file_identity;

typedef struct run_output {
    const char   *option, *path; /* "-o", "a.vxs"; borrowed from the command line */
    file_identity identity;
} run_output;

typedef struct run_files {
    run_output *outputs; /* [count] owned */
    size_t      count, capacity;
} run_files;

/* Declare an output of the run, m->files; path - is standard output.
 * Returns VXS_OK; VXS_E_ARGUMENT: it is the same file as another output; VXS_E_MEMORY. */
vxs_result run_files_add_output(const char *option, const char *path, message *m);

/* Ask before a file is read, or because an input refers to it; - is standard input. One that is not there may be asked for.
 * what  says who reads it: "SCENE", "buffer 0 of a.gltf"
 * Returns VXS_OK, or VXS_E_ARGUMENT: it is an output of this run, or where standard output goes. */
vxs_result run_files_check_input(const char *path, const char *what, message *m);

/* 1 when an output was asked for and goes to standard output: -, or a name of the file or pipe that standard output is (/dev/stdout).
 * path  NULL: not asked for */
int is_standard_output(const char *path);

/* Accepts a zeroed object. */
void run_files_free(run_files *f);

#ifdef __cplusplus
}
#endif
#endif
