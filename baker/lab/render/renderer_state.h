/* A renderer's data, for its files: renderer.c makes it, renderer_frame.c draws, renderer_read.c reads back. Each uses
 * renderer_shade.c; renderer_frame.c uses renderer_read.c, too.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RENDERER_STATE_H
#define RENDERER_STATE_H

#include "baker/base/embedded.h"
#include "baker/lab/render/render.h"
#include "baker/lab/render/surface_mesh.h"
#include "runtime/gl/vxs_gl.h"

/* Render targets. */
enum {
    DEPTHS,
    NORMALS,
    ALBEDOS,
    LIGHTS,
    SCREEN,
    LINEAR,
    PICTURE,
    TARGETS
}; /* SCREEN and LINEAR have the picture's size, the others one texel for each sample */

typedef struct smoke_cloud smoke_cloud;

struct renderer {
    render_options options;
    gl_context    *gl;
    vxs_gl        *shadows;
    surface_mesh   mesh;
    uint32_t       light_count, width, height; /* samples */
    fog_pass      *fog;                        /* NULL: there is no fog, area light or sky; for the latter two the air may be
                                                  clear */
    area_pass     *areas;                      /* NULL: there is none */
    sky_pass      *sky;                        /* likewise */
    double         scale;                      /* factor on lights of the scene, before exposure */
    moving_pass   *moving;                     /* NULL: no moving casters */
    smoke_pass    *smoke;                      /* NULL: there is none */
    smoke_cloud   *cloud;                      /* likewise */
    uint32_t       frames_drawn;
    double (*colours)[3];      /* [light_count] scaled so that the largest is 1 */
    light_emission *emissions; /* [light_count] the same, as fog_pass needs it */
    int             day;       /* 1: there is a sun */
    GLuint          colour_buffer, empty_array;
    GLuint          surface_program, shade_program, tone_program;
    uint64_t        uploaded_bytes; /* including the last frame */
    GLuint          target[TARGETS], surface_frame, light_frame, screen_frame, picture_frame;
    double          exposure; /* 0: not yet chosen */
    int             is_clear; /* 1: fog does not dim lights, while the exposure is chosen */
    camera_pose     camera;   /* of the last frame */
    camera_view     seen;
    vxs_view        view;
    double          near_metres;
};

/* Whether lists of lights are made. */
int renderer_culls(const renderer *r);

/* Make a program of a full-screen pass with lookups: its text follows those of vxs_gl.h, and lit.glsl.   program  [out] deleted by
 * the caller, whatever is returned */
vxs_result renderer_lit_program(const renderer *r, GLuint *program, embedded fragment, vxs_filter filter, run_context *m);

/* Bind the resources of such programs. */
void renderer_bind_lights(const renderer *r);

/* Number of lights that one draw of such a pass adds up. llvmpipe ends all loops of a fragment shader after 65535 iterations,
 * which four groups of pixels share: so a light may take 512 for each of them. A lookup of 17 x 17 texels in a city takes less
 * than 135. */
#define LIGHTS_AT_ONCE 32U

/* Draw a full-screen triangle for each LIGHTS_AT_ONCE lights into the bound framebuffer, and add up their light.
 * uniform, element  of the program: an ivec4, and its component that is the first light;   values  of the other components */
void renderer_add_lights(const renderer *r, GLuint program, const char *uniform, int element, const GLint values[4]);

/* Begin a full-screen pass.   textures  the first of the targets that the program reads */
void renderer_begin_screen(const renderer *r, GLuint frame, GLuint program, GLuint textures, uint32_t width, uint32_t height);

/* The factor on the sky's light: 1 by day, less at night, or when a map replaces the sky. */
double renderer_day(const renderer *r);

/* The sky's light that fog scatters: that of a tenth of the horizon, at every place.   ambient  [out] */
void renderer_fog_ambient(const renderer *r, double ambient[3]);

/* Smoke as the eye sees it (smoke_cloud.c): make its resources; draw it over the picture and its fog. */
vxs_result renderer_make_cloud(renderer *r, const scene_smoke *smoke, run_context *m);
void       renderer_free_cloud(renderer *r);
vxs_result renderer_draw_cloud(renderer *r, run_context *m);

/* The matrix from positions relative to the scene's middle to clip space: x / w and y / w in [-1, 1], z / w = near / w.
 * eye  relative to the middle, too */
void renderer_clip(const renderer *r, const double eye[3], float m[16]);

/* Modes of shade_frag.glsl. */
enum { SHOW_LIGHT = 0, SHOW_LIT = 1, SHOW_FULL = 2 };

/* Look up all lights again for the last frame's surfaces, into target LIGHTS.   light  of SHOW_LIT */
void renderer_shade(const renderer *r, int show, uint32_t light);

/* The last frame as a screen shows it, in 8 bits.   rgb  [out] as for renderer_draw */
vxs_result renderer_read_screen(const renderer *r, uint8_t *rgb, run_context *m);

#endif
