/* The command line of a command as a table. Parsing, checks, help, manual pages, completion, and the lists of input and output
 * files all use the same rows.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef OPTION_TABLE_H
#define OPTION_TABLE_H

#include <stddef.h>
#include <stdint.h>

#include "baker/base/text.h"

/* The kind of a file, by its first bytes and not by its name. */

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

typedef enum option_kind {
    OPTION_SWITCH, /* int, set to 1; takes no value */
    OPTION_U32,    /* uint32_t in [min, max] */
    OPTION_U32S,   /* number_list, repeated: each in [min, max], without duplicates */
    OPTION_BYTES,  /* uint64_t, at least 1: plain, or with K, M, G, T (powers of 1024), and iB or B after it */
    OPTION_F64,    /* double in [min, max], finite */
    OPTION_VECTOR, /* double[(size_t)max]: that many comma-separated finite numbers; see min */
    OPTION_TEXT,   /* const char *, borrowed from argv */
    OPTION_TEXTS,  /* text_list, repeated; borrowed from argv */
    OPTION_CHOICE, /* int, or an enum of its size: index of the value in `choices` */
    /* named_list, repeated as [NAME=]value; at most one value for each name, and one without a name. Values are those of VECTOR
     * (of 3), U32 (also "4K": times 1024), F64 */
    OPTION_NAMED_VECTOR,
    OPTION_NAMED_U32,
    OPTION_NAMED_F64,
    OPTION_INPUT,  /* const char *, borrowed from argv: an input file of kind `min` (option_table.h); max OPERAND_OPTIONAL: the last
                      operand, which may be missing */
    OPTION_INPUTS, /* text_list, repeated: input files of kind `min` */
    OPTION_OUTPUT, /* const char *, borrowed from argv: an output file, - is standard output; min 1: required; max
                      OUTPUT_CHECKED_BY_COMMAND: the command itself checks that it can be written */
    OPTION_FOLDER, /* const char *, borrowed from argv: an output folder; `choices` has the patterns of its files */
    OPTION_HELP,   /* int: index of a format in `choices`; the value follows '=' only; without a value it is the first format */
    OPTION_GROUP   /* no option: a heading in help, `help`, for the rows that follow; the other fields are 0 */
} option_kind;

enum { OPTION_NUMBERS_MAX = 32, OUTPUT_CHECKED_BY_COMMAND = 1, OPERAND_OPTIONAL = 1 };

/* Values of an OPTION_U32S. */
typedef struct number_list {
    uint32_t items[OPTION_NUMBERS_MAX];
    size_t   count;
} number_list;

/* A row. A row whose name does not begin with '-' is an operand, of kind TEXT, CHOICE, INPUT or INPUTS. Operands are given in
 * the order of their rows, and all of them are required, unless the last one is OPERAND_OPTIONAL; if the last one is a list, it takes
 * all remaining operands. */
typedef struct option {
    const char *name; /* "--resolution", "-o"; "SCENE"; NULL for a group */
    option_kind kind;
    void       *target; /* holds the default on entry */
    double      min, max;
    const char *choices; /* OPTION_CHOICE: "auto|peel|back"; OPTION_NAMED_*: the name of a value without a name, or NULL;
                            OPTION_OUTPUT: extensions of the format written, ".html|.htm"; OPTION_FOLDER: patterns of names,
                            "lit-*.png|sky.png" */
    const char *value; /* name of the value in help: "N", "OUT.vxs", for files with their extension; NULL for operands, switches and
                          choices */
    const char *help;  /* meaning and unit; at the end "(default X)" if it has a default */
    int        *given; /* NULL, or set to 1 when the option was given */
} option;

typedef struct command_line {
    const char   *name;     /* "bake" */
    const char   *synopsis; /* "SCENE -o OUT.vxs [options]" */
    const char   *summary;  /* its first sentence is also in the list of commands */
    const option *options;  /* [option_count]; at most OPTIONS_MAX together with the options of every command */
    size_t        option_count;
} command_line;

enum { OPTIONS_MAX = 64 };

/* The options are an array. */
#define COMMAND_LINE(name, synopsis, summary, options)                                                                             \
    ((command_line){name, synopsis, summary, options, sizeof(options) / sizeof *(options)})

static inline int is_operand(const option *o)
{
    return o->name && o->name[0] != '-';
}

static inline int operand_is_optional(const option *o)
{
    return is_operand(o) && o->kind == OPTION_INPUT && o->max == OPERAND_OPTIONAL;
}

static inline int is_named(const option *o)
{
    return o->kind == OPTION_NAMED_VECTOR || o->kind == OPTION_NAMED_U32 || o->kind == OPTION_NAMED_F64;
}

static inline int is_list(const option *o)
{
    return o->kind == OPTION_TEXTS || o->kind == OPTION_INPUTS || o->kind == OPTION_U32S || is_named(o);
}

/* Texts that help, manual pages and completion have in common. */

#endif
