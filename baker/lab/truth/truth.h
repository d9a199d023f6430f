/* The ray-traced truth: whether points are lit, whether they are inside solids, what a ray meets first. Slow, plain, and
 * independent of the bake, so that the bake can be checked against it.
 *
 * All coordinates are world space, in metres. Embree traces in float, so casters and points are moved to the centre of the
 * casters' bounds and scaled by a power of two, in double, before they are rounded. Results are those of casters and rays
 * displaced by at most truth_precision(), wherever the scene is in the world. Both sides of every triangle count.
 * Rays pass through the holes of alpha-tested triangles (baker/scene/scene.h).
 *
 * Threads: every function that takes a const truth may be called from any number of threads at once.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TRUTH_H
#define TRUTH_H

#include "baker/casters/casters.h"
#include "formats/vxs_file.h"
#include "formats/vxs_format.h"

typedef struct truth truth;

/* Build the acceleration structure.
 * t        [out] NULL on failure; destroyed with truth_destroy
 * c        at least one triangle, indices in range; borrowed until truth_destroy
 * threads  for building, 0: all processors; answers do not depend on it
 * Returns VXS_OK, VXS_E_NO_CASTER, VXS_E_SCENE (a position is not finite), VXS_E_MEMORY, VXS_E_UNSUPPORTED (a processor that
 * Embree does not run on).   Cost: half a second for a million triangles on one core, 80 bytes a triangle. */
vxs_result truth_create(truth **t, const casters *c, uint32_t threads, run_context *m);

/* Accepts NULL. */
void truth_destroy(truth *t);

/* The maximum distance in metres by which rounding to float may displace a surface or a ray inside the casters' bounds. */
double truth_precision(const truth *t);

/* Move a point off its surface, so that the surface does not shadow it: by 1e-5 of the diagonal of the casters' bounds along its
 * normal, about twenty times truth_precision.
 * normal_ws  unit
 * lifted_ws  [out] may be point_ws */
void truth_lift(const truth *t, const double point_ws[3], const double normal_ws[3], double lifted_ws[3]);

/* 1 when no caster is between the point and the light, 0 otherwise. The light's cone and range are ignored; light_reaches()
 * tests them. Casters within truth_precision of the point, along the ray, are ignored, so that a point on a floor is not in the
 * floor's shadow, unless the light is nearly parallel to it. Casters at the position of a spot or point light are ignored, too:
 * a punctual light may be in a ceiling. Casters near such a light, within a thousandth of the scene's size, are tested in double,
 * so that a caster a millimetre in front of a punctual light casts the right shadow a kilometre away. A light may be inside the
 * casters' bounds or far outside.
 * Cost: one or two rays; 2 to 10 million points a second on one core, with up to 700 000 triangles. */
int truth_lit(const truth *t, const double point_ws[3], const light_shape *light);

/* 1 when the winding number of the solids around the point is above zero: inside one solid or more. Sheets are ignored.
 * Within truth_precision of a solid's surface the result may be either. */
int truth_inside_solid(const truth *t, const double point_ws[3]);

/* The first caster along a ray; at equal distances, the one with the lower triangle number.
 * direction_ws  unit
 * distance      [out] metres, >= 0; may be NULL, as may the next two; none is written when 0 is returned
 * normal_ws     [out] unit, by the triangle's winding: outward, whichever side was hit
 * triangle      [out] index into the casters' triangles
 * Returns 1 when a caster was hit. */
int truth_first_hit(const truth *t, const double origin_ws[3], const double direction_ws[3], double *distance, double normal_ws[3],
                    uint32_t *triangle);

/* Sample a point of the casters' surfaces, uniform by area if `uniforms` are uniform and independent.
 * uniforms   [3] in [0,1)
 * point_ws   [out]
 * normal_ws  [out] unit, by the triangle's winding; may be NULL
 * triangle   [out] may be NULL
 * Returns 0, and writes nothing, when all triangles together have no area, or when 64 points in a row are in holes of
 * alpha-tested triangles.   Cost: O(log triangles) for each of them. */
int truth_sample_surface(const truth *t, const double uniforms[3], double point_ws[3], double normal_ws[3], uint32_t *triangle);

enum { FILTER_TAPS_MAX = VXS_FILTER_MAX + 1 }; /* a smooth box covers this many texels of a row, the first and the last in part */

/* The texels that a filtered lookup reads, and their weights: the column's times the row's. */
typedef struct filter_taps {
    int      map;                      /* of the light; -1: the point is outside the light's volume, and the other members are
                                          not set */
    int32_t  first[2], depth;          /* column and row of the first texel, and the depth of all, voxels */
    int      count[2];                 /* columns, and rows */
    uint32_t part[2][FILTER_TAPS_MAX]; /* [count] weight of each column and row, in 1/256: 1 to 256 */
} filter_taps;

/* normal_ws, filter  as for vxs_lookup: all values are allowed */
filter_taps filter_taps_of(const vxs_light *light, const double point_ws[3], const double *normal_ws, vxs_filter filter);

/* The lit fraction, 0 to 1: the weighted mean of a ray to the light for each texel. Each ray begins at the texel's centre, at
 * the middle of the voxel's depth, since in a lookup (vxs_lookup) a texel's centre decides for the texel. Rays beside the map
 * are treated alike.
 * shape  baked_light_shape of light;   taps  whose map is not -1 */
double truth_filtered(const truth *t, const vxs_light *light, const light_shape *shape, const filter_taps *taps);

#endif
