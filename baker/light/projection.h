/* The casters as one map of a light sees them: vertices in its texels, triangles that may touch it.
 *
 * Projecting, and clipping what needs it, is done here in double, so that what OpenGL gets is flat: positions in texels, with a depth
 * that is linear across a triangle whatever the light.
 *
 *     directional    z is depth, 0 at the near plane, 1 at the far plane
 *     spot, point    z is near / distance, 1 at the near plane, 0 infinitely far: linear in the texels of a perspective map, and as
 *                    fine, as a float, as the logarithm that becomes of it, which 1 - near / distance is not
 *
 * Source: [CPVS16] 3.3, 5.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PROJECTION_H
#define PROJECTION_H

#include "baker/casters/casters.h"
#include "formats/vxs_file.h"

/* A vertex as the map sees it. */
typedef struct vertex_ls {
    double u, v; /* texels, from -2^levels to 2^(levels + 1) */
    double z;    /* see above */
} vertex_ls;

/* A place in an image, times q, and q: all three are linear across a triangle. q is 1, or z of a perspective map. */
typedef struct hole_uvq {
    float u, v, q;
} hole_uvq;

typedef struct projection {
    const casters *casters;
    int            reversed; /* spot and point lights: what is nearer has a larger z */

    size_t     vertex_count;
    vertex_ls *vertices;

    size_t          triangle_count;
    size_t          solid_triangle_count; /* triangles [0, solid_triangle_count) belong to solids, as in casters */
    size_t          holed_first;          /* triangles [holed_first, triangle_count) have holes, as in casters */
    const uint32_t *indices;              /* [3 * triangle_count] into vertices, in the casters' order */
    uint32_t       *own_indices;          /* the same, or NULL: they are the casters' */

    size_t *
        alpha_mask_first; /* [casters->alpha_mask_count + 1] triangles [alpha_mask_first[i], alpha_mask_first[i + 1]) have mask i */
    hole_uvq (*uvq)[3];   /* [triangle_count - holed_first] of each corner */
    const uint8_t *meets; /* [solid_triangle_count] as the casters' solid_meets, or NULL: all do */
    uint8_t       *own_meets;        /* the same, or NULL */
    const uint8_t *double_sided;     /* [triangle_count] as the casters', or NULL: none is */
    uint8_t       *own_double_sided; /* the same, or NULL */
} projection;

/* Project the casters into map `map` of a light (vxs.h numbers them); casters are borrowed.
 * Triangles that cannot touch the map may be left out; what reaches far beyond it is clipped.
 * Returns VXS_OK or VXS_E_MEMORY; released with projection_free either way. */
vxs_result projection_init(projection *p, const casters *c, const vxs_light *light, int map, uint32_t threads, message *m);

/* Leave out all triangles but some, in their order; vertices stay.
 * kept  [p->triangle_count] 1: the triangle stays
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result projection_keep(projection *p, const uint8_t *kept);

/* Accepts a zeroed object. */
void projection_free(projection *p);

#endif
