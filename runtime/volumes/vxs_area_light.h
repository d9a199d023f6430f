/* Light of a surface in fog: as many virtual point lights as are set on it, each with a shadow volume of its own, all made at once. It stands on
 * vxs_volumes.h.
 *
 *     vxs_area_rectangle screen = {...};                                // once, or when the picture on it changes
 *     vxs_area_sample(&screen, VXS_AREA_IMPORTANCE, 0, lamps, 64);
 *
 * Places are metres from the origin that vxs_gl_origin was told last.
 * Source: [IVSV13].
 * SPDX-License-Identifier: MIT */
#ifndef VXS_AREA_LIGHT_H
#define VXS_AREA_LIGHT_H

#include "vxs_volumes.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { VXS_AREA_LAMPS = 256 }; /* no more at once */

/* virtual point lights ------------------------------------------------------------------------------------------------------------ */

/* A small piece of a surface that shines to one side: its intensity is `colour` times the cosine to its normal. */
typedef struct vxs_area_lamp {
    float place[3];
    float normal[3];     /* of length 1; all 0: it shines to all sides alike */
    float colour[3];     /* intensity along the normal, in candela, or in the units of the picture; >= 0 */
    float radius_metres; /* > 0: no eye ray passes nearer */
} vxs_area_lamp;

/* A picture that shines, such as a screen or a window. */
typedef struct vxs_area_rectangle {
    float        corner[3];        /* from which the sides run; the picture's first texel is there */
    float        across[3], up[3]; /* both sides, metres; it shines to where their cross product points */
    float        radiance[3];      /* in each direction of that side alike, as of paper; >= 0 */
    const float *texture;          /* [high_px][wide_px][3] what the radiance is times, >= 0; NULL: 1 everywhere */
    uint32_t     wide_px, high_px; /* of the texture */
} vxs_area_rectangle;

/* How its places are chosen. */
typedef enum vxs_area_places {
    VXS_AREA_HALTON, /* points of Halton's sequence, of bases 2 and 3: any part of it is even, so that lamps may be added one by one */
    VXS_AREA_IMPORTANCE, /* the same points, moved to where the texture is bright: all lamps have one luminance, and none is where it is black */
    VXS_AREA_REGULAR,  /* the middles of equal cells, as square as `count` lets them be */
    VXS_AREA_JITTERED, /* a place at random in each of these cells */
} vxs_area_places;

/* Lamps of a rectangle, of which each has its part of the area: their sum is the rectangle's light, exactly in luminance where they are chosen by
 * importance, else as even as the texture is.
 * seed   of what is at random; of Halton's points a shift of all, round the edges. 0: none
 * lamps  [out] [count]
 * count  1 to VXS_AREA_LAMPS
 * Returns VXS_OK; VXS_E_ARGUMENT for numbers that are none, a rectangle without area, or a texture without texels.
 * Cost: of importance, two readings of the texture, and a row of it for each lamp. Threads: none shared; no memory is taken. */
vxs_result vxs_area_sample(const vxs_area_rectangle *rectangle, vxs_area_places places, uint32_t seed, vxs_area_lamp *lamps,
                           uint32_t count);

/* points of what casts shadows ---------------------------------------------------------------------------------------------------- */

/* A point of a surface, which stands for so much of it; as a storage buffer has it. */
typedef struct vxs_area_point {
    float place[3];
    float square_metres;
} vxs_area_point;

/* Points of triangles, as many on each as its part of the area is, in the order of the triangles.
 * positions  [3 * vertices] metres;   corners  [3 * triangle_count] vertices
 * points     [out] [count] all of one area
 * Returns the area of all triangles, in square metres; 0 where there is none, or it is no number, and then no points are written.
 * Threads: none shared; no memory is taken. */
double vxs_area_scatter(const float *positions, const uint32_t *corners, uint32_t triangle_count, vxs_area_point *points,
                        uint32_t count);

#ifdef __cplusplus
}
#endif
#endif
