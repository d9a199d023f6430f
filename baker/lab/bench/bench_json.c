/* Measurements as JSON; see bench_json.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/bench/bench_json.h"

#include <stdlib.h>
#include <string.h>

#include "baker/files/json_file.h"
#include "baker/lab/bench/json_shape.h"

/* The shape of a bench file (json_shape.h). Names with a question mark exist for one coding only. */
static const char file_shape[] =
    "{'cells': [4096, {"
    "     'scene': 'text', 'light': 'text', 'triangles': 'count', 'solid_triangles': 'count', 'lights': 'count', 'maps': 'count',"
    "     'options': {'resolution_px': 'side'},"
    "     'bake': {'wall_seconds': 'spread', 'total_seconds': 'spread', 'maps_to_words_seconds': 'spread', 'peak_bytes': 'count',"
    "         'stages': [32, {'name': 'text', 'seconds': 'spread', 'peak_bytes': 'count'}]},"
    "     'size': {'file_bytes': 'count', 'memory_bytes': 'count', 'nodes?': 'count', 'masks?': 'count', 'inserted_nodes?': "
    "'count',"
    "         'inserted_masks?': 'count',"
    "         'levels?': [32, {'side_voxels': 'u32', 'count': 'count', 'memory_bytes': 'count', 'stored_bytes': 'count'}],"
    "         'palette_blocks?': {'pages': 'count', 'nodes': 'count', 'blocks': 'count', 'tiles': 'count', 'own_tiles': 'count',"
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

vxs_result bench_json_check(const json_t *bench, const char *path, message *m)
{
    return json_shape_check(bench, file_shape, "vxs bench", path, m);
}

vxs_result bench_json_read(json_t **result, const char *path, message *m)
{
    vxs_result r = json_read(result, path, m);
    if (r == VXS_OK && (r = bench_json_check(*result, path, m)) != VXS_OK) {
        json_decref(*result);
        *result = NULL;
    }
    return r;
}

/* Members --------------------------------------------------------------------------------------------------------------------- */

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
