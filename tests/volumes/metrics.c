/* Errors of pictures; see metrics.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/metrics.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/spread.h"
#include "baker/base/vec3.h"

pixel_class pixel_class_of(const double eye[3], const double direction[3], const double punctual[3], double radius_metres)
{
    double to_light[3], across[3];
    vec3_sub(punctual, eye, to_light);
    vec3_cross(to_light, direction, across);
    int is_near = vec3_dot(across, across) < EPIPOLE_RADII * EPIPOLE_RADII * radius_metres * radius_metres;
    return is_near && vec3_dot(to_light, direction) > 0 ? PIXELS_EPIPOLE : PIXELS_ELSEWHERE;
}

static double ratio_of(double wrong, double size)
{
    return size > 0 ? sqrt(wrong / size) : wrong > 0 ? INFINITY : 0;
}

picture_error picture_error_of(const double *found, const double *wanted, size_t pixels, const uint8_t *classes, pixel_class which)
{
    picture_error e     = {0};
    double       *sizes = malloc((3 * pixels + 1) * sizeof *sizes), wrong = 0, square = 0, largest = 0;
    if (!sizes) abort();
    for (size_t n = 0; n < 3 * pixels; n++) {
        double error = found[n] - wanted[n];
        if (isnan(wanted[n])) continue;
        largest = fmax(largest, fabs(wanted[n]));
        if (which != PIXEL_CLASSES && classes && classes[n / 3] != which) continue;
        wrong += error * error;
        square += wanted[n] * wanted[n];
        e.signed_mean += error;
        sizes[e.count++] = fabs(error);
    }
    if (e.count) {
        double unit = largest > 0 ? largest : 1;
        qsort(sizes, e.count, sizeof *sizes, doubles_ascending);
        e.relative_rms = ratio_of(wrong, square);
        e.signed_mean /= unit * (double)e.count;
        e.percentile_99 = sizes[(size_t)(0.99 * (double)(e.count - 1) + 0.5)] / unit;
        e.most          = sizes[e.count - 1] / unit;
    }
    free(sizes);
    return e;
}

double picture_flicker_of(const double *found, const double *wanted, size_t frames, size_t pixels)
{
    double change = 0, square = 0;
    size_t values = 3 * pixels;
    if (frames < 2) return 0;
    for (size_t n = 0; n < frames * values; n++) {
        square += wanted[n] * wanted[n];
        if (n < values) continue;
        double more = (found[n] - wanted[n]) - (found[n - values] - wanted[n - values]);
        change += more * more;
    }
    return ratio_of(change / (double)(frames - 1), square / (double)frames);
}
