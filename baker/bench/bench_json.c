/* Measurements as JSON; see bench_json.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bench/bench_json.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/integer.h"
#include "baker/files/json_file.h"

/* To JSON ---------------------------------------------------------------------------------------------------------------------- */

static json_t *integer(uint64_t value)
{
    return json_integer((json_int_t)value);
}

static json_t *spread_json(const spread *s)
{
    return json_pack("{s:f, s:f, s:f}", "median", s->median, "min", s->min, "max", s->max);
}

static json_t *bake_json(const bench_cell *c)
{
    json_t *stages = json_array();
    for (uint32_t n = 0; n < c->stage_count; n++) {
        const bench_stage *s = &c->stages[n];
        json_array_append_new(stages, json_pack("{s:s, s:o, s:o}", "name", s->name, "seconds", spread_json(&s->seconds),
                                                "peak_bytes", integer(s->peak_bytes)));
    }
    return json_pack("{s:o, s:o, s:o, s:o, s:o}", "wall_seconds", spread_json(&c->wall_seconds), "total_seconds",
                     spread_json(&c->total_seconds), "maps_to_dag_seconds", spread_json(&c->maps_to_dag_seconds), "stages", stages,
                     "peak_bytes", integer(c->peak_bytes));
}

/* The root first, masks last. */
static json_t *levels_json(const bench_cell *c)
{
    json_t *levels = json_array();
    for (int n = BENCH_LEVELS_MAX; n-- > 0;) {
        const bench_level *l = &c->levels[n];
        if (c->level_set >> n & 1)
            json_array_append_new(levels, json_pack("{s:o, s:o, s:o, s:o}", "side_voxels", integer(n ? 1u << n : 0), "count",
                                                    integer(l->count), "memory_bytes", integer(l->memory_bytes), "stored_bytes",
                                                    integer(l->stored_bytes)));
    }
    return levels;
}

static json_t *size_json(const bench_cell *c)
{
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "file_bytes", integer(c->file_bytes), "memory_bytes",
                     integer(c->memory_bytes), "nodes", integer(c->nodes), "masks", integer(c->masks), "inserted_nodes",
                     integer(c->inserted_nodes), "inserted_masks", integer(c->inserted_masks), "levels", levels_json(c));
}

static json_t *error_json(const bench_error *e)
{
    char    points[32];
    json_t *object = json_pack("{s:s, s:o, s:o}", "points", choice_word(points, BENCH_POINTS_WORDS, (int)e->points), "filter_px",
                               integer(e->filter_px), "checked", integer(e->checked));
    if (e->filter_px > 1) {
        json_object_set_new(object, "rmse", json_real(e->rmse));
        json_object_set_new(object, "max_error", json_real(e->max_error));
        return object;
    }
    json_object_set_new(object, "wrong_share", json_real(e->wrong_share));
    json_object_set_new(object, "leaks", integer(e->leaks));
    json_object_set_new(object, "false_shadows", integer(e->false_shadows));
    json_object_set_new(object, "unexplained", integer(e->unexplained));
    return object;
}

static json_t *cell_json(const bench_cell *c)
{
    json_t *errors = json_array(), *lookups = json_array();
    for (uint32_t n = 0; n < c->error_count; n++) json_array_append_new(errors, error_json(&c->errors[n]));
    for (uint32_t n = 0; n < c->lookup_count; n++) {
        const bench_lookup *l = &c->lookups[n];
        json_t *lookup = json_pack("{s:o, s:o}", "filter_px", integer(l->filter_px), "nanoseconds", spread_json(&l->nanoseconds));
        if (l->filter_px == 1) json_object_set_new(lookup, "ray_nanoseconds", spread_json(&l->ray_nanoseconds));
        json_array_append_new(lookups, lookup);
    }
    return json_pack("{s:s, s:o, s:o, s:o, s:o, s:o, s:O, s:o, s:o, s:o, s:o}", "scene", c->scene, "triangles",
                     integer(c->triangles), "solid_triangles", integer(c->solid_triangles), "light", json_text(c->light), "lights",
                     integer(c->lights), "maps", integer(c->maps), "options", c->options, "bake", bake_json(c), "size",
                     size_json(c), "errors", errors, "lookups", lookups);
}

vxs_result bench_json_write(const char *path, const bench_result *r, message *m)
{
    const bench_machine *machine = &r->machine;
    json_t              *cells   = json_array();
    for (size_t n = 0; n < r->cell_count; n++) json_array_append_new(cells, cell_json(&r->cells[n]));
    json_t *root = json_pack("{s:s, s:s, s:{s:o, s:o, s:o, s:o, s:o}, s:o, s:o, s:o}", "vxs", r->vxs, "started", r->started,
                             "machine", "processor", json_text(machine->processor), "cores", integer(machine->cores),
                             "memory_bytes", integer(machine->memory_bytes), "system", json_text(machine->system), "renderer",
                             json_text(machine->renderer), "runs", integer(r->runs), "points", integer(r->points), "cells", cells);
    return json_write(path, root, m);
}

/* From JSON -------------------------------------------------------------------------------------------------------------------- */

/* Where in the file it is, for messages: "cell 3". The first fault wins. */
typedef struct reader {
    const char *path;
    char        at[64];
    message    *m;
    vxs_result  result;
} reader;

static int fault(reader *r, const char *what)
{
    if (r->result == VXS_OK)
        r->result = fail(r->m, VXS_E_READ, "%s: not what vxs bench writes: %s%s%s", r->path, r->at, r->at[0] ? ": " : "", what);
    return 0;
}

static int no_memory(reader *r)
{
    if (r->result == VXS_OK) r->result = fail(r->m, VXS_E_MEMORY, "out of memory while reading %s", r->path);
    return 0;
}

static const json_t *member(reader *r, const json_t *object, const char *name, int type, const char *expected)
{
    char          what[128];
    const json_t *value = json_object_get(object, name);
    if (value && (int)json_typeof(value) == type) return value;
    snprintf(what, sizeof what, "\"%s\" is missing or no %s", name, expected);
    fault(r, what);
    return NULL;
}

static const json_t *read_object(reader *r, const json_t *object, const char *name)
{
    return member(r, object, name, JSON_OBJECT, "object");
}

/* An array of `most` objects at most. */
static const json_t *read_objects(reader *r, const json_t *object, const char *name, size_t most)
{
    char          what[128];
    const json_t *array = member(r, object, name, JSON_ARRAY, "array"), *item;
    size_t        n;
    if (!array) return NULL;
    snprintf(what, sizeof what, "\"%s\" has %zu items, expected at most %zu", name, json_array_size(array), most);
    if (json_array_size(array) > most && !fault(r, what)) return NULL;
    snprintf(what, sizeof what, "\"%s\" has an item that is no object", name);
    json_array_foreach(array, n, item) if (!json_is_object(item) && !fault(r, what)) return NULL;
    return array;
}

static int read_text(reader *r, const json_t *object, const char *name, char **text)
{
    const json_t *value = member(r, object, name, JSON_STRING, "text");
    if (!value) return 0;
    *text = strdup(json_string_value(value));
    return *text ? 1 : no_memory(r);
}

static int read_count(reader *r, const json_t *object, const char *name, uint64_t *count)
{
    char          what[128];
    const json_t *value = member(r, object, name, JSON_INTEGER, "whole number");
    *count              = 0;
    if (!value) return 0;
    snprintf(what, sizeof what, "\"%s\" is negative", name);
    if (json_integer_value(value) < 0) return fault(r, what);
    *count = (uint64_t)json_integer_value(value);
    return 1;
}

static int read_count_u32(reader *r, const json_t *object, const char *name, uint32_t *count)
{
    char     what[128];
    uint64_t value;
    if (!read_count(r, object, name, &value)) return 0;
    snprintf(what, sizeof what, "\"%s\" is too large", name);
    if (value > UINT32_MAX) return fault(r, what);
    *count = (uint32_t)value;
    return 1;
}

/* A number from 0 to `most`. */
static int read_number(reader *r, const json_t *object, const char *name, double most, double *number)
{
    char          what[128];
    const json_t *value = json_object_get(object, name);
    *number             = json_number_value(value);
    if (json_is_number(value) && *number >= 0 && *number <= most) return 1;
    snprintf(what, sizeof what, "\"%s\" is missing or no number from 0 to %g", name, most);
    return fault(r, what);
}

static int read_spread(reader *r, const json_t *object, const char *name, spread *s)
{
    static const double most  = 1e15;
    const json_t       *value = read_object(r, object, name);
    char                what[128];
    if (!value || !read_number(r, value, "median", most, &s->median) || !read_number(r, value, "min", most, &s->min) ||
        !read_number(r, value, "max", most, &s->max))
        return 0;
    snprintf(what, sizeof what, "\"%s\" has its median not between min and max", name);
    return s->min <= s->median && s->median <= s->max ? 1 : fault(r, what);
}

static int read_bake(reader *r, bench_cell *c, const json_t *bake)
{
    const json_t *stages = bake ? read_objects(r, bake, "stages", BENCH_STAGES_MAX) : NULL, *stage;
    size_t        n;
    if (!stages || !read_spread(r, bake, "wall_seconds", &c->wall_seconds) ||
        !read_spread(r, bake, "total_seconds", &c->total_seconds) ||
        !read_spread(r, bake, "maps_to_dag_seconds", &c->maps_to_dag_seconds) || !read_count(r, bake, "peak_bytes", &c->peak_bytes))
        return 0;
    json_array_foreach(stages, n, stage)
    {
        bench_stage  *s    = &c->stages[n];
        const json_t *name = member(r, stage, "name", JSON_STRING, "text");
        if (!name || !read_spread(r, stage, "seconds", &s->seconds) || !read_count(r, stage, "peak_bytes", &s->peak_bytes))
            return 0;
        snprintf(s->name, sizeof s->name, "%s", json_string_value(name));
    }
    c->stage_count = (uint32_t)n;
    return 1;
}

static int read_size(reader *r, bench_cell *c, const json_t *size)
{
    const json_t *levels = size ? read_objects(r, size, "levels", BENCH_LEVELS_MAX) : NULL, *level;
    size_t        n;
    if (!levels || !read_count(r, size, "file_bytes", &c->file_bytes) || !read_count(r, size, "memory_bytes", &c->memory_bytes) ||
        !read_count(r, size, "nodes", &c->nodes) || !read_count(r, size, "masks", &c->masks) ||
        !read_count(r, size, "inserted_nodes", &c->inserted_nodes) || !read_count(r, size, "inserted_masks", &c->inserted_masks))
        return 0;
    json_array_foreach(levels, n, level)
    {
        uint32_t side;
        if (!read_count_u32(r, level, "side_voxels", &side)) return 0;
        if ((side & (side - 1)) || side == 1) return fault(r, "\"side_voxels\" is neither 0 nor a power of two");
        uint32_t     at = side ? log2_u32(side) : 0;
        bench_level *l  = &c->levels[at];
        if (c->level_set >> at & 1) return fault(r, "\"levels\" has a side twice");
        if (!read_count(r, level, "count", &l->count) || !read_count(r, level, "memory_bytes", &l->memory_bytes) ||
            !read_count(r, level, "stored_bytes", &l->stored_bytes))
            return 0;
        c->level_set |= 1u << at;
    }
    return 1;
}

static int read_error(reader *r, bench_error *e, const json_t *error)
{
    const json_t *points = member(r, error, "points", JSON_STRING, "text");
    int           kind   = points ? choice_index(BENCH_POINTS_WORDS, json_string_value(points)) : 0;
    if (!points || !read_count_u32(r, error, "filter_px", &e->filter_px) || !read_count(r, error, "checked", &e->checked)) return 0;
    if (kind < 0) return fault(r, "\"points\" is not one of " BENCH_POINTS_WORDS);
    e->points = (bench_points)kind;
    if (e->filter_px > 1) return read_number(r, error, "rmse", 1, &e->rmse) && read_number(r, error, "max_error", 1, &e->max_error);
    return read_number(r, error, "wrong_share", 1, &e->wrong_share) && read_count(r, error, "leaks", &e->leaks) &&
           read_count(r, error, "false_shadows", &e->false_shadows) && read_count(r, error, "unexplained", &e->unexplained);
}

static int read_lookup(reader *r, bench_lookup *l, const json_t *lookup)
{
    return read_count_u32(r, lookup, "filter_px", &l->filter_px) && read_spread(r, lookup, "nanoseconds", &l->nanoseconds) &&
           (l->filter_px > 1 || read_spread(r, lookup, "ray_nanoseconds", &l->ray_nanoseconds));
}

static int require_resolution(reader *r, const json_t *options)
{
    const json_t *side = json_object_get(options, "resolution_px");
    if (json_is_integer(side) && json_integer_value(side) >= 8 && json_integer_value(side) <= 1 << 24) return 1;
    return fault(r, "\"resolution_px\" is no whole number from 8 to 2^24");
}

static int read_cell(reader *r, bench_cell *c, const json_t *cell)
{
    const json_t *errors  = read_objects(r, cell, "errors", sizeof c->errors / sizeof *c->errors);
    const json_t *lookups = read_objects(r, cell, "lookups", BENCH_FILTERS_MAX), *item;
    const json_t *options = read_object(r, cell, "options");
    size_t        n;
    if (!errors || !lookups || !options || !read_text(r, cell, "scene", &c->scene) || !read_text(r, cell, "light", &c->light) ||
        !read_count(r, cell, "triangles", &c->triangles) || !read_count(r, cell, "solid_triangles", &c->solid_triangles) ||
        !read_count(r, cell, "lights", &c->lights) || !read_count(r, cell, "maps", &c->maps) ||
        !require_resolution(r, options) || !read_bake(r, c, read_object(r, cell, "bake")) || !read_size(r, c, read_object(r, cell, "size")))
        return 0;
    json_array_foreach(errors, n, item) if (!read_error(r, &c->errors[n], item)) return 0;
    c->error_count = (uint32_t)json_array_size(errors);
    json_array_foreach(lookups, n, item) if (!read_lookup(r, &c->lookups[n], item)) return 0;
    c->lookup_count = (uint32_t)json_array_size(lookups);
    c->options      = json_incref((json_t *)options);
    c->key          = bench_key(c->scene, c->options);
    return c->key ? 1 : no_memory(r);
}

static int read_machine(reader *r, bench_machine *machine, const json_t *value)
{
    return value && read_text(r, value, "processor", &machine->processor) && read_count(r, value, "cores", &machine->cores) &&
           read_count(r, value, "memory_bytes", &machine->memory_bytes) && read_text(r, value, "system", &machine->system) &&
           read_text(r, value, "renderer", &machine->renderer);
}

static void read_result(reader *r, bench_result *result, const json_t *root)
{
    const json_t *cells = json_is_object(root) ? read_objects(r, root, "cells", BENCH_CELLS_MAX) : NULL, *cell;
    size_t        n;
    if (!json_is_object(root)) fault(r, "no object");
    if (!cells || !read_text(r, root, "vxs", &result->vxs) || !read_text(r, root, "started", &result->started) ||
        !read_machine(r, &result->machine, read_object(r, root, "machine")) || !read_count_u32(r, root, "runs", &result->runs) ||
        !read_count_u32(r, root, "points", &result->points))
        return;
    result->cells = calloc(json_array_size(cells) + 1, sizeof *result->cells);
    if (!result->cells && !no_memory(r)) return;
    result->cell_count = json_array_size(cells);
    json_array_foreach(cells, n, cell)
    {
        snprintf(r->at, sizeof r->at, "cell %zu", n + 1);
        if (!read_cell(r, &result->cells[n], cell)) return;
    }
}

vxs_result bench_json_read(bench_result *result, const char *path, message *m)
{
    json_t    *root;
    vxs_result r = json_read(&root, path, m);
    if (r != VXS_OK) return r;
    reader reading = {.path = path, .m = m, .result = VXS_OK};
    read_result(&reading, result, root);
    json_decref(root);
    return reading.result;
}
