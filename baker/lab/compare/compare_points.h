/* The points at which a baked light is compared with the truth, and for each the start of its truth rays.
 *
 * Points are generated from (seed, kind, index): none is stored, and every thread makes its own.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COMPARE_POINTS_H
#define COMPARE_POINTS_H

#include "baker/base/box.h"
#include "baker/base/random.h"
#include "baker/lab/compare/compare.h"
#include "baker/lab/truth/truth.h"
#include "baker/scene/scene.h"
#include "formats/vxs_file.h"

enum { VOLUME_CELLS_SIDE = 64, VOLUME_CELLS = VOLUME_CELLS_SIDE * VOLUME_CELLS_SIDE };

typedef struct light_volume {
    const vxs_light *light; /* borrowed */
    light_shape      shape;
    box              box_ws;
    enum { DRAW_FROM_BOX, DRAW_FROM_MAP, DRAW_FROM_CONE } way;
    double axes[3][3];                /* of the cone: two across it, and its direction */
    double cell_weight[VOLUME_CELLS]; /* the mean of t1^3 - t0^3 over rays through a cell, which are in the box from t0 to t1 */
    double cell_sum[VOLUME_CELLS];    /* this cell and all before it */
} light_volume;

/* box_ws  metres; of some volume */
void light_volume_init(light_volume *v, const vxs_light *light, const box *box_ws);

/* A point in the box and in the volume of the light, uniform by volume.
 * Returns 0 when a hundred points in a row were in only one of them.   Threads: any. */
int light_volume_draw(const light_volume *v, rng *r, double point_ws[3]);

/* The inputs of a comparison. */
typedef struct comparison {
    const truth           *truth;
    const casters         *casters;
    const vxs_baked_light *baked;
    const vxs_light       *light; /* of baked */
    light_shape            shape; /* of the light, for the truth */
    const compare_options *options;
    compare_dont_care      dont_care;
    light_volume           volume; /* source of random points */
    camera_view            view;   /* of options->camera, if there is one */
    uint32_t               width_px, height_px;
} comparison;

typedef struct sample {
    double  point_ws[3];
    double  normal_ws[3];
    double *normal;      /* normal_ws, or NULL for a random point */
    int     map;         /* that is looked up */
    double  truth_ws[3]; /* start of truth rays: the point; for a surface, just above it */
    double  truth_ls[3]; /* the same in the map's coordinates: texels, texels, voxels */
} sample;

void comparison_init(comparison *out, const truth *t, const casters *c, const vxs_baked_light *baked, const compare_options *o);

/* The number of points of a kind; 0 for a camera's when there is none. */
size_t compare_point_count(const comparison *c, compare_kind kind);

/* Point `index` of a kind, [0, compare_point_count).
 * Returns 0 when there is none: casters without area, outside the light's volume, no surface in the pixel. */
int compare_point(const comparison *c, compare_kind kind, size_t index, sample *s);

/* The truth at a place of a map, in texels, texels, voxels. 1: lit. */
int compare_lit_at(const comparison *c, int map, double u, double v, double depth);

/* The maximum error of a ray, in truth_precision: it is rounded, may be tilted, and crosses a map at an angle. */
#define COMPARE_RAY_SLACK 3

/* The maximum that is excused, in texels and voxels. */
#define COMPARE_SLACK_MAX 2.0

/* Rays are tried at this many places on each side of a texel's centre, along both axes, one step apart: the rasterizer and the
 * rounding of rays may move an edge this far. In texels. */
enum { COMPARE_STEPS = 2 };
double compare_step_px(const comparison *c, int map, double u, double v, double depth);

/* Whether the asset has any don't-care rules. */
static inline int compare_leaves_free(const comparison *c)
{
    return c->dont_care.behind || c->dont_care.thickness_metres > 0;
}

/* 1 when voxels on the ray through (u, v) of a map, between two depths, are don't-care voxels. */
int compare_left_free(const comparison *c, int map, double u, double v, double near_vx, double far_vx);

/* FAULT_SELF_SHADOW, FAULT_DEEP_LEAK (see compare_bias), or FAULT_NONE, always for random points.
 * filter  as for vxs_lookup;   lookup  its result, not VXS_OUTSIDE;   lit  the truth at the point */
compare_fault compare_bias_fault(const comparison *c, const sample *s, vxs_filter filter, float lookup, int lit);

/* A wrong answer, and its distance from a place where it would be right. */
typedef struct wrong_answer {
    uint64_t index; /* of the point */
    int      asset_lit;
    float    texels; /* to the boundary; INFINITY: more than 8 */
} wrong_answer;

/* Measure the distance of each wrong answer.
 * answers  [count] texels is set; sorted by it on return
 * Cost: a little over 208 rays for an answer that is farther, a few dozen for most others. */
compare_distance compare_boundary(const comparison *c, compare_kind kind, wrong_answer *answers, size_t count);

#endif
