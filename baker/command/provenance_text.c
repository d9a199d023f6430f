/* The provenance of an asset as text; see provenance_text.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/provenance_text.h"

#include <string.h>

#include "baker/base/text.h"
#include "baker/command/options/bake_arguments.h"

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

/* A file without a coding in its metadata was baked with DAGs. */
static void print_coding(FILE *to, const json_t *options, coding_choice default_coding)
{
    if (json_object_get(options, "coding"))
        print_word(to, options, "coding", CODING_CHOICES, (int)default_coding);
    else if (options && default_coding != CODING_DAG)
        fprintf(to, " --coding dag");
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
    print_coding(to, options, defaults.o.coding);
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

void provenance_print(FILE *to, const json_t *made)
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
