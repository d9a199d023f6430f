/* Reports of frames: their passes as pictures; measurements as JSON, a table, a plot.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RENDER_REPORT_H
#define RENDER_REPORT_H

#include <jansson.h>

#include "baker/lab/render/frame_plan.h"
#include "baker/lab/render/render.h"
#include "baker/lab/truth/truth.h"

/* passes ----------------------------------------------------------------------------------------------------------------------- */

/* The difference between a frame's lookups and filtered rays, over lights and samples that face them. */
typedef struct truth_difference {
    uint64_t asked;
    double   mean;                /* of the absolute difference of lit fractions */
    uint64_t too_dark, too_light; /* by more than half */
} truth_difference;

/* Patterns of all files that render_passes writes (run_files_add_folder). */
#define RENDER_PASSES_NAMES                                                                                                        \
    "depth.png|normal.png|albedo.png|light.png|lights.png|smoke.png|smoke-*.png|area.png|sky.png|airlight.png|"                    \
    "transmittance.png|shadow-grid.png|light-mesh.png|lit-*.png|resident.png|truth.png|difference.png|depth.exr|"                  \
    "normal.exr|albedo.exr|light.exr|lights.exr|smoke.exr|smoke-*.exr|area.exr|sky.exr|airlight.exr|"                              \
    "transmittance.exr|shadow-grid.exr|lit-*.exr|resident.exr|truth.exr|difference.exr"

typedef struct passes_options {
    int          streamed;  /* lights are a stream's */
    int          is_linear; /* each pass is also written as floats, NAME.exr beside NAME.png */
    const truth *truth;     /* NULL: none */
    vxs_filter   filter;    /* as for vxs_lookup */
    uint32_t     threads;
} passes_options;

/* Write the last frame's passes into a folder, one pixel for each sample. The folder is created if needed.
 *
 *     depth.png, normal.png, albedo.png
 *     light.png        direct light, exposed, without albedo
 *     lights.png       number of lights looked up: black none, then blue to red for 1 to the maximum
 *     smoke.png        transmittance of smoke towards the eye, linear, if there is smoke: white is 1
 *     smoke-N-NAME.png transmittance of smoke towards light N at surfaces, if it dims the light; magenta without a surface
 *     area.png         light of area lights on surfaces, irradiance / pi, exposed, if there are some
 *     sky.png          the same for a map of the sky
 *     airlight.png     airlight of fog, exposed, if there is fog
 *     transmittance.png  transmittance of fog in front of surfaces, linear: white is 1
 *     shadow-grid.png  fog by a grid, of the light that was drawn last: columns of alpha, rows of theta, lit share of each
 *     light-mesh.png   fog by meshes, of the light that was drawn last: the mesh around its lit volume over the scene; warm
 *                      where a ray from the eye enters the light, cold where it leaves it
 *     lit-N-NAME.png   lit fraction of light N, if it reaches a sample; magenta without a surface, or beside its map
 *     resident.png     of a stream: grey where each lookup is answered in full, red where all are coarse, between them by the
 *                      share; dark without lookups, on surfaces that face no light
 *     truth.png        mean lit fraction of lights that reach, by K x K rays for the taps of a lookup
 *     difference.png   lookups minus truth: grey where equal, red where lookups are too dark, blue where too light
 *
 * Floats are linear, top row first, -1 where PNGs are magenta: depth (metres along the axis, 0: no surface) as Z, normals as
 * XYZ, colours and light as RGB, exposed, fractions and counts as Y. light-mesh has no floats.
 * lights  as passed to renderer_create
 * Returns VXS_OK, VXS_E_ARGUMENT (a picture would overwrite an input or another output), VXS_E_WRITE, VXS_E_GL, VXS_E_MEMORY. */
vxs_result render_passes(renderer *r, const char *folder, const vxs_baked_light *const *lights, uint32_t light_count,
                         const passes_options *o, truth_difference *difference, run_context *m);

/* measurements ----------------------------------------------------------------------------------------------------------------- */

typedef struct drawn_frame {
    camera_pose  camera;
    render_frame frame;

    /* of a stream, before the frame: pages held, pages read since the last frame, and time waited for them */
    vxs_stream_status stream;
    uint64_t          read_bytes;
    double            wait_seconds;
} drawn_frame;

typedef struct render_report {
    const char                   *scene_path, *asset_path, *moving_path; /* moving_path NULL: nothing moves */
    const render_options         *options;
    const render_facts           *facts;    /* of the last frame */
    uint32_t                      capsules; /* of the scene's smoke */
    const area_words             *areas;    /* NULL: area lights were not requested */
    const sky_words              *sky;      /* NULL: not requested */
    const vxs_baked_light *const *lights;   /* [light_count] */
    uint32_t                      light_count;
    uint64_t                      word_bytes;
    uint64_t                      budget_bytes; /* of a stream; 0: no stream */
    const drawn_frame            *frames;       /* [frame_count] */
    size_t                        frame_count;
    const truth_difference       *difference; /* NULL: not requested */
} render_report;

/* As in docs/render.schema.json. NULL when out of memory. */
json_t *render_report_json(const render_report *r);

/* Print the plan of the last frame: lights that see moving casters, lights that smoke dims, area lights that are drawn, lights in
 * fog; with `verbose` each of them. */
void render_report_print(FILE *to, const render_report *r, int verbose);

/* A line of names, and a line for each frame.   Returns VXS_OK, VXS_E_WRITE, VXS_E_MEMORY, as the next does. */
vxs_result render_report_csv(const render_report *r, const char *path, run_context *m);

/* Plot milliseconds of stages by frame, stacked, as SVG; for a stream, below it, uploads and the share of full answers. */
vxs_result render_report_plot(const render_report *r, const char *path, run_context *m);

#endif
