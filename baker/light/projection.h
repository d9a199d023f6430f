/* Casters projected into one map of a light: vertices in texels, and the triangles that may touch the map.
 *
 * Projection and clipping use double precision, so OpenGL gets planar input: positions in texels, with a depth that is linear
 * across a triangle for all kinds of light.
 *
 *     directional    z is depth, 0 at the near plane, 1 at the far plane
 *     spot, point    z is near / distance, 1 at the near plane, 0 at infinity: linear in the texels of a perspective map. As a
 *                    float it
 *                    is as precise as the logarithm computed from it later; 1 - near / distance is not
 *
 * Source: [CPVS16] 3.3, 5.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PROJECTION_H
#define PROJECTION_H

#include "baker/casters/casters.h"
#include "formats/vxs_file.h"

/* A vertex in a map. */
typedef struct vertex_ls {
    double u, v; /* texels, from -2^levels to 2^(levels + 1) */
    double z;    /* see above */
} vertex_ls;

/* Image coordinates times q, and q: all three are linear across a triangle. q is 1, or z in a perspective map. */
typedef struct hole_uvq {
    float u, v, q;
} hole_uvq;

typedef struct projection {
    const casters *casters;
    int            reversed; /* 1 for spot and point lights: a larger z is nearer */

    size_t     vertex_count;
    vertex_ls *vertices;

    size_t          triangle_count;
    size_t          solid_triangle_count; /* triangles [0, solid_triangle_count) belong to solids, as in casters */
    size_t          holed_first;          /* triangles [holed_first, triangle_count) have holes, as in casters */
    const uint32_t *indices;              /* [3 * triangle_count] into vertices, in the casters' order */
    uint32_t       *own_indices;          /* owner of `indices`; NULL: they are the casters' */

    size_t
        *alpha_mask_first; /* [casters->alpha_mask_count + 1] mask i applies to triangles [alpha_mask_first[i], alpha_mask_first[i +
                             1]) */
    hole_uvq (*uvq)[3];    /* [triangle_count - holed_first] for each corner */
    const uint32_t *edge_mates;       /* [3 * triangle_count] as the casters' edge_mates; NULL: not known */
    uint32_t       *own_edge_mates;   /* owner of `edge_mates`, or NULL */
    const uint8_t  *meets;            /* [solid_triangle_count] as the casters' solid_meets; NULL: all solids meet */
    uint8_t        *own_meets;        /* owner of `meets`, or NULL */
    const uint8_t  *double_sided;     /* [triangle_count] as the casters' double_sided; NULL: none */
    uint8_t        *own_double_sided; /* owner of `double_sided`, or NULL */
} projection;

/* Project the casters into map `map` of a light (numbered as in vxs.h); the casters are borrowed. Triangles that cannot touch the
 * map may be left out. Triangles that extend far beyond it are clipped.
 * Returns VXS_OK or VXS_E_MEMORY; released with projection_free either way. */
vxs_result projection_init(projection *p, const casters *c, const vxs_light *light, int map, uint32_t threads, run_context *m);

/* Remove triangles. The others keep their order; vertices stay.
 * kept  [p->triangle_count] 1: keep the triangle
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result projection_keep(projection *p, const uint8_t *kept);

/* Accepts a zeroed object. */
void projection_free(projection *p);

/* Bounding boxes of triangles in texels. */

/* The rasterizer snaps vertices to a grid of this many steps per texel. */
enum { SUBTEXELS = 256 };

/* Texels whose centres are in a triangle's bounding box. Empty when u0 > u1 or v0 > v1. */
typedef struct texel_box {
    int32_t u0, v0, u1, v1;
} texel_box;

/* Box of a triangle of a projection. */
texel_box texel_box_of(const projection *p, size_t triangle);

/* 1 when the triangle may touch the square of `side` texels at (u0, v0). */
int texel_box_touches(const texel_box *box, int32_t u0, int32_t v0, int32_t side);

#endif
