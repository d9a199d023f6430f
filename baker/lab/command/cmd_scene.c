/* vxs scene: procedural test scenes (scenes/README.md has their purposes).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>
#include <string.h>

#include "baker/command/options/options.h"
#include "baker/files/output_file.h"
#include "baker/lab/command/lab_commands.h"
#include "baker/lab/command/report_text.h"
#include "baker/scene/gltf/glb_write.h"
#include "baker/scene/light_choice.h"
#include "scenes/generate.h"

#define SCENE_KINDS "city|landscape|room|forest|smoke|hair|stress"
typedef enum scene_kind { KIND_CITY, KIND_LANDSCAPE, KIND_ROOM, KIND_FOREST, KIND_SMOKE, KIND_HAIR, KIND_STRESS } scene_kind;

typedef struct scene_options {
    scene_kind   kind;
    city_options city;
    uint32_t     triangles, capsules, seed;
    double       sun[3], size_metres, height_metres;
    const char  *out, *stress_case;
    int          screen, triangles_given, seed_given, sun_given, blocks_given, spots_given, size_given, height_given, case_given,
        capsules_given;
} scene_options;

/* The options that are valid for each kind of scene. */
static vxs_result check_kind(const scene_options *o, run_context *m)
{
    const struct {
        const char *name, *kinds_in_words;
        int         given;
        unsigned    kinds;
    } rules[] = {
        {"--triangles", "city, landscape, room and forest only", o->triangles_given,
         ~(1u << KIND_STRESS | 1 << KIND_SMOKE | 1 << KIND_HAIR)},
        {"--seed", "all kinds but stress", o->seed_given, ~(1u << KIND_STRESS)},
        {"--sun", "city, landscape and forest only", o->sun_given, 1 << KIND_CITY | 1 << KIND_LANDSCAPE | 1 << KIND_FOREST},
        {"--blocks", "city only", o->blocks_given, 1 << KIND_CITY},
        {"--spots", "city only", o->spots_given, 1 << KIND_CITY},
        {"--size", "landscape and forest only", o->size_given, 1 << KIND_LANDSCAPE | 1 << KIND_FOREST},
        {"--height", "landscape only", o->height_given, 1 << KIND_LANDSCAPE},
        {"--capsules", "smoke and hair only", o->capsules_given, 1 << KIND_SMOKE | 1 << KIND_HAIR},
        {"--screen", "room only", o->screen, 1 << KIND_ROOM},
        {"--case", "stress only", o->case_given, 1 << KIND_STRESS},
    };
    for (size_t i = 0; i < sizeof rules / sizeof *rules; i++)
        if (rules[i].given && !(rules[i].kinds >> o->kind & 1))
            return fail(m, VXS_E_ARGUMENT, "%s applies to %s", rules[i].name, rules[i].kinds_in_words);
    return VXS_OK;
}

/* Checks that the table of options cannot express. */
static vxs_result check(const scene_options *o, run_context *m)
{
    vxs_result r = check_kind(o, m);
    if (r != VXS_OK) return r;
    if (o->sun[0] == 0 && o->sun[1] == 0 && o->sun[2] == 0)
        return fail(m, VXS_E_ARGUMENT, "--sun 0,0,0: expected a direction, at least one number other than 0");
    if (o->kind == KIND_FOREST && o->size_given && o->size_metres < FOREST_SIZE_MIN)
        return fail(m, VXS_E_ARGUMENT, "--size %g: expected %g or more for a forest", o->size_metres, FOREST_SIZE_MIN);
    if (o->kind == KIND_STRESS && !o->case_given) return fail(m, VXS_E_ARGUMENT, "--case is missing: --case list prints the names");
    if (!o->out) return fail(m, VXS_E_ARGUMENT, "-o is missing: expected -o OUT.glb, or -o - for standard output");
    if (o->kind == KIND_STRESS) return stress_check(o->stress_case, m);
    if (o->sun_given) warn_about_sun(SUN_NAME, o->sun, m);
    return run_check(m);
}

static vxs_result generate(glb_scene *s, const scene_options *o, run_context *m)
{
    const double *sun = o->sun;
    switch (o->kind) {
    case KIND_CITY:
        return generate_city(s, &(city_options){o->city.blocks, o->triangles, o->seed, {sun[0], sun[1], sun[2]}, o->city.spots}, m);
    case KIND_LANDSCAPE: {
        double size = o->size_given ? o->size_metres : 1024;
        return generate_landscape(s, &(landscape_options){o->triangles, o->seed, size, o->height_metres, {sun[0], sun[1], sun[2]}},
                                  m);
    }
    case KIND_ROOM: return generate_room(s, &(room_options){o->triangles, o->seed, o->screen}, m);
    case KIND_FOREST: {
        double size = o->size_given ? o->size_metres : 100;
        return generate_forest(s, &(forest_options){o->triangles, o->seed, size, {sun[0], sun[1], sun[2]}}, m);
    }
    case KIND_SMOKE: return generate_smoke(s, &(smoke_options){o->capsules, o->seed}, m);
    case KIND_HAIR: return generate_hair(s, &(smoke_options){o->capsules, o->seed}, m);
    default: return generate_stress(s, o->stress_case, m);
    }
}

static vxs_result run(void *command, run_context *m)
{
    const scene_options *o   = command;
    glb_scene            s   = {0};
    output_file          out = {0};
    vxs_result           r;
    if (o->kind == KIND_STRESS && o->case_given && !strcmp(o->stress_case, "list") && check_kind(o, m) == VXS_OK) {
        for (size_t i = 0; stress_name(i); i++) printf("%-24s %s\n", stress_name(i), stress_purpose(i));
        return VXS_OK;
    }
    if ((r = check(o, m)) != VXS_OK) return r;

    FILE *to = report_stream(m, is_standard_output(o->out));
    if ((r = output_file_open(&out, o->out, m)) != VXS_OK) goto done; /* open first: fail early when the file cannot be written */
    if ((r = generate(&s, o, m)) != VXS_OK) goto done;
    if ((r = glb_write(&s, &out, m)) != VXS_OK) goto done;
    r = output_file_commit(&out, m);
    if (r == VXS_OK && to) {
        /* "99996 triangles, 2 lights", and smoke if there is some */
        char   what[128], smoke[48] = "";
        size_t capsules = 0;
        for (size_t n = 0; n < s.smoke_count; n++) capsules += s.smoke[n].vertex_count / (s.smoke[n].lines ? 2 : 1);
        if (capsules) snprintf(smoke, sizeof smoke, ", %zu capsules of smoke", capsules);
        snprintf(what, sizeof what, "%zu triangles, %zu light%s%s", s.triangle_count, s.light_count, s.light_count == 1 ? "" : "s",
                 smoke);
        written_print(to, o->out, what);
    }
done:
    output_file_abort(&out);
    glb_scene_free(&s);
    return r;
}

int cmd_scene(int argc, char **argv)
{
    scene_options o = {
        .city = {.blocks = 8}, .height_metres = 200, .triangles = 100000, .capsules = 12000, .seed = 1, .sun = {-0.5, -1, -0.3}};
    const option options[] = {
        {"KIND", OPTION_CHOICE, &o.kind, 0, 0, SCENE_KINDS, NULL, "city, landscape, room, forest, smoke, hair or stress", NULL},
        {"-o", OPTION_OUTPUT, &o.out, 0, 0, ".glb", "OUT.glb", "where to write; - is standard output", NULL},
        {"--triangles", OPTION_U32, &o.triangles, GENERATE_TRIANGLES_MIN, GENERATE_TRIANGLES_MAX, NULL, "T",
         "city, landscape, room, forest: how many triangles, met within 2% (default 100000)", &o.triangles_given},
        {"--seed", OPTION_U32, &o.seed, 0, UINT32_MAX, NULL, "S", "all but stress: another seed, another scene (default 1)",
         &o.seed_given},
        {"--sun", OPTION_VECTOR, o.sun, 0, 3, NULL, "X,Y,Z",
         "city, landscape, forest: the way sunlight travels (default -0.5,-1,-0.3)", &o.sun_given},
        {"--blocks", OPTION_U32, &o.city.blocks, 1, CITY_BLOCKS_MAX, NULL, "N", "city: N x N blocks (default 8)", &o.blocks_given},
        {"--spots", OPTION_U32, &o.city.spots, 0, CITY_SPOTS_MAX, NULL, "N", "city: street lamps that are spot lights (default 0)",
         &o.spots_given},
        {"--size", OPTION_F64, &o.size_metres, LANDSCAPE_SIZE_MIN, LANDSCAPE_SIZE_MAX, NULL, "METRES",
         "landscape, forest: length of a side; of a forest 100 unless given (default 1024)", &o.size_given},
        {"--height", OPTION_F64, &o.height_metres, 0, LANDSCAPE_HEIGHT_MAX, NULL, "METRES",
         "landscape: from lowest to highest point (default 200)", &o.height_given},
        {"--capsules", OPTION_U32, &o.capsules, SMOKE_MIN, SMOKE_MAX, NULL, "N",
         "smoke, hair: how many puffs and pieces of strands (default 12000)", &o.capsules_given},
        {"--screen", OPTION_SWITCH, &o.screen, 0, 0, NULL, NULL, "room: a screen on the wall, which shines", NULL},
        {"--case", OPTION_TEXT, &o.stress_case, 0, 0, NULL, "NAME", "stress: which scene; list prints their names and purposes",
         &o.case_given},
    };
    const command_line line =
        COMMAND_LINE("scene", "KIND -o OUT.glb [options]", "Make a procedural test scene. Same options, same bytes.", options);
    return command_run(&line, argc, argv, run, &o);
}
