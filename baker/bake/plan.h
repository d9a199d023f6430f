/* What a scene needs and what is left out, decided before the work. The bake takes its decisions from the plan alone.
 *
 * Decisions come with the numbers that they rest on; plan_text.c puts them into words. Estimates come from a sample of each map
 * (plan_sample.c) and from measured coefficients (plan_estimate.c): they decide only what takes less time or memory, never what is in
 * the file. docs/manual.md says how far off they are.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PLAN_H
#define PLAN_H

#include "baker/bake/bake_options.h"
#include "baker/base/context.h"
#include "baker/light/reach.h"
#include "baker/scene/light_choice.h"

enum { PLAN_SAVINGS_MAX = 3, SAMPLE_LEVELS = 3, TILE_SIZES = 4 };

/* What is known of all maps of a light from a sample of them: windows of 4 << SAMPLE_LEVELS texels a side, one in each cell of a map. */
typedef struct light_sample {
    /* of whole maps, and exact; blocks are those of depth_block.h */
    size_t   triangles;                                  /* that may touch them */
    uint64_t blocks, blocks_empty;                       /* blocks_empty: no triangle may touch them */
    uint64_t blocks_peeled;                              /* hold solids that meet another, where that is peeled */
    uint64_t blocks_not_peeled;                          /* hold other solids alone */
    uint64_t block_triangles;                            /* over all blocks, the triangles that may touch each */
    uint64_t block_most;                                 /* of the block with the most */
    uint64_t tiles[TILE_SIZES], tiles_empty[TILE_SIZES]; /* of TILE_MAX_PX >> n texels a side, or the whole map */

    /* of the windows */
    double   weight;                      /* texels of the maps for each texel of a window */
    uint64_t mask_tiles;                  /* tiles that no single depth parts into lit and shadowed */
    uint64_t mask_runs;                   /* of a DAG: their masks */
    uint64_t masks, nodes[SAMPLE_LEVELS]; /* of a DAG: inserted, by level */
    uint64_t unique_masks, unique_nodes;  /* different ones among them */

    /* of windows with patterns, as palette blocks */
    uint64_t palette_blocks, unique_blocks; /* all, and different ones */
    uint64_t patterns, own_patterns;        /* different ones; of them, those with depths of their own */
    uint64_t block_words, pattern_words;
} light_sample;

/* Palette blocks that a light will take, different ones alone. */
typedef struct palette_estimate {
    double blocks, patterns, own_patterns; /* own ones are among the patterns */
    double block_words, pattern_words, words;
} palette_estimate;

/* How wide a texel is at the casters that a light reaches, in metres: at the nearest, at half of their surface, at the farthest. A sun's
 * texels are alike. Of a sample of 256 points. */
typedef struct texel_range {
    double least, median, most;
} texel_range;

/* Of one light. */
typedef struct plan_light {
    char        name[VXS_LIGHT_NAME_BYTES];
    const char *left_out; /* why it is not baked; NULL: it is */
    light_shape shape;
    vxs_light   light; /* fitted */
    texel_range texels;
    uint32_t    map_count;
    uint64_t    tiles, tiles_empty; /* of all maps, of tile_px texels a side; tiles_empty: no triangle may touch them */

    /* estimated */
    double           seconds[STAGE_COUNT];
    double           mask_tiles;                                   /* that no single depth parts into lit and shadowed */
    double           mask_runs;                                    /* of a DAG: their masks */
    double           inserted_nodes, inserted_masks, nodes, masks; /* the same: before and after compression */
    palette_estimate palette;                                      /* of palette blocks */
    double           memory_bytes, stored_bytes;                   /* in the words that lookups read; in the file */
    double           built_bytes;                                  /* held for it until the file is written */
    double           part_bytes; /* held, of all of it, while it is built: of each tile its share */
    light_sample     sample;
} plan_light;

/* What an option would save that nobody has asked for, as it changes what the file promises. */
typedef struct plan_saving {
    const char *option; /* "--behind free" */
    uint64_t    file_bytes;
    double      seconds;   /* of the whole bake */
    size_t      triangles; /* of --closed on: that are closed, and would be solids but for a material of two sides; else 0 */
} plan_saving;

typedef struct bake_plan {
    /* solids: where exit depths are peeled */
    int    has_exit_map;                     /* 0: nothing is solid, and x = e */
    int    meeting_known;                    /* which solids meet was found out */
    int    peels_all;                        /* every block with solids is peeled */
    double meeting_seconds, peeling_seconds; /* what finding out takes; what it might spare */

    /* sub-DAG compression before the merge */
    compress_order compress; /* COMPRESS_NONE: left out */
    double         compress_seconds, merge_seconds_spared;

    uint32_t tile_px;       /* side of a map tile at most */
    uint64_t picture_bytes; /* what pictures of the largest lights hold; 0: nobody asked for them */
    uint64_t budget_bytes;  /* --memory; 0: none */
    uint64_t least_bytes;   /* what the smallest plan needs */
    uint64_t scene_bytes;   /* of the scene's file */

    reach_index reach;
    plan_light *lights; /* [light_count] as chosen, left out ones among them */
    size_t      light_count, baked_count;

    double   seconds[STAGE_COUNT], total_seconds;
    uint64_t peak_bytes, file_bytes, memory_bytes;
    double   plan_seconds; /* measured: what the plan itself took */

    plan_saving savings[PLAN_SAVINGS_MAX]; /* plan_savings.c: none before it is asked */
    size_t      saving_count;
} bake_plan;

/* Why a light reaches nothing. */
extern const char REACHES_NOTHING[];

/* Make a plan.
 * plan         [out] zeroed on failure; released with plan_free
 * c            gets solid_meets where the plan needs it
 * s            the scene that c is of, whose names warnings tell; NULL: none is known
 * scene_bytes  of the scene's file
 * Returns VXS_OK; VXS_E_NO_LIGHT when no light reaches a caster; VXS_E_ARGUMENT for a light that cannot be fitted, or two of one name;
 * VXS_E_MEMORY, also when no plan stays within the budget: one line says how much is needed; VXS_E_STRICT, before a light is sampled.
 * Same scene and options, same plan, but for the clock. */
vxs_result plan_make(bake_plan *plan, const bake_options *o, casters *c, const scene *s, const light_choice *chosen,
                     uint64_t scene_bytes, message *m);

/* Accepts a zeroed object. */
void plan_free(bake_plan *plan);

/* plan_checks.c: what the lights of a plan, which are fitted, show of a bake that would be of little use. Fills texels of each; warns of
 *   - an object that keeps a light from all others (light_hider.h)
 *   - objects that make a sun's map much larger than that of the rest, and texels wider than most components (coarse_texels.h)
 *   - a lamp whose range ends behind its own fixture
 *   - positions that are stored coarsely, as floats far from their origin
 * A warning comes where it is nearly certain; docs/manual.md, "Bakes of little use", says when.
 * s  NULL: nothing is known of nodes and their names. Without memory, warnings are left out. */
void plan_check_lights(bake_plan *plan, const bake_options *o, const casters *c, const scene *s, message *m);

/* plan_savings.c: what would be saved if more were left free, where that is worth it: a sample of all maps for each option.
 * c  as they were planned.   Returns VXS_OK or VXS_E_MEMORY. */
vxs_result plan_find_savings(bake_plan *plan, const bake_options *o, const casters *c, message *m);

/* The same of --closed on alone, where a quarter of all triangles or more are closed but for their material: a bake asks for it, too. Nothing is
 * sampled where there are fewer. */
vxs_result plan_find_closed(bake_plan *plan, const bake_options *o, const casters *c, message *m);

/* Sample all lights as these options would bake them, and estimate counts, seconds and bytes of them and of the whole.
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result plan_estimate(bake_plan *plan, const bake_options *o, const casters *c, message *m);

/* plan_sample.c: fill l->sample.
 * maps  that are sampled of all lights: of many, each gets fewer windows
 * Returns VXS_OK or VXS_E_MEMORY.  Same input, same result, at any number of threads. */
vxs_result plan_sample_light(plan_light *l, const bake_plan *plan, uint32_t maps, const bake_options *o, const casters *c,
                             message *m);

/* plan_estimate.c: from samples to seconds and bytes. */
void plan_estimate_light(plan_light *l, const bake_options *o);
void plan_estimate_scene(bake_plan *plan, const casters *c);

/* Peak memory with tiles of so many texels. */
uint64_t plan_peak_bytes(const bake_plan *plan, const bake_options *o, const casters *c, uint32_t tile_px);

#endif
