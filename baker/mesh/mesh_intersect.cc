/* Which triangles touch or cross; see mesh_intersect.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/mesh/mesh_intersect.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <CGAL/intersections.h>

#include <new>
#include <vector>

namespace
{
using kernel   = CGAL::Exact_predicates_inexact_constructions_kernel;
using point    = kernel::Point_3;
using segment  = kernel::Segment_3;
using triangle = kernel::Triangle_3;
using box      = CGAL::Box_intersection_d::Box_with_info_d<double, 3, uint32_t>;

constexpr std::ptrdiff_t scan_below = 2000; /* boxes that are compared one by one: fastest for meshes */

struct limit_met {
};
struct all_found {
};

point corner(const mesh_soup &s, uint32_t t, int i)
{
    const double *p = &s.positions_ws[3 * size_t(s.indices[3 * size_t(t) + i % 3])];
    return point(p[0], p[1], p[2]);
}

triangle triangle_at(const mesh_soup &s, uint32_t t)
{
    return triangle(corner(s, t, 0), corner(s, t, 1), corner(s, t, 2));
}

bool is_flat(const mesh_soup &s, uint32_t t)
{
    return CGAL::collinear(corner(s, t, 0), corner(s, t, 1), corner(s, t, 2));
}

/* Triangles with a common edge lie on each other when they are in one plane, on one side of the edge. */
bool overlap_beside_edge(const point &p, const point &q, const point &a, const point &b)
{
    return CGAL::coplanar(p, q, a, b) && CGAL::coplanar_orientation(p, q, a, b) == CGAL::POSITIVE;
}

bool do_meet(const mesh_soup &s, uint32_t a, uint32_t b)
{
    const uint32_t *u = &s.indices[3 * size_t(a)], *v = &s.indices[3 * size_t(b)];
    int             common = 0, ours[3], theirs[3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (u[i] == v[j]) ours[common] = i, theirs[common] = j, common++;

    if (common == 3) return true;
    if (common == 2)
        return overlap_beside_edge(corner(s, a, ours[0]), corner(s, a, ours[1]), corner(s, a, 3 - ours[0] - ours[1]),
                                   corner(s, b, 3 - theirs[0] - theirs[1]));
    if (common == 0) return CGAL::do_intersect(triangle_at(s, a), triangle_at(s, b));
    /* with one common corner, the side opposite of it reaches the other triangle, one way round or the other */
    const int i = ours[0], j = theirs[0];
    return CGAL::do_intersect(triangle_at(s, a), segment(corner(s, b, j + 1), corner(s, b, j + 2))) ||
           CGAL::do_intersect(triangle_at(s, b), segment(corner(s, a, i + 1), corner(s, a, i + 2)));
}

template <class visitor> void for_each_overlap(std::vector<box> &boxes, const visitor &visit)
{
    std::vector<box *> order; /* these are sorted, which is quicker than to sort boxes */
    order.reserve(boxes.size());
    for (box &b : boxes) order.push_back(&b);
    CGAL::box_self_intersection_d(
        order.begin(), order.end(), [&](const box *a, const box *b) { visit(a->info(), b->info()); }, scan_below);
}

void look_at(const mesh_soup &s, mesh_search &search, uint32_t a, uint32_t b)
{
    if (search.looks++ >= search.looks_max) throw limit_met();
    if (!search.wanted(search.user, a, b)) return;
    if (search.tests++ >= search.tests_max) throw limit_met();
    if (do_meet(s, a, b) && search.found(search.user, a, b)) throw all_found();
}

void find_intersections(const mesh_soup &s, mesh_search &search)
{
    std::vector<box> boxes;
    boxes.reserve(s.triangle_count);
    for (uint32_t t = 0; t < s.triangle_count; t++)
        if (!is_flat(s, t)) boxes.emplace_back(triangle_at(s, t).bbox(), t);
    for_each_overlap(boxes, [&](uint32_t a, uint32_t b) { look_at(s, search, a, b); });
}
} // namespace

vxs_result mesh_find_intersections(const mesh_soup *s, mesh_search *search)
{
    search->looks = search->tests = 0;
    search->gave_up               = 0;
    try {
        find_intersections(*s, *search);
    } catch (const std::bad_alloc &) {
        return VXS_E_MEMORY;
    } catch (const all_found &) {
    } catch (...) { /* a limit, or CGAL fails: either way some pairs are not known */
        search->gave_up = 1;
    }
    return VXS_OK;
}

vxs_result mesh_find_overlaps(const double *boxes, size_t count, int (*found)(void *user, uint32_t a, uint32_t b), void *user)
{
    try {
        std::vector<box> all;
        all.reserve(count);
        for (uint32_t i = 0; i < count; i++) {
            const double *b = &boxes[6 * size_t(i)];
            all.emplace_back(CGAL::Bbox_3(b[0], b[1], b[2], b[3], b[4], b[5]), i);
        }
        for_each_overlap(all, [&](uint32_t a, uint32_t b) {
            if (found(user, a, b)) throw all_found();
        });
    } catch (const all_found &) {
    } catch (...) {
        return VXS_E_MEMORY; /* boxes are compared, nothing else can fail */
    }
    return VXS_OK;
}

int mesh_is_flat(const mesh_soup *s, size_t triangle)
{
    return is_flat(*s, uint32_t(triangle));
}
