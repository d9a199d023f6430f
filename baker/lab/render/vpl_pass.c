/* Virtual lights in a frame; see vpl_pass.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/vpl_pass.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *const area_gather_names[] = {"each", "ninths", "quarter"};

static const double pi = 3.14159265358979324;

/* Light on surfaces, in the units of light before exposure. */
static const char add_text[] =
    "#version 450 core\n"
    "layout(binding = 0) uniform sampler2D irradiance;\n"
    "uniform float factor;\n"
    "layout(location = 0) out vec4 light_out;\n"
    "void main() { light_out = vec4(factor * texelFetch(irradiance, ivec2(gl_FragCoord.xy), 0).rgb, 0.0); }\n";

/* If a file has more points per place than this on average, only one point of each place is drawn. */
enum { CROWD = 4 };

/* Numbers of points: for all triangles; for moving ones. */
enum { POINTS = 1 << 18, MOVING_POINTS = 1 << 15 };

/* Limits on smoke maps: there are many virtual lights, and each has its map. The last is the limit on texels that all capsules
 * cover in all maps: it takes a minute or two on two processors. */
enum { SMOKE_SIDE_MOST = 64, SMOKE_SIDE_LEAST = 8, SMOKE_COVERED_MOST = 1 << 30 };

/* set-up ----------------------------------------------------------------------------------------------------------------------- */

/* Scatter points over a scene's triangles.
 * vpls  number of virtual lights where points are densest, as in the options
 * found  [out] number of points: 0 if all triangles have no area */
static vxs_result scatter(const vpl_pass *p, const scene *s, uint32_t vpls, vxs_area_point *points, uint32_t count, uint32_t *found,
                          run_context *m)
{
    uint32_t triangles = (uint32_t)s->triangle_count;
    float   *positions = malloc(3 * s->vertex_count * sizeof *positions);
    if (!positions) return fail(m, VXS_E_MEMORY, "out of memory for %u points of shadows", count);
    for (size_t n = 0; n < 3 * s->vertex_count; n++) positions[n] = (float)(s->positions_ws[n] - p->options.middle_ws[n % 3]);
    double area = vpls ? vxs_area_scatter_for(positions, s->indices, triangles, p->options.dense, vpls, points, count)
                       : vxs_area_scatter(positions, s->indices, triangles, points, count);
    *found      = area > 0 ? count : 0;
    free(positions);
    return VXS_OK;
}

/* Append the moving points, at their current position, to the static ones. */
static void put_moving(vpl_pass *p, const double moved_ws[3])
{
    GLsizeiptr size = sizeof *p->moved;
    for (uint32_t n = 0; n < p->moving_points; n++) {
        p->moved[n] = p->moving[n];
        for (int k = 0; k < 3; k++) p->moved[n].place[k] += (float)moved_ws[k];
    }
    p->gl->NamedBufferSubData(p->buffer, p->points * size, p->moving_points * size, p->moved);
    memcpy(p->moved_ws, moved_ws, sizeof p->moved_ws);
    p->has_moved = 1;
}

static int in_one_cell(const uint16_t *a, const uint16_t *b, uint32_t shift)
{
    return a[0] >> shift == b[0] >> shift && a[1] >> shift == b[1] >> shift && a[2] >> shift == b[2] >> shift;
}

/* Points of a file are usually as far apart as they are wide, except where surfaces overlap. The cost of shadow maps is the
 * texels that points cover, so a file with millions of wide points in one place would take minutes. If nearly all points
 * overlap, draw only one of each place: it covers the same texels. Points are sorted by their codes, so those of a place are
 * adjacent.
 * points  [baked->count] out
 * Returns their number. */
static uint32_t unpack(const vxs_baked_points *baked, const double middle_ws[3], vxs_area_point *points, run_context *m)
{
    double   units = 0.25 * sqrt(baked->square_metres) / baked->step_metres; /* in a quarter of a point's width */
    uint32_t shift = 0, places = 1, kept = 0;
    while (shift < 16 && units >= 2) units /= 2, shift++;
    for (uint32_t n = 1; n < baked->count; n++) {
        const uint16_t *c = baked->coordinates + 3 * (size_t)n;
        places += !in_one_cell(c - 3, c, shift);
    }
    vxs_points_unpack(baked, middle_ws, points->place);
    if (places >= baked->count / CROWD) return baked->count;
    for (uint32_t n = 0; n < baked->count; n++) {
        const uint16_t *c = baked->coordinates + 3 * (size_t)n;
        if (!n || !in_one_cell(c - 3, c, shift)) points[kept++] = points[n];
    }
    warn(m, "%u of %u points of the file lie within a quarter of their width of others: %u are drawn", baked->count - kept,
         baked->count, kept);
    return kept;
}

vxs_result vpl_pass_create(vpl_pass **out, const vpl_pass_options *o, const gl_context *gl, vxs_volumes *volumes, run_context *m)
{
    vpl_pass *p = calloc(1, sizeof *p);
    *out        = p;
    if (!p) return fail(m, VXS_E_MEMORY, "out of memory for area lights");
    p->options = *o;

    uint32_t side = o->smoke_side < SMOKE_SIDE_MOST ? o->smoke_side : SMOKE_SIDE_MOST, asked = side;
    double   count = o->smoke ? o->smoke->count : 0;
    while (side > SMOKE_SIDE_LEAST && count * o->vpls * side * side > SMOKE_COVERED_MOST) side /= 2;
    if (side < asked)
        warn(m,
             "smoke: %u capsules are many for %u virtual lights: each has %u x %u curves of smoke in place of %u x %u; --area "
             "below %u "
             "leaves more",
             o->smoke->count, o->vpls, side, side, asked, asked, o->vpls);
    p->options.smoke_side = side;

    p->gl      = gl;
    p->volumes = volumes;

    uint32_t            capsules = p->options.smoke ? p->options.smoke->count : 0;
    vxs_area_light_desc desc     = {.vpls = p->options.vpls, .capsules = capsules, .smoke_side_px = p->options.smoke_side};
    vxs_result          r        = vxs_area_light_create(&p->light, p->volumes, &desc);
    p->capsules                  = calloc(capsules + !capsules, sizeof *p->capsules);
    if (!p->capsules) return fail(m, VXS_E_MEMORY, "out of memory for %u capsules of smoke", capsules);
    if (r != VXS_OK) return fail(m, r, "OpenGL cannot draw area lights of %u VPLs: %s", p->options.vpls, vxs_result_text(r));
    if ((r = gl_screen_program(p->gl, &p->add_program, (const gl_text[]){{add_text, -1}, {0}}, m)) != VXS_OK) return r;
    p->gl->GenVertexArrays(1, &p->empty_array);

    static const double     nowhere[3] = {0};
    const vxs_baked_points *baked      = p->options.points;
    uint32_t                most       = baked ? baked->count : POINTS;
    vxs_area_point         *points     = malloc(most * sizeof *points);
    r                                  = points ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for %u points of shadows", most);
    p->points                          = most;
    if (r == VXS_OK && o->moving) {
        p->moving = malloc(MOVING_POINTS * sizeof *p->moving);
        p->moved  = malloc(MOVING_POINTS * sizeof *p->moved);
        r         = p->moving && p->moved ? scatter(p, o->moving, 0, p->moving, MOVING_POINTS, &p->moving_points, m)
                                          : fail(m, VXS_E_MEMORY, "out of memory for %d points of shadows", MOVING_POINTS);
    }
    if (r == VXS_OK && baked) p->points = unpack(baked, p->options.middle_ws, points, m);
    if (r == VXS_OK && !baked) r = scatter(p, p->options.scene, p->options.dense_count, points, most, &p->points, m);
    GLsizeiptr size = sizeof *points, still = r == VXS_OK ? p->points * size : 0;
    p->gl->GenBuffers(1, &p->buffer);
    p->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, p->buffer);
    p->gl->BufferData(GL_SHADER_STORAGE_BUFFER, still + p->moving_points * size, NULL, GL_DYNAMIC_DRAW);
    if (still) p->gl->NamedBufferSubData(p->buffer, 0, still, points);
    if (p->moving_points) put_moving(p, nowhere);
    free(points);
    return r;
}

void vpl_pass_destroy(vpl_pass *p)
{
    if (!p) return;
    vxs_area_light_destroy(p->light);
    if (p->buffer) p->gl->DeleteBuffers(1, &p->buffer);
    if (p->add_program) p->gl->DeleteProgram(p->add_program);
    if (p->empty_array) p->gl->DeleteVertexArrays(1, &p->empty_array);
    free(p->moving);
    free(p->moved);
    free(p->capsules);
    free(p);
}

/* frame ------------------------------------------------------------------------------------------------------------------------ */

int vpl_pass_move(vpl_pass *p, const double moved_ws[3])
{
    if (p->moving_points && memcmp(moved_ws, p->moved_ws, sizeof p->moved_ws)) put_moving(p, moved_ws);
    return p->has_moved;
}

vxs_result vpl_pass_set(vpl_pass *p, const vxs_vpl *vpls, uint32_t count, int (*is_reached)(const void *user, const vxs_capsule *c),
                        const void *user)
{
    const scene_smoke *smoke = p->options.smoke;
    vxs_result         r     = vxs_area_light_set(p->light, vpls, count);
    int                stay  = vxs_area_light_is_cast(p->light);
    if (r == VXS_OK && !stay) {
        p->capsule_count = 0;
        for (uint32_t n = 0; smoke && n < smoke->count; n++) {
            vxs_capsule *c = &p->capsules[p->capsule_count];
            *c             = smoke->list[n];
            smoke_from_eye(smoke, c, p->options.middle_ws);
            p->capsule_count += !is_reached || is_reached(user, c);
        }
        r = vxs_area_light_smoke(p->light, &(vxs_capsules){.list = p->capsules, .count = p->capsule_count});
    }
    if (r == VXS_OK && (p->has_moved || !stay))
        r = vxs_area_light_cast(p->light, &(vxs_area_casters){p->buffer, p->points + p->moving_points, 0});
    p->has_moved = 0;
    return r;
}

vxs_result vpl_pass_draw(vpl_pass *p, const double eye_ws[3], unsigned normals)
{
    float anchor[3];
    for (int n = 0; n < 3; n++) anchor[n] = (float)(p->options.middle_ws[n] - eye_ws[n]);
    vxs_result r = vxs_area_light_anchor(p->light, anchor);
    if (r != VXS_OK) return r;
    return vxs_volumes_area(p->volumes, p->light, &(vxs_area_look){.gather = p->options.gather, .normal_texture = normals});
}

void vpl_pass_begin_adding(const vpl_pass *p, GLuint program)
{
    p->gl->Enable(GL_BLEND);
    p->gl->BlendEquation(GL_FUNC_ADD);
    p->gl->BlendFunc(GL_ONE, GL_ONE);
    p->gl->UseProgram(program);
    p->gl->BindVertexArray(p->empty_array);
}

void vpl_pass_add_light(const vpl_pass *p, double exposure)
{
    const gl_context *gl = p->gl;
    vpl_pass_begin_adding(p, p->add_program);
    gl->BindTextureUnit(0, vxs_area_light_irradiance(p->light));
    gl->ProgramUniform1f(p->add_program, gl->GetUniformLocation(p->add_program, "factor"), (float)(1 / (pi * exposure)));
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->Disable(GL_BLEND);
}
