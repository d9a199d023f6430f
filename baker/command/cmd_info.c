/* vxs info: the contents of a .vxs file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <jansson.h>
#include <stdio.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/base/text.h"
#include "baker/command/asset_open.h"
#include "baker/command/commands.h"
#include "baker/command/light_text.h"
#include "baker/command/options/bake_arguments.h"
#include "baker/command/options/options.h"
#include "baker/command/provenance_differences.h"
#include "baker/command/report/report.h"
#include "baker/files/input_file.h"
#include "baker/files/json_file.h"

/* A string from a file, made printable and cut: it may have any content and length. */
static void print_string(FILE *to, const json_t *string)
{
    char text[256];
    snprintf(text, sizeof text, "%s", json_string_value(string));
    fputs(one_line(text), to);
}

/* Print a name or pattern from a file, quoted for a shell: it may contain blanks and special characters. */
static void print_argument(FILE *to, const json_t *string)
{
    char text[256];
    snprintf(text, sizeof text, "%s", json_string_value(string));
    if (!one_line(text)[strcspn(text, " \"#$&'()*;<>?[\\]`{|}~!")]) {
        fputs(text, to);
        return;
    }
    fputc('\'', to);
    print_quoted(to, text, "");
    fputc('\'', to);
}

static void print_numbers(FILE *to, const json_t *numbers)
{
    json_t *number;
    size_t  n;
    json_array_foreach(numbers, n, number) fprintf(to, "%s%.9g", n ? "," : "", json_number_value(number));
}

static long long integer_at(const json_t *object, const char *key)
{
    return json_integer_value(json_object_get(object, key));
}

static void print_scene(FILE *to, const json_t *made)
{
    static const char *const prints[][2] = {
        {"geometry", "geometry"}, {"alpha_masks", "alpha masks"}, {"cameras", "cameras"}, {"lights", "lights"}};
    const json_t *input = json_object_get(made, "scene");
    long long     read = integer_at(input, "triangles"), cast = integer_at(made, "triangles"), solids = integer_at(made, "solids");
    fprintf(to, "scene        ");
    if (input) print_string(to, json_object_get(input, "name"));
    if (json_string_length(json_object_get(input, "name"))) fprintf(to, ": ");
    if (input && read != cast) fprintf(to, "%lld triangles; ", read); /* triangles without area cast no shadow */
    fprintf(to, "%lld triangles cast shadows, %lld of them in %lld solid%s\nfingerprint  ", cast,
            integer_at(made, "solid_triangles"), solids, solids == 1 ? "" : "s");
    for (size_t n = 0; input && n < sizeof prints / sizeof *prints; n++) {
        fprintf(to, "%s%s ", n ? ", " : "", prints[n][1]);
        print_string(to, json_object_get(input, prints[n][0]));
    }
    fprintf(to, "%s\n", input ? "" : "none: no scene can be told from the one that was baked");
}

/* Print an option that is a word, unless it is the default. */
static void print_word(FILE *to, const json_t *options, const char *key, const char *choices, int default_index)
{
    char          word[32];
    const json_t *value = json_object_get(options, key);
    if (!value || !strcmp(json_string_value(value), choice_word(word, choices, default_index))) return;
    fprintf(to, " --%s ", key);
    print_string(to, value);
}

/* The size options of the lights' maps: those of the first light for all, then the lights that differ. */
static void print_size(FILE *to, const json_t *light, const json_t *first)
{
    const char   *key  = json_object_get(light, "resolution_px") ? "resolution_px" : "texel_m";
    const json_t *size = json_object_get(light, key);
    if (light != first && json_equal(size, json_object_get(first, key))) return;
    fprintf(to, strcmp(key, "texel_m") ? " --resolution " : " --texel ");
    if (light != first) {
        print_argument(to, json_object_get(light, "name"));
        fprintf(to, "=");
    }
    fprintf(to, "%.9g", json_number_value(size));
}

/* " --exclude 'Door*' --exclude Glass" */
static void print_patterns(FILE *to, const json_t *options, const char *key)
{
    json_t *pattern;
    size_t  n;
    json_array_foreach(json_object_get(options, key), n, pattern)
    {
        if (!json_is_string(pattern)) continue;
        fprintf(to, " --%s ", key);
        print_argument(to, pattern);
    }
}

/* Print values in the syntax of the command line. */
static void print_options(FILE *to, const json_t *made)
{
    const json_t  *lights = json_object_get(made, "lights"), *options = json_object_get(made, "options"), *light;
    size_t         n;
    bake_arguments defaults;
    bake_arguments_init(&defaults, "bake", "", "", 0);
    fprintf(to, "options     ");
    json_array_foreach(lights, n, light)
    {
        if (json_is_true(json_object_get(light, "in_scene"))) continue;
        fprintf(to, " --sun ");
        if (strcmp(json_string_value(json_object_get(light, "name")), SUN_NAME)) {
            print_argument(to, json_object_get(light, "name"));
            fprintf(to, "=");
        }
        print_numbers(to, json_object_get(light, "direction"));
    }
    print_patterns(to, options, "exclude");
    print_patterns(to, options, "include");
    if (json_is_string(json_object_get(options, "skinned"))) print_word(to, options, "skinned", SKINNED_CHOICES, SKINNED_EXCLUDE);
    if (json_is_string(json_object_get(options, "blend"))) print_word(to, options, "blend", BLEND_CHOICES, BLEND_MASK);
    json_array_foreach(lights, n, light) print_size(to, light, json_array_get(lights, 0));
    if (json_object_get(options, "region_m")) {
        fprintf(to, " --region ");
        print_numbers(to, json_object_get(options, "region_m"));
    }
    print_word(to, options, "closed", CLOSED_CHOICES, (int)defaults.o.closed);
    print_word(to, options, "exit", EXIT_CHOICES, (int)defaults.o.exit);
    print_word(to, options, "behind", BEHIND_CHOICES, (int)defaults.o.behind);
    if (json_object_get(options, "thickness_m"))
        fprintf(to, " --thickness %.9g", json_number_value(json_object_get(options, "thickness_m")));
    if (!json_object_get(options, "maps")) fprintf(to, " --maps gl");
    /* a file without a coding in its metadata was baked with DAGs */
    if (json_object_get(options, "coding"))
        print_word(to, options, "coding", CODING_CHOICES, (int)defaults.o.coding);
    else if (options && defaults.o.coding != CODING_DAG)
        fprintf(to, " --coding dag");
    print_word(to, options, "pack", PACK_CHOICES, (int)defaults.o.pack);
    print_word(to, options, "rule", RULE_CHOICES, (int)defaults.o.rule);
    print_word(to, options, "stop", STOP_CHOICES, (int)defaults.o.stop);
    print_word(to, options, "reuse", REUSE_CHOICES, defaults.o.reuse);
    print_word(to, options, "gl", GL_CHOICES, (int)defaults.o.gl);
    if (json_object_get(options, "zstd_level") && integer_at(options, "zstd_level") != defaults.o.zstd_level)
        fprintf(to, " --level %lld", integer_at(options, "zstd_level"));
    fprintf(to, "\n");
}

static void print_smoke(FILE *to, const json_t *smoke)
{
    const json_t *grid = json_object_get(smoke, "grid"), *capsules = json_object_get(smoke, "capsules");
    if (!json_is_string(grid) && !json_is_string(capsules)) return;
    fprintf(to, "smoke        ");
    if (json_is_string(grid)) fprintf(to, "grid "), print_string(to, grid);
    if (json_is_string(capsules)) fprintf(to, json_is_string(grid) ? ", capsules " : "capsules "), print_string(to, capsules);
    fprintf(to, ": --smoke-extinction %.9g", json_number_value(json_object_get(smoke, "extinction")));
    if (json_object_get(smoke, "side_px")) fprintf(to, " --smoke-side %lld", integer_at(smoke, "side_px"));
    fprintf(to, " --smoke-nodes %lld --smoke-error %.9g\n", integer_at(smoke, "nodes"),
            json_number_value(json_object_get(smoke, "error")));
}

/* Print some lines: version, scene, fingerprints, options that are not default, lights that were left out. Unknown values are
 * omitted.
 * made  as provenance_read returns it, not NULL */
static void provenance_print(FILE *to, const json_t *made)
{
    json_t *light;
    size_t  n;
    fprintf(to, "made by      ");
    print_string(to, json_object_get(made, "generator"));
    if (integer_at(made, "warnings")) fprintf(to, ", warnings: %lld", integer_at(made, "warnings"));
    fprintf(to, "\n");
    print_scene(to, made);
    print_options(to, made);
    print_smoke(to, json_object_get(json_object_get(made, "options"), "smoke"));
    json_array_foreach(json_object_get(made, "left_out"), n, light)
    {
        fprintf(to, "left out     light ");
        print_string(to, json_object_get(light, "name"));
        fprintf(to, ": ");
        print_string(to, json_object_get(light, "why"));
        fprintf(to, "\n");
    }
}

/* The parts of a section: of a light, usually one part; of smoke; of points; of other sections only their kind.
 * parts  [out] [VXS_LEVELS_MAX]
 * Returns how many, 1 at least. */
static uint32_t section_parts(vxs_part *parts, const vxs_asset *asset, uint32_t section)
{
    const vxs_contents    *c     = vxs_asset_contents(asset);
    const vxs_section     *s     = &c->sections[section];
    const vxs_baked_smoke *smoke = s->kind == VXS_KIND_SMOKE ? vxs_asset_smoke(asset, s->light) : NULL;
    uint32_t               count = 0;
    if (smoke) parts[count++] = (vxs_part){"smoke", smoke->side_px, smoke->node_count, 4 * (uint64_t)smoke->word_count, section};
    for (uint32_t n = 0; s->light < c->light_count && n < c->lights[s->light].part_count; n++)
        if (c->lights[s->light].parts[n].section == section) parts[count++] = c->lights[s->light].parts[n];
    if (s->kind == VXS_KIND_POINTS) {
        uint32_t points = vxs_asset_points(asset)->count;
        parts[count++]  = (vxs_part){"points", 0, points, points * 3 * (uint64_t)sizeof(uint16_t), section};
    }
    if (!count)
        parts[count++] = (vxs_part){.kind = s->kind == VXS_KIND_LIGHTS     ? "lights"
                                            : s->kind == VXS_KIND_METADATA ? "metadata"
                                                                           : "unknown"};
    return count;
}

/* The coding of palette blocks' pages; NULL: the light is a DAG. */
static const char *packing_text(const vxs_baked_light *l)
{
    if (l->light.coding != VXS_CODING_BLOCKS) return NULL;
    return l->packing == VXS_PACKING_FAST ? "fast" : "small";
}

static void print_info(FILE *to, const char *path, const vxs_asset *asset, const json_t *made, uint64_t file_bytes)
{
    const vxs_contents *c = vxs_asset_contents(asset);
    char                a[32], plain[PLAIN_BYTES];
    fprintf(to, "%s: .vxs version %u, %s, %u light%s\n", plain_text(plain, path), c->version, size_text(a, file_bytes),
            c->light_count, c->light_count == 1 ? "" : "s");
    if (made) provenance_print(to, made);
    if (!made && c->metadata)
        fprintf(to, "made by      unknown: vxs did not write the metadata, %s\n", size_text(a, c->metadata_bytes));
    for (uint32_t n = 0; n < c->light_count; n++) {
        const vxs_light       *l = &c->lights[n].light;
        char                   name[VXS_LIGHT_NAME_BYTES], text[LIGHT_TEXT_BYTES];
        const char            *packing = packing_text(&c->lights[n]);
        const vxs_baked_smoke *smoke   = vxs_asset_smoke(asset, n);
        fprintf(to, "light %s: %s, %s in memory%s%s", one_line(strcpy(name, l->name)), light_text(text, l),
                size_text(a, (uint64_t)c->lights[n].word_count * 4), packing ? ", packed " : "", packing ? packing : "");
        if (smoke) fprintf(to, ", smoke of %u x %u curves", smoke->side_px, smoke->side_px);
        fprintf(to, "\n");
    }
    fprintf(to, "%-10s %-16s %10s %12s %12s %12s\n", "section", "light", "count", "memory", "inflated", "on disk");
    for (const vxs_section *s = c->sections; s < c->sections + c->section_count; s++) {
        vxs_part parts[VXS_LEVELS_MAX];
        uint32_t count = section_parts(parts, asset, (uint32_t)(s - c->sections));
        char     name[32], memory[32], inflated[32], stored[32], light[VXS_LIGHT_NAME_BYTES];
        for (uint32_t n = 0; n < count; n++) /* the section's size is in its first row */
            fprintf(to, "%-10s %-16s %10u %12s %12s %12s\n", part_name(name, &parts[n]),
                    one_line(strcpy(light, s->light < c->light_count ? c->lights[s->light].light.name : "-")), parts[n].count,
                    size_text(memory, parts[n].memory_bytes), n ? "-" : size_text(inflated, s->inflated_bytes),
                    n ? "-" : size_text(stored, s->stored_bytes));
    }
}

static json_t *info_json(const char *path, const vxs_asset *asset, json_t *made, uint64_t file_bytes)
{
    const vxs_contents *c      = vxs_asset_contents(asset);
    json_t             *lights = json_array(), *sections = json_array();
    for (uint32_t n = 0; n < c->light_count; n++) {
        const vxs_light *l      = &c->lights[n].light;
        json_t          *matrix = json_array(), *light = light_json(l);
        for (int k = 0; k < 12; k++) json_array_append_new(matrix, json_real(l->ls_from_ws[k]));
        json_object_set_new(light, "ls_from_ws", matrix);
        json_object_set_new(light, "memory_bytes", json_integer((json_int_t)c->lights[n].word_count * 4));
        if (packing_text(&c->lights[n])) json_object_set_new(light, "packing", json_string(packing_text(&c->lights[n])));
        json_array_append_new(lights, light);
    }
    for (uint32_t n = 0; n < c->section_count; n++) {
        const vxs_section *s = &c->sections[n];
        vxs_part           parts[VXS_LEVELS_MAX], part;
        uint32_t           count = section_parts(parts, asset, n);
        part                     = parts[0];
        for (uint32_t k = 1; k < count; k++) part.memory_bytes += parts[k].memory_bytes;
        json_t *entry = json_pack("{s:s, s:I, s:I, s:I, s:I, s:I}", "kind", part.kind, "offset_bytes", (json_int_t)s->offset_bytes,
                                  "stored_bytes", (json_int_t)s->stored_bytes, "inflated_bytes", (json_int_t)s->inflated_bytes,
                                  "memory_bytes", (json_int_t)part.memory_bytes, "count", (json_int_t)part.count);
        if (s->light < c->light_count) json_object_set_new(entry, "light", json_text(c->lights[s->light].light.name));
        if (s->kind == VXS_KIND_LEVEL) json_object_set_new(entry, "side_voxels", json_integer(part.side_voxels));
        if (s->kind == VXS_KIND_SMOKE) json_object_set_new(entry, "side_px", json_integer(part.side_voxels));
        json_array_append_new(sections, entry);
    }
    json_t *root = json_pack("{s:o, s:i, s:I, s:o, s:o}", "file", json_text(path), "version", (int)c->version, "file_bytes",
                             (json_int_t)file_bytes, "lights", lights, "sections", sections);
    if (made) json_object_set(root, "metadata", made);
    return root;
}

typedef struct info_command {
    const char *path, *json_path;
    uint64_t    memory_bytes;
} info_command;

static vxs_result run(void *command, run_context *m)
{
    const info_command *c     = command;
    vxs_asset          *asset = NULL;
    vxs_result          r     = asset_open(&asset, c->path, c->memory_bytes, 1, parallel_default_threads(), m);
    if (r != VXS_OK) return r;
    uint64_t file_bytes = asset_file_bytes(asset);
    FILE    *to         = is_standard_output(c->json_path) ? NULL : report_stream(m, 0);
    json_t  *made;
    if ((r = provenance_read(&made, vxs_asset_contents(asset), m)) == VXS_OK && to)
        print_info(to, input_name(c->path), asset, made, file_bytes);
    if (c->json_path && r == VXS_OK) r = json_write(c->json_path, info_json(c->path, asset, made, file_bytes), m);
    json_decref(made);
    vxs_asset_close(asset);
    return r;
}

int cmd_info(int argc, char **argv)
{
    info_command c         = {0};
    const option options[] = {
        {"FILE.vxs", OPTION_INPUT, &c.path, FILE_ASSET, 0, NULL, NULL, "what vxs bake wrote", NULL},
        {"--memory", OPTION_BYTES, &c.memory_bytes, 0, 0, NULL, "BYTES",
         "hold no more of the file in memory than this (default 256 times the file, 64M at least)", NULL},
        {"--json", OPTION_OUTPUT, &c.json_path, 0, 0, ".json", "FILE.json", "the same as JSON; - is standard output", NULL},
    };
    const command_line line =
        COMMAND_LINE("info", "FILE.vxs [options]",
                     "Say what a .vxs file holds. How it was made; its lights, resolution, nodes and bytes.", options);
    return command_run(&line, argc, argv, run, &c);
}
