/* How often a baked light is wrong, where, by how far, and how fast it answers: lookups against the ray-traced truth.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COMPARE_H
#define COMPARE_H

#include "baker/lab/compare/compare_result.h"
#include "baker/lab/truth/truth.h"
#include "formats/vxs_file.h"

/* Compare one light with the truth.
 *
 * For a surface point the truth is traced from the surface itself (truth_lift), so that errors of the lookup's bias count as
 * well. A wrong answer is explained if rays near the centre of the texel that was looked up, in its voxel, give that answer.
 * "Near" covers rounding: a rasterizer may move edges by 1/128 texel and depths by a twentieth of a voxel, and rays are off by
 * three times truth_precision. The latter is more texels the nearer a caster is to a spot or point light; two texels at most.
 * compare_boundary.c explains how the distance is measured. In don't-care voxels no answer is wrong.
 * t      of c;   c  with the solids that the light was baked with
 * Same scene, asset, and options: same counts, at any thread count.   Returns VXS_OK or VXS_E_MEMORY. */
vxs_result compare_light(compare_result *out, const truth *t, const casters *c, const vxs_baked_light *light,
                         const compare_dont_care *dont_care, const compare_options *o, message *m);

/* Leaks and false shadows. */
uint64_t compare_wrong(const compare_counts *n);

#endif
