/* Which closed shells have something inside; see casters_cgal.h.
 *
 * If a component or point is in a shell, its box is in the shell's box. A tree of boxes enumerates these candidates ("guests") one
 * at a time, because for most shells the first one decides; among nested shells the number of pairs is quadratic. For several
 * guests at a time, a tree is built of the part of the shell that matters for them.
 *
 * Inside is decided by the winding number, because the shells are balanced soups and need not be manifold, as
 * CGAL::Side_of_triangle_mesh requires. The winding number is counted along a vertical segment from the point to above the shell.
 * The segment may hit edges, corners and vertical triangles. Therefore the point is moved by (h, h^2, 0) with an infinitely small h
 * > 0 (simulation of simplicity: Edelsbrunner and Muecke 1990). Then the segment either crosses the interior of a triangle or
 * misses the triangle, and no other direction must be tried.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/casters/casters_cgal.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <iterator>
#include <new>
#include <vector>

#include "baker/base/box.h"
#include "baker/base/parallel.h"

namespace
{
using kernel    = CGAL::Exact_predicates_inexact_constructions_kernel;
using point     = kernel::Point_3;
using triangle  = kernel::Triangle_3;
using triangles = std::vector<triangle>;
using primitive = CGAL::AABB_triangle_primitive<kernel, triangles::const_iterator>;
using tree      = CGAL::AABB_tree<CGAL::AABB_traits<kernel, primitive>>;

constexpr size_t tested_vertices_max = 4096;

point point_at(const double *xyz)
{
    return point(xyz[0], xyz[1], xyz[2]);
}

/* Side of the line through a and b, seen from above, on which p is after the move by (h, h^2). */
int side_above(const point &a, const point &b, const point &p)
{
    using plane_point = kernel::Point_2;
    int side          = CGAL::orientation(plane_point(a.x(), a.y()), plane_point(b.x(), b.y()), plane_point(p.x(), p.y()));
    if (side == 0) side = CGAL::compare(a.y(), b.y());
    if (side == 0) side = CGAL::compare(b.x(), a.x());
    return side;
}

/* Contribution of a triangle to the winding number of p, along the upward segment from p: +1 when the segment leaves through its
 * back. */
int crossing(const triangle &t, const point &p)
{
    int ab = side_above(t[0], t[1], p), bc = side_above(t[1], t[2], p), ca = side_above(t[2], t[0], p);
    return ab == bc && bc == ca ? ab : 0;
}

/* Guest numbers: below s.count a component, else point guest - s.count. */
CGAL::Bbox_3 guest_box(const shell_set &s, uint32_t guest)
{
    if (guest >= s.count) return point_at(&s.points[3 * (guest - s.count)]).bbox();
    const double *low = s.boxes[guest].min, *high = s.boxes[guest].max;
    return CGAL::Bbox_3(low[0], low[1], low[2], high[0], high[1], high[2]);
}

bool is_within(const CGAL::Bbox_3 &b, const CGAL::Bbox_3 &outer)
{
    return b.xmin() >= outer.xmin() && b.ymin() >= outer.ymin() && b.zmin() >= outer.zmin() && b.xmax() <= outer.xmax() &&
           b.ymax() <= outer.ymax() && b.zmax() <= outer.zmax();
}

/* The part of a component above or around an area. It decides whether a point of the area is inside. */
class shell
{
  public:
    shell(const shell_set &s, uint32_t component, const CGAL::Bbox_3 &area)
    {
        const CGAL::Bbox_3 whole = guest_box(s, component);
        /* above everything: no segment degenerates to a point */
        top                      = whole.zmax() + (whole.zmax() - whole.zmin());
        const CGAL::Bbox_3 column(area.xmin(), area.ymin(), area.zmin(), area.xmax(), area.ymax(), top);

        for (uint32_t i = s.first[component]; i < s.first[component + 1]; i++) {
            const uint32_t *v = &s.indices[3 * size_t(s.members[i])];
            const triangle  t(point_at(&s.positions_ws[3 * size_t(v[0])]), point_at(&s.positions_ws[3 * size_t(v[1])]),
                              point_at(&s.positions_ws[3 * size_t(v[2])]));
            /* skip triangles without area: they are edge-on to the segment and contribute nothing, and CGAL refuses them */
            if (CGAL::do_overlap(t.bbox(), column) && !t.is_degenerate()) faces.push_back(t);
        }
        face_tree.insert(faces.cbegin(), faces.cend());
        face_tree.build();
    }

    bool holds(const point &p)
    {
        met.clear();
        face_tree.all_intersected_primitives(kernel::Segment_3(p, point(p.x(), p.y(), top)), std::back_inserter(met));
        int winding = 0;
        for (auto face : met) {
            if (face->has_on(p)) return true;
            winding += crossing(*face, p);
        }
        return winding != 0;
    }

  private:
    double                                 top;
    triangles                              faces;
    tree                                   face_tree;
    std::vector<triangles::const_iterator> met;
};

/* 1 when a whole component is in the shell. A vertex on the surface does not decide, so further vertices are tested. If all are on
 * the surface (as for a copy of the shell), the component counts as inside: the safe answer. */
bool holds_component(shell &outer, const shell_set &s, uint32_t inner)
{
    /* one vertex rejects most components */
    const uint32_t corner = s.indices[3 * size_t(s.members[s.first[inner]])];
    if (!outer.holds(point_at(&s.positions_ws[3 * size_t(corner)]))) return false;

    std::vector<uint32_t> vertices;
    vertices.reserve(3 * size_t(s.first[inner + 1] - s.first[inner]));
    for (uint32_t i = s.first[inner]; i < s.first[inner + 1]; i++) {
        const uint32_t *v = &s.indices[3 * size_t(s.members[i])];
        vertices.insert(vertices.end(), v, v + 3);
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    const size_t tested = std::min(vertices.size(), tested_vertices_max);
    for (size_t i = 0; i < tested; i++) {
        const uint32_t v = vertices[i * vertices.size() / tested];
        if (!outer.holds(point_at(&s.positions_ws[3 * size_t(v)]))) return false;
    }
    return true;
}

/* Search structure for guests whose boxes may lie in a box: a balanced tree over their six bounds. Each part of the tree stores the
 * maxima of the lower bounds and the minima of the upper bounds of its guests; if these are outside the box, so are all guests of
 * the part. Bounds are floats, which may find guests that lie a little outside. */
class guest_tree
{
  public:
    guest_tree(const shell_set &s, uint32_t threads) : threads(threads)
    {
        guests.reserve(s.count + s.point_count);
        for (uint32_t i = 0; i < s.count + s.point_count; i++) guests.push_back({bounds_of(guest_box(s, i), INFINITY), i});
        size_t parts = 1;
        while (guests.size() > leaf_guests * parts) parts *= 2;
        greatest.resize(2 * parts);
        build(1, 0, guests.size());
    }

    /* Call visit(number) for the guests in a box until it returns true. */
    template <class visitor> bool any_inside(const CGAL::Bbox_3 &b, const visitor &visit) const
    {
        return any_inside(bounds_of(b, -INFINITY), visit, 1, 0, guests.size());
    }

  private:
    /* Lower bounds and negated upper bounds. A guest is in a box when each of its values is at least the box's value. */
    using bounds = std::array<float, 6>;
    struct guest {
        bounds   at;
        uint32_t number;
    };
    static constexpr size_t leaf_guests = 8;
    const uint32_t          threads;
    std::vector<guest>      guests;
    std::vector<bounds>     greatest; /* by part; part n has the children 2 n and 2 n + 1 */

    /* Rounded toward `to`. */
    static bounds bounds_of(const CGAL::Bbox_3 &b, float to)
    {
        const double exact[6] = {b.xmin(), b.ymin(), b.zmin(), -b.xmax(), -b.ymax(), -b.zmax()};
        bounds       out;
        for (size_t k = 0; k < 6; k++) {
            out[k] = (float)exact[k];
            if (to > 0 ? (double)out[k] < exact[k] : (double)out[k] > exact[k]) out[k] = std::nextafterf(out[k], to);
        }
        return out;
    }

    bool is_leaf(size_t part) const { return 2 * part >= greatest.size(); }

    static bool none_less(const bounds &a, const bounds &b)
    {
        bool less = false;
        for (size_t k = 0; k < 6; k++) less |= a[k] < b[k];
        return !less;
    }

    void build(size_t part, size_t begin, size_t end)
    {
        bounds least = guests[begin].at, most = least;
        size_t widest = 0, middle = begin + (end - begin) / 2;
        for (size_t i = begin; i < end; i++)
            for (size_t k = 0; k < 6; k++) {
                least[k] = std::min(least[k], guests[i].at[k]);
                most[k]  = std::max(most[k], guests[i].at[k]);
            }
        greatest[part] = most;
        if (is_leaf(part)) return;
        for (size_t k = 1; k < 6; k++)
            if (most[k] - least[k] > most[widest] - least[widest]) widest = k;
        std::nth_element(guests.begin() + (ptrdiff_t)begin, guests.begin() + (ptrdiff_t)middle, guests.begin() + (ptrdiff_t)end,
                         [widest](const guest &a, const guest &b) { return a.at[widest] < b.at[widest]; });
        halves both = {*this, 2 * part, {begin, middle, end}};
        /* recursively, until there is one part per thread */
        parallel_for(part < threads ? 2 : 1, 2, 1, build_halves, &both);
    }

    struct halves {
        guest_tree &tree;
        size_t      part, bounds[3];
    };

    static void build_halves(void *user, size_t begin, size_t end, uint32_t)
    {
        const halves *h = (const halves *)user;
        for (size_t n = begin; n < end; n++) h->tree.build(h->part + n, h->bounds[n], h->bounds[n + 1]);
    }

    template <class visitor> bool any_inside(const bounds &box, const visitor &visit, size_t part, size_t begin, size_t end) const
    {
        const size_t middle = begin + (end - begin) / 2;
        if (!none_less(greatest[part], box)) return false;
        if (!is_leaf(part))
            return any_inside(box, visit, 2 * part, begin, middle) || any_inside(box, visit, 2 * part + 1, middle, end);
        for (size_t i = begin; i < end; i++)
            if (none_less(guests[i].at, box) && visit(guests[i].number)) return true;
        return false;
    }
};

bool holds_any(const shell_set &s, uint32_t component, const std::vector<uint32_t> &guests)
{
    CGAL::Bbox_3 area;
    for (uint32_t guest : guests) area += guest_box(s, guest);
    shell outer(s, component, area);
    return std::any_of(guests.begin(), guests.end(), [&](uint32_t guest) {
        return guest < s.count ? holds_component(outer, s, guest) : outer.holds(point_at(&s.points[3 * (guest - s.count)]));
    });
}

/* Often the first guest in the box is inside, and a small part of the shell proves it. Otherwise groups of eight times as many
 * guests follow, so that many guests do not need many trees. */
bool is_occupied(const shell_set &s, const guest_tree &guests, uint32_t component)
{
    std::vector<uint32_t> batch;
    size_t                room = 1;
    const CGAL::Bbox_3    own  = guest_box(s, component);
    return guests.any_inside(own, [&](uint32_t guest) {
        if (guest == component || !is_within(guest_box(s, guest), own)) return false;
        batch.push_back(guest);
        if (batch.size() < room) return false;
        if (holds_any(s, component, batch)) return true;
        batch.clear();
        room *= 8;
        return false;
    }) || (!batch.empty() && holds_any(s, component, batch));
}

/* A search over all components by several threads. */
struct search {
    const shell_set  &s;
    const uint8_t    *wanted;
    uint8_t          *occupied;
    const uint32_t    threads;
    const guest_tree  guests{s, threads};
    std::atomic<bool> no_memory{false};

    void look(uint32_t component)
    {
        try {
            occupied[component] = is_occupied(s, guests, component);
        } catch (const std::bad_alloc &) {
            no_memory = true;
        } catch (...) {
            occupied[component] = 1;
        }
    }
};

void look_at_some(void *user, size_t begin, size_t end, uint32_t)
{
    search *work = (search *)user;
    for (size_t i = begin; i < end; i++)
        if (work->wanted[i]) work->look((uint32_t)i);
}

/* Test the pairs [begin, end), which have the same outer component. */
void find_inside(const shell_set &s, shell_pair *begin, shell_pair *end)
{
    CGAL::Bbox_3 area;
    for (const shell_pair *p = begin; p != end; p++) area += guest_box(s, p->inner);
    shell outer(s, begin->outer, area);
    for (shell_pair *p = begin; p != end; p++) {
        const uint32_t corner = s.indices[3 * size_t(s.members[s.first[p->inner]])];
        p->inside             = outer.holds(point_at(&s.positions_ws[3 * size_t(corner)]));
    }
}
} // namespace

vxs_result shells_find_inside(const shell_set *s, shell_pair *pairs, size_t count)
{
    for (shell_pair *begin = pairs, *end; begin != pairs + count; begin = end) {
        end = std::find_if(begin, pairs + count, [&](const shell_pair &p) { return p.outer != begin->outer; });
        try {
            find_inside(*s, begin, end);
        } catch (const std::bad_alloc &) {
            return VXS_E_MEMORY;
        } catch (...) {
            for (shell_pair *p = begin; p != end; p++) p->inside = 1;
        }
    }
    return VXS_OK;
}

vxs_result shells_find_occupied(const shell_set *s, const uint8_t *wanted, uint8_t *occupied, uint32_t threads)
{
    try {
        if (!s->count) return VXS_OK;
        search work{*s, wanted, occupied, threads};
        parallel_for(threads, s->count, 64, look_at_some, &work);
        return work.no_memory ? VXS_E_MEMORY : VXS_OK;
    } catch (const std::bad_alloc &) {
        return VXS_E_MEMORY;
    } catch (...) {
        for (size_t i = 0; i < s->count; i++)
            if (wanted[i]) occupied[i] = 1;
    }
    return VXS_OK;
}
