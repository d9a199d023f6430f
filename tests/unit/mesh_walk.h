/* The mesh about what a light reaches, made of a shadow depth map in C, and where rays cross it, in double, by asking every
 * triangle. Included behind cmocka.h and random_light.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_WALK_H
#define MESH_WALK_H

#include <math.h>
#include <stdlib.h>

#include "formats/vxs_space.h"
#include "runtime/volumes/vxs_volumes.h"

typedef struct mesh_lists {
    float              *places;
    uint32_t           *corners;
    vxs_light_mesh_size size;
} mesh_lists;

static inline mesh_lists mesh_make(const vxs_light_mesh_desc *desc)
{
    mesh_lists out  = {0};
    void      *work = malloc(vxs_light_mesh_room(desc));
    assert_non_null(work);
    assert_int_equal(vxs_light_mesh_plan(desc, work, &out.size), VXS_OK);
    out.places  = malloc((size_t)out.size.vertex_count * 3 * sizeof *out.places);
    out.corners = malloc((size_t)out.size.triangle_count * 3 * sizeof *out.corners);
    assert_true(out.places && out.corners);
    vxs_light_mesh_fill(desc, work, out.places, out.corners);
    for (size_t n = 0; n < (size_t)out.size.vertex_count * 3; n++) assert_true(isfinite(out.places[n]));
    for (size_t n = 0; n < (size_t)out.size.triangle_count * 3; n++) assert_true(out.corners[n] < out.size.vertex_count);
    free(work);
    return out;
}

static inline void mesh_free(mesh_lists *m)
{
    free(m->places);
    free(m->corners);
}

/* Whether a ray crosses a triangle: 1, and it leaves what is lit; -1, and it enters; 0. An edge is of one of the two that meet in
 * it, except for rays that meet it within the precision of a double.
 * from, way  light space
 * at         [out] in lengths of way, >= 0 */
static inline int crossing(const mesh_lists *m, uint32_t triangle, const double from[3], const double way[3], double *at)
{
    double p[3][3], normal[3], ab[3], ac[3], volume[3];
    for (int c = 0; c < 3; c++)
        for (int n = 0; n < 3; n++) p[c][n] = (double)m->places[3 * m->corners[3 * triangle + (uint32_t)c] + (uint32_t)n] - from[n];
    for (int c = 0; c < 3; c++) {
        cross(p[c], p[(c + 1) % 3], normal);
        volume[c] = dot(normal, way);
    }
    int leaves = volume[0] > 0 && volume[1] > 0 && volume[2] > 0, enters = volume[0] < 0 && volume[1] < 0 && volume[2] < 0;
    if (!leaves && !enters) return 0;
    for (int n = 0; n < 3; n++) {
        ab[n] = p[1][n] - p[0][n];
        ac[n] = p[2][n] - p[0][n];
    }
    cross(ab, ac, normal);
    *at = dot(normal, p[0]) / dot(normal, way);
    return *at < 0 ? 0 : leaves ? 1 : -1;
}

/* Whether the eye is in light, by a ray or two through the mesh. */
static inline int mesh_is_lit(const mesh_lists *m, const vxs_light *light, const double eye[3])
{
    rng    r = {11};
    double from[3], way[3], at;
    int    counts[3] = {0};
    vxs_ls_from_ws(light, eye, 1, from);
    for (int k = 0; k < 3; k++) {
        random_direction(&r, way);
        for (uint32_t t = 0; t < m->size.triangle_count; t++) counts[k] += crossing(m, t, from, way, &at);
    }
    assert_int_equal(counts[0], counts[1]);
    assert_int_equal(counts[0], counts[2]);
    return counts[0];
}

#endif
