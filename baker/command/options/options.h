/* Commands run from the tables of their lines: parsing, checking, errors.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef OPTIONS_H
#define OPTIONS_H

#include <string.h>

#include "baker/base/message.h"
#include "baker/command/options/option_table.h"
#include "baker/files/run_files.h"

/* Parse argv[1..argc). `--name value` and `--name=value` are the same; "-" alone is an operand; "--" ends the options; a
 * value may begin with '-' ("--sun -1,-2,0"). Options of every command are stored in m. Only list options may be repeated.
 * Returns VXS_OK, VXS_E_ARGUMENT (one line in m: the option, the value given, the value expected), or VXS_E_MEMORY;
 * *help_shown is set when --help was given and printed, and the command is done. */
vxs_result options_parse(const command_line *c, int argc, char **argv, int *help_shown, message *m);

/* Declare every output that is given (baker/files/run_files.h), and check files before the work begins: each output can be
 * written, and is neither an input nor another output; standard input is read at most once; inputs are of the expected kinds;
 * outputs do not have the extension of another format. Rows with OUTPUT_CHECKED_BY_COMMAND are not checked for being writable.
 * In strict mode, options_warn_of_names is called here.
 * Returns VXS_OK, VXS_E_ARGUMENT, VXS_E_READ, VXS_E_WRITE, VXS_E_MEMORY or VXS_E_STRICT. */
vxs_result options_check_files(const command_line *c, message *m);

/* Warn when the name of an output does not have the extension of its format. Call after the command has succeeded: after an
 * error, there is no output to warn about. */
void options_warn_of_names(const command_line *c, message *m);

/* Release the lists that parsing filled. */
void options_free(const command_line *c);

/* Run a command: parse its line, check its files, call `run` unless help was printed, print its error, release its lists.
 * command  passed to run; contains the options' targets
 * Returns the exit status. */
int command_run(const command_line *c, int argc, char **argv, vxs_result (*run)(void *command, message *m), void *command);

/* Print "vxs: error: ..." when m holds an error, release m, and return the exit status of `code`; 1 when the command succeeded
 * and m is marked as wrong. A failure to write the report (a full disk) is an error; a reader that closes the pipe early is not.
 * VXS_E_BROKEN_PIPE prints nothing. */
int command_end(message *m, vxs_result code);

#endif
