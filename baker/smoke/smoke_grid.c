/* Smoke as a grid; see smoke_grid.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/smoke/smoke_grid.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <xxhash.h>

#include "baker/base/memory.h"
#include "baker/base/vec3.h"
#include "baker/files/input_file.h"
#include "formats/vxs_bytes.h"

void smoke_grid_free(smoke_grid *g)
{
    free(g->extinction);
    *g = (smoke_grid){0};
}

/* one  1: a position; 0: a direction */
static void apply(const double matrix[12], const double v[3], double one, double out[3])
{
    for (int n = 0; n < 3; n++) out[n] = vec3_dot(matrix + 4 * n, v) + one * matrix[4 * n + 3];
}

void smoke_grid_corner(const smoke_grid *g, int corner, double ws[3])
{
    double at[3];
    for (int n = 0; n < 3; n++) at[n] = corner >> n & 1 ? g->size[n] - 0.5 : -0.5;
    apply(g->ws_from_grid, at, 1, ws);
}

void smoke_grid_middle(const smoke_grid *g, double ws[3])
{
    const double at[3] = {0.5 * (g->size[0] - 1.0), 0.5 * (g->size[1] - 1.0), 0.5 * (g->size[2] - 1.0)};
    apply(g->ws_from_grid, at, 1, ws);
}

double smoke_grid_spacing(const smoke_grid *g)
{
    double least = INFINITY;
    for (int n = 0; n < 3; n++) {
        const double unit[3] = {n == 0, n == 1, n == 2};
        double       axis[3];
        apply(g->ws_from_grid, unit, 0, axis);
        least = fmin(least, sqrt(vec3_dot(axis, axis)));
    }
    return least;
}

int smoke_grid_place(smoke_grid *g, const double axes[3][3], const double origin[3])
{
    double rows[3][3];
    for (int n = 0; n < 3; n++) vec3_cross(axes[(n + 1) % 3], axes[(n + 2) % 3], rows[n]);
    double volume = vec3_dot(axes[0], rows[0]);
    if (!isfinite(volume) || volume == 0) return 0;
    for (int n = 0; n < 3; n++) {
        for (int c = 0; c < 3; c++) {
            g->grid_from_ws[4 * n + c] = rows[n][c] / volume;
            g->ws_from_grid[4 * n + c] = axes[c][n];
        }
        g->grid_from_ws[4 * n + 3] = -vec3_dot(rows[n], origin) / volume;
        g->ws_from_grid[4 * n + 3] = origin[n];
    }
    for (int n = 0; n < 12; n++)
        if (!isfinite(g->grid_from_ws[n])) return 0;
    for (int corner = 0; corner < 8; corner++) {
        double ws[3];
        smoke_grid_corner(g, corner, ws);
        for (int n = 0; n < 3; n++)
            if (!(fabs(ws[n]) <= 1e9)) return 0; /* metres */
    }
    return 1;
}

void smoke_grid_fingerprint(const smoke_grid *g, char text[SMOKE_FINGERPRINT_BYTES])
{
    size_t        count = (size_t)g->size[0] * g->size[1] * g->size[2];
    XXH128_hash_t hash  = XXH3_128bits_withSeed(g->ws_from_grid, sizeof g->ws_from_grid, g->size[0]);
    hash                = XXH3_128bits_withSeed(g->extinction, count * sizeof *g->extinction, hash.low64 + g->size[1]);
    snprintf(text, SMOKE_FINGERPRINT_BYTES, "%016" PRIx64 "%016" PRIx64, (uint64_t)hash.high64, (uint64_t)hash.low64);
}

/* rays ------------------------------------------------------------------------------------------------------------------------- */

typedef struct march {
    const smoke_grid *grid;
    double            from[3], way[3]; /* in voxels */
    double            metres;          /* length of the ray per unit of depth */
} march;

static double extinction_along(const march *m, double depth)
{
    double at[3];
    vec3_mad(m->from, depth, m->way, at);

    /* Extinction at a position in the grid's box. */
    size_t step[3] = {1, m->grid->size[0], (size_t)m->grid->size[0] * m->grid->size[1]}, first = 0, next[3];
    double part[3];
    for (int n = 0; n < 3; n++) {
        double last = m->grid->size[n] - 1, held = at[n] > 0 ? at[n] < last ? at[n] : last : 0;
        size_t whole = (size_t)held;
        part[n]      = held - (double)whole;
        next[n]      = held < last ? step[n] : 0;
        first += whole * step[n];
    }
    double sum[4];
    for (int n = 0; n < 4; n++) {
        const float *row = m->grid->extinction + first + (n & 1 ? next[1] : 0) + (n & 2 ? next[2] : 0);
        sum[n]           = (double)row[0] + part[0] * ((double)row[next[0]] - (double)row[0]);
    }
    double near = sum[0] + part[1] * (sum[1] - sum[0]), far = sum[2] + part[1] * (sum[3] - sum[2]);
    return near + part[2] * (far - near);
}

/* Optical depth between two planes of samples, by Simpson's rule.
 * bow  [out] greatest error of linear optical depth in between, for linear extinction */
static double piece_thick(const march *m, double begin, double end, double *bow)
{
    double a = extinction_along(m, begin), middle = extinction_along(m, 0.5 * (begin + end)), b = extinction_along(m, end);
    *bow = (end - begin) / 8 * m->metres * fabs(b - a);
    return (end - begin) / 6 * m->metres * (a + 4 * middle + b);
}

/* Add smoke that is too dense for equal pieces: pieces of limited optical depth, until no light is left.
 * Returns 0 without memory. */
static int add_dense(const march *m, double begin, double end, smoke_path *path)
{
    double step = (end - begin) / SMOKE_PARTS_MOST;
    for (double a = begin; a < end && !(path->count && path->thick[path->count - 1] > SMOKE_OPAQUE);) {
        double b = a + step < end ? a + step : end, bow, thick = piece_thick(m, a, b, &bow);
        if ((thick > SMOKE_PIECE || bow > SMOKE_BOW) && a + step / 2 > a) {
            step /= 2;
            continue;
        }
        if (!(b > a)) b = nextafter(a, end);
        if (thick > 0 && !smoke_path_add(path, a, b, thick)) return 0;
        a = b;
        step *= 2;
    }
    return 1;
}

/* Returns 0 without memory. */
static int add_piece(const march *m, double begin, double end, smoke_path *path)
{
    double bow, thick = piece_thick(m, begin, end, &bow), parts = fmax(ceil(thick / SMOKE_PIECE), ceil(sqrt(bow / SMOKE_BOW)));
    if (!(thick > 0)) return 1;
    if (parts > SMOKE_PARTS_MOST) return add_dense(m, begin, end, path);
    for (int n = 0; n < (int)parts; n++) {
        double a = begin + (end - begin) * n / parts, b = n + 1 < parts ? begin + (end - begin) * (n + 1) / parts : end;
        if (parts > 1) thick = piece_thick(m, a, b, &bow);
        if (b > a && thick > 0 && !smoke_path_add(path, a, b, thick)) return 0;
    }
    return 1;
}

int smoke_grid_march(const smoke_grid *g, const double from[3], const double way[3], double begin, double end, smoke_path *path)
{
    march  m = {.grid = g, .metres = sqrt(vec3_dot(way, way))};
    double plane[3]; /* depth of the next plane of each axis */
    apply(g->grid_from_ws, from, 1, m.from);
    apply(g->grid_from_ws, way, 0, m.way);

    /* Clip to the grid's box. */
    for (int n = 0; n < 3; n++) {
        double low = -0.5 - m.from[n], high = m.grid->size[n] - 0.5 - m.from[n];
        if (m.way[n] == 0) {
            if (low > 0 || high < 0) end = -INFINITY;
            continue;
        }
        double a = low / m.way[n], b = high / m.way[n];
        begin = fmax(begin, fmin(a, b));
        end   = fmin(end, fmax(a, b));
    }

    for (int n = 0; n < 3; n++) {
        double at = m.from[n] + begin * m.way[n];
        plane[n]  = m.way[n] > 0 ? floor(at) + 1 : ceil(at) - 1;
    }
    while (begin < end && !(path->count && path->thick[path->count - 1] > SMOKE_OPAQUE)) {
        int    axis = -1;
        double next = end;
        for (int n = 0; n < 3; n++) {
            double at = m.way[n] != 0 ? (plane[n] - m.from[n]) / m.way[n] : INFINITY;
            if (at < next) next = at, axis = n;
        }
        if (next > begin && !add_piece(&m, begin, next, path)) return 0;
        begin = fmax(begin, next);
        if (axis < 0) break;
        plane[axis] += m.way[axis] > 0 ? 1 : -1;
    }
    return 1;
}

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
    run_context   *m;
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
    vxs_result r = memory_check((uint64_t)count * sizeof *g->extinction, n->m, "'%s': a grid of %u x %u x %u needs", n->name,
                                n->size[0], n->size[1], n->size[2]);
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

vxs_result nrrd_read(smoke_grid *g, const char *path, double factor, run_context *m)
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
