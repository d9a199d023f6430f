/* A scene in baked shadows, drawn with OpenGL as in a game: depth, normal and albedo of each pixel, lights culled for tiles of 8
 * x 8 pixels, lookups by libvxs_gl, shading, tone mapping.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RENDER_H
#define RENDER_H

#include "baker/lab/opengl/gl.h"
#include "baker/lab/render/fog_pass.h"
#include "baker/lab/render/moving_pass.h"
#include "baker/lab/render/smoke_pass.h"
#include "baker/lab/render/vpl_pass.h"
#include "baker/lab/truth/camera.h"
#include "baker/scene/scene.h"
#include "runtime/vxs_stream.h"

typedef enum cull_mode { CULL_AUTO, CULL_ON, CULL_OFF } cull_mode;
#define CULL_CHOICES "auto|on|off" /* the words of cull_mode, in its order; auto: with more than one light */

typedef enum smoke_mode { SMOKE_ON, SMOKE_OFF } smoke_mode;
#define SMOKE_CHOICES "on|off" /* on, off: whether smoke dims lights and is drawn */

typedef struct render_options {
    uint32_t   width_px, height_px;
    uint32_t   samples;     /* a pixel is the mean of samples x samples, 1 to 4 */
    vxs_filter filter;      /* of lookups, as for vxs_lookup */
    uint32_t   tile_lights; /* capacity of a tile's list */
    double     stops;       /* exposure, in addition to that of the first frame */
    cull_mode  cull;
    gl_backend backend;
    uint32_t   threads;

    const fog_medium *fog; /* NULL: there is none */
    fog_by            fog_by;
    uint32_t          fog_steps, fog_grid; /* as in fog_pass_options */
    int               fog_is_half;

    const scene            *moving;          /* a separate scene that moves; NULL: none */
    double                  moving_by_ws[3]; /* metres, from frame to frame */
    uint32_t                area_vpls;       /* virtual lights for the scene's area lights; 0: these emit no light */
    const vxs_baked_points *area_points;     /* as for area_pass_options */
    vxs_area_gather         area_gather;

    const sky_map *sky;       /* outlives the renderer; has its own area_vpls virtual lights. NULL: the default sky of pictures */
    double         sky_light; /* factor on its radiance: cd/m2, if lights are in candela and lux */
    double         sky_turn_degrees; /* about +Y */

    const vxs_baked_smoke *const
        *baked_smoke; /* [lights] baked smoke of each; a NULL item: of that light there is none; NULL: there is none at all */

    smoke_mode smoke;
    uint32_t   smoke_side;          /* side of smoke maps, texels */
    int        smoke_side_is_asked; /* 0: smaller, if they would take too long */

    const vxs_stream *stream;       /* the stream of these lights, all of them; outlives the renderer. NULL: the lights of an
                                       asset */
    uint64_t          upload_bytes; /* limit on uploads of its pages in each frame but the first */
} render_options;

/* Times of a frame's stages in seconds; each stage waits for OpenGL to finish. Stages that are not needed (of a stream, moving
 * casters, area lights, a sky, fog) are left out. */
enum {
    RENDER_UPLOAD,
    RENDER_MOVING,
    RENDER_SURFACES,
    RENDER_CULL,
    RENDER_SMOKE,
    RENDER_SHADE,
    RENDER_AREA,
    RENDER_SKY,
    RENDER_FOG,
    RENDER_TONE,
    RENDER_STAGES
};
extern const char *const render_stage_names[RENDER_STAGES]; /* "upload", ... */

typedef struct render_frame {
    double      seconds[RENDER_STAGES];
    uint64_t    surface_pixels; /* samples of pixels that show the scene */
    uint64_t    asked_lights;   /* lookups of all samples, without lights that the surface faces away from */
    uint32_t    longest_list;   /* lights in the longest list of a tile; 0 without culling */
    uint64_t    uploaded_bytes; /* of a stream's words; in the first frame, since the renderer was made */
    uint64_t    waiting_bytes;  /* loaded, but not yet uploaded */
    fog_plan    fog;            /* lights of it; without fog all 0 */
    smoke_plan  smoke;          /* lights that it dims; without it all 0 */
    area_plan   area;           /* area lights; without them all 0 */
    moving_plan moving;         /* lights that reach moving casters; all 0 without them */
    uint64_t    full_pixels;    /* the surface_pixels all of whose lookups are answered in full; without a stream, all of them */
} render_frame;

typedef struct renderer renderer;

/* Upload a scene and the words of lights: all of an asset's, or those that the stream holds.
 * r       [out] released with renderer_destroy, whatever is returned
 * s       at least one triangle; read only by this function
 * lights  [light_count] of an asset or the stream, which outlives the renderer; each has the colour of the scene's light with
 *         its name
 * Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result renderer_create(renderer **r, const render_options *o, const scene *s, const vxs_baked_light *const *lights,
                           uint32_t light_count, run_context *m);

/* Accepts NULL. */
void renderer_destroy(renderer *r);

/* Draw the view of a camera. The first frame determines the exposure of all.
 * rgb    [out] [3 * width_px * height_px] sRGB, top row first; NULL: not wanted
 * frame  [out]
 * Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result renderer_draw(renderer *r, const camera_pose *camera, uint8_t *rgb, render_frame *frame, run_context *m);

/* The picture that was drawn last as exposed linear light, before tone mapping: the mean of samples.
 * rgb  [out] [3 * width_px * height_px] top row first */
vxs_result renderer_read_linear(renderer *r, float *rgb, run_context *m);

/* What is known of the renderer, and of the frame that was drawn last. */
typedef struct render_facts {
    const char             *name;          /* OpenGL's, of the renderer */
    uint32_t                width, height; /* samples */
    double                  exposure;      /* factor on direct light */
    double                  white; /* luminance of value 1, in cd/m2, if lights of the scene are in candela and lux. It does not
                                              hold for light from other sources, such as the sky of pictures */
    int                     culls; /* 1: lists of lights are made */
    int                     is_in_fog;
    uint32_t                fog_grid;     /* n of the fog's grid of n x 2n x n; 0 without one */
    int                     has_mesh;     /* 1: the fog was drawn by meshes */
    const fog_light_plan   *fog_lights;   /* [light_count] NULL without fog */
    const smoke_light_plan *smoke_lights; /* [light_count] NULL without smoke */
    const area_pass        *areas;        /* NULL without area lights */
    const sky_pass         *sky;          /* NULL without a map of the sky */
} render_facts;

render_facts renderer_facts(const renderer *r);

/* For the following functions, count is width * height of render_facts; top row first. */

/* Textures of all samples: exposed airlight of fog; exposed light of area lights, and of the sky, on surfaces. */
typedef enum render_texture { TEXTURE_AIRLIGHT, TEXTURE_AREAS, TEXTURE_SKY } render_texture;

/* rgb  [out] [3 * count] linear */
vxs_result renderer_read_texture(renderer *r, render_texture which, float *rgb, run_context *m);

/* depths       [out] [count] metres along the camera's axis; 0: no surface
 * normals      [out] [3 * count]; albedos likewise, linear
 * light        [out] [4 * count] direct light without albedo and exposure; the number of lights that were looked up
 * Any of them may be NULL. */
vxs_result renderer_read(renderer *r, float *depths, float *normals, float *albedos, float *light, run_context *m);

/* The lit fraction of light n at each sample, by the lookups of the last frame.   lit  [out] [count]; -1 where there is no
 * surface, and where the light does not reach */
vxs_result renderer_read_lit(renderer *r, uint32_t n, float *lit, run_context *m);

/* The transmittance of fog in front of each sample.   depths  as from renderer_read;   left  [out] [3 * count] */
void renderer_fog_left(const renderer *r, const float *depths, float *left);

/* For a stream: the share of lookups at each sample, of lights that the surface faces, that are answered in full.
 * full  [out] [count]; RENDER_NOT_ASKED without lookups, -1 without a surface */
#define RENDER_NOT_ASKED (-2.0f)
vxs_result renderer_read_full(renderer *r, float *full, run_context *m);

/* The position of sample (x, y) of the last frame, top row first, `depth` metres along the axis. */
void renderer_place(const renderer *r, uint32_t x, uint32_t y, float depth, double place_ws[3]);

/* The shadow of the fog's grid, as fog_pass_read_grid. */
vxs_result renderer_read_grid(const renderer *r, float *dark, run_context *m);

/* A picture of the last mesh of the fog: its visible surfaces, transparent, and its edges; warm where a ray enters the light, cold
 * where it leaves it.   light  [out] [3 * count] sum */
vxs_result renderer_read_mesh(renderer *r, float *light, run_context *m);

/* The transmittance of smoke towards light n, which it dims, at each sample of the last frame.   left  [out] [count] */
vxs_result renderer_read_smoke(renderer *r, uint32_t n, float *left, run_context *m);

/* The transmittance of smoke towards the eye.   left  [out] [count] */
vxs_result renderer_read_through(renderer *r, float *left, run_context *m);

#endif
