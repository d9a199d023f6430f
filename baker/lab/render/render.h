/* A scene in baked shadows, drawn with OpenGL as a game would: what each pixel shows, lights culled for tiles of 8 x 8 pixels,
 * lookups by libvxs_gl, shading, tone mapping.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RENDER_H
#define RENDER_H

#include "baker/lab/opengl/gl.h"
#include "baker/lab/render/area_pass.h"
#include "baker/lab/render/fog_pass.h"
#include "baker/lab/render/moving_pass.h"
#include "baker/lab/render/sky_pass.h"
#include "baker/lab/render/smoke_pass.h"
#include "baker/lab/truth/camera.h"
#include "baker/scene/scene.h"
#include "runtime/vxs_stream.h"

typedef enum cull_mode { CULL_AUTO, CULL_ON, CULL_OFF } cull_mode;
#define CULL_CHOICES "auto|on|off" /* their words, in that order; auto: where there is more than one light */

typedef enum smoke_mode { SMOKE_ON, SMOKE_OFF } smoke_mode;
#define SMOKE_CHOICES "on|off" /* their words, in that order; off: the scene's dims nothing, and is not drawn */

typedef struct render_options {
    uint32_t   width_px, height_px;
    uint32_t   samples;     /* a pixel is the mean of samples x samples, 1 to 4 */
    int        filter_px;   /* of lookups, as for vxs_lookup */
    uint32_t   tile_lights; /* that a tile's list has room for */
    double     stops;       /* of exposure, beside what the first frame asks for */
    cull_mode  cull;
    gl_backend backend;
    uint32_t   threads;

    const fog_medium *fog; /* NULL: there is none */
    fog_by            fog_by;
    uint32_t          fog_steps, fog_grid; /* as for fog_pass_options */

    const scene            *moving;          /* a scene of its own that moves; NULL: none */
    double                  moving_by_ws[3]; /* metres, from frame to frame */
    uint32_t                area_lamps;      /* of the scene's area lights; 0: they do not shine */
    const vxs_baked_points *area_points;     /* as for area_pass_options */
    vxs_area_gather         area_gather;

    const sky_map *sky;       /* it outlives the renderer, and lights by area_lamps of its own. NULL: the sky that pictures have */
    double         sky_light; /* what its radiance is times: candela a square metre, where lights are in candela and lux */
    double         sky_turn_degrees; /* about +Y */

    const vxs_baked_smoke *const
        *baked_smoke; /* [lights] what smoke leaves of each; NULL: it loses nothing; NULL: no light loses any */

    smoke_mode smoke;
    uint32_t   smoke_side;          /* texels of a map of it, */
    int        smoke_side_is_asked; /* 0: fewer, where they would take too long */

    const vxs_stream *stream;       /* whose lights these are, all of them; it outlives the renderer. NULL: of an asset */
    uint64_t          upload_bytes; /* of its pages, in each frame but the first at most */
} render_options;

/* What a frame took, in seconds, each stage by itself: OpenGL is waited for behind each. Without a stream, what moves, area
 * lights, a sky, or fog, theirs is left out. */
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
    uint64_t    surface_pixels; /* that show the scene, with all samples */
    uint64_t    asked_lights;   /* lookups of all pixels but those of lights that they face away from */
    uint32_t    longest_list;   /* lights of a tile; 0 without culling */
    uint64_t    uploaded_bytes; /* of a stream's words; in the first frame, since the renderer was made */
    uint64_t    waiting_bytes;  /* that are there, and for the next frames to upload */
    fog_plan    fog;            /* lights of it; without fog all 0 */
    smoke_plan  smoke;          /* lights that it dims; without it all 0 */
    area_plan   area;           /* area lights; without them all 0 */
    moving_plan moving;         /* lights that see what moves; without it all 0 */
    uint64_t    full_pixels;    /* surface_pixels of which each lookup is answered in full; all of them without a stream */
} render_frame;

typedef struct renderer renderer;

/* Upload a scene and the words of lights: all of an asset's, of a stream's what is there.
 * r       [out] NULL on failure; released with renderer_destroy
 * s       at least one triangle; only read here
 * lights  [light_count] of an asset or the stream, which outlives the renderer; those of the scene's names shine with the
 *         scene's colours
 * Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result renderer_create(renderer **r, const render_options *o, const scene *s, const vxs_baked_light *const *lights,
                           uint32_t light_count, message *m);

/* Accepts NULL. */
void renderer_destroy(renderer *r);

/* Draw what a camera sees. Exposure is that of the first frame.
 * rgb    [out] [3 * width_px * height_px] sRGB, top row first; NULL: nobody looks
 * frame  [out]
 * Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result renderer_draw(renderer *r, const camera_pose *camera, uint8_t *rgb, render_frame *frame, message *m);

/* The picture that was drawn last as linear light, as exposed, without a screen's shoulder and curve: the mean of samples.
 * rgb  [out] [3 * width_px * height_px] top row first */
vxs_result renderer_read_linear(renderer *r, float *rgb, message *m);

/* What is 1 there, in cd/m2, where lights of the scene are in candela and lux. Of what is not lit by them, such as the sky that
 * pictures have, it says nothing. */
double renderer_white(const renderer *r);

/* Of the frame that was drawn last, at all samples: [width, height] samples a side as renderer_size says, top row first. */
void renderer_size(const renderer *r, uint32_t *width, uint32_t *height);

/* depths       [out] [count] metres along the camera's axis; 0: nothing is there
 * normals      [out] [3 * count]; albedos likewise, linear;   light  [out] [4 * count] direct light without albedo and exposure;
 *              how many lights were asked
 * Any of them may be NULL. */
vxs_result renderer_read(renderer *r, float *depths, float *normals, float *albedos, float *light, message *m);

/* The lit fraction that light n has at each place, as lookups of the last frame say it.   lit  [out] [count]; -1 where nothing
 * is, and where the light does not reach */
vxs_result renderer_read_lit(renderer *r, uint32_t n, float *lit, message *m);

/* What fog scatters toward the eye, as exposed.   air  [out] [3 * count] linear */
vxs_result renderer_read_airlight(renderer *r, float *air, message *m);

/* What fog leaves of what is seen.   depths  as renderer_read has them;   left  [out] [3 * count] */
void renderer_fog_left(const renderer *r, const float *depths, float *left);

/* Of a stream: the share of lookups at each place, of lights that it faces, that are answered in full.
 * full  [out] [count]; RENDER_NOT_ASKED where there is none, -1 where nothing is */
#define RENDER_NOT_ASKED (-2.0f)
vxs_result renderer_read_full(renderer *r, float *full, message *m);

/* The place of sample (x, y) of the last frame, top row first, `depth` metres along the axis. */
void renderer_place(const renderer *r, uint32_t x, uint32_t y, float depth, double place_ws[3]);

/* The factor that direct light is shown with. */
double renderer_exposure(const renderer *r);

/* Whether lists of lights are made; whether there is fog. */
int renderer_culls(const renderer *r);
int renderer_is_in_fog(const renderer *r);

/* What draws area lights; NULL without them. */
const area_pass *renderer_areas(const renderer *r);

/* What surfaces got of area lights in the last frame, as exposed.   light  [out] [3 * count] linear */
vxs_result renderer_read_area(renderer *r, float *light, message *m);

/* What draws the sky; NULL without it. */
const sky_pass *renderer_sky(const renderer *r);

/* What surfaces got of it in the last frame, as renderer_read_area. */
vxs_result renderer_read_sky(renderer *r, float *light, message *m);

/* Each light in the last frame's fog, [light_count]; NULL without fog. */
const fog_light_plan *renderer_fog_lights(const renderer *r);

/* n of the fog's grid of n x 2n x n; 0 without one. What it holds, as fog_pass_read_grid. */
uint32_t   renderer_fog_grid(const renderer *r);
vxs_result renderer_read_grid(const renderer *r, float *dark, message *m);

/* Whether there is a mesh of a light that the last frame's fog was drawn of; if so, the last one, as it is seen: a veil for each
 * surface of it that the scene does not hide, and its edges; warm where a ray comes into the light, cold where it leaves it.
 * light  [out] [3 * count] added up */
int        renderer_has_mesh(const renderer *r);
vxs_result renderer_read_mesh(renderer *r, float *light, message *m);

/* Each light in the last frame's smoke, [light_count]; NULL without smoke. */
const smoke_light_plan *renderer_smoke_lights(const renderer *r);

/* How much of light n, which it dims, smoke leaves at each place of the last frame.   left  [out] [count] */
vxs_result renderer_read_smoke(renderer *r, uint32_t n, float *left, message *m);

/* How much smoke lets through of what is behind it, to the eye.   left  [out] [count] */
vxs_result renderer_read_through(renderer *r, float *left, message *m);

/* What draws. */
const char *renderer_name(const renderer *r);

#endif
