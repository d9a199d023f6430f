/* Help from a command's table; see help.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/options/help.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "baker/base/embedded.h"
#include "baker/base/version.h"
#include "baker/command/options/option_table.h"

/* The value that follows an option's name in help: "N", "auto|on|off"; NULL for switches and operands. */
static const char *option_value(const option *o)
{
    return o->kind == OPTION_CHOICE && !is_operand(o) ? o->choices : o->value;
}

/* "--resolution N", "--camera", "SCENE" into text. Returns text. */
static const char *option_usage(char text[96], const option *o)
{
    const char *value = option_value(o);
    snprintf(text, 96, "%s%s%s", o->name, value ? " " : "", value ? value : "");
    return text;
}

/* "bake the shadows of a scene": the first sentence of a summary without its period, in lower case, into text. Returns text. */
static const char *summary_phrase(char text[128], const char *summary)
{
    const char *end = strstr(summary, ". ");
    snprintf(text, 128, "%.*s", (int)(end ? end - summary : (long)strlen(summary) - 1), summary);
    text[0] = (char)tolower((unsigned char)text[0]);
    return text;
}

/* Completion of command lines by shells.
 *
 * A script is a head, a part for each command, and a tail: the functions that read the parts, from the files completion.*. */

typedef enum shell { SHELL_BASH, SHELL_ZSH, SHELL_FISH } shell;

EMBEDDED(completion_bash)
EMBEDDED(completion_zsh)
EMBEDDED(completion_fish)

/* values of a row -------------------------------------------------------------------------------------------------------------- */

static int is_switch(const option *o)
{
    return o->kind == OPTION_SWITCH || o->kind == OPTION_HELP;
}

static int is_file(const option *o)
{
    return o->kind == OPTION_INPUT || o->kind == OPTION_INPUTS || o->kind == OPTION_OUTPUT;
}

/* "auto|on|off", or NULL. Rows of OPTION_TEXT may have choices, too; their values are parsed later. */
static const char *choices_of(const option *o)
{
    if (o->kind == OPTION_CHOICE) return o->choices;
    return o->value && strchr(o->value, '|') ? o->value : NULL;
}

/* The file extensions of an option's value, "glb|gltf", from its value word, such as FILE.vxs; "" for any. */
static const char *extensions_of(const option *o)
{
    const char *name = is_operand(o) ? o->name : o->value, *dot = strrchr(name, '.');
    return !strcmp(name, "SCENE") ? "glb|gltf" : dot ? dot + 1 : "";
}

/* Print "auto|on|off" with a text before each word. */
static void print_words(const char *before, const char *words)
{
    while (*words) {
        int length = (int)strcspn(words, "|");
        printf("%s%.*s", before, length, words);
        words += length + (words[length] == '|');
    }
}

/* bash: arrays of values, by the option's name or the operand's number --------------------------------------------------------- */

static void bash_part(const command_line *c)
{
    int operands = 0;
    printf("_vxs_names[%s]='", c->name);
    for (const option *o = c->options; o < c->options + c->option_count; o++)
        if (o->name && !is_operand(o)) printf(" %s", o->name);
    printf("'\n");
    for (const option *o = c->options; o < c->options + c->option_count; o++) {
        char number[16];
        if (is_operand(o)) snprintf(number, sizeof number, is_list(o) ? "more" : "%d", operands++);
        if (o->name) {
            const char *key = is_operand(o) ? number : o->name;
            printf("_vxs_values['%s %s']='", c->name, key);
            if (choices_of(o))
                print_words(" ", choices_of(o));
            else if (is_file(o))
                printf("files"), print_words(" ", extensions_of(o));
            else if (!is_switch(o))
                printf("text");
            printf("'\n");
        }
    }
}

/* zsh: a function for each command, with arguments for _arguments -------------------------------------------------------------- */

static void zsh_value(const option *o, const char *name)
{
    if (is_switch(o)) return;
    printf(":%s:", name);
    if (choices_of(o))
        printf("("), print_words(" ", choices_of(o)), printf(")");
    else if (is_file(o) && *extensions_of(o))
        printf("_files -g \"*.(%s)(-.)\"", extensions_of(o));
    else
        printf("%s", is_file(o) ? "_files" : " ");
}

static void zsh_part(const command_line *c)
{
    char phrase[128];
    int  operands = 0;
    printf("_vxs_commands+=('%s:", c->name);
    print_quoted(stdout, summary_phrase(phrase, c->summary), ":\\");
    printf("')\n_vxs_%s()\n{\n    _arguments -S", c->name);
    for (const option *o = c->options; o < c->options + c->option_count; o++) {
        if (!o->name) continue;
        printf(" \\\n        '");
        if (is_operand(o)) {
            if (is_list(o))
                printf("*");
            else
                printf(operand_is_optional(o) ? "%d:" : "%d", ++operands);
            zsh_value(o, o->name);
        } else {
            printf("%s%s%s[", is_list(o) ? "*" : "", o->name, is_switch(o) || o->name[1] != '-' ? "" : "=");
            print_quoted(stdout, o->help, "[]:\\");
            printf("]");
            zsh_value(o, choices_of(o) ? o->name + 2 : o->value);
        }
        printf("'");
    }
    printf("\n}\n");
}

/* fish: calls of complete ------------------------------------------------------------------------------------------------------ */

static void fish_part(const command_line *c)
{
    char phrase[128];
    printf("complete -c vxs -n __vxs_needs_command -a %s -d '", c->name);
    print_quoted(stdout, summary_phrase(phrase, c->summary), "\\");
    printf("'\n");
    for (const option *o = c->options; o < c->options + c->option_count; o++) {
        if (!o->name) continue;
        printf("complete -c vxs -n '__vxs_is %s'", c->name);
        if (!is_operand(o)) {
            printf(" -%c %s -d '", o->name[1] == '-' ? 'l' : 's', o->name + (o->name[1] == '-' ? 2 : 1));
            print_quoted(stdout, o->help, "\\");
            printf("'");
        }
        if (choices_of(o) && !is_switch(o)) {
            printf(" -x -a '"), print_words(" ", choices_of(o)), printf("'");
        } else if (is_file(o) && *extensions_of(o)) {
            printf(" -x -a '(__vxs_files \"%s\")'", extensions_of(o));
        } else if (!is_switch(o)) {
            printf(is_file(o) ? " -r -F" : " -x");
        }
        printf("\n");
    }
}

/* functions of each shell ------------------------------------------------------------------------------------------------------ */

static const struct {
    const char *name, *first, *begin;
    void (*part)(const command_line *c);
    const embedded *tail;
} shells[] = {
    {"bash", "", "declare -A _vxs_names=() _vxs_values=()\n", bash_part, &completion_bash},
    {"zsh", "#compdef vxs\n", "local -a _vxs_commands\n", zsh_part, &completion_zsh},
    {"fish", "", "complete -c vxs -e\ncomplete -c vxs -f\n", fish_part, &completion_fish},
};

/* docs/manual.md describes the same statuses in more detail. */
static const struct {
    int         status;
    const char *meaning;
} statuses[] = {
    {0, "Done."},
    {1, "It worked, and what it looked at is wrong; with --strict, a warning."},
    {2, "The command line is wrong, or names a light or scene that does not exist."},
    {3, "An input cannot be read: no such file, of another kind, or broken."},
    {4, "An output cannot be written."},
    {5, "There is nothing to bake: no triangle, no light, or none that reaches a triangle."},
    {6, "Not enough memory, or no OpenGL."},
    {130, "Interrupted (SIGINT)."},
    {141, "The reader of answers of query or truth has gone."},
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

static void print_tagged(const option *o)
{
    printf(".TP\n");
    printf("\\fB");
    print_escaped(o->name);
    printf("\\fR");
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

/* Print the page of a command, vxs-bake(1), to standard output. */
static void man_page(const command_line *c)
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

static void man_row(const command_line *c)
{
    char phrase[128];
    printf(".TP\n.BR vxs\\-%s (1)\n", c->name);
    print_line(summary_phrase(phrase, c->summary));
}

/* Column of the options' texts, and the minimum width for them. */
enum { TEXT_COLUMN = 26, TEXT_ROOM_MIN = 30 };

/* Print words wrapped to the width; the first line starts at a column that is already reached. */
static void print_wrapped(const char *text, int indent)
{
    /* width of the terminal in columns; 80 without a terminal */
    struct winsize size;
    int            known = !ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) && size.ws_col > 0, column = indent;
    int            width = !known ? 80 : size.ws_col < TEXT_COLUMN + TEXT_ROOM_MIN ? TEXT_COLUMN + TEXT_ROOM_MIN : size.ws_col;
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

void help_print(const command_line *c, help_format format)
{
    char phrase[128];
    switch (format) {
    case HELP_TEXT: {
        printf("vxs %s %s\n\n", c->name, c->synopsis);
        print_wrapped(c->summary, 0);
        print_rows(c, 1, "operands");
        print_rows(c, 0, "options");
    } break;
    case HELP_TEXT_ROW: printf("  %-10s %s\n", c->name, summary_phrase(phrase, c->summary)); break;
    case HELP_MAN: man_page(c); break;
    case HELP_MAN_ROW: man_row(c); break;
    default: shells[format - HELP_BASH].part(c);
    }
}

void help_print_head(help_format format)
{
    if (format == HELP_MAN) {
        /* The page vxs(1): the part before the list of commands, one command of the list, and the part after it. */
        print_title("vxs");
        printf(".SH NAME\nvxs \\- baked voxelized shadows\n"
               ".SH SYNOPSIS\n.B vxs\n.I command\n.RI [ arguments ]\n.br\n.B vxs help\n.RI [ command ]\n.br\n.B vxs \\-\\-version\n"
               ".SH DESCRIPTION\nBakes the shadows of static geometry into a small file, and answers from it how lit a point is.\n"
               "Operands and options may come in any order; \\fB\\-\\-\\fR ends the options.\n"
               "A file \\fB\\-\\fR is standard output where it is written.\n"
               "Scenes are glTF 2.0; positions are in metres, and directions of light are the way the light travels.\n"
               ".SH COMMANDS\n");
    } else if (format != HELP_TEXT) {
        int s = (int)format - HELP_BASH;
        printf("%s# Completion of command lines for vxs %s: made by vxs --help=%s\n%s", shells[s].first, VXS_VERSION,
               shells[s].name, shells[s].begin);
    } else
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
    if (format == HELP_MAN) {
        printf(".SH OPTIONS\n.TP\n.B \\-\\-help\nThe list of commands; after a command, what the command takes.\n"
               ".TP\n.B \\-\\-help=man\nThis page; after a command, the page of that command.\n"
               ".TP\n.BR \\-\\-help=bash \", \" \\-\\-help=zsh \", \" \\-\\-help=fish\nA script of completion for that shell.\n"
               ".TP\n.B \\-\\-version\nThe version.\n");
        print_statuses();
        printf(
            ".SH EXAMPLES\n.nf\nvxs scene city \\-o city.glb\nvxs bake city.glb \\-o city.vxs\nvxs render city.glb city.vxs \\-o "
            "city.png\n.fi\n"
            ".SH SEE ALSO\nThe page of each command, and manual.md, which is installed among the documents of vxs.\n");
    } else if (format != HELP_TEXT) {
        embedded_print(stdout, *shells[format - HELP_BASH].tail);
    }
}
