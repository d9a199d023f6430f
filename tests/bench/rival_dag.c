/* vxs itself, and its own older or simpler ways; see rival.h. The stages are the baker's.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>

#include "formats/vxs_space.h" /* before dag.h: vxs_lookup.h calls a light's words `dag` */
#include "runtime/vxs.h"

#include "baker/coding/dag/build.h"
#include "tests/bench/rival.h"
#include "tests/columns/stored_maps.h"

typedef struct dag_options {
    mask_rule       rule;
    int             reuse_off;
    compress_choice compress;
    stop_stage      stop;
} dag_options;

static vxs_result dag_build(rival_maps *maps, const void *options, vxs_bytes *file)
{
    const dag_options *o       = options;
    int                unify   = o->stop == STOP_FINAL;
    compress_order     order   = o->compress == COMPRESS_CHOICE_AUTO ? maps->plan.compress : compress_order_of(o->compress);
    build_options      build   = build_options_of(&(bake_options){.rule = o->rule, .reuse = !o->reuse_off, .stop = o->stop}, order);
    build_stats        stats   = {0};
    run_context        m       = {0};
    bake_context       ctx     = {.run = &m, .threads = maps->threads};
    column_map         columns = stored_map(&maps->maps);
    dag_merger         merger;
    dag                d = {0};
    vxs_result         r;

    depth_maps_reduce(&maps->maps, maps->threads);
    if ((r = dag_merger_init(&merger, columns.side_px, 1, unify)) != VXS_OK) goto done;
    if ((r = dag_build_map(&merger, 0, &columns, &build, &stats, &ctx)) != VXS_OK) goto done;
    if ((r = dag_merger_finish(&merger, &d)) != VXS_OK) goto done;

    vxs_write_light light = dag_to_write(&maps->light, &d);
    vxs_write_desc  desc  = {.lights = &light, .light_count = 1, .zstd_level = RIVAL_ZSTD_LEVEL};
    r                     = vxs_write(file, &desc);
done:
    dag_merger_free(&merger);
    dag_free(&d);
    return r;
}

static vxs_result dag_open(const rival_maps *maps, const void *options, const vxs_bytes *file, rival_asset *asset)
{
    const vxs_read_desc any_size = {.memory_limit_bytes = UINT64_MAX}; /* a file that was just made here */
    vxs_asset          *opened   = NULL;
    vxs_result          r        = vxs_asset_open(&opened, file->data, file->size_bytes, &any_size);
    (void)maps;
    (void)options;
    if (r == VXS_OK) *asset = (rival_asset){opened, (uint64_t)vxs_asset_light(opened, 0)->word_count * sizeof(uint32_t)};
    return r;
}

static void dag_count_dark(const void *state, const voxel_at *at, size_t count, vxs_filter filter, uint32_t *dark)
{
    const vxs_baked_light *light = vxs_asset_light(state, 0);
    for (size_t n = 0; n < count && filter.is_smooth; n++)
        dark[n] = vxs_shadow_weight(light->words, 0, light->light.levels, at[n].i, at[n].j, at[n].within & 255, at[n].within >> 8,
                                    (uint32_t)at[n].k, filter.width_px);
    for (size_t n = 0; n < count && !filter.is_smooth; n++)
        dark[n] = vxs_shadow_taps(light->words, &light->light, 0, at[n].i, at[n].j, (uint32_t)at[n].k, filter.width_px);
}

static void dag_close(void *state)
{
    vxs_asset_close(state);
}

#define DAG_RIVAL(name, what, ...)                                                                                                 \
    {                                                                                                                              \
        name, what, &(const dag_options){__VA_ARGS__}, RIVAL_SMOOTH, dag_build, dag_open, dag_count_dark, dag_close                \
    }

const rival dag_rivals[] = {
    DAG_RIVAL("DAG", "as vxs bake --coding dag makes it", .stop = STOP_FINAL),
    {"DAG, batch", "the same file, asked as vxs_lookup_batch does: each walk goes on from the one before it",
     &(const dag_options){.stop = STOP_FINAL}, RIVAL_SMOOTH, dag_build, dag_open, asset_count_dark_batch, dag_close},
    DAG_RIVAL("DAG, older mask rule", "--rule shadow: undefined voxels become dark", .rule = MASK_RULE_SHADOW, .stop = STOP_FINAL),
    DAG_RIVAL("DAG, no culling", "--reuse off: what equals its neighbour nearer the light is made again", .reuse_off = 1,
              .stop = STOP_FINAL),
    DAG_RIVAL("DAG, top-down", "--compress top-down: sub-DAGs by subtree hash, from the roots down",
              .compress = COMPRESS_CHOICE_TOP_DOWN, .stop = STOP_FINAL),
    DAG_RIVAL("DAG, bottom-up", "--compress bottom-up: sub-DAGs by sorted contents, from the masks up",
              .compress = COMPRESS_CHOICE_BOTTOM_UP, .stop = STOP_FINAL),
    DAG_RIVAL("DAG, uncompressed", "--stop insert: sub-DAGs side by side, as they were inserted", .stop = STOP_INSERT),
    DAG_RIVAL("DAG, uncompressed, no culling", "--stop insert --reuse off", .reuse_off = 1, .stop = STOP_INSERT),
    {.name = NULL},
};
