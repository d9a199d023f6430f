/* Options as JSON; see bake_options.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/bake_options.h"

#include "baker/files/input_file.h"
#include "baker/files/json_value.h"
#include "baker/smoke/smoke_grid.h"

static void set_word(json_t **object, const char *key, const char *choices, int index)
{
    char word[32];
    json_set(object, key, json_string(choice_word(word, choices, index)));
}

/* A coding and its own options. Files omit the DAG coding, which was once the only one, and small packing. */
static void set_coding(json_t **object, const bake_options *o)
{
    if (o->coding != CODING_DAG) {
        set_word(object, "coding", CODING_CHOICES, (int)o->coding);
        if (o->pack != PACK_SMALL) set_word(object, "pack", PACK_CHOICES, (int)o->pack);
        return;
    }
    set_word(object, "rule", RULE_CHOICES, (int)o->rule);
    set_word(object, "stop", STOP_CHOICES, (int)o->stop);
    if (o->stop == STOP_INSERT) set_word(object, "reuse", REUSE_CHOICES, o->reuse); /* compression gives the same result */
}

json_t *bake_choices_json(const bake_options *o)
{
    json_t       *object = json_object();
    const double *b      = o->region_ws;
    set_word(&object, "closed", CLOSED_CHOICES, (int)o->closed);
    set_word(&object, "exit", EXIT_CHOICES, (int)o->exit);
    /* files omit OpenGL, which was once the only source of depths */
    if (o->maps == MAPS_SPARSE) set_word(&object, "maps", MAPS_CHOICES, (int)o->maps);
    if (o->behind != BEHIND_SHADOW) set_word(&object, "behind", BEHIND_CHOICES, (int)o->behind);
    if (o->thickness_metres > 0) json_set(&object, "thickness_m", json_real(o->thickness_metres));
    set_coding(&object, o);
    set_word(&object, "gl", GL_CHOICES, (int)o->gl);
    json_set(&object, "zstd_level", json_integer(o->zstd_level));
    if (o->points) json_set(&object, "points", json_integer(o->points));
    if (o->region_given) json_set(&object, "region_m", json_pack("[f,f,f,f,f,f]", b[0], b[1], b[2], b[3], b[4], b[5]));
    if (o->scene.exclude.count) json_set(&object, "exclude", json_texts(&o->scene.exclude));
    if (o->scene.include.count) json_set(&object, "include", json_texts(&o->scene.include));
    if (o->scene.skinned != SKINNED_EXCLUDE) set_word(&object, "skinned", SKINNED_CHOICES, o->scene.skinned);
    if (o->scene.blend != BLEND_MASK) set_word(&object, "blend", BLEND_CHOICES, o->scene.blend);
    return object;
}

json_t *bake_smoke_json(const bake_options *o)
{
    json_t *smoke =
        json_pack("{s:f, s:i, s:f}", "extinction", o->smoke_factor, "nodes", (int)o->smoke.nodes, "error", o->smoke.error);
    if (o->smoke.side_px) json_set(&smoke, "side_px", json_integer(o->smoke.side_px));
    return smoke;
}

/* Without memory there are no values, and the object becomes NULL. */
static void set_unless_empty(json_t **object, const char *key, json_t *values, size_t count)
{
    if (!values || count)
        json_set(object, key, values);
    else
        json_decref(values);
}

/* {"noon": [0, -1, 0]}, or {"noon": 1024}, for entries with a name; omitted if there are none. */
static void set_named(json_t **object, const char *key, const named_list *list, json_t *(*value_json)(const double numbers[3]))
{
    json_t *values = json_object();
    for (const named_value *v = list->items; v < list->items + list->count; v++)
        if (v->name) json_set(&values, v->name, value_json(v->numbers));
    set_unless_empty(object, key, values, json_object_size(values));
}

static json_t *whole_json(const double numbers[3])
{
    return json_integer((json_int_t)numbers[0]);
}

static json_t *real_json(const double numbers[3])
{
    return json_real(numbers[0]);
}

json_t *bake_options_json(const bake_options *o)
{
    json_t *object = bake_choices_json(o);
    if (bakes_smoke(o)) json_set(&object, "smoke", bake_smoke_json(o));
    json_t *names = json_array();
    for (size_t n = 0; n < o->light_names.count; n++) json_append(&names, json_text(o->light_names.items[n]));
    set_unless_empty(&object, "light", names, json_array_size(names));
    set_named(&object, "sun", &o->suns, json_vector);
    if (o->resolution)
        json_set(&object, "resolution_px", json_integer(o->resolution));
    else
        json_set(&object, "texel_m", json_real(o->texel_metres));
    set_named(&object, "light_resolution_px", &o->resolutions, whole_json);
    set_named(&object, "light_texel_m", &o->texels, real_json);

    set_word(&object, "coding", CODING_CHOICES, (int)o->coding);
    if (o->coding == CODING_DAG) {
        set_word(&object, "reuse", REUSE_CHOICES, o->reuse);
        set_word(&object, "compress", COMPRESS_CHOICES, (int)o->compress);
    } else
        set_word(&object, "pack", PACK_CHOICES, (int)o->pack);
    json_set(&object, "threads", json_integer(o->threads));
    if (o->memory_bytes) json_set(&object, "memory_bytes", json_integer((json_int_t)o->memory_bytes));
    return object;
}

uint32_t light_resolution(const bake_options *o, const char *light_name, double *texel_metres)
{
    const named_value *resolution = named_find(&o->resolutions, light_name), *texel = named_find(&o->texels, light_name);
    *texel_metres = texel ? texel->numbers[0] : o->texel_metres;
    return resolution ? (uint32_t)resolution->numbers[0] : texel ? 0 : o->resolution;
}

compress_order compress_order_of(compress_choice choice)
{
    return choice == COMPRESS_CHOICE_BOTTOM_UP ? COMPRESS_BOTTOM_UP : COMPRESS_TOP_DOWN;
}

build_options build_options_of(const bake_options *o, compress_order compress)
{
    /* share equal parts where the merge would find them anyway; keep inserted parts separate where they are left side by side */
    return (build_options){.rule     = o->rule,
                           .reuse    = o->reuse,
                           .compress = o->stop == STOP_INSERT ? COMPRESS_NONE : compress,
                           .share    = o->reuse && o->stop == STOP_FINAL};
}

vxs_result bake_scene_read(bake_scene *s, const bake_options *o, const scene_check *check, bake_context *ctx)
{
    watch_say(ctx->watch, "reading %s", o->scene_path);
    s->file_bytes = input_bytes(o->scene_path, ctx->run);
    vxs_result r  = scene_load_gltf_checked(&s->scene, o->scene_path, &o->scene, check, ctx->run);
    return r == VXS_OK ? scene_fingerprint_take(&s->fingerprint, &s->scene, ctx->run) : r;
}

vxs_result bake_scene_read_smoke(bake_scene *s, const bake_options *o, bake_context *ctx)
{
    if (!o->smoke_path) return VXS_OK;
    watch_say(ctx->watch, "reading %s", o->smoke_path);
    return nrrd_read(&s->smoke, o->smoke_path, o->smoke_factor, ctx->run);
}

smoke_source bake_scene_smoke(const bake_scene *s, const bake_options *o)
{
    return (smoke_source){.grid     = s->smoke.extinction ? &s->smoke : NULL,
                          .capsules = o->scene_smoke && s->scene.smoke.count ? &s->scene.smoke : NULL};
}

vxs_result bake_scene_find_casters(bake_scene *s, const bake_options *o, bake_context *ctx)
{
    vxs_result r;
    stage_begin(ctx, STAGE_SOLIDS);
    if ((r = context_check(ctx)) != VXS_OK) return r;
    watch_say(ctx->watch, "telling solids from sheets");
    return casters_for_maps(&s->casters, &s->scene, o->closed, o->threads, ctx->run);
}

void bake_scene_free(bake_scene *s)
{
    casters_free(&s->casters);
    smoke_grid_free(&s->smoke);
    scene_free(&s->scene);
    *s = (bake_scene){0};
}
