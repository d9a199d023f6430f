/* Fit the maps of a light; see light_fit.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/light/light_fit.h"

#include <math.h>
#include <string.h>

#include "baker/base/box.h"
#include "baker/base/integer.h"
#include "baker/base/vec3.h"

static void axes_from_direction(double axes[3][3], const double *direction)
{
    static const double up[3] = {0, 1, 0}, east[3] = {1, 0, 0};
    double              v[3];
    vec3_cross(up, direction, axes[0]);
    /* light from straight above has no unique horizontal axis: use world x for u */
    if (vec3_dot(axes[0], axes[0]) < 1e-6) {
        vec3_cross(direction, east, v);
        vec3_cross(v, direction, axes[0]);
    }
    double length = sqrt(vec3_dot(axes[0], axes[0]));
    for (int n = 0; n < 3; n++) axes[0][n] /= length;
    vec3_cross(direction, axes[0], axes[1]);
    memcpy(axes[2], direction, sizeof axes[2]);
}

/* extent  along the axes, metres */
static void extend_along(box *extent, double axes[3][3], const double *point)
{
    box_add(extent, (double[3]){vec3_dot(axes[0], point), vec3_dot(axes[1], point), vec3_dot(axes[2], point)});
}

/* The format stores up to 63 bytes. Longer names are cut between UTF-8 characters. */
static void set_name(vxs_light *light, const char *name, message *m)
{
    size_t length = strlen(name);
    if (length > VXS_LIGHT_NAME_BYTES - 1) {
        length = VXS_LIGHT_NAME_BYTES - 1;
        while (length && ((unsigned char)name[length] & 0xc0) == 0x80) length--;
        warn(m, "light '%s': the name is cut to its first %zu bytes, by which it will be looked up; rename it in the scene", name,
             length);
    }
    memcpy(light->name, name, length);
}

static vxs_result sun_fit(vxs_light *light, const casters *c, const light_fit_desc *desc, double axes[3][3], message *m)
{
    box    extent = box_empty();
    double length[3];
    if (desc->region_ws)
        for (int corner = 0; corner < 8; corner++) {
            const double *b = desc->region_ws;
            extend_along(&extent, axes, (double[3]){b[corner & 1 ? 3 : 0], b[corner & 2 ? 4 : 1], b[corner & 4 ? 5 : 2]});
        }
    else
        for (size_t n = 0; n < c->vertex_count; n++) extend_along(&extent, axes, c->positions_ws + 3 * n);

    vec3_sub(extent.max, extent.min, length);
    double   width = fmax(length[0], length[1]), depth = length[2];
    uint32_t side  = desc->resolution;
    double   texel = desc->texel_metres;
    if (side) {
        texel = fmax(width, depth * 1e-3) / (side - 2);
    } else {
        for (side = 8; side < desc->resolution_max && (side - 2) * texel < width; side *= 2) {}
        if ((side - 2) * texel < width)
            return fail(
                m, VXS_E_ARGUMENT,
                "--texel %g: the scene is %g m wide seen from light '%s', which needs more than %u texels; at least --texel "
                "%s=%.3g",
                texel, width, desc->name, desc->resolution_max, desc->name, 1.005 * width / (desc->resolution_max - 2));
    }
    double voxel = fmax(depth / (side - 3), texel);
    if (desc->region_ws && fmax(width, depth) < texel)
        warn(m,
             "light '%s': --region is %.3g x %.3g m seen from it, and a texel is %.3g m: one voxel holds all; give a smaller "
             "--texel or a larger region",
             desc->name, width, depth, texel);
    if (!(texel > 0) || !isfinite(1 / texel) || !isfinite(width) || !isfinite(depth))
        return fail(m, VXS_E_ARGUMENT, "the casters span %g x %g m seen from light '%s': no map can be fitted to them", width,
                    depth, desc->name);

    light->kind         = VXS_LIGHT_KIND_DIRECTIONAL;
    light->flags        = desc->region_ws ? VXS_LIGHT_BOUNDED : 0;
    light->levels       = log2_u32(side);
    light->texel_metres = texel;
    light->voxel_metres = voxel;

    /* rows of ls_from_ws: casters centred in u and v, one voxel behind the near plane */
    double determinant = 1;
    for (int row = 0; row < 3; row++) {
        double unit   = row < 2 ? texel : voxel;
        double before = row < 2 ? (side - length[row] / texel) / 2 : 1;
        for (int n = 0; n < 3; n++) light->ls_from_ws[row * 4 + n] = axes[row][n] / unit;
        light->ls_from_ws[row * 4 + 3] = before - extent.min[row] / unit;
        determinant /= unit;
    }
    /* the format requires an invertible transform */
    if (!isfinite(determinant) || determinant == 0)
        return fail(m, VXS_E_ARGUMENT, "%s spans %g x %g m seen from light '%s': no map can be fitted to it",
                    desc->region_ws ? "--region" : "the scene", width, depth, desc->name);
    return VXS_OK;
}

vxs_result light_fit(vxs_light *light, const casters *c, const light_fit_desc *desc, message *m)
{
    static const double ahead[3] = {0, 0, 1}; /* a point light's cube is aligned with the world axes */
    double              axes[3][3];
    memset(light, 0, sizeof *light);
    set_name(light, desc->name, m);
    memcpy(light->direction_ws, desc->shape->kind == LIGHT_POINT ? ahead : desc->shape->direction_ws, sizeof light->direction_ws);
    axes_from_direction(axes, light->direction_ws);
    return desc->shape->kind == LIGHT_DIRECTIONAL ? sun_fit(light, c, desc, axes, m) : lamp_fit(light, c, desc, axes, m);
}
