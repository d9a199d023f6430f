/* Opening a .vxs file; see asset_open.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/asset_open.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "baker/base/array.h"
#include "baker/base/nearest.h"
#include "baker/base/parallel.h"
#include "baker/command/provenance_differences.h"
#include "baker/files/input_file.h"
#include "baker/scene/light_choice.h"
#include "formats/vxs_bytes.h"
#include "formats/vxs_desc.h"

/* limit on the bytes of a file, if none is given */
#define READ_MAX ((uint64_t)4 << 30)

void keep_first_finding(void *user, int number, const char *text, int section, uint64_t offset)
{
    first_finding *f = user;
    if (!f->number) *f = (first_finding){number, section, offset, text};
}

/* The file's size as its header states it. 0 when the header is invalid: the bytes read so far suffice for the error. */
static uint64_t wanted_bytes(void *user, const uint8_t *first, size_t size_bytes)
{
    (void)user;
    if (size_bytes < VXS_HEADER_BYTES || memcmp(first, VXS_MAGIC, VXS_MAGIC_BYTES) != 0) return 0;
    uint32_t version = vxs_load32(first + VXS_HEADER_VERSION);
    int      known   = version >= 1 && version <= VXS_FORMAT_VERSION;
    return known && XXH64(first, VXS_HEADER_HASH, 0) == vxs_load64(first + VXS_HEADER_HASH)
               ? vxs_load64(first + VXS_HEADER_FILE_BYTES)
               : 0;
}

vxs_result asset_read_keeping(vxs_asset **asset, vxs_bytes *kept, const char *path, const vxs_read_desc *desc, run_context *m)
{
    vxs_read_desc rest      = *desc;
    uint64_t      most      = desc->memory_limit_bytes ? desc->memory_limit_bytes - 1 : READ_MAX;
    *kept                   = (vxs_bytes){0};
    *asset                  = NULL;
    vxs_result r            = input_read(&kept->data, &kept->size_bytes, path, most, &(input_head){wanted_bytes, NULL}, m);
    uint64_t   limit        = vxs_memory_limit_of(desc, kept->size_bytes); /* larger than the file in any case */
    rest.memory_limit_bytes = limit - kept->size_bytes;
    return r == VXS_OK ? vxs_asset_open(asset, kept->data, kept->size_bytes, &rest) : r;
}

vxs_result asset_read(vxs_asset **asset, const char *path, const vxs_read_desc *desc, run_context *m)
{
    vxs_bytes  bytes;
    vxs_result r = asset_read_keeping(asset, &bytes, path, desc, m);
    free(bytes.data);
    return r;
}

vxs_result asset_fail(const char *path, vxs_result r, const first_finding *found, const char *remedy, run_context *m)
{
    first_finding f = *found;
    path            = input_name(path);
    if (!f.number) return fail(m, r, "cannot read '%s': %s", path, vxs_result_text(r));
    char where[32] = "the header";
    if (f.section >= 0) snprintf(where, sizeof where, "section %d", f.section);
    const char *judgement = r == VXS_E_MEMORY ? "cannot be opened" : "is not a valid .vxs file";
    return fail(m, r, "'%s' %s: %s (finding %d at byte %llu, in %s)%s", path, judgement, f.text, f.number,
                (unsigned long long)f.offset, where, r == VXS_E_MEMORY ? remedy : "");
}

vxs_result asset_open(vxs_asset **asset, const char *path, uint64_t memory_bytes, int metadata, uint32_t threads, run_context *m)
{
    first_finding found = {0};
    vxs_parallel  lent  = parallel_lent(threads);
    vxs_read_desc desc  = {.memory_limit_bytes = memory_bytes,
                           .metadata           = metadata,
                           .parallel           = &lent,
                           .finding            = keep_first_finding,
                           .finding_user       = &found};
    vxs_result    r     = asset_read(asset, path, &desc, m);
    return r == VXS_OK ? r : asset_fail(path, r, &found, "; --memory of info, validate and query sets it", m);
}

uint64_t asset_file_bytes(const vxs_asset *asset)
{
    const vxs_contents *c    = vxs_asset_contents(asset);
    const vxs_section  *last = &c->sections[c->section_count - 1];
    return last->offset_bytes + last->stored_bytes;
}

/* The metadata is untrusted input: skip items that are not strings. */
static vxs_result add_patterns(text_list *list, const json_t *patterns, run_context *m)
{
    json_t *pattern;
    size_t  n;
    json_array_foreach(patterns, n, pattern)
    {
        if (!json_is_string(pattern)) continue;
        if (!array_reserve(&list->items, &list->capacity, list->count + 1, sizeof *list->items))
            return fail(m, VXS_E_MEMORY, "out of memory for what casts");
        list->items[list->count++] = json_string_value(pattern);
    }
    return VXS_OK;
}

/* An option in the metadata counts as given on the command line. */
static void take_word(const json_t *options, const char *key, const char *choices, int *value, int *given)
{
    const char *word  = json_string_value(json_object_get(options, key));
    int         index = word ? choice_index(choices, word) : -1;
    if (index < 0) return;
    *value = index;
    *given = 1;
}

vxs_result asset_scene_choice(const json_t *made, scene_choice *choice, run_context *m)
{
    const json_t *options = json_object_get(made, "options");
    if (choice->exclude.count || choice->include.count || choice->skinned_given || choice->blend_given) return VXS_OK;
    take_word(options, "skinned", SKINNED_CHOICES, &choice->skinned, &choice->skinned_given);
    take_word(options, "blend", BLEND_CHOICES, &choice->blend, &choice->blend_given);
    vxs_result r = add_patterns(&choice->exclude, json_object_get(options, "exclude"), m);
    return r == VXS_OK ? add_patterns(&choice->include, json_object_get(options, "include"), m) : r;
}

vxs_result asset_check_scene(const vxs_contents *asset, const json_t *made, const char *path, const scene *s,
                             const char *scene_path, const char *consequence, run_context *m)
{
    char       differ[PROVENANCE_TEXT_BYTES];
    json_t    *differences;
    vxs_result r = provenance_differences(&differences, made, asset, s, m);
    if (json_array_size(differences))
        warn(m, "'%s' was baked from another scene than %s (differs: %s): %s; bake it anew", input_name(path),
             input_name(scene_path), provenance_differences_text(differ, differences), consequence);
    json_decref(differences);
    return r == VXS_OK ? run_check(m) : r;
}

static vxs_result fail_no_such_light(const vxs_contents *asset, const char *path, const char *name, run_context *m)
{
    nearest near              = {.typed = name};
    char    known[LIST_BYTES] = "", meant[64];
    for (uint32_t n = 0; n < asset->light_count; n++) {
        const char *light = asset->lights[n].light.name;
        list_item(known, light);
        nearest_try(&near, light, strlen(light));
    }
    return fail(m, VXS_E_ARGUMENT, "--light %s: '%s' has no light of that name; it has %s%s", name, path, known,
                nearest_text(meant, &near));
}

static int is_among(const vxs_baked_light *light, const vxs_baked_light *const *lights, uint32_t count)
{
    for (uint32_t n = 0; n < count; n++)
        if (lights[n] == light) return 1;
    return 0;
}

vxs_result asset_choose_lights(const vxs_contents *asset, const char *path, const text_list *names, const vxs_baked_light **lights,
                               uint32_t *count, run_context *m)
{
    *count = 0;
    if (!names->count)
        for (uint32_t n = 0; n < asset->light_count; n++) lights[(*count)++] = &asset->lights[n];
    for (size_t k = 0; k < names->count; k++) {
        const char            *name  = names->items[k];
        const vxs_baked_light *light = asset->lights, *end = light + asset->light_count;
        uint32_t               matched = 0;
        while (light < end && strcmp(light->light.name, name)) light++;
        if (light < end) {
            if (is_among(light, lights, *count)) return fail(m, VXS_E_ARGUMENT, "--light %s is given twice", name);
            lights[(*count)++] = light;
            continue;
        }
        for (uint32_t n = 0; n < asset->light_count; n++) { /* a pattern adds all that it matches, except those already chosen */
            if (!light_name_matches(name, n, asset->lights[n].light.name)) continue;
            matched++;
            if (!is_among(&asset->lights[n], lights, *count)) lights[(*count)++] = &asset->lights[n];
        }
        if (!matched) return fail_no_such_light(asset, path, name, m);
    }
    return VXS_OK;
}

void asset_find_smoke(const vxs_asset *asset, const vxs_baked_light *const *lights, uint32_t count, const vxs_baked_smoke **smoke)
{
    for (uint32_t n = 0; n < count; n++) smoke[n] = vxs_asset_smoke(asset, (uint32_t)(lights[n] - vxs_asset_light(asset, 0)));
}
