/* Manual pages, for man(1).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef HELP_MAN_H
#define HELP_MAN_H

#include "baker/command/options/option_table.h"

/* Print the page of a command, vxs-bake(1), to standard output. */
void man_page(const command_line *c);

/* The page vxs(1): the part before the list of commands, one command of the list, and the part after it. */
void man_head(void);
void man_row(const command_line *c);
void man_tail(void);

#endif
