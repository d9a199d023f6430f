/* Manual pages; see help_man.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/options/help_man.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "baker/base/version.h"
#include "baker/command/options/option_text.h"

/* docs/manual.md describes the same statuses in more detail. */
static const struct {
    int         status;
    const char *meaning;
} statuses[] = {
    {0, "Done."},
    {1, "It worked, and what it looked at is wrong; with --strict, a warning."},
    {2, "The command line is wrong, or asks for a light or scene that is not there."},
    {3, "An input cannot be read: no such file, of another kind, or broken."},
    {4, "An output cannot be written."},
    {5, "There is nothing to bake: no triangle, no light, or none that reaches a triangle."},
    {6, "Not enough memory, or no OpenGL."},
    {130, "Interrupted (SIGINT)."},
    {141, "Nobody reads the answers of query or truth any more."},
};

/* Print text literally: escape dashes, which would become hyphens, and marks that start roff requests. */
static void print_escaped(const char *text)
{
    if (*text == '.' || *text == '\'') fputs("\\&", stdout);
    for (; *text; text++) {
        switch (*text) {
        case '-': fputs("\\-", stdout); break;
        case '\\': fputs("\\(rs", stdout); break;
        case '`': fputs("\\(ga", stdout); break;
        case '\'': fputs("\\(aq", stdout); break;
        case '^': fputs("\\(ha", stdout); break;
        case '~': fputs("\\(ti", stdout); break;
        default: putchar(*text);
        }
    }
}

static void print_line(const char *text)
{
    print_escaped(text);
    putchar('\n');
}

/* The date is empty: the program does not know its release date. A package may add it. */
static void print_title(const char *page)
{
    printf(".TH ");
    for (; *page; page++) putchar(toupper((unsigned char)*page));
    printf(" 1 \"\" \"vxs %s\" \"vxs manual\"\n", VXS_VERSION);
}

static void print_bold(const char *text)
{
    printf("\\fB");
    print_escaped(text);
    printf("\\fR");
}

static void print_tagged(const option *o)
{
    printf(".TP\n");
    print_bold(o->name);
    if (option_value(o)) {
        printf(" \\fI");
        print_escaped(option_value(o));
        printf("\\fR");
    }
    putchar('\n');
    print_line(o->help);
}

static void print_statuses(void)
{
    printf(".SH EXIT STATUS\n");
    for (size_t n = 0; n < sizeof statuses / sizeof *statuses; n++) {
        printf(".TP\n.B %d\n", statuses[n].status);
        print_line(statuses[n].meaning);
    }
}

void man_page(const command_line *c)
{
    char page[32], phrase[128];
    snprintf(page, sizeof page, "vxs-%s", c->name);
    print_title(page);
    printf(".SH NAME\n");
    print_escaped(page);
    printf(" \\- ");
    print_line(summary_phrase(phrase, c->summary));
    printf(".SH SYNOPSIS\n.B vxs %s\n", c->name);
    print_line(c->synopsis);
    printf(".SH DESCRIPTION\n");
    print_line(c->summary);
    printf(".SH OPERANDS\n");
    for (const option *o = c->options; o < c->options + c->option_count; o++)
        if (is_operand(o)) print_tagged(o);
    printf(".SH OPTIONS\n");
    for (const option *o = c->options; o < c->options + c->option_count; o++) {
        if (o->kind == OPTION_GROUP)
            printf(".SS %c%s\n", toupper((unsigned char)o->help[0]), o->help + 1);
        else if (!is_operand(o))
            print_tagged(o);
    }
    print_statuses();
    printf(".SH SEE ALSO\n.BR vxs (1)\n.PP\nThe manual, manual.md, is installed among the documents of vxs.\n");
}

void man_row(const command_line *c)
{
    char phrase[128];
    printf(".TP\n.BR vxs\\-%s (1)\n", c->name);
    print_line(summary_phrase(phrase, c->summary));
}

void man_head(void)
{
    print_title("vxs");
    printf(".SH NAME\nvxs \\- baked voxelized shadows\n"
           ".SH SYNOPSIS\n.B vxs\n.I command\n.RI [ arguments ]\n.br\n.B vxs help\n.RI [ command ]\n.br\n.B vxs \\-\\-version\n"
           ".SH DESCRIPTION\nBakes the shadows of static geometry into a small file, and answers from it how lit a point is.\n"
           "Operands and options may come in any order; \\fB\\-\\-\\fR ends the options.\n"
           "A file \\fB\\-\\fR is standard output where it is written.\n"
           "Scenes are glTF 2.0; positions are in metres, and directions of light are the way the light travels.\n"
           ".SH COMMANDS\n");
}

void man_tail(void)
{
    printf(".SH OPTIONS\n.TP\n.B \\-\\-help\nThe list of commands; after a command, what the command takes.\n"
           ".TP\n.B \\-\\-help=man\nThis page; after a command, the page of that command.\n"
           ".TP\n.BR \\-\\-help=bash \", \" \\-\\-help=zsh \", \" \\-\\-help=fish\nA script of completion for that shell.\n"
           ".TP\n.B \\-\\-version\nThe version.\n");
    print_statuses();
    printf(".SH EXAMPLES\n.nf\nvxs scene city \\-o city.glb\nvxs bake city.glb \\-o city.vxs\nvxs render city.glb city.vxs \\-o "
           "city.png\n.fi\n"
           ".SH SEE ALSO\nThe page of each command, and manual.md, which is installed among the documents of vxs.\n");
}
