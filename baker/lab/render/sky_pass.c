/* A sky; see vpl_pass.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/vpl_pass.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/box.h"
#include "baker/base/vec3.h"

EMBEDDED(sky_frag_glsl)

static const double pi = 3.14159265358979324;

/* set-up ----------------------------------------------------------------------------------------------------------------------- */

static vxs_result place_vpls(sky_pass *p, run_context *m)
{
    const sky_map *map   = p->options.map;
    uint32_t       count = p->options.lit.vpls;
    float          scale = (float)p->options.scale;
    vxs_area_sky   sky   = {map->radiance, map->wide_px, map->high_px, {scale, scale, scale}, {0}, (float)p->options.radius_metres};
    p->placed            = malloc(count * sizeof *p->placed);
    if (!p->placed) return fail(m, VXS_E_MEMORY, "out of memory for the VPLs of a sky");
    vxs_result r = vxs_area_sample_sky(&sky, VXS_AREA_IMPORTANCE, 0, p->placed, count);
    if (r != VXS_OK) return fail(m, r, "the sky has no VPLs: %s", vxs_result_text(r));
    for (uint32_t n = 0; n < count; n++) {
        const float *colour = p->placed[n].colour;
        if (!isfinite(colour[0] + colour[1] + colour[2]))
            return fail(m, VXS_E_ARGUMENT, "--sky-light makes the sky brighter than any number: expected a smaller one");
        /* turn from the axes of vxs_area_sky, whose first column is in direction x, to those of the map */
        double turn_rad = p->options.turn_rad;
        double x = (double)p->placed[n].normal[0], z = (double)p->placed[n].normal[2], along = -cos(turn_rad),
               across          = -sin(turn_rad);
        p->placed[n].normal[0] = (float)(along * x + across * z);
        p->placed[n].normal[2] = (float)(along * z - across * x);
    }
    return VXS_OK;
}

vxs_result sky_pass_create(sky_pass **out, const sky_pass_options *o, const gl_context *gl, vxs_volumes *volumes, run_context *m)
{
    sky_pass *p = calloc(1, sizeof *p);
    *out        = p;
    if (!p) return fail(m, VXS_E_MEMORY, "out of memory for the sky");
    p->options = *o;
    p->gl      = gl;

    const scene *moving = p->options.lit.moving;
    vxs_result   r      = place_vpls(p, m);
    if (moving) p->moving_ws = box_of_corners(moving->positions_ws, moving->indices, 3 * moving->triangle_count);
    if (r == VXS_OK) r = vpl_pass_create(&p->vpls, &p->options.lit, gl, volumes, m);
    if (r == VXS_OK) r = gl_screen_program(gl, &p->program, (const gl_text[]){gl_embedded(sky_frag_glsl), {0}}, m);
    if (r == VXS_OK) {
        const sky_map *map = p->options.map;
        gl->CreateTextures(GL_TEXTURE_2D, 1, &p->texture);
        gl->TextureStorage2D(p->texture, 1, GL_RGB32F, (GLsizei)map->wide_px, (GLsizei)map->high_px);
        gl->TextureSubImage2D(p->texture, 0, 0, 0, (GLsizei)map->wide_px, (GLsizei)map->high_px, GL_RGB, GL_FLOAT, map->radiance);
        gl->TextureParameteri(p->texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        gl->TextureParameteri(p->texture, GL_TEXTURE_WRAP_S, GL_REPEAT);
        gl->TextureParameteri(p->texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    }
    return r;
}

void sky_pass_destroy(sky_pass *p)
{
    if (!p) return;
    vpl_pass_destroy(p->vpls);
    if (p->texture) p->gl->DeleteTextures(1, &p->texture);
    if (p->program) p->gl->DeleteProgram(p->program);
    free(p->placed);
    free(p);
}

/* frame ------------------------------------------------------------------------------------------------------------------------ */

vxs_result sky_pass_draw(sky_pass *p, const double eye_ws[3], const double moved_ws[3], unsigned normals, double exposure,
                         run_context *m)
{
    vxs_result r = VXS_OK;
    if (vpl_pass_move(p->vpls, moved_ws) || exposure != p->exposure) {
        /* the radius of a sphere around the scene and the moving casters at their current position */
        double square = 0;
        for (int n = 0; n < 3 && p->options.lit.moving; n++) {
            double from = moved_ws[n] - p->options.lit.middle_ws[n];
            double most = fmax(fabs(p->moving_ws.min[n] + from), fabs(p->moving_ws.max[n] + from));
            square += most * most;
        }
        double  radius = fmax(p->options.radius_metres, sqrt(square));
        vxs_vpl vpls[VXS_VPLS_MAX];
        for (uint32_t n = 0; n < p->options.lit.vpls; n++) {
            vpls[n]               = p->placed[n];
            vpls[n].radius_metres = (float)radius;
            for (int k = 0; k < 3; k++) vpls[n].colour[k] = (float)(exposure * (double)vpls[n].colour[k]);
        }
        r           = vpl_pass_set(p->vpls, vpls, p->options.lit.vpls, NULL, NULL);
        p->exposure = r == VXS_OK ? exposure : 0;
    }
    if (r == VXS_OK) r = vpl_pass_draw(p->vpls, eye_ws, normals);
    return r == VXS_OK ? VXS_OK : fail(m, r, "light of the sky cannot be drawn: %s", vxs_result_text(r));
}

void sky_pass_add_light(const sky_pass *p)
{
    vpl_pass_add_light(p->vpls, p->exposure);
}

void sky_pass_add_map(const sky_pass *p, const vxs_view *view, unsigned depths, double exposure)
{
    const gl_context *gl      = p->gl;
    GLuint            program = p->program;
    vpl_pass_begin_adding(p->vpls, program);
    gl->ProgramUniformMatrix4fv(program, gl->GetUniformLocation(program, "point_from_depth"), 1, GL_FALSE, view->point_from_depth);
    gl->ProgramUniform4f(program, gl->GetUniformLocation(program, "sizes"), (float)view->width_px, (float)view->height_px,
                         (float)(p->options.turn_rad / (2 * pi)), (float)(exposure * p->options.scale));
    gl->BindTextureUnit(0, depths);
    gl->BindTextureUnit(1, p->texture);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->Disable(GL_BLEND);
}

void sky_pass_mean(const sky_pass *p, double exposure, double rgb[3])
{
    for (int k = 0; k < 3; k++) {
        rgb[k] = 0;
        for (uint32_t n = 0; n < p->options.lit.vpls; n++) rgb[k] += exposure / (4 * pi) * (double)p->placed[n].colour[k];
    }
}
