/* Metadata compared with a scene; see provenance_differences.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/provenance_differences.h"

#include <stdio.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/files/json_file.h"
#include "baker/scene/fingerprint.h"

vxs_result provenance_read(json_t **made, const vxs_contents *contents, run_context *m)
{
    *made = provenance_parse(contents);
    if (!json_memory_missing()) return VXS_OK;
    json_decref(*made);
    *made = NULL;
    return fail(m, VXS_E_MEMORY, "out of memory for the metadata of a file");
}

/* Whether a light of the metadata is in the file; names in the file may be truncated. */
static int is_baked(const vxs_contents *contents, const char *name)
{
    for (uint32_t n = 0; n < contents->light_count; n++) {
        const char *baked = contents->lights[n].light.name;
        if (strlen(name) < VXS_LIGHT_NAME_BYTES ? !strcmp(baked, name) : !strncmp(baked, name, strlen(baked))) return 1;
    }
    return 0;
}

/* "light 'lamp': position, range" */
static void add_light_difference(json_t *differences, const json_t *made, const scene *s)
{
    static const struct {
        const char *key, *word;
    } members[] = {
        {"kind", "kind"}, {"direction", "direction"}, {"position_m", "position"}, {"range_m", "range"}, {"outer_rad", "cone"}};
    const char        *name = json_string_value(json_object_get(made, "name")), *before = ": ";
    const scene_light *l = s->lights, *end = l + s->light_count;
    json_t            *is        = json_object();
    char               words[64] = "";
    while (l < end && strcmp(l->name, name)) l++;
    if (l < end) provenance_set_shape(&is, &l->shape);
    for (size_t n = 0; l < end && n < sizeof members / sizeof *members; n++) {
        const json_t *a = json_object_get(made, members[n].key), *b = json_object_get(is, members[n].key);
        if (a == b || json_equal(a, b)) continue;
        strcat(strcat(words, before), members[n].word);
        before = ", ";
    }
    if (l == end || words[0])
        json_array_append_new(differences, json_sprintf("light '%s'%s", name, l < end ? words : ": not there"));
    json_decref(is);
}

static json_t *differences_of(const json_t *made, const vxs_contents *contents, const scene *s, const scene_fingerprint *f)
{
    const struct {
        const char *key, *word, *is;
    } prints[] = {
        {"geometry", "geometry", f->geometry}, {"alpha_masks", "alpha masks", f->alpha_masks}, {"cameras", "cameras", f->cameras}};
    json_t *differences = json_array(), *was = json_object_get(made, "scene"), *light;
    size_t  index;
    for (size_t n = 0; was && n < sizeof prints / sizeof *prints; n++)
        if (strcmp(json_string_value(json_object_get(was, prints[n].key)), prints[n].is) != 0)
            json_array_append_new(differences, json_string(prints[n].word));
    json_array_foreach(json_object_get(made, "lights"), index, light)
    {
        if (!json_is_true(json_object_get(light, "in_scene"))) continue;
        if (is_baked(contents, json_string_value(json_object_get(light, "name")))) add_light_difference(differences, light, s);
    }
    /* a different name alone is no difference; else the name selects the scene of a file */
    const char *name = json_string_value(json_object_get(was, "name"));
    if (name && name[0] && json_array_size(differences) && strcmp(name, s->name))
        json_array_insert_new(differences, 0, json_sprintf("name, which was '%s'", name));
    return differences;
}

vxs_result provenance_differences(json_t **differences, const json_t *made, const vxs_contents *contents, const scene *s,
                                  run_context *m)
{
    scene_fingerprint f;
    *differences = NULL;
    vxs_result r = scene_fingerprint_take(&f, s, m);
    if (r != VXS_OK) return r;
    *differences = differences_of(made, contents, s, &f);
    if (!json_memory_missing()) return VXS_OK;
    json_decref(*differences);
    *differences = NULL;
    return fail(m, VXS_E_MEMORY, "out of memory for what differs from the scene that was baked");
}

enum { DIFFERENCES_SAID = 4 };

const char *provenance_differences_text(char text[PROVENANCE_TEXT_BYTES], const json_t *differences)
{
    size_t  used = 0, size = PROVENANCE_TEXT_BYTES, n;
    json_t *one;
    text[0] = '\0';
    json_array_foreach(differences, n, one)
    {
        if (n < DIFFERENCES_SAID) used += (size_t)snprintf(text + used, size - used, "%s%s", n ? "; " : "", json_string_value(one));
        if (used >= size) break;
    }
    if (used < size && n > DIFFERENCES_SAID)
        used += (size_t)snprintf(text + used, size - used, "; and %zu more", n - DIFFERENCES_SAID);
    if (used >= size) memcpy(text + size - sizeof "...", "...", sizeof "...");
    return one_line(text);
}
