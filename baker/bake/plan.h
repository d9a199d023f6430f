/* Plan of a bake: all decisions, made before the work. The bake takes its decisions only from the plan.
 *
 * Decisions are stored with the numbers that they are based on; plan_text.c describes them. Estimates come from a sample of each
 * map (plan_sample.c) and from measured coefficients (plan_estimate.c). They affect only time and memory, never the bytes of the
 * file. docs/manual.md documents their accuracy.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PLAN_H
#define PLAN_H

#include "baker/bake/bake_options.h"
#include "baker/base/context.h"
#include "baker/light/lit_points.h"
#include "baker/scene/light_choice.h"

enum { PLAN_SAVINGS_MAX = 3, SAMPLE_LEVELS = 3, TILE_SIZES = 4 };

/* Sample of all maps of a light: windows of 4 << SAMPLE_LEVELS texels a side, one in each cell of a map. */
typedef struct light_sample {
    /* of whole maps, exact; blocks are those of depth_block.h */
    size_t   triangles;                                  /* that may touch the maps */
    uint64_t blocks, blocks_empty;                       /* blocks_empty: no triangle may touch them */
    uint64_t blocks_peeled;                              /* with solids that meet others, if these are peeled */
    uint64_t blocks_not_peeled;                          /* with other solids only */
    uint64_t block_triangles;                            /* sum over blocks of the triangles that may touch them */
    uint64_t block_most;                                 /* of the block with the most */
    uint64_t tiles[TILE_SIZES], tiles_empty[TILE_SIZES]; /* of TILE_MAX_PX >> n texels a side, or the whole map */

    /* of the windows */
    double   weight;                      /* texels of the maps per texel of a window */
    uint64_t mask_tiles;                  /* tiles in which no single depth separates lit from shadowed */
    uint64_t mask_runs;                   /* DAG: masks of these tiles */
    uint64_t masks, nodes[SAMPLE_LEVELS]; /* DAG: inserted ones, by level */
    uint64_t unique_masks, unique_nodes;  /* distinct ones among them */

    /* of windows with patterns, as palette blocks */
    uint64_t palette_blocks, unique_blocks; /* all, and distinct ones */
    uint64_t patterns, private_patterns;    /* distinct ones; those of them with a private palette */
    uint64_t block_words, pattern_words;
} light_sample;

/* Estimate of a light's distinct palette blocks. */
typedef struct palette_estimate {
    double blocks, patterns, private_patterns; /* patterns includes private_patterns */
    double block_words, pattern_words, words;
} palette_estimate;

/* Width of a texel at the casters that a light reaches, metres: at the nearest, at half of their surface, at the farthest. All
 * texels of a sun have the same width. From a sample of 256 points. */
typedef struct texel_range {
    double least, median, most;
} texel_range;

typedef struct plan_light {
    char        name[VXS_LIGHT_NAME_BYTES];
    const char *left_out; /* reason why the light is not baked; NULL: it is baked */
    light_shape shape;
    vxs_light   light; /* fitted */
    texel_range texels;
    uint32_t    map_count;
    uint64_t    tiles, tiles_empty; /* of all maps, tile_px texels a side; tiles_empty: no triangle may touch them */

    /* estimated */
    double           seconds[STAGE_COUNT];
    double           mask_tiles;                                   /* in which no single depth separates lit from shadowed */
    double           mask_runs;                                    /* DAG: their masks */
    double           inserted_nodes, inserted_masks, nodes, masks; /* DAG: before and after compression */
    palette_estimate palette;                                      /* for palette blocks */
    double           memory_bytes, stored_bytes;                   /* words that lookups read; size in the file */
    double           built_bytes;                                  /* held until the file is written */
    double           part_bytes;                                   /* held during the build in total; each tile has its share */
    light_sample     sample;
} plan_light;

/* What an option would save. It must be given explicitly, because it changes what the file promises. */
typedef struct plan_saving {
    const char *option; /* "--behind free" */
    uint64_t    file_bytes;
    double      seconds;   /* of the whole bake */
    size_t      triangles; /* --closed on: closed triangles of double-sided materials, which would be solids; else 0 */
} plan_saving;

typedef struct bake_plan {
    /* solids: where exit depths are peeled */
    int    has_exit_map;                     /* 0: no solids, and x = e */
    int    meeting_known;                    /* 1: the solids that meet were found */
    int    peels_all;                        /* 1: every block with solids is peeled */
    double meeting_seconds, peeling_seconds; /* time to find the solids that meet; time that this may save */

    /* sub-DAG compression before the merge */
    compress_order compress; /* COMPRESS_NONE: not done */
    double         compress_seconds, merge_seconds_spared;

    uint32_t tile_px;       /* greatest side of a map tile */
    uint64_t picture_bytes; /* memory of the pictures of the largest lights; 0: not wanted */
    uint64_t budget_bytes;  /* --memory; 0: none */
    uint64_t least_bytes;   /* need of the smallest plan */
    uint64_t scene_bytes;   /* of the scene's file */

    plan_light *lights; /* [light_count] as chosen, including lights that are not baked */
    size_t      light_count, baked_count;

    double   seconds[STAGE_COUNT], total_seconds;
    uint64_t peak_bytes, file_bytes, memory_bytes;
    double   plan_seconds; /* measured time of the plan */

    plan_saving savings[PLAN_SAVINGS_MAX]; /* empty before plan_find_savings */
    size_t      saving_count;
} bake_plan;

/* Reason of a light that reaches nothing (plan_light.left_out). */
extern const char REACHES_NOTHING[];

/* Make a plan.
 * plan         [out] zeroed on failure; released with plan_free
 * c            runs and solid_meets are set if the plan needs them
 * s            scene of c, for names in warnings; NULL: none
 * scene_bytes  of the scene's file
 * Returns VXS_OK; VXS_E_NO_LIGHT if no light reaches a caster; VXS_E_ARGUMENT for a light that cannot be fitted, or two lights of
 * one name; VXS_E_MEMORY, also if no plan stays within the budget (the message gives the need); VXS_E_STRICT, before a light is
 * sampled. Same scene and options, same plan, except for times. */
vxs_result plan_make(bake_plan *plan, const bake_options *o, casters *c, const scene *s, const light_choice *chosen,
                     uint64_t scene_bytes, run_context *m);

/* Accepts a zeroed object. */
void plan_free(bake_plan *plan);

/* plan_checks.c: check the fitted lights of a plan for signs of a bake of little use. Fills texels of each light; warns of
 *   - an object that hides a light from all others (scene_objects.h)
 *   - objects that make a sun's map much larger than the rest needs, and texels wider than most components (coarse_texels.h)
 *   - a punctual light whose range ends within its own fixture
 *   - positions that are stored coarsely, because floats are far from their origin
 * Warnings are given only in nearly certain cases; see docs/manual.md, "Bakes of little use".
 * s  NULL: nodes and their names are not known. Without memory, warnings are left out. */
void plan_check_lights(bake_plan *plan, const bake_options *o, const casters *c, const scene *s, run_context *m);

/* plan_savings.c: find what more don't-care voxels would save, if it is enough to matter. Samples all maps for each option.
 * c  as it was planned.   Returns VXS_OK or VXS_E_MEMORY. */
vxs_result plan_find_savings(bake_plan *plan, const bake_options *o, const casters *c, run_context *m);

/* The same for --closed on only, if at least a quarter of all triangles are closed except for their material. A bake calls this
 * too. Samples nothing if there are fewer. */
vxs_result plan_find_closed(bake_plan *plan, const bake_options *o, const casters *c, run_context *m);

/* Sample all lights with these options, and estimate counts, seconds and bytes of each light and of the bake.
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result plan_estimate(bake_plan *plan, const bake_options *o, const casters *c, run_context *m);

/* plan_sample.c: fill l->sample.
 * maps  number of sampled maps of all lights: with many, each gets fewer windows
 * Returns VXS_OK or VXS_E_MEMORY. The result does not depend on the number of threads. */
vxs_result plan_sample_light(plan_light *l, const bake_plan *plan, uint32_t maps, const bake_options *o, const casters *c,
                             run_context *m);

/* plan_estimate.c: compute seconds and bytes from samples. */
void plan_estimate_light(plan_light *l, const bake_options *o);
void plan_estimate_scene(bake_plan *plan, const casters *c);

/* Peak memory with tiles of tile_px texels a side. */
uint64_t plan_peak_bytes(const bake_plan *plan, const bake_options *o, const casters *c, uint32_t tile_px);

#endif
