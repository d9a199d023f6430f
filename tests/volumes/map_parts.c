/* Lit parts by the texels of a shadow depth map; see map_parts.h.
 *
 * In light space a ray is a line. Of a sun, planes between columns are u = i; of a punctual light's map, x = c_i z: also planes.
 * Between two cuts that follow each other the ray is in one texel, and its depth is linear.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/map_parts.h"

#include <math.h>

#include "formats/vxs_space.h"

/* A ray in light space, or as a map of a cube sees it. */
typedef struct line {
    double from[3], way[3];
} line;

static line line_in_light(const vxs_light *light, const eye_ray *ray)
{
    line l;
    vxs_ls_from_ws(light, ray->eye, 1, l.from);
    vxs_ls_from_ws(light, ray->direction, 0, l.way);
    return l;
}

static line line_in_map(const shadow_depth_map *map, const line *l, int layer)
{
    line turned = *l;
    if (map->light->kind == VXS_LIGHT_KIND_DIRECTIONAL) return turned;
    vxs_face_from_ls(vxs_face_of_map(map->light, layer), l->from, turned.from);
    vxs_face_from_ls(vxs_face_of_map(map->light, layer), l->way, turned.way);
    return turned;
}

/* Texel coordinate: scale * x + middle of a sun, of x / z of a punctual light. */
static double texels_per_unit(const shadow_depth_map *map)
{
    double coarser = map->side / ldexp(1, (int)map->light->levels);
    return map->light->kind == VXS_LIGHT_KIND_DIRECTIONAL ? coarser : coarser / map->light->texel_metres;
}

static void add_cut(places *cuts, const eye_ray *ray, double from, double way, double at)
{
    double x = (at - from) / way;
    if (x > ray->begin && x < ray->end) places_add(cuts, x);
}

/* Where a line leaves a texel of a map for the next one. */
static void cut_map(const shadow_depth_map *map, const eye_ray *ray, const line *l, places *cuts)
{
    double scale = texels_per_unit(map), baked = ldexp(1, (int)map->light->levels);
    int    is_sun = map->light->kind == VXS_LIGHT_KIND_DIRECTIONAL;
    for (int axis = 0; axis < 2; axis++)
        for (uint32_t i = 0; i <= map->side; i++) {
            double across = (i - (is_sun ? 0 : 0.5 * map->side)) / scale;
            if (is_sun)
                add_cut(cuts, ray, l->from[axis], l->way[axis], across);
            else
                add_cut(cuts, ray, l->from[axis] - across * l->from[2], l->way[axis] - across * l->way[2], 0);
        }
    add_cut(cuts, ray, l->from[2], l->way[2], 0);
    if (is_sun) add_cut(cuts, ray, l->from[2], l->way[2], baked);
}

/* From one map of a cube to the next: |a| = |b|. */
static void cut_cube(const eye_ray *ray, const line *l, places *cuts)
{
    for (int a = 0; a < 3; a++)
        for (int sign = -1; sign <= 1; sign += 2) {
            int b = (a + 1) % 3;
            add_cut(cuts, ray, l->from[a] - sign * l->from[b], l->way[a] - sign * l->way[b], 0);
        }
}

/* The texel that a place of light space is in: its map, and where shadow begins there. Returns 0 where there is none.
 * layer  [out] */
static int texel_of(const shadow_depth_map *map, const double ls[3], int *layer, double *first)
{
    const vxs_light *light = map->light;
    double           p[3] = {ls[0], ls[1], 1}, scale = texels_per_unit(map), middle = 0;
    *layer = 0;
    if (light->kind == VXS_LIGHT_KIND_DIRECTIONAL) {
        if ((light->flags & VXS_LIGHT_BOUNDED) && !(ls[2] >= 0 && ls[2] < ldexp(1, (int)light->levels))) return 0;
    } else {
        *layer = vxs_map_from_ls(light, ls);
        vxs_face_from_ls(vxs_face_of_map(light, *layer), ls, p);
        middle = 0.5 * map->side;
        if (!(p[2] > 0)) return 0;
    }
    double u = middle + scale * p[0] / p[2], v = middle + scale * p[1] / p[2];
    if (!(u >= 0 && v >= 0 && u < map->side && v < map->side)) return 0;
    size_t texel = ((size_t)*layer * map->side + (size_t)v) * map->side + (size_t)u;
    *first       = map->first[texel];
    return 1;
}

static double depth_in_map(const shadow_depth_map *map, const double ls[3], int layer)
{
    double turned[3] = {0, 0, ls[2]};
    if (map->light->kind != VXS_LIGHT_KIND_DIRECTIONAL) vxs_face_from_ls(vxs_face_of_map(map->light, layer), ls, turned);
    return turned[2];
}

int map_lit(const shadow_depth_map *map, const double point[3])
{
    double ls[3], first;
    int    layer;
    vxs_ls_from_ws(map->light, point, 1, ls);
    return !texel_of(map, ls, &layer, &first) || depth_in_map(map, ls, layer) < first;
}

/* What is lit between two cuts that follow each other. */
static void add_texel(const shadow_depth_map *map, const line *l, double begin, double end, lit_parts *parts)
{
    double ls[3], first;
    int    layer;
    for (int n = 0; n < 3; n++) ls[n] = l->from[n] + 0.5 * (begin + end) * l->way[n];
    if (!texel_of(map, ls, &layer, &first)) {
        lit_parts_add(parts, begin, end);
        return;
    }
    line   turned = line_in_map(map, l, layer);
    double meets  = (first - turned.from[2]) / turned.way[2];
    if (turned.way[2] > 0)
        lit_parts_add(parts, begin, fmin(end, meets));
    else if (turned.way[2] < 0)
        lit_parts_add(parts, fmax(begin, meets), end);
    else if (turned.from[2] < first)
        lit_parts_add(parts, begin, end);
}

void map_parts(const void *subject, const eye_ray *ray, lit_parts *parts)
{
    const shadow_depth_map *map  = subject;
    line                    l    = line_in_light(map->light, ray);
    places                  cuts = {0};
    lit_parts_clear(parts);
    places_add(&cuts, ray->begin);
    places_add(&cuts, ray->end);
    for (uint32_t layer = 0; layer < map->layers; layer++) {
        line turned = line_in_map(map, &l, (int)layer);
        cut_map(map, ray, &turned, &cuts);
    }
    if (map->layers > 1) cut_cube(ray, &l, &cuts);
    places_sort(&cuts);
    for (size_t n = 0; n + 1 < cuts.count; n++)
        if (cuts.at[n + 1] > cuts.at[n]) add_texel(map, &l, cuts.at[n], cuts.at[n + 1], parts);
    places_free(&cuts);
}
