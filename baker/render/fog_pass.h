/* Fog over a picture, by libvxs_volumes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FOG_PASS_H
#define FOG_PASS_H

#include "baker/opengl/gl.h"
#include "baker/scene/fog_medium.h"
#include "runtime/gl/vxs_gl.h"

/* What tells where fog is lit. */
typedef enum fog_by { FOG_BY_MARCH, FOG_BY_ANGLES, FOG_BY_INTERVALS, FOG_BY_MESH, FOG_BY_GRID } fog_by;
#define FOG_BY_CHOICES "march|angles|intervals|mesh|grid" /* their words, in that order */

typedef struct fog_pass_options {
    const fog_medium *medium; /* it outlives the pass */
    fog_by            by;
    uint32_t          steps;         /* of a march */
    uint32_t          grid;          /* n: a grid of n x 2n x n; 0: as fits the processor that draws */
    uint32_t          width, height; /* samples */
    double            size_metres;   /* of the scene */
} fog_pass_options;

/* What a light of libvxs_gl is beside its shadows. */
typedef struct fog_shine {
    double colour[3]; /* as for vxs_volumes_light */
    double cos_inner;
} fog_shine;

/* How many lights a frame's fog was drawn of, and how many were left out, and why. */
typedef struct fog_plan {
    uint32_t drawn;
    uint32_t faint;       /* of less than FOG_FAINTEST, wherever one looks */
    uint32_t out_of_view; /* of less than that in any pixel */
} fog_plan;

/* Airlight that is not worth a pass, where 1 is white: half of one of a screen's 255 steps in black, where they are finest: 1 / (2 * 255 * 12.92). */
#define FOG_FAINTEST (1.0 / 6600)

typedef struct fog_pass fog_pass;

/* pass  [out] NULL on failure.   Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result fog_pass_create(fog_pass **pass, const fog_pass_options *o, const gl_context *gl, vxs_gl *shadows, message *m);

/* Accepts NULL. */
void fog_pass_destroy(fog_pass *pass);

/* A frame's fog, over the linear picture in the current framebuffer.
 * shines   [lights of shadows];   exposure  what their colours are times
 * ambient  of the sky, which fog scatters, too;   plan  [out] */
vxs_result fog_pass_draw(fog_pass *pass, const vxs_view *view, unsigned depths, const double eye_ws[3], const fog_shine *shines,
                         double exposure, const double ambient[3], fog_plan *plan, message *m);

/* What fog leaves of light that comes to the eye along a ray.
 * direction  of length 1;   metres  INFINITY: from where rays end that meet nothing;   left  [out] of each channel */
void fog_pass_left(const fog_pass *pass, const double eye_ws[3], const double direction[3], double metres, double left[3]);

/* n of its grid of n x 2n x n; 0 without one. */
uint32_t fog_pass_grid(const fog_pass *pass);

/* Of the grid of the light that was drawn last: how much of each column and row is in shadow. Without such a light, nothing is.
 * dark  [out] [2n][n] rows of theta, columns of alpha, 0 to 1;   Returns VXS_OK, VXS_E_MEMORY. */
vxs_result fog_pass_read_grid(const fog_pass *pass, float *dark, message *m);

/* An RGBA32F texture of width x height. */
unsigned fog_pass_airlight(const fog_pass *pass);

#endif
