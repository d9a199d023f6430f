/* The commands of vxs, each in a file of its own.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COMMANDS_H
#define COMMANDS_H

struct square_exchange;

/* argv[0] is the command's own name; the result is the exit status (docs/manual.md). */
int cmd_bake(int argc, char **argv);
int cmd_bake_with(const struct square_exchange *others, int argc, char **argv); /* together with other processes that make
                                                                                   squares of it */
int cmd_merge(int argc, char **argv);
int cmd_info(int argc, char **argv);
int cmd_validate(int argc, char **argv);
int cmd_query(int argc, char **argv);
int cmd_plan(int argc, char **argv);
int cmd_view(int argc, char **argv);
int cmd_export(int argc, char **argv);

#endif
