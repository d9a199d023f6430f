/* Parsing the command line of a command; see options.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/options/options.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/nearest.h"
#include "baker/command/options/help.h"
#include "baker/command/process/process.h"
#include "baker/files/run_files.h"

/* The exit status of a command that ran, but found something wrong. */
enum { STATUS_WRONG = 1 };

/* Print one line, between lines of progress. */
static void print_line(vxs_severity severity, const char *text, void *user)
{
    const run_context *m        = user;
    int                is_error = severity == VXS_SEVERITY_ERROR;
    char               word[COLORED_BYTES];
    progress_clear();
    fprintf(stderr, "vxs: %s: %s\n",
            colored(word, m->color, stderr, is_error ? COLOR_RED : COLOR_YELLOW, is_error ? "error" : "warning"), text);
}

int command_end(run_context *m, vxs_result code)
{
    /* a flush can fail: output is written only after it succeeds. A reader that has closed the pipe is no error here
     * (output_file.h) */
    if ((fflush(stdout) || ferror(stdout)) && code == VXS_OK && !standard_output_is_broken())
        code = fail(m, VXS_E_WRITE, "standard output: cannot be written: %s", strerror(errno));
    progress_clear();
    if (code != VXS_OK && code != VXS_E_BROKEN_PIPE) print_line(VXS_SEVERITY_ERROR, m->error[0] ? m->error : "unknown", m);
    /* STATUS_WRONG, even if the run stopped at its finding; except if it failed to write the report */
    int status = m->wrong && code != VXS_E_WRITE ? STATUS_WRONG : exit_status(code);
    run_free(m);
    return status;
}

int command_run(const command_line *c, int argc, char **argv, vxs_result (*run)(void *command, run_context *m), void *command)
{
    run_files   files = {0};
    run_context m     = {.log = print_line, .log_user = &m, .files = &files, .temporary = process_temporary_files()};
    int         help_shown;
    vxs_result  r = options_parse(c, argc, argv, &help_shown, &m);
    if (r == VXS_OK && !help_shown) r = options_check_files(c, &m);
    if (r == VXS_OK && !help_shown && (r = run(command, &m)) == VXS_OK && (r = run_check(&m)) == VXS_OK)
        options_warn_of_names(c, &m);
    options_free(c);
    run_files_free(&files);
    return command_end(&m, r);
}

/* Options of every command, after its own rows. */
enum { COMMON_OPTIONS = 8 };

static const option *find_option(const command_line *c, const char *name, size_t length)
{
    for (size_t i = 0; i < c->option_count; i++)
        if (c->options[i].name && strlen(c->options[i].name) == length && !memcmp(c->options[i].name, name, length))
            return &c->options[i];
    return NULL;
}

/* The next operand's row after `last` (NULL at first); NULL when there is none. */
static const option *next_operand(const command_line *c, const option *last)
{
    if (last && is_list(last)) return last;
    for (const option *o = last ? last + 1 : c->options; o < c->options + c->option_count; o++)
        if (is_operand(o)) return o;
    return NULL;
}

/* Parse a finite number. Returns the rest of the text, or NULL. */
static const char *parse_number(const char *text, double *number)
{
    char *end;
    errno   = 0;
    *number = strtod(text, &end);
    return end == text || !isfinite(*number) ? NULL : end;
}

/* Parse "512M", "1.5GiB", "1000000": a whole number of bytes, at least 1. */
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

/* The value of NAME=VALUE: after the last '=', since a name may contain one and a number cannot. */
static const char *behind_name(const option *o, const char *text)
{
    const char *equals = is_named(o) ? strrchr(text, '=') : NULL;
    return equals ? equals + 1 : text;
}

static vxs_result set_vector(const option *o, const char *value, double *out, run_context *m)
{
    size_t      count = (size_t)o->max;
    double      numbers[16];
    const char *at = behind_name(o, value);
    for (size_t i = 0; i < count; i++) {
        at = parse_number(at, &numbers[i]);
        if (!at || *at != (i + 1 < count ? ',' : '\0'))
            return fail(m, VXS_E_ARGUMENT, "%s %s: expected %zu numbers separated by commas", o->name, value, count);
        at++;
    }
    memcpy(out, numbers, count * sizeof *numbers);
    return VXS_OK;
}

static vxs_result parse_in_range(const option *o, const char *value, int whole, double *number, run_context *m)
{
    const char *end = parse_number(behind_name(o, value), number);
    if (o->kind == OPTION_NAMED_U32 && end && (*end == 'K' || *end == 'k')) { /* "4K" is 4096, for texels, powers of two */
        *number *= 1024;
        end++;
    }
    if (end && !*end && *number >= o->min && *number <= o->max && (!whole || *number == floor(*number))) return VXS_OK;
    int digits = whole ? 10 : 6; /* digits of the largest uint32_t; digits of %g */
    return fail(m, VXS_E_ARGUMENT, "%s %s: expected a %snumber from %.*g to %.*g", o->name, value, whole ? "whole " : "", digits,
                o->min, digits, o->max);
}

static vxs_result set_u32(const option *o, const char *value, uint32_t *out, run_context *m)
{
    double     number;
    vxs_result r = parse_in_range(o, value, 1, &number, m);
    if (r == VXS_OK) *out = (uint32_t)number;
    return r;
}

static vxs_result add_number(const option *o, const char *value, run_context *m)
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

static vxs_result add_named(const option *o, const char *text, run_context *m)
{
    named_list  *list   = o->target;
    size_t       length = (size_t)(behind_name(o, text) - text);
    named_value *item;
    if (length == 1) return fail(m, VXS_E_ARGUMENT, "%s %s: expected a name before the '=', or none", o->name, text);
    if (!array_reserve(&list->items, &list->capacity, list->count + 1, sizeof *list->items)) goto no_memory;
    item  = &list->items[list->count];
    *item = (named_value){0};
    if (length && !(item->name = strndup(text, length - 1))) goto no_memory;
    if (!length && o->choices && !(item->name = strdup(o->choices))) goto no_memory;
    list->count++; /* from here on, the list releases it */
    if (named_find(list, item->name) != item)
        return item->name ? fail(m, VXS_E_ARGUMENT, "%s is given twice for '%s': expected once", o->name, item->name)
                          : fail(m, VXS_E_ARGUMENT, "%s is given twice without a name: expected once", o->name);
    if (o->kind == OPTION_NAMED_VECTOR) return set_vector(o, text, item->numbers, m);
    return parse_in_range(o, text, o->kind == OPTION_NAMED_U32, item->numbers, m);
no_memory:
    return fail(m, VXS_E_MEMORY, "out of memory while reading %s", o->name);
}

static vxs_result set_option(const option *o, const char *value, run_context *m)
{
    switch (o->kind) {
    case OPTION_SWITCH: *(int *)o->target = 1; break;
    case OPTION_TEXT:
    case OPTION_INPUT:
    case OPTION_FOLDER:
    case OPTION_OUTPUT: *(const char **)o->target = value; break;
    case OPTION_VECTOR: return set_vector(o, value, o->target, m);
    case OPTION_TEXTS:
    case OPTION_INPUTS: {
        text_list *list = o->target;
        if (!array_reserve(&list->items, &list->capacity, list->count + 1, sizeof *list->items))
            return fail(m, VXS_E_MEMORY, "out of memory while reading %s", o->name);
        list->items[list->count++] = value;
        return VXS_OK;
    }
    case OPTION_NAMED_VECTOR:
    case OPTION_NAMED_U32:
    case OPTION_NAMED_F64: return add_named(o, value, m);
    case OPTION_CHOICE:
    case OPTION_HELP: {
        int     index = choice_index(o->choices, value);
        nearest near  = {.typed = value};
        char    meant[64];
        if (index < 0) {
            nearest_try_choices(&near, o->choices);
            return fail(m, VXS_E_ARGUMENT, "%s %s: expected one of %s%s", o->name, value, o->choices, nearest_text(meant, &near));
        }
        *(int *)o->target = index;
        return VXS_OK;
    }
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

/* Set an option; only lists may be set repeatedly. given  [option_count] */
static vxs_result give(const command_line *c, const option *o, const char *value, char *given, run_context *m)
{
    char *before = &given[o - c->options];
    if (*before && !is_list(o)) return fail(m, VXS_E_ARGUMENT, "%s is given twice: expected once", o->name);
    *before = 1;
    if (o->given) *o->given = 1;
    return set_option(o, value, m);
}

/* The value of option o in argv[*i]: after its '=', or the next argument. NULL for switches. */
static vxs_result take_value(const option *o, const char *equals, int argc, char **argv, int *i, const char **value, run_context *m)
{
    *value = equals ? equals + 1 : NULL;
    if (o->kind == OPTION_SWITCH) return equals ? fail(m, VXS_E_ARGUMENT, "%s takes no value", o->name) : VXS_OK;
    if (equals) return VXS_OK;
    if (++*i == argc)
        return fail(m, VXS_E_ARGUMENT, "%s needs a value: %s", o->name, o->kind == OPTION_CHOICE ? o->choices : o->value);
    *value = argv[*i];
    return VXS_OK;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* Suggest options that begin with the text typed, three at most: ": did you mean '--resolution' or '--resume'?" into text, or
 * "". */
static void begun_text(char text[128], const command_line *c, const char *typed)
{
    const char *names[OPTIONS_MAX];
    size_t      count = 0, used = 0, length = strlen(typed);
    text[0] = 0;
    for (const option *o = c->options; o < c->options + c->option_count && length > strlen("--"); o++)
        if (o->name && !is_operand(o) && !strncmp(o->name, typed, length)) names[count++] = o->name;
    if (!count || count > 3) return;
    qsort(names, count, sizeof *names, by_name);
    for (size_t n = 0; n < count; n++)
        used += (size_t)snprintf(text + used, 128 - used, "%s'%s'",
                                 !n               ? ": did you mean "
                                 : n + 1 == count ? " or "
                                                  : ", ",
                                 names[n]);
    snprintf(text + used, 128 - used, "?");
}

static vxs_result parse_arguments(const command_line *c, int argc, char **argv, char *given, int *help_shown, run_context *m)
{
    const option *operand      = NULL;
    int           options_over = 0;
    vxs_result    r            = VXS_OK;
    for (int i = 1; i < argc && r == VXS_OK && !*help_shown; i++) {
        const char *arg = argv[i], *value;
        if (options_over || arg[0] != '-' || !arg[1]) {
            if (!(operand = next_operand(c, operand)))
                return fail(m, VXS_E_ARGUMENT, "unexpected argument '%s': usage is vxs %s %s", arg, c->name, c->synopsis);
            r = give(c, operand, arg, given, m);
            continue;
        }
        if (!strcmp(arg, "--")) {
            options_over = 1;
            continue;
        }
        if (!strcmp(arg, "-h")) arg = "--help";
        const char   *equals = arg[1] == '-' ? strchr(arg, '=') : NULL;
        const option *o      = find_option(c, arg, equals ? (size_t)(equals - arg) : strlen(arg));
        if (!o) {
            char    name[NEAREST_LENGTH_MAX + 2], meant[128]; /* longer names are cut after the part that is compared */
            nearest near = {.typed = name};
            snprintf(name, sizeof name, "%.*s", (int)strcspn(arg, "="), arg);
            begun_text(meant, c, name);
            for (const option *a = c->options; a < c->options + c->option_count; a++)
                if (a->name && !is_operand(a)) nearest_try(&near, a->name, strlen(a->name));
            if (!meant[0]) nearest_text(meant, &near);
            return fail(m, VXS_E_ARGUMENT, "unknown option '%s'%s%s vxs %s --help lists the options", arg, meant,
                        meant[0] ? "" : ":", c->name);
        }
        if (o->kind == OPTION_HELP) {
            *help_shown = 1;
            return set_option(o, equals ? equals + 1 : "text", m);
        }
        if ((r = take_value(o, equals, argc, argv, &i, &value, m)) == VXS_OK) r = give(c, o, value, given, m);
    }
    return r;
}

vxs_result options_parse(const command_line *c, int argc, char **argv, int *help_shown, run_context *m)
{
    char         given[OPTIONS_MAX] = {0};
    help_format  format             = HELP_TEXT;
    option       options[OPTIONS_MAX];
    command_line line = {c->name, c->synopsis, c->summary, options, c->option_count + COMMON_OPTIONS};

    const option common[COMMON_OPTIONS] = {
        {NULL, OPTION_GROUP, NULL, 0, 0, NULL, NULL, "in every command", NULL},
        {"--strict", OPTION_SWITCH, &m->strict, 0, 0, NULL, NULL, "a warning is an error, and nothing is written", NULL},
        {"--force", OPTION_SWITCH, &m->force, 0, 0, NULL, NULL, "replace outputs that are read-only or have further names", NULL},
        {"--quiet", OPTION_SWITCH, &m->no_report, 0, 0, NULL, NULL, "no report and no progress: errors, warnings and results alone",
         NULL},
        {"--verbose", OPTION_SWITCH, &m->verbose, 0, 0, NULL, NULL, "the report at full length, with decisions and their reasons",
         NULL},
        {"--progress", OPTION_CHOICE, &m->progress, 0, 0, PROGRESS_CHOICES, NULL,
         "progress; auto: on a terminal; json: lines for a program, on standard error (default auto)", NULL},
        {"--color", OPTION_CHOICE, &m->color, 0, 0, COLOR_CHOICES, NULL, "colours; auto: on a terminal (default auto)", NULL},
        {"--help", OPTION_HELP, &format, 0, 0, HELP_FORMATS, NULL, "this text, and nothing else; --help=man prints a manual page",
         NULL},
    };
    memcpy(options, c->options, c->option_count * sizeof *options);
    memcpy(options + c->option_count, common, sizeof common);
    *help_shown  = 0;
    vxs_result r = parse_arguments(&line, argc, argv, given, help_shown, m);
    if (r == VXS_OK && *help_shown) help_print(&line, format);
    for (size_t i = 0; i < c->option_count && r == VXS_OK && !*help_shown; i++) {
        const option *o = &c->options[i];
        if (given[i]) continue;
        if (is_operand(o) && !operand_is_optional(o))
            r = fail(m, VXS_E_ARGUMENT, "%s is missing: usage is vxs %s %s", o->name, c->name, c->synopsis);
        else if (o->kind == OPTION_OUTPUT && o->min > 0)
            r = fail(m, VXS_E_ARGUMENT, "%s needs %s %s", c->name, o->name, o->value);
    }
    if (r == VXS_OK && m->no_report && m->verbose) r = fail(m, VXS_E_ARGUMENT, "--quiet and --verbose exclude each other");
    return r;
}

void options_free(const command_line *c)
{
    for (const option *o = c->options; o < c->options + c->option_count; o++) {
        if (o->kind == OPTION_TEXTS || o->kind == OPTION_INPUTS) free(((text_list *)o->target)->items);
        if (is_named(o)) named_list_free(o->target);
    }
}
