/* Filters over rays; see truth_filter.h.
 * Source: [CPVS16] 5.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/truth/truth_filter.h"

#include "runtime/vxs.h"

double truth_filtered(const truth *t, const vxs_light *light, const light_shape *shape, int map, const int32_t voxel[3],
                      int filter_px)
{
    int half = filter_px / 2, lit = 0;
    for (int j = -half; j <= half; j++)
        for (int i = -half; i <= half; i++) {
            double from_ws[3];
            vxs_point(light, map, (double[3]){voxel[0] + i + 0.5, voxel[1] + j + 0.5, voxel[2] + 0.5}, from_ws);
            lit += truth_lit(t, from_ws, shape);
        }
    return (double)lit / (double)(filter_px * filter_px);
}
