/* Welding; see mesh_weld.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/casters/mesh_weld.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#define NONE UINT32_MAX

typedef struct welder {
    uint32_t *slots; /* [mask + 1] open addressing: welded vertex or NONE; at most half full */
    size_t    mask;
} welder;

static vxs_result welder_init(welder *d, size_t vertex_count)
{
    size_t slot_count = 16;
    while (slot_count < 2 * vertex_count) slot_count *= 2;
    d->mask  = slot_count - 1;
    d->slots = malloc(slot_count * sizeof *d->slots);
    if (!d->slots) return VXS_E_MEMORY;
    memset(d->slots, 0xff, slot_count * sizeof *d->slots);
    return VXS_OK;
}

/* The welded vertex at a position, a new one when there is none yet. */
static uint32_t weld_position(mesh_weld *w, welder *d, const double *position_ws)
{
    double p[3];
    for (int axis = 0; axis < 3; axis++) p[axis] = position_ws[axis] + 0.0; /* -0 becomes +0 */

    for (size_t at = XXH3_64bits(p, sizeof p) & d->mask;; at = (at + 1) & d->mask) {
        uint32_t v = d->slots[at];
        if (v == NONE) {
            d->slots[at] = v = (uint32_t)w->vertex_count++;
            memcpy(&w->positions_ws[3 * (size_t)v], p, sizeof p);
            return v;
        }
        if (!memcmp(&w->positions_ws[3 * (size_t)v], p, sizeof p)) return v;
    }
}

static int is_finite_position(const double *p)
{
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

/* Vertices that no triangle uses are left out: they may be anything and must not widen the bounds. */
static vxs_result weld_triangles(mesh_weld *w, welder *d, const scene *s, message *m)
{
    for (size_t t = 0; t < s->triangle_count; t++) {
        uint32_t *corners = &w->indices[3 * w->triangle_count];
        for (size_t i = 0; i < 3; i++) {
            uint32_t v = s->indices[3 * t + i];
            assert(v < s->vertex_count);
            if (w->welded_of[v] == NONE) {
                const double *p = &s->positions_ws[3 * (size_t)v];
                if (!is_finite_position(p))
                    return fail(m, VXS_E_SCENE, "triangle %zu: corner at (%g, %g, %g), expected finite coordinates", t, p[0], p[1],
                                p[2]);
                w->welded_of[v] = weld_position(w, d, p);
            }
            corners[i] = w->welded_of[v];
        }
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
        w->from[w->triangle_count++] = (uint32_t)t;
    }
    return VXS_OK;
}

vxs_result mesh_weld_scene(mesh_weld *w, const scene *s, message *m)
{
    vxs_result r = VXS_OK;
    welder     d = {0};

    *w = (mesh_weld){0};
    /* half-edges are numbered with 32 bits */
    if (s->triangle_count >= NONE / 3 || s->vertex_count >= NONE)
        return fail(m, VXS_E_SCENE, "%zu triangles with %zu vertices, expected fewer than %u and %u", s->triangle_count,
                    s->vertex_count, NONE / 3, NONE);
    w->positions_ws = malloc((3 * s->vertex_count + 1) * sizeof *w->positions_ws);
    w->indices      = malloc((3 * s->triangle_count + 3) * sizeof *w->indices);
    w->from         = malloc((s->triangle_count + 1) * sizeof *w->from);
    w->welded_of    = malloc((s->vertex_count + 1) * sizeof *w->welded_of);
    if (!w->positions_ws || !w->indices || !w->from || !w->welded_of || welder_init(&d, s->vertex_count) != VXS_OK) {
        r = fail(m, VXS_E_MEMORY, "out of memory while welding %zu triangles", s->triangle_count);
    } else {
        memset(w->welded_of, 0xff, s->vertex_count * sizeof *w->welded_of);
        r = weld_triangles(w, &d, s, m);
    }
    free(d.slots);
    if (r != VXS_OK) mesh_weld_free(w);
    return r;
}

void mesh_weld_free(mesh_weld *w)
{
    free(w->positions_ws);
    free(w->indices);
    free(w->from);
    free(w->welded_of);
    *w = (mesh_weld){0};
}
