/* Measurements of frames: JSON, a table, a plot.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RENDER_REPORT_H
#define RENDER_REPORT_H

#include <jansson.h>

#include "baker/lab/render/frame_plan.h"
#include "baker/lab/render/render.h"
#include "baker/lab/render/render_passes.h"

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
vxs_result render_report_csv(const render_report *r, const char *path, message *m);

/* Plot milliseconds of stages by frame, stacked, as SVG; for a stream, below it, uploads and the share of full answers. */
vxs_result render_report_plot(const render_report *r, const char *path, message *m);

#endif
