/* Completion of command lines by shells; see complete.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/options/complete.h"

#include <stdio.h>
#include <string.h>

#include "baker/base/embedded.h"
#include "baker/base/version.h"
#include "baker/command/options/option_text.h"

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

static void bash_value(const command_line *c, const option *o, const char *key)
{
    printf("_vxs_values['%s %s']='", c->name, key);
    if (choices_of(o))
        print_words(" ", choices_of(o));
    else if (is_file(o))
        printf("files"), print_words(" ", extensions_of(o));
    else if (!is_switch(o))
        printf("text");
    printf("'\n");
}

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
        if (o->name) bash_value(c, o, is_operand(o) ? number : o->name);
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
                printf("%d", ++operands);
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

static void fish_value(const option *o)
{
    if (is_switch(o)) return;
    if (choices_of(o)) {
        printf(" -x -a '"), print_words(" ", choices_of(o)), printf("'");
    } else if (is_file(o) && *extensions_of(o)) {
        printf(" -x -a '(__vxs_files \"%s\")'", extensions_of(o));
    } else {
        printf(is_file(o) ? " -r -F" : " -x");
    }
}

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
        fish_value(o);
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

void complete_head(shell s)
{
    printf("%s# Completion of command lines for vxs %s: made by vxs --help=%s\n%s", shells[s].first, VXS_VERSION, shells[s].name,
           shells[s].begin);
}

void complete_part(shell s, const command_line *c)
{
    shells[s].part(c);
}

void complete_tail(shell s)
{
    embedded_print(stdout, *shells[s].tail);
}
