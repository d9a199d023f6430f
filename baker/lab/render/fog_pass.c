/* Fog; see fog_pass.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "runtime/volumes/vxs_air_path.h" /* first: box.h defines a type with the name of one of its variables */

#include "baker/lab/render/fog_pass.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/volumes/vxs_shadow_grid.h"

/* the mesh of a light ---------------------------------------------------------------------------------------------------------- */

/* Read the first shadow depths of the light's rays from the asset.   first  [out] released with free */
static vxs_result read_map(const baked_mesh_options *o, const gl_context *gl, vxs_volumes *volumes, float **first,
                           uint32_t *side_px, run_context *m)
{
    vxs_shadow_depth_map *map    = NULL;
    vxs_result            result = vxs_shadow_depth_map_create(
                   &map, volumes, &(vxs_shadow_depth_map_desc){.baked_number = vxs_baked_number(o->light), .side_px = o->side_px});
    if (result != VXS_OK) return fail(m, result, "OpenGL has no room for a shadow depth map: %s", vxs_result_text(result));
    while (vxs_shadow_depth_map_fill(map, UINT64_MAX)) continue;
    *side_px    = vxs_shadow_depth_map_side_px(map);
    size_t size = sizeof **first * *side_px * *side_px * vxs_shadow_depth_map_layers(map);
    *first      = malloc(size);
    if (*first)
        gl->GetTextureImage(vxs_shadow_depth_map_texture(map), 0, GL_RED, GL_FLOAT, (GLsizei)size, *first);
    else
        result = fail(m, VXS_E_MEMORY, "out of memory for a shadow depth map of %u texels a side", *side_px);
    vxs_shadow_depth_map_destroy(map);
    return result;
}

vxs_result baked_mesh_make(vxs_light_mesh **mesh, const baked_mesh_options *o, const gl_context *gl, const vxs_gl *shadows,
                           vxs_volumes *volumes, run_context *m)
{
    vxs_light_mesh_desc desc   = {.struct_size  = sizeof desc,
                                  .light        = &vxs_gl_constants(shadows)[o->light],
                                  .far_metres   = (float)o->far_metres,
                                  .error_texels = (float)o->error_texels};
    float              *first  = NULL;
    vxs_result          result = read_map(o, gl, volumes, &first, &desc.side_px, m);
    if (result != VXS_OK) return result;

    vxs_light_mesh_size size;
    float              *places  = NULL;
    uint32_t           *corners = NULL;
    desc.first                  = first;
    void *room                  = malloc(vxs_light_mesh_room(&desc) + 1);
    result                      = room ? vxs_light_mesh_plan(&desc, room, &size) : VXS_E_MEMORY;
    if (result == VXS_OK) {
        places  = malloc(3 * sizeof *places * size.vertex_count);
        corners = malloc(3 * sizeof *corners * size.triangle_count);
        result  = VXS_E_MEMORY;
    }
    if (places && corners) {
        vxs_light_mesh_fill(&desc, room, places, corners);
        result = vxs_light_mesh_create(mesh, volumes, places, corners, &size);
    }
    free(places);
    free(corners);
    free(room);
    free(first);
    return result == VXS_OK ? VXS_OK : fail(m, result, "no mesh can be made of light %u: %s", o->light, vxs_result_text(result));
}

/* fog -------------------------------------------------------------------------------------------------------------------------- */

/* Largest side of the map that a mesh is made from, in texels: six such maps take a second. Voxels of a grid along alpha and
 * phi; fewer on a software renderer, which fills the grid for each light in each frame. */
enum { MAP_SIDE = 1024, MESH_SIDE = 1024, GRID_SIDE = 512, GRID_SIDE_SOFTWARE = 256 };

vxs_result fog_pass_create(fog_pass **out, const fog_pass_options *o, const gl_context *gl, vxs_gl *shadows, run_context *m)
{
    vxs_volumes_desc desc = {.struct_size      = sizeof desc,
                             .get_proc_address = gl_lookup,
                             .user             = (void *)(uintptr_t)gl,
                             .shadows          = shadows,
                             .width_px         = o->width,
                             .height_px        = o->height,
                             .has_half         = (uint32_t)o->is_half};
    fog_pass        *p    = calloc(1, sizeof *p);
    *out                  = p;
    if (!p) return fail(m, VXS_E_MEMORY, "out of memory for fog");
    p->options        = *o;
    p->gl             = gl;
    p->shadows        = shadows;
    p->last           = UINT32_MAX;
    p->lights         = calloc(vxs_gl_light_count(shadows), sizeof *p->lights);
    p->meshes         = calloc(vxs_gl_light_count(shadows), sizeof *p->meshes);
    p->maps           = calloc(vxs_gl_light_count(shadows), sizeof *p->maps);
    p->faint          = calloc(vxs_gl_light_count(shadows), sizeof *p->faint);
    p->least          = calloc(vxs_gl_light_count(shadows), sizeof *p->least);
    vxs_result result = VXS_E_MEMORY;
    if (p->lights && p->meshes && p->maps && p->faint && p->least) result = vxs_volumes_create(&p->volumes, &desc);
    if (result != VXS_OK)
        return fail(m, result, "OpenGL cannot draw fog of %u x %u samples: %s", o->width, o->height, vxs_result_text(result));
    if (o->by != FOG_BY_GRID) return VXS_OK;

    uint32_t side = o->grid ? o->grid : gl->backend == GL_BACKEND_OSMESA ? GRID_SIDE_SOFTWARE : GRID_SIDE;
    result = vxs_shadow_grid_create(&p->grid, p->volumes, &(vxs_shadow_grid_desc){.columns = side, .rows = 2 * side, .bits = side});
    p->options.grid = side;
    if (result == VXS_OK) return VXS_OK;
    return fail(m, result, "a shadow grid of %u x %u x %u voxels is larger than what OpenGL has room for", side, 2 * side, side);
}

void fog_pass_destroy(fog_pass *p)
{
    if (!p) return;
    for (uint32_t n = 0; p->meshes && n < vxs_gl_light_count(p->shadows); n++) vxs_light_mesh_destroy(p->meshes[n]);
    for (uint32_t n = 0; p->maps && n < vxs_gl_light_count(p->shadows); n++) vxs_shadow_depth_map_destroy(p->maps[n]);
    vxs_shadow_grid_destroy(p->grid);
    vxs_volumes_destroy(p->volumes);
    free(p->least);
    free(p->faint);
    free(p->maps);
    free(p->meshes);
    free(p->lights);
    free(p);
}

/* frame ------------------------------------------------------------------------------------------------------------------------ */

double fog_pass_far_metres(const fog_pass *p)
{
    return 2 * p->options.size_metres;
}

/* map  NULL: use the baked data */
static vxs_result draw_light(fog_pass *p, const vxs_volumes_light *light, const vxs_shadow_depth_map *map, run_context *m)
{
    uint32_t   n      = light->baked_number - 1;
    vxs_result result = VXS_OK;
    switch (p->lights[n].by) {
    case FOG_BY_MARCH: return vxs_volumes_march(p->volumes, light, map, p->options.steps, VXS_STEPS_EVEN);
    case FOG_BY_ANGLES: return vxs_volumes_march(p->volumes, light, map, p->options.steps, VXS_STEPS_EQUIANGULAR);
    case FOG_BY_GRID: return vxs_volumes_grid(p->volumes, light, map, p->grid, 0);
    case FOG_BY_INTERVALS: break;
    case FOG_BY_MESH:
        if (!p->meshes[n]) {
            /* the mesh extends to 16 scene sizes: rays end 2 sizes from the eye, and a path may move the eye by some sizes */
            const baked_mesh_options o = {
                .light = n, .side_px = MESH_SIDE, .far_metres = 16 * p->options.size_metres, .error_texels = 1};
            result = baked_mesh_make(&p->meshes[n], &o, p->gl, p->shadows, p->volumes, m);
            p->meshes_made += result == VXS_OK;
        }
        return result == VXS_OK ? vxs_volumes_mesh(p->volumes, light, p->meshes[n]) : result;
    }
    return vxs_volumes_intervals_in_pieces(p->volumes, light);
}

static vxs_volumes_light light_of(const fog_pass *p, uint32_t n, const light_emission *emission, double exposure)
{
    const double      radius = 5e-4 * p->options.size_metres; /* airlight is unbounded on a ray through a point light */
    vxs_volumes_light light  = {
         .baked_number = vxs_baked_number(n), .cos_inner = (float)emission->cos_inner, .radius_metres = (float)radius};
    for (int k = 0; k < 3; k++) light.colour[k] = (float)(exposure * emission->colour[k]);
    return light;
}

static int fainter(const void *a, const void *b)
{
    const faint_light *p = a, *q = b;
    if (p->most != q->most) return p->most < q->most ? -1 : 1;
    return p->light < q->light ? -1 : 1;
}

/* Add one light; those left out cost no call and no mesh.   light  its values in libvxs_volumes */
static vxs_result add_light(fog_pass *p, vxs_volumes_light light, const moving_pass *moving, const smoke_pass *smoke,
                            fog_plan *plan, run_context *m)
{
    vxs_moving_casters casters[MOVING_FACES];
    uint32_t           n = light.baked_number - 1, caster_count = moving ? moving_pass_casters(moving, n, casters) : 0;
    vxs_result         result = VXS_OK;

    static const fog_cull_result cull_results[] = {[VXS_NOT_CULLED]       = FOG_DRAWN,
                                                   [VXS_CULLED_FAINT]     = FOG_FAINT,
                                                   [VXS_CULLED_OFFSCREEN] = FOG_OUT_OF_VIEW,
                                                   [VXS_CULLED_CLEAR]     = FOG_CLEAR};
    vxs_pixels                   pixels;
    fog_light_plan              *planned = &p->lights[n];
    *planned = (fog_light_plan){.cull_result = cull_results[vxs_volumes_cull(p->volumes, &light, &pixels)], .by = p->options.by};
    plan->lights[planned->cull_result]++;
    if (planned->cull_result != FOG_DRAWN) return VXS_OK;
    const uint32_t each = p->options.is_half ? 2 : 1;
    planned->share =
        (double)pixels.wide_px * pixels.high_px / (ceil((double)p->options.width / each) * ceil((double)p->options.height / each));
    p->last     = n;
    light.smoke = smoke ? smoke_pass_map(smoke, n) : NULL;

    /* fall back to equiangular steps for lights that the requested method cannot draw correctly: if smoke dims the light, only
     * marches can, since the other methods use closed forms; if casters move in it, intervals and meshes cannot, since they are
     * of the file alone */
    int is_dimmed = light.smoke || (p->options.baked_smoke && p->options.baked_smoke[n]);
    int marches   = planned->by == FOG_BY_MARCH || planned->by == FOG_BY_ANGLES;
    if (is_dimmed && !marches)
        planned->why = "smoke dims it";
    else if (caster_count && !marches && planned->by != FOG_BY_GRID)
        planned->why = "something moves in its light";
    if (planned->why) planned->by = FOG_BY_ANGLES;
    plan->by_angles += planned->why != NULL;

    if (caster_count) { /* join the light's shadow depth map with those of moving casters: light ends at the first of them */
        const vxs_shadow_depth_map_desc desc = {.baked_number = light.baked_number, .side_px = MAP_SIDE, .moves = 1};
        plan->shadow_depth_maps++;
        if (!p->maps[n] && (result = vxs_shadow_depth_map_create(&p->maps[n], p->volumes, &desc)) != VXS_OK) return result;
        if (p->options.streamed) vxs_shadow_depth_map_refill(p->maps[n]);
        vxs_shadow_depth_map_fill(p->maps[n], UINT64_MAX);
        result = vxs_shadow_depth_map_join(p->maps[n], casters, caster_count);
    }
    return result == VXS_OK ? draw_light(p, &light, caster_count ? p->maps[n] : NULL, m) : result;
}

vxs_result fog_pass_begin(fog_pass *p, const vxs_view *view, unsigned depths, const double eye_ws[3], const double ambient[3],
                          run_context *m)
{
    const fog_medium *medium = p->options.medium;
    vxs_volumes_frame frame  = {.anisotropy    = (float)medium->anisotropy,
                                .top_metres    = (float)fmin(medium->top_ws - eye_ws[1], 1e30),
                                .view          = *view,
                                .far_metres    = (float)fog_pass_far_metres(p),
                                .min_radiance  = (float)FOG_FAINTEST,
                                .depth_texture = depths};
    for (int n = 0; n < 3; n++) {
        frame.scattering[n] = (float)medium->scattering[n];
        frame.extinction[n] = (float)medium->extinction[n];
        frame.ambient[n]    = (float)ambient[n];
    }

    vxs_result result = vxs_volumes_begin(p->volumes, &frame);
    return result == VXS_OK ? VXS_OK : fail(m, result, "fog cannot be drawn: %s", vxs_result_text(result));
}

vxs_result fog_pass_draw(fog_pass *p, const light_emission *emissions, const moving_pass *moving, const smoke_pass *smoke,
                         double exposure, fog_plan *plan, run_context *m)
{
    uint32_t   count = vxs_gl_light_count(p->shadows), faint = 0;
    double     sum    = 0;
    vxs_result result = VXS_OK;
    *plan             = (fog_plan){0};
    p->last           = UINT32_MAX;

    /* Lights are left out, faintest first, as long as their sum is at most half of the allowed error, FOG_FAINTEST. The other half
     * is shared equally by the remaining lights: each may skip pixels below its share. */
    for (uint32_t n = 0; n < count; n++) {
        vxs_volumes_light light = light_of(p, n, &emissions[n], exposure);
        p->faint[n]             = (faint_light){n, vxs_volumes_most(p->volumes, &light)};
    }
    qsort(p->faint, count, sizeof *p->faint, fainter);
    while (faint < count && sum + (double)p->faint[faint].most <= 0.5 * FOG_FAINTEST) sum += (double)p->faint[faint++].most;
    for (uint32_t n = 0; n < count; n++)
        p->least[p->faint[n].light] =
            n < faint ? fmaxf(1.001F * p->faint[n].most, 1e-30F) : (float)(0.5 * FOG_FAINTEST / (count - faint));

    if (p->options.is_half) result = vxs_volumes_begin_half(p->volumes);
    for (uint32_t n = 0; n < count && result == VXS_OK; n++) {
        vxs_volumes_light light = light_of(p, n, &emissions[n], exposure);
        light.min_radiance      = p->least[n];
        result                  = add_light(p, light, moving, smoke, plan, m);
    }
    if (result != VXS_OK) return fail(m, result, "fog cannot be drawn: %s", vxs_result_text(result));
    plan->meshes_made = p->meshes_made;
    vxs_volumes_composite(p->volumes);
    return VXS_OK;
}

const vxs_light_mesh *fog_pass_mesh(const fog_pass *p, uint32_t *light)
{
    *light = p->last;
    return p->last != UINT32_MAX ? p->meshes[p->last] : NULL;
}

void fog_pass_left(const fog_pass *p, const double eye_ws[3], const double direction[3], double metres, double left[3])
{
    const fog_medium *medium    = p->options.medium;
    double            in_fog[2] = {0, fmin(metres, fog_pass_far_metres(p))};
    vxs_medium        air       = {.anisotropy = medium->anisotropy};
    memcpy(air.scattering, medium->scattering, sizeof air.scattering);
    memcpy(air.extinction, medium->extinction, sizeof air.extinction);
    if (medium->top_ws < INFINITY) vxs_air_in_fog(eye_ws[1], direction[1], medium->top_ws, in_fog);
    vxs_air_left(&air, fmax(in_fog[1] - in_fog[0], 0), left);
}

vxs_result fog_pass_read_grid(const fog_pass *p, float *dark, run_context *m)
{
    enum { HEAD_BYTES = 128 };
    const int     side  = (int)p->options.grid;
    vxs_grid_size size  = {.columns = side, .rows = 2 * side, .bits = side};
    size_t        bytes = sizeof(uint32_t) * (size_t)vxs_grid_words(&size);
    uint32_t     *words = malloc(bytes);
    if (!words) return fail(m, VXS_E_MEMORY, "out of memory for a shadow grid");
    memset(words, 0, bytes);
    if (p->last != UINT32_MAX) p->gl->GetNamedBufferSubData(vxs_shadow_grid_buffer(p->grid), HEAD_BYTES, (GLsizeiptr)bytes, words);
    for (int row = 0; row < size.rows; row++)
        for (int column = 0; column < size.columns; column++)
            dark[row * side + column] = (float)(1 - vxs_grid_lit_part(words, &size, column, row, 0, size.bits));
    free(words);
    return VXS_OK;
}
