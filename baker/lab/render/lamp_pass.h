/* Virtual lights in a frame, by libvxs_volumes: their shadows, cast by points of a scene, their airlight, and their light on
 * surfaces.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LAMP_PASS_H
#define LAMP_PASS_H

#include "baker/lab/opengl/gl.h"
#include "baker/scene/scene.h"
#include "runtime/volumes/vxs_area_light.h"

#define AREA_GATHER_CHOICES "each|ninths|quarter" /* words of vxs_area_gather, in that order */
extern const char *const area_gather_names[];

typedef struct lamp_pass_options {
    const scene            *scene;      /* casters; read only by create */
    const vxs_baked_points *points;     /* that cast shadows; NULL: they are scattered over the scene's triangles */
    const scene            *moving;     /* moving casters, at their position in each frame; NULL: none */
    const scene_smoke      *smoke;      /* smoke that dims the light; NULL: none */
    uint32_t                smoke_side; /* side of its maps in curves; at most 64 for a virtual light */
    const double           *middle_ws;  /* [3] origin of relative positions */
    uint32_t                lamps;      /* 1 to VXS_VPLS_MAX */
    vxs_area_gather         gather;
    const vxs_vpl          *dense; /* [dense_count] virtual lights where points are densest, relative to the middle; read only by
                                      create */
    uint32_t                dense_count; /* 0: points are equally dense everywhere */
} lamp_pass_options;

typedef struct lamp_pass lamp_pass;

/* pass  [out] NULL on failure.   Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result lamp_pass_create(lamp_pass **pass, const lamp_pass_options *o, const gl_context *gl, vxs_volumes *volumes, message *m);

/* Accepts NULL. */
void lamp_pass_destroy(lamp_pass *pass);

/* Set the offset of moving casters from their position in the file, metres.   Returns 1: they moved since shadows were cast, so
 * the caller has to set the virtual lights again. */
int lamp_pass_move(lamp_pass *pass, const double moved_ws[3]);

/* Set the virtual lights, relative to the middle and exposed, and make their smoke maps and shadows. Call again when something
 * has moved.
 * is_shone_on  whether some virtual light may reach a capsule, relative to the middle; NULL: each capsule may be reached */
vxs_result lamp_pass_set(lamp_pass *pass, const vxs_vpl *lamps, uint32_t count,
                         int (*is_shone_on)(const void *user, const vxs_capsule *c), const void *user);

/* Add airlight to the volumes' current frame, and compute the light on surfaces.   normals  a texture of surfaces' normals */
vxs_result lamp_pass_draw(lamp_pass *pass, const double eye_ws[3], unsigned normals);

/* Add the light on surfaces to the current framebuffer, divided by the exposure that it has. */
void lamp_pass_add_light(const lamp_pass *pass, double exposure);

/* Bind a program, and enable additive blending into the current framebuffer for a following draw without vertices. The caller
 * disables blending. */
void lamp_pass_begin_adding(const lamp_pass *pass, GLuint program);

/* The number of points that cast shadows; then the light on surfaces, times exposure: an RGBA32F texture. */
uint32_t lamp_pass_points(const lamp_pass *pass);
unsigned lamp_pass_irradiance(const lamp_pass *pass);

/* The number of smoke capsules that dim the virtual lights, and the side of each one's smoke map. */
uint32_t lamp_pass_capsules(const lamp_pass *pass, uint32_t *smoke_side);

#endif
