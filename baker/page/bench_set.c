/* Measurements as series; see bench_set.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/page/bench_set.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/bench/bench_json.h"
#include "baker/page/html.h"

/* files ----------------------------------------------------------------------------------------------------------------------- */

static vxs_result read_file(bench_set *set, uint32_t number, const char *path, message *m)
{
    set_file  *f = &set->files[number];
    vxs_result r = bench_json_read(&f->result, path, m);
    f->path      = path;
    if (r != VXS_OK) return r;
    if (!f->result.cell_count) return fail(m, VXS_E_READ, "%s: no cells: expected one at least", path);
    set_cell *longer = realloc(set->cells, (set->cell_count + f->result.cell_count) * sizeof *longer);
    if (!longer) return fail(m, VXS_E_MEMORY, "out of memory for %s", path);
    set->cells = longer;
    for (size_t n = 0; n < f->result.cell_count; n++) {
        const bench_cell *c    = &f->result.cells[n];
        const json_t     *side = json_object_get(c->options, "resolution_px");
        if (!json_is_integer(side) || json_integer_value(side) < 8 || json_integer_value(side) > 1 << 24)
            return fail(m, VXS_E_READ, "%s: cell %zu: \"resolution_px\" is no whole number from 8 to %d", path, n + 1, 1 << 24);
        set->cells[set->cell_count++] = (set_cell){.measured = c, .file = number, .side_px = json_number_value(side)};
    }
    return VXS_OK;
}

/* names ----------------------------------------------------------------------------------------------------------------------- */

static vxs_result no_memory(message *m)
{
    return fail(m, VXS_E_MEMORY, "out of memory for the names of scenes and settings");
}

/* The index of a name in a list, which takes it in when it is new; the name is released or owned by the list. -1 without memory. */
static int take_name(char ***names, size_t *count, char *name)
{
    if (!name) return -1;
    for (size_t n = 0; n < *count; n++)
        if (!strcmp((*names)[n], name)) {
            free(name);
            return (int)n;
        }
    char **longer = realloc(*names, (*count + 1) * sizeof *longer);
    if (!longer) {
        free(name);
        return -1;
    }
    *names           = longer;
    longer[(*count)] = name;
    return (int)(*count)++;
}

static const json_t *sun_of(const bench_cell *c)
{
    return json_object_get(c->options, "sun");
}

/* Whether a scene is there with several lights first, or several suns. */
static int is_ambiguous(const bench_set *set, const bench_cell *c)
{
    for (size_t n = 0; n < set->cell_count; n++) {
        const bench_cell *other = set->cells[n].measured;
        if (strcmp(other->scene, c->scene)) continue;
        if (strcmp(other->light, c->light) || (sun_of(c) && sun_of(other) && !json_equal(sun_of(c), sun_of(other)))) return 1;
    }
    return 0;
}

/* A value as an option would have it: no quotes about words. NULL without memory. */
static char *value_text(const json_t *value)
{
    return json_is_string(value) ? strdup(json_string_value(value))
                                 : json_dumps(value, JSON_ENCODE_ANY | JSON_COMPACT | JSON_REAL_PRECISION(9));
}

static char *scene_label(const bench_set *set, const bench_cell *c)
{
    char *label = NULL, *sun = sun_of(c) ? value_text(sun_of(c)) : NULL;
    int   length = is_ambiguous(set, c) ? asprintf(&label, "%s, %s%s%s", c->scene, c->light, sun ? " " : "", sun ? sun : "")
                                        : asprintf(&label, "%s", c->scene);
    free(sun);
    return length < 0 ? NULL : clean_text(label);
}

/* Options that make a setting: a resolution is a place on its line, and a sun belongs to its scene. */
static int is_of_setting(const char *key)
{
    return strcmp(key, "resolution_px") && strcmp(key, "sun");
}

/* "rule shadow, stop insert": the options of a cell that are not as `base` has them. */
static char *differences(const json_t *options, const json_t *base)
{
    char       *text = NULL;
    size_t      size;
    FILE       *to = open_memstream(&text, &size);
    const char *key, *before = "";
    json_t     *value;
    if (!to) return NULL;
    json_object_foreach((json_t *)(size_t)options, key, value)
    {
        if (!is_of_setting(key) || json_equal(value, json_object_get(base, key))) continue;
        char *word = value_text(value);
        fprintf(to, "%s%s %s", before, key, word ? word : "?");
        free(word);
        before = ", ";
    }
    json_object_foreach((json_t *)(size_t)base, key, value)
    {
        if (!is_of_setting(key) || json_object_get(options, key)) continue;
        fprintf(to, "%sno %s", before, key);
        before = ", ";
    }
    int failed = ferror(to);
    if (fclose(to) || failed) {
        free(text);
        return NULL;
    }
    return clean_text(text);
}

/* Options of the first cell that any other has otherwise: the first cell, against what all cells agree on. */
static vxs_result find_base(bench_set *set, message *m)
{
    const json_t *first  = set->cells[0].measured->options;
    json_t       *common = json_copy((json_t *)(size_t)first);
    const char   *key;
    json_t       *value;
    for (size_t n = 0; n < set->cell_count && common; n++) json_object_foreach((json_t *)(size_t)first, key, value)
        {
            if (!json_equal(value, json_object_get(set->cells[n].measured->options, key))) json_object_del(common, key);
        }
    set->base = common ? differences(first, common) : NULL;
    json_decref(common);
    return set->base ? VXS_OK : no_memory(m);
}

static vxs_result name_cells(bench_set *set, message *m)
{
    const json_t *first = set->cells[0].measured->options;
    for (size_t n = 0; n < set->cell_count; n++) {
        set_cell *c       = &set->cells[n];
        char     *setting = differences(c->measured->options, first);
        if (setting && !*setting) {
            free(setting);
            setting = strdup("base");
        }
        int scene = take_name(&set->scenes, &set->scene_count, scene_label(set, c->measured));
        int named = take_name(&set->settings, &set->setting_count, setting);
        if (scene < 0 || named < 0) return no_memory(m);
        c->scene   = (uint32_t)scene;
        c->setting = (uint32_t)named;
    }
    return VXS_OK;
}

static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

/* The last part of a path, all of it where two would be the same, and a number where that does not help. */
static vxs_result label_files(bench_set *set, message *m)
{
    for (size_t n = 0; n < set->file_count; n++) {
        const char *path = set->files[n].path, *name = base_name(path);
        size_t      same_name = 0, before = 0;
        for (size_t k = 0; k < set->file_count; k++) {
            same_name += !strcmp(base_name(set->files[k].path), name);
            before += k < n && !strcmp(set->files[k].path, path);
        }
        char *label;
        int length = before ? asprintf(&label, "%s (%zu)", path, before + 1) : asprintf(&label, "%s", same_name > 1 ? path : name);
        if (length < 0) return no_memory(m);
        set->files[n].label = clean_text(label);
    }
    return VXS_OK;
}

/* series ---------------------------------------------------------------------------------------------------------------------- */

static bench_series *series_of(bench_set *set, const set_cell *c)
{
    for (size_t n = 0; n < set->series_count; n++) {
        bench_series *s = &set->series[n];
        if (s->file == c->file && s->scene == c->scene && s->setting == c->setting) return s;
    }
    bench_series *s = &set->series[set->series_count++];
    *s              = (bench_series){.file = c->file, .scene = c->scene, .setting = c->setting};
    return s;
}

/* A bake that is there twice stays twice. */
static void insert_by_resolution(const bench_set *set, bench_series *s, uint32_t cell)
{
    size_t at = s->count++;
    for (; at && set->cells[s->cells[at - 1]].side_px > set->cells[cell].side_px; at--) s->cells[at] = s->cells[at - 1];
    s->cells[at] = cell;
}

static vxs_result make_series(bench_set *set, message *m)
{
    set->series = calloc(set->cell_count, sizeof *set->series);
    if (!set->series) return no_memory(m);
    for (size_t n = 0; n < set->cell_count; n++) {
        bench_series *s      = series_of(set, &set->cells[n]);
        uint32_t     *longer = realloc(s->cells, (s->count + 1) * sizeof *longer);
        if (!longer) return no_memory(m);
        s->cells = longer;
        insert_by_resolution(set, s, (uint32_t)n);
    }
    return VXS_OK;
}

/* all ------------------------------------------------------------------------------------------------------------------------- */

vxs_result bench_set_read(bench_set *set, const char *const *paths, size_t count, message *m)
{
    vxs_result r = VXS_OK;
    memset(set, 0, sizeof *set);
    set->files = calloc(count + 1, sizeof *set->files);
    if (!set->files) return no_memory(m);
    for (size_t n = 0; n < count && r == VXS_OK; n++) {
        set->file_count++;
        r = read_file(set, (uint32_t)n, paths[n], m);
    }
    if (r == VXS_OK) r = label_files(set, m);
    if (r == VXS_OK) r = find_base(set, m);
    if (r == VXS_OK) r = name_cells(set, m);
    if (r == VXS_OK) r = make_series(set, m);
    return r;
}

static void free_names(char **names, size_t count)
{
    for (size_t n = 0; n < count; n++) free(names[n]);
    free(names);
}

void bench_set_free(bench_set *set)
{
    for (size_t n = 0; n < set->file_count; n++) {
        free(set->files[n].label);
        bench_result_free(&set->files[n].result);
    }
    for (size_t n = 0; n < set->series_count; n++) free(set->series[n].cells);
    free_names(set->scenes, set->scene_count);
    free_names(set->settings, set->setting_count);
    free(set->base);
    free(set->files);
    free(set->cells);
    free(set->series);
    memset(set, 0, sizeof *set);
}

const bench_error *bench_error_of(const bench_cell *c, bench_points points, uint32_t filter_px)
{
    for (size_t n = 0; n < c->error_count; n++)
        if (c->errors[n].points == points && c->errors[n].filter_px == filter_px) return &c->errors[n];
    return NULL;
}

const bench_lookup *bench_lookup_of(const bench_cell *c, uint32_t filter_px)
{
    for (size_t n = 0; n < c->lookup_count; n++)
        if (c->lookups[n].filter_px == filter_px) return &c->lookups[n];
    return NULL;
}

double bench_rmse(const bench_error *e)
{
    return e->filter_px == 1 ? sqrt(e->wrong_share) : e->rmse;
}

const char *bench_points_text(bench_points points)
{
    return points == BENCH_RANDOM ? "random points" : "surface points";
}
