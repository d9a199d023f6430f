/* The command vxs render: cmd_render.c reads its options and loads scene and file, render_draw.c draws it and writes reports.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RENDER_COMMAND_H
#define RENDER_COMMAND_H

#include "baker/command/asset_open.h"
#include "baker/command/options/options.h"
#include "baker/files/output_file.h"
#include "baker/lab/command/camera_choice.h"
#include "baker/lab/command/fog_choice.h"
#include "baker/lab/render/render_report.h"

typedef enum draw_mode { DRAW_GL, DRAW_RAYS } draw_mode;

typedef struct render_command {
    const char    *scene_path, *asset_path, *out;
    scene_choice   choice;
    text_list      light_names;
    render_options options;
    camera_choice  camera;
    filter_choice  filter;
    draw_mode      draw;
    fog_choice     fog;
    const char    *camera_name; /* name of a camera of the scene; NULL: none */
    const char    *linear_path, *passes_folder, *path_file, *json_path, *csv_path, *plot_path, *moving_path, *sky_path;
    uint32_t       frames;
    uint64_t       budget_bytes;
    int            budget_given, upload_given;
    int orbits, samples_given, cull_given, stops_given, frames_given, moving_by_given, area_given, gather_given, smoke_given,
        smoke_side_given, sky_light_given, sky_turn_given, width_given, height_given, fov_given;
} render_command;

/* The scene, asset and camera that are drawn. */
typedef struct subject {
    scene                  scene, moving;
    sky_map                sky;
    box                    box;
    vxs_asset             *asset;  /* NULL where it is streamed */
    asset_stream           stream; /* with --budget */
    const vxs_baked_light *lights[VXS_LIGHTS_MAX];
    const vxs_baked_smoke *smoke[VXS_LIGHTS_MAX]; /* baked smoke of each light; NULL: it has none */
    uint32_t               light_count;
} subject;

/* Whether baked smoke dims any light. */
int render_has_baked_smoke(const render_command *c, const subject *s);

/* The reason why the scene's light of a name emits no light; NULL: it does, or does not exist. */
const char *render_dark_text(const scene *s, const char *name);

/* Draw the picture into a file, and write the reports.   Returns VXS_OK, VXS_E_GL, VXS_E_WRITE, VXS_E_MEMORY. */
vxs_result render_draw(const render_command *c, subject *s, output_file *out, run_context *m);

/* Print a line for each file that was written. */
void render_print_written(const render_command *c, const run_context *m);

#endif
