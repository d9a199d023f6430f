/* vxs query: how lit is each point, by lookups in a .vxs file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/asset_open.h"
#include "baker/command/commands.h"
#include "baker/command/points.h"
#include "baker/options/filter_choice.h"
#include "baker/options/options.h"

typedef struct query {
    const vxs_baked_light *lights[VXS_LIGHTS_MAX]; /* [light_count] */
    const vxs_baked_smoke *smoke[VXS_LIGHTS_MAX];  /* [light_count] NULL: the light has none */
    uint32_t               light_count;
    int                    wants_smoke;
    filter_choice          filter;
    text_list              light_names;
    const char            *path;
    uint64_t               memory_bytes;
} query;

static void look_up(const void *user, const query_point *point, float *lit)
{
    const query *q         = user;
    int          filter_px = filter_px_of(&q->filter);
    for (uint32_t n = 0; n < q->light_count; n++) {
        *lit++ = vxs_lookup(q->lights[n], point->position_ws, point->has_normal ? point->normal_ws : NULL, filter_px);
        if (q->wants_smoke) *lit++ = vxs_smoke_lookup(&q->lights[n]->light, q->smoke[n], point->position_ws);
    }
}

static vxs_result run(void *command, message *m)
{
    query     *q     = command;
    vxs_asset *asset = NULL;
    vxs_result r;

    if ((r = filter_check(&q->filter, m)) != VXS_OK) goto done;
    if ((r = points_check_input("FILE.vxs", q->path, m)) != VXS_OK) goto done;
    if ((r = asset_open_within(&asset, q->path, q->memory_bytes, 0, m)) != VXS_OK) goto done;
    if ((r = asset_choose_lights(vxs_asset_contents(asset), q->path, &q->light_names, q->lights, &q->light_count, m)) != VXS_OK)
        goto done;
    asset_find_smoke(asset, q->lights, q->light_count, q->smoke);
    r = points_answer(look_up, q, q->wants_smoke ? 2 * (size_t)q->light_count : q->light_count, 1, m);
done:
    vxs_asset_close(asset);
    return r;
}

int cmd_query(int argc, char **argv)
{
    query        q         = {.filter.box_px = 1};
    const option options[] = {
        {"FILE.vxs", OPTION_INPUT, &q.path, FILE_ASSET, 0, NULL, NULL, "what vxs bake wrote", NULL},
        {"--light", OPTION_TEXTS, &q.light_names, 0, 0, NULL, "NAME",
         "answer for this light; repeat for more (default all, in file order)", NULL},
        FILTER_ROWS(q.filter, "K x K box filter, K odd, 1 to 17 texels (default 1)"),
        {"--smoke", OPTION_SWITCH, &q.wants_smoke, 0, 0, NULL, NULL,
         "a second column for each light: how much of it baked smoke leaves, 0 to 1", NULL},
        {"--memory", OPTION_BYTES, &q.memory_bytes, 0, 0, NULL, "BYTES",
         "hold no more of the file in memory than this (default 256 times the file, 64M at least)", NULL},
    };
    const command_line line = COMMAND_LINE(
        "query", "FILE.vxs [options] < points",
        "Answer 'how lit is this point?' from a .vxs file. For each line 'x y z' or 'x y z nx ny nz' of standard "
        "input (world space, metres), print the lit fraction, 0 to 1, one column a light; 'out' outside a light's volume.",
        options);
    return command_run(&line, argc, argv, run, &q);
}
