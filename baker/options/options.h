/* Command-line options as a table: parsing, checking and help come from the same rows.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef OPTIONS_H
#define OPTIONS_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "baker/base/message.h"
#include "baker/base/text.h"

typedef enum option_kind {
    OPTION_SWITCH, /* int, set to 1; takes no value */
    OPTION_U32,    /* uint32_t in [min, max] */
    OPTION_U32S,   /* number_list, repeated: each in [min, max], none twice */
    OPTION_BYTES,  /* uint64_t, at least 1: plain, or with K, M, G, T (powers of 1024), and iB or B after it */
    OPTION_F64,    /* double in [min, max], finite */
    OPTION_VECTOR, /* double[(size_t)max]: that many comma-separated finite numbers; see min */
    OPTION_TEXT,   /* const char *, borrowed from argv */
    OPTION_TEXTS,  /* text_list, repeated; borrowed from argv */
    OPTION_CHOICE, /* int, or an enum of its size: index of the value in `choices` */
    OPTION_GROUP   /* no option: what follows stands in help under this heading, `help`; the other fields are 0 */
} option_kind;

enum { OPTION_NUMBERS_MAX = 32 };

/* Values of an OPTION_U32S. */
typedef struct number_list {
    uint32_t items[OPTION_NUMBERS_MAX];
    size_t   count;
} number_list;

typedef struct option {
    const char *name; /* "--resolution", "-o"; NULL for a group */
    option_kind kind;
    void       *target; /* holds the default on entry */
    double      min, max;
    const char *choices; /* OPTION_CHOICE: "auto|peel|back" */
    const char *value;   /* name of the value in help: "N", "FILE"; NULL for switches and choices */
    const char *help;    /* one line: what, unit, default */
    int        *given;   /* NULL, or set to 1 when the option was given */
} option;

typedef struct command_line {
    const char   *name;     /* "bake" */
    const char   *synopsis; /* "SCENE -o OUT.vxs [options]" */
    const char   *summary;  /* one sentence */
    const option *options;
    size_t        option_count;
    size_t        operand_count; /* how many operands (file names and the like) must be given, exactly */
} command_line;

/* The options are an array. */
#define COMMAND_LINE(name, synopsis, summary, options, operand_count)                                                              \
    ((command_line){name, synopsis, summary, options, sizeof(options) / sizeof *(options), operand_count})

/* Parse argv[1..argc). `--name value` and `--name=value` are the same; "-" alone is an operand; "--" ends the options; a
 * value may begin with '-' ("--sun -1,-2,0").
 * operands  [operand_count] borrowed from argv.
 * Returns VXS_OK, VXS_E_ARGUMENT (one line in m: the option, what was given, what was expected), or VXS_E_MEMORY;
 * *help_shown is set when --help was given and printed, and the command is done. */
vxs_result options_parse(const command_line *c, int argc, char **argv, const char **operands, int *help_shown, message *m);

/* The same, and the last operand may be given more than once.
 * operands  [argc] those that are not given are left alone */
vxs_result options_parse_repeated(const command_line *c, int argc, char **argv, const char **operands, int *help_shown, message *m);

/* 1 when an output was asked for, and goes to standard output. path  NULL: not asked for */
static inline int is_standard_output(const char *path)
{
    return path && !strcmp(path, "-");
}

/* Two outputs that must not be one file, nor both standard output. Names that differ may still be links to one file.
 * a, b            the options that name them, for the message
 * a_path, b_path  NULL: not given
 * Returns VXS_OK or VXS_E_ARGUMENT. */
vxs_result outputs_check_apart(const char *a, const char *a_path, const char *b, const char *b_path, message *m);

/* All of a command: parse its line, run it unless help was asked for, print its error, release its lists of texts.
 * operands  as of options_parse;   command  whatever run works on, and the options' targets are in
 * Returns the exit status. */
int command_run(const command_line *c, int argc, char **argv, const char **operands, vxs_result (*run)(void *command, message *m),
                void *command);

/* Print "vxs: error: ..." when m holds an error, release m, and return the exit status of `code`. */
int command_end(message *m, vxs_result code);

#endif
