/* A scene's smoke in the light of its punctual lights and suns, by libvxs_volumes: a transmittance map for each light that capsules
 * can dim, and for each pixel the transmittance towards each light. A map is built once, when its light is first in view: smoke
 * does not move. And smoke as the eye sees it, by quads.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_PASS_H
#define SMOKE_PASS_H

#include "baker/base/run_context.h"
#include "baker/lab/opengl/gl.h"
#include "baker/lab/render/frame_plan.h"
#include "baker/lab/truth/camera.h"
#include "baker/scene/scene.h"
#include "runtime/volumes/vxs_transmittance.h"

enum { SMOKE_MAPS = 16, SMOKE_SIDE = 256 };
typedef struct smoke_pass_options {
    const scene_smoke            *smoke;  /* at least one capsule; outlives the pass, as lights do */
    const vxs_baked_light *const *lights; /* [light_count] those of the volumes */
    uint32_t                      light_count;
    uint32_t                      side_px; /* side of maps; smaller for a map that capsules cover very many times, unless
                                              is_asked */
    int                           is_asked;
    uint32_t                      width, height; /* samples */
} smoke_pass_options;

struct camera_view;
/* Only its functions write it; others may read it. */
typedef struct smoke_pass {
    smoke_pass_options     options;
    const gl_context      *gl;
    vxs_volumes           *volumes;
    uint32_t               layers, used;         /* of the pictures */
    vxs_transmittance_map *maps[SMOKE_MAPS];     /* by layer, in the order in which they were built */
    GLuint                 pictures[SMOKE_MAPS]; /* views of layers, GL_R32F of width x height */
    GLuint                 array, buffer;
    smoke_light_plan      *lights;   /* [light_count] */
    int32_t               *layer_of; /* [light_count] -1: none, yet */
    uint8_t               *in_reach; /* [light_count] 1: some capsule is in reach */
    vxs_capsule           *capsules; /* [smoke's count] relative to the light */
} smoke_pass;

/* pass  [out] released with its destroy function, whatever is returned.   Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result smoke_pass_create(smoke_pass **pass, const smoke_pass_options *o, const gl_context *gl, vxs_volumes *volumes,
                             run_context *m);

/* Call before destroying the volumes. Accepts NULL. */
void smoke_pass_destroy(smoke_pass *pass);

/* Build maps of lights that are newly in view, and the pictures of all maps, in the volumes' current frame. If a map has no room
 * for all segments, warn.
 * seen  from eye_ws, the origin of the volumes' positions;   plan  [out] */
vxs_result smoke_pass_draw(smoke_pass *pass, const double eye_ws[3], const struct camera_view *seen, smoke_plan *plan,
                           run_context *m);

/* Bind the resources of shaders that include lit.glsl. */
void smoke_pass_bind(const smoke_pass *pass);

/* Write the transmittance towards each light at places, layer by layer, into a storage buffer of float.
 * places  as for vxs_volumes_transmittance_at */
vxs_result smoke_pass_ask(const smoke_pass *pass, GLuint places, uint32_t count, GLuint left);

/* The map of a light that the last frame's smoke dims; else NULL. */
const vxs_transmittance_map *smoke_pass_map(const smoke_pass *pass, uint32_t light);

/* smoke as the eye sees it: capsules from back to front, each by a quad that covers it, facing the eye ------------------------- */

/* Layout as in smoke_quads.glsl. Positions are in metres relative to the eye. */
typedef struct drawn_capsule {
    vxs_capsule capsule;
    float       albedo[4];
} drawn_capsule;

enum { SMOKE_CORNERS = 4 };

typedef struct smoke_quads {
    uint32_t       count;
    drawn_capsule *capsules;       /* [count] */
    float (*corners)[4];           /* [4 * count] of quads, in the order of a strip; the fourth number is unused, as in places */
    float (*places)[4];            /* [4 * count] places of light lookups, between a capsule's middle and the corners */
    struct quad_order *order;      /* [count] */
    double             covered_px; /* about how many samples of the picture quads cover; each quad at most all of the picture */
} smoke_quads;

/* The view of the quads. */
typedef struct smoke_eye {
    double      at_ws[3];
    camera_view seen;
    double      pixel_metres; /* width of a sample at 1 m; no capsule is drawn thinner */
    double      all_px;       /* samples of the picture */
} smoke_eye;

/* Allocate room for the capsules of a scene.   q  [out]   Returns VXS_OK, VXS_E_MEMORY. */
vxs_result smoke_quads_reserve(smoke_quads *q, const scene_smoke *smoke, run_context *m);
void       smoke_quads_free(smoke_quads *q);

/* The quad of a capsule that contains the eye, or nearly, covers the whole picture. */
void smoke_quads_make(smoke_quads *q, const scene_smoke *smoke, const smoke_eye *eye);

#endif
