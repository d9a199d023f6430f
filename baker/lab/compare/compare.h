/* How often a baked light is wrong, where, by how far, and how fast its lookups are: lookups against the ray-traced truth.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COMPARE_H
#define COMPARE_H

#include "baker/lab/truth/camera.h"
#include "baker/lab/truth/truth.h"
#include "formats/vxs_file.h"

enum {
    COMPARE_EXAMPLES_MAX      = 10,
    COMPARE_FILTERS_MAX       = VXS_FILTER_MAX / 2 + VXS_FILTER_MAX, /* the odd widths above 1; smooth ones of all widths */
    COMPARE_FILTER_POINTS_MAX = 20000,
    COMPARE_TIMED_POINTS_MAX  = 1000000
};

/* The aspect of a camera's picture: width / height. */
#define COMPARE_CAMERA_ASPECT (16.0 / 9)

/* Where the points come from. */
typedef enum compare_kind {
    /* Uniform in the light's volume (map, cone, range) and the casters' bounding box, 5 % larger; without a normal. */
    COMPARE_RANDOM,
    /* Uniform by area on casters, both sides of sheets; looked up with the normal. For a spot or point light, on the surfaces
     * that it reaches; where these are too small to be sampled so, the first surfaces behind random points of its volume. */
    COMPARE_SURFACE,
    /* The surface seen through the centre of each pixel of a camera; looked up with the normal, towards the eye. */
    COMPARE_CAMERA,
    COMPARE_KINDS
} compare_kind;

/* The don't-care rules of an asset besides the insides of solids. */
typedef struct compare_dont_care {
    int    behind;           /* 1: behind the last surface */
    double thickness_metres; /* of single-sided sheets that face the light */
} compare_dont_care;

typedef struct compare_options {
    uint32_t           points; /* of each kind; a camera's number is rounded to make a picture */
    uint32_t           seed;
    vxs_filter         filters[COMPARE_FILTERS_MAX]; /* as for vxs_lookup, without duplicates: compared besides single taps */
    uint32_t           filter_count;
    const camera_pose *camera; /* NULL: no points of a camera */
    uint32_t           threads;
} compare_options;

/* Distance in texels from wrong answers to the nearest place where the truth agrees with the asset. */
typedef struct compare_distance {
    uint64_t points;                 /* number of wrong answers that are near enough to be measured */
    uint64_t beyond;                 /* the others */
    double   mean, median, p95, max; /* of points; 0 when there are none */
} compare_distance;

/* Faults that nothing excuses. */
typedef enum compare_fault { FAULT_NONE, FAULT_UNEXPLAINED, FAULT_SELF_SHADOW, FAULT_DEEP_LEAK } compare_fault;

/* Faults of the bias of lookups on surfaces. */
typedef struct compare_bias {
    uint64_t self_shadows; /* not fully lit, although no caster is between the light and the plane of the surface, under the filter
                              and one texel around it */
    uint64_t deep_leaks;   /* lit, although casters are before the filter and one texel around it, farther from the point than the
                              filter's width */
} compare_bias;

/* points = outside + inside_solid + left_free + checked; wrong = leaks + false_shadows = near_boundary + near_surface +
 * unexplained = boundary.points + boundary.beyond. All are 0 for a kind that was not compared, and the last two for random
 * points. */
typedef struct compare_counts {
    uint64_t points;
    uint64_t outside;      /* tried, but not in the light's volume; for a camera also pixels without a surface */
    uint64_t inside_solid; /* where answers are undefined */
    uint64_t left_free;    /* lit, in shadow by the truth, in a don't-care voxel of the asset */
    uint64_t checked;
    uint64_t leaks;         /* lit in the asset, in shadow by the truth */
    uint64_t false_shadows; /* in shadow in the asset, lit by the truth */
    uint64_t near_boundary; /* the ray through the centre of the texel agrees with the asset, in the voxel that was looked up */
    uint64_t near_surface;  /* else, the voxel is free there: inside a solid, or crossed by a surface */
    uint64_t unexplained;   /* neither: a fault */
    compare_distance boundary;
    compare_bias     bias;
} compare_counts;

/* A wrong answer without an excuse. */
typedef struct compare_example {
    compare_fault fault;
    compare_kind  kind;
    double        point_ws[3];
    double        normal_ws[3]; /* zero for random points */
    int           map;          /* of the light: 0, or 0 to 5 of six */
    int32_t       voxel[3];     /* that was looked up */
    int           asset_lit, truth_lit;
} compare_example;

/* Filtered lookups against the same filter over rays. */
typedef struct compare_error {
    uint64_t     points; /* compared: neither outside nor inside a solid */
    double       rmse, max_error;
    compare_bias bias; /* of these points */
} compare_error;

typedef struct compare_filter {
    compare_error error[COMPARE_KINDS];
    double        lookup_s; /* as compare_time.lookup_s */
} compare_filter;

typedef struct compare_time {
    uint64_t points;            /* random points inside the map */
    double   lookup_s, truth_s; /* a single tap and a ray, for one point, on one thread: the median of five runs */
} compare_time;

typedef struct compare_result {
    compare_counts  counts[COMPARE_KINDS];
    compare_filter  filters[COMPARE_FILTERS_MAX]; /* [filter_count] */
    compare_example examples[COMPARE_EXAMPLES_MAX];
    uint32_t        example_count;
    compare_time    time;
} compare_result;

/* The size of a camera's picture with at most this many points, with an aspect as near to COMPARE_CAMERA_ASPECT as possible. */
void compare_picture_size(uint32_t points, uint32_t *width_px, uint32_t *height_px);

/* Compare one light with the truth.
 *
 * For a surface point the truth is traced from the surface itself (truth_lift), so that errors of the lookup's bias count as
 * well. A wrong answer is explained if rays near the centre of the texel that was looked up, in its voxel, give that answer.
 * "Near" covers rounding: a rasterizer may move edges by 1/128 texel and depths by a twentieth of a voxel, and rays are off by
 * three times truth_precision. The latter is more texels the nearer a caster is to a spot or point light; two texels at most.
 * compare_excuse.c explains how the distance is measured. In don't-care voxels no answer is wrong.
 * t      of c;   c  with the solids that the light was baked with
 * Same scene, asset, and options: same counts, at any thread count.   Returns VXS_OK or VXS_E_MEMORY. */
vxs_result compare_light(compare_result *out, const truth *t, const casters *c, const vxs_baked_light *light,
                         const compare_dont_care *dont_care, const compare_options *o, run_context *m);

/* Leaks and false shadows. */
uint64_t compare_wrong(const compare_counts *n);

#endif
