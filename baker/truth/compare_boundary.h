/* How far wrong answers are from a place where they would be right.
 *
 * From where the truth was asked, probes go 26 ways in the coordinates of the map, where a texel counts as much as a voxel's depth:
 * across the light, along it, and between, as from the middle of a cube to its corners and to the middles of its edges and faces.
 *
 *        \ | /        Each way the truth is asked at 1/2, 1, 1 1/2, 2, 3, 4, 6 and 8 texels. Where it first is what the asset
 *       -- p --       says, the last step is halved six times. The least distance of all ways is the answer. To a flat boundary
 *        / | \        that is at most 13 % too far; what is thinner than a step may be missed. Inside of solids it is dark.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COMPARE_BOUNDARY_H
#define COMPARE_BOUNDARY_H

#include "baker/truth/compare_points.h"

#define COMPARE_BOUNDARY_REACH 8 /* texels */

typedef struct wrong_answer {
    uint64_t index; /* of the point */
    int      asset_lit;
    float    texels; /* to the boundary; INFINITY: beyond the reach */
} wrong_answer;

/* Measure the distance of each wrong answer.
 * answers  [count] texels is written; sorted by it in the end
 * Cost: 208 rays and some for an answer that is beyond, a few dozen for most others. */
compare_distance compare_boundary(const comparison *c, compare_kind kind, wrong_answer *answers, size_t count);

#endif
