/* Fog over a picture, by libvxs_volumes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FOG_PASS_H
#define FOG_PASS_H

#include "baker/lab/opengl/gl.h"
#include "baker/lab/render/frame_plan.h"
#include "baker/lab/render/moving_pass.h"
#include "baker/lab/render/smoke_pass.h"
#include "baker/scene/smoke.h"
#include "runtime/gl/vxs_gl.h"
#include "runtime/volumes/vxs_volumes.h"

typedef struct fog_pass_options {
    const fog_medium             *medium; /* it outlives the pass */
    fog_by                        by;
    uint32_t                      steps;         /* of a march */
    uint32_t                      grid;          /* n: a grid of n x 2n x n; 0: chosen for the renderer */
    int                           is_half;       /* 1: rays at half the width and height */
    uint32_t                      width, height; /* samples */
    double                        size_metres;   /* of the scene */
    const vxs_baked_smoke *const *baked_smoke;   /* [lights] as in render_options */
    int                           streamed; /* 1: baked data may change, so shadow depth maps are looked up anew in each frame */
} fog_pass_options;

/* Properties of a light, in addition to its shadows in libvxs_gl. */
typedef struct light_emission {
    double colour[3]; /* as for vxs_volumes_light */
    double cos_inner;
} light_emission;

/* A light, and the maximum of its airlight on any ray. */
typedef struct faint_light {
    uint32_t light;
    float    most;
} faint_light;

/* Only its functions write it; others may read it. */
typedef struct fog_pass {
    fog_pass_options       options;
    const gl_context      *gl;
    vxs_gl                *shadows;
    vxs_volumes           *volumes;
    vxs_shadow_grid       *grid;   /* FOG_BY_GRID */
    vxs_light_mesh       **meshes; /* FOG_BY_MESH: [lights], NULL until the light is first drawn */
    vxs_shadow_depth_map **maps;   /* [lights] for lights that have met moving casters; else NULL */
    uint32_t               meshes_made;
    fog_light_plan        *lights; /* [lights] of the last frame */
    faint_light           *faint;  /* [lights] */
    float                 *least;  /* [lights] min_radiance of each */
    uint32_t               last;   /* the light that was drawn last; UINT32_MAX: none */
} fog_pass;

/* pass  [out] released with its destroy function, whatever is returned.   Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result fog_pass_create(fog_pass **pass, const fog_pass_options *o, const gl_context *gl, vxs_gl *shadows, run_context *m);

/* Accepts NULL. */
void fog_pass_destroy(fog_pass *pass);

/* Begin a frame without airlight.
 * ambient  of the sky, scattered by the fog, too */
vxs_result fog_pass_begin(fog_pass *pass, const vxs_view *view, unsigned depths, const double eye_ws[3], const double ambient[3],
                          run_context *m);

/* Add the airlight of lights, and blend fog over the linear picture in the current framebuffer.
 * emissions   [lights of shadows];   exposure  factor on their colours;   plan  [out]
 * moving   moving casters: lights that meet them are drawn by maps joined with theirs, not by intervals or meshes; NULL: none */
vxs_result fog_pass_draw(fog_pass *pass, const light_emission *emissions, const moving_pass *moving, const smoke_pass *smoke,
                         double exposure, fog_plan *plan, run_context *m);

/* End of rays that meet no surface, in metres: beyond the whole scene. */
double fog_pass_far_metres(const fog_pass *pass);

/* Transmittance of the fog along a ray to the eye.
 * direction  of length 1;   metres  INFINITY: up to the end of rays that meet no surface;   left  [out] of each channel */
void fog_pass_left(const fog_pass *pass, const double eye_ws[3], const double direction[3], double metres, double left[3]);

/* The share of shadow in each column and row of the grid of the light that was drawn last. 0 if there is no such light.
 * dark  [out] [2n][n] rows of theta, columns of alpha, 0 to 1;   Returns VXS_OK, VXS_E_MEMORY. */
vxs_result fog_pass_read_grid(const fog_pass *pass, float *dark, run_context *m);

/* The mesh that the last frame drew last, with FOG_BY_MESH.   light  [out] its number;   Returns NULL if there is none */
const vxs_light_mesh *fog_pass_mesh(const fog_pass *pass, uint32_t *light);

/* the mesh around the lit volume of a baked light, made once from its shadow depths -------------------------------------------- */

typedef struct baked_mesh_options {
    uint32_t light;      /* its number in vxs_gl */
    uint32_t side_px;    /* side of the shadow depth map, a power of two; 0, or more than the baked map's: that side */
    double   far_metres; /* as for vxs_light_mesh_desc, like the next one */
    double   error_texels;
} baked_mesh_options;

/* mesh  [out] untouched on failure; released with vxs_light_mesh_destroy.   Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY,
 *       VXS_E_ARGUMENT. */
vxs_result baked_mesh_make(vxs_light_mesh **mesh, const baked_mesh_options *o, const gl_context *gl, const vxs_gl *shadows,
                           vxs_volumes *volumes, run_context *m);

#endif
