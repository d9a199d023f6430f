/* Filters over rays; see truth.h.
 * Source: [CPVS16] 5.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/truth/truth.h"

#include "formats/vxs_space.h"
#include "runtime/vxs.h"

/* Taps along one axis: K texels around one; or those that a row of K, centred `within` / 256 from the texel's near side, covers. */
static void set_axis(filter_taps *taps, int axis, int32_t texel, uint32_t within, vxs_filter filter)
{
    int width = vxs_filter_width(filter), begin = (int)within - 128 * width; /* in 1/256, relative to the texel */
    if (!filter.is_smooth) begin = -256 * (width / 2);
    int first         = begin < 0 ? (begin - 255) / 256 : begin / 256; /* rounded down */
    taps->first[axis] = texel + first;
    taps->count[axis] = 0;
    for (int x = 256 * first; x < begin + 256 * width; x += 256) {
        int from = x > begin ? x : begin, to = x + 256 < begin + 256 * width ? x + 256 : begin + 256 * width;
        taps->part[axis][taps->count[axis]++] = (uint32_t)(to - from);
    }
}

filter_taps filter_taps_of(const vxs_light *light, const double point_ws[3], const double *normal_ws, vxs_filter filter)
{
    static const double in_the_air[3] = {0, 0, 0};
    vxs_place           place         = vxs_place_from_ws(light, point_ws, normal_ws ? normal_ws : in_the_air, filter);
    filter_taps         taps          = {.map = place.map, .depth = place.voxel[2]};
    if (place.map < 0) return taps;
    set_axis(&taps, 0, place.voxel[0], place.across, filter);
    set_axis(&taps, 1, place.voxel[1], place.down, filter);
    return taps;
}

double truth_filtered(const truth *t, const vxs_light *light, const light_shape *shape, const filter_taps *taps)
{
    double lit = 0, all = 0;
    for (int j = 0; j < taps->count[1]; j++)
        for (int i = 0; i < taps->count[0]; i++) {
            double from_ws[3], part = (double)taps->part[0][i] * taps->part[1][j];
            vxs_point(light, taps->map, (double[3]){taps->first[0] + i + 0.5, taps->first[1] + j + 0.5, taps->depth + 0.5},
                      from_ws);
            all += part;
            if (truth_lit(t, from_ws, shape)) lit += part;
        }
    return lit / all;
}
