/* What a filtered lookup in a baked light should answer: the same filter over exact rays.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TRUTH_FILTER_H
#define TRUTH_FILTER_H

#include "baker/truth/truth.h"
#include "formats/vxs_file.h"

/* The lit fraction, 0 to 1, of filter_px x filter_px rays to a light: each begins where a texel's centre is, about that of the voxel, in the
 * middle of the voxel's depth, as in a lookup (vxs_lookup) a texel's centre decides for the texel. Beside the map rays are like any other.
 * shape  baked_light_shape of light
 * map    and voxel: what vxs_voxel returned and wrote, not -1 */
double truth_filtered(const truth *t, const vxs_light *light, const light_shape *shape, int map, const int32_t voxel[3],
                      int filter_px);

#endif
