/* A bounding volume tree of points; see point_tree.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/casters/point_tree.h"

#include <math.h>
#include <stdlib.h>

enum { LEAF_POINTS = 8, DEPTH_MAX = 64 };

/* A node and its range of points. */
typedef struct span {
    size_t node, begin, end;
} span;

static int is_leaf(span s)
{
    return s.end - s.begin <= LEAF_POINTS;
}

static span child_of(span s, int second)
{
    size_t middle = s.begin + (s.end - s.begin) / 2;
    return second ? (span){2 * s.node + 2, middle, s.end} : (span){2 * s.node + 1, s.begin, middle};
}

/* --- building ---------------------------------------------------------------------------------------------------------- */

static void swap_points(tree_point *a, tree_point *b)
{
    tree_point swapped = *a;
    *a                 = *b;
    *b                 = swapped;
}

/* Partially sort [begin, end): no point before `middle` is greater than one from `middle` on. Quickselect with a random pivot and a
 * three-way partition, because many points of a mesh have equal coordinates. */
static void part_points(tree_point *p, size_t begin, size_t end, size_t middle, int axis)
{
    uint64_t state = begin ^ end;
    while (end - begin > 1) {
        state        = state * 6364136223846793005u + 1442695040888963407u;
        double pivot = p[begin + (state >> 33) % (end - begin)].at[axis];
        size_t less = begin, more = end; /* [begin, less) is less than the pivot, [more, end) is greater */
        for (size_t n = begin; n < more;) {
            if (p[n].at[axis] < pivot)
                swap_points(&p[less++], &p[n++]);
            else if (p[n].at[axis] > pivot)
                swap_points(&p[--more], &p[n]);
            else
                n++;
        }
        if (middle < less)
            end = less;
        else if (middle >= more)
            begin = more;
        else
            return;
    }
}

static void build(point_tree *t, span s)
{
    box tight = box_empty(), *b = &t->boxes[s.node];
    *b = tight;
    for (const tree_point *p = t->points + s.begin; p < t->points + s.end; p++) {
        box_add(&tight, p->at);
        box_add(b, (double[3]){p->at[0] - p->reach, p->at[1] - p->reach, p->at[2] - p->reach});
        box_add(b, (double[3]){p->at[0] + p->reach, p->at[1] + p->reach, p->at[2] + p->reach});
    }
    if (is_leaf(s)) return;
    span first = child_of(s, 0), second = child_of(s, 1);
    int  longest = 0;
    for (int axis = 1; axis < 3; axis++)
        if (tight.max[axis] - tight.min[axis] > tight.max[longest] - tight.min[longest]) longest = axis;
    part_points(t->points, s.begin, s.end, first.end, longest);
    build(t, first);
    build(t, second);
}

int point_tree_init(point_tree *t, tree_point *points, size_t count, uint64_t visits)
{
    size_t nodes = 1;
    /* the larger half determines the depth */
    for (size_t most = count; most > LEAF_POINTS; most -= most / 2) nodes = 2 * nodes + 1;
    *t = (point_tree){.count = count, .points = points, .visits = visits, .boxes = malloc(nodes * sizeof *t->boxes)};
    if (!t->boxes) return 0;
    build(t, (span){0, 0, count});
    return 1;
}

void point_tree_free(point_tree *t)
{
    free(t->boxes);
    *t = (point_tree){0};
}

/* --- searching --------------------------------------------------------------------------------------------------------- */

/* 0 when no point of the segment is within `radius` of the box, along each axis. */
static int may_touch(const box *b, const double a[3], const double step[3], const double radius[3])
{
    double from = 0, to = 1;
    for (int axis = 0; axis < 3; axis++) {
        double low = b->min[axis] - radius[axis] - a[axis], high = b->max[axis] + radius[axis] - a[axis];
        if (step[axis] == 0) {
            if (low > 0 || high < 0) return 0;
            continue;
        }
        double enter = low / step[axis], leave = high / step[axis];
        from = fmax(from, fmin(enter, leave));
        to   = fmin(to, fmax(enter, leave));
    }
    return from <= to * (1 + 1e-12); /* tolerance for rounded quotients */
}

int point_tree_search(point_tree *t, const double a[3], const double b[3], const double radius[3], point_tree_visitor *visit,
                      void *user)
{
    double step[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    span   stack[DEPTH_MAX];
    int    held   = 0;
    stack[held++] = (span){0, 0, t->count};
    while (held) {
        span     s    = stack[--held];
        uint64_t cost = 1 + (is_leaf(s) ? s.end - s.begin : 0);
        if (t->visits < cost) return 0;
        t->visits -= cost;
        if (!may_touch(&t->boxes[s.node], a, step, radius)) continue;
        if (!is_leaf(s)) {
            stack[held++] = child_of(s, 1);
            stack[held++] = child_of(s, 0);
            continue;
        }
        for (size_t n = s.begin; n < s.end; n++)
            if (visit(user, n)) return 1;
    }
    return 1;
}
