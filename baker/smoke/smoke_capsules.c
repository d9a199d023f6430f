/* Smoke as capsules; see smoke_map.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/smoke/smoke_map.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <xxhash.h>

#include "baker/base/array.h"
#include "baker/base/portable_quick.h"
#include "baker/base/vec3.h"
#include "baker/smoke/smoke_grid.h"
#include "formats/vxs_format.h"
#include "formats/vxs_space.h"

void smoke_path_free(smoke_path *p)
{
    free(p->depth);
    free(p->thick);
    free(p->left);
    *p = (smoke_path){0};
}

static int add_point(smoke_path *p, double depth, double thick)
{
    if (!array_reserve(&p->depth, &p->depth_capacity, p->count + 1, sizeof *p->depth)) return 0;
    if (!array_reserve(&p->thick, &p->thick_capacity, p->count + 1, sizeof *p->thick)) return 0;
    if (!array_reserve(&p->left, &p->left_capacity, p->count + 1, sizeof *p->left)) return 0;
    p->depth[p->count]  = depth;
    p->thick[p->count]  = thick;
    p->left[p->count++] = portable_quick_exp(-thick);
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
    if (p->count) add_point(p, depth, thick); /* replaces one behind it, so that there is memory */
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

/* Find the point of gap n that is farthest from its line. */
static void sample_gap(curve *c, uint32_t n)
{
    const smoke_path *p = c->path;
    size_t            a = c->point[n], b = c->point[n + 1];
    double            left = p->left[a], slope = (p->left[b] - left) / (p->depth[b] - p->depth[a]);
    c->far[n] = 0;
    for (size_t k = a + 1; k < b; k++) {
        double off = fabs(p->left[k] - left - slope * (p->depth[k] - p->depth[a]));
        if (off <= c->far[n]) continue;
        c->far[n]   = off;
        c->worst[n] = k;
    }
}

static uint32_t farthest_gap(const curve *c)
{
    uint32_t farthest = 0;
    for (uint32_t n = 1; n + 1 < c->count; n++)
        if (c->far[n] > c->far[farthest]) farthest = n;
    return farthest;
}

uint32_t smoke_path_nodes(const smoke_path *p, const smoke_units *units, double error, uint32_t most, uint32_t *nodes)
{
    if (!p->count || 1 - p->left[p->count - 1] <= error) return 0;
    curve c = {.path = p, .point = {0, p->count - 1}, .count = 2};
    sample_gap(&c, 0);
    for (uint32_t gap = 0; c.count < most && c.far[gap = farthest_gap(&c)] > error;) {
        /* Insert a node in gap n. */
        for (uint32_t k = c.count++; k > gap + 1; k--) {
            c.point[k] = c.point[k - 1];
            c.worst[k] = c.worst[k - 1];
            c.far[k]   = c.far[k - 1];
        }
        c.point[gap + 1] = c.worst[gap];
        sample_gap(&c, gap);
        sample_gap(&c, gap + 1);
    }

    /* Nodes are at whole units, with the transmittance there. The first is not behind the path's begin, the last not before its
     * end. */
    uint32_t count = 0;
    for (uint32_t n = 0; n < c.count; n++) {
        double   unit  = (p->depth[c.point[n]] - units->first_metres) / units->step_metres;
        double   depth = fmin(fmax(n == 0 ? floor(unit) : n + 1 == c.count ? ceil(unit) : round(unit), 0), 65535);
        double   left  = portable_quick_exp(-smoke_path_thick(p, units->first_metres + depth * units->step_metres));
        uint32_t node  = (uint32_t)depth | (uint32_t)lround(left * 65535) << 16;
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
        most = fmax(most, fabs(left / 65535 - p->left[k]));
    }
    return most;
}

static void ends_of(const scene_smoke *smoke, uint32_t n, double begin[3], double end[3])
{
    for (int i = 0; i < 3; i++) {
        begin[i] = smoke->origin_ws[i] + (double)smoke->list[n].begin[i];
        end[i]   = smoke->origin_ws[i] + (double)smoke->list[n].end[i];
    }
}

void smoke_capsules_fingerprint(const scene_smoke *smoke, char text[SMOKE_FINGERPRINT_BYTES])
{
    XXH128_hash_t hash = XXH3_128bits(smoke->origin_ws, sizeof smoke->origin_ws);
    hash               = XXH3_128bits_withSeed(smoke->list, smoke->count * sizeof *smoke->list, hash.low64);
    snprintf(text, SMOKE_FINGERPRINT_BYTES, "%016" PRIx64 "%016" PRIx64, (uint64_t)hash.high64, (uint64_t)hash.low64);
}

/* bins ------------------------------------------------------------------------------------------------------------------------- */

/* Box of a capsule in a map: metres across, down, and along its axis.   box  [out] least, greatest */
static void box_in_map(const scene_smoke *smoke, uint32_t n, const vxs_light *light, int32_t map, double box[2][3])
{
    double ends[2][3], ls[3], at[2][3], radius = (double)smoke->list[n].radius_metres;
    ends_of(smoke, n, ends[0], ends[1]);
    for (int k = 0; k < 2; k++) {
        vxs_ls_from_ws(light, ends[k], 1, ls);
        if (light->kind == VXS_LIGHT_KIND_DIRECTIONAL)
            for (int i = 0; i < 3; i++) at[k][i] = ls[i] * (i < 2 ? light->texel_metres : light->voxel_metres);
        else
            vxs_face_from_ls(vxs_face_of_map(light, map), ls, at[k]);
    }
    for (int i = 0; i < 3; i++) {
        box[0][i] = fmin(at[0][i], at[1][i]) - radius;
        box[1][i] = fmax(at[0][i], at[1][i]) + radius;
    }
}

void smoke_capsule_depths(const scene_smoke *smoke, uint32_t n, const vxs_light *light, int32_t map, double range[2])
{
    double box[2][3];
    box_in_map(smoke, n, light, map, box);
    range[0] = fmin(range[0], box[0][2]);
    range[1] = fmax(range[1], box[1][2]);
}

/* Tiles [first, end) across and down.   Returns 0: none */
static int tiles_of(const scene_smoke *smoke, uint32_t n, const vxs_light *light, uint32_t levels, int32_t map, uint32_t first[2],
                    uint32_t end[2])
{
    double box[2][3], tile = light->texel_metres * ldexp(SMOKE_TILE_PX, (int)(light->levels - levels)),
                      tiles = ldexp(1, (int)levels - 3);
    int is_sun              = light->kind == VXS_LIGHT_KIND_DIRECTIONAL;
    box_in_map(smoke, n, light, map, box);
    if (!is_sun && box[1][2] <= 0) return 0;
    for (int i = 0; i < 2; i++) {
        double low = box[0][i], high = box[1][i];
        if (!is_sun) { /* slopes; a capsule that is beside the light or around it may be anywhere */
            double near = fmax(box[0][2], 0), far = box[1][2];
            low  = fmin(low / near, low / far);
            high = fmax(high / near, high / far);
            if (!(near > 0)) low = -INFINITY, high = INFINITY;
        }
        low      = floor(low / tile + (is_sun ? 0 : tiles / 2) - 1e-6);
        high     = floor(high / tile + (is_sun ? 0 : tiles / 2) + 1e-6) + 1;
        first[i] = (uint32_t)fmin(fmax(low, 0), tiles);
        end[i]   = (uint32_t)fmin(fmax(high, 0), tiles);
    }
    return first[0] < end[0] && first[1] < end[1];
}

/* Count capsules in the entry behind their tile's (if b->capsules is NULL), or store them. */
static void visit(const smoke_bins *b, const scene_smoke *smoke, const vxs_light *light, uint32_t levels)
{
    uint32_t across = 1u << (levels - 3), first[2], end[2];
    for (uint32_t map = 0; map < vxs_map_count(light); map++)
        for (uint32_t n = 0; n < smoke->count; n++) {
            if (!tiles_of(smoke, n, light, levels, (int32_t)map, first, end)) continue;
            for (uint32_t y = first[1]; y < end[1]; y++)
                for (uint32_t x = first[0]; x < end[0]; x++) {
                    size_t *at = &b->first[((size_t)map * across + y) * across + x + 1];
                    if (b->capsules) b->capsules[*at] = n;
                    ++*at;
                }
        }
}

int smoke_bins_make(smoke_bins *b, const scene_smoke *smoke, const vxs_light *light, uint32_t levels)
{
    size_t tiles = (size_t)vxs_map_count(light) << (2 * (levels - 3)), sum = 0;
    b->first = calloc(tiles + 1, sizeof *b->first);
    if (!b->first) return 0;
    visit(b, smoke, light, levels);
    for (size_t n = 1; n <= tiles; n++) { /* the begin of each tile is in the entry behind it, until all capsules are stored */
        size_t count = b->first[n];
        b->first[n]  = sum;
        sum += count;
    }
    if (!(b->capsules = malloc((sum + 1) * sizeof *b->capsules))) return 0;
    visit(b, smoke, light, levels);
    return 1;
}

void smoke_bins_free(smoke_bins *b)
{
    free(b->first);
    free(b->capsules);
    *b = (smoke_bins){0};
}

/* rays ------------------------------------------------------------------------------------------------------------------------- */

/* Extend a part by the ray inside a ball around the origin.   from  of the ray;   way  of length 1;   part  [in, out] */
static void join_ball(const double from[3], const double way[3], double radius, double part[2])
{
    double near = -vec3_dot(from, way), beside[3];
    vec3_mad(from, near, way, beside);
    double inside = radius * radius - vec3_dot(beside, beside);
    if (!(inside > 0)) return;
    part[0] = fmin(part[0], near - sqrt(inside));
    part[1] = fmax(part[1], near + sqrt(inside));
}

/* The same for a cylinder from the origin to `axis`: the part of the ray between its end planes and within its radius. */
static void join_cylinder(const double from[3], const double way[3], const double axis[3], double radius, double part[2])
{
    double u[3], beside[3], turned[3], size = sqrt(vec3_dot(axis, axis));
    if (!vec3_unit(axis, u)) return;
    double along = vec3_dot(from, u), slope = vec3_dot(way, u);
    vec3_mad(from, -along, u, beside);
    vec3_mad(way, -slope, u, turned);
    double square = vec3_dot(turned, turned), near = square > 1e-24 ? -vec3_dot(beside, turned) / square : 0;
    vec3_mad(beside, near, turned, beside);
    double inside = radius * radius - vec3_dot(beside, beside), low = -INFINITY, high = INFINITY;
    if (!(inside > 0)) return;
    if (square > 1e-24) {
        low  = near - sqrt(inside / square);
        high = near + sqrt(inside / square);
    }
    if (slope != 0) {
        low  = fmax(low, fmin(-along / slope, (size - along) / slope));
        high = fmin(high, fmax(-along / slope, (size - along) / slope));
    } else if (along < 0 || along > size) {
        return;
    }
    if (!(high > low)) return;
    part[0] = fmin(part[0], low);
    part[1] = fmax(part[1], high);
}

/* Depth range of a ray in capsule n.   Returns 0: it misses */
static int part_of(const scene_smoke *smoke, uint32_t n, const double from[3], const double way[3], double depths[2])
{
    double begin[3], end[3], unit[3], at[3], axis[3], from_end[3], part[2] = {INFINITY, -INFINITY};
    double length = sqrt(vec3_dot(way, way)), radius = (double)smoke->list[n].radius_metres;
    ends_of(smoke, n, begin, end);
    vec3_sub(end, begin, axis);
    for (int i = 0; i < 3; i++) unit[i] = way[i] / length;
    vec3_sub(from, begin, at);
    double near = -vec3_dot(at, unit); /* all that follows is relative to this point, to avoid cancellation */
    vec3_mad(at, near, unit, at);
    vec3_sub(at, axis, from_end);
    join_ball(at, unit, radius, part);
    join_ball(from_end, unit, radius, part);
    join_cylinder(at, unit, axis, radius, part);
    depths[0] = (near + part[0]) / length;
    depths[1] = (near + part[1]) / length;
    return depths[1] > depths[0];
}

static int add_change(smoke_changes *c, double depth, double loss)
{
    if (!array_reserve(&c->list, &c->capacity, c->count + 1, sizeof *c->list)) return 0;
    c->list[c->count++] = (smoke_change){depth, loss};
    return 1;
}

/* By depth. At equal depths begins come before ends, so that sums stay positive. */
static int by_depth(const void *a, const void *b)
{
    const smoke_change *p = a, *q = b;
    if (p->depth != q->depth) return p->depth < q->depth ? -1 : 1;
    return (p->loss < q->loss) - (p->loss > q->loss);
}

/* Pieces short enough to be linear, as far as light is left; the last piece has all the rest. */
static int add_even(smoke_path *path, double begin, double end, double thick)
{
    double parts = ceil(thick / SMOKE_PIECE);
    int    count = (int)fmin(parts, SMOKE_PARTS_MOST);
    for (int n = 0; n < count; n++) {
        double a = begin + (end - begin) * n / parts, b = n + 1 < count ? begin + (end - begin) * (n + 1) / parts : end;
        if (b > a && !smoke_path_add(path, a, b, thick * (n + 1 < count ? 1 : parts - n) / parts)) return 0;
    }
    return 1;
}

int smoke_capsules_march(const scene_smoke *smoke, const uint32_t *capsules, size_t count, const double from[3],
                         const double way[3], double begin, double end, smoke_changes *scratch, smoke_path *path)
{
    double length = sqrt(vec3_dot(way, way)), loss = 0;
    path->count = scratch->count = 0;
    for (size_t n = 0; n < count; n++) {
        double depths[2], each = length * (double)smoke->list[capsules[n]].extinction;
        if (!part_of(smoke, capsules[n], from, way, depths)) continue;
        depths[0] = fmax(depths[0], begin);
        depths[1] = fmin(depths[1], end);
        if (!(depths[1] > depths[0])) continue;
        if (!add_change(scratch, depths[0], each) || !add_change(scratch, depths[1], -each)) return 0;
    }
    if (scratch->count) qsort(scratch->list, scratch->count, sizeof *scratch->list, by_depth);
    for (size_t n = 0; n + 1 < scratch->count; n++) {
        double a = scratch->list[n].depth, b = scratch->list[n + 1].depth;
        loss += scratch->list[n].loss;
        if (b > a && loss > 0 && !add_even(path, a, b, loss * (b - a))) return 0;
        if (path->count && path->thick[path->count - 1] > SMOKE_OPAQUE) break;
    }
    return 1;
}
