/* Random DAGs for tests of the format and of lookups, and what they mean: every slice of the map, expanded from the references.
 * Nodes are shared, repeat their neighbours, end early in lit or shadow, and some are not referenced.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DAG_SAMPLE_H
#define DAG_SAMPLE_H

#include <stdlib.h>
#include <string.h>

#include "baker/base/random.h"
#include "formats/vxs_write_file.h"

typedef struct dag_sample {
    uint32_t     levels; /* of the map: 2^levels texels a side */
    uint32_t    *nodes[VXS_LEVELS_MAX];
    uint64_t    *masks;
    uint64_t    *dense; /* [tile x + tiles * (tile y + tiles * k)] the mask of each slice, for the whole map */
    vxs_dag_view view;
} dag_sample;

static inline void *dag_sample_alloc(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory) abort();
    return memory;
}

static inline uint32_t dag_sample_ref(rng *r, uint32_t below_count)
{
    uint32_t dice = rng_below(r, 8);
    if (dice < 3 || !below_count) return dice & 1;
    return 2 + rng_below(r, below_count);
}

static inline void dag_sample_nodes(rng *r, uint32_t *child, uint32_t count, uint32_t below_count, int slices)
{
    for (uint32_t n = 0; n < 8 * count; n++) {
        uint32_t c      = n % 8;
        uint32_t nearer = slices ? 1 : 4;
        child[n]        = c >= nearer && !rng_below(r, 3) ? child[n - nearer] : dag_sample_ref(r, below_count);
    }
}

static inline uint32_t dag_sample_tiles(const dag_sample *s)
{
    return 1u << (s->levels - 3);
}

/* Write what `ref`, a child at `level` or a mask (-1), means into its cube: tiles from (x, y), slices from k. */
static inline void dag_sample_fill(dag_sample *s, int level, uint32_t ref, uint32_t x, uint32_t y, uint32_t k)
{
    uint32_t tiles = dag_sample_tiles(s);
    if (ref < 2 || level < 0) {
        uint64_t mask = ref < 2 ? 0 - (uint64_t)ref : s->masks[ref - 2];
        uint32_t side = level < 0 ? 1 : 1u << level;
        for (uint32_t dk = 0; dk < (level < 0 ? 1 : 8 * side); dk++)
            for (uint32_t dy = 0; dy < side; dy++)
                for (uint32_t dx = 0; dx < side; dx++) s->dense[x + dx + tiles * (y + dy + (size_t)tiles * (k + dk))] = mask;
        return;
    }
    const uint32_t *child = s->nodes[level] + 8 * (size_t)(ref - 2);
    for (uint32_t c = 0; c < 8; c++) {
        uint32_t half = level ? 1u << (level - 1) : 0;
        if (level)
            dag_sample_fill(s, level - 1, child[c], x + (c & 1) * half, y + (c >> 1 & 1) * half, k + (c >> 2) * half * 8);
        else
            dag_sample_fill(s, -1, child[c], x, y, k + c);
    }
}

/* Make `dense` that of a map. */
static inline void dag_sample_show(dag_sample *s, uint32_t map)
{
    dag_sample_fill(s, (int)s->view.level_count - 1, 2 + s->view.roots[map], 0, 0, 0);
}

/* count_max  nodes a level and masks at most; 0 masks happen too. */
static inline void dag_sample_init(dag_sample *s, rng *r, uint32_t levels, uint32_t count_max)
{
    *s                  = (dag_sample){.levels = levels};
    s->view.level_count = levels - 2;
    s->view.mask_count  = rng_below(r, count_max + 1);
    s->masks            = dag_sample_alloc(s->view.mask_count, sizeof *s->masks);
    s->view.masks       = s->masks;
    for (uint32_t m = 0; m < s->view.mask_count; m++) s->masks[m] = (uint64_t)rng_u32(r) << 32 | rng_u32(r);
    uint32_t below = s->view.mask_count;
    for (uint32_t l = 0; l < s->view.level_count; l++) {
        uint32_t count   = 1 + rng_below(r, count_max);
        s->nodes[l]      = dag_sample_alloc(count, 8 * sizeof **s->nodes);
        s->view.nodes[l] = s->nodes[l];
        s->view.count[l] = count;
        dag_sample_nodes(r, s->nodes[l], count, below, l == 0);
        below = count;
    }
    for (uint32_t map = 0; map < VXS_CUBE_FACES; map++) s->view.roots[map] = rng_below(r, below); /* two may be equal */
    s->dense = dag_sample_alloc((size_t)1 << (3 * levels - 6), sizeof *s->dense);
    dag_sample_show(s, 0);
}

static inline void dag_sample_free(dag_sample *s)
{
    for (uint32_t l = 0; l < s->view.level_count; l++) free(s->nodes[l]);
    free(s->masks);
    free(s->dense);
}

static inline uint32_t dag_sample_shadow(const dag_sample *s, uint32_t i, uint32_t j, uint32_t k)
{
    uint32_t tiles = dag_sample_tiles(s);
    return s->dense[(i >> 3) + tiles * ((j >> 3) + (size_t)tiles * k)] >> ((i & 7) + 8 * (j & 7)) & 1;
}

/* A light for a sample: texels of half a metre, voxels of a metre, looking down -y; the map's corner is at (-1, 10, 2). */
static inline vxs_write_light dag_sample_light(const dag_sample *s, const char *name)
{
    vxs_write_light l = {.light = {.kind         = VXS_LIGHT_KIND_DIRECTIONAL,
                                   .levels       = s->levels,
                                   .coding       = VXS_CODING_DAG,
                                   .ls_from_ws   = {2, 0, 0, 2, 0, 0, 2, -4, 0, -1, 0, 10},
                                   .texel_metres = 0.5,
                                   .voxel_metres = 1,
                                   .direction_ws = {0, -1, 0}},
                         .dag   = s->view};
    strncpy(l.light.name, name, sizeof l.light.name - 1);
    return l;
}

/* A spot or point light for a sample, at (1, 2, 3) and looking along -x: u is +z, v is +y. One map reaches to 45 degrees, and depth
 * from half a metre to 8. */
static inline vxs_write_light dag_sample_punctual(const dag_sample *s, const char *name, uint32_t kind, uint32_t flags)
{
    double          side = (double)(1u << s->levels);
    vxs_write_light l    = {.light = {.kind         = kind,
                                      .flags        = flags,
                                      .levels       = s->levels,
                                      .coding       = VXS_CODING_DAG,
                                      .ls_from_ws   = {0, 0, 1, -3, 0, 1, 0, -2, -1, 0, 0, 1},
                                      .texel_metres = 2 / side,
                                      .voxel_metres = 2.772588722239781 / side, /* log(16) */
                                      .direction_ws = {-1, 0, 0},
                                      .near_metres  = 0.5,
                                      .cos_outer    = kind == VXS_LIGHT_KIND_SPOT ? flags & VXS_LIGHT_CUBE ? 0.25 : 0.75 : 0},
                            .dag   = s->view};
    strncpy(l.light.name, name, sizeof l.light.name - 1);
    return l;
}

/* Encode a file of one light, "sun". */
static inline vxs_bytes dag_sample_file(const dag_sample *s)
{
    vxs_write_light light = dag_sample_light(s, "sun");
    vxs_write_desc  desc  = {.lights = &light, .light_count = 1, .zstd_level = 1};
    vxs_bytes       file  = {0};
    if (vxs_write(&file, &desc) != VXS_OK) abort();
    return file;
}

#endif
