/* Lights of all kinds over samples of both codings, for tests of lookups and queries. Include after <cmocka.h>, or without it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef QUERY_LIGHTS_H
#define QUERY_LIGHTS_H

#include "blocks_sample.h"
#include "dag_sample.h"
#include "runtime/vxs_query.h"

/* A sun, the same bounded, a spot with one map, and a point light with six. */
enum { LIGHTS = 4 };

/* The lights of some words, palette blocks. */
static inline vxs_baked_light blocks_light(const uint32_t *words, uint32_t levels, int kind)
{
    dag_sample      shape = {.levels = levels};
    vxs_write_light sun = dag_sample_light(&shape, "sun"), spot = dag_sample_punctual(&shape, "spot", VXS_LIGHT_KIND_SPOT, 0);
    vxs_write_light point = dag_sample_punctual(&shape, "lamp", VXS_LIGHT_KIND_POINT, VXS_LIGHT_CUBE);
    vxs_baked_light l     = {.light = kind < 2 ? sun.light : kind == 2 ? spot.light : point.light, .words = words};
    if (kind == 1) l.light.flags = VXS_LIGHT_BOUNDED;
    l.light.coding = VXS_CODING_BLOCKS;
    return l;
}

/* The lights of a DAG: their words come from a file. */
static inline vxs_asset *dag_asset(const dag_sample *s)
{
    vxs_write_light lights[LIGHTS] = {dag_sample_light(s, "sun"), dag_sample_light(s, "moon"),
                                      dag_sample_punctual(s, "spot", VXS_LIGHT_KIND_SPOT, 0),
                                      dag_sample_punctual(s, "lamp", VXS_LIGHT_KIND_POINT, VXS_LIGHT_CUBE)};
    vxs_write_desc  desc           = {.lights = lights, .light_count = LIGHTS, .zstd_level = 1};
    vxs_bytes       file           = {0};
    vxs_asset      *asset          = NULL;
    lights[1].light.flags          = VXS_LIGHT_BOUNDED;
    if (vxs_write(&file, &desc) != VXS_OK || vxs_asset_open(&asset, file.data, file.size_bytes, NULL) != VXS_OK) abort();
    free(file.data);
    return asset;
}

#endif
