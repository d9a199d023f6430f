/* The true result of a filtered lookup in a baked light: the same filter over exact rays.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TRUTH_FILTER_H
#define TRUTH_FILTER_H

#include "baker/lab/truth/truth.h"
#include "formats/vxs_file.h"
#include "formats/vxs_format.h"

enum { FILTER_TAPS_MAX = VXS_FILTER_MAX + 1 }; /* a smooth box covers this many texels of a row, the first and the last in part */

/* The texels that a filtered lookup reads, and their weights: the column's times the row's. */
typedef struct filter_taps {
    int      map;                      /* of the light; -1: the point is outside the light's volume, and the other members are
                                          not set */
    int32_t  first[2], depth;          /* column and row of the first texel, and the depth of all, voxels */
    int      count[2];                 /* columns, and rows */
    uint32_t part[2][FILTER_TAPS_MAX]; /* [count] weight of each column and row, in 1/256: 1 to 256 */
} filter_taps;

/* normal_ws, filter_px  as for vxs_lookup: all values are allowed */
filter_taps filter_taps_of(const vxs_light *light, const double point_ws[3], const double *normal_ws, int filter_px);

/* The lit fraction, 0 to 1: the weighted mean of a ray to the light for each texel. Each ray begins at the texel's centre, at
 * the middle of the voxel's depth, since in a lookup (vxs_lookup) a texel's centre decides for the texel. Rays beside the map
 * are treated alike.
 * shape  baked_light_shape of light;   taps  whose map is not -1 */
double truth_filtered(const truth *t, const vxs_light *light, const light_shape *shape, const filter_taps *taps);

#endif
