/* Frames lit by many lights, and in fog; see gpu_bench.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/bench/gpu_bench.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "runtime/volumes/vxs_volumes.h"
#include "tests/volumes/rival_froxels.h"

/* lists of lights -------------------------------------------------------------------------------------------------------------- */

enum { LIST_LIGHTS = 64 };

typedef struct culling {
    vxs_gl         *shadows;
    const gpu_view *view;
} culling;

static vxs_result cull_frame(gpu_bench *b, void *user)
{
    const culling *c = user;
    (void)b;
    return vxs_gl_cull(c->shadows, &c->view->view, c->view->depths, LIST_LIGHTS);
}

#define LISTED                                                                                                                     \
    "float answer_of(ivec2 pixel, vec3 at, vec3 normal)\n{\n"                                                                      \
    "    float lit  = 0.0;\n"                                                                                                      \
    "    uint  tile = vxs_tile_of(pixel), count = vxs_tile_light_count(tile);\n"

static const char listed_body[] = LISTED "    return float(count);\n}\n";
static const char lights_body[] =
    LISTED "    for (uint n = 0u; n < count; n++) lit += max(vxs_lit_by(vxs_tile_light(tile, n), at, normal, FILTER), 0.0);\n"
           "    return lit;\n}\n";
static const char unlisted_body[] =
    "float answer_of(ivec2 pixel, vec3 at, vec3 normal)\n{\n"
    "    float lit = 0.0;\n"
    "    for (uint n = 0u; n < vxs_light_count(); n++) lit += max(vxs_lit_by(n, at, normal, FILTER), 0.0);\n"
    "    return lit;\n}\n";

/* Without lists is what lists are compared with: the same light. */
static const struct {
    const char *name, *body;
    gpu_filter  filter;
    int         is_counted;
} lit_frames[] = {{"all lights, 9 x 9 box (rival)", unlisted_body, GPU_BOX_9, 0},
                  {"reading lists alone", listed_body, GPU_TAP, 1},
                  {"lists, 1 tap", lights_body, GPU_TAP, 0},
                  {"lists, 9 x 9 box", lights_body, GPU_BOX_9, 0},
                  {"lists, 9 x 9 smooth", lights_body, GPU_SMOOTH_9, 0}};
enum { LIT_FRAMES = sizeof lit_frames / sizeof *lit_frames };

static void bind(gpu_bench *b, vxs_gl *shadows, const gpu_view *view, GLuint program)
{
    vxs_gl_bind(shadows);
    b->gl->UseProgram(program);
    b->gl->BindTextureUnit(8, view->positions);
    b->gl->BindTextureUnit(9, view->normals);
    b->gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 7, b->answers);
}

static double mean_listed(const gpu_bench *b, const float *answers)
{
    double sum = 0, seen = 0;
    for (size_t n = 0; n < b->pixels; n++)
        if (answers[n] >= 0) {
            sum += (double)answers[n];
            seen++;
        }
    return seen > 0 ? sum / seen : 0;
}

static vxs_result measure_lit_view(gpu_bench *b, vxs_gl *shadows, const GLuint *programs, const gpu_view *view, uint32_t side_px,
                                   uint32_t count, run_context *m)
{
    char       group[64];
    int        is_compared = b->only != GPU_ONLY_LISTS;
    float     *all = malloc(b->pixels * sizeof *all), *found = malloc(b->pixels * sizeof *found);
    double     listed = 0;
    culling    c      = {shadows, view};
    vxs_result r      = all && found ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for answers");
    snprintf(group, sizeof group, "%u spot lights", count);
    vxs_gl_origin(shadows, view->eye_ws);
    if (r == VXS_OK)
        r = gpu_measure(b, view, &(gpu_row){.group = group, .name = "cull", .resolution_px = side_px}, cull_frame, &c, m);
    for (int n = b->only == GPU_ONLY_LISTS; n < LIT_FRAMES && r == VXS_OK; n++) {
        gpu_dispatch d   = {shadows, view, programs[n]};
        gpu_row      row = {.group         = group,
                            .name          = lit_frames[n].name,
                            .resolution_px = side_px,
                            .wanted = is_compared && lit_frames[n].body == lights_body && lit_frames[n].filter == GPU_BOX_9 ? all : NULL,
                            .tolerance = 1e-3f};
        bind(b, shadows, view, programs[n]);
        if (lit_frames[n].is_counted) { /* before it is timed: the row has the number */
            gpu_dispatch_frame(b, &d);
            gpu_answers(b, found);
            row.has_listed = 1;
            row.listed = listed = mean_listed(b, found);
        }
        r = gpu_measure(b, view, &row, gpu_dispatch_frame, &d, m);
        if (n == 0) gpu_answers(b, all);
    }
    free(all);
    free(found);
    return r;
}

vxs_result gpu_measure_lights(gpu_bench *b, const vxs_baked_light *const *lights, uint32_t count, run_context *m)
{
    GLuint      programs[LIT_FRAMES] = {0};
    vxs_gl     *shadows              = NULL;
    vxs_gl_desc desc                 = {.storage = VXS_GL_BUFFER, .baked = lights, .light_count = count};
    vxs_result  r                    = gpu_shadows_of(b, &desc, &shadows, m);
    for (int n = 0; n < LIT_FRAMES && r == VXS_OK; n++) {
        char defines[64];
        snprintf(defines, sizeof defines, "#define FILTER %s\n", gpu_filter_texts[lit_frames[n].filter]);
        r = gpu_program(b, shadows, defines, lit_frames[n].body, &programs[n], m);
    }
    for (size_t v = 0; v < b->view_count && r == VXS_OK; v++)
        r = measure_lit_view(b, shadows, programs, &b->views[v], 1u << lights[0]->light.levels, count, m);
    for (int n = 0; n < LIT_FRAMES; n++) b->gl->DeleteProgram(programs[n]);
    vxs_gl_destroy(shadows);
    return r;
}

/* fog -------------------------------------------------------------------------------------------------------------------------- */

typedef struct fog_state {
    vxs_volumes          *volumes;
    vxs_shadow_depth_map *map;
    rival_froxels        *froxels;
    vxs_volumes_frame     frame;
    vxs_volumes_light     light;
} fog_state;

static vxs_result draw_intervals(fog_state *s)
{
    return vxs_volumes_intervals(s->volumes, &s->light);
}

static vxs_result draw_march_64(fog_state *s)
{
    return vxs_volumes_march(s->volumes, &s->light, s->map, 64, VXS_STEPS_EVEN);
}

static vxs_result draw_march_128(fog_state *s)
{
    return vxs_volumes_march(s->volumes, &s->light, s->map, 128, VXS_STEPS_EVEN);
}

static vxs_result draw_half(fog_state *s, vxs_result (*draw)(fog_state *s))
{
    vxs_result r = vxs_volumes_begin_half(s->volumes);
    if (r == VXS_OK) r = draw(s);
    return r == VXS_OK ? vxs_volumes_end_half(s->volumes) : r;
}

static vxs_result draw_half_intervals(fog_state *s)
{
    return draw_half(s, draw_intervals);
}

static vxs_result draw_half_march(fog_state *s)
{
    return draw_half(s, draw_march_64);
}

static vxs_result draw_froxels(fog_state *s)
{
    return rival_froxels_add(s->froxels, &s->light, s->map);
}

static const struct {
    const char *name;
    vxs_result (*draw)(fog_state *s);
} fogs[] = {{"exact intervals", draw_intervals},
            {"march of a map, 64 steps (rival)", draw_march_64},
            {"march of a map, 128 steps", draw_march_128},
            {"exact intervals, half", draw_half_intervals},
            {"march of a map, 64 steps, half", draw_half_march},
            {"froxels, 160 x 90 x 64", draw_froxels}};
enum { FOGS = sizeof fogs / sizeof *fogs };

typedef struct fog_frame {
    fog_state *state;
    int        which;
} fog_frame;

static vxs_result draw_fog(gpu_bench *b, void *user)
{
    const fog_frame *f = user;
    vxs_result       r = vxs_volumes_begin(f->state->volumes, &f->state->frame);
    (void)b;
    return r == VXS_OK ? fogs[f->which].draw(f->state) : r;
}

/* Relative RMS difference of what was drawn to what exact intervals draw, over all pixels. */
static double error_of(const gpu_bench *b, const float *found, const float *wanted)
{
    double differ = 0, all = 0;
    for (size_t n = 0; n < 4 * b->pixels; n += 4) {
        double off = (double)found[n] - (double)wanted[n];
        differ += off * off;
        all += (double)wanted[n] * (double)wanted[n];
    }
    return all > 0 ? sqrt(differ / all) : 0;
}

static vxs_result measure_fog_view(gpu_bench *b, fog_state *s, const gpu_view *view, uint32_t side_px, run_context *m)
{
    size_t     bytes  = 4 * b->pixels * sizeof(float);
    float     *wanted = malloc(bytes), *found = malloc(bytes);
    vxs_result r           = wanted && found ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for a picture");
    s->frame.view          = view->view;
    s->frame.depth_texture = view->depths;
    for (int n = 0; n < FOGS && r == VXS_OK; n++) {
        fog_frame f = {s, n};
        if ((r = draw_fog(b, &f)) != VXS_OK) {
            r = fail(m, r, "%s: cannot be drawn", fogs[n].name);
            break;
        }
        b->MemoryBarrier(GL_ALL_BARRIER_BITS);
        b->gl->GetTextureImage(vxs_volumes_airlight(s->volumes), 0, GL_RGBA, GL_FLOAT, (GLsizei)bytes, n ? found : wanted);
        gpu_row row = {.group         = "fog",
                       .name          = fogs[n].name,
                       .resolution_px = side_px,
                       .has_error     = 1,
                       .error         = n ? error_of(b, found, wanted) : 0};
        if (n == 0 && vxs_volumes_cut(s->volumes))
            warn(m, "exact intervals: %u rays were ended early by the driver", vxs_volumes_cut(s->volumes));
        r = gpu_measure(b, view, &row, draw_fog, &f, m);
    }
    free(wanted);
    free(found);
    return r;
}

/* Fog of the albedo 0.9 and the anisotropy 0.4, with the first light as bright as 1. */
static vxs_result open_fog(gpu_bench *b, fog_state *s, vxs_gl *shadows, const vxs_light *light, run_context *m)
{
    vxs_volumes_desc          desc = {.struct_size      = sizeof desc,
                                      .get_proc_address = gl_lookup,
                                      .user             = b->gl,
                                      .shadows          = shadows,
                                      .width_px         = b->width_px,
                                      .height_px        = b->height_px,
                                      .has_half         = 1};
    double                    side = (double)(1u << light->levels) * light->texel_metres;
    vxs_shadow_depth_map_desc map  = {.baked_number = vxs_baked_number(0)};
    vxs_result                r    = vxs_volumes_create(&s->volumes, &desc);
    if (r == VXS_OK) r = vxs_shadow_depth_map_create(&s->map, s->volumes, &map);
    while (r == VXS_OK && vxs_shadow_depth_map_fill(s->map, 1 << 20)) continue;
    if (r == VXS_OK) r = rival_froxels_create(&s->froxels, s->volumes, 160, 90, 64);
    if (r != VXS_OK) return fail(m, r, "no fog: %s", vxs_result_text(r));
    s->light =
        (vxs_volumes_light){.baked_number = vxs_baked_number(0), .colour = {1, 1, 1}, .cos_inner = 1, .radius_metres = 0.01f};
    s->frame = (vxs_volumes_frame){.anisotropy = 0.4f, .top_metres = 1e30f, .far_metres = (float)(2 * side)};
    for (int n = 0; n < 3; n++) {
        s->frame.extinction[n] = (float)b->fog_per_metre;
        s->frame.scattering[n] = 0.9f * (float)b->fog_per_metre;
    }
    return VXS_OK;
}

vxs_result gpu_measure_fog(gpu_bench *b, const vxs_asset *asset, run_context *m)
{
    const vxs_light *light   = &vxs_asset_light(asset, 0)->light;
    fog_state        s       = {0};
    vxs_gl          *shadows = NULL;
    vxs_result       r       = gpu_shadows(b, asset, VXS_GL_BUFFER, 0, &shadows, m);
    if (r == VXS_OK) r = open_fog(b, &s, shadows, light, m);
    for (size_t v = 0; v < b->view_count && r == VXS_OK; v++) {
        vxs_gl_origin(shadows, b->views[v].eye_ws);
        r = measure_fog_view(b, &s, &b->views[v], 1u << light->levels, m);
    }
    if (s.froxels) rival_froxels_destroy(s.froxels);
    if (s.map) vxs_shadow_depth_map_destroy(s.map);
    vxs_volumes_destroy(s.volumes);
    vxs_gl_destroy(shadows);
    return r;
}
