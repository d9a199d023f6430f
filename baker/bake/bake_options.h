/* Options of a bake.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_OPTIONS_H
#define BAKE_OPTIONS_H

#include <jansson.h>

#include "baker/bake/cache/cache_folder.h"
#include "baker/base/context.h"
#include "baker/base/text.h"
#include "baker/base/watch.h"
#include "baker/casters/casters.h"
#include "baker/coding/dag/build.h"
#include "baker/columns/rendered_columns.h"
#include "baker/scene/fingerprint.h"
#include "baker/smoke/smoke_grid.h"
#include "baker/smoke/smoke_map.h"

enum { RESOLUTION_MIN_PX = 8, RESOLUTION_MAX_PX = 262144 };

typedef enum stop_stage {
    STOP_INSERT,  /* sub-DAGs as inserted, side by side */
    STOP_PARTIAL, /* compressed sub-DAGs, side by side */
    STOP_FINAL    /* one merged DAG without equal subtrees */
} stop_stage;

/* Source of depths. auto: sparse, or gl if other options need it; resolved before the bake. */
typedef enum maps_choice { MAPS_AUTO, MAPS_GL, MAPS_SPARSE } maps_choice;

/* Voxels behind the last surface on a ray: in shadow, or don't-care voxels. */
typedef enum behind_choice { BEHIND_SHADOW, BEHIND_FREE } behind_choice;

/* Coding of a light's maps, in the order of VXS_CODING_DAG and on. */
typedef enum coding_choice { CODING_DAG, CODING_BLOCKS } coding_choice;

/* Storage of the pages of palette blocks, in the order of VXS_PACKING_SMALL and on; of fine maps small is VXS_PACKING_FINE. */
typedef enum pack_choice { PACK_SMALL, PACK_FAST } pack_choice;

/* Order of sub-DAG compression; auto: top-down, if the plan finds that it pays. */
typedef enum compress_choice { COMPRESS_CHOICE_AUTO, COMPRESS_CHOICE_TOP_DOWN, COMPRESS_CHOICE_BOTTOM_UP } compress_choice;

/* Words of the options below, in the order of their enums. */
#define MAPS_CHOICES     "auto|gl|sparse"
#define BEHIND_CHOICES   "shadow|free"
#define CODING_CHOICES   "dag|blocks"
#define PACK_CHOICES     "small|fast"
#define EXIT_CHOICES     "auto|peel|back"
#define RULE_CHOICES     "greedy|shadow"
#define REUSE_CHOICES    "off|on"
#define COMPRESS_CHOICES "auto|top-down|bottom-up"
#define STOP_CHOICES     "insert|partial|final"
#define GL_CHOICES       "osmesa|egl"

typedef struct bake_options {
    const char            *scene_path;
    struct bake_scene     *prepared;    /* NULL: read the scene; else a scene with its casters, read only (bake_options.h) */
    const char            *output_path; /* "-" is standard output; NULL: nothing is written */
    const char            *page_path;   /* NULL: none; else pictures of the maps of the largest lights are kept for the page */
    scene_choice           scene;       /* scene of the file, and which parts of it cast */
    text_list              light_names; /* empty: all lights, or the suns */
    named_list             suns;        /* all have a name; direction in which sunlight travels, any length but zero */
    uint32_t               resolution;  /* texels a side, for lights without an entry below; 0: from texel_metres */
    double                 texel_metres;
    named_list             resolutions, texels; /* by light; no light is in both */
    int                    region_given;
    double                 region_ws[6]; /* min xyz, max xyz */
    maps_choice            maps;
    closed_mode            closed;
    exit_mode              exit;
    behind_choice          behind;
    double                 thickness_metres; /* of sheets that face the light; 0: none */
    coding_choice          coding;
    pack_choice            pack; /* for palette blocks */
    mask_rule              rule;
    int                    reuse;
    compress_choice        compress;
    stop_stage             stop;
    gl_backend             gl;
    const column_renderer *renderer; /* for MAPS_GL; NULL: this program has none */
    uint32_t               threads;
    uint32_t               zstd_level;   /* 1..19 */
    uint32_t               points;       /* number of random points on casters in the file; 0: none */
    const char            *smoke_path;   /* a smoke grid in NRRD; NULL: none */
    int                    scene_smoke;  /* 1: bake also the scene's smoke capsules */
    double                 smoke_factor; /* factor from the grid's numbers to extinction per metre */
    smoke_settings         smoke;
    uint64_t               memory_bytes; /* limit of the bake's memory; 0: none */
    const char            *resume_path;  /* folder of the square cache; NULL: none */
    uint32_t               part, parts;  /* bake part `part` of `parts`, from 1; 0 of 0: the whole */
    int                    if_changed;   /* 1: keep the output and do nothing, if this version baked it from the same input */
    const run_watch       *watch;        /* gets the progress; NULL: not wanted; borrowed */

    const square_exchange *others; /* other processes that make squares of this bake; NULL: none */
} bake_options;

/* Whether squares are stored: in the cache, as a part, or for other processes. */
static inline int stores_squares(const bake_options *o)
{
    return o->resume_path || o->parts || o->others;
}

/* Whether another process adds the squares that are made here, and writes the asset. */
static inline int is_baked_apart(const bake_options *o)
{
    return o->parts || (o->others && !o->others->adds);
}

/* Whether smoke is baked, if there is some. */
static inline int bakes_smoke(const bake_options *o)
{
    return o->smoke_path || o->scene_smoke;
}

/* Whether more voxels than the insides of solids are don't-care voxels; only the sparse source supports this. */
static inline int leaves_more_free(const bake_options *o)
{
    return o->behind == BEHIND_FREE || o->thickness_metres > 0;
}

/* The order of a choice; auto: top-down, if sub-DAGs are compressed at all. */
compress_order compress_order_of(compress_choice choice);

/* Options of a DAG build: rule, reuse and stop. If the stop comes before compression, `compress` is ignored. */
build_options build_options_of(const bake_options *o, compress_order compress);

/* Side of a light's map in texels; 0: from *texel_metres, which is set. */
uint32_t light_resolution(const bake_options *o, const char *light_name, double *texel_metres);

/* As JSON: the options that decide the baked bytes, except those by light; and all options that matter for the report. NULL
 * without memory. */
json_t *bake_choices_json(const bake_options *o);
json_t *bake_smoke_json(const bake_options *o); /* only smoke */
json_t *bake_options_json(const bake_options *o);

/* A scene that was read, with its casters: the input of bakes of any of its lights. */

/* Zero it. */
typedef struct bake_scene {
    scene             scene;
    scene_fingerprint fingerprint;
    casters           casters;
    smoke_grid        smoke;      /* zeroed if there is none */
    uint64_t          file_bytes; /* of the scene's file; 0: not known. Buffer files of a .gltf are not counted */
} bake_scene;

/* Read o->scene_path, and compute its fingerprint.
 * check  NULL: none
 * Returns what scene_load_gltf_checked returns. */
vxs_result bake_scene_read(bake_scene *s, const bake_options *o, const scene_check *check, bake_context *ctx);

/* Read the smoke grid that the options name, if any.   Returns what nrrd_read returns. */
vxs_result bake_scene_read_smoke(bake_scene *s, const bake_options *o, bake_context *ctx);

/* The smoke that is baked.   Valid until bake_scene_free. */
smoke_source bake_scene_smoke(const bake_scene *s, const bake_options *o);

/* Find the casters of a scene that was read.   Returns what casters_for_maps and context_check return. */
vxs_result bake_scene_find_casters(bake_scene *s, const bake_options *o, bake_context *ctx);

/* Accepts a zeroed object. */
void bake_scene_free(bake_scene *s);

#endif
