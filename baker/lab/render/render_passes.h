/* What a frame is made of, each as a picture.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RENDER_PASSES_H
#define RENDER_PASSES_H

#include "baker/lab/render/render.h"
#include "baker/lab/truth/truth.h"

/* How lookups of a frame compare with filtered rays, where a light reaches a sample that faces it. */
typedef struct truth_difference {
    uint64_t asked;
    double   mean;                /* of the lit fractions' difference, without its sign */
    uint64_t too_dark, too_light; /* by more than half */
} truth_difference;

/* All that render_passes writes into its folder (run_files_add_folder). */
#define RENDER_PASSES_NAMES                                                                                                        \
    "depth.png|normal.png|albedo.png|light.png|lights.png|smoke.png|smoke-*.png|area.png|sky.png|airlight.png|"                    \
    "transmittance.png|shadow-grid.png|light-mesh.png|lit-*.png|resident.png|truth.png|difference.png|depth.exr|"                  \
    "normal.exr|albedo.exr|light.exr|lights.exr|smoke.exr|smoke-*.exr|area.exr|sky.exr|airlight.exr|"                              \
    "transmittance.exr|shadow-grid.exr|lit-*.exr|resident.exr|truth.exr|difference.exr"

typedef struct passes_options {
    int          streamed;  /* lights are a stream's */
    int          is_linear; /* each pass is also written as floats, NAME.exr beside NAME.png */
    const truth *truth;     /* NULL: none */
    int          filter_px; /* as for vxs_lookup */
    uint32_t     threads;
} passes_options;

/* Write the last frame's passes into a folder, which is made where it is not there, a sample a pixel:
 *
 *     depth.png, normal.png, albedo.png
 *     light.png        direct light, as exposed, without albedo
 *     lights.png       how many lights were asked: black none, then blue to red for 1 to the most
 *     smoke.png        how much smoke lets through to the eye, linear, where there is smoke: white is all of it
 *     smoke-N-NAME.png how much of light N it leaves at what is seen, if it dims the light; magenta where nothing is
 *     area.png         what surfaces get of area lights, irradiance / pi, as exposed, where there are some
 *     sky.png          the same of a map of the sky
 *     airlight.png     what fog scatters toward the eye, as exposed, where there is fog
 *     transmittance.png  what fog leaves of what is seen, linear: white is all of it
 *     shadow-grid.png  of fog by a grid, of the light that was drawn last: columns of alpha, rows of theta, how much of each is
 *                      lit
 *     light-mesh.png   of fog by meshes, of the light that was drawn last: the mesh about what it reaches, warm where a ray from
 *                      the eye comes into its light, cold where it leaves it, before the scene
 *     lit-N-NAME.png   lit fraction of light N, if it reaches a sample; magenta where nothing is, or where its map does not
 *                      reach
 *     resident.png     of a stream: grey where each lookup is answered in full, red where coarsely, between them by the share;
 *                      dark where there is none, for surfaces that face no light
 *     truth.png        mean lit fraction of lights that reach, by K x K rays for the taps of a lookup
 *     difference.png   the same by lookups, less truth: grey where equal, red where too dark, blue where too light
 *
 * Floats are linear, top row first, -1 where PNGs are magenta: depth (metres along the axis, 0: nothing) as Z, normals as XYZ,
 * colours and light as RGB, as exposed, fractions and counts as Y. light-mesh is a drawing and has none.
 * lights  as renderer_create was given them
 * Returns VXS_OK, VXS_E_ARGUMENT (a picture would go where the run reads, or to another output), VXS_E_WRITE, VXS_E_GL,
 * VXS_E_MEMORY. */
vxs_result render_passes(renderer *r, const char *folder, const vxs_baked_light *const *lights, uint32_t light_count,
                         const passes_options *o, truth_difference *difference, message *m);

#endif
