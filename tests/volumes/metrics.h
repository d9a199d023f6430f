/* How far a picture of airlight is from its reference, linear, channels alike; and how much that flickers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef METRICS_H
#define METRICS_H

#include <stddef.h>
#include <stdint.h>

/* Pixels are counted apart: those within EPIPOLE_RADII radii of a punctual light that is seen, beside the ray, where airlight is
 * largest and sharpest. */
typedef enum pixel_class { PIXELS_ELSEWHERE, PIXELS_EPIPOLE, PIXEL_CLASSES } pixel_class;

#define EPIPOLE_RADII 4.0

pixel_class pixel_class_of(const double eye[3], const double direction[3], const double punctual[3], double radius_metres);

/* Of a picture's pixels of one class. All but the first are relative to the reference's largest value in the whole picture. */
typedef struct picture_error {
    double relative_rms;  /* ||found - wanted|| / ||wanted|| */
    double signed_mean;   /* of found - wanted */
    double percentile_99; /* of |found - wanted| */
    double most;
    size_t count; /* values */
} picture_error;

/* found          [pixels][3]; no NaN
 * wanted         [pixels][3]; NaN: not counted
 * classes        [pixels] of pixel_class; NULL: all are `which`
 * which          the class; PIXEL_CLASSES: all pixels
 * A reference that is dark: relative_rms is 0 where the picture is dark, too, else infinite; the others are as they are. */
picture_error picture_error_of(const double *found, const double *wanted, size_t pixels, const uint8_t *classes, pixel_class which);

/* RMS of the change of found - wanted from each frame to the next, relative to the RMS of wanted.
 * found, wanted  [frames][pixels][3]; frames of a pan by less than a texel of the shadows or a pixel.   0 for fewer than two */
double picture_flicker_of(const double *found, const double *wanted, size_t frames, size_t pixels);

#endif
