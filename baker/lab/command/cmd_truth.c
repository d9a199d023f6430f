/* vxs truth: how lit is each point, by ray tracing.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/casters/casters.h"
#include "baker/command/asset_open.h"
#include "baker/command/options/options.h"
#include "baker/command/points.h"
#include "baker/command/provenance_differences.h"
#include "baker/lab/command/lab_commands.h"
#include "baker/lab/truth/truth.h"
#include "baker/light/map_space.h"
#include "baker/scene/light_choice.h"
#include "baker/scene/scene.h"

typedef struct truth_options {
    const char   *scene_path;
    scene_choice  choice;
    const char   *like_path; /* NULL: trace rays from the points themselves */
    text_list     light_names;
    named_list    suns;
    filter_choice filter;
    uint32_t      threads;
} truth_options;

typedef struct traced {
    const truth        *truth;
    const light_choice *lights;
} traced;

/* The lights of an asset, traced with the filter of lookups. */
typedef struct traced_like {
    const truth           *truth;
    const vxs_baked_light *lights[VXS_LIGHTS_MAX]; /* [light_count] */
    light_shape            shapes[VXS_LIGHTS_MAX]; /* of them */
    uint32_t               light_count;
    vxs_filter             filter;
} traced_like;

static int trace(void *user, const query_point *point, float *lit)
{
    const traced *q = user;
    double        from_ws[3];
    memcpy(from_ws, point->position_ws, sizeof from_ws);
    if (point->has_normal) truth_lift(q->truth, point->position_ws, point->normal_ws, from_ws);
    for (size_t n = 0; n < q->lights->count; n++) {
        const light_shape *light = &q->lights->lights[n].shape;
        lit[n]                   = light_reaches(light, point->position_ws) ? (float)truth_lit(q->truth, from_ws, light) : -1;
    }
    return 1;
}

static int trace_like(void *user, const query_point *point, float *lit)
{
    const traced_like *q = user;
    for (uint32_t n = 0; n < q->light_count; n++) {
        const vxs_light *light = &q->lights[n]->light;
        filter_taps      taps  = filter_taps_of(light, point->position_ws, point->has_normal ? point->normal_ws : NULL, q->filter);
        lit[n]                 = taps.map < 0 ? -1 : (float)truth_filtered(q->truth, light, &q->shapes[n], &taps);
    }
    return 1;
}

/* Open the asset, choose the lights that are wanted, and set the scene options of its bake. */
static vxs_result open_like(truth_options *o, vxs_asset **asset, json_t **made, traced_like *q, run_context *m)
{
    vxs_result r = asset_open(asset, o->like_path, 0, 1, o->threads, m);
    if (r == VXS_OK) r = provenance_read(made, vxs_asset_contents(*asset), m);
    if (r == VXS_OK) r = asset_scene_choice(*made, &o->choice, m);
    if (r == VXS_OK)
        r = asset_choose_lights(vxs_asset_contents(*asset), o->like_path, &o->light_names, q->lights, &q->light_count, m);
    for (uint32_t n = 0; r == VXS_OK && n < q->light_count; n++) q->shapes[n] = baked_light_shape(&q->lights[n]->light);
    q->filter = filter_of(&o->filter);
    return r;
}

static vxs_result judge_lights(const light_choice *chosen, run_context *m)
{
    warn_about_suns(chosen, m);
    return VXS_OK;
}

static vxs_result run(void *command, run_context *m)
{
    truth_options *o = command;
    vxs_result     r;
    scene          s      = {0};
    light_choice   lights = {0};
    casters        c      = {0};
    truth         *t      = NULL;
    vxs_asset     *asset  = NULL;
    json_t        *made   = NULL;
    traced_like    like   = {0};
    light_question q      = {&o->light_names, &o->suns, &lights, judge_lights};
    scene_check    check  = light_question_check(&q);

    if ((r = points_check_input("SCENE", o->scene_path, m)) != VXS_OK) goto done;

    if (filter_given(&o->filter) && !o->like_path) {
        r = fail(m, VXS_E_ARGUMENT, "%s goes with --like FILE.vxs: a filter is as wide as the texels of a baked map",
                 o->filter.smooth_given ? "--smooth" : "--filter");
        goto done;
    }
    if (o->suns.count && o->like_path) {
        r = fail(m, VXS_E_ARGUMENT, "--sun and --like exclude each other: the lights are those of %s", o->like_path);
        goto done;
    }
    if ((r = filter_check(&o->filter, m)) != VXS_OK) goto done;

    if (o->like_path && (r = open_like(o, &asset, &made, &like, m)) != VXS_OK) goto done;
    if ((r = scene_load_gltf_checked(&s, o->scene_path, &o->choice, o->like_path ? NULL : &check, m)) != VXS_OK) goto done;
    if (o->like_path)
        r = asset_check_scene(vxs_asset_contents(asset), made, o->like_path, &s, o->scene_path, "it may answer otherwise", m);
    if (r != VXS_OK) goto done;
    /* solids and sheets cast the same shadow, so components are not classified */
    if ((r = casters_from_scene(&c, &s, CLOSED_OFF, o->threads, m)) != VXS_OK) goto done;
    if ((r = truth_create(&t, &c, o->threads, m)) != VXS_OK) goto done;
    like.truth = t;
    r          = o->like_path ? points_answer(trace_like, &like, like.light_count, o->threads, m)
                              : points_answer(trace, &(traced){t, &lights}, lights.count, o->threads, m);
done:
    truth_destroy(t);
    casters_free(&c);
    light_choice_free(&lights);
    scene_free(&s);
    vxs_asset_close(asset);
    json_decref(made);
    return r;
}

int cmd_truth(int argc, char **argv)
{
    truth_options o = {.filter.box_px = 1, .threads = parallel_default_threads()};

    const option options[] = {
        {"SCENE", OPTION_INPUT, &o.scene_path, FILE_SCENE, 0, NULL, NULL, "a glTF 2.0 scene, .gltf or .glb", NULL},
        {"--light", OPTION_TEXTS, &o.light_names, 0, 0, NULL, "NAME",
         "a light, or all that a pattern names, a column each; repeat for more (default all, in the scene's order)", NULL},
        {"--sun", OPTION_NAMED_VECTOR, &o.suns, 0, 3, SUN_NAME, "[NAME=]X,Y,Z",
         "add a light that travels this way, named sun or NAME; repeat for more", NULL},
        {"--like", OPTION_INPUT, &o.like_path, FILE_ASSET, 0, NULL, "FILE.vxs",
         "answer as a lookup in this file: its lights, its volumes, its voxels", NULL},
        FILTER_ROWS(o.filter, "with --like: the mean of K x K rays, K odd, 1 to 17 texels (default 1)"),
        SCENE_ROWS(o.choice),
        {"--threads", OPTION_U32, &o.threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "threads (default all processors)", NULL},
    };
    const command_line line = COMMAND_LINE(
        "truth", "SCENE [options] < points",
        "Answer 'how lit is this point?' by ray tracing the scene. For each line 'x y z' or 'x y z nx ny nz' of standard "
        "input (world space, metres), print 1 (lit), 0 (in shadow) or 'out' (beyond the light's cone or range), one "
        "column a light. With a normal the ray starts just off the surface. With --like the answer is what "
        "vxs query FILE.vxs should say: of rays through the centres of the texels that a lookup reads, from where its voxel is.",
        options);
    return command_run(&line, argc, argv, run, &o);
}
