/* The vxs command: argv to a command, a command to an exit status.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "baker/base/nearest.h"
#include "baker/base/parallel.h"
#include "baker/base/version.h"
#include "baker/command/commands.h"
#include "baker/command/options/help.h"
#include "baker/command/options/laboratory.h"
#include "baker/command/options/options.h"
#include "baker/command/process/process.h"

static const command_entry commands[] = {
    {"bake", cmd_bake},   {"plan", cmd_plan}, {"merge", cmd_merge},   {"info", cmd_info}, {"validate", cmd_validate},
    {"query", cmd_query}, {"view", cmd_view}, {"export", cmd_export}, {NULL, NULL},
};

/* Command after c: the product's commands first, then the laboratory's. c NULL: the first one. Returns NULL after the last. */
static const command_entry *next_command(const command_entry *c)
{
    c = c ? c + 1 : commands;
    if (c == commands + sizeof commands / sizeof *commands - 1) c = linked_laboratory.commands;
    return c->name ? c : NULL;
}

/* Help of vxs itself: a head, the part that each command prints, and a tail. */
static int print_help(const char *format_word)
{
    run_context m      = {0};
    int         format = choice_index(HELP_FORMATS_OF_ALL, format_word), status = 0;
    char        part[32], part_option[sizeof part + sizeof "--help="];
    if (format < 0)
        return command_end(&m, fail(&m, VXS_E_ARGUMENT, "--help %s: expected one of %s", format_word, HELP_FORMATS_OF_ALL));
    snprintf(part_option, sizeof part_option, "--help=%s", choice_word(part, HELP_FORMATS, help_part(format)));
    help_print_head(format);
    for (const command_entry *c = NULL; !status && (c = next_command(c));)
        status = c->run(2, (char *[]){(char *)c->name, part_option, NULL});
    if (!status) help_print_tail(format);
    return status ? status : command_end(&m, VXS_OK);
}

static int unknown_command(const char *name)
{
    run_context m    = {0};
    nearest     near = {.typed = name};
    char        meant[64];
    for (const command_entry *c = NULL; (c = next_command(c));) nearest_try(&near, c->name, strlen(c->name));
    nearest_try(&near, "help", strlen("help"));
    nearest_try(&near, "version", strlen("version"));
    return command_end(&m, fail(&m, VXS_E_ARGUMENT, "unknown command '%s'%s%s vxs --help lists the commands", name,
                                nearest_text(meant, &near), near.word ? "" : ":"));
}

static int run(int argc, char **argv)
{
    run_context m    = {0};
    const char *name = argc >= 2 ? argv[1] : "";
    if (argc < 2) {
        /* the list of commands is the error message, so it goes to standard error */
        dup2(STDERR_FILENO, STDOUT_FILENO);
        print_help("text");
        return exit_status(VXS_E_ARGUMENT);
    }
    if (!strcmp(name, "help") && argc > 3)
        return command_end(&m, fail(&m, VXS_E_ARGUMENT, "unexpected argument '%s': usage is vxs help COMMAND", argv[3]));
    if (!strcmp(name, "help") && argc == 3 && argv[2][0] != '-') { /* vxs help COMMAND is vxs COMMAND --help */
        name    = argv[2];
        argv[1] = argv[2];
        argv[2] = "--help";
    }
    if (!strcmp(name, "--help") || !strcmp(name, "-h") || !strcmp(name, "help")) return print_help("text");
    if (!strncmp(name, "--help=", strlen("--help="))) return print_help(strchr(name, '=') + 1);
    if (!strcmp(name, "--version") || !strcmp(name, "version") || !strcmp(name, "-V") || !strcmp(name, "-v")) {
        if (argc > 2) return command_end(&m, fail(&m, VXS_E_ARGUMENT, "unexpected argument '%s': usage is vxs --version", argv[2]));
        printf("vxs %s\n", VXS_VERSION);
        return command_end(&m, VXS_OK);
    }
    for (const command_entry *c = NULL; (c = next_command(c));)
        if (!strcmp(name, c->name)) return c->run(argc - 1, argv + 1);
    return unknown_command(name);
}

static int run_with_threads(int argc, char **argv)
{
    thread_pool *pool   = parallel_keep_threads();
    int          status = run(argc, argv);
    parallel_end_threads(pool);
    return status;
}

int main(int argc, char **argv)
{
    return process_run(run_with_threads, argc, argv);
}
