/* Lit parts by a mesh; see mesh_parts.h.
 *
 * Seen along the ray, which is a point then, a triangle is met if its border winds about the point: that is, if a half line from
 * there crosses its edges more often one way than the other. Where an edge is crossed is computed from its two ends in one order,
 * whichever triangle uses it. So what triangles that share it get from it cancels to the bit, and all faces of a closed mesh
 * together, of the whole line, are 0, wherever the ray goes: through edges and corners, too.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/mesh_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/vec3.h"

enum { GROUP = 32 }; /* triangles with a box about them */

typedef double corner[3];
typedef corner box_of[2];

struct lit_mesh {
    size_t count, group_count;
    corner (*triangles)[3];
    box_of *boxes; /* [group_count] */
};

lit_mesh *lit_mesh_create(const double (*triangles)[3][3], size_t count)
{
    lit_mesh *m = calloc(1, sizeof *m);
    if (!m) return NULL;
    m->count       = count;
    m->group_count = (count + GROUP - 1) / GROUP;
    m->triangles   = malloc((count + 1) * sizeof *m->triangles);
    m->boxes       = malloc((m->group_count + 1) * sizeof *m->boxes);
    if (!m->triangles || !m->boxes) {
        lit_mesh_destroy(m);
        return NULL;
    }
    memcpy(m->triangles, triangles, count * sizeof *m->triangles);
    for (size_t g = 0; g < m->group_count; g++)
        for (int n = 0; n < 3; n++) {
            double low = INFINITY, high = -INFINITY;
            for (size_t t = g * GROUP; t < (g + 1) * GROUP && t < count; t++)
                for (int c = 0; c < 3; c++) {
                    low  = fmin(low, triangles[t][c][n]);
                    high = fmax(high, triangles[t][c][n]);
                }
            m->boxes[g][0][n] = low;
            m->boxes[g][1][n] = high;
        }
    return m;
}

void lit_mesh_destroy(lit_mesh *m)
{
    if (!m) return;
    free(m->triangles);
    free(m->boxes);
    free(m);
}

/* Whether the line may meet the box, at its begin or behind it; a little too often. */
static int meets_box(const eye_ray *ray, const corner *box)
{
    double near = ray->begin, far = INFINITY;
    for (int n = 0; n < 3; n++) {
        double margin = 1e-9 * (fabs(box[0][n]) + fabs(box[1][n]) + fabs(ray->eye[n]));
        double low = box[0][n] - margin - ray->eye[n], high = box[1][n] + margin - ray->eye[n], way = ray->direction[n];
        if (way == 0) {
            if (low > 0 || high < 0) return 0;
            continue;
        }
        near = fmax(near, fmin(low / way, high / way));
        far  = fmin(far, fmax(low / way, high / way));
    }
    return near <= far;
}

/* Two unit vectors across a ray. */
typedef struct across {
    double right[3], up[3];
} across;

static across across_of(const eye_ray *ray)
{
    across a;
    vec3_across(ray->direction, a.right, a.up);
    return a;
}

/* How often the edge from p to q crosses the half line to the right, upward: 1, 0, or -1. */
static int edge_crosses(const double p[2], const double q[2])
{
    int rises = p[1] < 0 && q[1] >= 0, falls = q[1] < 0 && p[1] >= 0;
    if (!rises && !falls) return 0;
    const double *low = rises ? p : q, *high = rises ? q : p;
    return low[0] * high[1] - high[0] * low[1] > 0 ? rises - falls : 0;
}

typedef struct crossing {
    double x;
    int    sign; /* 1: into the dark */
} crossing;

/* Returns 0 where the line misses it, or meets it before `begin`. */
static int meets_triangle(const eye_ray *ray, const across *turned, const corner *t, crossing *c)
{
    double seen[3][2], to[3], a[3], b[3], normal[3], near = INFINITY, far = -INFINITY;
    for (int n = 0; n < 3; n++) {
        vec3_sub(t[n], ray->eye, to);
        seen[n][0] = vec3_dot(to, turned->right);
        seen[n][1] = vec3_dot(to, turned->up);
        near       = fmin(near, vec3_dot(to, ray->direction));
        far        = fmax(far, vec3_dot(to, ray->direction));
    }
    c->sign = edge_crosses(seen[0], seen[1]) + edge_crosses(seen[1], seen[2]) + edge_crosses(seen[2], seen[0]);
    if (!c->sign) return 0;
    vec3_sub(t[1], t[0], a);
    vec3_sub(t[2], t[0], b);
    vec3_cross(a, b, normal);
    vec3_sub(t[0], ray->eye, to);
    c->x = fmin(fmax(vec3_dot(normal, to) / vec3_dot(normal, ray->direction), near), far); /* edge on: somewhere of it */
    return c->x > ray->begin;
}

typedef struct crossings {
    crossing *at;
    size_t    count, room;
} crossings;

static int by_place(const void *a, const void *b)
{
    const crossing *p = a, *q = b;
    return p->x != q->x ? (p->x > q->x) - (p->x < q->x) : (p->sign > q->sign) - (p->sign < q->sign);
}

/* All of them, to infinity, from near to far. */
static crossings find_crossings(const lit_mesh *m, const eye_ray *ray)
{
    crossings found  = {0};
    across    turned = across_of(ray);
    for (size_t g = 0; g < m->group_count; g++) {
        if (!meets_box(ray, m->boxes[g])) continue;
        for (size_t t = g * GROUP; t < (g + 1) * GROUP && t < m->count; t++) {
            crossing c;
            if (!meets_triangle(ray, &turned, m->triangles[t], &c)) continue;
            if (found.count == found.room) {
                found.room = 2 * found.room + 16;
                found.at   = realloc(found.at, found.room * sizeof *found.at);
                if (!found.at) abort();
            }
            found.at[found.count++] = c;
        }
    }
    if (found.count) qsort(found.at, found.count, sizeof *found.at, by_place);
    return found;
}

static int winding_of(const crossings *found)
{
    int winding = 0;
    for (size_t n = 0; n < found->count; n++) winding += found->at[n].sign;
    return winding;
}

int mesh_winding(const lit_mesh *m, const eye_ray *ray)
{
    crossings found   = find_crossings(m, ray);
    int       winding = winding_of(&found);
    free(found.at);
    return winding;
}

void mesh_parts(const void *mesh, const eye_ray *ray, lit_parts *parts)
{
    crossings found   = find_crossings(mesh, ray);
    int       winding = winding_of(&found);
    double    begin   = ray->begin;
    lit_parts_clear(parts);
    for (size_t n = 0; n < found.count && found.at[n].x < ray->end; n++) {
        if (winding > 0) lit_parts_add(parts, begin, found.at[n].x);
        winding -= found.at[n].sign;
        begin = found.at[n].x;
    }
    if (winding > 0) lit_parts_add(parts, begin, ray->end);
    free(found.at);
}
