/* Output made from a command's table: help, manual pages and shell completion.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef HELP_H
#define HELP_H

#include "baker/command/options/option_table.h"

/* Formats of --help=FORMAT. A row format prints one command's entry in the list of all commands. */
#define HELP_FORMATS_OF_ALL "text|man|bash|zsh|fish"
#define HELP_FORMATS        HELP_FORMATS_OF_ALL "|text-row|man-row"
typedef enum help_format { HELP_TEXT, HELP_MAN, HELP_BASH, HELP_ZSH, HELP_FISH, HELP_TEXT_ROW, HELP_MAN_ROW } help_format;

/* Print a table to standard output. c includes the rows that every command has. */
void help_print(const command_line *c, help_format format);

/* The help of vxs itself: a head, then each command in the format that help_part returns, then a tail.
 * format  HELP_TEXT to HELP_FISH */
void        help_print_head(help_format format);
help_format help_part(help_format format);
void        help_print_tail(help_format format);

#endif
