/* Tracks the files of a run: an output must not be a file that the run reads, and no two outputs may be the same file.
 *
 * The command line declares all outputs before any work, and the folders into which files with certain names are written. Later,
 * code that opens an input, or finds a file that an input refers to, calls run_files_check_input. The file is remembered, and
 * output_file_open, through which all files are written (output_file.h), refuses to write over it. Files are identified by device
 * and inode, after following links; files that do not exist yet by their folder's device and inode and their name. Devices and
 * sockets are exempt: several inputs and outputs may be /dev/null or the terminal. Threads: one at a time; run_files_check_write
 * from any number of threads once all inputs are known.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RUN_FILES_H
#define RUN_FILES_H

#include <stddef.h>
#include <sys/types.h>

#include "baker/base/run_context.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct file_identity {
    int         is_known; /* 0: unknown, equal to no other */
    dev_t       device;
    ino_t       inode;
    const char *name; /* NULL: device and inode identify the file; else they identify its folder, and this is the name in it, a
                         pointer into the path */
} file_identity;

typedef struct run_output {
    const char   *option, *path; /* for example "-o" and "a.vxs"; borrowed from the command line */
    file_identity identity;
} run_output;

/* A folder into which the run writes files; their names are not known in advance. */
typedef struct run_folder {
    const char   *option, *path, *names; /* names: shell patterns, "depth.png|lit-*.png"; all borrowed */
    file_identity identity, inside;      /* identity of the folder; identity to compare with the folders of files in it, known when
                                            the folder exists */
} run_folder;

/* A file that the run reads. */
typedef struct run_input {
    file_identity identity; /* of an existing file */
    char         *what;     /* description for messages; owned */
} run_input;

/* An existing file in a run_folder that may be overwritten. */
typedef struct run_held {
    file_identity identity;
    size_t        folder;
    char         *name; /* owned */
    int           is_link;
} run_held;

typedef struct run_files {
    run_output *outputs; /* [count] owned, like all arrays below */
    size_t      count, capacity;
    run_folder *folders; /* [folder_count] */
    size_t      folder_count, folder_capacity;
    run_held   *held; /* [held_count] */
    size_t      held_count, held_capacity;
    int         links;  /* 1: some held file is a symbolic link */
    run_input  *inputs; /* [input_count] */
    size_t      input_count, input_capacity;
    void (*seen)(void       *user,
                 const char *path); /* gets the path of each input that is checked, also of a missing one; NULL: not wanted */
    void *seen_user;
} run_files;

/* Declare an output of the run, in m->files. The path "-" is standard output.
 * Returns VXS_OK; VXS_E_ARGUMENT: the same file as another output; VXS_E_MEMORY. */
vxs_result run_files_add_output(const char *option, const char *path, run_context *m);

/* Declare a folder into which files with certain names are written. Call it after all outputs are declared. The folder need not
 * exist.
 * names  shell patterns, "depth.png|lit-*.png"
 * Returns VXS_OK; VXS_E_ARGUMENT: the folder is an output, an output may be one of those files, or two of them are the same file;
 * VXS_E_MEMORY. */
vxs_result run_files_add_folder(const char *option, const char *path, const char *names, run_context *m);

/* Check a file before it is read, or because an input refers to it. The path "-" is standard input. The file need not exist.
 * what  the reader, for messages: "SCENE", "buffer 0 of a.gltf"
 * Returns VXS_OK; VXS_E_ARGUMENT: the file is an output of this run, may be overwritten in one of its folders, or is the target of
 * standard output; VXS_E_MEMORY. */
vxs_result run_files_check_input(const char *path, const char *what, run_context *m);

/* Check a file, by any of its names, before it is written. Without m->files all files may be written.
 * Returns VXS_OK, or VXS_E_ARGUMENT: this run reads the file. */
vxs_result run_files_check_write(const char *path, run_context *m);

/* The same for a file in a declared folder. It must not be a declared output either. */
vxs_result run_files_check_write_in_folder(const char *option, const char *path, run_context *m);

/* 1 when an output goes to standard output: the path is "-", or names the file or pipe of standard output (/dev/stdout).
 * path  NULL: no such output */
int is_standard_output(const char *path);

/* Accepts a zeroed object. */
void run_files_free(run_files *f);

#ifdef __cplusplus
}
#endif
#endif
