/* vxs truth: how lit is each point, by ray tracing.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/casters/casters.h"
#include "baker/command/commands.h"
#include "baker/command/points.h"
#include "baker/options/options.h"
#include "baker/scene/light_choice.h"
#include "baker/scene/scene.h"
#include "baker/truth/truth.h"

typedef struct truth_options {
    const char *scene_path;
    const char *scene_name;
    text_list   light_names;
    int         sun_given;
    double      sun[3];
    uint32_t    threads;
} truth_options;

typedef struct traced {
    const truth        *truth;
    const light_choice *lights;
} traced;

static void trace(const void *user, const query_point *point, float *lit)
{
    const traced *q = user;
    double        from_ws[3];
    memcpy(from_ws, point->position_ws, sizeof from_ws);
    if (point->has_normal) truth_lift(q->truth, point->position_ws, point->normal_ws, from_ws);
    for (size_t n = 0; n < q->lights->count; n++) {
        const light_shape *light = &q->lights->lights[n].shape;
        lit[n]                   = light_reaches(light, point->position_ws) ? (float)truth_lit(q->truth, from_ws, light) : -1;
    }
}

static vxs_result run(void *command, message *m)
{
    const truth_options *o = command;
    vxs_result           r;
    scene                s      = {0};
    light_choice         lights = {0};
    casters              c      = {0};
    truth               *t      = NULL;

    if ((r = scene_load_gltf(&s, o->scene_path, o->scene_name, m)) != VXS_OK) goto done;
    if ((r = lights_choose(&s, &o->light_names, o->sun_given, o->sun, &lights, m)) != VXS_OK) goto done;
    /* solids and sheets cast the same shadow: nothing needs to be sorted */
    if ((r = casters_from_scene(&c, &s, CLOSED_OFF, m)) != VXS_OK) goto done;
    if ((r = truth_create(&t, &c, o->threads, m)) != VXS_OK) goto done;
    r = points_answer(trace, &(traced){t, &lights}, lights.count, o->threads, m);
done:
    truth_destroy(t);
    casters_free(&c);
    light_choice_free(&lights);
    scene_free(&s);
    return r;
}

int cmd_truth(int argc, char **argv)
{
    truth_options o = {.threads = parallel_default_threads()};

    const option options[] = {
        {"--light", OPTION_TEXTS, &o.light_names, 0, 0, NULL, "NAME", "a light, a column each (all)", NULL},
        {"--sun", OPTION_VECTOR, o.sun, 0, 3, NULL, "X,Y,Z", "the way sunlight travels; adds a light named sun", &o.sun_given},
        {"--scene", OPTION_TEXT, &o.scene_name, 0, 0, NULL, "NAME", "a scene of the file, name or index (the file's own)", NULL},
        {"--threads", OPTION_U32, &o.threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "threads (the processors allowed)", NULL},
    };
    const command_line line =
        COMMAND_LINE("truth", "SCENE [--light NAME]... [--sun X,Y,Z] [options] < points",
                     "Read points from standard input, `x y z` or `x y z nx ny nz` a line (world space, metres); for each print 1\n"
                     "(lit), 0 (in shadow) or out (beyond the light's cone or range), one column a light, by tracing a ray to the\n"
                     "light. With a normal the ray starts just off the surface.",
                     options, 1);
    return command_run(&line, argc, argv, &o.scene_path, run, &o);
}
