/* The points at which a baked light is compared with the truth, and for each the start of its truth rays.
 *
 * Points are generated from (seed, kind, index), so that none is stored and every thread makes its own.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COMPARE_POINTS_H
#define COMPARE_POINTS_H

#include "baker/lab/compare/compare_result.h"
#include "baker/lab/compare/light_volume.h"
#include "baker/lab/truth/truth.h"

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

/* Rays are tried at this many places on each side of a texel's centre, along both axes, one step apart: the rasterizer and the
 * rounding of rays may move an edge this far. In texels. */
enum { COMPARE_STEPS = 2 };
double compare_step_px(const comparison *c, int map, double u, double v, double depth);

/* Whether the asset has any don't-care rules. */
static inline int compare_leaves_free(const comparison *c)
{
    return c->dont_care.behind || c->dont_care.thickness_m > 0;
}

/* compare_free.c: 1 when voxels on the ray through (u, v) of a map, between two depths, are don't-care voxels. */
int compare_left_free(const comparison *c, int map, double u, double v, double near_vx, double far_vx);

/* compare_bias.c: FAULT_SELF_SHADOW, FAULT_DEEP_LEAK (see compare_bias), or FAULT_NONE, always for random points.
 * filter_px  as for vxs_lookup;   lookup  its result, not VXS_OUTSIDE;   lit  the truth at the point */
compare_fault compare_bias_fault(const comparison *c, const sample *s, int filter_px, float lookup, int lit);

/* compare_boundary.c: the distance of wrong answers from a place where they would be right. */

typedef struct wrong_answer {
    uint64_t index; /* of the point */
    int      asset_lit;
    float    texels; /* to the boundary; INFINITY: more than 8 */
} wrong_answer;

/* Measure the distance of each wrong answer.
 * answers  [count] texels is set; sorted by it on return
 * Cost: a little over 208 rays for an answer that is farther, a few dozen for most others. */
compare_distance compare_boundary(const comparison *c, compare_kind kind, wrong_answer *answers, size_t count);

/* compare_filter.c: compare filtered lookups with the same filter over rays, for COMPARE_FILTER_POINTS_MAX points at most,
 * spread evenly over the points of the kind.
 * out  [out] written only when VXS_OK is returned.   Returns VXS_OK or VXS_E_MEMORY. */
vxs_result compare_filtered(const comparison *c, compare_kind kind, uint32_t filter_px, compare_error *out, message *m);

/* compare_time.c: measure the time of lookups, and of filtered ones. Only points within the map count: others cost nothing, and
 * would make the mean too low.
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result compare_measure_time(const comparison *c, compare_result *out, message *m);

#endif
