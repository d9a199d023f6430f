/* Curves of light through smoke; see smoke_path.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/smoke/smoke_path.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/array.h"
#include "formats/vxs_format.h"

void smoke_path_free(smoke_path *p)
{
    free(p->depth);
    free(p->thick);
    *p = (smoke_path){0};
}

static int add_point(smoke_path *p, double depth, double thick)
{
    if (!array_reserve(&p->depth, &p->depth_capacity, p->count + 1, sizeof *p->depth)) return 0;
    if (!array_reserve(&p->thick, &p->thick_capacity, p->count + 1, sizeof *p->thick)) return 0;
    p->depth[p->count]   = depth;
    p->thick[p->count++] = thick;
    return 1;
}

int smoke_path_add(smoke_path *p, double begin, double end, double thick)
{
    double before = p->count ? p->thick[p->count - 1] : 0;
    if ((!p->count || p->depth[p->count - 1] < begin) && !add_point(p, begin, before)) return 0;
    return add_point(p, end, before + thick);
}

void smoke_path_cut(smoke_path *p, double depth)
{
    if (!p->count || p->depth[p->count - 1] <= depth) return;
    double thick = smoke_path_thick(p, depth);
    while (p->count && p->depth[p->count - 1] > depth) p->count--;
    if (!p->count) return;
    p->depth[p->count]   = depth; /* replaces one behind it */
    p->thick[p->count++] = thick;
}

double smoke_path_thick(const smoke_path *p, double depth)
{
    size_t low = 0, high = p->count; /* the first point behind that depth is in [low, high] */
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (p->depth[middle] > depth)
            high = middle;
        else
            low = middle + 1;
    }
    if (low == 0) return 0;
    if (low == p->count) return p->thick[p->count - 1];
    double part = (depth - p->depth[low - 1]) / (p->depth[low] - p->depth[low - 1]);
    return p->thick[low - 1] + part * (p->thick[low] - p->thick[low - 1]);
}

int smoke_path_sum(const smoke_path *a, const smoke_path *b, smoke_path *sum)
{
    sum->count = 0;
    for (size_t i = 0, j = 0; i < a->count || j < b->count;) {
        double depth = j == b->count || (i < a->count && a->depth[i] < b->depth[j]) ? a->depth[i] : b->depth[j];
        while (i < a->count && a->depth[i] <= depth) i++;
        while (j < b->count && b->depth[j] <= depth) j++;
        if (!add_point(sum, depth, smoke_path_thick(a, depth) + smoke_path_thick(b, depth))) return 0;
    }
    return 1;
}

/* nodes ------------------------------------------------------------------------------------------------------------------------ */

/* A curve during the choice of its nodes: points of the path; for each gap between two of them, the point that is farthest from the
 * straight line. */
typedef struct curve {
    const smoke_path *path;
    size_t            point[VXS_SMOKE_NODES_MAX], worst[VXS_SMOKE_NODES_MAX];
    double            far[VXS_SMOKE_NODES_MAX];
    uint32_t          count;
} curve;

static double left_of(const smoke_path *p, size_t point)
{
    return exp(-p->thick[point]);
}

/* Find the point of gap n that is farthest from its line. */
static void look_into_gap(curve *c, uint32_t n)
{
    const smoke_path *p = c->path;
    size_t            a = c->point[n], b = c->point[n + 1];
    double            left = left_of(p, a), slope = (left_of(p, b) - left) / (p->depth[b] - p->depth[a]);
    c->far[n] = 0;
    for (size_t k = a + 1; k < b; k++) {
        double off = fabs(left_of(p, k) - left - slope * (p->depth[k] - p->depth[a]));
        if (off <= c->far[n]) continue;
        c->far[n]   = off;
        c->worst[n] = k;
    }
}

/* Insert a node in gap n. */
static void split_gap(curve *c, uint32_t n)
{
    for (uint32_t k = c->count++; k > n + 1; k--) {
        c->point[k] = c->point[k - 1];
        c->worst[k] = c->worst[k - 1];
        c->far[k]   = c->far[k - 1];
    }
    c->point[n + 1] = c->worst[n];
    look_into_gap(c, n);
    look_into_gap(c, n + 1);
}

static uint32_t farthest_gap(const curve *c)
{
    uint32_t farthest = 0;
    for (uint32_t n = 1; n + 1 < c->count; n++)
        if (c->far[n] > c->far[farthest]) farthest = n;
    return farthest;
}

/* A node at a whole unit, with the transmittance there. The first node is not behind the path's begin, the last not before its
 * end. */
static uint32_t node_at(const smoke_path *p, const smoke_units *units, double unit)
{
    double depth = fmin(fmax(unit, 0), 65535), left = exp(-smoke_path_thick(p, units->first_metres + depth * units->step_metres));
    return (uint32_t)depth | (uint32_t)lround(left * 65535) << 16;
}

uint32_t smoke_path_nodes(const smoke_path *p, const smoke_units *units, double error, uint32_t most, uint32_t *nodes)
{
    if (!p->count || 1 - left_of(p, p->count - 1) <= error) return 0;
    curve c = {.path = p, .point = {0, p->count - 1}, .count = 2};
    look_into_gap(&c, 0);
    for (uint32_t gap = 0; c.count < most && c.far[gap = farthest_gap(&c)] > error;) split_gap(&c, gap);

    uint32_t count = 0;
    for (uint32_t n = 0; n < c.count; n++) {
        double   unit = (p->depth[c.point[n]] - units->first_metres) / units->step_metres;
        uint32_t node = node_at(p, units, n == 0 ? floor(unit) : n + 1 == c.count ? ceil(unit) : round(unit));
        if (count && (node & 0xffff) == (nodes[count - 1] & 0xffff)) count--;
        nodes[count++] = node;
    }
    return count;
}

double smoke_path_error(const smoke_path *p, const smoke_units *units, const uint32_t *nodes, uint32_t count)
{
    double   most   = 0;
    uint32_t before = 0; /* number of nodes at or before the depth */
    for (size_t k = 0; k < p->count; k++) {
        double unit = (p->depth[k] - units->first_metres) / units->step_metres, left = 65535;
        while (before < count && (nodes[before] & 0xffff) <= unit) before++;
        if (before) left = nodes[before - 1] >> 16;
        if (before && before < count) {
            double near = nodes[before - 1] & 0xffff, far = nodes[before] & 0xffff;
            left += (unit - near) / (far - near) * ((nodes[before] >> 16) - left);
        }
        most = fmax(most, fabs(left / 65535 - left_of(p, k)));
    }
    return most;
}
