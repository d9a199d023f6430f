/* Measurements as untrusted JSON; see bench_json.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/bench/bench_json.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/files/json_file.h"

/* shapes ----------------------------------------------------------------------------------------------------------------------- */

static const struct number_kind {
    const char *name;
    int         is_whole;
    double      least, most;
} number_kinds[] = {{"count", 1, 0, 1e15},                              /* a double holds it exactly */
                    {"u32", 1, 0, UINT32_MAX}, {"side", 1, 8, 1 << 24}, /* texels */
                    {"time", 0, 0, 1e15},                               /* seconds, milliseconds, nanoseconds */
                    {"size", 0, 0, 1e15},      {"number", 0, -1e15, 1e15}, {"share", 0, 0, 1}};

typedef struct shape_reader {
    const char  *path, *writer;
    size_t       scene, cell; /* from 1; 0: outside of them */
    run_context *m;
} shape_reader;

static int fault(shape_reader *r, const char *name, const char *format, ...) __attribute__((format(printf, 3, 4)));
static int fault(shape_reader *r, const char *name, const char *format, ...)
{
    char    what[128], scene[32] = "", cell[32] = "";
    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    if (r->scene) snprintf(scene, sizeof scene, "scene %zu: ", r->scene);
    if (r->cell) snprintf(cell, sizeof cell, "cell %zu: ", r->cell);
    fail(r->m, VXS_E_READ, "%s: not what %s writes: %s%s\"%s\" %s", r->path, r->writer, scene, cell, name, what);
    return 0;
}

static int check_number(shape_reader *r, const char *name, const json_t *value, const char *kind)
{
    const struct number_kind *k = number_kinds;
    while (strcmp(k->name, kind)) k++;
    double number = json_number_value(value);
    if ((k->is_whole ? json_is_integer(value) : json_is_number(value)) && number >= k->least && number <= k->most) return 1;
    return fault(r, name, "is missing or no %s from %.10g to %.10g", k->is_whole ? "whole number" : "number", k->least, k->most);
}

static int check_shape(shape_reader *r, const char *name, const json_t *value, const json_t *shape);

static int check_object(shape_reader *r, const char *object_name, const json_t *object, const json_t *shape)
{
    const char *key;
    json_t     *part;
    if (!json_is_object(object)) return fault(r, object_name, "is missing or no object");
    json_object_foreach((json_t *)(size_t)shape, key, part)
    {
        char name[32];
        snprintf(name, sizeof name, "%.*s", (int)strcspn(key, "?"), key);
        const json_t *value = json_object_get(object, name);
        if ((value || !strchr(key, '?')) && !check_shape(r, name, value, part)) return 0;
    }
    return 1;
}

static int check_array(shape_reader *r, const char *name, const json_t *array, const json_t *shape)
{
    size_t  n, most = (size_t)json_integer_value(json_array_get(shape, 0)), last = json_array_size(shape) - 1;
    size_t *number = !strcmp(name, "cells") ? &r->cell : !strcmp(name, "scenes") ? &r->scene : NULL;
    json_t *item;
    if (!json_is_array(array)) return fault(r, name, "is missing or no array");
    if (json_array_size(array) > most) return fault(r, name, "has %zu items, expected at most %zu", json_array_size(array), most);
    json_array_foreach(array, n, item)
    {
        if (!json_is_object(item)) return fault(r, name, "has an item that is no object");
        if (number) *number = n + 1;
        int is_other = json_is_true(json_object_get(item, "smooth")) || json_is_true(json_object_get(item, "refused")) ||
                       json_integer_value(json_object_get(item, "filter_px")) > 1;
        if (!check_object(r, name, item, json_array_get(shape, is_other ? last : 1))) return 0;
    }
    if (number) *number = 0;
    return 1;
}

static int check_levels(shape_reader *r, const json_t *levels)
{
    json_t  *level;
    size_t   n;
    uint64_t sides = 0; /* bits; masks are bit 0 */
    json_array_foreach(levels, n, level)
    {
        uint64_t side = (uint64_t)json_integer_value(json_object_get(level, "side_voxels")), bit = side ? side : 1;
        if ((side & (side - 1)) || side == 1) return fault(r, "side_voxels", "is neither 0 nor a power of two");
        if (sides & bit) return fault(r, "levels", "has a side twice");
        sides |= bit;
    }
    return 1;
}

static int check_shape(shape_reader *r, const char *name, const json_t *value, const json_t *shape)
{
    if (json_is_string(shape)) {
        const char *kind      = json_string_value(shape);
        int         is_choice = strchr(kind, '|') != NULL;
        if (!strcmp(kind, "size or null")) return json_is_null(value) ? 1 : check_number(r, name, value, "size");
        if (!strcmp(kind, "spread")) {
            static const char *const members[] = {"min", "median", "max"};
            double                   of[3];
            if (!json_is_object(value)) return fault(r, name, "is missing or no object");
            for (size_t n = 0; n < 3; n++) {
                const json_t *number = json_object_get(value, members[n]);
                if (!check_number(r, members[n], number, "time")) return 0;
                of[n] = json_number_value(number);
            }
            return of[0] <= of[1] && of[1] <= of[2] ? 1 : fault(r, name, "has its median not between min and max");
        }
        if (!strcmp(kind, "bool")) return json_is_boolean(value) ? 1 : fault(r, name, "is neither true nor false");
        if (!is_choice && strcmp(kind, "text")) return check_number(r, name, value, kind);
        if (!json_is_string(value)) return fault(r, name, "is missing or no text");
        return !is_choice || choice_index(kind, json_string_value(value)) >= 0 ? 1 : fault(r, name, "is not one of %s", kind);
    }
    if (json_is_object(shape)) return check_object(r, name, value, shape);
    return check_array(r, name, value, shape) && (strcmp(name, "levels") || check_levels(r, value));
}

/* writer  the program that writes such files; path  of the file: both for the error.
 * Returns VXS_OK; VXS_E_READ: the shape differs, with the place in one line of m; VXS_E_MEMORY. */
static vxs_result json_shape_check(const json_t *value, const char *shape, const char *writer, const char *path, run_context *m)
{
    shape_reader reading = {.path = path, .writer = writer, .m = m};

    /* shapes have single quotes, which C can contain without escapes */
    char *text = strdup(shape);
    for (char *at = text; at && (at = strchr(at, '\''));) *at = '"';
    json_t *wanted = text ? json_loads(text, 0, NULL) : NULL;
    free(text);

    if (!wanted) return fail(m, VXS_E_MEMORY, "out of memory while reading %s", path);
    vxs_result r = VXS_OK;
    if (!json_is_object(value))
        r = fail(m, VXS_E_READ, "%s: not what %s writes: no object", path, writer);
    else if (!check_object(&reading, "", value, wanted))
        r = VXS_E_READ;
    json_decref(wanted);
    return r;
}

/* bakes ------------------------------------------------------------------------------------------------------------------------ */

/* The shape of a bench file. Names with a question mark exist for one coding only. */
static const char bench_shape[] =
    "{'cells': [4096, {"
    "     'scene': 'text', 'light': 'text', 'triangles': 'count', 'solid_triangles': 'count', 'lights': 'count', 'maps': 'count',"
    "     'options': {'resolution_px': 'side'},"
    "     'bake': {'wall_seconds': 'spread', 'total_seconds': 'spread', 'maps_to_words_seconds': 'spread', 'peak_bytes': 'count',"
    "         'stages': [32, {'name': 'text', 'seconds': 'spread', 'peak_bytes': 'count'}]},"
    "     'size': {'file_bytes': 'count', 'memory_bytes': 'count', 'nodes?': 'count', 'masks?': 'count', 'inserted_nodes?': "
    "'count',"
    "         'inserted_masks?': 'count',"
    "         'levels?': [32, {'side_voxels': 'u32', 'count': 'count', 'memory_bytes': 'count', 'stored_bytes': 'count'}],"
    "         'palette_blocks?': {'pages': 'count', 'nodes': 'count', 'blocks': 'count', 'tiles': 'count', 'private_tiles': "
    "'count',"
    "             'patterns': 'count'},"
    "         'parts?': [8, {'kind': 'tops|patterns|pages', 'count': 'count', 'memory_bytes': 'count', 'stored_bytes': 'count'}]},"
    "     'errors': [52,"
    "         {'points': 'random|surface', 'filter_px': 'u32', 'checked': 'count', 'wrong_share': 'share', 'leaks': 'count',"
    "          'false_shadows': 'count', 'unexplained': 'count'},"
    "         {'points': 'random|surface', 'filter_px': 'u32', 'smooth?': 'bool', 'checked': 'count', 'rmse': 'share',"
    "          'max_error': 'share'}],"
    "     'lookups': [26, {'filter_px': 'u32', 'nanoseconds': 'spread', 'ray_nanoseconds': 'spread'},"
    "         {'filter_px': 'u32', 'smooth?': 'bool', 'nanoseconds': 'spread'}]}],"
    " 'vxs': 'text', 'started': 'text', 'runs': 'u32', 'points': 'u32',"
    " 'machine': {'processor': 'text', 'cores': 'count', 'memory_bytes': 'count', 'system': 'text', 'renderer': 'text'}}";

vxs_result bench_json_check(const json_t *bench, const char *path, run_context *m)
{
    return json_shape_check(bench, bench_shape, "vxs bench", path, m);
}

vxs_result bench_json_read(json_t **result, const char *path, run_context *m)
{
    vxs_result r = json_read(result, path, m);
    if (r == VXS_OK && (r = bench_json_check(*result, path, m)) != VXS_OK) {
        json_decref(*result);
        *result = NULL;
    }
    return r;
}

/* Members ---------------------------------------------------------------------------------------------------------------------- */

json_t *json_at(const json_t *object, const char *path)
{
    while (object && *path) {
        size_t length = strcspn(path, "/");
        object = json_is_array(object) ? json_array_get(object, strtoul(path, NULL, 10)) : json_object_getn(object, path, length);
        path += length + (path[length] == '/');
    }
    return (json_t *)(size_t)object;
}

uint64_t count_at(const json_t *object, const char *path)
{
    return (uint64_t)json_integer_value(json_at(object, path));
}

double number_at(const json_t *object, const char *path)
{
    return json_number_value(json_at(object, path));
}

const char *text_at(const json_t *object, const char *path)
{
    const char *text = json_string_value(json_at(object, path));
    return text ? text : "";
}

spread spread_at(const json_t *object, const char *path, double unit)
{
    const json_t *s = json_at(object, path);
    return (spread){unit * number_at(s, "median"), unit * number_at(s, "min"), unit * number_at(s, "max")};
}

int bench_cells_equal(const json_t *a, const json_t *b)
{
    return json_equal(json_at(a, "scene"), json_at(b, "scene")) && json_equal(json_at(a, "options"), json_at(b, "options"));
}

/* fog -------------------------------------------------------------------------------------------------------------------------- */

#define ERROR                                                                                                                      \
    "{'relative_rms': 'size or null', 'signed_mean': 'number', 'percentile_99': 'size', 'most': 'size', 'values': 'count'}"
#define CELL "'technique': 'text', 'knob': 'text', 'value': 'u32', 'refused': 'bool', 'open_ms': 'time'"

/* The shape that the page needs. */
static const char volumes_shape[] =
    "{'machine': {'processor': 'text', 'cores': 'count', 'memory_bytes': 'count', 'system': 'text'},"
    " 'scenes': [256, {"
    "     'name': 'text', 'generator': 'text', 'file_bytes?': 'count', 'reference': 'text', 'light': 'text', 'renderer': 'text',"
    "     'clock': 'wall|processor', 'width_px': 'u32', 'height_px': 'u32', 'rounds': 'u32',"
    "     'claims?': [16, {'what': 'text', 'value': 'size', 'paper': 'size'}],"
    "     'techniques': [64, {'name': 'text', 'knob': 'text', 'limit': 'text', 'rival': 'bool'}],"
    "     'cells': [1024,"
    "         {" CELL ", 'ms': {'median': 'time', 'least': 'time', 'greatest': 'time'}, 'error': " ERROR ", 'epipole?': " ERROR ","
    "          'parts?': [3, {'name': 'text', 'ms': 'time'}], 'creation_ms?': 'time', 'bytes_per_texel?': 'size',"
    "          'flicker?': 'size', 'behind': 'size', 'front': 'bool'},"
    "         {" CELL "}]}]}";

int is_volumes_json(const json_t *measured)
{
    return json_object_get(measured, "scenes") != NULL;
}

vxs_result volumes_json_check(const json_t *volumes, const char *path, run_context *m)
{
    return json_shape_check(volumes, volumes_shape, "make bench-volumes", path, m);
}
