/* vxs render: a scene in the shadows of a .vxs file, drawn with OpenGL as a game would, or by rays.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/command/render_command.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/box.h"
#include "baker/base/parallel.h"
#include "baker/command/asset_open.h"
#include "baker/command/options/options.h"
#include "baker/command/provenance_differences.h"
#include "baker/lab/command/lab_commands.h"

enum {
    SIDE_MIN_PX      = 16,
    SIDE_MAX_PX      = 8192,
    SAMPLES_MAX      = 4,
    SAMPLES_SIDE_MAX = 16384,
    TILE_LIGHTS      = 255,
    UPLOAD_BYTES     = 1 << 20,
    AREA_VPLS        = 64,
    SMOKE_SIDE_MIN   = 16,
    SMOKE_SIDE_MAX   = 2048,
    FRAMES           = 60,
    FRAMES_MAX       = 100000
};

/* The first given option that needs OpenGL, or a path; NULL: there is none. */
static const char *needs_gl(const render_command *c)
{
    return c->samples_given      ? "--samples"
           : c->budget_given     ? "--budget"
           : c->cull_given       ? "--cull"
           : c->fog.by_given     ? "--fog-by"
           : c->fog.steps_given  ? "--fog-steps"
           : c->fog.grid_given   ? "--fog-grid"
           : c->fog.is_half      ? "--fog-half"
           : c->area_given       ? "--area"
           : c->gather_given     ? "--area-gather"
           : c->sky_path         ? "--sky"
           : c->stops_given      ? "--exposure"
           : c->smoke_given      ? "--smoke"
           : c->smoke_side_given ? "--smoke-side"
           : c->moving_path      ? "--moving"
           : c->passes_folder    ? "--passes"
           : c->path_file        ? "--path"
           : c->orbits           ? "--orbit"
           : c->json_path        ? "--json"
           : c->csv_path         ? "--csv"
           : c->plot_path        ? "--plot"
                                 : NULL;
}

static vxs_result check_samples(const render_options *o, run_context *m)
{
    if (o->width_px * o->samples <= SAMPLES_SIDE_MAX && o->height_px * o->samples <= SAMPLES_SIDE_MAX) return VXS_OK;
    return fail(m, VXS_E_ARGUMENT, "--samples %u of a picture of %u x %u: expected no side of more than %d samples", o->samples,
                o->width_px, o->height_px, SAMPLES_SIDE_MAX);
}

static vxs_result check_options(const render_command *c, run_context *m)
{
    const render_options *o    = &c->options;
    int                   path = c->path_file || c->orbits;
    vxs_result            r    = filter_check(&c->filter, m);
    if (r == VXS_OK) r = camera_check(&c->camera, m);
    if (r != VXS_OK) return r;
    if (c->draw == DRAW_RAYS && needs_gl(c))
        return fail(m, VXS_E_ARGUMENT, "--draw rays goes without %s, which is for OpenGL", needs_gl(c));
    if (r == VXS_OK) r = fog_check(&c->fog, m);
    if (r != VXS_OK) return r;
    if (c->fog.by == FOG_BY_MESH && c->budget_given)
        return fail(m, VXS_E_ARGUMENT, "--fog-by mesh goes without --budget: it is made once, of all of the file");
    if (c->gather_given && !o->area_vpls) return fail(m, VXS_E_ARGUMENT, "--area-gather needs area lights: --area 1 or more");
    if (c->sky_path && !o->area_vpls) return fail(m, VXS_E_ARGUMENT, "--sky needs virtual lights: --area 1 or more");
    if (!c->sky_path && (c->sky_light_given || c->sky_turn_given))
        return fail(m, VXS_E_ARGUMENT, "%s needs --sky", c->sky_light_given ? "--sky-light" : "--sky-turn");
    const char *other = c->camera.eye_given ? "--eye"
                        : c->path_file      ? "--path"
                        : c->orbits         ? "--orbit"
                        : c->fov_given      ? "--fov"
                                            : NULL;
    if (c->camera_name && other) return fail(m, VXS_E_ARGUMENT, "--camera and %s exclude each other", other);
    if (c->path_file && c->orbits) return fail(m, VXS_E_ARGUMENT, "--path and --orbit exclude each other");
    if (c->path_file && c->camera.eye_given) return fail(m, VXS_E_ARGUMENT, "--path and --eye exclude each other");
    if (c->upload_given && !c->budget_given)
        return fail(m, VXS_E_ARGUMENT, "--upload %llu needs --budget", (unsigned long long)o->upload_bytes);
    if (c->smoke_side_given && o->smoke == SMOKE_OFF) return fail(m, VXS_E_ARGUMENT, "--smoke-side needs --smoke on");
    if (c->moving_by_given && (!c->moving_path || !path))
        return fail(m, VXS_E_ARGUMENT, "--moving-by needs --moving, and --path or --orbit");
    if (!path && c->frames_given) return fail(m, VXS_E_ARGUMENT, "--frames %u needs --path or --orbit", c->frames);
    return check_samples(o, m);
}

/* Open all of an asset, or its resident part as a stream.   contents  [out] */
static vxs_result open_asset(render_command *c, subject *s, const vxs_contents **contents, run_context *m)
{
    vxs_result r;
    *contents = &s->stream.contents;
    if (c->budget_given) {
        r = asset_stream_open(&s->stream, c->asset_path, c->budget_bytes, &c->light_names, c->options.area_vpls > 0, s->lights,
                              s->smoke, &s->light_count, m);
        c->options.stream      = s->stream.stream;
        c->options.area_points = s->stream.points.coordinates ? &s->stream.points : NULL;
        return r;
    }
    if ((r = asset_open(&s->asset, c->asset_path, 0, 1, c->options.threads, m)) != VXS_OK) return r;
    *contents              = vxs_asset_contents(s->asset);
    c->options.area_points = vxs_asset_points(s->asset);
    r                      = asset_choose_lights(*contents, c->asset_path, &c->light_names, s->lights, &s->light_count, m);
    if (r == VXS_OK) asset_find_smoke(s->asset, s->lights, s->light_count, s->smoke);
    return r;
}

/* Include skinned meshes, in their pose: they are typical moving objects. */
static vxs_result load_moving(render_command *c, subject *s, run_context *m)
{
    const scene_choice all = {.skinned = SKINNED_REST, .skinned_given = 1};
    vxs_result         r   = scene_load_gltf(&s->moving, c->moving_path, &all, m);
    c->options.moving      = &s->moving;
    if (r != VXS_OK || s->moving.triangle_count) return r;
    return fail(m, VXS_E_SCENE, "%s has no triangles: nothing moves", c->moving_path);
}

int render_has_baked_smoke(const render_command *c, const subject *s)
{
    int some = 0;
    for (uint32_t n = 0; n < s->light_count && c->options.baked_smoke; n++) some |= c->options.baked_smoke[n] != NULL;
    return some;
}

/* The scene's own camera, or one that sees the whole scene; on an orbit, from each of its poses. */
static vxs_result place_camera(render_command *c, subject *s, run_context *m)
{
    render_options   *o    = &c->options;
    const scene_view *view = NULL;
    if (!c->camera_name) {
        double aspect = (double)o->width_px / o->height_px;
        if (!c->camera.eye_given) camera_frame_lit(&c->camera.camera, &s->box, s->lights, s->light_count, aspect);
        if (c->orbits && !c->camera.eye_given) camera_frame_orbit(&c->camera.camera, &s->box, aspect);
        return VXS_OK;
    }
    vxs_result r = scene_camera_find(&view, &s->scene, c->camera_name, c->scene_path, m);
    if (r != VXS_OK) return r;
    if (view->kind == VIEW_ORTHOGRAPHIC && o->fog)
        return fail(m, VXS_E_ARGUMENT,
                    "--fog is of the way to an eye, and the orthographic camera '%s' has none: expected a perspective one",
                    view->name);
    scene_camera_size(view, c->width_given, c->height_given, SIDE_MAX_PX, &o->width_px, &o->height_px);
    c->camera.camera = scene_camera_pose(view, &s->box);
    return check_samples(o, m);
}

const char *render_dark_text(const scene *s, const char *name)
{
    for (size_t n = 0; n < s->lost_light_count; n++)
        if (!strcmp(s->lost_lights[n].name, name))
            return s->lost_lights[n].why ? "it cannot be read" : "it is hidden (KHR_node_visibility)";
    for (size_t n = 0; n < s->light_count; n++)
        if (!strcmp(s->lights[n].name, name)) return s->lights[n].dark;
    return NULL;
}

enum { DARK_SHOWN = 3 };

static vxs_result load(render_command *c, subject *s, run_context *m)
{
    json_t             *made = NULL;
    const vxs_contents *contents;
    vxs_result          r;
    if ((r = open_asset(c, s, &contents, m)) != VXS_OK) goto done;
    if ((r = provenance_read(&made, contents, m)) != VXS_OK) goto done;
    c->options.baked_smoke    = s->smoke;
    const json_t *baked_smoke = json_object_get(json_object_get(made, "options"), "smoke");
    if (c->options.smoke == SMOKE_ON && json_object_get(baked_smoke, "capsules"))
        memset(s->smoke, 0, sizeof s->smoke); /* the scene's capsules are drawn, too: both would dim light twice */
    if ((r = asset_scene_choice(made, &c->choice, m)) != VXS_OK) goto done;
    if ((r = scene_load_gltf(&s->scene, c->scene_path, &c->choice, m)) != VXS_OK) goto done;
    r = asset_check_scene(contents, made, c->asset_path, &s->scene, c->scene_path, "its shadows may not fit", m);
    if (r != VXS_OK) goto done;
    if (!s->scene.triangle_count) {
        r = casters_none(&s->scene, m);
        goto done;
    }

    size_t dark = 0;
    for (uint32_t n = 0; n < s->light_count; n++) {
        const char *name = s->lights[n]->light.name, *why = render_dark_text(&s->scene, name);
        if (why && ++dark <= DARK_SHOWN)
            warn(m, "light '%s' is not drawn: in the scene %s; set it there, or draw others with --light", name, why);
    }
    if (dark > DARK_SHOWN)
        warn(m, "%zu more lights are not drawn for such reasons; see to those above, and run again", dark - DARK_SHOWN);

    if ((r = run_check(m)) != VXS_OK) goto done;
    s->box = box_of_corners(s->scene.positions_ws, s->scene.indices, 3 * s->scene.triangle_count);
    if (c->moving_path && (r = load_moving(c, s, m)) != VXS_OK) goto done;
    if (c->sky_path) {
        c->options.sky = &s->sky;
        if ((r = sky_map_read(&s->sky, c->sky_path, m)) != VXS_OK) goto done;
    }

    /* does some light take steps in fog? */
    if (!c->moving_path && (c->options.smoke == SMOKE_OFF || !s->scene.smoke.count) && !render_has_baked_smoke(c, s)) {
        r = fog_check_steps(&c->fog, s->scene.smoke.count ? ", or --smoke on" : ": there is no smoke, and nothing moves", m);
        if (r != VXS_OK) goto done;
    }
    r = place_camera(c, s, m);
done:
    json_decref(made);
    return r;
}

static vxs_result run(void *command, run_context *m)
{
    render_command *c              = command;
    subject        *s              = calloc(1, sizeof *s);
    output_file     out            = {0};
    vxs_result      r              = s ? check_options(c, m) : fail(m, VXS_E_MEMORY, "out of memory for a picture");
    fog_medium      medium         = fog_of(&c->fog);
    c->options.filter              = filter_of(&c->filter);
    c->options.fog                 = c->fog.given ? &medium : NULL;
    c->options.fog_by              = c->fog.by;
    c->options.fog_steps           = c->fog.steps;
    c->options.fog_grid            = c->fog.grid;
    c->options.fog_is_half         = c->fog.is_half;
    c->options.smoke_side_is_asked = c->smoke_side_given;
    c->choice.areas                = c->draw == DRAW_GL && c->options.area_vpls;
    if (r == VXS_OK) r = load(c, s, m);
    if (r == VXS_OK) r = output_file_open(&out, c->out, m);
    if (r == VXS_OK) r = render_draw(c, s, &out, m);
    if (r == VXS_OK) r = output_file_commit(&out, m);
    if (r == VXS_OK) render_print_written(c, m);
    output_file_abort(&out);
    if (s) {
        scene_free(&s->scene);
        scene_free(&s->moving);
        sky_map_free(&s->sky);
        vxs_asset_close(s->asset);
        asset_stream_close(&s->stream);
    }
    free(s);
    return r;
}

/* c  a render_command */
/* clang-format off */
/* Area lights and the sky. */
#define VPL_ROWS(c)                                                                                                                \
    {"--area", OPTION_U32, &(c).options.area_vpls, 0, VXS_VPLS_MAX, NULL, "N",                                                    \
     "with OpenGL: virtual lights on what shines in the scene, parallelograms of two triangles; 0 to 256, 0: they do not shine "   \
     "(default 64)",                                                                                                               \
     &(c).area_given},                                                                                                             \
    {"--area-gather", OPTION_CHOICE, &(c).options.area_gather, 0, 0, AREA_GATHER_CHOICES, NULL,                                    \
     "a sample looks up every virtual light, a ninth of them, or every one for one sample in four (default quarter)", &(c).gather_given},        \
    {"--sky", OPTION_INPUT, &(c).sky_path, FILE_PICTURE, 0, NULL, "FILE",                                                          \
     "with OpenGL: a map of the sky that lights surfaces and fog, by as many virtual lights as --area says, and is seen: .hdr "    \
     "or PNG, twice as wide as high",                                                                                              \
     NULL},                                                                                                                        \
    {"--sky-light", OPTION_F64, &(c).options.sky_light, 1e-9, 1e9, NULL, "FACTOR",                                                 \
     "candela a square metre of what is 1 in the map, 1e-9 to 1e9 (default 1)", &(c).sky_light_given},                             \
    {"--sky-turn", OPTION_F64, &(c).options.sky_turn_degrees, -360, 360, NULL, "DEGREES",                                          \
     "of the map, whose middle is along +X, about +Y, counter-clockwise from above, -360 to 360 (default 0)",                      \
     &(c).sky_turn_given}

/* Frames along a path, and reports of frames. */
#define FRAME_ROWS(c)                                                                                                              \
    {"--path", OPTION_INPUT, &(c).path_file, FILE_UNKNOWN, 0, NULL, "FILE",                                                        \
     "frames along a path: lines of x y z of the eye, x y z of where it looks; the last one is the picture", NULL},                \
    {"--orbit", OPTION_SWITCH, &(c).orbits, 0, 0, NULL, NULL, "frames once around the target", NULL},                              \
    {"--frames", OPTION_U32, &(c).frames, 1, FRAMES_MAX, NULL, "N", "of --path or --orbit, 1 to 100000 (default 60)",              \
     &(c).frames_given},                                                                                                           \
    {"--json", OPTION_OUTPUT, &(c).json_path, 0, 0, ".json", "FILE.json", "times of each frame as JSON; - is standard output",     \
     NULL},                                                                                                                        \
    {"--csv", OPTION_OUTPUT, &(c).csv_path, 0, 0, ".csv", "FILE.csv", "times of each frame as a table; - is standard output",      \
     NULL},                                                                                                                        \
    {"--plot", OPTION_OUTPUT, &(c).plot_path, 0, 0, ".svg", "FILE.svg", "times of each frame as a plot; - is standard output",     \
     NULL}
/* clang-format on */

int cmd_render(int argc, char **argv)
{
    render_command  c           = {.options       = {.width_px     = 1280,
                                                     .height_px    = 720,
                                                     .samples      = 2,
                                                     .tile_lights  = TILE_LIGHTS,
                                                     .upload_bytes = UPLOAD_BYTES,
                                                     .smoke_side   = SMOKE_SIDE,
                                                     .area_vpls    = AREA_VPLS,
                                                     .area_gather  = VXS_AREA_QUARTER,
                                                     .sky_light    = 1,
                                                     .threads      = parallel_default_threads()},
                                   .filter.box_px = 5,
                                   .frames        = 60,
                                   .fog           = FOG_DEFAULTS};
    render_options *o           = &c.options;
    c.camera.camera.fov_degrees = 35;
    const option options[]      = {
             {"SCENE", OPTION_INPUT, &c.scene_path, FILE_SCENE, 0, NULL, NULL, "a glTF 2.0 scene, .gltf or .glb", NULL},
             {"FILE.vxs", OPTION_INPUT, &c.asset_path, FILE_ASSET, 0, NULL, NULL, "what vxs bake wrote", NULL},
             {"-o", OPTION_OUTPUT, &c.out, 1, 0, ".png", "OUT.png", "where the picture goes; - is standard output", NULL},
             {"--linear", OPTION_OUTPUT, &c.linear_path, 0, 0, ".exr", "FILE.exr",
              "also the picture as linear floats, as OpenEXR, and with --passes each pass; - is standard output", NULL},
             {"--draw", OPTION_CHOICE, &c.draw, 0, 0, "gl|rays", NULL,
              "with OpenGL, as a game would, or all but shadows by rays, with light from the sky (default gl)", NULL},
             {"--width", OPTION_U32, &o->width_px, SIDE_MIN_PX, SIDE_MAX_PX, NULL, "PX", "16 to 8192 (default 1280)", &c.width_given},
             {"--height", OPTION_U32, &o->height_px, SIDE_MIN_PX, SIDE_MAX_PX, NULL, "PX", "16 to 8192 (default 720)", &c.height_given},
             {"--samples", OPTION_U32, &o->samples, 1, SAMPLES_MAX, NULL, "N",
              "a pixel is the mean of N x N samples, 1 to 4 (default 2)", &c.samples_given},
             {"--exposure", OPTION_F64, &o->stops, -20, 20, NULL, "STOPS", "brighter or darker by powers of two, -20 to 20 (default 0)",
              &c.stops_given},
             CAMERA_ROWS(c.camera, c.fov_given, "where to stand, metres (default all of the scene in view)"),
             {"--camera", OPTION_TEXT, &c.camera_name, 0, 0, NULL, "NAME",
              "a camera of the scene, by its name, a pattern, or its number from 0; without --width or --height the picture has its "
                   "shape",
              NULL},
             {"--light", OPTION_TEXTS, &c.light_names, 0, 0, NULL, "NAME",
              "a light that shines, or all that a pattern names; repeat for more (default all of the file)", NULL},
             FILTER_ROWS(c.filter, "K x K box filter, K odd, 1 to 17 texels (default 5)"),
             FOG_ROWS(c.fog),
             VPL_ROWS(c),
             {"--smoke", OPTION_CHOICE, &o->smoke, 0, 0, SMOKE_CHOICES, NULL,
              "points and lines of the scene that are smoke dim light, and are drawn (default on)", &c.smoke_given},
             {"--smoke-side", OPTION_U32, &o->smoke_side, SMOKE_SIDE_MIN, SMOKE_SIDE_MAX, NULL, "PX",
              "curves a side of a light's map of smoke, 16 to 2048; fewer where smoke is very thick (default 256)", &c.smoke_side_given},
             {"--moving", OPTION_INPUT, &c.moving_path, FILE_SCENE, 0, NULL, "SCENE",
              "another scene that is not baked: it is drawn, and casts shadows by depth maps", NULL},
             {"--moving-by", OPTION_VECTOR, o->moving_by_ws, 0, 3, NULL, "X,Y,Z",
              "metres that it moves from frame to frame (default 0,0,0)", &c.moving_by_given},
             {"--cull", OPTION_CHOICE, &o->cull, 0, 0, CULL_CHOICES, NULL,
              "lists of lights for tiles of 8 x 8 pixels; auto: where there are several lights (default auto)", &c.cull_given},
             {"--budget", OPTION_BYTES, &c.budget_bytes, 0, 0, NULL, "BYTES",
              "stream FILE.vxs: hold no more of it than this, 4M or plain bytes (default all of the file)", &c.budget_given},
             {"--upload", OPTION_BYTES, &o->upload_bytes, 0, 0, NULL, "BYTES",
              "of a stream's pages, in each frame of a path at most (default 1M)", &c.upload_given},
             {"--passes", OPTION_FOLDER, &c.passes_folder, 0, 0, RENDER_PASSES_NAMES, "FOLDER",
              "also depth, normals, light, lights of each pixel, each light's shadow, what rays say, and of a stream what is there, as "
                   "PNG",
              NULL},
             FRAME_ROWS(c),
             {"--gl", OPTION_CHOICE, &o->backend, 0, 0, "osmesa|egl", NULL, "OpenGL by OSMesa, or by EGL for a GPU (default osmesa)",
              NULL},
             SCENE_ROWS(c.choice),
             {"--threads", OPTION_U32, &o->threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "threads (default all processors)", NULL},
    };
    const command_line line = COMMAND_LINE("render", "SCENE FILE.vxs -o OUT.png [options]",
                                           "Draw a picture (PNG) of a scene with the shadows of a .vxs file.", options);
    return command_run(&line, argc, argv, run, &c);
}
