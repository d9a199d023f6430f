/* The commands of the laboratory, each in a file of its own; see laboratory.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LAB_COMMANDS_H
#define LAB_COMMANDS_H

int cmd_truth(int argc, char **argv);
int cmd_compare(int argc, char **argv);
int cmd_bench(int argc, char **argv);
int cmd_report(int argc, char **argv);
int cmd_render(int argc, char **argv);
int cmd_health(int argc, char **argv);
int cmd_mend(int argc, char **argv);
int cmd_scene(int argc, char **argv);

#endif
