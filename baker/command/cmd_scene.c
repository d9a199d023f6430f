/* vxs scene: procedural test scenes (scenes/README.md says what they are for).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <string.h>

#include "baker/base/output_file.h"
#include "baker/command/options.h"
#include "baker/scene/generate.h"
#include "baker/scene/glb_write.h"

typedef struct scene_options {
    city_options      city;
    landscape_options landscape;
    uint32_t          triangles, seed;
    double            sun[3];
    const char       *out;
    int               blocks_given, spots_given, size_given, height_given;
} scene_options;

static vxs_result parse(scene_options *o, const char **kind, int argc, char **argv, int *help_shown, message *m)
{
    const option options[] = {
        {"-o", OPTION_TEXT, &o->out, 0, 0, NULL, "OUT.glb", "where to write; - is standard output", NULL},
        {"--triangles", OPTION_U32, &o->triangles, GENERATE_TRIANGLES_MIN, GENERATE_TRIANGLES_MAX, NULL, "T",
         "how many triangles, met within 2% (default 100000)", NULL},
        {"--seed", OPTION_U32, &o->seed, 0, UINT32_MAX, NULL, "S", "another seed, another scene (default 1)", NULL},
        {"--sun", OPTION_VECTOR, o->sun, 0, 3, NULL, "X,Y,Z", "the way sunlight travels (default -0.5,-1,-0.3)", NULL},
        {"--blocks", OPTION_U32, &o->city.blocks, 1, CITY_BLOCKS_MAX, NULL, "N", "city: N x N blocks (default 8)",
         &o->blocks_given},
        {"--spots", OPTION_U32, &o->city.spots, 0, CITY_SPOTS_MAX, NULL, "N", "city: street lamps that are spot lights (default 0)",
         &o->spots_given},
        {"--size", OPTION_F64, &o->landscape.size_metres, LANDSCAPE_SIZE_MIN, LANDSCAPE_SIZE_MAX, NULL, "METRES",
         "landscape: length of a side (default 1024)", &o->size_given},
        {"--height", OPTION_F64, &o->landscape.height_metres, 0, LANDSCAPE_HEIGHT_MAX, NULL, "METRES",
         "landscape: from lowest to highest point (default 200)", &o->height_given},
    };
    const command_line c = {
        "scene", "KIND -o OUT.glb [options]",      "Make a test scene of closed solids and a sun; KIND is city or landscape.",
        options, sizeof options / sizeof *options, 1};
    return options_parse(&c, argc, argv, kind, help_shown, m);
}

/* What the table cannot say: which option goes with which kind, and that some must be there. */
static vxs_result check(const scene_options *o, const char *kind, message *m)
{
    int is_city = !strcmp(kind, "city"), is_landscape = !strcmp(kind, "landscape");

    if (!is_city && !is_landscape) return fail(m, VXS_E_ARGUMENT, "unknown kind '%s': expected city or landscape", kind);
    if (o->blocks_given && !is_city) return fail(m, VXS_E_ARGUMENT, "--blocks applies to city only");
    if (o->spots_given && !is_city) return fail(m, VXS_E_ARGUMENT, "--spots applies to city only");
    if (o->size_given && !is_landscape) return fail(m, VXS_E_ARGUMENT, "--size applies to landscape only");
    if (o->height_given && !is_landscape) return fail(m, VXS_E_ARGUMENT, "--height applies to landscape only");
    if (o->sun[0] == 0 && o->sun[1] == 0 && o->sun[2] == 0)
        return fail(m, VXS_E_ARGUMENT, "--sun 0,0,0: expected a direction, at least one number other than 0");
    if (!o->out) return fail(m, VXS_E_ARGUMENT, "-o is missing: expected -o OUT.glb, or -o - for standard output");
    return VXS_OK;
}

static vxs_result generate(glb_scene *s, scene_options *o, const char *kind, message *m)
{
    if (!strcmp(kind, "city")) {
        o->city.triangles = o->triangles;
        o->city.seed      = o->seed;
        memcpy(o->city.sun, o->sun, sizeof o->sun);
        return generate_city(s, &o->city, m);
    }
    o->landscape.triangles = o->triangles;
    o->landscape.seed      = o->seed;
    memcpy(o->landscape.sun, o->sun, sizeof o->sun);
    return generate_landscape(s, &o->landscape, m);
}

int cmd_scene(int argc, char **argv)
{
    scene_options o    = {.city      = {.blocks = 8},
                          .landscape = {.size_metres = 1024, .height_metres = 200},
                          .triangles = 100000,
                          .seed      = 1,
                          .sun       = {-0.5, -1, -0.3}};
    glb_scene     s    = {0};
    output_file   out  = {0};
    message       m    = {0};
    const char   *kind = NULL;
    int           help_shown;
    vxs_result    r;

    if ((r = parse(&o, &kind, argc, argv, &help_shown, &m)) != VXS_OK || help_shown) goto done;
    if ((r = check(&o, kind, &m)) != VXS_OK) goto done;
    if ((r = output_file_open(&out, o.out, &m)) != VXS_OK) goto done; /* first: a name that cannot be written costs nothing */
    if ((r = generate(&s, &o, kind, &m)) != VXS_OK) goto done;
    if ((r = glb_write(&s, &out, &m)) != VXS_OK) goto done;
    r = output_file_commit(&out, &m);
done:
    output_file_abort(&out);
    glb_scene_free(&s);
    return command_end(&m, r);
}
