/* Points, read as lines of text, and answers to them; see points.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/points.h"

#include <errno.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/base/vec3.h"
#include "baker/files/input_file.h"
#include "baker/files/run_files.h"

/* Limits of a block: points, and answers. With many lights a block has fewer points, so that answers take 16 MiB at most. */
#define BLOCK_POINTS      ((size_t)1 << 16)
#define BLOCK_ANSWERS_MAX ((size_t)1 << 22)
#define POINTS_AT_A_TIME  256
#define BYTE_ORDER_MARK   "\xef\xbb\xbf"

/* Read the next line; its LF becomes a NUL.
 * length  [out] without the line's end
 * at_end  [out] 1: there is no further line */
static vxs_result next_line(point_reader *reader, size_t *length, int *at_end, run_context *m)
{
    int    c = EOF;
    size_t n = 0;
    errno    = 0;
    while (n < sizeof reader->text - 1 && !feof(reader->file) && (c = getc_unlocked(reader->file)) != EOF && c != '\n')
        reader->text[n++] = (char)c;
    if (ferror(reader->file))
        return fail(m, VXS_E_READ, "%s: cannot be read: %s", reader->name, errno ? strerror(errno) : "unknown error");
    *at_end = c == EOF && !n;
    if (!*at_end) reader->line++;
    if (n && reader->text[n - 1] == '\r') n--;
    if (n > POINT_LINE_MAX)
        return fail(m, VXS_E_READ, "%s: line %llu: longer than %d characters", reader->name, (unsigned long long)reader->line,
                    POINT_LINE_MAX);
    reader->text[n] = '\0';
    *length         = n;
    return VXS_OK;
}

static int is_blank(char c)
{
    return c == ' ' || c == '\t';
}

static int is_separator(char c)
{
    return is_blank(c) || c == ',' || c == ';';
}

/* The separator between two numbers. */
typedef struct separator {
    char mark;  /* ',' or ';'; 0: only blanks */
    int  loose; /* 1: blanks before the next number */
} separator;

/* The numbers of a line, and their separators. */
typedef struct number_row {
    double      numbers[6]; /* the first of them */
    separator   after[6];   /* behind each */
    size_t      count;
    int         has_points; /* decimal points */
    const char *wrong;      /* NULL, or the text that is not a finite number */
} number_row;

/* Skip blanks, and at most one mark. */
static const char *skip_separator(const char *at, separator *s)
{
    *s = (separator){0};
    while (is_blank(*at)) at++;
    if (!*at || !is_separator(*at)) return at;
    s->mark            = *at++;
    const char *behind = at;
    while (is_blank(*at)) at++;
    s->loose = at > behind;
    return at;
}

static number_row parse_numbers(const char *line)
{
    number_row row = {0};
    while (is_blank(*line)) line++;
    for (separator s = {0}; *line || s.mark; row.count++) {
        char  *end;
        double number = strtod(line, &end);
        if (end == line || (*end && !is_separator(*end)) || !isfinite(number)) {
            row.wrong = line;
            return row;
        }
        row.has_points |= memchr(line, '.', (size_t)(end - line)) != NULL;
        line = skip_separator(end, &s);
        if (row.count < 6) row.numbers[row.count] = number, row.after[row.count] = s;
    }
    return row;
}

static vxs_result parse_point(const point_reader *reader, const char *line, size_t length, query_point *point, run_context *m)
{
    unsigned long long number = reader->line;
    if (memchr(line, '\0', length)) return fail(m, VXS_E_READ, "%s: line %llu: holds a NUL byte", reader->name, number);

    number_row row  = parse_numbers(line);
    size_t     word = row.wrong ? strcspn(row.wrong, " \t,;") : 0;
    if (row.wrong)
        return fail(m, VXS_E_READ, "%s: line %llu: expected a finite number, found '%.*s'", reader->name, number,
                    (int)(word < 32 ? word : 32), row.wrong);

    /* Whether a line is ambiguous, because the decimal point may be a comma: "1,5 2,5 3,5", "1,5;2,5;3,5" and "1,5, 2,5, 3,5"
     * may be three numbers each. "1,2,3, 0,1,0" is not ambiguous. */
    size_t alike = 1, in_pairs = 1;
    for (size_t n = 0; n + 1 < row.count && n < 6; n++) {
        alike &= row.after[n].mark == row.after[0].mark;
        in_pairs &= row.after[n].mark == ',' && row.after[n].loose == (n % 2 == 1);
    }
    if (!alike || (row.count == 6 && in_pairs && !row.has_points))
        return fail(m, VXS_E_READ,
                    "%s: line %llu: expected numbers with a decimal point, separated all alike, by blanks or commas: "
                    "'%.32s' could mean two things",
                    reader->name, number, line);

    if (row.count != 3 && row.count != 6)
        return fail(m, VXS_E_READ, "%s: line %llu: expected 3 or 6 numbers, found %zu", reader->name, number, row.count);

    *point = (query_point){.has_normal = row.count == 6};
    memcpy(point->position_ws, row.numbers, sizeof point->position_ws);
    if (point->has_normal && !vec3_unit(&row.numbers[3], point->normal_ws))
        return fail(m, VXS_E_READ, "%s: line %llu: the normal is zero", reader->name, number);
    return VXS_OK;
}

vxs_result points_read(point_reader *reader, query_point *points, size_t capacity, size_t *count, run_context *m)
{
    for (*count = 0; *count < capacity;) {
        size_t     length = 0;
        int        at_end = 0;
        vxs_result r      = next_line(reader, &length, &at_end, m);
        if (r != VXS_OK || at_end) return r;

        size_t blanks = reader->line == 1 && !strncmp(reader->text, BYTE_ORDER_MARK, 3) ? 3 : 0;
        while (is_blank(reader->text[blanks])) blanks++;
        if (blanks == length || reader->text[blanks] == '#') continue;
        if ((r = parse_point(reader, reader->text + blanks, length - blanks, &points[*count], m)) != VXS_OK) return r;
        ++*count;
    }
    return VXS_OK;
}

vxs_result points_check_input(const char *name, const char *path, run_context *m)
{
    if (!is_standard_input(path)) return VXS_OK;
    return fail(m, VXS_E_ARGUMENT, "%s -: points are read from standard input: expected a file or <(command)", name);
}

/* answers ---------------------------------------------------------------------------------------------- */

typedef struct block {
    point_answer answer;
    void        *user;
    size_t       light_count, capacity;
    query_point *points; /* [capacity] */
    float       *lit;    /* [capacity * light_count] */
    atomic_int   fails;  /* a point has no answer */
} block;

static void answer_points(void *user, size_t begin, size_t end, uint32_t worker)
{
    block *b = user;
    (void)worker;
    for (size_t n = begin; n < end && !b->fails; n++)
        if (!b->answer(b->user, &b->points[n], &b->lit[n * b->light_count])) b->fails = 1;
}

vxs_result points_answer(point_answer answer, void *user, size_t light_count, uint32_t threads, run_context *m)
{
    point_reader reader = {.file = stdin, .name = "standard input"};
    vxs_result   r      = run_files_check_input("-", reader.name, m);
    block        b      = {.answer = answer, .user = user, .light_count = light_count, .capacity = BLOCK_ANSWERS_MAX / light_count};
    size_t       count  = 0;

    if (r != VXS_OK) return r;
    if (!b.capacity) b.capacity = 1;
    if (b.capacity > BLOCK_POINTS) b.capacity = BLOCK_POINTS;
    b.points = malloc(b.capacity * sizeof *b.points);
    b.lit    = malloc(b.capacity * light_count * sizeof *b.lit);
    if (!b.points || !b.lit) {
        r = fail(m, VXS_E_MEMORY, "out of memory for a block of points");
        goto done;
    }
    do {
        if ((r = points_read(&reader, b.points, b.capacity, &count, m)) != VXS_OK) goto done;
        parallel_for(threads, count, POINTS_AT_A_TIME, answer_points, &b);
        if (b.fails) goto done;
        for (size_t n = 0; n < count * light_count; n++) {
            float lit = b.lit[n];
            char  end = (n + 1) % light_count ? ' ' : '\n';
            if (lit < 0)
                printf("out%c", end);
            else if (lit == 0 || lit == 1)
                printf("%c%c", lit == 0 ? '0' : '1', end);
            else
                printf("%.6g%c", (double)lit, end);
        }
        if (fflush(stdout) || ferror(stdout)) {
            r = standard_output_is_broken() ? VXS_E_BROKEN_PIPE
                                            : fail(m, VXS_E_WRITE, "standard output: cannot be written: %s", strerror(errno));
            goto done;
        }
    } while (count);
done:
    free(b.points);
    free(b.lit);
    return r;
}
