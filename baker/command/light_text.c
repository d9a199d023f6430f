/* A baked light as text and as JSON; see light_text.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/light_text.h"

#include <math.h>
#include <stdio.h>

#include "baker/base/portable_math.h"
#include "baker/files/json_file.h"
#include "baker/light/map_space.h"

static double far_metres(const vxs_light *l)
{
    return l->near_metres * portable_exp(ldexp(l->voxel_metres, (int)l->levels));
}

/* From edge to edge. */
static double cone_degrees(const light_shape *s)
{
    return 2 * s->outer_rad * 180 / 3.14159265358979323846;
}

/* "(1, 0, -2.5)". Values that rounding left close to zero are printed as 0. */
static const char *vector_text(char text[64], const double v[3])
{
    double tidy[3];
    for (int i = 0; i < 3; i++) tidy[i] = fabs(v[i]) < 1e-9 ? 0 : v[i];
    snprintf(text, 64, "(%.6g, %.6g, %.6g)", tidy[0], tidy[1], tidy[2]);
    return text;
}

const char *light_text(char *text, const vxs_light *light)
{
    light_shape s    = baked_light_shape(light);
    unsigned    side = 1u << light->levels;
    char        shape[LIGHT_TEXT_BYTES / 2];
    if (s.kind == LIGHT_DIRECTIONAL) {
        snprintf(text, LIGHT_TEXT_BYTES, "directional %s, %u x %u texels of %.4g m, voxels %.4g m deep",
                 vector_text(shape, s.direction_ws), side, side, light->texel_metres, light->voxel_metres);
        return text;
    }

    /* Position and range of a spot or point light. */
    size_t size = sizeof shape;
    char   at[64], way[64], cone[128] = "", range[32] = "no range";
    if (s.kind == LIGHT_SPOT)
        snprintf(cone, sizeof cone, " towards %s, cone of %.4g degrees", vector_text(way, s.direction_ws), cone_degrees(&s));
    if (isfinite(s.range_metres)) snprintf(range, sizeof range, "range %.6g m", s.range_metres);
    snprintf(shape, size, "%s at %s%s, %s, from %.4g to %.4g m", light_kind_name(s.kind), vector_text(at, s.position_ws), cone,
             range, light->near_metres, far_metres(light));

    snprintf(text, LIGHT_TEXT_BYTES, "%s, %s%u x %u texels of %.4g m a metre away, voxels %.4g m deep there", shape,
             light->flags & VXS_LIGHT_CUBE ? "six maps of " : "", side, side, light->texel_metres, light->voxel_metres);
    return text;
}

json_t *light_json(const vxs_light *light)
{
    light_shape s = baked_light_shape(light);
    json_t *json = json_pack("{s:o, s:s, s:o, s:I, s:i, s:f, s:f}", "name", json_text(light->name), "kind", light_kind_name(s.kind),
                             "direction", json_vector(s.direction_ws), "resolution_px", (json_int_t)1 << light->levels, "maps",
                             light->flags & VXS_LIGHT_CUBE ? 6 : 1, "texel_m", light->texel_metres, "voxel_m", light->voxel_metres);
    if (!json || s.kind == LIGHT_DIRECTIONAL) return json;
    json_object_set_new(json, "position_m", json_vector(s.position_ws));
    json_object_set_new(json, "near_m", json_real(light->near_metres));
    json_object_set_new(json, "far_m", json_real(far_metres(light)));
    if (isfinite(s.range_metres)) json_object_set_new(json, "range_m", json_real(s.range_metres));
    if (s.kind == LIGHT_SPOT) json_object_set_new(json, "cone_degrees", json_real(cone_degrees(&s)));
    return json;
}
