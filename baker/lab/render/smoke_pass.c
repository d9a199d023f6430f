/* Smoke between lights and surfaces; see smoke_pass.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/smoke_pass.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/vec3.h"
#include "baker/lab/truth/camera.h"
#include "baker/light/map_space.h"

/* Initial capacity of segment lists; if a map needs more, they grow up to SEGMENTS_MOST. */
enum { SEGMENTS = 1 << 20, SEGMENTS_MOST = 1 << 22, BINDING = 7, UNIT = 7 };

/* The limit on segments of a map; it takes 10 s on two processors. Without it, a file of some kilobytes could take minutes. */
enum { SEGMENTS_MADE = 1 << 26, SIDE_LEAST = 16 };

/* reach ------------------------------------------------------------------------------------------------------------------------ */

/* The bounding sphere of a capsule.   Returns its radius */
static double ball_of(const scene_smoke *smoke, const vxs_capsule *c, double middle_ws[3])
{
    double square = 0;
    for (int n = 0; n < 3; n++) {
        double half  = 0.5 * ((double)c->end[n] - (double)c->begin[n]);
        middle_ws[n] = smoke->origin_ws[n] + (double)c->begin[n] + half;
        square += half * half;
    }
    return sqrt(square) + (double)c->radius_metres;
}

/* Whether a light reaches the sphere around a capsule. A sun's prism is taken to be endless. */
static int reaches(const vxs_light *light, const light_shape *shape, const scene_smoke *smoke, const vxs_capsule *c)
{
    double middle_ws[3], radius = ball_of(smoke, c, middle_ws);
    if (shape->kind != LIGHT_DIRECTIONAL) return light_reaches_ball(shape, middle_ws, radius);

    double edge = ldexp(1, (int)light->levels), texels = radius / light->texel_metres;
    for (int row = 0; row < 2; row++) {
        double at = vec3_dot(light->ls_from_ws + 4 * row, middle_ws) + light->ls_from_ws[4 * row + 3];
        if (at + texels < 0 || at - texels > edge) return 0;
    }
    return 1;
}

/* Whether a punctual light's range is partly in view: not outside of any plane through the eye and an edge of the picture. */
static int is_in_view(const vxs_light *light, const double eye_ws[3], const camera_view *seen)
{
    light_shape shape = baked_light_shape(light);
    double      way[3];
    if (shape.range_metres == INFINITY) return 1;
    vec3_sub(shape.position_ws, eye_ws, way);
    for (int side = 0; side < 4; side++) {
        const double *across  = side < 2 ? seen->right : seen->up;
        double        tangent = sqrt(vec3_dot(across, across)), inside[3];
        for (int n = 0; n < 3; n++) inside[n] = tangent * seen->forward[n] + (side % 2 ? -1 : 1) * across[n] / tangent;
        if (vec3_dot(inside, way) < -shape.range_metres * sqrt(vec3_dot(inside, inside))) return 0;
    }
    return 1;
}

/* create ----------------------------------------------------------------------------------------------------------------------- */

vxs_result smoke_pass_create(smoke_pass **out, const smoke_pass_options *o, const gl_context *gl, vxs_volumes *volumes,
                             run_context *m)
{
    smoke_pass *p = calloc(1, sizeof *p);
    *out          = p;
    if (!p) return fail(m, VXS_E_MEMORY, "out of memory for smoke");
    p->options = *o;
    p->gl      = gl;
    p->volumes = volumes;

    uint32_t lights = p->options.light_count, reached = 0;
    p->lights   = calloc(lights, sizeof *p->lights);
    p->layer_of = malloc(lights * sizeof *p->layer_of);
    p->in_reach = calloc(lights, 1);
    p->capsules = malloc(p->options.smoke->count * sizeof *p->capsules);
    if (!p->lights || !p->layer_of || !p->in_reach || !p->capsules) return fail(m, VXS_E_MEMORY, "out of memory for smoke");
    for (uint32_t n = 0; n < lights; n++) {
        const vxs_light *light = &p->options.lights[n]->light;
        light_shape      shape = baked_light_shape(light);
        p->layer_of[n]         = -1;
        for (uint32_t k = 0; k < o->smoke->count && !p->in_reach[n]; k++)
            p->in_reach[n] = (uint8_t)reaches(light, &shape, o->smoke, &o->smoke->list[k]);
        reached += p->in_reach[n];
    }
    p->layers = reached < SMOKE_MAPS ? reached : SMOKE_MAPS;

    gl->GenBuffers(1, &p->buffer);
    gl->CreateTextures(GL_TEXTURE_2D_ARRAY, 1, &p->array);
    gl->TextureStorage3D(p->array, 1, GL_R32F, (GLsizei)p->options.width, (GLsizei)p->options.height,
                         (GLsizei)(p->layers + !p->layers));
    gl->GenTextures((GLsizei)p->layers, p->pictures);
    for (GLuint n = 0; n < p->layers; n++) gl->TextureView(p->pictures[n], GL_TEXTURE_2D, p->array, GL_R32F, 0, 1, n, 1);
    if (gl->GetError() == GL_NO_ERROR) return VXS_OK;
    return fail(m, VXS_E_MEMORY, "OpenGL has no room for %u pictures of %u x %u samples", p->layers, p->options.width,
                p->options.height);
}

void smoke_pass_destroy(smoke_pass *p)
{
    if (!p) return;
    for (uint32_t n = 0; n < SMOKE_MAPS; n++) vxs_transmittance_map_destroy(p->maps[n]);
    p->gl->DeleteTextures((GLsizei)p->layers, p->pictures);
    p->gl->DeleteTextures(1, &p->array);
    p->gl->DeleteBuffers(1, &p->buffer);
    free(p->capsules);
    free(p->in_reach);
    free(p->layer_of);
    free(p->lights);
    free(p);
}

/* maps ------------------------------------------------------------------------------------------------------------------------- */

/* The width of a texel at a capsule, for a light's map of side_px texels a side. */
static double texel_at(const smoke_pass *p, const vxs_light *light, const light_shape *shape, const vxs_capsule *c,
                       uint32_t side_px)
{
    double middle_ws[3], way[3], texel = ldexp(light->texel_metres, (int)light->levels) / side_px;
    if (shape->kind == LIGHT_DIRECTIONAL) return texel;
    ball_of(p->options.smoke, c, middle_ws);
    vec3_sub(middle_ws, shape->position_ws, way);
    return texel * sqrt(vec3_dot(way, way));
}

/* The side of a light's map: the requested one, or less when capsules cover it so many times that it would take minutes. */
static uint32_t choose_side(const smoke_pass *p, const vxs_light *light, run_context *m)
{
    uint32_t asked = p->options.side_px, side = asked;

    /* texels that all capsules cover, each at most the whole map: about the number of segments in its lists */
    const scene_smoke *smoke = p->options.smoke;
    light_shape        shape = baked_light_shape(light);
    double             all = (double)vxs_map_count(light) * asked * asked, covered = 0;
    for (uint32_t n = 0; n < smoke->count; n++) {
        const vxs_capsule *c = &smoke->list[n];
        double             axis[3], texel = texel_at(p, light, &shape, c, asked);
        if (!reaches(light, &shape, smoke, c)) continue;
        for (int k = 0; k < 3; k++) axis[k] = (double)c->end[k] - (double)c->begin[k];
        double wide = 2 * (double)c->radius_metres / texel + 1;
        covered += fmin(wide * (wide + sqrt(vec3_dot(axis, axis)) / texel), all);
    }

    if (!(covered > SEGMENTS_MADE)) return side;
    if (!p->options.is_asked) side = (uint32_t)(asked * sqrt(SEGMENTS_MADE / covered));
    if (side < SIDE_LEAST) side = SIDE_LEAST;
    if (side < asked)
        warn(m,
             "smoke: %u capsules cover %.3g texels of the map of light %s: it has %u x %u curves in place of %u x %u, unless "
             "--smoke-side is larger",
             p->options.smoke->count, covered, light->name, side, side, asked, asked);
    else
        warn(m, "smoke: %u capsules cover %.3g texels of the map of light %s, which takes long: --smoke-side below %u takes less",
             p->options.smoke->count, covered, light->name, asked);
    return side;
}

static vxs_result build(smoke_pass *p, uint32_t light, uint32_t side_px, uint32_t segments, vxs_transmittance_map **map)
{
    const vxs_capsules     capsules = {.list = p->capsules, .count = p->options.smoke->count};
    vxs_transmittance_desc desc     = {
            .baked_number = vxs_baked_number(light), .side_px = side_px, .capsules = capsules.count, .segments = segments};
    vxs_result result = vxs_transmittance_map_create(map, p->volumes, &desc);
    return result == VXS_OK ? vxs_transmittance_map_build(*map, &capsules, NULL) : result;
}

/* Repeat with longer lists if they were too short and may grow. */
static vxs_result make_map(smoke_pass *p, uint32_t light, const double eye_ws[3], run_context *m)
{
    vxs_transmittance_map  **map    = &p->maps[p->used];
    vxs_transmittance_counts counts = {0};
    const vxs_light         *of     = &p->options.lights[light]->light;
    uint32_t                 side   = choose_side(p, of, m);
    vxs_result               result;

    /* capsules relative to the eye, and at least a texel thick */
    const scene_smoke *smoke = p->options.smoke;
    light_shape        shape = baked_light_shape(of);
    for (uint32_t n = 0; n < smoke->count; n++) {
        p->capsules[n] = smoke_widened(smoke->list[n], 0.5 * texel_at(p, of, &shape, &smoke->list[n], side));
        smoke_from_eye(smoke, &p->capsules[n], eye_ws);
    }

    result = build(p, light, side, SEGMENTS, map);
    if (result == VXS_OK) counts = vxs_transmittance_map_counts(*map);
    if (counts.merged) {
        uint32_t room = counts.segments < SEGMENTS_MOST ? counts.segments : SEGMENTS_MOST;
        vxs_transmittance_map_destroy(*map);
        result = build(p, light, side, room, map);
        if (result == VXS_OK) counts = vxs_transmittance_map_counts(*map);
    }
    if (result != VXS_OK) return fail(m, result, "a map of smoke of %u x %u curves is more than OpenGL has room for", side, side);

    if (counts.merged)
        warn(m,
             "smoke: %u of %u segments in the map of light %s have no room, and are merged: it is right behind the smoke, and "
             "coarse in it; --smoke-side below %u takes fewer",
             counts.merged, counts.segments, of->name, side);
    if (counts.cut_texels)
        warn(m,
             "smoke: OpenGL ended the lists of %u texels in the map of light %s before their end: there it is too light; "
             "--smoke-side above %u spreads them over more",
             counts.cut_texels, of->name, side);

    p->lights[light]   = (smoke_light_plan){.segments = counts.segments, .merged = counts.merged, .cut_texels = counts.cut_texels};
    p->layer_of[light] = (int32_t)p->used++;
    return VXS_OK;
}

/* frame ------------------------------------------------------------------------------------------------------------------------ */

vxs_result smoke_pass_draw(smoke_pass *p, const double eye_ws[3], const camera_view *seen, smoke_plan *plan, run_context *m)
{
    vxs_result result = VXS_OK;
    *plan             = (smoke_plan){0};
    for (uint32_t n = 0; n < p->options.light_count; n++) {
        smoke_cull_result cull_result = SMOKE_DIMS;
        if (!p->in_reach[n])
            cull_result = SMOKE_OUT_OF_REACH;
        else if (!is_in_view(&p->options.lights[n]->light, eye_ws, seen))
            cull_result = SMOKE_OUT_OF_VIEW;
        else if (p->layer_of[n] < 0 && p->used == p->layers)
            cull_result = SMOKE_NO_ROOM;
        plan->lights[cull_result]++;
        if (cull_result == SMOKE_DIMS && p->layer_of[n] < 0) {
            plan->built++;
            if ((result = make_map(p, n, eye_ws, m)) != VXS_OK) return result;
        }
        p->lights[n].cull_result = cull_result;
        if (cull_result != SMOKE_DIMS) continue;
        int32_t layer = p->layer_of[n];
        result        = vxs_volumes_transmittance(p->volumes, p->maps[layer], p->pictures[layer], VXS_CURVE_LINES);
        if (result != VXS_OK) return fail(m, result, "a map of smoke cannot be made: %s", vxs_result_text(result));
    }
    return VXS_OK;
}

void smoke_pass_bind(const smoke_pass *p)
{
    const gl_context *gl = p->gl;
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, p->buffer);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(p->options.light_count * sizeof *p->layer_of), p->layer_of,
                   GL_DYNAMIC_DRAW);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING, p->buffer);
    gl->BindTextureUnit(UNIT, p->array);
}

vxs_result smoke_pass_ask(const smoke_pass *p, GLuint places, uint32_t count, GLuint left)
{
    vxs_result result = VXS_OK;
    for (uint32_t n = 0; n < p->used && result == VXS_OK; n++)
        result = vxs_volumes_transmittance_at(p->volumes, p->maps[n], places, count, left, n * count, VXS_CURVE_LINES);
    return result;
}

const vxs_transmittance_map *smoke_pass_map(const smoke_pass *p, uint32_t light)
{
    return p->lights[light].cull_result == SMOKE_DIMS ? p->maps[p->layer_of[light]] : NULL;
}
