/* Commands run from the tables of their lines: parsing, checking, errors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef OPTIONS_H
#define OPTIONS_H

#include <string.h>

#include "baker/base/message.h"
#include "baker/command/options/option_table.h"
#include "baker/files/run_files.h"

/* Parse argv[1..argc). `--name value` and `--name=value` are the same; "-" alone is an operand; "--" ends the options; a
 * value may begin with '-' ("--sun -1,-2,0"). Options that every command has are kept in m. An option that is no list is given
 * once at most.
 * Returns VXS_OK, VXS_E_ARGUMENT (one line in m: the option, what was given, what was expected), or VXS_E_MEMORY;
 * *help_shown is set when --help was given and printed, and the command is done. */
vxs_result options_parse(const command_line *c, int argc, char **argv, int *help_shown, message *m);

/* Declare every output that is given (baker/files/run_files.h), and find out before long work that it can be written, and is no
 * input and no other output, that standard input is read once at most, that inputs are of their kinds, and outputs not named
 * like other files. Whether a row OUTPUT_CHECKED_BY_COMMAND can be written is not asked here. Where warnings are errors, those
 * of options_warn_of_names come now.
 * Returns VXS_OK, VXS_E_ARGUMENT, VXS_E_READ, VXS_E_WRITE, VXS_E_MEMORY or VXS_E_STRICT. */
vxs_result options_check_files(const command_line *c, message *m);

/* Warn about names of outputs that do not say what is written. Called when the command has done its work: of what is refused no
 * name matters. */
void options_warn_of_names(const command_line *c, message *m);

/* Release what parsing put into lists. */
void options_free(const command_line *c);

/* All of a command: parse its line, check its files, run it unless help was asked for, print its error, release its lists.
 * command  whatever run works on, and the options' targets are in
 * Returns the exit status. */
int command_run(const command_line *c, int argc, char **argv, vxs_result (*run)(void *command, message *m), void *command);

/* Print "vxs: error: ..." when m holds an error, release m, and return the exit status of `code`; 1 when all went well and m
 * says that something is wrong. A report that nobody reads to its end is no error; one that cannot be written, to a full disk,
 * is. Of VXS_E_BROKEN_PIPE nothing is said. */
int command_end(message *m, vxs_result code);

#endif
