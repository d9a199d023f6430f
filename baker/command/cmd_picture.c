/* vxs picture: a PNG of a scene in the shadows of a .vxs file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>

#include "baker/bake/provenance.h"
#include "baker/base/parallel.h"
#include "baker/command/asset_open.h"
#include "baker/command/commands.h"
#include "baker/files/output_file.h"
#include "baker/files/png_encode.h"
#include "baker/options/camera_choice.h"
#include "baker/options/filter_choice.h"
#include "baker/options/options.h"
#include "baker/options/scene_rows.h"
#include "baker/picture/picture.h"

enum { SIDE_MIN_PX = 16, SIDE_MAX_PX = 8192 };

typedef struct picture_command {
    const char     *scene_path, *asset_path, *out;
    scene_choice    choice;
    text_list       light_names;
    picture_options options;
    camera_choice   camera;
} picture_command;

static vxs_result check_options(const picture_command *c, message *m)
{
    vxs_result r = filter_check(c->options.filter_px, m);
    return r == VXS_OK ? camera_check(&c->camera, m) : r;
}

static vxs_result draw(picture_command *c, const truth *t, const casters *casting, const vxs_baked_light *const *lights,
                       uint32_t count, output_file *out, message *m)
{
    picture_options *o = &c->options;
    camera_place(&c->camera, casting, lights, count, (double)o->width_px / o->height_px);
    o->camera      = c->camera.camera;
    uint8_t   *rgb = malloc((size_t)3 * o->width_px * o->height_px), *png = NULL;
    size_t     size_bytes = 0;
    vxs_result r          = rgb ? picture_render(rgb, o, t, casting, lights, count, m) : VXS_E_MEMORY;
    if (r == VXS_OK && !(png = png_encode(rgb, o->width_px, o->height_px, 3, &size_bytes))) r = VXS_E_MEMORY;
    if (r == VXS_OK) r = output_file_write(out, png, size_bytes, m);
    free(png);
    free(rgb);
    if (r != VXS_E_MEMORY) return r;
    return fail(m, r, "out of memory for a picture of %u x %u pixels", o->width_px, o->height_px); /* the first message stays */
}

static vxs_result run(void *command, message *m)
{
    picture_command       *c     = command;
    vxs_asset             *asset = NULL;
    json_t                *made  = NULL;
    const vxs_baked_light *lights[VXS_LIGHTS_MAX];
    uint32_t               light_count;
    scene                  s       = {0};
    casters                casting = {0};
    truth                 *t       = NULL;
    output_file            out     = {0};
    vxs_result             r;

    if ((r = check_options(c, m)) != VXS_OK) goto done;
    if ((r = asset_open(&asset, c->asset_path, c->options.threads, m)) != VXS_OK) goto done;
    if ((r = asset_choose_lights(asset, c->asset_path, &c->light_names, lights, &light_count, m)) != VXS_OK) goto done;
    if ((r = provenance_read(&made, vxs_asset_contents(asset), m)) != VXS_OK) goto done;
    if ((r = asset_scene_choice(made, &c->choice, m)) != VXS_OK) goto done;
    if ((r = scene_load_gltf(&s, c->scene_path, &c->choice, m)) != VXS_OK) goto done;
    r = asset_check_scene(asset, made, c->asset_path, &s, c->scene_path, "its shadows may not fit", m);
    if (r != VXS_OK) goto done;
    /* rays meet solids and sheets alike: nothing needs to be sorted */
    if ((r = casters_from_scene(&casting, &s, CLOSED_OFF, c->options.threads, m)) != VXS_OK) goto done;
    if ((r = truth_create(&t, &casting, c->options.threads, m)) != VXS_OK) goto done;
    if ((r = output_file_open(&out, c->out, m)) != VXS_OK) goto done;
    if ((r = draw(c, t, &casting, lights, light_count, &out, m)) != VXS_OK) goto done;
    r = output_file_commit(&out, m);
done:
    output_file_abort(&out);
    truth_destroy(t);
    casters_free(&casting);
    scene_free(&s);
    vxs_asset_close(asset);
    json_decref(made);
    return r;
}

int cmd_picture(int argc, char **argv)
{
    picture_command  c = {.options = {.width_px = 1280, .height_px = 720, .filter_px = 5, .threads = parallel_default_threads()}};
    picture_options *o = &c.options;
    camera_pose     *camera = &c.camera.camera;
    camera->fov_degrees     = 35;
    const option options[]  = {
         {"SCENE", OPTION_INPUT, &c.scene_path, FILE_SCENE, 0, NULL, NULL, "a glTF 2.0 scene, .gltf or .glb", NULL},
         {"FILE.vxs", OPTION_INPUT, &c.asset_path, FILE_ASSET, 0, NULL, NULL, "what vxs bake wrote", NULL},
         {"-o", OPTION_OUTPUT, &c.out, 1, 0, ".png", "OUT.png", "where the picture goes; - is standard output", NULL},
         {"--width", OPTION_U32, &o->width_px, SIDE_MIN_PX, SIDE_MAX_PX, NULL, "PX", "16 to 8192 (default 1280)", NULL},
         {"--height", OPTION_U32, &o->height_px, SIDE_MIN_PX, SIDE_MAX_PX, NULL, "PX", "16 to 8192 (default 720)", NULL},
         {"--eye", OPTION_VECTOR, camera->eye_ws, 0, 3, NULL, "X,Y,Z", "where to stand, metres (default all of the scene in view)",
          &c.camera.eye_given},
         {"--target", OPTION_VECTOR, camera->target_ws, 0, 3, NULL, "X,Y,Z", "where to look; goes with --eye",
          &c.camera.target_given},
         {"--fov", OPTION_F64, &camera->fov_degrees, 1, 170, NULL, "DEGREES", "from top to bottom, 1 to 170 (default 35)", NULL},
         {"--light", OPTION_TEXTS, &c.light_names, 0, 0, NULL, "NAME",
          "a light that shines; repeat for more (default all of the file)", NULL},
         {"--filter", OPTION_U32, &o->filter_px, 1, VXS_FILTER_MAX, NULL, "K", "K x K box filter, K odd, 1 to 17 texels (default 5)",
          NULL},
         SCENE_ROWS(c.choice),
         {"--threads", OPTION_U32, &o->threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "threads (default all processors)", NULL},
    };
    const command_line line =
        COMMAND_LINE("picture", "SCENE FILE.vxs -o OUT.png [options]",
                     "Draw a picture (PNG) of a scene with the shadows of a .vxs file. All else is ray traced.", options);
    return command_run(&line, argc, argv, run, &c);
}
