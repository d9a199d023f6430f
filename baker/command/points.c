/* Points, read as lines of text, and answers to them; see points.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/points.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/base/vec3.h"

/* Points of a block. With many lights it has fewer, so that answers take 16 MiB at most. */
#define BLOCK_POINTS      ((size_t)1 << 16)
#define BLOCK_ANSWERS_MAX ((size_t)1 << 22)
#define POINTS_AT_A_TIME  256

/* The next line, ended by a NUL in place of its LF.
 * length  [out] without the line's end
 * at_end  [out] 1: there is no further line */
static vxs_result next_line(point_reader *reader, size_t *length, int *at_end, message *m)
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

/* All numbers of a line, of which the first six are kept.
 * Returns NULL, or the word that is not a finite number. */
static const char *parse_numbers(const char *line, double numbers[6], size_t *count)
{
    for (*count = 0;; ++*count) {
        while (is_blank(*line)) line++;
        if (!*line) return NULL;

        char  *end;
        double number = strtod(line, &end);
        if (end == line || (*end && !is_blank(*end)) || !isfinite(number)) return line;
        if (*count < 6) numbers[*count] = number;
        line = end;
    }
}

static vxs_result parse_point(const point_reader *reader, const char *line, size_t length, query_point *point, message *m)
{
    double             numbers[6];
    size_t             count;
    unsigned long long number = reader->line;
    if (memchr(line, '\0', length)) return fail(m, VXS_E_READ, "%s: line %llu: holds a NUL byte", reader->name, number);

    const char *wrong = parse_numbers(line, numbers, &count);
    size_t      word  = wrong ? strcspn(wrong, " \t") : 0;
    if (wrong)
        return fail(m, VXS_E_READ, "%s: line %llu: expected a finite number, found '%.*s'", reader->name, number,
                    (int)(word < 32 ? word : 32), wrong);
    if (count != 3 && count != 6)
        return fail(m, VXS_E_READ, "%s: line %llu: expected 3 or 6 numbers, found %zu", reader->name, number, count);

    *point = (query_point){.has_normal = count == 6};
    memcpy(point->position_ws, numbers, sizeof point->position_ws);
    if (point->has_normal && !vec3_unit(&numbers[3], point->normal_ws))
        return fail(m, VXS_E_READ, "%s: line %llu: the normal is zero", reader->name, number);
    return VXS_OK;
}

vxs_result points_read(point_reader *reader, query_point *points, size_t capacity, size_t *count, message *m)
{
    for (*count = 0; *count < capacity;) {
        size_t     length = 0;
        int        at_end = 0;
        vxs_result r      = next_line(reader, &length, &at_end, m);
        if (r != VXS_OK || at_end) return r;

        size_t blanks = 0;
        while (is_blank(reader->text[blanks])) blanks++;
        if (blanks == length || reader->text[blanks] == '#') continue;
        if ((r = parse_point(reader, reader->text, length, &points[*count], m)) != VXS_OK) return r;
        ++*count;
    }
    return VXS_OK;
}

/* answers ---------------------------------------------------------------------------------------------- */

typedef struct block {
    point_answer answer;
    const void  *user;
    size_t       light_count, capacity;
    query_point *points; /* [capacity] */
    float       *lit;    /* [capacity * light_count] */
} block;

static void answer_points(void *user, size_t begin, size_t end, uint32_t worker)
{
    const block *b = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) b->answer(b->user, &b->points[n], &b->lit[n * b->light_count]);
}

static void print_answer(float lit, char end)
{
    if (lit < 0)
        printf("out%c", end);
    else if (lit == 0 || lit == 1)
        printf("%c%c", lit == 0 ? '0' : '1', end);
    else
        printf("%.6g%c", (double)lit, end);
}

vxs_result points_answer(point_answer answer, const void *user, size_t light_count, uint32_t threads, message *m)
{
    point_reader reader = {.file = stdin, .name = "standard input"};
    block        b      = {.answer = answer, .user = user, .light_count = light_count, .capacity = BLOCK_ANSWERS_MAX / light_count};
    size_t       count  = 0;
    vxs_result   r      = VXS_OK;

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
        for (size_t n = 0; n < count * light_count; n++) print_answer(b.lit[n], (n + 1) % light_count ? ' ' : '\n');
        if (fflush(stdout) || ferror(stdout)) {
            r = fail(m, VXS_E_WRITE, "standard output: cannot be written: %s", strerror(errno));
            goto done;
        }
    } while (count);
done:
    free(b.points);
    free(b.lit);
    return r;
}
