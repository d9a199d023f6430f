/* Data structures of a scene; see scene.h. Loaders fill them; other code only reads them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/portable_math.h"
#include "baker/base/vec3.h"

/* The equivalent coordinate within two periods of the wrap mode, so that pixel numbers fit integers. */
static double reduced(double u, texture_wrap wrap)
{
    if (!isfinite(u)) return 0;
    if (wrap == WRAP_CLAMP) return fmin(fmax(u, -1), 2);
    return u - 2 * floor(0.5 * u);
}

static uint32_t wrapped(int64_t pixel, uint32_t width_px, texture_wrap wrap)
{
    int64_t last = (int64_t)width_px - 1, period = wrap == WRAP_MIRROR ? 2 * (int64_t)width_px : width_px;
    if (wrap == WRAP_CLAMP) return (uint32_t)(pixel < 0 ? 0 : pixel > last ? last : pixel);
    pixel = (pixel % period + period) % period;
    return (uint32_t)(pixel > last ? period - 1 - pixel : pixel);
}

static double between(double a, double b, double share)
{
    return a + share * (b - a);
}

static double alpha_of_pixel(const alpha_mask *mask, const alpha_image *image, int64_t i, int64_t j)
{
    size_t row = wrapped(j, image->height_px, mask->wrap_v), column = wrapped(i, image->width_px, mask->wrap_u);
    return image->alpha[row * image->width_px + column];
}

double alpha_mask_alpha(const alpha_mask *mask, const alpha_image *image, double u, double v)
{
    double x = reduced(u, mask->wrap_u) * image->width_px, y = reduced(v, mask->wrap_v) * image->height_px;
    if (mask->nearest) return alpha_of_pixel(mask, image, (int64_t)floor(x), (int64_t)floor(y));

    double  left = floor(x - 0.5), upper = floor(y - 0.5), share = x - 0.5 - left;
    int64_t i = (int64_t)left, j = (int64_t)upper;
    double  above = between(alpha_of_pixel(mask, image, i, j), alpha_of_pixel(mask, image, i + 1, j), share);
    double  below = between(alpha_of_pixel(mask, image, i, j + 1), alpha_of_pixel(mask, image, i + 1, j + 1), share);
    return between(above, below, y - 0.5 - upper);
}

int alpha_mask_opaque(const alpha_mask *mask, const alpha_image *image, double u, double v)
{
    return (float)(alpha_mask_alpha(mask, image, u, v) / 255) >= mask->threshold;
}

void scene_drop_triangles(scene *s)
{
    free(s->triangle_flags);
    free(s->indices);
    free(s->positions_ws);
    s->triangle_flags = NULL;
    s->indices        = NULL;
    s->positions_ws   = NULL;
    s->triangle_count = s->vertex_count = 0;
}

void scene_free(scene *s)
{
    for (size_t i = 0; i < s->light_count; i++) {
        /* Free the members of a light. */
        free(s->lights[i].name);
        free(s->lights[i].node_name);
        free(s->lights[i].odd);
    }
    free(s->lights);
    for (size_t i = 0; i < s->lost_light_count; i++) {
        free(s->lost_lights[i].name);
        free(s->lost_lights[i].node_name);
        free(s->lost_lights[i].why);
    }
    free(s->lost_lights);
    for (size_t i = 0; i < s->image_count; i++) free(s->images[i].alpha);
    free(s->images);
    for (size_t i = 0; i < s->area_count; i++) free(s->areas[i].texture);
    free(s->areas);
    free(s->parts);
    free(s->names);
    free(s->origins);
    free(s->exclusions);
    free(s->alpha_masks);
    free(s->holed_triangles);
    free(s->material_colours);
    free(s->camera_positions_ws);
    for (size_t i = 0; i < s->view_count; i++) free(s->views[i].name);
    free(s->views);
    free(s->smoke.list);
    free(s->smoke.albedos);
    scene_drop_triangles(s);
    free(s->name);
    memset(s, 0, sizeof *s);
}

const char *exclusion_text(char text[128], const scene_exclusion *e)
{
    switch (e->rule) {
    case EXCLUDED_BY_INCLUDE: return strcpy(text, "no --include names them");
    case EXCLUDED_BY_EXCLUDE: snprintf(text, 128, "--exclude %s", e->pattern); return one_line(text);
    case EXCLUDED_BY_EXTRAS: return strcpy(text, "vxs_cast_shadow is false in their extras");
    case EXCLUDED_AS_SKINNED: return strcpy(text, "skinned, which --skinned rest includes");
    case EXCLUDED_AS_HIDDEN: snprintf(text, 128, "hidden by KHR_node_visibility, %zu nodes", e->nodes); return text;
    case EXCLUDED_AS_BLEND: return strcpy(text, "their materials let light through (--blend)");
    }
    return strcpy(text, "unknown");
}

const char *light_kind_name(light_kind kind)
{
    return kind == LIGHT_DIRECTIONAL ? "directional" : kind == LIGHT_SPOT ? "spot" : "point";
}

int light_reaches(const light_shape *light, const double point_ws[3])
{
    return light_reaches_by(light, portable_cos(light->outer_rad), point_ws);
}

int light_reaches_by(const light_shape *light, double cosine, const double point_ws[3])
{
    if (light->kind == LIGHT_DIRECTIONAL) return 1;
    double to_point[3];
    vec3_sub(point_ws, light->position_ws, to_point);
    double distance = sqrt(vec3_dot(to_point, to_point));
    if (distance > light->range_metres) return 0;
    return light->kind == LIGHT_POINT || vec3_dot(to_point, light->direction_ws) >= distance * cosine;
}

int light_reaches_ball(const light_shape *light, const double middle_ws[3], double radius_metres)
{
    if (light->kind == LIGHT_DIRECTIONAL) return 1;
    double way[3];
    vec3_sub(middle_ws, light->position_ws, way);
    double metres = sqrt(vec3_dot(way, way));
    if (metres - radius_metres > light->range_metres) return 0;
    if (light->kind == LIGHT_POINT || metres <= radius_metres) return 1;
    double cosine = fmax(-1, fmin(1, vec3_dot(way, light->direction_ws) / metres));
    return portable_acos(cosine) - portable_asin(radius_metres / metres) < light->outer_rad;
}
