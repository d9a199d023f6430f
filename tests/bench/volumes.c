/* volumes: error against run time of shadows in fog, of every technique and rival, each with its own knob, in one process and context.
 *
 *     volumes SCENE FILE.vxs --eye X,Y,Z --target X,Y,Z [--light NAME] [--fog PER_METRE] [--json FILE.json] ...
 *
 * What is seen from a camera, and from two more a third of a texel of the light's map aside. In each round every technique draws every setting of its knob
 * once, one after the other, so that what else the machine does falls on all of them; OpenGL is waited for before and behind each. The reference
 * is airlight between exact lit intervals of the asset, in double. A cell is on the front when no other is both faster and nearer to it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/opengl/gl.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/base/version.h"
#include "baker/casters/casters.h"
#include "baker/files/json_file.h"
#include "baker/files/json_value.h"
#include "baker/measure/clock.h"
#include "baker/measure/spread.h"
#include "baker/options/fog_choice.h"
#include "baker/options/options.h"
#include "baker/picture/fog.h"
#include "baker/render/baked_mesh.h"
#include "baker/truth/baked_light.h"
#include "baker/truth/camera.h"
#include "baker/truth/truth.h"
#include "runtime/volumes/vxs_volumes.h"
#include "runtime/vxs.h"
#include "tests/volumes/metrics.h"
#include "tests/volumes/rival_froxels.h"
#include "tests/volumes/rival_slices.h"

enum { CAMERAS = 3, CELLS_MAX = 64, ROUNDS_MAX = 99 };

#define NEAR_METRES 0.01

typedef struct bench {
    const char    *scene_path, *asset_path, *light_name, *json_path;
    camera_pose    pose;
    uint32_t       width, height, rounds, threads;
    gl_backend     backend;
    fog_choice     fog;
    double         far_metres, radius_metres;
    fog_medium     medium;
    scene          scene;
    casters        casting;
    truth         *truth;
    vxs_asset     *asset;
    uint32_t       number; /* of the light */
    gl_context    *gl;
    vxs_gl        *shadows;
    vxs_volumes   *volumes;
    vxs_light_map *map; /* as fine as the baked one */

    size_t            pixels;
    vxs_volumes_frame frames[CAMERAS];
    double           *wanted;  /* [CAMERAS][pixels][3] */
    uint8_t          *classes; /* [pixels] of the first camera */
} bench;

/* techniques ---------------------------------------------------------------------------------------------------------------------- */

static vxs_volumes_light light_of(const bench *b)
{
    return (vxs_volumes_light){.baked = b->number, .colour = {1, 1, 1}, .cos_inner = 1, .radius_metres = (float)b->radius_metres};
}

static vxs_result even_of_map(bench *b, const vxs_volumes_light *light, void *state, uint32_t steps)
{
    (void)state;
    return vxs_volumes_march(b->volumes, light, b->map, steps, VXS_STEPS_EVEN);
}

static vxs_result angles_of_map(bench *b, const vxs_volumes_light *light, void *state, uint32_t steps)
{
    (void)state;
    return vxs_volumes_march(b->volumes, light, b->map, steps, VXS_STEPS_ANGLE);
}

static vxs_result angles_of_asset(bench *b, const vxs_volumes_light *light, void *state, uint32_t steps)
{
    (void)state;
    return vxs_volumes_march(b->volumes, light, NULL, steps, VXS_STEPS_ANGLE);
}

static vxs_result intervals(bench *b, const vxs_volumes_light *light, void *state, uint32_t value)
{
    (void)state;
    (void)value;
    return vxs_volumes_intervals(b->volumes, light);
}

/* A mesh of the light map, made once; quads are as large as so many texels' width of error lets them be. */
static vxs_result open_mesh(bench *b, void **state, uint32_t error_texels)
{
    const baked_mesh_options o = {.light = b->number, .far_metres = b->far_metres, .error_texels = error_texels};
    message                  m = {0};
    return baked_mesh_make((vxs_light_mesh **)state, &o, b->gl, b->shadows, b->volumes, &m);
}

static vxs_result mesh(bench *b, const vxs_volumes_light *light, void *mesh, uint32_t value)
{
    (void)value;
    return vxs_volumes_mesh(b->volumes, light, mesh);
}

static void close_mesh(void *mesh)
{
    vxs_light_mesh_destroy(mesh);
}

/* A mesh that is made where it is drawn, of a map of so many texels a side. */
static vxs_result open_map(bench *b, void **state, uint32_t side_px)
{
    vxs_light_map_desc desc = {.baked = b->number, .side_px = side_px};
    vxs_result         r    = vxs_light_map_create((vxs_light_map **)state, b->volumes, &desc);
    while (r == VXS_OK && vxs_light_map_fill(*state, 1 << 20)) continue;
    return r;
}

static vxs_result mesh_of_map(bench *b, const vxs_volumes_light *light, void *map, uint32_t value)
{
    (void)value;
    return vxs_volumes_mesh_map(b->volumes, light, map);
}

static void close_map(void *map)
{
    vxs_light_map_destroy(map);
}

/* The grid of n x 2n x n bits, filled of the map, or of the asset without one. */
static vxs_result open_grid(bench *b, void **state, uint32_t size)
{
    vxs_shadow_grid_desc desc = {.columns = size, .rows = 2 * size, .bits = size};
    return vxs_shadow_grid_create((vxs_shadow_grid **)state, b->volumes, &desc);
}

static vxs_result grid_of_map(bench *b, const vxs_volumes_light *light, void *grid, uint32_t size)
{
    (void)size;
    return vxs_volumes_grid(b->volumes, light, b->map, grid, 0);
}

static vxs_result grid_of_asset(bench *b, const vxs_volumes_light *light, void *grid, uint32_t size)
{
    (void)size;
    return vxs_volumes_grid(b->volumes, light, NULL, grid, 0);
}

static void close_grid(void *grid)
{
    vxs_shadow_grid_destroy(grid);
}

/* Columns of 8 x 8 pixels, as engines have it, and so many slices. */
static vxs_result open_froxels(bench *b, void **state, uint32_t deep)
{
    return rival_froxels_create((rival_froxels **)state, b->volumes, (b->width + 7) / 8, (b->height + 7) / 8, deep);
}

static vxs_result froxels_of_map(bench *b, const vxs_volumes_light *light, void *froxels, uint32_t deep)
{
    (void)deep;
    return rival_froxels_add(froxels, light, b->map);
}

static void close_froxels(void *froxels)
{
    rival_froxels_destroy(froxels);
}

/* Twice as many bins as slices, and as many samples. */
static vxs_result open_slices(bench *b, void **state, uint32_t slices)
{
    return rival_slices_create((rival_slices **)state, b->volumes, slices, 2 * slices, slices);
}

/* At 256 slices, so many questions a ray. */
static vxs_result open_moments(bench *b, void **state, uint32_t parts)
{
    vxs_result r = open_slices(b, state, 256);
    return r == VXS_OK ? rival_slices_set_moments(*state, parts) : r;
}

static vxs_result slices_of_map(bench *b, const vxs_volumes_light *light, void *slices, uint32_t count)
{
    (void)count;
    return rival_slices_add(slices, light, b->map);
}

static void close_slices(void *slices)
{
    rival_slices_destroy(slices);
}

static vxs_result nothing(bench *b, void **state, uint32_t value)
{
    (void)b;
    (void)value;
    *state = NULL;
    return VXS_OK;
}

static void forget(void *state)
{
    (void)state;
}

/* What is drawn, by what knob; values end with 0. */
typedef struct technique {
    const char *name, *knob;
    uint32_t    values[8];
    vxs_result (*open)(bench *b, void **state,
                       uint32_t value); /* before the first round: what a level or a size is made ready by */
    vxs_result (*draw)(bench *b, const vxs_volumes_light *light, void *state, uint32_t value); /* what a frame does */
    void (*close)(void *state);
} technique;

static const technique techniques[] = {
    {"march", "steps", {8, 16, 32, 64, 128, 256, 512}, nothing, even_of_map, forget},
    {"angles", "steps", {8, 16, 32, 64, 128, 256, 512}, nothing, angles_of_map, forget},
    {"angles, asset", "steps", {16, 64, 256}, nothing, angles_of_asset, forget},
    {"intervals", "-", {1}, nothing, intervals, forget},
    {"mesh", "texels of error", {16, 4, 1}, open_mesh, mesh, close_mesh},
    {"mesh of the map", "texels a side", {64, 256, 1024}, open_map, mesh_of_map, close_map},
    {"grid", "bits a side", {64, 128, 256, 512}, open_grid, grid_of_map, close_grid},
    {"grid, asset", "bits a side", {64, 128, 256}, open_grid, grid_of_asset, close_grid},
    {"froxels", "slices", {16, 64, 256, 1024}, open_froxels, froxels_of_map, close_froxels},
    {"moments", "parts a ray", {1, 4, 16, 64}, open_moments, slices_of_map, close_slices},
    {"min-max slices", "slices", {64, 128, 256, 512}, open_slices, slices_of_map, close_slices},
};
enum { TECHNIQUES = sizeof techniques / sizeof *techniques };

typedef struct cell {
    const technique *technique;
    uint32_t         value;
    void            *state;
    double           seconds[ROUNDS_MAX], open_seconds;
    spread           spread;
    picture_error    all, elsewhere, epipole;
    double           flicker;
    int              is_refused, is_front;
} cell;

/* what is seen -------------------------------------------------------------------------------------------------------------------- */

static vxs_gl_function lookup(const char *name, void *user)
{
    return (vxs_gl_function)((const gl_context *)user)->lookup(name);
}

static void say(const char *text, void *user)
{
    (void)user;
    fprintf(stderr, "%s\n", text);
}

/* Depths are NEAR_METRES over metres along the axis, 0 where nothing is. Places count from the first camera. */
static void set_view(vxs_volumes_frame *f, const camera_view *v, const double eye[3], uint32_t width, uint32_t height)
{
    float *m = f->view.point_from_depth;
    f->view  = (vxs_view){.width_px = width, .height_px = height};
    for (int n = 0; n < 3; n++) {
        m[n]      = (float)(2 * v->right[n] * NEAR_METRES);
        m[4 + n]  = (float)(2 * v->up[n] * NEAR_METRES);
        m[8 + n]  = (float)eye[n];
        m[12 + n] = (float)((v->forward[n] - v->right[n] - v->up[n]) * NEAR_METRES);
        f->eye[n] = (float)eye[n];
    }
    m[11] = 1;
}

typedef struct seen {
    bench             *b;
    const camera_view *view;
    double             eye_ws[3];
    int                camera;
    fog_light          light;
    float             *depths;
} seen;

static void see_pixels(void *user, size_t begin, size_t end, uint32_t worker)
{
    seen  *s = user;
    bench *b = s->b;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        size_t x = n % b->width, y  = n / b->width;
        double direction[3], metres = INFINITY, *to = b->wanted + 3 * ((size_t)s->camera * b->pixels + n);
        camera_direction(s->view, (double)(x + 0.5) / b->width, 1 - (double)(y + 0.5) / b->height, direction);
        int    hit   = truth_first_hit(b->truth, s->eye_ws, direction, &metres, NULL, NULL);
        double along = 0;
        for (int k = 0; k < 3; k++) along += direction[k] * s->view->forward[k];
        s->depths[n] = hit ? (float)(NEAR_METRES / (metres * along)) : 0;
        metres       = s->depths[n] > 0 ? NEAR_METRES / ((double)s->depths[n] * along) : b->far_metres; /* as a float has it */
        to[0] = to[1] = to[2] = 0;
        fog_add_airlight(&b->medium, &s->light, 1, s->eye_ws, direction, fmin(metres, b->far_metres), to);
        if (s->camera == 0)
            b->classes[n] = s->light.shape.kind == LIGHT_DIRECTIONAL
                                ? PIXELS_ELSEWHERE
                                : (uint8_t)pixel_class_of(s->eye_ws, direction, s->light.shape.position_ws, b->radius_metres);
    }
}

/* The light's own texels, where the camera looks, are what shadows flicker by. */
static double texel_metres(const bench *b)
{
    const vxs_light  *l      = &vxs_asset_light(b->asset, b->number)->light;
    const light_shape shape  = baked_light_shape(l);
    double            square = 0;
    if (shape.kind == LIGHT_DIRECTIONAL) return l->texel_metres;
    for (int n = 0; n < 3; n++) square += pow(shape.position_ws[n] - b->pose.target_ws[n], 2);
    return l->texel_metres * sqrt(square);
}

static vxs_result see(bench *b, int camera, message *m)
{
    const vxs_baked_light *baked = vxs_asset_light(b->asset, b->number);
    camera_view            view  = camera_view_of(&b->pose, (double)b->width / b->height);
    vxs_volumes_frame     *f     = &b->frames[camera];
    double                 aside = texel_metres(b) * camera / CAMERAS, length = 0, eye[3];
    GLuint                 texture;
    seen                   s = {.b      = b,
                                .view   = &view,
                                .camera = camera,
                                .light  = {baked, baked_light_shape(&baked->light), {1, 1, 1}, 1, b->radius_metres}};
    s.light.cos_inner        = fmax(cos(s.light.shape.outer_rad), -1); /* as light_of says: no rim */
    s.depths                 = malloc(b->pixels * sizeof *s.depths);
    if (!s.depths) return fail(m, VXS_E_MEMORY, "out of memory for a picture");
    for (int n = 0; n < 3; n++) length += view.right[n] * view.right[n];
    for (int n = 0; n < 3; n++) {
        eye[n]      = aside * view.right[n] / sqrt(length);
        s.eye_ws[n] = b->pose.eye_ws[n] + eye[n];
    }
    set_view(f, &view, eye, b->width, b->height);
    parallel_for(b->threads, b->pixels, b->width, see_pixels, &s);
    b->gl->CreateTextures(GL_TEXTURE_2D, 1, &texture);
    b->gl->TextureStorage2D(texture, 1, GL_R32F, (GLsizei)b->width, (GLsizei)b->height);
    b->gl->TextureSubImage2D(texture, 0, 0, 0, (GLsizei)b->width, (GLsizei)b->height, GL_RED, GL_FLOAT, s.depths);
    free(s.depths);
    f->depth_texture = texture;
    f->far_metres    = (float)b->far_metres;
    f->anisotropy    = (float)b->medium.anisotropy;
    f->top_metres    = (float)fmin(b->medium.top_ws - b->pose.eye_ws[1], 1e30);
    for (int n = 0; n < 3; n++) {
        f->scattering[n] = (float)b->medium.scattering[n];
        f->extinction[n] = (float)b->medium.extinction[n];
    }
    return VXS_OK;
}

/* cells --------------------------------------------------------------------------------------------------------------------------- */

static double finished(const bench *b)
{
    b->gl->Finish();
    return clock_seconds();
}

static vxs_result draw(bench *b, const cell *c, int camera)
{
    vxs_volumes_light light = light_of(b);
    vxs_result        r     = vxs_volumes_begin(b->volumes, &b->frames[camera]);
    return r == VXS_OK ? c->technique->draw(b, &light, c->state, c->value) : r;
}

static void open_cells(bench *b, cell *cells, size_t *count)
{
    for (int t = 0; t < TECHNIQUES; t++)
        for (int n = 0; n < 8 && techniques[t].values[n]; n++) {
            cell  *c        = &cells[(*count)++];
            double since    = finished(b);
            *c              = (cell){.technique = &techniques[t], .value = techniques[t].values[n]};
            c->is_refused   = techniques[t].open(b, &c->state, c->value) != VXS_OK || draw(b, c, 0) != VXS_OK;
            c->open_seconds = finished(b) - since;
        }
}

static vxs_result time_cells(bench *b, cell *cells, size_t count, message *m)
{
    for (uint32_t round = 0; round < b->rounds; round++)
        for (size_t n = 0; n < count; n++) {
            if (cells[n].is_refused) continue;
            double since = finished(b);
            if (draw(b, &cells[n], 0) != VXS_OK) return fail(m, VXS_E_GL, "%s cannot be drawn", cells[n].technique->name);
            cells[n].seconds[round] = finished(b) - since;
        }
    for (size_t n = 0; n < count; n++)
        if (!cells[n].is_refused) cells[n].spread = spread_of(cells[n].seconds, b->rounds);
    return VXS_OK;
}

static vxs_result judge(bench *b, cell *c, message *m)
{
    float     *read  = malloc(4 * b->pixels * sizeof *read);
    double    *found = malloc(3 * CAMERAS * b->pixels * sizeof *found);
    vxs_result r     = read && found ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for a picture");
    for (int camera = 0; camera < CAMERAS && r == VXS_OK; camera++) {
        if ((r = draw(b, c, camera)) != VXS_OK) break;
        b->gl->GetTextureImage(vxs_volumes_airlight(b->volumes), 0, GL_RGBA, GL_FLOAT, (GLsizei)(4 * b->pixels * sizeof *read),
                               read);
        for (size_t n = 0; n < 3 * b->pixels; n++) found[3 * (size_t)camera * b->pixels + n] = (double)read[4 * (n / 3) + n % 3];
    }
    if (r == VXS_OK) {
        c->all       = picture_error_of(found, b->wanted, b->pixels, b->classes, PIXEL_CLASSES);
        c->elsewhere = picture_error_of(found, b->wanted, b->pixels, b->classes, PIXELS_ELSEWHERE);
        c->epipole   = picture_error_of(found, b->wanted, b->pixels, b->classes, PIXELS_EPIPOLE);
        c->flicker   = picture_flicker_of(found, b->wanted, CAMERAS, b->pixels);
    }
    free(read);
    free(found);
    return r;
}

/* No other is as fast and nearer, or as near and faster. */
static void find_front(cell *cells, size_t count)
{
    for (size_t n = 0; n < count; n++) {
        cells[n].is_front = !cells[n].is_refused;
        for (size_t k = 0; k < count && cells[n].is_front; k++) {
            const cell *a = &cells[n], *o = &cells[k];
            if (o->is_refused || o == a) continue;
            int as_good = o->spread.median <= a->spread.median && o->all.relative_rms <= a->all.relative_rms;
            int better  = o->spread.median < a->spread.median || o->all.relative_rms < a->all.relative_rms;
            if (as_good && better) cells[n].is_front = 0;
        }
    }
}

/* reports ------------------------------------------------------------------------------------------------------------------------- */

static json_t *error_json(const picture_error *e)
{
    json_t *o = json_object();
    json_set(&o, "relative_rms", isfinite(e->relative_rms) ? json_real(rounded(e->relative_rms, 4)) : json_null());
    json_set(&o, "signed_mean", json_real(rounded(e->signed_mean, 4)));
    json_set(&o, "percentile_99", json_real(rounded(e->percentile_99, 4)));
    json_set(&o, "most", json_real(rounded(e->most, 4)));
    json_set(&o, "values", json_integer((json_int_t)e->count));
    return o;
}

static json_t *cell_json(const cell *c)
{
    json_t *o = json_object(), *ms = json_object();
    json_set(&o, "technique", json_text(c->technique->name));
    json_set(&o, "knob", json_text(c->technique->knob));
    json_set(&o, "value", json_integer(c->value));
    json_set(&o, "refused", json_boolean(c->is_refused));
    json_set(&o, "open_ms", json_real(rounded(1000 * c->open_seconds, 4)));
    if (!c->is_refused) {
        json_set(&ms, "median", json_real(rounded(1000 * c->spread.median, 4)));
        json_set(&ms, "least", json_real(rounded(1000 * c->spread.min, 4)));
        json_set(&ms, "greatest", json_real(rounded(1000 * c->spread.max, 4)));
        json_set(&o, "ms", ms);
        json_set(&o, "error", error_json(&c->all));
        json_set(&o, "elsewhere", error_json(&c->elsewhere));
        if (c->epipole.count) json_set(&o, "epipole", error_json(&c->epipole));
        json_set(&o, "flicker", json_real(rounded(c->flicker, 4)));
        json_set(&o, "front", json_boolean(c->is_front));
    } else
        json_decref(ms);
    return o;
}

static vxs_result report(const bench *b, const cell *cells, size_t count, message *m)
{
    json_t *o = json_object(), *list = json_array();
    printf("%-16s %-10s %10s %10s %10s %10s %10s\n", "technique", "knob", "ms", "error", "largest", "flicker", "front");
    for (size_t n = 0; n < count; n++) {
        const cell *c = &cells[n];
        if (c->is_refused)
            printf("%-16s %5u %-10s refused\n", c->technique->name, c->value, c->technique->knob);
        else
            printf("%-16s %5u %-10s %8.3g %10.2g %10.2g %10.2g %6s\n", c->technique->name, c->value, c->technique->knob,
                   1000 * c->spread.median, c->all.relative_rms, c->all.most, c->flicker, c->is_front ? "*" : "");
        json_append(&list, cell_json(c));
    }
    if (!b->json_path) {
        json_decref(o);
        json_decref(list);
        return VXS_OK;
    }
    json_set(&o, "generator", json_text("vxs " VXS_VERSION));
    json_set(&o, "scene", json_text(b->scene_path));
    json_set(&o, "asset", json_text(b->asset_path));
    json_set(&o, "light", json_text(vxs_asset_light(b->asset, b->number)->light.name));
    json_set(&o, "renderer", json_text(b->gl->renderer));
    json_set(&o, "eye", json_vector(b->pose.eye_ws));
    json_set(&o, "target", json_vector(b->pose.target_ws));
    json_set(&o, "width_px", json_integer(b->width));
    json_set(&o, "height_px", json_integer(b->height));
    json_set(&o, "extinction_per_metre", json_vector(b->medium.extinction));
    json_set(&o, "scattering_per_metre", json_vector(b->medium.scattering));
    json_set(&o, "anisotropy", json_real(b->medium.anisotropy));
    json_set(&o, "rounds", json_integer(b->rounds));
    json_set(&o, "cells", list);
    return json_write(b->json_path, o, m);
}

/* ---------------------------------------------------------------------------------------------------------------------------------- */

static vxs_result load(bench *b, message *m)
{
    scene_choice choice = {0};
    vxs_result   r      = vxs_asset_open_file(&b->asset, b->asset_path, NULL);
    if (r != VXS_OK) return fail(m, r, "%s: %s", b->asset_path, vxs_result_text(r));
    for (uint32_t n = 0; b->light_name && n < vxs_asset_light_count(b->asset); n++)
        if (!strcmp(vxs_asset_light(b->asset, n)->light.name, b->light_name)) b->number = n;
    if ((r = scene_load_gltf(&b->scene, b->scene_path, &choice, m)) != VXS_OK) return r;
    if ((r = casters_from_scene(&b->casting, &b->scene, CLOSED_OFF, b->threads, m)) != VXS_OK) return r;
    if ((r = truth_create(&b->truth, &b->casting, b->threads, m)) != VXS_OK) return r;
    box    bounds    = box_of_corners(b->casting.positions_ws, b->casting.indices, 3 * b->casting.triangle_count);
    double size      = box_diagonal(&bounds);
    b->far_metres    = 2 * size;
    b->radius_metres = 5e-4 * size;
    b->medium        = fog_of(&b->fog);
    b->pixels        = (size_t)b->width * b->height;
    b->wanted        = malloc(3 * CAMERAS * b->pixels * sizeof *b->wanted);
    b->classes       = malloc(b->pixels);
    return b->wanted && b->classes ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for a picture");
}

static vxs_result open_gl(bench *b, message *m)
{
    vxs_result r = gl_context_create(&b->gl, b->backend, b->threads, m);
    if (r != VXS_OK) return r;
    vxs_gl_desc words = {.struct_size = sizeof words, .get_proc_address = lookup, .user = b->gl, .asset = b->asset};
    if ((r = vxs_gl_create(&b->shadows, &words)) != VXS_OK)
        return fail(m, r, "the words cannot be uploaded: %s", vxs_result_text(r));
    vxs_gl_upload(b->shadows, SIZE_MAX);
    vxs_gl_origin(b->shadows, b->pose.eye_ws);
    vxs_volumes_desc desc = {.struct_size      = sizeof desc,
                             .get_proc_address = lookup,
                             .user             = b->gl,
                             .shadows          = b->shadows,
                             .width_px         = b->width,
                             .height_px        = b->height,
                             .log              = say};
    if ((r = vxs_volumes_create(&b->volumes, &desc)) != VXS_OK) return fail(m, r, "no fog: %s", vxs_result_text(r));
    vxs_light_map_desc map = {.baked = b->number};
    if ((r = vxs_light_map_create(&b->map, b->volumes, &map)) != VXS_OK) return fail(m, r, "no light map: %s", vxs_result_text(r));
    while (vxs_light_map_fill(b->map, 1 << 20)) continue;
    return VXS_OK;
}

static vxs_result run(void *command, message *m)
{
    bench     *b     = command;
    size_t     count = 0;
    cell      *cells = calloc(CELLS_MAX, sizeof *cells);
    vxs_result r     = cells ? load(b, m) : fail(m, VXS_E_MEMORY, "out of memory");
    if (r == VXS_OK) r = open_gl(b, m);
    for (int camera = 0; camera < CAMERAS && r == VXS_OK; camera++) r = see(b, camera, m);
    if (r == VXS_OK) open_cells(b, cells, &count);
    if (r == VXS_OK) r = time_cells(b, cells, count, m);
    for (size_t n = 0; n < count && r == VXS_OK; n++)
        if (!cells[n].is_refused) r = judge(b, &cells[n], m);
    if (r == VXS_OK) {
        find_front(cells, count);
        r = report(b, cells, count, m);
    }
    for (size_t n = 0; n < count; n++) cells[n].technique->close(cells[n].state);
    vxs_light_map_destroy(b->map);
    vxs_volumes_destroy(b->volumes);
    vxs_gl_destroy(b->shadows);
    gl_context_destroy(b->gl);
    truth_destroy(b->truth);
    casters_free(&b->casting);
    scene_free(&b->scene);
    vxs_asset_close(b->asset);
    free(b->wanted);
    free(b->classes);
    free(cells);
    return r;
}

int main(int argc, char **argv)
{
    bench b                = {.pose.fov_degrees = 60,
                              .width            = 160,
                              .height           = 90,
                              .rounds           = 7,
                              .threads          = parallel_default_threads(),
                              .fog              = FOG_DEFAULTS};
    b.fog.per_metre        = 0.01;
    const option options[] = {
        {"SCENE", OPTION_INPUT, &b.scene_path, FILE_SCENE, 0, NULL, NULL, "a glTF 2.0 scene", NULL},
        {"FILE.vxs", OPTION_INPUT, &b.asset_path, FILE_ASSET, 0, NULL, NULL, "its shadows", NULL},
        {"--light", OPTION_TEXT, &b.light_name, 0, 0, NULL, "NAME", "the light (default the first)", NULL},
        {"--eye", OPTION_VECTOR, b.pose.eye_ws, 0, 3, NULL, "X,Y,Z", "where to stand, metres", NULL},
        {"--target", OPTION_VECTOR, b.pose.target_ws, 0, 3, NULL, "X,Y,Z", "where to look", NULL},
        {"--fov", OPTION_F64, &b.pose.fov_degrees, 1, 170, NULL, "DEGREES", "from top to bottom (default 60)", NULL},
        {"--width", OPTION_U32, &b.width, 16, 4096, NULL, "PX", "default 160", NULL},
        {"--height", OPTION_U32, &b.height, 16, 4096, NULL, "PX", "default 90", NULL},
        FOG_ROWS(b.fog),
        {"--rounds", OPTION_U32, &b.rounds, 1, ROUNDS_MAX, NULL, "N", "default 7", NULL},
        {"--gl", OPTION_CHOICE, &b.backend, 0, 0, "osmesa|egl", NULL, "whose OpenGL draws (default osmesa)", NULL},
        {"--threads", OPTION_U32, &b.threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "threads", NULL},
        {"--json", OPTION_OUTPUT, &b.json_path, 0, 0, ".json", "FILE.json", "figures as JSON", NULL},
    };
    const command_line line = COMMAND_LINE("volumes", "SCENE FILE.vxs --eye X,Y,Z --target X,Y,Z [options]",
                                           "Measure error against run time of shadows in fog.", options);
    return command_run(&line, argc, argv, run, &b);
}
