/* Boolean unions with CGAL; see mesh_unite.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/mend/mesh_unite.h"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iterator>
#include <map>
#include <new>
#include <numeric>
#include <vector>

namespace
{
namespace pmp  = CGAL::Polygon_mesh_processing;
using kernel   = CGAL::Exact_predicates_exact_constructions_kernel;
using surface  = CGAL::Surface_mesh<kernel::Point_3>;
using polygons = std::vector<std::array<std::size_t, 3>>;

struct no_patch {
};

constexpr size_t attempts_max = 4; /* what failed with some is tried with so many others */

/* The union of two closed surfaces.
 *
 * CGAL cuts both along the lines where they cross (corefinement), exactly. Those lines part each surface into patches, each wholly outside
 * the other surface, inside, or on it; one point of a patch tells which:
 *
 *     outside                        stays
 *     inside                         goes
 *     on it, looking the same way    stays once
 *     on it, looking at each other   goes, both of them
 *
 * CGAL's own assembly of boolean results (5.5) is not used: it does not come back from some pairs that touch along an edge and a face. */
class summation
{
  public:
    summation(const surface &a, const surface &b) : sides{a, b}
    {
        for (int i = 0; i < 2; i++) cut[i] = sides[i].add_property_map<surface::Edge_index, bool>("e:cut", false).first;
        pmp::corefine(sides[0], sides[1], CGAL::parameters::throw_on_self_intersection(true).edge_is_constrained_map(cut[0]),
                      CGAL::parameters::edge_is_constrained_map(cut[1]));
    }

    /* Returns false when the union is not a manifold. */
    bool result(surface &sum)
    {
        for (int i = 0; i < 2; i++) keep_patches(i);
        if (faces.empty() || !pmp::is_polygon_soup_a_polygon_mesh(faces)) return false;
        pmp::polygon_soup_to_polygon_mesh(points, faces, sum);
        return CGAL::is_closed(sum);
    }

  private:
    using face      = surface::Face_index;
    using inside    = CGAL::Side_of_triangle_mesh<surface, kernel>;
    using primitive = CGAL::AABB_face_graph_triangle_primitive<surface>;
    using tree      = CGAL::AABB_tree<CGAL::AABB_traits<kernel, primitive>>;

    surface                                          sides[2]; /* copies: they are cut */
    surface::Property_map<surface::Edge_index, bool> cut[2];
    std::vector<kernel::Point_3>                     points;
    std::map<kernel::Point_3, size_t>                point_numbers;
    polygons                                         faces;

    static kernel::Triangle_3 triangle_of(const surface &mesh, face f)
    {
        auto h = mesh.halfedge(f);
        return kernel::Triangle_3(mesh.point(mesh.source(h)), mesh.point(mesh.target(h)), mesh.point(mesh.target(mesh.next(h))));
    }

    void keep(const surface &mesh, face f)
    {
        const kernel::Triangle_3   t = triangle_of(mesh, f);
        std::array<std::size_t, 3> corners;
        for (int i = 0; i < 3; i++) {
            const auto found = point_numbers.emplace(t[i], points.size());
            if (found.second) points.push_back(t[i]);
            corners[i] = found.first->second;
        }
        faces.push_back(corners);
    }

    /* A point on the other surface: does that look the same way there? */
    static bool looks_the_same_way(const kernel::Triangle_3 &t, const kernel::Point_3 &p, const surface &other,
                                   const tree &other_faces)
    {
        std::vector<face> met;
        other_faces.all_intersected_primitives(p, std::back_inserter(met));
        for (face f : met) {
            const kernel::Triangle_3 u = triangle_of(other, f);
            const kernel::Vector_3   n = CGAL::normal(u[0], u[1], u[2]), m = CGAL::normal(t[0], t[1], t[2]);
            if (CGAL::cross_product(n, m) == CGAL::NULL_VECTOR) return CGAL::scalar_product(n, m) > 0;
        }
        throw no_patch(); /* it crosses there: then this is no patch */
    }

    void keep_patches(int i)
    {
        const surface &mesh = sides[i], &other = sides[1 - i];
        auto           patch_of = sides[i].add_property_map<face, std::size_t>("f:patch", 0).first;
        const size_t   count    = pmp::connected_components(mesh, patch_of, CGAL::parameters::edge_is_constrained_map(cut[i]));
        tree           other_faces(other.faces().begin(), other.faces().end(), other);
        const inside   side(other_faces);
        enum { unknown, stays, goes };
        std::vector<char> fate(count, unknown);
        for (face f : mesh.faces()) {
            char &its = fate[patch_of[f]];
            if (its == unknown) {
                const kernel::Triangle_3 t     = triangle_of(mesh, f);
                const kernel::Point_3    p     = CGAL::centroid(t);
                const auto               where = side(p);
                const bool               on    = where == CGAL::ON_BOUNDARY; /* the first surface's patch stands for both */
                its = where == CGAL::ON_UNBOUNDED_SIDE || (on && i == 0 && looks_the_same_way(t, p, other, other_faces)) ? stays
                                                                                                                         : goes;
            }
            if (its == stays) keep(mesh, f);
        }
    }
};

/* Parts that have become one solid. */
struct body {
    surface             mesh;
    std::vector<size_t> parts;
};
using bodies = std::vector<body>;

class uniter
{
  public:
    uniter(const mesh_soup &soup, unite_part *all) : s(soup), parts(all) {}

    /* Unite parts [begin, end) of an order, halves first: neighbours are in one half as far as possible. */
    bodies unite(size_t *begin, size_t *end)
    {
        if (begin == end) return {};
        if (end - begin == 1) return load(*begin);
        size_t *middle = begin + (end - begin) / 2;
        split(begin, middle, end);
        bodies left = unite(begin, middle), right = unite(middle, end);
        for (body &b : right) add(left, b);
        return left;
    }

  private:
    const mesh_soup &s;
    unite_part      *parts;

    const double *corner(size_t part, size_t i) const
    {
        return &s.positions_ws[3 * size_t(s.indices[3 * size_t(parts[part].triangles[i / 3]) + i % 3])];
    }

    void split(size_t *begin, size_t *middle, size_t *end) const
    {
        double low[3], high[3];
        for (int axis = 0; axis < 3; axis++) low[axis] = high[axis] = corner(*begin, 0)[axis];
        for (size_t *p = begin; p != end; p++)
            for (int axis = 0; axis < 3; axis++) {
                low[axis]  = std::min(low[axis], corner(*p, 0)[axis]);
                high[axis] = std::max(high[axis], corner(*p, 0)[axis]);
            }
        int longest = 0;
        for (int axis = 1; axis < 3; axis++)
            if (high[axis] - low[axis] > high[longest] - low[longest]) longest = axis;
        std::nth_element(begin, middle, end, [&](size_t a, size_t b) {
            const double p = corner(a, 0)[longest], q = corner(b, 0)[longest];
            return p != q ? p < q : a < b;
        });
    }

    /* One part as a surface; none when it is not one that can be united. */
    bodies load(size_t part)
    {
        std::vector<uint32_t> vertices;
        for (size_t i = 0; i < 3 * parts[part].count; i++)
            vertices.push_back(s.indices[3 * size_t(parts[part].triangles[i / 3]) + i % 3]);
        std::vector<uint32_t> corners = vertices;
        std::sort(vertices.begin(), vertices.end());
        vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());

        std::vector<kernel::Point_3> points;
        for (uint32_t v : vertices) {
            const double *p = &s.positions_ws[3 * size_t(v)];
            points.emplace_back(p[0], p[1], p[2]);
        }
        polygons faces(parts[part].count);
        for (size_t i = 0; i < corners.size(); i++)
            faces[i / 3][i % 3] = size_t(std::lower_bound(vertices.begin(), vertices.end(), corners[i]) - vertices.begin());

        bodies result(1);
        parts[part].outcome = check(points, faces, result[0].mesh);
        if (parts[part].outcome != UNITED) return {};
        result[0].parts.push_back(part);
        return result;
    }

    static unite_outcome check(const std::vector<kernel::Point_3> &points, const polygons &faces, surface &mesh)
    {
        try {
            if (!pmp::is_polygon_soup_a_polygon_mesh(faces)) return UNITE_NOT_MANIFOLD;
            pmp::polygon_soup_to_polygon_mesh(points, faces, mesh);
            if (!CGAL::is_closed(mesh)) return UNITE_NOT_MANIFOLD;
            if (pmp::does_self_intersect(mesh)) return UNITE_CROSSES_ITSELF;
            if (!pmp::does_bound_a_volume(mesh) || !pmp::is_outward_oriented(mesh)) return UNITE_NOT_OUTWARD;
        } catch (const std::bad_alloc &) {
            throw;
        } catch (...) {
            return UNITE_FAILED;
        }
        return UNITED;
    }

    /* Unite a body with one of those that are there, or put it beside them. */
    void add(bodies &all, body &other)
    {
        for (size_t i = 0; i < all.size() && i < attempts_max; i++) {
            surface sum;
            if (!sum_of(all[i].mesh, other.mesh, sum)) continue;
            all[i].mesh = std::move(sum);
            all[i].parts.insert(all[i].parts.end(), other.parts.begin(), other.parts.end());
            return;
        }
        all.push_back(std::move(other));
    }

    static bool sum_of(const surface &a, const surface &b, surface &sum)
    {
        try {
            return summation(a, b).result(sum);
        } catch (const std::bad_alloc &) {
            throw;
        } catch (...) {
            return false;
        }
    }
};

double volume(const double *o, const double *const p[3])
{
    double e[3][3];
    for (int i = 0; i < 9; i++) e[i / 3][i % 3] = p[i / 3][i % 3] - o[i % 3];
    return (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) + e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
            e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
           6;
}

/* The surfaces of bodies, rounded. */
struct rounded {
    std::vector<double>   positions;
    std::vector<uint32_t> indices, result_of;
};

/* Append a body; each vertex is rounded once, so that what was closed stays so. */
void append(rounded &all, surface &mesh, uint32_t result)
{
    const uint32_t first = uint32_t(all.positions.size() / 3);
    mesh.collect_garbage();
    for (auto v : mesh.vertices())
        for (int axis = 0; axis < 3; axis++) all.positions.push_back(CGAL::to_double(CGAL::exact(mesh.point(v)[axis])));
    for (auto f : mesh.faces()) {
        for (auto v : CGAL::vertices_around_face(mesh.halfedge(f), mesh)) all.indices.push_back(first + uint32_t(v));
        all.result_of.push_back(result);
    }
}

/* Is the union as large as its largest part, and no larger than all of them? Rounding is far below a millionth. */
bool has_right_volume(const mesh_soup &s, const unite_part *parts, const body &b, const rounded &all, size_t first)
{
    const double *o   = &all.positions[3 * size_t(all.indices[first])];
    double        sum = 0, largest = 0, now = 0;
    for (size_t part : b.parts) {
        double its = 0;
        for (size_t i = 0; i < parts[part].count; i++) {
            const uint32_t *v    = &s.indices[3 * size_t(parts[part].triangles[i])];
            const double   *p[3] = {&s.positions_ws[3 * size_t(v[0])], &s.positions_ws[3 * size_t(v[1])],
                                    &s.positions_ws[3 * size_t(v[2])]};
            its += volume(o, p);
        }
        sum += its;
        largest = std::max(largest, its);
    }
    for (size_t i = first; i < all.indices.size(); i += 3) {
        const double *p[3] = {&all.positions[3 * size_t(all.indices[i])], &all.positions[3 * size_t(all.indices[i + 1])],
                              &all.positions[3 * size_t(all.indices[i + 2])]};
        now += volume(o, p);
    }
    return now > 0 && now >= largest * (1 - 1e-6) && now <= sum * (1 + 1e-6);
}

template <class number> number *copy_of(const std::vector<number> &from)
{
    number *to = static_cast<number *>(std::malloc((from.size() + 1) * sizeof *to));
    if (!to) throw std::bad_alloc();
    std::copy(from.begin(), from.end(), to);
    return to;
}

void unite(const mesh_soup &s, unite_part *parts, size_t count, unite_result &out)
{
    std::vector<size_t> order(count);
    std::iota(order.begin(), order.end(), size_t(0));
    bodies  all = uniter(s, parts).unite(order.data(), order.data() + count);
    rounded sum;
    for (body &b : all) {
        const size_t positions = sum.positions.size(), corners = sum.indices.size(), triangles = sum.result_of.size();
        bool         good = b.parts.size() > 1;
        if (good) {
            append(sum, b.mesh, uint32_t(out.result_count));
            good = has_right_volume(s, parts, b, sum, corners);
        }
        for (size_t part : b.parts) {
            parts[part].outcome = good ? UNITED : UNITE_FAILED;
            parts[part].result  = uint32_t(out.result_count);
        }
        if (good) {
            out.result_count++;
        } else {
            sum.positions.resize(positions);
            sum.indices.resize(corners);
            sum.result_of.resize(triangles);
        }
    }
    out.vertex_count   = sum.positions.size() / 3;
    out.triangle_count = sum.result_of.size();
    out.positions_ws   = copy_of(sum.positions);
    out.indices        = copy_of(sum.indices);
    out.result_of      = copy_of(sum.result_of);
}
} // namespace

vxs_result mesh_unite(const mesh_soup *s, unite_part *parts, size_t count, unite_result *out)
{
    *out = unite_result();
    try {
        unite(*s, parts, count, *out);
        return VXS_OK;
    } catch (const std::bad_alloc &) {
        unite_result_free(out);
        return VXS_E_MEMORY;
    } catch (...) {
        unite_result_free(out);
        for (size_t i = 0; i < count; i++) parts[i].outcome = UNITE_FAILED;
        return VXS_OK;
    }
}

void unite_result_free(unite_result *r)
{
    std::free(r->positions_ws);
    std::free(r->indices);
    std::free(r->result_of);
    *r = unite_result();
}
