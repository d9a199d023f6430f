/* The airlight of an eye ray as it should be, in double: lit parts by an oracle (lit_parts.h), and between their ends adaptive
 * quadrature of the integrand as it is reported (airlight.h). It takes the structs of runtime/volumes, whose numbers are all that
 * it has of it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef REFERENCE_H
#define REFERENCE_H

#include "runtime/volumes/vxs_air_path.h"
#include "tests/volumes/lit_parts.h"

typedef struct reference_light {
    vxs_air_light light;
    double        colour[3];
    lit_oracle    oracle;
    const void   *subject; /* of the oracle */
} reference_light;

/* In fog with a top light is dimmed by what of its way lies below that.
 * top       height of the fog's level top; VXS_AIR_EVERYWHERE: it has none
 * airlight  [out] of all that is lit, between the ray's begin and its end, to 1e-6
 * Threads: one at a time. */
void reference_airlight(const vxs_medium *medium, double top, const reference_light *light, const eye_ray *ray, double airlight[3]);

#endif
