/* The vxs command: argv to a command, a command to an exit status.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>
#include <string.h>

#include "baker/base/version.h"
#include "baker/command/commands.h"
#include "baker/options/options.h"
#include "baker/process/process.h"

static const struct {
    const char *name;
    int (*run)(int argc, char **argv);
    const char *summary;
} commands[] = {
    {"bake", cmd_bake, "bake the shadows of a scene into a .vxs file"},
    {"plan", cmd_plan, "what a bake would do, what it would leave out, and why"},
    {"info", cmd_info, "what a .vxs file holds"},
    {"validate", cmd_validate, "check every byte of a .vxs file"},
    {"query", cmd_query, "answer 'how lit is this point?' from a .vxs file"},
    {"truth", cmd_truth, "answer the same question by ray tracing the scene"},
    {"compare", cmd_compare, "error, size and time of .vxs files against ray tracing"},
    {"bench", cmd_bench, "time, memory, size and error of bakes and lookups"},
    {"report", cmd_report, "a page with plots of what bench measured"},
    {"picture", cmd_picture, "a picture (PNG) of a scene with the shadows of a .vxs file"},
    {"health", cmd_health, "what is wrong with the meshes of a scene"},
    {"mend", cmd_mend, "write a scene with closed meshes, for smaller files"},
    {"scene", cmd_scene, "make a procedural test scene"},
};

enum { COMMAND_COUNT = sizeof commands / sizeof *commands };

static void print_usage(FILE *to)
{
    fprintf(to, "vxs %s: baked voxelized shadows\n\nusage: vxs COMMAND [arguments], vxs COMMAND --help\n\ncommands:\n",
            VXS_VERSION);
    for (int n = 0; n < COMMAND_COUNT; n++) fprintf(to, "  %-10s %s\n", commands[n].name, commands[n].summary);
}

int main(int argc, char **argv)
{
    message m = {0};
    process_begin();

    if (argc >= 2 && (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h") || !strcmp(argv[1], "help"))) {
        print_usage(stdout);
        return command_end(&m, VXS_OK);
    }
    if (argc >= 2 && !strcmp(argv[1], "--version")) {
        printf("vxs %s\n", VXS_VERSION);
        return command_end(&m, VXS_OK);
    }
    for (int n = 0; argc >= 2 && n < COMMAND_COUNT; n++)
        if (!strcmp(argv[1], commands[n].name)) return commands[n].run(argc - 1, argv + 1);

    if (argc < 2)
        fprintf(stderr, "vxs: error: no command given: vxs --help lists the commands\n");
    else
        fprintf(stderr, "vxs: error: unknown command '%s': vxs --help lists the commands\n", argv[1]);
    return exit_status(VXS_E_ARGUMENT);
}
