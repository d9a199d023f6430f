/* Command-line options as a table; see options.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/options/options.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "baker/base/array.h"
#include "baker/measure/progress.h"

static void print_help(const command_line *c)
{
    printf("vxs %s %s\n\n%s\n", c->name, c->synopsis, c->summary);
    if (c->option_count) printf("\noptions:\n");
    for (size_t i = 0; i < c->option_count; i++) {
        const option *o = &c->options[i];
        char          left[96];
        if (o->kind == OPTION_GROUP) {
            printf("\n%s:\n", o->help);
            continue;
        }
        snprintf(left, sizeof left, "%s %s", o->name,
                 o->kind == OPTION_SWITCH   ? ""
                 : o->kind == OPTION_CHOICE ? o->choices
                                            : o->value);
        printf("  %-28s %s\n", left, o->help);
    }
}

static const option *find_option(const command_line *c, const char *name, size_t length)
{
    for (size_t i = 0; i < c->option_count; i++)
        if (c->options[i].name && strlen(c->options[i].name) == length && !memcmp(c->options[i].name, name, length))
            return &c->options[i];
    return NULL;
}

/* A finite number and the rest of the text, or NULL. */
static const char *parse_number(const char *text, double *number)
{
    char *end;
    errno   = 0;
    *number = strtod(text, &end);
    return end == text || !isfinite(*number) ? NULL : end;
}

/* "512M", "1.5GiB", "1000000": a whole number of bytes, at least 1. */
static int parse_bytes(const char *text, uint64_t *bytes)
{
    static const char units[] = "KMGT";
    double            number;
    const char       *at = text[0] >= '0' && text[0] <= '9' ? parse_number(text, &number) : NULL;
    if (!at) return 0;
    const char *unit = *at ? strchr(units, *at) : NULL;
    if (unit) number = ldexp(number, 10 * (int)(unit - units + 1));
    if (unit) at++;
    if (unit && *at == 'i') at++;
    if (*at == 'B') at++;
    if (*at || !(number >= 1) || number > 1e18) return 0;
    *bytes = (uint64_t)number;
    return 1;
}

static vxs_result set_vector(const option *o, const char *value, message *m)
{
    size_t      count = (size_t)o->max;
    double      numbers[16];
    const char *at = value;
    for (size_t i = 0; i < count; i++) {
        at = parse_number(at, &numbers[i]);
        if (!at || *at != (i + 1 < count ? ',' : '\0'))
            return fail(m, VXS_E_ARGUMENT, "%s %s: expected %zu numbers separated by commas", o->name, value, count);
        at++;
    }
    memcpy(o->target, numbers, count * sizeof *numbers);
    return VXS_OK;
}

static vxs_result parse_in_range(const option *o, const char *value, int whole, double *number, message *m)
{
    const char *end = parse_number(value, number);
    if (end && !*end && *number >= o->min && *number <= o->max && (!whole || *number == floor(*number))) return VXS_OK;
    int digits = whole ? 10 : 6; /* as many as a uint32_t may have; as many as %g has */
    return fail(m, VXS_E_ARGUMENT, "%s %s: expected a %snumber from %.*g to %.*g", o->name, value, whole ? "whole " : "", digits,
                o->min, digits, o->max);
}

static vxs_result set_u32(const option *o, const char *value, uint32_t *out, message *m)
{
    double     number;
    vxs_result r = parse_in_range(o, value, 1, &number, m);
    if (r == VXS_OK) *out = (uint32_t)number;
    return r;
}

static vxs_result add_number(const option *o, const char *value, message *m)
{
    number_list *list = o->target;
    uint32_t     number;
    vxs_result   r = set_u32(o, value, &number, m);
    if (r != VXS_OK) return r;
    for (size_t n = 0; n < list->count; n++)
        if (list->items[n] == number) return fail(m, VXS_E_ARGUMENT, "%s %s is given twice", o->name, value);
    if (list->count == OPTION_NUMBERS_MAX)
        return fail(m, VXS_E_ARGUMENT, "%s: expected at most %d of them", o->name, OPTION_NUMBERS_MAX);
    list->items[list->count++] = number;
    return VXS_OK;
}

static vxs_result add_text(const option *o, const char *value, message *m)
{
    text_list *list = o->target;
    if (!array_reserve(&list->items, &list->capacity, list->count + 1, sizeof *list->items))
        return fail(m, VXS_E_MEMORY, "out of memory while reading %s", o->name);
    list->items[list->count++] = value;
    return VXS_OK;
}

static vxs_result set_choice(const option *o, const char *value, message *m)
{
    int index = choice_index(o->choices, value);
    if (index < 0) return fail(m, VXS_E_ARGUMENT, "%s %s: expected one of %s", o->name, value, o->choices);
    *(int *)o->target = index;
    return VXS_OK;
}

static vxs_result set_option(const option *o, const char *value, message *m)
{
    switch (o->kind) {
    case OPTION_SWITCH: *(int *)o->target = 1; break;
    case OPTION_TEXT: *(const char **)o->target = value; break;
    case OPTION_VECTOR: return set_vector(o, value, m);
    case OPTION_TEXTS: return add_text(o, value, m);
    case OPTION_CHOICE: return set_choice(o, value, m);
    case OPTION_U32: return set_u32(o, value, o->target, m);
    case OPTION_U32S: return add_number(o, value, m);
    case OPTION_F64: return parse_in_range(o, value, 0, o->target, m);
    case OPTION_BYTES:
        if (!parse_bytes(value, o->target))
            return fail(m, VXS_E_ARGUMENT, "%s %s: expected a number of bytes, such as 800M or 2G", o->name, value);
        break;
    case OPTION_GROUP: break; /* has no name to be found by */
    }
    return VXS_OK;
}

static vxs_result parse(const command_line *c, int argc, char **argv, size_t operand_max, const char **operands, int *help_shown,
                        message *m)
{
    size_t found        = 0;
    int    options_over = 0;
    *help_shown         = 0;
    for (int i = 1; i < argc; i++) {
        const char *arg = argv[i];
        if (options_over || arg[0] != '-' || !arg[1]) {
            if (found == operand_max)
                return fail(m, VXS_E_ARGUMENT, "unexpected argument '%s': usage is vxs %s %s", arg, c->name, c->synopsis);
            operands[found++] = arg;
            continue;
        }
        if (!strcmp(arg, "--")) {
            options_over = 1;
            continue;
        }
        if (!strcmp(arg, "--help") || !strcmp(arg, "-h")) {
            print_help(c);
            *help_shown = 1;
            return VXS_OK;
        }

        const char   *equals = arg[1] == '-' ? strchr(arg, '=') : NULL;
        const option *o      = find_option(c, arg, equals ? (size_t)(equals - arg) : strlen(arg));
        if (!o) return fail(m, VXS_E_ARGUMENT, "unknown option '%s': vxs %s --help lists the options", arg, c->name);
        const char *value = equals ? equals + 1 : NULL;
        if (o->kind == OPTION_SWITCH) {
            if (value) return fail(m, VXS_E_ARGUMENT, "%s takes no value", o->name);
        } else if (!value) {
            if (++i == argc)
                return fail(m, VXS_E_ARGUMENT, "%s needs a value: %s", o->name, o->kind == OPTION_CHOICE ? o->choices : o->value);
            value = argv[i];
        }
        vxs_result r = set_option(o, value, m);
        if (r != VXS_OK) return r;
        if (o->given) *o->given = 1;
    }
    if (found < c->operand_count) return fail(m, VXS_E_ARGUMENT, "too few arguments: usage is vxs %s %s", c->name, c->synopsis);
    return VXS_OK;
}

vxs_result options_parse(const command_line *c, int argc, char **argv, const char **operands, int *help_shown, message *m)
{
    return parse(c, argc, argv, c->operand_count, operands, help_shown, m);
}

vxs_result options_parse_repeated(const command_line *c, int argc, char **argv, const char **operands, int *help_shown, message *m)
{
    return parse(c, argc, argv, SIZE_MAX, operands, help_shown, m);
}

vxs_result outputs_check_apart(const char *a, const char *a_path, const char *b, const char *b_path, message *m)
{
    struct stat a_status, b_status;
    if (!a_path || !b_path) return VXS_OK;
    int is_same = !strcmp(a_path, b_path);
    if (is_same && is_standard_output(a_path))
        return fail(m, VXS_E_ARGUMENT, "%s - and %s - exclude each other: both would go to standard output", a, b);
    if (!is_same && !is_standard_output(a_path) && !is_standard_output(b_path) && !stat(a_path, &a_status) &&
        !stat(b_path, &b_status))
        is_same = S_ISREG(a_status.st_mode) && a_status.st_dev == b_status.st_dev && a_status.st_ino == b_status.st_ino;
    return is_same ? fail(m, VXS_E_ARGUMENT, "%s and %s are both %s: expected two names", a, b, b_path) : VXS_OK;
}

int command_end(message *m, vxs_result code)
{
    /* what was printed counts as written only when it has arrived */
    if ((fflush(stdout) || ferror(stdout)) && code == VXS_OK)
        code = fail(m, VXS_E_WRITE, "standard output: cannot be written: %s", strerror(errno));
    progress_clear();
    if (code != VXS_OK) fprintf(stderr, "vxs: error: %s\n", m->error[0] ? m->error : "unknown");
    message_free(m);
    return exit_status(code);
}

int command_run(const command_line *c, int argc, char **argv, const char **operands, vxs_result (*run)(void *command, message *m),
                void *command)
{
    message    m = {0};
    int        help_shown;
    vxs_result r = options_parse(c, argc, argv, operands, &help_shown, &m);
    if (r == VXS_OK && !help_shown) r = run(command, &m);
    for (size_t i = 0; i < c->option_count; i++)
        if (c->options[i].kind == OPTION_TEXTS) free(((text_list *)c->options[i].target)->items);
    return command_end(&m, r);
}
