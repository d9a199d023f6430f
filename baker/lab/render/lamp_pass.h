/* Virtual lights in a frame: their shadows, cast by points of a scene, their light in the air, and what surfaces get of it, by
 * libvxs_volumes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LAMP_PASS_H
#define LAMP_PASS_H

#include "baker/lab/opengl/gl.h"
#include "baker/scene/scene.h"
#include "runtime/volumes/vxs_area_light.h"

#define AREA_GATHER_CHOICES "each|ninths|quarter" /* words of vxs_area_gather, in that order */
extern const char *const area_gather_names[];

typedef struct lamp_pass_options {
    const scene            *scene;      /* whose triangles cast shadows; read by create alone */
    const vxs_baked_points *points;     /* that cast shadows; NULL: they are scattered over the scene's triangles */
    const scene            *moving;     /* what casts shadows from where it is in each frame; NULL: nothing moves */
    const scene_smoke      *smoke;      /* what dims the light; NULL: nothing does */
    uint32_t                smoke_side; /* curves a side of a map of it; a virtual light has no more than 64 */
    const double           *middle_ws;  /* [3] places count from there */
    uint32_t                lamps;      /* 1 to VXS_VPLS_MAX */
    vxs_area_gather         gather;
    const vxs_vpl *dense;       /* [dense_count] lamps where points are densest, of places from the middle; read by create alone */
    uint32_t       dense_count; /* 0: points are as dense everywhere */
} lamp_pass_options;

typedef struct lamp_pass lamp_pass;

/* pass  [out] NULL on failure.   Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result lamp_pass_create(lamp_pass **pass, const lamp_pass_options *o, const gl_context *gl, vxs_volumes *volumes, message *m);

/* Accepts NULL. */
void lamp_pass_destroy(lamp_pass *pass);

/* Where what moves is now: moved_ws metres from where it is in its file.   Returns 1: it has moved since shadows were cast, and
 * lamps are to be set. */
int lamp_pass_move(lamp_pass *pass, const double moved_ws[3]);

/* Its lamps, of places from the middle, as exposed; what smoke leaves of them, and their shadows: again, where something has moved.
 * is_shone_on  whether some lamp may shine on a capsule, of places from the middle; NULL: some does on each */
vxs_result lamp_pass_set(lamp_pass *pass, const vxs_vpl *lamps, uint32_t count,
                         int (*is_shone_on)(const void *user, const vxs_capsule *c), const void *user);

/* Add airlight to the frame of volumes that has begun, and find what surfaces get.   normals  a texture of them */
vxs_result lamp_pass_draw(lamp_pass *pass, const double eye_ws[3], unsigned normals);

/* Add what surfaces got to the current framebuffer, less the exposure that it has. */
void lamp_pass_add_light(const lamp_pass *pass, double exposure);

/* What is drawn next, without vertices, with a program, is added to the current framebuffer, until blending is disabled. */
void lamp_pass_begin_adding(const lamp_pass *pass, GLuint program);

/* How many points cast shadows; what surfaces got, times exposure: an RGBA32F texture. */
uint32_t lamp_pass_points(const lamp_pass *pass);
unsigned lamp_pass_irradiance(const lamp_pass *pass);

/* How many capsules of smoke dim the lamps; and by how many curves a side of each. */
uint32_t lamp_pass_capsules(const lamp_pass *pass, uint32_t *smoke_side);

#endif
