/* Filling holes with CGAL; see mesh_repair.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/mend/mesh_repair.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <vector>

namespace
{
using kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using point  = kernel::Point_3;

point point_at(const double *points, size_t i)
{
    return point(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
}

/* The face type that CGAL requires. */
struct face {
    face(int a, int b, int c) : corners{a, b, c} {}
    std::array<int, 3> corners;
};

bool is_crack(const double *points, size_t count)
{
    const point a = point_at(points, 0), b = point_at(points, 1);
    for (size_t i = 2; i < count; i++)
        if (!CGAL::collinear(a, b, point_at(points, i))) return false;
    return true;
}

bool fill_hole(const double *points, size_t count, uint32_t *triangles)
{
    std::vector<face> faces;
    if (count == 3 || is_crack(points, count)) {
        for (int i = 1; i + 1 < int(count); i++) faces.emplace_back(0, i, i + 1);
    } else {
        std::vector<point> line;
        for (size_t i = 0; i < count; i++) line.push_back(point_at(points, i));
        CGAL::Polygon_mesh_processing::triangulate_hole_polyline(line, std::back_inserter(faces));
    }
    if (faces.size() != count - 2) return false;
    for (const face &f : faces)
        for (int corner : f.corners) *triangles++ = uint32_t(corner);
    return true;
}

/* Check that n - 2 triangles have each side of the polygon once, and all other sides in both directions. */
bool runs_along(size_t count, const uint32_t *triangles)
{
    std::vector<std::pair<uint32_t, uint32_t>> sides;
    for (size_t i = 0; i < 3 * (count - 2); i++) {
        const uint32_t from = triangles[i], to = triangles[i % 3 == 2 ? i - 2 : i + 1];
        if (from >= count || to >= count || from == to) return false;
        if (to != (from + 1) % count) sides.emplace_back(from, to);
    }
    std::sort(sides.begin(), sides.end());
    for (const auto &side : sides)
        if (!std::binary_search(sides.begin(), sides.end(), std::make_pair(side.second, side.first))) return false;
    return sides.size() == 2 * (count - 3) && std::adjacent_find(sides.begin(), sides.end()) == sides.end();
}
} // namespace

int mesh_is_crack(const double *points, size_t count)
{
    return is_crack(points, count);
}

int mesh_fill_hole(const double *points, size_t count, uint32_t *triangles)
{
    try {
        if (!fill_hole(points, count, triangles)) return 0;
        if (runs_along(count, triangles)) return 1;
        for (size_t i = 0; i < count - 2; i++) std::swap(triangles[3 * i + 1], triangles[3 * i + 2]);
        return runs_along(count, triangles);
    } catch (...) {
        return 0;
    }
}
