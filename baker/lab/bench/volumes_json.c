/* Measurements of shadows in fog; see volumes_json.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/bench/volumes_json.h"

#include "baker/lab/bench/json_shape.h"

#define ERROR                                                                                                                      \
    "{'relative_rms': 'size or null', 'signed_mean': 'number', 'percentile_99': 'size', 'most': 'size', 'values': 'count'}"
#define CELL "'technique': 'text', 'knob': 'text', 'value': 'u32', 'refused': 'bool', 'open_ms': 'time'"

/* The shape that the page needs. */
static const char file_shape[] =
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

vxs_result volumes_json_check(const json_t *volumes, const char *path, message *m)
{
    return json_shape_check(volumes, file_shape, "make bench-volumes", path, m);
}
