/* The files that a run writes: none of them is a file that it reads, and no two are one.
 *
 * The outputs, and the folders into which files of certain names are written, are declared before any work, by the command line. From then on
 * whoever opens an input, or learns of a file that belongs to one, asks here whether it may; and it is remembered, so that nothing is written
 * over it later: output_file_open, through which all is written, asks for that (output_file.h). Files are told apart by device and inode, links
 * followed; those that are not there yet by their folder's, and their name in it. Devices and sockets are nobody's: any number of inputs and
 * outputs may be /dev/null, or the terminal. Called by one thread at a time; run_files_check_write by any number, once all inputs are known.
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

/* A folder into which the run writes files whose names it does not know beforehand. */
typedef struct run_folder {
    const char   *option, *path, *names; /* names: "depth.png|lit-*.png", patterns of a shell; all borrowed */
    file_identity identity, inside;      /* of the folder; and as the folder of what is in it, known where it is there */
} run_folder;

/* A file that the run reads. */
typedef struct run_input {
    file_identity identity; /* of a file that is there */
    char         *what;     /* owned */
} run_input;

/* A file of a run_folder that is there already, and may be written over. */
typedef struct run_held {
    file_identity identity;
    size_t        folder;
    char         *name; /* owned */
    int           is_link;
} run_held;

typedef struct run_files {
    run_output *outputs; /* [count] owned, as the others */
    size_t      count, capacity;
    run_folder *folders; /* [folder_count] */
    size_t      folder_count, folder_capacity;
    run_held   *held; /* [held_count] */
    size_t      held_count, held_capacity;
    int         links;  /* 1: one of them is a symbolic link */
    run_input  *inputs; /* [input_count] */
    size_t      input_count, input_capacity;
} run_files;

/* Declare an output of the run, m->files; path - is standard output.
 * Returns VXS_OK; VXS_E_ARGUMENT: it is the same file as another output; VXS_E_MEMORY. */
vxs_result run_files_add_output(const char *option, const char *path, message *m);

/* Declare a folder into which files of some names are written, once all outputs are declared; it need not be there.
 * names  "depth.png|lit-*.png", patterns of a shell
 * Returns VXS_OK; VXS_E_ARGUMENT: the folder is an output, or an output may be one of those files, or two of them are one; VXS_E_MEMORY. */
vxs_result run_files_add_folder(const char *option, const char *path, const char *names, message *m);

/* Ask before a file is read, or because an input refers to it; - is standard input. One that is not there may be asked for.
 * what  says who reads it: "SCENE", "buffer 0 of a.gltf"
 * Returns VXS_OK; VXS_E_ARGUMENT: it is an output of this run, or may be written over in one of its folders, or is where standard output
 * goes; VXS_E_MEMORY. */
vxs_result run_files_check_input(const char *path, const char *what, message *m);

/* Ask before a file is written, by whatever name. Where a run knows of none, all may be.
 * Returns VXS_OK, or VXS_E_ARGUMENT: it is a file that this run reads. */
vxs_result run_files_check_write(const char *path, message *m);

/* The same of a file of a folder that was declared, which may be no declared output either. */
vxs_result run_files_check_write_in_folder(const char *option, const char *path, message *m);

/* 1 when an output was asked for and goes to standard output: -, or a name of the file or pipe that standard output is (/dev/stdout).
 * path  NULL: not asked for */
int is_standard_output(const char *path);

/* Accepts a zeroed object. */
void run_files_free(run_files *f);

#ifdef __cplusplus
}
#endif
#endif
