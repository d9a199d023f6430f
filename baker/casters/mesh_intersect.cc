/* Which triangles touch or cross; see casters_cgal.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/casters/casters_cgal.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <CGAL/intersections.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <new>
#include <vector>

#include "baker/base/box.h"
#include "baker/base/parallel.h"
#include "baker/base/threads.h"

namespace
{
using kernel       = CGAL::Exact_predicates_inexact_constructions_kernel;
using point        = kernel::Point_3;
using segment      = kernel::Segment_3;
using triangle     = kernel::Triangle_3;
using numbered_box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, uint32_t>;

constexpr std::ptrdiff_t scan_below = 300;  /* this many boxes or fewer are compared one by one: fastest for meshes */
constexpr size_t         slab_boxes = 8192; /* boxes that begin in one slab */

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

/* Two triangles with a common edge overlap when they are coplanar and on the same side of the edge. */
bool overlap_beside_edge(const point &p, const point &q, const point &a, const point &b)
{
    return CGAL::coplanar(p, q, a, b) && CGAL::coplanar_orientation(p, q, a, b) == CGAL::POSITIVE;
}

/* 1 when the two boxes share only a point, or a line along an axis, and this is the common corner or edge. This shortcut covers
 * most of a mesh of voxels, where exact predicates are slowest because all is coplanar. */
bool boxes_have_only_corners_in_common(const mesh_soup &s, uint32_t a, uint32_t b, int common)
{
    const CGAL::Bbox_3 u = triangle_at(s, a).bbox(), v = triangle_at(s, b).bbox();
    int                flat = 0;
    for (int axis = 0; axis < 3; axis++) flat += std::max(u.min(axis), v.min(axis)) == std::min(u.max(axis), v.max(axis));
    return flat == 3 || (flat == 2 && common == 2);
}

bool do_meet(const mesh_soup &s, uint32_t a, uint32_t b)
{
    const uint32_t *u = &s.indices[3 * size_t(a)], *v = &s.indices[3 * size_t(b)];
    int             common = 0, ours[3], theirs[3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (u[i] == v[j]) ours[common] = i, theirs[common] = j, common++;

    if (common == 3) return true;
    if (common && boxes_have_only_corners_in_common(s, a, b, common)) return false;
    if (common == 2)
        return overlap_beside_edge(corner(s, a, ours[0]), corner(s, a, ours[1]), corner(s, a, 3 - ours[0] - ours[1]),
                                   corner(s, b, 3 - theirs[0] - theirs[1]));
    if (common == 0) return CGAL::do_intersect(triangle_at(s, a), triangle_at(s, b));
    /* with one common corner, the opposite side of one triangle must reach the other triangle */
    const int i = ours[0], j = theirs[0];
    return CGAL::do_intersect(triangle_at(s, a), segment(corner(s, b, j + 1), corner(s, b, j + 2))) ||
           CGAL::do_intersect(triangle_at(s, b), segment(corner(s, a, i + 1), corner(s, a, i + 2)));
}

/* Sort pointers to boxes: faster than sorting boxes. */
template <class visitor> void for_each_overlap(std::vector<const numbered_box *> &boxes, const visitor &visit)
{
    CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), visit, scan_below);
}

/* Slabs of space across its longest axis, between consecutive bounds. A pair belongs to the slab in which the later of its boxes
 * begins. */
struct slabs {
    int                 axis = 0;
    std::vector<double> bounds; /* strictly ascending; the last slab is unbounded */
};

slabs cut(const std::vector<numbered_box> &boxes)
{
    slabs        s;
    CGAL::Bbox_3 all;
    for (const numbered_box &b : boxes) all += b.bbox();
    for (int axis = 1; axis < 3; axis++)
        if (all.max(axis) - all.min(axis) > all.max(s.axis) - all.min(s.axis)) s.axis = axis;

    std::vector<double> begins;
    begins.reserve(boxes.size());
    for (const numbered_box &b : boxes) begins.push_back(b.min_coord(s.axis));
    for (size_t n = 0, last = 0; n < begins.size(); last = n, n += slab_boxes) {
        std::nth_element(begins.begin() + last, begins.begin() + n, begins.end());
        if (s.bounds.empty() || begins[n] > s.bounds.back()) s.bounds.push_back(begins[n]);
    }
    return s;
}

/* Search of all slabs by several threads. An end or failure in one slab ends all. */
struct slab_search {
    const mesh_soup          &soup;
    mesh_search              &search;
    std::vector<numbered_box> boxes;
    slabs                     space;
    os_mutex                  reporting;
    std::atomic<uint64_t>     overlaps{0}, tests{0};
    std::atomic<bool>         done{false}, gave_up{false}, no_memory{false};

    slab_search(const mesh_soup &s, mesh_search &how) : soup(s), search(how)
    {
        boxes.reserve(s.triangle_count);
        for (uint32_t t = 0; t < s.triangle_count; t++)
            if (!is_flat(s, t)) boxes.emplace_back(triangle_at(s, t).bbox(), t);
        space = cut(boxes);
        os_mutex_init(&reporting);
    }

    slab_search(const slab_search &) = delete;
    ~slab_search() { os_mutex_free(&reporting); }

    void examine(uint32_t a, uint32_t b)
    {
        if (done) throw all_found();
        if (overlaps++ >= search.overlaps_max) throw limit_met();
        if (!search.wanted(search.user, a, b)) return;
        if (tests++ >= search.tests_max) throw limit_met();
        if (!do_meet(soup, a, b)) return;
        os_lock(&reporting);
        int is_last = !done && search.found(search.user, a, b);
        os_unlock(&reporting);
        if (is_last) throw all_found();
    }

    void search_slab(size_t n)
    {
        const double                      begin = space.bounds[n];
        const double                      end   = n + 1 < space.bounds.size() ? space.bounds[n + 1] : HUGE_VAL;
        std::vector<const numbered_box *> here;
        for (const numbered_box &b : boxes)
            if (b.min_coord(space.axis) < end && b.max_coord(space.axis) >= begin) here.push_back(&b);
        for_each_overlap(here, [&](const numbered_box *a, const numbered_box *b) {
            if (std::max(a->min_coord(space.axis), b->min_coord(space.axis)) >= begin) examine(a->info(), b->info());
        });
    }

    static void search_slabs(void *user, size_t begin, size_t end, uint32_t)
    {
        slab_search &s = *static_cast<slab_search *>(user);
        try {
            for (size_t n = begin; n < end && !s.done; n++) s.search_slab(n);
            return;
        } catch (const std::bad_alloc &) {
            s.no_memory = true;
        } catch (const all_found &) {
        } catch (...) { /* a limit was reached or CGAL failed: some pairs are missing */
            s.gave_up = true;
        }
        s.done = true;
    }
};
} // namespace

vxs_result mesh_find_intersections(const mesh_soup *s, mesh_search *search)
{
    search->overlaps = search->tests = 0;
    search->gave_up                  = 0;
    try {
        slab_search all(*s, *search);
        parallel_for(search->threads, all.space.bounds.size(), 1, slab_search::search_slabs, &all);
        search->overlaps = all.overlaps;
        search->tests    = all.tests;
        search->gave_up  = all.gave_up;
        return all.no_memory ? VXS_E_MEMORY : VXS_OK;
    } catch (const std::bad_alloc &) {
        return VXS_E_MEMORY;
    } catch (...) { /* CGAL failed before the first pair */
        search->gave_up = 1;
    }
    return VXS_OK;
}

vxs_result mesh_find_overlaps(const box *boxes, size_t count, int (*found)(void *user, uint32_t a, uint32_t b), void *user)
{
    try {
        std::vector<numbered_box> all;
        all.reserve(count);
        for (uint32_t i = 0; i < count; i++) {
            const double *low = boxes[i].min, *high = boxes[i].max;
            all.emplace_back(CGAL::Bbox_3(low[0], low[1], low[2], high[0], high[1], high[2]), i);
        }
        std::vector<const numbered_box *> order;
        for (const numbered_box &b : all) order.push_back(&b);
        for_each_overlap(order, [&](const numbered_box *a, const numbered_box *b) {
            if (found(user, a->info(), b->info())) throw all_found();
        });
    } catch (const all_found &) {
    } catch (...) {
        return VXS_E_MEMORY; /* only memory can fail here: boxes are compared without CGAL */
    }
    return VXS_OK;
}

int mesh_is_flat(const mesh_soup *s, size_t triangle)
{
    return is_flat(*s, uint32_t(triangle));
}
