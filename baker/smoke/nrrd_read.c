/* Reading NRRD; see nrrd_read.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/smoke/nrrd_read.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "baker/base/memory.h"
#include "baker/files/input_file.h"
#include "formats/vxs_bytes.h"

enum { LINE_BYTES = 1024, SIZE_MOST = 1 << 14 };

static const uint64_t FILE_BYTES_MAX = (uint64_t)16 << 30;

/* A file during reading. */
typedef struct nrrd {
    const char    *name; /* for messages */
    const uint8_t *bytes;
    size_t         size_bytes, at;
    uint32_t       dimension, number_bytes; /* 0: not given */
    uint32_t       size[3];
    double         axes[3][3], origin[3];
    int            has_axes, has_spacings, is_raw, is_little;
    vxs_result     result; /* of the header */
    message       *m;
} nrrd;

static vxs_result is_unsupported(const nrrd *n, const char *field, const char *value, const char *expected)
{
    return fail(n->m, VXS_E_UNSUPPORTED, "'%s': %s: %s: expected %s", n->name, field, value, expected);
}

/* the header ------------------------------------------------------------------------------------------------------------------- */

/* The next line of the header, without its end.   Returns 0: no more lines, or not text */
static int next_line(nrrd *n, char line[LINE_BYTES])
{
    const uint8_t *from = n->bytes + n->at, *end = memchr(from, '\n', n->size_bytes - n->at);
    size_t         size = end ? (size_t)(end - from) : 0;
    if (!end || size >= LINE_BYTES || memchr(from, 0, size)) return 0;
    memcpy(line, from, size);
    n->at += size + 1;
    if (size && line[size - 1] == '\r') size--;
    line[size] = 0;
    return 1;
}

/* Parse a vector, "(1,2,3)".   Returns its end; NULL: not a vector */
static const char *read_vector(const char *text, double v[3])
{
    int used = 0;
    if (sscanf(text, " ( %lf , %lf , %lf )%n", &v[0], &v[1], &v[2], &used) != 3 || !used) return NULL;
    return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]) ? text + used : NULL;
}

static int is_end(const char *text)
{
    return text && !text[strspn(text, " \t")];
}

static vxs_result read_type(nrrd *n, const char *value)
{
    static const struct {
        const char *name;
        uint32_t    bytes;
    } types[] = {{"float", 4},          {"unsigned char", 1}, {"uchar", 1},  {"uint8", 1},    {"uint8_t", 1},
                 {"unsigned short", 2}, {"ushort", 2},        {"uint16", 2}, {"uint16_t", 2}, {"unsigned short int", 2}};
    for (size_t k = 0; k < sizeof types / sizeof *types; k++)
        if (!strcasecmp(value, types[k].name)) n->number_bytes = types[k].bytes;
    return n->number_bytes ? VXS_OK : is_unsupported(n, "type", value, "float, uint8 or uint16");
}

static vxs_result read_sizes(nrrd *n, const char *value)
{
    long long size[3];
    int       used = 0;
    if (sscanf(value, "%lld %lld %lld%n", &size[0], &size[1], &size[2], &used) != 3 || !is_end(value + used))
        return is_unsupported(n, "sizes", value, "three numbers");
    for (int k = 0; k < 3; k++) {
        if (size[k] < 1 || size[k] > SIZE_MOST) return is_unsupported(n, "sizes", value, "1 to 16384 along each axis");
        n->size[k] = (uint32_t)size[k];
    }
    return VXS_OK;
}

static vxs_result read_axes(nrrd *n, const char *value)
{
    const char *at = value;
    for (int k = 0; k < 3 && at; k++) at = read_vector(at, n->axes[k]);
    if (!is_end(at)) return is_unsupported(n, "space directions", value, "three vectors of three numbers");
    n->has_axes = 1;
    return VXS_OK;
}

static vxs_result read_spacings(nrrd *n, const char *value)
{
    int used = 0;
    if (sscanf(value, "%lf %lf %lf%n", &n->axes[0][0], &n->axes[1][1], &n->axes[2][2], &used) != 3 || !is_end(value + used))
        return is_unsupported(n, "spacings", value, "three numbers");
    n->has_spacings = 1;
    return VXS_OK;
}

static vxs_result read_dimension(nrrd *n, const char *value)
{
    if (strcmp(value, "3") != 0) return is_unsupported(n, "dimension", value, "3, a grid of x, y and z");
    n->dimension = 3;
    return VXS_OK;
}

static vxs_result read_encoding(nrrd *n, const char *value)
{
    if (strcasecmp(value, "raw") != 0) return is_unsupported(n, "encoding", value, "raw");
    n->is_raw = 1;
    return VXS_OK;
}

static vxs_result read_endian(nrrd *n, const char *value)
{
    if (strcasecmp(value, "little") != 0) return is_unsupported(n, "endian", value, "little");
    n->is_little = 1;
    return VXS_OK;
}

static vxs_result read_origin(nrrd *n, const char *value)
{
    return is_end(read_vector(value, n->origin)) ? VXS_OK : is_unsupported(n, "space origin", value, "a vector of three numbers");
}

/* Other spaces are relative to a body, or have axes of another handedness. */
static vxs_result read_space(nrrd *n, const char *value)
{
    if (!strcmp(value, "3") || !strcasecmp(value, "3D-right-handed") || !strcasecmp(value, "3DRH")) return VXS_OK;
    return is_unsupported(n, "space", value, "'space dimension: 3', the world space of the scene");
}

static vxs_result read_elsewhere(nrrd *n, const char *value)
{
    return is_unsupported(n, "data file", value, "numbers behind the header, in the same file");
}

static vxs_result read_skip(nrrd *n, const char *value)
{
    return strcmp(value, "0") != 0 ? is_unsupported(n, "skip", value, "0") : VXS_OK;
}

static vxs_result read_field(nrrd *n, const char *line)
{
    static const struct {
        const char *name;
        vxs_result (*read)(nrrd *n, const char *value);
    } fields[]        = {{"type", read_type},
                         {"dimension", read_dimension},
                         {"sizes", read_sizes},
                         {"encoding", read_encoding},
                         {"endian", read_endian},
                         {"space", read_space},
                         {"space dimension", read_space},
                         {"space directions", read_axes},
                         {"space origin", read_origin},
                         {"spacings", read_spacings},
                         {"data file", read_elsewhere},
                         {"datafile", read_elsewhere},
                         {"byte skip", read_skip},
                         {"byteskip", read_skip},
                         {"line skip", read_skip},
                         {"lineskip", read_skip}};
    const char *value = strstr(line, ": ");
    if (line[0] == '#' || strstr(line, ":=")) return VXS_OK; /* a comment; a private key */
    if (!value) return fail(n->m, VXS_E_SCENE, "'%s': '%s': expected a field of NRRD, 'name: value'", n->name, line);
    for (size_t k = 0; k < sizeof fields / sizeof *fields; k++)
        if (strlen(fields[k].name) == (size_t)(value - line) && !strncasecmp(line, fields[k].name, (size_t)(value - line)))
            return fields[k].read(n, value + 2 + strspn(value + 2, " "));
    return VXS_OK; /* kinds, units, names: they do not change numbers */
}

static vxs_result read_header(nrrd *n)
{
    char       line[LINE_BYTES];
    vxs_result r = VXS_OK;
    if (!next_line(n, line) || strncmp(line, "NRRD000", 7) != 0)
        return fail(n->m, VXS_E_SCENE, "'%s': expected a grid in NRRD, which begins with 'NRRD000'", n->name);
    while (r == VXS_OK) {
        if (!next_line(n, line))
            return fail(n->m, VXS_E_SCENE, "'%s': the header of NRRD does not end: expected an empty line", n->name);
        if (!line[0]) break;
        r = read_field(n, line);
    }
    return r;
}

/* Size of all numbers. */
static uint64_t number_bytes_of(const nrrd *n)
{
    return (uint64_t)n->size[0] * n->size[1] * n->size[2] * n->number_bytes;
}

static vxs_result check_header(const nrrd *n)
{
    const char *missing = !n->number_bytes                       ? "type"
                          : !n->dimension                        ? "dimension"
                          : !n->size[0]                          ? "sizes"
                          : !n->is_raw                           ? "encoding"
                          : !n->is_little && n->number_bytes > 1 ? "endian"
                          : !n->has_axes && !n->has_spacings     ? "space directions"
                                                                 : NULL;
    if (missing) return fail(n->m, VXS_E_SCENE, "'%s': the field '%s' of NRRD is missing", n->name, missing);
    if (n->has_axes && n->has_spacings)
        return fail(n->m, VXS_E_SCENE, "'%s': 'space directions' and 'spacings': expected one of them", n->name);
    return VXS_OK;
}

/* File size that the header requires; 0: not valid, with a message. */
static uint64_t wanted_bytes(void *user, const uint8_t *first, size_t size_bytes)
{
    nrrd *n       = user;
    n->bytes      = first;
    n->size_bytes = size_bytes;
    n->result     = read_header(n);
    if (n->result == VXS_OK) n->result = check_header(n);
    return n->result == VXS_OK ? n->at + number_bytes_of(n) : 0;
}

static vxs_result check_size(const nrrd *n)
{
    uint64_t wanted = number_bytes_of(n), there = n->size_bytes - n->at;
    if (there == wanted) return VXS_OK;
    return fail(n->m, VXS_E_SCENE, "'%s': %s%llu bytes of numbers: expected %llu, for %u x %u x %u", n->name,
                there > wanted ? "more than " : "", (unsigned long long)(there > wanted ? wanted : there),
                (unsigned long long)wanted, n->size[0], n->size[1], n->size[2]);
}

/* numbers ---------------------------------------------------------------------------------------------------------------------- */

static double number_at(const nrrd *n, size_t k)
{
    const uint8_t *p = n->bytes + n->at + k * n->number_bytes;
    if (n->number_bytes < 4) return n->number_bytes == 1 ? *p : vxs_load16(p);
    uint32_t bits = vxs_load32(p);
    float    number;
    memcpy(&number, &bits, sizeof number);
    return (double)number;
}

static vxs_result read_numbers(const nrrd *n, smoke_grid *g, double factor)
{
    size_t count = (size_t)n->size[0] * n->size[1] * n->size[2];
    memcpy(g->size, n->size, sizeof g->size);
    vxs_result r = memory_check(count * sizeof *g->extinction, n->m, "'%s': a grid of %u x %u x %u needs", n->name, n->size[0],
                                n->size[1], n->size[2]);
    if (r != VXS_OK) return r;
    if (!(g->extinction = malloc(count * sizeof *g->extinction)))
        return fail(n->m, VXS_E_MEMORY, "out of memory for '%s'", n->name);
    for (size_t k = 0; k < count; k++) {
        double number    = number_at(n, k);
        g->extinction[k] = (float)(number * factor);
        if (number >= 0 && isfinite(g->extinction[k])) continue;
        return fail(n->m, VXS_E_SCENE, "'%s': sample (%zu, %zu, %zu) is %g: expected extinction, 0 or more", n->name,
                    k % n->size[0], k / n->size[0] % n->size[1], k / n->size[0] / n->size[1], number);
    }
    return VXS_OK;
}

vxs_result nrrd_read(smoke_grid *g, const char *path, double factor, message *m)
{
    uint8_t   *bytes;
    nrrd       n = {.name = input_name(path), .m = m};
    vxs_result r = input_read(&bytes, &n.size_bytes, path, FILE_BYTES_MAX, &(input_head){wanted_bytes, &n}, m);
    n.bytes      = bytes;
    if (r == VXS_OK) r = n.result;
    if (r == VXS_OK) r = check_size(&n);
    if (r == VXS_OK) r = read_numbers(&n, g, factor);
    if (r == VXS_OK && !smoke_grid_place(g, n.axes, n.origin))
        r = fail(m, VXS_E_SCENE, "'%s': axes that lie in a plane, or lead beyond 1e9 m: expected three of any directions", n.name);
    free(bytes);
    return r;
}
