/* Area lights in a frame: the grids of all VPLs, and the light that pixels gather from them; see vxs_area_light.h.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdio.h>

#include "area_state.h"
#include "vxs_air_light.h"
#include "vxs_desc.h"

enum { RUNS = 8, GROUP = 8 };

static uint32_t groups(uint32_t count, uint32_t each)
{
    return (count + each - 1) / each;
}

static vxs_epipolar space_of(const frame_block *f, const area_vpl *vpl, const float anchor[3], const vxs_epipolar_view *view)
{
    double to_vpl[3], normal[3], back[3];
    for (int n = 0; n < 3; n++) {
        to_vpl[n] = (double)vpl->place[n] + (double)anchor[n] - (double)f->eye[n];
        normal[n] = (double)vpl->normal[n];
        back[n]   = -normal[n];
    }
    if (vpl->kind == AREA_FAR) return vxs_epipolar_of_sun(back, view);
    vxs_epipolar space = vxs_epipolar_of_punctual(to_vpl, view);
    if (vpl->kind == AREA_ONE_SIDE) vxs_epipolar_in_cone(&space, normal, 0, space.phi);
    return space;
}

static void put_heads(vxs_area_light *light, const vxs_shadow_depth_map *const *maps, uint32_t runs)
{
    const vxs_volumes *v    = light->volumes;
    vxs_epipolar_view  view = vxs_grid_view_of(&v->frame);
    for (uint32_t n = 0; n < light->count; n++) {
        vxs_epipolar space   = space_of(&v->frame, &light->vpls[n], light->anchor, &view);
        light->vpls[n].grid  = vxs_grid_head_of(&space, &light->size, runs);
        light->vpls[n].baked = maps && maps[n]->is_baked ? (float)(maps[n]->baked + 1) : 0;
    }
    vxs_area_light_put(light, 1);
}

/* Fill the grids by imperfect shadow maps. */
static void fill(const vxs_area_light *light)
{
    vxs_volumes *v      = light->volumes;
    uint32_t     texels = (uint32_t)vxs_grid_words(&light->size) / 4, rows = (uint32_t)light->size.rows;
    v->api.ClearNamedBufferSubData(light->buffer, GL_FORMAT_R32UI, sizeof light->vpls,
                                   (gl_bytes)light->count * 16 * (gl_bytes)texels, GL_FORMAT_RED_INTEGER, GL_TYPE_UNSIGNED_INT,
                                   NULL);
    v->own.area = (area_block){.vpls = light->count, .side_px = light->side_px, .first_word = vxs_area_shadow_depth_maps(light)};
    vxs_volumes_use_storage(v, light->buffer, 0);
    gl_name     program = vxs_volumes_program(v, &(program_texts){.body = &vxs_volumes_text_area_grids_glsl});
    saved_state saved   = vxs_volumes_use(v, program, 0, 0, 0);
    vxs_volumes_dispatch(v, groups(AREA_BITS, 32), groups(rows, 4), light->count);
    vxs_volumes_restore(v, &saved);
    vxs_or_scan_run(&light->scan, light->buffer, sizeof light->vpls / 16, (uint32_t)light->size.columns, rows * light->count);
}

/* Make a VPL's shadow depth map that of the frame. All pixels of the view are drawn, because a VPL of an area light has no
 * range. */
static void set_map(const vxs_area_light *light, uint32_t vpl, const vxs_shadow_depth_map *map)
{
    vxs_volumes      *v   = light->volumes;
    vxs_volumes_light of  = {.constants = vxs_shadow_depth_map_constants(map), .radius_metres = light->vpls[vpl].radius_metres};
    vxs_pixels        all = v->frame.pixels;
    vxs_volumes_set_light(v, &of, map);
    v->frame.pixels = all;
}

/* Fill the grids by shadow depth maps, one after the other, through the grid of vxs_shadow_grid. */
static void fill_exactly(vxs_area_light *light, const vxs_shadow_depth_map *const *maps, uint32_t runs)
{
    const vxs_volumes *v     = light->volumes;
    gl_bytes           bytes = 4 * (gl_bytes)vxs_grid_words(&light->size);
    for (uint32_t n = 0; n < light->count; n++) {
        const area_vpl *vpl = &light->vpls[n];
        set_map(light, n, maps[n]);
        vxs_shadow_grid_make(light->exact, vxs_shadow_depth_map_texture(maps[n]), runs);
        gl_name from = vxs_shadow_grid_buffer(light->exact);
        v->api.CopyNamedBufferSubData(from, light->buffer, 0, (gl_bytes)(n * sizeof *vpl), sizeof vpl->grid);
        v->api.CopyNamedBufferSubData(from, light->buffer, sizeof vpl->grid, (gl_bytes)sizeof light->vpls + (gl_bytes)n * bytes,
                                      bytes);
    }
}

/* Run a program, which smoke dims where there is some, on the given number of pixels.   map  a texture; 0: none */
static void gather_by(const vxs_area_light *light, const char *names, const volumes_text *text, gl_name map,
                      unsigned normal_texture, uint32_t wide, uint32_t high)
{
    vxs_volumes *v       = light->volumes;
    int          dims    = light->smoke != AREA_CLEAR;
    gl_name      program = dims ? vxs_transmittance_program(&light->curves, names, text)
                                : vxs_volumes_program(v, &(program_texts){.names = names, .body = text});
    vxs_volumes_use_storage(v, light->buffer, 0);
    if (dims) vxs_area_light_use_curves(light);
    saved_state saved = vxs_volumes_use(v, program, map, light->gathered, GL_FORMAT_RGBA32F);
    v->api.ActiveTexture(GL_UNIT_0 + v->first_unit + UNIT_OTHER);
    v->api.BindTexture(GL_TARGET_TEXTURE_2D, normal_texture);
    vxs_volumes_dispatch(v, groups(wide, GROUP), groups(high, GROUP), 1);
    vxs_volumes_restore(v, &saved);
}

/* Whether nothing in the air scatters light, so that grids are not needed. */
static int is_clear(const frame_block *f)
{
    return f->scattering[0] == 0 && f->scattering[1] == 0 && f->scattering[2] == 0;
}

/* Pixels of the view across one gathered pixel. */
static uint32_t each_of(vxs_area_gather gather)
{
    return gather == VXS_AREA_QUARTER ? 2 : 1;
}

static int emits(const vxs_area_light *light, int how)
{
    for (uint32_t n = 0; n < light->count; n++)
        if (light->vpls[n].kind == (float)how) return 1;
    return 0;
}

/* Gather the air's light, or that of surfaces: a program for each way in which VPLs emit. What smoke and fog need is in it only
 * where a frame has them, because drivers compile all that a program calls into one function. */
static void gather_layer(const vxs_area_light *light, const vxs_area_look *look, int is_air, uint32_t wide, uint32_t high)
{
    vxs_volumes *v       = light->volumes;
    v->own.area.is_added = 0;
    for (int how = AREA_ALL_SIDES; how <= AREA_FAR; how++) {
        char names[PROGRAM_NAMES];
        if (!emits(light, how)) continue;
        snprintf(names, sizeof names, AREA_GATHERS "%s%s%s%s#define VXS_AREA_EMITS %d.0\n#define VXS_ONLY_KIND %d\n",
                 is_air ? "#define VXS_AREA_AIR\n" : "", is_air && look->maps ? AREA_TAKES_MAPS : "",
                 v->frame.top_metres < (float)VXS_AIR_EVERYWHERE ? "" : "#define VXS_ONLY_EVERYWHERE\n",
                 how == AREA_ONE_SIDE ? "#define VXS_AIR_FACES\n" : "", how,
                 how == AREA_FAR ? VXS_LIGHT_KIND_DIRECTIONAL : VXS_LIGHT_KIND_POINT);
        gather_by(light, names, &vxs_volumes_text_area_gather_glsl, 0, look->normal_texture, wide, high);
        v->own.area.is_added = 1;
    }
}

/* Add the light of one VPL after the other on surfaces, by shadow depth maps. */
static void gather_exactly(const vxs_area_light *light, const vxs_area_look *look, uint32_t wide, uint32_t high)
{
    vxs_volumes *v = light->volumes;
    for (uint32_t n = 0; n < light->count; n++) {
        set_map(light, n, look->maps[n]);
        v->own.area.vpl      = n;
        v->own.area.is_added = n > 0;
        gather_by(light, AREA_GATHERS AREA_TAKES_MAPS, &vxs_volumes_text_area_exact_glsl,
                  vxs_shadow_depth_map_texture(look->maps[n]), look->normal_texture, wide, high);
    }
}

static void gather(const vxs_area_light *light, const vxs_area_look *look, uint32_t runs)
{
    vxs_volumes *v    = light->volumes;
    uint32_t     each = each_of(look->gather), wide = groups((uint32_t)v->frame.wide_px, each),
             high     = groups((uint32_t)v->frame.high_px, each);
    v->own.area       = (area_block){.vpls         = light->count,
                                     .side_px      = light->side_px,
                                     .first_word   = vxs_area_shadow_depth_maps(light),
                                     .gather       = look->gather,
                                     .wide_px      = wide,
                                     .high_px      = high,
                                     .runs         = (int32_t)runs,
                                     .between_rows = !look->is_sharp};
    v->curves.side_px = light->curves.side_px;
    if (!is_clear(&v->frame)) gather_layer(light, look, 1, wide, high);
    if (look->normal_texture && look->maps)
        gather_exactly(light, look, wide, high);
    else if (look->normal_texture)
        gather_layer(light, look, 0, wide, high);
}

void vxs_area_light_show(const vxs_area_light *light, vxs_area_gather gather, uint32_t layer, gl_name image, int is_added)
{
    vxs_volumes *v    = light->volumes;
    uint32_t     each = each_of(gather);
    v->own.area       = (area_block){.gather   = gather,
                                     .wide_px  = groups((uint32_t)v->frame.wide_px, each),
                                     .high_px  = groups((uint32_t)v->frame.high_px, each),
                                     .layer    = layer,
                                     .is_added = is_added != 0};
    gl_name program   = vxs_volumes_program(v, &(program_texts){.body = &vxs_volumes_text_area_show_glsl});
    vxs_volumes_run(v, program, light->gathered, image, groups((uint32_t)v->frame.wide_px, GROUP),
                    groups((uint32_t)v->frame.high_px, GROUP));
}

static int are_maps(const vxs_area_light *light, const vxs_shadow_depth_map *const *maps)
{
    for (uint32_t n = 0; n < light->count; n++)
        if (light->vpls[n].kind == AREA_FAR || !maps[n] ||
            vxs_shadow_depth_map_constants(maps[n])->kind == VXS_LIGHT_KIND_DIRECTIONAL)
            return 0;
    return light->exact != NULL;
}

vxs_result vxs_volumes_area(vxs_volumes *v, vxs_area_light *light, const vxs_area_look *given)
{
    vxs_area_look        known = {0};
    const vxs_area_look *look  = &known;
    const size_t         first = offsetof(vxs_area_look, maps) + sizeof known.maps;
    if (vxs_desc_take(&known, sizeof known, first, given) != VXS_OK) return VXS_E_ARGUMENT;
    uint32_t runs = look->runs ? look->runs : RUNS;
    if (!v->depth_texture || v->is_half || !light->count || runs > AREA_BITS || (unsigned)look->gather > VXS_AREA_QUARTER)
        return VXS_E_ARGUMENT;
    if (light->smoke == AREA_DIMMED_BEFORE && !v->is_warming) return VXS_E_ARGUMENT;
    if (look->maps ? !are_maps(light, look->maps) : !light->is_cast && !v->is_warming) return VXS_E_ARGUMENT;
    v->frame.pixels     = (vxs_pixels){0, 0, (uint32_t)v->frame.wide_px, (uint32_t)v->frame.high_px};
    saved_storage saved = vxs_volumes_save_storage(v);
    put_heads(light, look->maps, runs);
    if (!is_clear(&v->frame)) {
        if (look->maps)
            fill_exactly(light, look->maps, runs);
        else
            fill(light);
    }
    gather(light, look, runs);
    if (!is_clear(&v->frame)) vxs_area_light_show(light, look->gather, 0, v->airlight, 1);
    if (look->normal_texture) vxs_area_light_show(light, look->gather, 1, light->irradiance, 0);
    vxs_volumes_restore_storage(v, &saved);
    return vxs_volumes_done(v);
}
