/* Rivals of maps of transmittance curves: other curves, made of the same lists of segments (vxs_transmittance.h) and looked up the
 * same way, in the same context.
 *
 *     opacity shadow maps    optical depth up to even slices, a line between two                      [Kim 2001]
 *     Fourier opacity maps   terms of a Fourier series of extinction over depth                       [Jansen 2010]
 *     moments                four power moments of extinction over depth, the middle of their bounds  [Peters 2017]
 *     deep shadow maps       lines that leave the curve nowhere by more than a tolerance              [Lokovic 2000]
 *     uncompressed           all segments of a texel, one after the other
 *
 * The first three know depth in a range alone, which the caller gives; each takes a whole segment, by its integral, rather than a
 * sample of it. Deep shadow maps are arrays here and searched in halves, not linked lists as in [AVSM10].
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RIVAL_CURVES_H
#define RIVAL_CURVES_H

#include "runtime/volumes/vxs_transmittance.h"

typedef enum rival_curve { RIVAL_OPACITY, RIVAL_FOURIER, RIVAL_MOMENTS, RIVAL_DEEP, RIVAL_UNCOMPRESSED } rival_curve;

typedef struct rival_curves rival_curves;

/* map    with lists; borrowed, and so is the room of its lists
 * knob   slices, or terms, 1 to 64; deep shadow maps: the tolerance in 1 / 10000; else 0
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_GL */
vxs_result rival_curves_create(rival_curves **out, vxs_volumes *v, vxs_transmittance_map *map, rival_curve which, uint32_t knob);
void       rival_curves_destroy(rival_curves *r);

/* Of the lists as vxs_transmittance_map_build or rival_curves_capture left them.
 * nearest, farthest  depths between which all segments lie */
void rival_curves_build(rival_curves *r, double nearest, double farthest);

/* Capture alone, as that begins. */
void rival_curves_capture(vxs_transmittance_map *map, const vxs_capsules *capsules);

/* As vxs_volumes_transmittance. */
void rival_curves_look_up(rival_curves *r, unsigned texture);

/* What is kept of all texels after the last build, for lookups: without lists, but for uncompressed ones. */
uint64_t rival_curves_bytes(const rival_curves *r);

#endif
