/* Quads of capsules; see smoke_quads.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/smoke_quads.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/memory.h"
#include "baker/base/vec3.h"

typedef struct quad_order {
    double   metres; /* from the eye to its middle */
    uint32_t capsule;
} quad_order;

/* The place for light lookups, as a share of the distance from a capsule's middle to a corner: far enough out that the shadows
 * of other capsules may differ. */
static const double ASKED_AT = 0.6;

vxs_result smoke_quads_reserve(smoke_quads *q, const scene_smoke *smoke, message *m)
{
    uint64_t   each = sizeof *q->capsules + SMOKE_CORNERS * (sizeof *q->corners + sizeof *q->places) + sizeof *q->order;
    vxs_result r    = memory_check(smoke->count * each, m, "drawing %u capsules of smoke needs", smoke->count);
    *q              = (smoke_quads){.count = smoke->count};
    if (r != VXS_OK) return r;
    q->capsules = malloc(smoke->count * sizeof *q->capsules);
    q->corners  = malloc(SMOKE_CORNERS * (size_t)smoke->count * sizeof *q->corners);
    q->places   = malloc(SMOKE_CORNERS * (size_t)smoke->count * sizeof *q->places);
    q->order    = malloc(smoke->count * sizeof *q->order);
    if (q->capsules && q->corners && q->places && q->order) return VXS_OK;
    return fail(m, VXS_E_MEMORY, "out of memory for %u capsules of smoke", smoke->count);
}

void smoke_quads_free(smoke_quads *q)
{
    free(q->capsules);
    free(q->corners);
    free(q->places);
    free(q->order);
    *q = (smoke_quads){0};
}

static void middle_of(const scene_smoke *smoke, const vxs_capsule *c, const double eye_ws[3], double middle[3])
{
    for (int n = 0; n < 3; n++) middle[n] = 0.5 * ((double)c->begin[n] + (double)c->end[n]) + smoke->origin_ws[n] - eye_ws[n];
}

/* Order: the farthest first; equal ones in the scene's order. */
static int is_farther(const void *a, const void *b)
{
    const quad_order *x = a, *y = b;
    if (x->metres != y->metres) return x->metres > y->metres ? -1 : 1;
    return x->capsule < y->capsule ? -1 : x->capsule > y->capsule;
}

static void sort(smoke_quads *q, const scene_smoke *smoke, const double eye_ws[3])
{
    for (uint32_t n = 0; n < q->count; n++) {
        double middle[3];
        middle_of(smoke, &smoke->list[n], eye_ws, middle);
        q->order[n] = (quad_order){sqrt(vec3_dot(middle, middle)), n};
    }
    qsort(q->order, q->count, sizeof *q->order, is_farther);
}

/* The plane of a quad: through the capsule's middle, perpendicular to the direction from the eye; u along the capsule's axis as
 * seen. */
typedef struct quad_plane {
    double middle[3], u[3], v[3], half_u, half_v;
} quad_plane;

/* Find the plane of a capsule's quad; parts nearer than it appear larger.   Returns 0 when the eye is in the capsule, or nearly */
static int find_plane(const vxs_capsule *c, quad_plane *p)
{
    double axis[3], way[3], radius = (double)c->radius_metres;
    for (int n = 0; n < 3; n++) {
        axis[n]      = 0.5 * ((double)c->end[n] - (double)c->begin[n]);
        p->middle[n] = 0.5 * ((double)c->end[n] + (double)c->begin[n]);
    }
    double metres = sqrt(vec3_dot(p->middle, p->middle));
    if (!vec3_unit(p->middle, way)) return 0;
    double ahead = vec3_dot(axis, way), reach = fabs(ahead) + radius;
    if (!(metres > 1.1 * reach)) return 0;
    vec3_mad(axis, -ahead, way, p->u);
    double aside = sqrt(vec3_dot(p->u, p->u)), larger = metres / (metres - reach);
    if (!(aside > 1e-6 * radius) || !vec3_unit(p->u, p->u)) vec3_across(way, p->u, p->v);
    vec3_cross(way, p->u, p->v);
    p->half_u = larger * (aside + radius);
    p->half_v = larger * radius;
    return 1;
}

/* A quad that covers the whole picture, a metre in front of the eye. */
static quad_plane whole_picture(const smoke_eye *eye)
{
    quad_plane p = {.half_u = 1, .half_v = 1};
    memcpy(p.middle, eye->seen.forward, sizeof p.middle);
    memcpy(p.u, eye->seen.right, sizeof p.u);
    memcpy(p.v, eye->seen.up, sizeof p.v);
    return p;
}

static void set_corners(smoke_quads *q, uint32_t n, const vxs_capsule *c, const smoke_eye *eye)
{
    quad_plane p;
    int        is_near = !find_plane(c, &p);
    quad_plane drawn   = is_near ? whole_picture(eye) : p;
    double     pixel   = eye->pixel_metres * sqrt(vec3_dot(p.middle, p.middle));
    q->covered_px += is_near ? eye->all_px : fmin(eye->all_px, 4 * p.half_u * p.half_v / (pixel * pixel));
    for (int corner = 0; corner < SMOKE_CORNERS; corner++) {
        float *at    = q->corners[SMOKE_CORNERS * (size_t)n + (size_t)corner],
              *asked = q->places[SMOKE_CORNERS * (size_t)n + (size_t)corner];
        double u = (corner & 1 ? 1 : -1) * drawn.half_u, v = (corner & 2 ? 1 : -1) * drawn.half_v;
        for (int k = 0; k < 3; k++) {
            double aside = u * drawn.u[k] + v * drawn.v[k];
            at[k]        = (float)(drawn.middle[k] + aside);
            asked[k]     = (float)(p.middle[k] + (is_near ? 0 : ASKED_AT * aside));
        }
        at[3] = asked[3] = 0;
    }
}

void smoke_quads_make(smoke_quads *q, const scene_smoke *smoke, const smoke_eye *eye)
{
    sort(q, smoke, eye->at_ws);
    q->covered_px = 0;
    for (uint32_t n = 0; n < q->count; n++) {
        uint32_t       from = q->order[n].capsule;
        drawn_capsule *to   = &q->capsules[n];
        to->capsule         = smoke_widened(smoke->list[from], 0.5 * eye->pixel_metres * q->order[n].metres);
        smoke_from_eye(smoke, &to->capsule, eye->at_ws);
        for (int k = 0; k < 4; k++) to->albedo[k] = k < 3 ? smoke->albedos[from][k] : 0;
        set_corners(q, n, &to->capsule, eye);
    }
}
