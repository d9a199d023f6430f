/* Virtual lights in a frame, by libvxs_volumes; those of area lights, and those of a sky.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef VPL_PASS_H
#define VPL_PASS_H

#include "baker/lab/opengl/gl.h"
#include "baker/lab/render/frame_plan.h"
#include "baker/lab/render/sky_map.h"
#include "baker/lab/truth/camera.h"
#include "baker/scene/scene.h"
#include "runtime/gl/vxs_gl.h"
#include "runtime/volumes/vxs_area_light.h"

/* virtual lights: their shadows, cast by points of a scene, their airlight, and their light on surfaces ------------------------ */

#define AREA_GATHER_CHOICES "each|ninths|quarter" /* words of vxs_area_gather, in that order */
extern const char *const area_gather_names[];

typedef struct vpl_pass_options {
    const scene            *scene;      /* casters; read only by create */
    const vxs_baked_points *points;     /* that cast shadows; NULL: they are scattered over the scene's triangles */
    const scene            *moving;     /* moving casters, at their position in each frame; NULL: none */
    const scene_smoke      *smoke;      /* smoke that dims the light; NULL: none */
    uint32_t                smoke_side; /* side of its maps in curves; at most 64 for a virtual light */
    const double           *middle_ws;  /* [3] origin of relative positions */
    uint32_t                vpls;       /* 1 to VXS_VPLS_MAX */
    vxs_area_gather         gather;
    const vxs_vpl          *dense; /* [dense_count] virtual lights where points are densest, relative to the middle; read only by
                                      create */
    uint32_t                dense_count; /* 0: points are equally dense everywhere */
} vpl_pass_options;

/* Only its functions write it; others may read it. */
typedef struct vpl_pass {
    vpl_pass_options  options;
    const gl_context *gl;
    vxs_volumes      *volumes;
    vxs_area_light   *light;
    uint32_t          points, moving_points; /* of static casters, first in the buffer; of moving casters */
    vxs_area_point   *moving, *moved;        /* [moving_points] at their position in the file; at their current one */
    double            moved_ws[3];           /* the offset between them */
    int               has_moved;             /* 1: moved since shadow maps were cast */
    vxs_capsule      *capsules;              /* [options.smoke->count] capsules of smoke that virtual lights reach */
    uint32_t          capsule_count;
    GLuint            buffer, add_program, empty_array;
} vpl_pass;

/* pass  [out] released with its destroy function, whatever is returned.   Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result vpl_pass_create(vpl_pass **pass, const vpl_pass_options *o, const gl_context *gl, vxs_volumes *volumes, run_context *m);

/* Accepts NULL. */
void vpl_pass_destroy(vpl_pass *pass);

/* Set the offset of moving casters from their position in the file, metres.   Returns 1: they moved since shadows were cast, so
 * the caller has to set the virtual lights again. */
int vpl_pass_move(vpl_pass *pass, const double moved_ws[3]);

/* Set the virtual lights, relative to the middle and exposed, and make their smoke maps and shadows. Call again when something
 * has moved.
 * is_reached  whether some virtual light may reach a capsule, relative to the middle; NULL: each capsule may be reached */
vxs_result vpl_pass_set(vpl_pass *pass, const vxs_vpl *vpls, uint32_t count,
                        int (*is_reached)(const void *user, const vxs_capsule *c), const void *user);

/* Add airlight to the volumes' current frame, and compute the light on surfaces.   normals  a texture of surfaces' normals */
vxs_result vpl_pass_draw(vpl_pass *pass, const double eye_ws[3], unsigned normals);

/* Add the light on surfaces to the current framebuffer, divided by the exposure that it has. */
void vpl_pass_add_light(const vpl_pass *pass, double exposure);

/* Bind a program, and enable additive blending into the current framebuffer for a following draw without vertices. The caller
 * disables blending. */
void vpl_pass_begin_adding(const vpl_pass *pass, GLuint program);

/* area lights ------------------------------------------------------------------------------------------------------------------ */

typedef struct area_pass_options {
    vpl_pass_options lit;   /* the receivers; its scene has area lights, and outlives the pass */
    double           scale; /* factor on radiance, before exposure */
} area_pass_options;

/* Only its functions write it; others may read it. */
typedef struct area_pass {
    area_pass_options options;
    const gl_context *gl;
    vpl_pass         *vpls;
    double           *powers;        /* [areas] */
    area_share       *shares, *next; /* [areas] of the last frame; of this one */
    double            exposure;      /* exposure of the virtual lights; 0: not yet set */
    uint32_t          count;         /* areas */
    GLuint            glow_program;
    GLuint           *textures; /* [areas] */
} area_pass;

/* pass  [out] released with its destroy function, whatever is returned.   Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result area_pass_create(area_pass **pass, const area_pass_options *o, const gl_context *gl, vxs_volumes *volumes,
                            run_context *m);

/* Accepts NULL. */
void area_pass_destroy(area_pass *pass);

/* Add airlight to the volumes' current frame, and compute the light on surfaces.
 * moved_ws  offset of moving casters, metres
 * normals   a texture of surfaces' normals;   exposure  factor on light
 * plan      [out] */
vxs_result area_pass_draw(area_pass *pass, const double eye_ws[3], const camera_view *seen, const double moved_ws[3],
                          double far_metres, unsigned normals, double exposure, area_plan *plan, run_context *m);

/* Add the light on surfaces to the current framebuffer, without exposure. */
void area_pass_add_light(const area_pass *pass);

/* Draw the area lights themselves into the current framebuffer, where no surface is in front of them.
 * clip_from_scene  for positions relative to the scene's middle;   depths  of the scene */
void area_pass_add_glow(const area_pass *pass, const float clip_from_scene[16], unsigned depths, const double eye_ws[3],
                        double exposure);

/* a sky ------------------------------------------------------------------------------------------------------------------------ */

typedef struct sky_pass_options {
    vpl_pass_options lit;           /* the receivers */
    double           radius_metres; /* of a sphere around the middle that contains all static casters */
    const sky_map   *map;           /* it outlives the pass */
    double           scale;         /* factor on the map's radiance, before exposure */
    double           turn_rad;      /* of the map about +Y, from +Z towards +X */
} sky_pass_options;

/* Only its functions write it; others may read it. */
typedef struct sky_pass {
    sky_pass_options  options;
    const gl_context *gl;
    vpl_pass         *vpls;
    vxs_vpl          *placed;    /* [vpls] without exposure */
    double            exposure;  /* exposure of the virtual lights; 0: not yet set */
    box               moving_ws; /* box of the moving casters, as in their file */
    GLuint            program, texture;
} sky_pass;

/* pass  [out] released with its destroy function, whatever is returned.   Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result sky_pass_create(sky_pass **pass, const sky_pass_options *o, const gl_context *gl, vxs_volumes *volumes, run_context *m);

/* Accepts NULL. */
void sky_pass_destroy(sky_pass *pass);

/* Add airlight to the volumes' current frame, and compute the light on surfaces.
 * moved_ws  offset of moving casters, metres
 * normals   a texture of surfaces' normals;   exposure  factor on light */
vxs_result sky_pass_draw(sky_pass *pass, const double eye_ws[3], const double moved_ws[3], unsigned normals, double exposure,
                         run_context *m);

/* Add the light on surfaces to the current framebuffer, without exposure. */
void sky_pass_add_light(const sky_pass *pass);

/* Draw the map into the current framebuffer, where there is no surface.   depths  of the scene */
void sky_pass_add_map(const sky_pass *pass, const vxs_view *view, unsigned depths, double exposure);

/* The mean of the map over all directions, exposed.   rgb  [out] */
void sky_pass_mean(const sky_pass *pass, double exposure, double rgb[3]);

#endif
