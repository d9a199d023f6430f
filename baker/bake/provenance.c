/* Provenance of an asset; see provenance.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/provenance.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "baker/base/text.h"
#include "baker/base/version.h"
#include "baker/files/input_file.h"
#include "baker/files/json_value.h"
#include "baker/scene/fingerprint.h"

/* vxs never writes more. JSON takes about twenty times its text in memory. */
enum { METADATA_MAX_BYTES = 4 << 20 };

/* input ----------------------------------------------------------------------------------------------------------------------- */

/* Without -0, which equals 0. */
static json_t *number_json(double number)
{
    return json_real(number + 0.0);
}

static json_t *vector_json(const double v[3])
{
    return json_pack("[o, o, o]", number_json(v[0]), number_json(v[1]), number_json(v[2]));
}

void provenance_set_shape(json_t **object, const light_shape *l)
{
    json_set(object, "kind", json_string(light_kind_name(l->kind)));
    if (l->kind != LIGHT_POINT) json_set(object, "direction", vector_json(l->direction_ws));
    if (l->kind == LIGHT_DIRECTIONAL) return;
    json_set(object, "position_m", vector_json(l->position_ws));
    if (isfinite(l->range_metres)) json_set(object, "range_m", number_json(l->range_metres));
    if (l->kind == LIGHT_SPOT) json_set(object, "outer_rad", number_json(l->outer_rad));
}

/* Options, and the fingerprint of the smoke, if there is some. */
static json_t *options_json(const bake_options *o, const bake_scene *s)
{
    json_t      *options = bake_choices_json(o);
    smoke_source source  = bake_scene_smoke(s, o);
    char         text[SMOKE_FINGERPRINT_BYTES];
    if (!source.grid && !source.capsules) return options;
    json_t *smoke = bake_smoke_json(o);
    if (source.grid) {
        smoke_grid_fingerprint(source.grid, text);
        json_set(&smoke, "grid", json_string(text));
    }
    if (source.capsules) {
        smoke_capsules_fingerprint(source.capsules, text);
        json_set(&smoke, "capsules", json_string(text));
    }
    json_set(&options, "smoke", smoke);
    return options;
}

vxs_result provenance_inputs(json_t **inputs, const bake_options *o, const bake_scene *s, const light_choice *chosen,
                             run_context *m)
{
    json_t *lights = json_array();
    for (const chosen_light *l = chosen->lights; l < chosen->lights + chosen->count; l++) {
        double   texel_metres;
        uint32_t side   = light_resolution(o, l->name, &texel_metres);
        json_t  *object = json_pack("{s:o, s:b}", "name", json_text(l->name), "in_scene", !l->is_option);
        provenance_set_shape(&object, &l->shape);
        json_set(&object, side ? "resolution_px" : "texel_m", side ? json_integer(side) : number_json(texel_metres));
        json_append(&lights, object);
    }
    *inputs = json_pack("{s:s, s:o, s:o, s:o}", "generator", "vxs " VXS_VERSION, "scene",
                        json_pack("{s:o, s:I, s:s, s:s, s:s, s:s}", "name", json_text(s->scene.name), "triangles",
                                  (json_int_t)s->scene.triangle_count, "geometry", s->fingerprint.geometry, "alpha_masks",
                                  s->fingerprint.alpha_masks, "cameras", s->fingerprint.cameras, "lights", s->fingerprint.lights),
                        "lights", lights, "options", options_json(o, s));
    return *inputs ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for what is to be baked");
}

/* results --------------------------------------------------------------------------------------------------------------------- */

char *provenance_text(const bake_report *report)
{
    json_t *root     = json_object(); /* json_copy silently omits values if memory runs out */
    json_t *outcome  = json_pack("{s:I, s:I, s:I, s:o, s:I}", "triangles", (json_int_t)casters_whole_count(&report->casters),
                                 "solids", (json_int_t)report->casters.component_count[COMPONENT_SOLID], "solid_triangles",
                                 (json_int_t)report->casters.solid_triangle_count, "left_out", report_left_out_json(report),
                                 "warnings", (json_int_t)report->warning_count);
    int     is_whole = outcome && !json_object_update(root, report->inputs) && !json_object_update(root, outcome);
    char   *text     = is_whole ? json_whole_text(root, JSON_COMPACT) : NULL;
    json_decref(outcome);
    json_decref(root);
    return text;
}

/* reading --------------------------------------------------------------------------------------------------------------------- */

/* Whether a value has the members and types of a format of json_unpack. */
#define HAS_TYPES(value, ...) (!json_unpack_ex(value, NULL, JSON_VALIDATE_ONLY, __VA_ARGS__))

static int is_light(json_t *light)
{
    return HAS_TYPES(light, "{s:s, s:b, s:s, s?[F, F, F!], s?[F, F, F!], s?F, s?F, s?I, s?F}", "name", "in_scene", "kind",
                     "direction", "position_m", "range_m", "outer_rad", "resolution_px", "texel_m");
}

static int is_left_out(json_t *light)
{
    return HAS_TYPES(light, "{s:s, s:s}", "name", "why");
}

/* An array of items that `is_item` accepts, or NULL. */
static int is_list(const json_t *list, int (*is_item)(json_t *item))
{
    json_t *item;
    size_t  n;
    if (list && !json_is_array(list)) return 0;
    json_array_foreach(list, n, item) if (!is_item(item)) return 0;
    return 1;
}

json_t *provenance_parse(const vxs_contents *contents)
{
    if (!contents->metadata || contents->metadata_bytes > METADATA_MAX_BYTES) return NULL;
    json_t *root = json_loadb(contents->metadata, contents->metadata_bytes, JSON_REJECT_DUPLICATES, NULL);

    /* check the types of members that vxs writes; older versions wrote fewer members */
    json_t *input = json_object_get(root, "scene"), *options = json_object_get(root, "options");
    if (HAS_TYPES(root, "{s:s, s?I, s?I, s?I, s?I}", "generator", "triangles", "solids", "solid_triangles", "warnings") &&
        (!input ||
         HAS_TYPES(input, "{s:s, s:I, s:s, s:s, s:s, s:s}", "name", "triangles", "geometry", "alpha_masks", "cameras", "lights")) &&
        (!options ||
         HAS_TYPES(options, "{s?s, s?s, s?s, s?F, s?s, s?s, s?s, s?s, s?s, s?s, s?I, s?[F, F, F, F, F, F!]}", "closed", "exit",
                   "behind", "thickness_m", "coding", "pack", "rule", "stop", "reuse", "gl", "zstd_level", "region_m")) &&
        is_list(json_object_get(root, "lights"), is_light) && is_list(json_object_get(root, "left_out"), is_left_out))
        return root;

    json_decref(root);
    return NULL;
}

/* The asset of a file; NULL: there is none that can be read.   size_bytes  [out] */
static vxs_asset *open_asset(const char *path, uint64_t *size_bytes, const run_context *m)
{
    struct stat         status;
    run_context         unheard = {.access = m->access, .memory_bytes = m->memory_bytes};
    uint8_t            *bytes   = NULL;
    size_t              count   = 0;
    vxs_asset          *asset   = NULL;
    const vxs_read_desc desc    = {.metadata = 1};
    if (!m->access) {
        if (stat(path, &status) || !S_ISREG(status.st_mode)) return NULL; /* reading a pipe without a writer would block */
        vxs_asset_open_file(&asset, path, &desc);
        *size_bytes = (uint64_t)status.st_size;
    } else if (input_read(&bytes, &count, path, SIZE_MAX, NULL, &unheard) == VXS_OK) {
        vxs_asset_open(&asset, bytes, count, &desc);
        *size_bytes = count;
    }
    free(bytes);
    return asset;
}

int provenance_is_current(const char *path, const json_t *inputs, uint64_t *file_bytes, size_t *warning_count, const run_context *m)
{
    vxs_asset *asset = open_asset(path, file_bytes, m);
    if (!asset) return 0;
    json_t     *made    = provenance_parse(vxs_asset_contents(asset)), *input;
    int         current = 1;
    const char *key;
    json_object_foreach((json_t *)(size_t)inputs, key, input) current &= json_equal(json_object_get(made, key), input);
    *warning_count = (size_t)json_integer_value(json_object_get(made, "warnings"));
    json_decref(made);
    vxs_asset_close(asset);
    return current;
}
