/* vxs info: what a .vxs file holds.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/command/asset_open.h"
#include "baker/command/commands.h"
#include "baker/command/light_text.h"
#include "baker/files/json_file.h"
#include "baker/options/options.h"

static const char *section_name(uint32_t kind)
{
    switch (kind) {
    case VXS_KIND_LIGHTS: return "lights";
    case VXS_KIND_LEVEL: return "nodes";
    case VXS_KIND_MASKS: return "masks";
    case VXS_KIND_METADATA: return "metadata";
    default: return "unknown";
    }
}

/* Nodes or masks of a section, and the words that they take; 0 for others. */
static uint32_t section_count(const vxs_contents *c, const vxs_section *s, uint64_t *memory_bytes)
{
    *memory_bytes = 0;
    if (s->kind == VXS_KIND_LEVEL) {
        *memory_bytes = (uint64_t)c->lights[s->light].counts.node_words[s->level] * 4;
        return c->lights[s->light].counts.nodes[s->level];
    }
    if (s->kind == VXS_KIND_MASKS) {
        *memory_bytes = (uint64_t)c->lights[s->light].counts.masks * 8;
        return c->lights[s->light].counts.masks;
    }
    return 0;
}

static vxs_result print_info(const char *path, const vxs_contents *c, uint64_t file_bytes, message *m)
{
    char  a[32], b[32];
    char *metadata = c->metadata ? strdup(c->metadata) : NULL;
    if (c->metadata && !metadata) return fail(m, VXS_E_MEMORY, "out of memory for the metadata of '%s'", path);
    printf("%s: .vxs version %u, %s, %u lights\n", path, c->version, size_text(a, file_bytes), c->light_count);
    if (metadata) printf("metadata     %s\n", one_line(metadata));
    free(metadata);
    for (uint32_t n = 0; n < c->light_count; n++) {
        const vxs_light *l = &c->lights[n].light;
        char             name[VXS_LIGHT_NAME_BYTES], text[LIGHT_TEXT_BYTES];
        printf("light %s: %s, %s in memory\n", one_line(strcpy(name, l->name)), light_text(text, l),
               size_text(a, (uint64_t)c->lights[n].dag.word_count * 4));
    }
    printf("%-10s %-16s %10s %12s %12s %12s\n", "section", "light", "count", "memory", "inflated", "on disk");
    for (uint32_t n = 0; n < c->section_count; n++) {
        const vxs_section *s = &c->sections[n];
        char               name[32], memory_text[32], light[VXS_LIGHT_NAME_BYTES];
        uint64_t           memory;
        uint32_t           count = section_count(c, s, &memory);
        if (s->kind == VXS_KIND_LEVEL)
            snprintf(name, sizeof name, "%u^3", 8u << s->level);
        else
            snprintf(name, sizeof name, "%s", section_name(s->kind));
        printf("%-10s %-16s %10u %12s %12s %12s\n", name,
               one_line(strcpy(light, s->light < c->light_count ? c->lights[s->light].light.name : "-")), count,
               size_text(memory_text, memory), size_text(a, s->inflated_bytes), size_text(b, s->stored_bytes));
    }
    return VXS_OK;
}

static json_t *info_json(const char *path, const vxs_contents *c, uint64_t file_bytes)
{
    json_t *lights = json_array(), *sections = json_array();
    for (uint32_t n = 0; n < c->light_count; n++) {
        const vxs_light *l      = &c->lights[n].light;
        json_t          *matrix = json_array(), *light = light_json(l);
        for (int k = 0; k < 12; k++) json_array_append_new(matrix, json_real(l->ls_from_ws[k]));
        json_object_set_new(light, "ls_from_ws", matrix);
        json_object_set_new(light, "memory_bytes", json_integer((json_int_t)c->lights[n].dag.word_count * 4));
        json_array_append_new(lights, light);
    }
    for (uint32_t n = 0; n < c->section_count; n++) {
        const vxs_section *s = &c->sections[n];
        uint64_t           memory;
        uint32_t           count = section_count(c, s, &memory);
        json_t            *entry = json_pack("{s:s, s:I, s:I, s:I, s:I, s:I}", "kind", section_name(s->kind), "offset_bytes",
                                             (json_int_t)s->offset_bytes, "stored_bytes", (json_int_t)s->stored_bytes, "inflated_bytes",
                                             (json_int_t)s->inflated_bytes, "memory_bytes", (json_int_t)memory, "count", (json_int_t)count);
        if (s->light < c->light_count) json_object_set_new(entry, "light", json_text(c->lights[s->light].light.name));
        if (s->kind == VXS_KIND_LEVEL) json_object_set_new(entry, "side_voxels", json_integer((json_int_t)8 << s->level));
        json_array_append_new(sections, entry);
    }
    json_t *root     = json_pack("{s:o, s:i, s:I, s:o, s:o}", "file", json_text(path), "version", (int)c->version, "file_bytes",
                                 (json_int_t)file_bytes, "lights", lights, "sections", sections);
    json_t *metadata = c->metadata ? json_loads(c->metadata, 0, NULL) : NULL;
    if (root && metadata) json_object_set_new(root, "metadata", metadata);
    return root;
}

int cmd_info(int argc, char **argv)
{
    const char  *json_path = NULL, *path = NULL;
    const option options[] = {
        {"--json", OPTION_TEXT, &json_path, 0, 0, NULL, "FILE", "the same as JSON; - is standard output", NULL}};
    const command_line line  = {"info", "FILE.vxs [--json FILE]", "Lights, resolution, nodes and bytes of a .vxs file.", options, 1,
                                1};
    message            m     = {0};
    vxs_asset         *asset = NULL;
    int                help_shown;
    vxs_result         r = options_parse(&line, argc, argv, &path, &help_shown, &m);
    if (r == VXS_OK && !help_shown && (r = asset_open(&asset, path, &m)) == VXS_OK) {
        const vxs_contents *c          = vxs_asset_contents(asset);
        uint64_t            file_bytes = asset_file_bytes(asset);
        if (!is_standard_output(json_path)) r = print_info(path, c, file_bytes, &m);
        if (json_path && r == VXS_OK) r = json_write(json_path, info_json(path, c, file_bytes), &m);
    }
    vxs_asset_close(asset);
    return command_end(&m, r);
}
