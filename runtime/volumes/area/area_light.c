/* Area lights: create, VPLs, and their imperfect shadow maps; see vxs_area_light.h.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#include "area_state.h"
#include "vxs_desc.h"

_Static_assert(sizeof(area_vpl) == 192, "a VPL is twelve texels");

enum { VPLS = VXS_VPLS_MAX, SIDE = 128, SIDE_MOST = 256, FILL_LEVELS = 5 };

/* Relative to the width of what a point represents: the width of a drawn point, and the largest width of a texel of the coarsest
 * level from which gaps between points are filled. */
#define POINT_WIDE 1.5F
#define GAP_WIDE   2.0F

/* Distance between drawn points where they are dense, in texels. */
#define POINTS_APART 0.5F

static uint32_t words_of_map(uint32_t side)
{
    return (4 * side * side - 1) / 3;
}

uint32_t vxs_area_shadow_depth_maps(const vxs_area_light *light)
{
    return light->most * (uint32_t)vxs_grid_words(&light->size);
}

static uint64_t bytes_of(const vxs_area_light *light)
{
    return sizeof light->vpls +
           4 * ((uint64_t)vxs_area_shadow_depth_maps(light) + (uint64_t)light->most * words_of_map(light->side_px));
}

static vxs_result make(vxs_area_light *light, const vxs_area_light_desc *desc)
{
    vxs_volumes *v      = light->volumes;
    vxs_result   result = vxs_or_scan_create(&light->scan, v, 0);
    if (result != VXS_OK) return result;
    light->buffer     = vxs_volumes_buffer(v, bytes_of(light));
    light->gathered   = vxs_volumes_texture(v, GL_FORMAT_RGBA32F, v->width_px, v->height_px, 2);
    light->irradiance = vxs_volumes_texture(v, GL_FORMAT_RGBA32F, v->width_px, v->height_px, 0);
    if (!light->buffer || !light->gathered || !light->irradiance) return VXS_E_MEMORY;
    v->api.ClearTexImage(light->irradiance, 0, GL_FORMAT_RGBA, GL_TYPE_FLOAT, NULL);
    vxs_shadow_grid_desc grid = {.columns = (uint32_t)light->size.columns, .rows = (uint32_t)light->size.rows, .bits = AREA_BITS};
    if (desc->takes_maps) result = vxs_shadow_grid_create(&light->exact, v, &grid);
    return result == VXS_OK && desc->capsules ? vxs_area_light_take_smoke(light, desc) : result;
}

vxs_result vxs_area_light_create(vxs_area_light **out, vxs_volumes *v, const vxs_area_light_desc *desc)
{
    vxs_area_light_desc known = {0};
    const size_t        first = offsetof(vxs_area_light_desc, smoke_nodes) + sizeof known.smoke_nodes;
    int                 most  = 0;
    *out                      = NULL;
    if (vxs_desc_take(&known, sizeof known, first, desc) != VXS_OK) return VXS_E_ARGUMENT;
    uint32_t side = known.side_px ? known.side_px : SIDE, columns = known.columns ? known.columns : SIDE,
             rows = known.rows ? known.rows : SIDE;
    if (known.vpls > VPLS || side < 32 || side > SIDE_MOST || (side & (side - 1))) return VXS_E_ARGUMENT;
    if (columns > SIDE_MOST || rows > SIDE_MOST) return VXS_E_ARGUMENT;
    vxs_area_light *light = vxs_volumes_alloc(v, sizeof *light);
    if (!light) return VXS_E_MEMORY;
    memset(light, 0, sizeof *light);
    light->volumes = v;
    light->size    = (vxs_grid_size){(int)columns, (int)rows, AREA_BITS};
    light->most    = known.vpls ? known.vpls : VPLS;
    light->side_px = side;
    v->api.GetIntegerv(GL_MOST_STORAGE_BYTES, &most);
    vxs_result result =
        bytes_of(light) > (uint32_t)most
            ? vxs_volumes_fail(v, VXS_E_GL,
                               "an area light is larger than a storage buffer of this context: use fewer vpls, columns or rows")
            : make(light, &known);
    if (result == VXS_OK)
        *out = light;
    else
        vxs_area_light_destroy(light);
    return result;
}

void vxs_area_light_destroy(vxs_area_light *light)
{
    if (!light) return;
    const vxs_volumes *v = light->volumes;
    if (light->buffer) v->api.DeleteBuffers(1, &light->buffer);
    if (light->gathered) v->api.DeleteTextures(1, &light->gathered);
    if (light->irradiance) v->api.DeleteTextures(1, &light->irradiance);
    if (light->scan.volumes) vxs_or_scan_destroy(&light->scan);
    vxs_shadow_grid_destroy(light->exact);
    if (light->curves.volumes) vxs_transmittance_free(&light->curves);
    vxs_volumes_free(v, light, sizeof *light);
}

unsigned vxs_area_light_irradiance(const vxs_area_light *light)
{
    return light->irradiance;
}

/* VPLs ------------------------------------------------------------------------------------------------------------------------ */

static float kind_of(const vxs_vpl *vpl)
{
    static const float none[3] = {0, 0, 0};
    return vpl->is_far ? AREA_FAR : memcmp(vpl->normal, none, sizeof none) ? AREA_ONE_SIDE : AREA_ALL_SIDES;
}

/* Returns 0 if it is not a valid VPL. */
static int vpl_of(const vxs_vpl *from, area_vpl *to)
{
    float square = 0;
    int   least  = 0;
    for (int n = 0; n < 3; n++) {
        square += from->normal[n] * from->normal[n];
        if (fabsf(from->normal[n]) < fabsf(from->normal[least])) least = n;
        if (!isfinite(from->place[n]) || !(from->colour[n] >= 0) || !isfinite(from->colour[n])) return 0;
    }
    if (!(from->radius_metres > 0) || !isfinite(from->radius_metres)) return 0;
    if ((square != 0 || from->is_far) && !(fabsf(square - 1) < 1e-3F)) return 0;
    *to = (area_vpl){.radius_metres = from->radius_metres, .kind = kind_of(from)};
    memcpy(to->place, from->place, sizeof to->place);
    memcpy(to->normal, from->normal, sizeof to->normal);
    memcpy(to->colour, from->colour, sizeof from->colour);
    double across[3], normal[3], axis[3] = {least == 0, least == 1, least == 2};
    for (int n = 0; n < 3; n++) normal[n] = (double)from->normal[n];
    vxs_epipolar_cross(axis, normal, across);
    vxs_epipolar_unit(across);
    for (int n = 0; n < 3; n++) to->across[n] = (float)across[n];
    return 1;
}

static int is_where_it_was(const area_vpl *before, const vxs_vpl *vpl)
{
    return !memcmp(before->place, vpl->place, sizeof before->place) &&
           !memcmp(before->normal, vpl->normal, sizeof before->normal) && before->radius_metres == vpl->radius_metres &&
           (before->kind == AREA_FAR) == (vpl->is_far != 0);
}

vxs_result vxs_area_light_set(vxs_area_light *light, const vxs_vpl *vpls, uint32_t count)
{
    area_vpl unused;
    if (!count || count > light->most) return VXS_E_ARGUMENT;
    for (uint32_t n = 0; n < count; n++)
        if (!vpl_of(&vpls[n], &unused)) return VXS_E_ARGUMENT;
    int stays = count == light->count;
    for (uint32_t n = 0; n < count; n++) {
        stays = stays && is_where_it_was(&light->vpls[n], &vpls[n]);
        vpl_of(&vpls[n], &light->vpls[n]);
    }
    if (!stays) light->is_cast = 0;
    if (!stays && light->smoke == AREA_DIMMED) light->smoke = AREA_DIMMED_BEFORE;
    light->count = count;
    return VXS_OK;
}

int vxs_area_light_is_cast(const vxs_area_light *light)
{
    return light->is_cast;
}

vxs_result vxs_area_light_anchor(vxs_area_light *light, const float place[3])
{
    for (int n = 0; n < 3; n++)
        if (!isfinite(place[n])) return VXS_E_ARGUMENT;
    memcpy(light->anchor, place, sizeof light->anchor);
    return VXS_OK;
}

void vxs_area_light_put(vxs_area_light *light, int from_origin)
{
    for (uint32_t n = 0; n < light->count && from_origin; n++) {
        light->placed[n] = light->vpls[n];
        for (int i = 0; i < 3; i++) light->placed[n].place[i] += light->anchor[i];
    }
    vxs_volumes_put(light->volumes, light->buffer, 0, light->count * sizeof *light->vpls,
                    from_origin ? light->placed : light->vpls);
}

/* imperfect shadow maps -------------------------------------------------------------------------------------------------------- */

static void clear(const vxs_area_light *light)
{
    static const uint32_t none  = UINT32_MAX;
    gl_bytes              first = (gl_bytes)(sizeof light->vpls + 4 * (size_t)vxs_area_shadow_depth_maps(light));
    light->volumes->api.ClearNamedBufferSubData(light->buffer, GL_FORMAT_R32UI, first,
                                                (gl_bytes)light->count * 4 * (gl_bytes)words_of_map(light->side_px),
                                                GL_FORMAT_RED_INTEGER, GL_TYPE_UNSIGNED_INT, &none);
}

static void splat(const vxs_area_light *light, const vxs_area_casters *casters)
{
    enum { GROUP = 64, ACROSS = 32768 };
    vxs_volumes *v      = light->volumes;
    uint32_t     groups = casters->count / GROUP + (casters->count % GROUP != 0), across = groups < ACROSS ? groups : ACROSS;
    v->own.area = (area_block){.vpls         = light->count,
                               .side_px      = light->side_px,
                               .first_word   = vxs_area_shadow_depth_maps(light),
                               .points       = casters->count,
                               .is_whole     = casters->is_whole != 0,
                               .point_wide   = POINT_WIDE,
                               .gap_wide     = GAP_WIDE,
                               .points_apart = POINTS_APART};
    vxs_volumes_use_storage(v, light->buffer, casters->buffer);
    gl_name program = vxs_volumes_program(v, &(program_texts){.body = &vxs_volumes_text_area_splat_glsl});
    vxs_volumes_run(v, program, 0, 0, across, (groups + across - 1) / across);
}

int vxs_area_light_has_sides(const vxs_area_light *light)
{
    for (uint32_t n = 0; n < light->count; n++)
        if (light->vpls[n].kind == AREA_ALL_SIDES) return 0;
    return light->count > 0;
}

vxs_result vxs_area_light_cast(vxs_area_light *light, const vxs_area_casters *casters)
{
    vxs_volumes *v = light->volumes;
    if (!vxs_area_light_has_sides(light) || (casters->count && !casters->buffer)) return VXS_E_ARGUMENT;
    saved_storage saved = vxs_volumes_save_storage(v);
    vxs_area_light_put(light, 0);
    clear(light);
    if (casters->count) splat(light, casters);
    v->own.area = (area_block){
        .vpls = light->count, .levels = FILL_LEVELS, .side_px = light->side_px, .first_word = vxs_area_shadow_depth_maps(light)};
    vxs_volumes_use_storage(v, light->buffer, 0);
    gl_name program = vxs_volumes_program(v, &(program_texts){.body = &vxs_volumes_text_area_pull_push_glsl});
    vxs_volumes_run(v, program, 0, 0, light->count, 1);
    vxs_volumes_restore_storage(v, &saved);
    vxs_result result = vxs_volumes_done(v);
    light->is_cast    = result == VXS_OK && !v->is_warming;
    return result;
}
