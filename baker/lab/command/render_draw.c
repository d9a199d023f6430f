/* Pictures of vxs render, by OpenGL or by rays, and their reports; see render_command.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/command/render_command.h"

#include <stdlib.h>

#include "baker/base/clock.h"
#include "baker/files/json_file.h"
#include "baker/files/png_encode.h"
#include "baker/lab/command/report_text.h"
#include "baker/lab/picture/picture.h"
#include "baker/lab/render/exr_encode.h"

/* Rays treat solids and sheets alike, so components are not classified. */
static vxs_result make_truth(truth **t, casters *casting, const subject *s, uint32_t threads, run_context *m)
{
    vxs_result r = casters_from_scene(casting, &s->scene, CLOSED_OFF, threads, m);
    return r == VXS_OK ? truth_create(t, casting, threads, m) : r;
}

/* The picture in memory. */
typedef struct pixels {
    uint8_t *rgb;    /* [3 * width * height] from renderer_draw */
    float   *linear; /* likewise, from renderer_read_linear; NULL: not wanted */
    double   white;  /* of render_facts; 0: unknown */
} pixels;

static vxs_result draw_by_rays(const render_command *c, const subject *s, const pixels *to, run_context *m)
{
    picture_options        o       = {.width_px  = c->options.width_px,
                                      .height_px = c->options.height_px,
                                      .filter    = c->options.filter,
                                      .threads   = c->options.threads,
                                      .fog       = c->options.fog,
                                      .camera    = c->camera.camera};
    casters                casting = {0};
    truth                 *t       = NULL;
    vxs_result             r       = make_truth(&t, &casting, s, o.threads, m);
    const vxs_baked_light *lights[VXS_LIGHTS_MAX];
    uint32_t               count = 0;
    for (uint32_t n = 0; n < s->light_count; n++)
        if (!render_dark_text(&s->scene, s->lights[n]->light.name)) lights[count++] = s->lights[n];
    if (r == VXS_OK) r = picture_render(to->rgb, to->linear, &o, t, &casting, lights, count, m);
    truth_destroy(t);
    casters_free(&casting);
    return r;
}

static vxs_result write_passes(const render_command *c, const subject *s, renderer *drawn, truth_difference *difference,
                               run_context *m)
{
    casters    casting = {0};
    truth     *t       = NULL;
    vxs_result r       = make_truth(&t, &casting, s, c->options.threads, m);
    if (r == VXS_OK)
        r = render_passes(drawn, c->passes_folder, s->lights, s->light_count,
                          &(passes_options){.streamed  = c->budget_given,
                                            .is_linear = c->linear_path != NULL,
                                            .truth     = t,
                                            .filter    = c->options.filter,
                                            .threads   = c->options.threads},
                          difference, m);
    truth_destroy(t);
    casters_free(&casting);
    return r;
}

/* The stream of the report; NULL: no report. */
static FILE *report_of(const render_command *c, const run_context *m)
{
    const char *outs[] = {c->out, c->linear_path, c->json_path, c->csv_path, c->plot_path};
    int         taken  = 0;
    for (int n = 0; n < 5; n++) taken |= outs[n] && is_standard_output(outs[n]);
    return report_stream(m, taken);
}

/* vpls  NULL: there are none */
static vpl_words words_of_vpls(const render_command *c, const subject *s, const vpl_pass *vpls)
{
    vpl_words w = {.gather = area_gather_names[c->options.area_gather], .baked = c->options.area_points != NULL};
    if (!vpls) return w;
    w.points      = vpls->points + vpls->moving_points;
    w.capsules    = vpls->capsule_count;
    w.smoke_side  = vpls->options.smoke_side;
    w.baked_smoke = render_has_baked_smoke(c, s);
    return w;
}

/* Write the requested reports of frames [count], and print the plan of the last one. */
static vxs_result report_frames(const render_command *c, const subject *s, const renderer *drawn, const drawn_frame *frames,
                                uint32_t count, const truth_difference *difference, run_context *m)
{
    render_facts     facts = renderer_facts(drawn);
    const area_pass *lit   = facts.areas;
    area_words areas = {.scene = &s->scene, .shares = lit ? lit->shares : NULL, .lit = words_of_vpls(c, s, lit ? lit->vpls : NULL)};
    sky_words  sky   = {.path         = c->sky_path,
                        .wide_px      = s->sky.wide_px,
                        .high_px      = s->sky.high_px,
                        .light        = c->options.sky_light,
                        .turn_degrees = c->options.sky_turn_degrees,
                        .vpls         = c->options.area_vpls,
                        .lit          = words_of_vpls(c, s, facts.sky ? facts.sky->vpls : NULL)};
    render_report report = {.scene_path   = c->scene_path,
                            .asset_path   = c->asset_path,
                            .moving_path  = c->moving_path,
                            .options      = &c->options,
                            .facts        = &facts,
                            .capsules     = s->scene.smoke.count,
                            .areas        = lit || (c->area_given && c->options.area_vpls && !c->sky_path) ? &areas : NULL,
                            .sky          = c->sky_path ? &sky : NULL,
                            .lights       = s->lights,
                            .light_count  = s->light_count,
                            .budget_bytes = c->budget_given ? c->budget_bytes : 0,
                            .frames       = frames,
                            .frame_count  = count,
                            .difference   = c->passes_folder ? difference : NULL};
    vxs_result    r      = VXS_OK;
    uint32_t      words  = 0;
    if (s->stream.stream) vxs_stream_words(s->stream.stream, &words);
    report.word_bytes = words * sizeof(uint32_t);
    for (uint32_t n = 0; n < s->light_count && !s->stream.stream; n++)
        report.word_bytes += (uint64_t)s->lights[n]->word_count * sizeof(uint32_t);
    if (c->json_path) r = json_write(c->json_path, render_report_json(&report), m);
    if (r == VXS_OK && c->csv_path) r = render_report_csv(&report, c->csv_path, m);
    if (r == VXS_OK && c->plot_path) r = render_report_plot(&report, c->plot_path, m);
    FILE *to = report_of(c, m);
    if (r == VXS_OK && to) render_report_print(to, &report, m->verbose);
    return r;
}

void render_print_written(const render_command *c, const run_context *m)
{
    FILE *to = report_of(c, m);
    char  size[48];
    if (!to) return;
    snprintf(size, sizeof size, "%u x %u pixels", c->options.width_px, c->options.height_px);
    written_print(to, c->passes_folder, "passes, as pictures");
    written_print(to, c->json_path, "times of frames as JSON");
    written_print(to, c->csv_path, "times of frames as a table");
    written_print(to, c->plot_path, "times of frames as a plot");
    written_print(to, c->linear_path, "the picture as linear floats");
    written_print(to, c->out, size);
}

/* Draw each frame of a path, or a single frame without a path; the last one is the picture. A stream is filled before the first
 * frame, as by a loading screen; later frames have the pages loaded meanwhile. */
static vxs_result draw_by_gl(const render_command *c, subject *s, pixels *to, run_context *m)
{
    renderer        *drawn      = NULL;
    camera_path      path       = {0};
    truth_difference difference = {0};
    uint32_t         count      = c->path_file || c->orbits ? c->frames : 1;
    drawn_frame     *frames     = calloc(count, sizeof *frames);
    vxs_result       r          = frames ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for %u frames", count);
    if (r == VXS_OK && c->path_file) r = camera_path_read(&path, c->path_file, c->camera.camera.fov_degrees, m);
    if (r == VXS_OK && c->orbits) r = camera_path_orbit(&path, &c->camera.camera, m);
    for (uint32_t n = 0; n < count && r == VXS_OK; n++) {
        drawn_frame *f     = &frames[n];
        double       share = count > 1 ? (double)n / (path.closed ? count : count - 1) : 0;
        f->camera          = path.count ? camera_path_at(&path, share) : c->camera.camera;
        if (c->budget_given) {
            double        since   = clock_seconds();
            const double *eye_ws  = f->camera.eye_ws;
            f->stream.struct_size = sizeof f->stream;
            r = n ? asset_stream_frame(&s->stream, eye_ws, &f->stream, m) : asset_stream_fill(&s->stream, eye_ws, &f->stream, m);
            f->read_bytes   = f->stream.bytes_read - (n ? f[-1].stream.bytes_read : 0);
            f->wait_seconds = clock_seconds() - since;
        }
        if (r == VXS_OK && !n) r = renderer_create(&drawn, &c->options, &s->scene, s->lights, s->light_count, m);
        if (r == VXS_OK) r = renderer_draw(drawn, &f->camera, n + 1 == count ? to->rgb : NULL, &f->frame, m);
    }
    if (r == VXS_OK && to->linear) r = renderer_read_linear(drawn, to->linear, m);
    if (r == VXS_OK) to->white = renderer_facts(drawn).white;
    if (r == VXS_OK && c->passes_folder) r = write_passes(c, s, drawn, &difference, m);
    if (r == VXS_OK) r = report_frames(c, s, drawn, frames, count, &difference, m);
    renderer_destroy(drawn);
    camera_path_free(&path);
    free(frames);
    return r;
}

vxs_result render_draw(const render_command *c, subject *s, output_file *out, run_context *m)
{
    uint32_t    width = c->options.width_px, height = c->options.height_px;
    size_t      count = (size_t)3 * width * height, size_bytes = 0;
    uint8_t    *png = NULL, *exr = NULL;
    output_file linear = {0};
    pixels      p      = {.rgb = malloc(count), .linear = c->linear_path ? malloc(count * sizeof(float)) : NULL};
    vxs_result  r      = VXS_E_MEMORY;
    if (p.rgb && (p.linear || !c->linear_path)) r = c->draw == DRAW_RAYS ? draw_by_rays(c, s, &p, m) : draw_by_gl(c, s, &p, m);
    if (r != VXS_OK) goto done;
    if (p.linear) { /* linear colours, as OpenEXR */
        exr = exr_encode(p.linear, width, height, "RGB", (float)p.white, &size_bytes);
        r   = exr ? output_file_open(&linear, c->linear_path, m) : VXS_E_MEMORY;
        if (r == VXS_OK) r = output_file_write(&linear, exr, size_bytes, m);
        if (r == VXS_OK) r = output_file_commit(&linear, m);
        if (r != VXS_OK) goto done;
    }
    png = png_encode(p.rgb, width, height, 3, &size_bytes);
    r   = png ? output_file_write(out, png, size_bytes, m) : VXS_E_MEMORY;
done:
    output_file_abort(&linear);
    free(exr);
    free(png);
    free(p.rgb);
    free(p.linear);
    if (r != VXS_E_MEMORY) return r;
    return fail(m, r, "out of memory for a picture of %u x %u pixels", width, height); /* the first message stays */
}
