/* Points to ask about, read as lines of text; see points.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/points.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/vec3.h"

#define BUFFER_SIZE ((size_t)1 << 16)

/* a line of the greatest length, its CR and LF, and one character that shows that a line is longer */
_Static_assert(BUFFER_SIZE > POINT_LINE_MAX + 3, "the buffer holds a line");

vxs_result point_reader_init(point_reader *reader, FILE *file, const char *name, message *m)
{
    *reader = (point_reader){.file = file, .name = name, .buffer = malloc(BUFFER_SIZE + 1)}; /* 1: the last line gets its end */
    return reader->buffer ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for reading %s", name);
}

void point_reader_free(point_reader *reader)
{
    free(reader->buffer);
    *reader = (point_reader){0};
}

/* Move what is left to the front and read on behind it. */
static vxs_result refill(point_reader *reader, message *m)
{
    size_t left = reader->end - reader->begin;
    memmove(reader->buffer, reader->buffer + reader->begin, left);
    errno         = 0;
    size_t got    = fread(reader->buffer + left, 1, BUFFER_SIZE - left, reader->file);
    reader->begin = 0;
    reader->end   = left + got;
    if (got < BUFFER_SIZE - left) {
        if (ferror(reader->file))
            return fail(m, VXS_E_READ, "%s: cannot be read: %s", reader->name, errno ? strerror(errno) : "unknown error");
        reader->at_end = 1;
    }
    return VXS_OK;
}

/* The next line, ended by a NUL in place of its LF; NULL at the end of the file.
 * length  [out] without the line's end */
static vxs_result next_line(point_reader *reader, char **line, size_t *length, message *m)
{
    *line         = NULL;
    char *begin   = reader->buffer + reader->begin;
    char *newline = memchr(begin, '\n', reader->end - reader->begin);
    if (!newline && !reader->at_end && reader->end - reader->begin <= POINT_LINE_MAX + 1) {
        vxs_result r = refill(reader, m);
        if (r != VXS_OK) return r;
        begin   = reader->buffer;
        newline = memchr(begin, '\n', reader->end);
    }
    if (reader->begin == reader->end) return VXS_OK;

    char *end = newline ? newline : reader->buffer + reader->end;
    reader->line++;
    *length = (size_t)(end - begin);
    if (*length && begin[*length - 1] == '\r') --*length;
    if (*length > POINT_LINE_MAX)
        return fail(m, VXS_E_READ, "%s: line %llu: longer than %d characters", reader->name, (unsigned long long)reader->line,
                    POINT_LINE_MAX);
    begin[*length] = '\0';
    reader->begin  = (size_t)(end - reader->buffer) + (newline ? 1 : 0);
    *line          = begin;
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
        char      *line;
        size_t     length;
        vxs_result r = next_line(reader, &line, &length, m);
        if (r != VXS_OK || !line) return r;

        size_t blanks = 0;
        while (is_blank(line[blanks])) blanks++;
        if (blanks == length || line[blanks] == '#') continue;
        if ((r = parse_point(reader, line, length, &points[*count], m)) != VXS_OK) return r;
        ++*count;
    }
    return VXS_OK;
}
