/* vxs query: how lit is each point, by lookups in a .vxs file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/parallel.h"
#include "baker/command/asset_open.h"
#include "baker/command/commands.h"
#include "baker/command/options/options.h"
#include "baker/command/points.h"

typedef struct query {
    const vxs_baked_light *lights[VXS_LIGHTS_MAX]; /* [light_count] */
    const vxs_baked_smoke *smoke[VXS_LIGHTS_MAX];  /* [light_count] NULL: the light has none */
    uint32_t               light_count;
    int                    wants_smoke;
    filter_choice          filter;
    text_list              light_names;
    const char            *path;
    uint64_t               memory_bytes, budget_bytes;
    int                    memory_given, budget_given;
} query;

/* A query of a streamed file. */
typedef struct streamed_query {
    query       *query;
    asset_stream stream;
    uint64_t     coarse; /* points whose pages do not fit into the budget */
    vxs_result   result;
    run_context *run;
} streamed_query;

static const double *normal_of(const query_point *point)
{
    return point->has_normal ? point->normal_ws : NULL;
}

static int look_up(void *user, const query_point *point, float *lit)
{
    const query *q      = user;
    vxs_filter   filter = filter_of(&q->filter);
    for (uint32_t n = 0; n < q->light_count; n++) {
        *lit++ = vxs_lookup(q->lights[n], point->position_ws, normal_of(point), filter);
        if (q->wants_smoke) *lit++ = vxs_smoke_lookup(&q->lights[n]->light, q->smoke[n], point->position_ws);
    }
    return 1;
}

static int is_full(const query *q, const query_point *point)
{
    int full = 1;
    for (uint32_t n = 0; n < q->light_count && full; n++)
        full = vxs_lookup_is_full(q->lights[n], point->position_ws, normal_of(point), filter_of(&q->filter));
    return full;
}

/* Repeat frames around a point until its pages are loaded, or no page is pending. */
static int look_up_streamed(void *user, const query_point *point, float *lit)
{
    streamed_query   *s      = user;
    vxs_stream_status status = {.struct_size = sizeof status, .reads = 1};
    int               full   = is_full(s->query, point);
    while (!full && (status.reads || status.pages_coming)) {
        s->result = asset_stream_frame(&s->stream, point->position_ws, &status, s->run);
        if (s->result != VXS_OK) return 0;
        full = is_full(s->query, point);
    }
    s->coarse += !full;
    return look_up(s->query, point, lit);
}

static size_t column_count(const query *q)
{
    return q->wants_smoke ? 2 * (size_t)q->light_count : q->light_count;
}

static vxs_result answer_whole(query *q, run_context *m)
{
    vxs_asset *asset = NULL;
    vxs_result r     = asset_open(&asset, q->path, q->memory_bytes, 0, parallel_default_threads(), m);
    if (r == VXS_OK) r = asset_choose_lights(vxs_asset_contents(asset), q->path, &q->light_names, q->lights, &q->light_count, m);
    if (r == VXS_OK) {
        asset_find_smoke(asset, q->lights, q->light_count, q->smoke);
        r = points_answer(look_up, q, column_count(q), 1, m);
    }
    vxs_asset_close(asset);
    return r;
}

static vxs_result answer_streamed(query *q, run_context *m)
{
    streamed_query s = {.query = q, .run = m};
    vxs_result     r =
        asset_stream_open(&s.stream, q->path, q->budget_bytes, &q->light_names, 0, q->lights, q->smoke, &q->light_count, m);
    if (r == VXS_OK) r = points_answer(look_up_streamed, &s, column_count(q), 1, m);
    if (r == VXS_OK) r = s.result;
    if (r == VXS_OK && s.coarse)
        warn(m, "%llu points are answered coarsely: --budget %llu has no room for all pages about them",
             (unsigned long long)s.coarse, (unsigned long long)q->budget_bytes);
    asset_stream_close(&s.stream);
    return r == VXS_OK ? run_check(m) : r;
}

static vxs_result run(void *command, run_context *m)
{
    query     *q = command;
    vxs_result r = filter_check(&q->filter, m);
    if (r == VXS_OK && q->memory_given && q->budget_given) r = fail(m, VXS_E_ARGUMENT, "--memory and --budget exclude each other");
    if (r == VXS_OK) r = points_check_input("FILE.vxs", q->path, m);
    if (r != VXS_OK) return r;
    return q->budget_given ? answer_streamed(q, m) : answer_whole(q, m);
}

int cmd_query(int argc, char **argv)
{
    query        q         = {.filter.box_px = 1};
    const option options[] = {
        {"FILE.vxs", OPTION_INPUT, &q.path, FILE_ASSET, 0, NULL, NULL, "what vxs bake wrote", NULL},
        {"--light", OPTION_TEXTS, &q.light_names, 0, 0, NULL, "NAME",
         "answer for this light, or all that a pattern names; repeat for more (default all, in file order)", NULL},
        FILTER_ROWS(q.filter, "K x K box filter, K odd, 1 to 17 texels (default 1)"),
        {"--smoke", OPTION_SWITCH, &q.wants_smoke, 0, 0, NULL, NULL,
         "a second column for each light: how much of it baked smoke leaves, 0 to 1", NULL},
        {"--memory", OPTION_BYTES, &q.memory_bytes, 0, 0, NULL, "BYTES",
         "hold no more of the file in memory than this (default 256 times the file, 64M at least)", &q.memory_given},
        {"--budget", OPTION_BYTES, &q.budget_bytes, 0, 0, NULL, "BYTES",
         "stream FILE.vxs: hold no more of it than this, and have its pages come to each point (default all of the file)",
         &q.budget_given},
    };
    const command_line line = COMMAND_LINE(
        "query", "FILE.vxs [options] < points",
        "Answer 'how lit is this point?' from a .vxs file. For each line 'x y z' or 'x y z nx ny nz' of standard "
        "input (world space, metres), print the lit fraction, 0 to 1, one column a light; 'out' outside a light's volume.",
        options);
    return command_run(&line, argc, argv, run, &q);
}
