/* Moving casters: a second scene, drawn beside the one whose shadows are baked. Each light that can reach them renders them into
 * its own depth maps, anew in each frame. These shade surfaces (lit.glsl) and end light in fog (vxs_shadow_depth_map_join).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MOVING_PASS_H
#define MOVING_PASS_H

#include "baker/lab/render/surface_mesh.h"
#include "runtime/volumes/vxs_volumes.h"

enum {
    MOVING_FACES = 6, /* depth maps of a light at most, when it is among the moving casters */
    MOVING_MAPS  = 16 /* of a frame; further lights get none */
};

typedef struct moving_plan {
    uint32_t lights;   /* lights that reach moving casters */
    uint32_t maps;     /* depth maps that were drawn for them */
    uint32_t left_out; /* lights without maps, because all maps were taken */
} moving_plan;

/* Only its functions write it; others may read it. */
typedef struct moving_pass {
    gl_context                   *gl;
    surface_mesh                  mesh;
    double                        first_middle_ws[3];
    const vxs_baked_light *const *lights;
    uint32_t                      light_count;
    struct shader_block          *block;
    GLuint                        buffer, depths, layers[MOVING_MAPS], frames[MOVING_MAPS];
} moving_pass;

/* pass    [out] released with its destroy function, whatever is returned;   s  at least one triangle
 * lights  [light_count] outlive the pass
 * Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result moving_pass_create(moving_pass **pass, gl_context *gl, const scene *s, const vxs_baked_light *const *lights,
                              uint32_t light_count, run_context *m);

/* Accepts NULL. */
void moving_pass_destroy(moving_pass *pass);

/* Move the casters, and render the depth maps of lights.
 * program  that draws surfaces;   by_ws  offset from the file's position, metres;   eye_ws  origin of relative positions */
void moving_pass_cast(moving_pass *pass, GLuint program, const double by_ws[3], const double eye_ws[3], moving_plan *plan);

/* Bind the resources of shaders that include lit.glsl. */
void moving_pass_bind(const moving_pass *pass);

/* The depth maps of a light.   casters  [out];   Returns their number */
uint32_t moving_pass_casters(const moving_pass *pass, uint32_t light, vxs_moving_casters casters[MOVING_FACES]);

#endif
