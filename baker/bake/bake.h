/* From a scene to a .vxs file: the list of stages, and what they report.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_H
#define BAKE_H

#include <jansson.h>

#include "baker/bake/light_picture.h"
#include "baker/base/text.h"
#include "baker/casters/casters.h"
#include "baker/columns/opengl/depth_gl.h"
#include "baker/dag/dag.h"

enum { RESOLUTION_MIN_PX = 8, RESOLUTION_MAX_PX = 16384, TILE_MIN_PX = 512, SUB_DAG_MAX_PX = 1024, PICTURES_MAX = 4 };

typedef enum stop_stage {
    STOP_INSERT,  /* sub-DAGs as they were inserted, side by side */
    STOP_PARTIAL, /* each sub-DAG compressed, side by side */
    STOP_FINAL    /* merged into one DAG without equal subtrees */
} stop_stage;

/* Order of sub-DAG compression; auto: top-down, where the plan says that it pays. */
typedef enum compress_choice { COMPRESS_CHOICE_AUTO, COMPRESS_CHOICE_TOP_DOWN, COMPRESS_CHOICE_BOTTOM_UP } compress_choice;

typedef enum baseline_mode { BASELINE_SAMPLE, BASELINE_FULL, BASELINE_OFF } baseline_mode;

/* The words of the options below, in the order of their enums. */
#define EXIT_CHOICES     "auto|peel|back"
#define RULE_CHOICES     "greedy|shadow"
#define REUSE_CHOICES    "off|on"
#define COMPRESS_CHOICES "auto|top-down|bottom-up"
#define STOP_CHOICES     "insert|partial|final"
#define GL_CHOICES       "osmesa|egl"
#define BASELINE_CHOICES "sample|full|off"

typedef struct bake_options {
    const char     *scene_path;
    const char     *output_path; /* "-" is standard output */
    const char     *scene_name;  /* NULL: the default scene */
    text_list       light_names; /* none: all directional lights, or the sun */
    int             sun_given;
    double          sun[3];     /* the way sunlight travels; any length but zero */
    uint32_t        resolution; /* texels a side; 0: from texel_metres */
    double          texel_metres;
    int             region_given;
    double          region_ws[6]; /* min xyz, max xyz */
    closed_mode     closed;
    exit_mode       exit;
    mask_rule       rule;
    int             reuse;
    compress_choice compress;
    stop_stage      stop;
    gl_backend      gl;
    uint32_t        threads;
    uint32_t        zstd_level; /* 1..19 */
    baseline_mode   baseline;
    uint64_t        memory_bytes; /* what the bake may hold at most; 0: as much as it needs */
    int             pictures;     /* 1: keep pictures of the maps of the largest lights, for a page */
    int             progress;     /* 1: say on standard error how far it is */
} bake_options;

typedef enum bake_stage {
    STAGE_LOAD,     /* glTF to triangles */
    STAGE_SOLIDS,   /* weld, components, solids and sheets */
    STAGE_PLAN,     /* what the scene needs, and which solids meet */
    STAGE_GL,       /* OpenGL context, vertices in light space */
    STAGE_MAPS,     /* enter and exit depth */
    STAGE_PYRAMID,  /* min-max pyramid */
    STAGE_MASKS,    /* visibility masks */
    STAGE_INSERT,   /* sub-DAGs */
    STAGE_COMPRESS, /* sub-DAG compression */
    STAGE_MERGE,    /* into one DAG */
    STAGE_ENCODE,   /* sections, zstd */
    STAGE_WRITE,    /* reading back what was encoded, and the file */
    STAGE_COUNT
} bake_stage;

typedef struct stage_report {
    double   seconds;    /* wall time over all tiles and lights */
    uint64_t peak_bytes; /* most memory that the process held while in this stage; 0 where the system does not tell */
} stage_report;

/* A section of a light in the file: a level, or its masks. */
typedef struct level_report {
    uint32_t side_voxels; /* 16.. octree nodes, 8 slice nodes, 0 masks */
    uint32_t count;
    uint64_t memory_bytes, stored_bytes;
} level_report;

typedef struct light_report {
    vxs_light    light;
    depth_stats  depth;
    uint64_t     tiles, tiles_skipped;           /* map tiles of TILE_MAX_PX at most; without casters */
    uint64_t     mask_tiles, mask_runs;          /* 8 x 8 tiles that need masks; masks before merging */
    uint64_t     inserted_nodes, inserted_masks; /* before compression */
    uint64_t     memory_bytes, stored_bytes;
    level_report level[VXS_LEVELS_MAX]; /* the root first, masks last */
    uint32_t     level_count;
    double       depth_zstd19_ratio; /* zstd -19 over raw, of the 16-bit depth map; 0: not measured */
    double       depth_sample_share; /* of its texels that this was measured on */
} light_report;

/* A light of the scene that was not baked. */
typedef struct light_left_out {
    char        name[VXS_LIGHT_NAME_BYTES];
    const char *why;
} light_left_out;

/* Why a light reaches nothing. */
extern const char REACHES_NOTHING[];

typedef struct bake_plan bake_plan; /* plan.h */

typedef struct bake_report {
    stage_report    stage[STAGE_COUNT];
    double          total_seconds;                     /* from start to the file under its name */
    double          baseline_seconds, picture_seconds; /* no part of the total */
    uint64_t        peak_bytes;
    char            renderer[128];
    uint64_t        file_bytes;
    casters         casters; /* counts only: no arrays */
    double          casters_min_ws[3], casters_max_ws[3];
    light_report   *lights;
    uint32_t        light_count;
    light_left_out *left_out;
    size_t          left_out_count;

    bake_plan *plan; /* owned */

    light_picture pictures[PICTURES_MAX]; /* of the largest lights, when asked for: owned */
    uint32_t      picture_count;
} bake_report;

/* Words for the options that decide what is baked, and for all that make a difference to the report. */
json_t *bake_choices_json(const bake_options *o);
json_t *bake_options_json(const bake_options *o);

/* Bake a scene. The output is complete under its name, or untouched.
 * report  [out] zero it first; released with bake_report_free, whatever is returned.
 * Same scene and options, same bytes, at any thread count. */
vxs_result bake(const bake_options *o, bake_report *report, message *m);

/* Only what would be done: fills what is known before the work, the plan above all. */
vxs_result bake_plan_only(const bake_options *o, bake_report *report, message *m);

void bake_report_free(bake_report *r);

const char *bake_stage_name(bake_stage stage);

#endif
