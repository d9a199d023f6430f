/* A rival: epipolar slices with 1D min-max mipmaps. Planes through the eye and the light cut the shadow depth map in lines; along a
 * line, shadow begins at one distance for each angle at the light, and a tree of the least and the greatest of these decides for long
 * parts of an eye ray at once whether they are lit. Airlight is found at some angles in each slice, and pixels read it between them; those
 * whose neighbours there lie at other distances walk themselves.
 *
 *     slice   angle theta about the axis from the eye to the light (of a sun: toward it)
 *     sample  angle alpha from that axis, even in the range that the view has
 *     bin     angle phi at the light, from the eye on; of a sun, metres from the axis
 *
 * Source: Chen, Baran, Durand, Jarosz, Real-Time Volumetric Shadows using 1D Min-Max Mipmaps, I3D 2011, in the rectified
 * coordinates of Baran et al. 2010; samples between which pixels are interpolated: Engelhardt and Dachsbacher 2010. Airlight of lit
 * parts is the library's.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RIVAL_SLICES_H
#define RIVAL_SLICES_H

#include "runtime/volumes/vxs_volumes.h"

typedef struct rival_slices rival_slices;

/* slices   in the view's range of theta, 1 to 2^14
 * bins     a power of two, 2 to 2^13
 * samples  in each slice; 0: each pixel walks the nearest slice by itself, and nothing is interpolated
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_GL */
vxs_result rival_slices_create(rival_slices **out, vxs_volumes *v, uint32_t slices, uint32_t bins, uint32_t samples);
void       rival_slices_destroy(rival_slices *s);

/* 1: walk bin by bin, as if there were no tree. What it is worth is a question to measure. */
void rival_slices_set_flat(rival_slices *s, int flat);

/* Prefiltered moments: instead of walking, a ray queries what part of its bins is lit, of four moments of the angles at which
 * shadow begins, summed along each slice; their bounds for four moments, and the middle between these. So often along a ray; 0: it
 * walks.
 * Source: Klehm, Seidel, Eisemann, Prefiltered Single Scattering, I3D 2014; Peters et al., Improved Moment Shadow Maps for
 * Translucent Occluders, Soft Shadows and Single Scattering, JCGT 2017.
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_GL */
vxs_result rival_slices_set_moments(rival_slices *s, uint32_t parts);

/* Add a light's airlight to the frame, as vxs_volumes_march does. A sun's map that is bounded is taken for one that is not. */
vxs_result rival_slices_add(rival_slices *s, const vxs_volumes_light *light, const vxs_shadow_depth_map *map);

#endif
