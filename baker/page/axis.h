/* Axes of plots, with tics that people read: units, and no exponents.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef AXIS_H
#define AXIS_H

#include <stdio.h>

typedef enum axis_unit {
    UNIT_SECONDS,
    UNIT_NANOSECONDS,
    UNIT_BYTES,
    UNIT_SHARE, /* of 1, shown in per cent */
    UNIT_COUNT,
    UNIT_TEXELS, /* a power of two, or nearly */
    UNIT_VOXELS, /* likewise; MASKS_AT stands for masks */
    UNIT_ZERO    /* nothing has no unit */
} axis_unit;

/* Where masks stand on an axis of voxels: before the slices of 8. */
static const double MASKS_AT = 4;

/* An axis that is grown by what lies on it. */
typedef struct axis {
    axis_unit   unit;
    int         is_linear; /* from 0; otherwise logarithmic: only what is above 0 has a place */
    const char *label;
    double      min, max; /* min > max: nothing yet */
} axis;

axis axis_of(axis_unit unit, int is_linear, const char *label);
void axis_add(axis *a, double value);

/* Range, tics with units, and label of axis 'x' or 'y'. room: more of its length for labels behind the last point, 0 to 1. */
void axis_print(const axis *a, FILE *to, char letter, double room);

#endif
