/* Evaluates alpha masks; see alpha_mask.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/alpha_mask.h"

#include <math.h>

/* The equivalent coordinate within two periods of the wrap mode, so that pixel numbers fit integers. */
static double reduced(double u, texture_wrap wrap)
{
    if (!isfinite(u)) return 0;
    if (wrap == WRAP_CLAMP) return fmin(fmax(u, -1), 2);
    return u - 2 * floor(0.5 * u);
}

static uint32_t wrapped(int64_t pixel, uint32_t width_px, texture_wrap wrap)
{
    int64_t last = (int64_t)width_px - 1, period = wrap == WRAP_MIRROR ? 2 * (int64_t)width_px : width_px;
    if (wrap == WRAP_CLAMP) return (uint32_t)(pixel < 0 ? 0 : pixel > last ? last : pixel);
    pixel = (pixel % period + period) % period;
    return (uint32_t)(pixel > last ? period - 1 - pixel : pixel);
}

static double between(double a, double b, double share)
{
    return a + share * (b - a);
}

static double alpha_of_pixel(const alpha_mask *mask, const alpha_image *image, int64_t i, int64_t j)
{
    size_t row = wrapped(j, image->height_px, mask->wrap_v), column = wrapped(i, image->width_px, mask->wrap_u);
    return image->alpha[row * image->width_px + column];
}

double alpha_mask_alpha(const alpha_mask *mask, const alpha_image *image, double u, double v)
{
    double x = reduced(u, mask->wrap_u) * image->width_px, y = reduced(v, mask->wrap_v) * image->height_px;
    if (mask->nearest) return alpha_of_pixel(mask, image, (int64_t)floor(x), (int64_t)floor(y));

    double  left = floor(x - 0.5), upper = floor(y - 0.5), share = x - 0.5 - left;
    int64_t i = (int64_t)left, j = (int64_t)upper;
    double  above = between(alpha_of_pixel(mask, image, i, j), alpha_of_pixel(mask, image, i + 1, j), share);
    double  below = between(alpha_of_pixel(mask, image, i, j + 1), alpha_of_pixel(mask, image, i + 1, j + 1), share);
    return between(above, below, y - 0.5 - upper);
}

int alpha_mask_opaque(const alpha_mask *mask, const alpha_image *image, double u, double v)
{
    return (float)(alpha_mask_alpha(mask, image, u, v) / 255) >= mask->threshold;
}
