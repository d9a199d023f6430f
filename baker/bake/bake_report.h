/* Report of a bake: its plan, and its results.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_REPORT_H
#define BAKE_REPORT_H

#include "baker/bake/light_coder.h"
#include "baker/bake/light_picture.h"
#include "baker/bake/plan.h"
#include "baker/base/context.h"
#include "baker/smoke/smoke_map.h"

/* A part of a light, and its size in the file. */
typedef struct part_report {
    vxs_part part;
    uint64_t stored_bytes;
} part_report;

typedef struct light_report {
    vxs_light      light;
    texel_range    texels;
    depth_stats    depth;
    uint64_t       tiles, tiles_skipped;           /* map tiles of at most TILE_MAX_PX; those without casters */
    uint64_t       squares, squares_made;          /* with a square cache: squares of tiles with casters; those made in this run */
    uint64_t       mask_tiles;                     /* 8 x 8 tiles in which no single depth separates lit from shadowed */
    uint64_t       mask_runs;                      /* DAG: their masks, before merging */
    uint64_t       inserted_nodes, inserted_masks; /* DAG: before compression */
    palette_counts palette;                        /* for palette blocks */
    uint64_t       memory_bytes, stored_bytes;
    part_report    parts[VXS_LEVELS_MAX];
    uint32_t       part_count;
    smoke_counts   smoke;
} light_report;

/* All maps: number of texels, and bytes of plain 16-bit depth maps. */
static inline double light_texels(const light_report *l)
{
    return (double)((uint64_t)vxs_map_count(&l->light) << (2 * l->light.levels));
}

static inline double light_depth16_bytes(const light_report *l)
{
    return 2 * light_texels(l);
}

/* Squares of all lights, with a square cache. */
typedef struct square_counts {
    uint64_t all, made; /* with casters; those made in this run */
} square_counts;

/* A light of the scene that was not baked. */
typedef struct light_left_out {
    char        name[VXS_LIGHT_NAME_BYTES];
    const char *why;
} light_left_out;

typedef struct bake_report {
    stage_report    stage[STAGE_COUNT];
    double          total_seconds;   /* from the start until the file has its name */
    double          picture_seconds; /* not included in the total */
    uint64_t        peak_bytes;
    char            renderer[128];
    char            cpu_class[16]; /* "" if the result does not depend on it */
    uint64_t        file_bytes;
    uint64_t        points_bytes;                         /* of file_bytes: random points on casters */
    uint32_t        capsule_count;                        /* of the scene's smoke */
    casters         casters;                              /* only counts, no arrays */
    double          casters_min_ws[3], casters_max_ws[3]; /* metres */
    light_report   *lights;
    uint32_t        light_count;
    light_left_out *left_out;
    size_t          left_out_count;

    scene_exclusion *exclusions; /* [exclusion_count] parts of the scene that do not cast; owned */
    size_t           exclusion_count;
    json_t          *inputs;                         /* input of the bake (baker/bake/provenance.h); owned */
    size_t           warning_count, warnings_before; /* of the bake; of the run before it */
    int unchanged; /* 1: the output was baked from the same input and is kept; only its size, warnings and time are known */

    bake_plan *plan; /* owned */

    light_picture pictures[PICTURES_MAX]; /* of the largest lights, if wanted; owned */
    uint32_t      picture_count;
} bake_report;

/* Fill what is known before the work: counts of casters, and lights of the scene that are not baked. Warns of lights that reach
 * nothing.
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result bake_report_begin(bake_report *report, const scene *s, const casters *c, run_context *m);

square_counts report_squares(const bake_report *r);

/* The lights that are not baked: [{"name", "why"}]. NULL without memory. */
json_t *report_left_out_json(const bake_report *r);

/* Accepts a zeroed object. */
void bake_report_free(bake_report *r);

#endif
