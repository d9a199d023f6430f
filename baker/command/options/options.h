/* Commands run from the tables of their lines: parsing, checking, errors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef OPTIONS_H
#define OPTIONS_H

#include <string.h>

#include "baker/base/run_context.h"
#include "baker/command/options/option_table.h"
#include "baker/files/run_files.h"
#include "baker/scene/scene.h"
#include "formats/vxs_file.h"

/* Parse argv[1..argc). `--name value` and `--name=value` are the same; "-" alone is an operand; "--" ends the options; a
 * value may begin with '-' ("--sun -1,-2,0"). Options of every command are stored in m. Only list options may be repeated.
 * Returns VXS_OK, VXS_E_ARGUMENT (one line in m: the option, the value given, the value expected), or VXS_E_MEMORY;
 * *help_shown is set when --help was given and printed, and the command is done. */
vxs_result options_parse(const command_line *c, int argc, char **argv, int *help_shown, run_context *m);

/* Declare every output that is given (baker/files/run_files.h), and check files before the work begins: each output can be
 * written, and is neither an input nor another output; standard input is read at most once; inputs are of the expected kinds;
 * outputs do not have the extension of another format. Rows with OUTPUT_CHECKED_BY_COMMAND are not checked for being writable.
 * In strict mode, options_warn_of_names is called here.
 * Returns VXS_OK, VXS_E_ARGUMENT, VXS_E_READ, VXS_E_WRITE, VXS_E_MEMORY or VXS_E_STRICT. */
vxs_result options_check_files(const command_line *c, run_context *m);

/* Warn when the name of an output does not have the extension of its format. Call after the command has succeeded: after an
 * error, there is no output to warn about. */
void options_warn_of_names(const command_line *c, run_context *m);

/* Release the lists that parsing filled. */
void options_free(const command_line *c);

/* Run a command: parse its line, check its files, call `run` unless help was printed, print its error, release its lists.
 * command  passed to run; contains the options' targets
 * Returns the exit status. */
int command_run(const command_line *c, int argc, char **argv, vxs_result (*run)(void *command, run_context *m), void *command);

/* Print "vxs: error: ..." when m holds an error, release m, and return the exit status of `code`; 1 when the command succeeded
 * and m is marked as wrong. A failure to write the report (a full disk) is an error; a reader that closes the pipe early is not.
 * VXS_E_BROKEN_PIPE prints nothing. */
int command_end(run_context *m, vxs_result code);

/* The option rows of every command that loads a scene: the scene within the file, and which parts of it cast shadows. */

/* choice  a scene_choice */
/* clang-format off */
#define SCENE_ROWS(choice)                                                                                                         \
    {"--scene", OPTION_TEXT, &(choice).name, 0, 0, NULL, "NAME", "name or index of the glTF scene (default the file's)", NULL},    \
    {"--exclude", OPTION_TEXTS, &(choice).exclude, 0, 0, NULL, "PATTERN",                                                          \
     "nodes, meshes or materials that cast no shadow: node:Door*, mesh:grass_?, Glass; repeat for more", NULL},                    \
    {"--include", OPTION_TEXTS, &(choice).include, 0, 0, NULL, "PATTERN",                                                          \
     "only these cast, less what --exclude names; repeat for more (default all)", NULL},                                                         \
    {"--skinned", OPTION_CHOICE, &(choice).skinned, 0, 0, SKINNED_CHOICES, NULL,                                                   \
     "skinned meshes: left out, or in the pose that the file has (default exclude)", &(choice).skinned_given},                     \
    {"--blend", OPTION_CHOICE, &(choice).blend, 0, 0, BLEND_CHOICES, NULL,                                                         \
     "materials of alphaMode BLEND: walls where alpha is 0.5 or more; walls; nothing (default mask)", &(choice).blend_given},      \
    {"--allow-outside", OPTION_SWITCH, &(choice).allow_outside, 0, 0, NULL, NULL,                                                  \
     "read buffers and images that lie outside of the scene's folder", NULL}
/* clang-format on */

/* Filters from a command line: boxes of whole texels by --filter, smooth ones by --smooth. */

/* The maximum number of different filters besides single taps: boxes of odd widths, up to VXS_FILTER_MAX, and smooth ones of any
 * width. */
enum { FILTERS_MAX = VXS_FILTER_MAX / 2 + VXS_FILTER_MAX };

/* The filter of a command that takes one filter. */
typedef struct filter_choice {
    uint32_t box_px, smooth_px; /* widths, 1 to VXS_FILTER_MAX; box_px holds the default */
    int      box_given, smooth_given;
} filter_choice;

/* Option rows.   choice  a filter_choice;   help  of --filter */
/* clang-format off */
#define FILTER_ROWS(choice, help)                                                                                                  \
    {"--filter", OPTION_U32, &(choice).box_px, 1, VXS_FILTER_MAX, NULL, "K", help, &(choice).box_given},                           \
    {"--smooth", OPTION_U32, &(choice).smooth_px, 1, VXS_FILTER_MAX, NULL, "K",                                                    \
     "a smooth K x K filter in its place, about the point itself, K even or odd, 1 to 17 texels", &(choice).smooth_given}
/* clang-format on */

/* Returns VXS_OK, or VXS_E_ARGUMENT when both are given, or for a box of even width. */
vxs_result filter_check(const filter_choice *c, run_context *m);

/* The filter as vxs_lookup takes it. */
vxs_filter filter_of(const filter_choice *c);

static inline int filter_given(const filter_choice *c)
{
    return c->box_given || c->smooth_given;
}

/* Collect the filters of a command that takes several: the boxes, then the smooth filters. Boxes of width 1, single taps, are
 * skipped: the callers always measure them.
 * boxes, smooth  each without duplicates, from 1 to VXS_FILTER_MAX; smooth may be NULL
 * filters        [FILTERS_MAX] each in the order given;   count  [out]
 * Returns VXS_OK, or VXS_E_ARGUMENT for a box of even width. */
vxs_result filters_take(const number_list *boxes, const number_list *smooth, vxs_filter *filters, uint32_t *count, run_context *m);

/* "9 x 9", "9 x 9 smooth". */
const char *filter_text(char text[32], vxs_filter filter);

#endif
