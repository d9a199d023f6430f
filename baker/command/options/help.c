/* Help from a command's table; see help.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/options/help.h"

#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "baker/base/version.h"
#include "baker/command/options/complete.h"
#include "baker/command/options/help_man.h"
#include "baker/command/options/option_text.h"

/* Column of the options' texts, and the minimum width for them. */
enum { TEXT_COLUMN = 26, TEXT_ROOM_MIN = 30 };

/* Width of the terminal in columns; 80 without a terminal. */
static int line_width(void)
{
    struct winsize size;
    int            known = !ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) && size.ws_col > 0;
    return !known ? 80 : size.ws_col < TEXT_COLUMN + TEXT_ROOM_MIN ? TEXT_COLUMN + TEXT_ROOM_MIN : size.ws_col;
}

/* Print words wrapped to the width; the first line starts at a column that is already reached. */
static void print_wrapped(const char *text, int indent)
{
    int width = line_width(), column = indent;
    while (*(text += strspn(text, " "))) {
        int length = (int)strcspn(text, " "), breaks = column > indent && column + 1 + length > width;
        if (breaks) printf("\n%*s", indent, "");
        if (!breaks && column > indent) putchar(' ');
        column = (breaks ? indent : column + (column > indent)) + length;
        printf("%.*s", length, text);
        text += length;
    }
    putchar('\n');
}

static void print_row(const char *left, const char *text)
{
    int length = printf("  %s", left);
    if (length + 2 > TEXT_COLUMN) length = (putchar('\n'), 0);
    printf("%*s", TEXT_COLUMN - length, "");
    print_wrapped(text, TEXT_COLUMN);
}

/* Print the operands, or the options, each group under its heading. */
static void print_rows(const command_line *c, int operands, const char *heading)
{
    char left[96];
    for (const option *o = c->options; o < c->options + c->option_count; o++) {
        if (o->kind == OPTION_GROUP) heading = o->help;
        if (o->kind == OPTION_GROUP || is_operand(o) != operands) continue;
        if (heading) printf("\n%s:\n", heading);
        heading = NULL;
        print_row(option_usage(left, o), o->help);
    }
}

static void print_text(const command_line *c)
{
    printf("vxs %s %s\n\n", c->name, c->synopsis);
    print_wrapped(c->summary, 0);
    print_rows(c, 1, "operands");
    print_rows(c, 0, "options");
}

void help_print(const command_line *c, help_format format)
{
    char phrase[128];
    switch (format) {
    case HELP_TEXT: print_text(c); break;
    case HELP_TEXT_ROW: printf("  %-10s %s\n", c->name, summary_phrase(phrase, c->summary)); break;
    case HELP_MAN: man_page(c); break;
    case HELP_MAN_ROW: man_row(c); break;
    default: complete_part((shell)(format - HELP_BASH), c);
    }
}

void help_print_head(help_format format)
{
    if (format == HELP_MAN)
        man_head();
    else if (format != HELP_TEXT)
        complete_head((shell)(format - HELP_BASH));
    else
        printf(
            "vxs %s: baked voxelized shadows\n\nusage: vxs COMMAND [arguments]\n       vxs help COMMAND\n       vxs --version\n\n"
            "commands:\n",
            VXS_VERSION);
}

help_format help_part(help_format format)
{
    return format == HELP_TEXT ? HELP_TEXT_ROW : format == HELP_MAN ? HELP_MAN_ROW : format;
}

void help_print_tail(help_format format)
{
    if (format == HELP_MAN)
        man_tail();
    else if (format != HELP_TEXT)
        complete_tail((shell)(format - HELP_BASH));
}
