/* What a bake is asked to do.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_OPTIONS_H
#define BAKE_OPTIONS_H

#include <jansson.h>

#include "baker/bake/cache/square_exchange.h"
#include "baker/base/text.h"
#include "baker/base/watch.h"
#include "baker/casters/casters.h"
#include "baker/coding/dag/build.h"
#include "baker/columns/rendered_columns.h"
#include "baker/smoke/smoke_map.h"

enum { RESOLUTION_MIN_PX = 8, RESOLUTION_MAX_PX = 262144 };

typedef enum stop_stage {
    STOP_INSERT,  /* sub-DAGs as they were inserted, side by side */
    STOP_PARTIAL, /* each sub-DAG compressed, side by side */
    STOP_FINAL    /* merged into one DAG without equal subtrees */
} stop_stage;

/* Where depths come from. auto: sparse, or gl where other options ask for it; a bake is told which. */
typedef enum maps_choice { MAPS_AUTO, MAPS_GL, MAPS_SPARSE } maps_choice;

/* What is baked of where a ray leaves the last surface of the scene. */
typedef enum behind_choice { BEHIND_SHADOW, BEHIND_FREE } behind_choice;

/* How the words of a light hold its maps, in the order of VXS_CODING_DAG and after. */
typedef enum coding_choice { CODING_DAG, CODING_BLOCKS } coding_choice;

/* How pages of palette blocks are stored, in the order of VXS_PACKING_SMALL and after. */
typedef enum pack_choice { PACK_SMALL, PACK_FAST } pack_choice;

/* Order of sub-DAG compression; auto: top-down, where the plan says that it pays. */
typedef enum compress_choice { COMPRESS_CHOICE_AUTO, COMPRESS_CHOICE_TOP_DOWN, COMPRESS_CHOICE_BOTTOM_UP } compress_choice;

/* The words of the options below, in the order of their enums. */
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
    struct bake_scene     *prepared; /* NULL: the scene is read; else it is there, with its casters, and read only (bake_scene.h) */
    const char            *output_path; /* "-" is standard output; NULL: nothing is written */
    const char            *page_path;   /* NULL: none. Else pictures of the maps of the largest lights are kept for it */
    scene_choice           scene;       /* which one of the file, and what of it casts */
    text_list              light_names; /* none: all lights, or the suns */
    named_list             suns;        /* all have a name; the way sunlight travels, of any length but zero */
    uint32_t               resolution;  /* texels a side of a map whose light has none of its own below; 0: from texel_metres */
    double                 texel_metres;
    named_list             resolutions, texels; /* by light; none is in both */
    int                    region_given;
    double                 region_ws[6]; /* min xyz, max xyz */
    maps_choice            maps;
    closed_mode            closed;
    exit_mode              exit;
    behind_choice          behind;
    double                 thickness_m; /* of sheets that face the light; 0: none */
    coding_choice          coding;
    pack_choice            pack; /* of palette blocks */
    mask_rule              rule;
    int                    reuse;
    compress_choice        compress;
    stop_stage             stop;
    gl_backend             gl;
    const column_renderer *renderer; /* with MAPS_GL; NULL: this program has none */
    uint32_t               threads;
    uint32_t               zstd_level;   /* 1..19 */
    uint32_t               points;       /* of what casts, in the file; 0: none */
    const char            *smoke_path;   /* a grid of smoke in NRRD; NULL: none */
    int                    scene_smoke;  /* 1: the scene's capsules are baked, too */
    double                 smoke_factor; /* on its numbers: extinction per metre */
    smoke_settings         smoke;
    uint64_t               memory_bytes; /* what the bake may hold at most; 0: as much as it needs */
    const char            *resume_path;  /* a folder where squares are kept; NULL: none */
    uint32_t               part, parts;  /* which of how many parts is baked, from 1; 0 of 0: all is */
    int              if_changed; /* 1: where the output was baked from the same by this version, it stays, and nothing is done */
    const run_watch *watch;      /* who is told how far it is; NULL: nobody; borrowed */

    const square_exchange *others; /* processes that make squares of this bake, too; NULL: none */
} bake_options;

/* Whether squares of the maps are kept, in a folder, as a part, or for others. */
static inline int keeps_squares(const bake_options *o)
{
    return o->resume_path || o->parts || o->others;
}

/* Whether squares are made here and added by somebody else, who writes the asset. */
static inline int is_baked_apart(const bake_options *o)
{
    return o->parts || (o->others && !o->others->adds);
}

/* Whether smoke is baked, where there is some. */
static inline int bakes_smoke(const bake_options *o)
{
    return o->smoke_path || o->scene_smoke;
}

/* Whether more is left free than the insides of solids, as only the sparse source can tell. */
static inline int leaves_more_free(const bake_options *o)
{
    return o->behind == BEHIND_FREE || o->thickness_m > 0;
}

/* The order that a choice names; auto: top-down, where sub-DAGs are compressed at all. */
compress_order compress_order_of(compress_choice choice);

/* How DAGs are built by these options: rule, reuse and stop, with sub-DAGs compressed in an order that the stop may leave out. */
build_options build_options_of(const bake_options *o, compress_order compress);

/* The side of a light's map in texels; 0: from *texel_metres, which is written. */
uint32_t light_resolution(const bake_options *o, const char *light_name, double *texel_metres);

/* Words and numbers of the options that decide which bytes are baked, but for what goes by light; and of all that make a difference to
 * the report. NULL without memory. */
json_t *bake_choices_json(const bake_options *o);
json_t *bake_smoke_json(const bake_options *o); /* of smoke alone */
json_t *bake_options_json(const bake_options *o);

#endif
