/* Airlight of a rectangle that shines, along an eye ray among casters, in double: a mean over places of the rectangle and of the
 * ray, by Halton's sequence in three dimensions with a shift of its own for each ray, each with a ray between them. Places of the
 * eye ray lie at even angles about that of the rectangle [Kulla 2012], so that the square of the distance is in no term. It shares
 * nothing with what it judges.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef AREA_REFERENCE_H
#define AREA_REFERENCE_H

#include <stdint.h>

#include "baker/scene/smoke.h"
#include "runtime/volumes/vxs_area_light.h"

/* A rectangle whose places count from an origin, and whether nothing is between two places. */
typedef struct area_source {
    const vxs_area_rectangle *rectangle;
    double                    origin_ws[3];
    int (*is_free)(const void *user, const double from_ws[3], const double to_ws[3]);
    const void *user;
} area_source;

/* f        has no level top
 * samples  even; the more, the nearer
 * ray      any number: rays with others have shifts of their own
 * to       [3] [in, out] airlight is added
 * Returns how far the means of both halves of the samples are off that of all, RMS over channels: about what all are off at
 * most. */
double area_reference_add(const area_source *source, const fog_medium *f, const double eye_ws[3], const double direction[3],
                          double metres, uint32_t samples, uint64_t ray, double to[3]);

#endif
