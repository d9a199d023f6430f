/* Which closed shells have something inside; see casters_cgal.h.
 *
 * Whatever lies in a shell has its box in the shell's box. A tree of boxes finds these guests one by one, since of most shells the first is
 * enough: of nested ones there are as many pairs as their number's square. For some at a time a tree is built of the part of the shell that
 * can matter.
 *
 * Inside is decided by the winding number, because the shells are balanced soups and need not be manifold, as
 * CGAL::Side_of_triangle_mesh wants them. It is counted along a vertical segment from the point to above the shell. That may
 * run through edges, corners and vertical triangles, so the count is made for the point moved by (h, h^2, 0), h > 0
 * infinitely small (simulation of simplicity: Edelsbrunner and Muecke 1990). Moved so, the segment crosses a triangle's
 * interior or misses the triangle, and no other direction has to be tried.
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

/* Where p, moved by (h, h^2), lies of the line through a and b, seen from above. */
int side_above(const point &a, const point &b, const point &p)
{
    using plane_point = kernel::Point_2;
    int side          = CGAL::orientation(plane_point(a.x(), a.y()), plane_point(b.x(), b.y()), plane_point(p.x(), p.y()));
    if (side == 0) side = CGAL::compare(a.y(), b.y());
    if (side == 0) side = CGAL::compare(b.x(), a.x());
    return side;
}

/* What a triangle that the upward segment from p meets adds to the winding number of p: +1 when left through its back. */
int crossing(const triangle &t, const point &p)
{
    int ab = side_above(t[0], t[1], p), bc = side_above(t[1], t[2], p), ca = side_above(t[2], t[0], p);
    return ab == bc && bc == ca ? ab : 0;
}

/* A guest below s.count is that component, any other is point guest - s.count. */
CGAL::Bbox_3 guest_box(const shell_set &s, uint32_t guest)
{
    if (guest >= s.count) return point_at(&s.points[3 * (guest - s.count)]).bbox();
    const double *low = s.boxes[guest].min, *high = s.boxes[guest].max;
    return CGAL::Bbox_3(low[0], low[1], low[2], high[0], high[1], high[2]);
}

/* The part of a component that is above or around an area, and so decides whether a point of the area is inside. */
class shell
{
  public:
    shell(const shell_set &s, uint32_t component, const CGAL::Bbox_3 &area)
    {
        const CGAL::Bbox_3 whole = guest_box(s, component);
        top                      = whole.zmax() + (whole.zmax() - whole.zmin()); /* above all: no segment shrinks to a point */
        const CGAL::Bbox_3 column(area.xmin(), area.ymin(), area.zmin(), area.xmax(), area.ymax(), top);

        for (uint32_t i = s.first[component]; i < s.first[component + 1]; i++) {
            const uint32_t *v = &s.indices[3 * size_t(s.members[i])];
            const triangle  t(point_at(&s.positions_ws[3 * size_t(v[0])]), point_at(&s.positions_ws[3 * size_t(v[1])]),
                              point_at(&s.positions_ws[3 * size_t(v[2])]));
            /* one without area is seen edge on from everywhere: it adds nothing, and CGAL refuses it */
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

std::vector<uint32_t> vertices_of(const shell_set &s, uint32_t component)
{
    std::vector<uint32_t> vertices;
    vertices.reserve(3 * size_t(s.first[component + 1] - s.first[component]));
    for (uint32_t i = s.first[component]; i < s.first[component + 1]; i++) {
        const uint32_t *v = &s.indices[3 * size_t(s.members[i])];
        vertices.insert(vertices.end(), v, v + 3);
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    return vertices;
}

/* Is all of a component in the shell? On the surface counts as inside: a point on it decides nothing, so further ones do,
 * and where all are on it (as those of a copy of the shell are) the doubt is resolved to the safe side. */
bool holds_component(shell &outer, const shell_set &s, uint32_t inner)
{
    /* most are dismissed by one vertex */
    const uint32_t corner = s.indices[3 * size_t(s.members[s.first[inner]])];
    if (!outer.holds(point_at(&s.positions_ws[3 * size_t(corner)]))) return false;

    const std::vector<uint32_t> vertices = vertices_of(s, inner);
    const size_t                tested   = std::min(vertices.size(), tested_vertices_max);
    for (size_t i = 0; i < tested; i++) {
        const uint32_t v = vertices[i * vertices.size() / tested];
        if (!outer.holds(point_at(&s.positions_ws[3 * size_t(v)]))) return false;
    }
    return true;
}

/* Boxes of guests, asked for those that lie in a box: a balanced tree over their six bounds. What is known of a part of the tree are its
 * greatest lower bounds and its least upper ones: where these are not in the box, no guest of the part is. */
class guest_tree
{
  public:
    guest_tree(const shell_set &s, uint32_t threads) : threads(threads)
    {
        guests.reserve(s.count + s.point_count);
        for (uint32_t i = 0; i < s.count + s.point_count; i++) {
            const CGAL::Bbox_3 b = guest_box(s, i);
            guests.push_back({{b.xmin(), b.ymin(), b.zmin(), -b.xmax(), -b.ymax(), -b.zmax()}, i});
        }
        size_t parts = 1;
        while (guests.size() > leaf_guests * parts) parts *= 2;
        greatest.resize(2 * parts);
        build(1, 0, guests.size());
    }

    /* Call visit(number) with the guests in a box until one says true. */
    template <class visitor> bool any_inside(const CGAL::Bbox_3 &b, const visitor &visit) const
    {
        return any_inside({b.xmin(), b.ymin(), b.zmin(), -b.xmax(), -b.ymax(), -b.zmax()}, visit, 1, 0, guests.size());
    }

  private:
    /* Lower bounds, and upper ones negated: in a box lies what has none less than the box's. */
    using bounds = std::array<double, 6>;
    struct guest {
        bounds   at;
        uint32_t number;
    };
    static constexpr size_t leaf_guests = 8;
    const uint32_t          threads;
    std::vector<guest>      guests;
    std::vector<bounds>     greatest; /* by part; part n is divided into 2 n and 2 n + 1 */

    bool is_leaf(size_t part) const { return 2 * part >= greatest.size(); }

    static bool none_less(const bounds &a, const bounds &b)
    {
        for (size_t k = 0; k < 6; k++)
            if (a[k] < b[k]) return false;
        return true;
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
        /* halves of halves, until there is one for each thread */
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

bool holds_guest(shell &outer, const shell_set &s, uint32_t guest)
{
    return guest < s.count ? holds_component(outer, s, guest) : outer.holds(point_at(&s.points[3 * (guest - s.count)]));
}

bool holds_any(const shell_set &s, uint32_t component, const std::vector<uint32_t> &guests)
{
    CGAL::Bbox_3 area;
    for (uint32_t guest : guests) area += guest_box(s, guest);
    shell outer(s, component, area);
    return std::any_of(guests.begin(), guests.end(), [&](uint32_t guest) { return holds_guest(outer, s, guest); });
}

/* Often the first guest in its box is inside, and a small part of the shell shows it; then eight more are tried, and so on, so that many
 * guests do not cost many trees. */
bool is_occupied(const shell_set &s, const guest_tree &guests, uint32_t component)
{
    std::vector<uint32_t> batch;
    size_t                room = 1;
    return guests.any_inside(guest_box(s, component), [&](uint32_t guest) {
        if (guest == component) return false;
        batch.push_back(guest);
        if (batch.size() < room) return false;
        if (holds_any(s, component, batch)) return true;
        batch.clear();
        room *= 8;
        return false;
    }) || (!batch.empty() && holds_any(s, component, batch));
}

/* Of all components, several at once. */
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

vxs_result find_occupied(const shell_set &s, const uint8_t *wanted, uint8_t *occupied, uint32_t threads)
{
    if (!s.count) return VXS_OK;
    search work{s, wanted, occupied, threads};
    parallel_for(threads, s.count, 64, look_at_some, &work);
    return work.no_memory ? VXS_E_MEMORY : VXS_OK;
}

/* The pairs [begin, end) of one outer component. */
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
        return find_occupied(*s, wanted, occupied, threads);
    } catch (const std::bad_alloc &) {
        return VXS_E_MEMORY;
    } catch (...) {
        for (size_t i = 0; i < s->count; i++)
            if (wanted[i]) occupied[i] = 1;
    }
    return VXS_OK;
}
