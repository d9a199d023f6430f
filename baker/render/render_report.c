/* What frames took; see render_report.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/render/render_report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "baker/base/text.h"
#include "baker/base/version.h"
#include "baker/files/json_value.h"
#include "baker/files/output_file.h"
#include "baker/measure/spread.h"

static double total_of(const render_frame *f)
{
    double sum = 0;
    for (int n = 0; n < RENDER_STAGES; n++) sum += f->seconds[n];
    return sum;
}

static double lights_per_pixel(const render_frame *f)
{
    return f->surface_pixels ? (double)f->asked_lights / (double)f->surface_pixels : 0;
}

static json_t *milliseconds(double seconds)
{
    return json_real(rounded(1000 * seconds, 4));
}

static json_t *frame_json(const drawn_frame *d)
{
    json_t *o = json_object(), *stages = json_object();
    for (int n = 0; n < RENDER_STAGES; n++) json_set(&stages, render_stage_names[n], milliseconds(d->frame.seconds[n]));
    json_set(&o, "eye", json_vector(d->camera.eye_ws));
    json_set(&o, "target", json_vector(d->camera.target_ws));
    json_set(&o, "ms", stages);
    json_set(&o, "total_ms", milliseconds(total_of(&d->frame)));
    json_set(&o, "surface_samples", json_integer((json_int_t)d->frame.surface_pixels));
    json_set(&o, "lights_per_sample", json_real(rounded(lights_per_pixel(&d->frame), 4)));
    json_set(&o, "longest_list", json_integer(d->frame.longest_list));
    return o;
}

/* Of stages of all frames but the first, in which shaders are made ready, where there are several; then of their sums. */
static json_t *median_json(const render_report *r)
{
    size_t  skipped = r->frame_count > 1, count = r->frame_count - skipped;
    double *values = malloc(count * sizeof *values);
    json_t *o      = values ? json_object() : NULL;
    for (int stage = 0; stage <= RENDER_STAGES && values; stage++) {
        for (size_t n = 0; n < count; n++) {
            const render_frame *f = &r->frames[skipped + n].frame;
            values[n]             = stage < RENDER_STAGES ? f->seconds[stage] : total_of(f);
        }
        json_set(&o, stage < RENDER_STAGES ? render_stage_names[stage] : "total",
                 milliseconds(spread_of(values, (uint32_t)count).median));
    }
    free(values);
    return o;
}

static json_t *difference_json(const truth_difference *d)
{
    json_t *o = json_object();
    json_set(&o, "samples", json_integer((json_int_t)d->asked));
    json_set(&o, "mean", json_real(rounded(d->mean, 4)));
    json_set(&o, "too_dark", json_integer((json_int_t)d->too_dark));
    json_set(&o, "too_light", json_integer((json_int_t)d->too_light));
    return o;
}

json_t *render_report_json(const render_report *r)
{
    json_t *o = json_object(), *frames = json_array();
    for (size_t n = 0; n < r->frame_count; n++) json_append(&frames, frame_json(&r->frames[n]));
    json_set(&o, "generator", json_text("vxs " VXS_VERSION));
    json_set(&o, "scene", json_text(r->scene_path));
    json_set(&o, "asset", json_text(r->asset_path));
    json_set(&o, "renderer", json_text(r->renderer));
    json_set(&o, "width_px", json_integer(r->options->width_px));
    json_set(&o, "height_px", json_integer(r->options->height_px));
    json_set(&o, "samples", json_integer(r->options->samples));
    json_set(&o, "filter_px", json_integer(r->options->filter_px % VXS_SMOOTH));
    json_set(&o, "smooth", json_boolean(r->options->filter_px >= VXS_SMOOTH));
    json_set(&o, "lights", json_integer(r->light_count));
    json_set(&o, "culling", json_boolean(r->culls));
    json_set(&o, "word_bytes", json_integer((json_int_t)r->word_bytes));
    json_set(&o, "frames", frames);
    json_set(&o, "median_ms", median_json(r));
    if (r->difference) json_set(&o, "difference", difference_json(r->difference));
    return o;
}

vxs_result render_report_csv(const render_report *r, const char *path, message *m)
{
    output_file out    = {0};
    vxs_result  result = output_file_open(&out, path, m);
    if (result != VXS_OK) return result;
    fputs("frame,eye_x,eye_y,eye_z,target_x,target_y,target_z", out.stream);
    for (int n = 0; n < RENDER_STAGES; n++) fprintf(out.stream, ",%s_ms", render_stage_names[n]);
    fputs(",total_ms,surface_samples,lights_per_sample,longest_list\n", out.stream);
    for (size_t n = 0; n < r->frame_count; n++) {
        const drawn_frame *d = &r->frames[n];
        fprintf(out.stream, "%zu", n);
        for (int k = 0; k < 6; k++) fprintf(out.stream, ",%.6g", k < 3 ? d->camera.eye_ws[k] : d->camera.target_ws[k - 3]);
        for (int k = 0; k < RENDER_STAGES; k++) fprintf(out.stream, ",%.4g", 1000 * d->frame.seconds[k]);
        fprintf(out.stream, ",%.4g,%llu,%.4g,%u\n", 1000 * total_of(&d->frame), (unsigned long long)d->frame.surface_pixels,
                lights_per_pixel(&d->frame), d->frame.longest_list);
    }
    result = output_file_commit(&out, m);
    output_file_abort(&out);
    return result;
}

/* plot ---------------------------------------------------------------------------------------------------------------------------- */

enum { PLOT_WIDE = 900, PLOT_HIGH = 360, LEFT = 60, RIGHT = 150, TOP = 20, BOTTOM = 40 };

static const char *const plot_colours[RENDER_STAGES] = {"#4477aa", "#ccbb44", "#cc6677", "#999999"};

/* 1, 2 or 5 times a power of ten, five of which or fewer reach `most`. */
static double step_for(double most)
{
    double power = pow(10, floor(log10(most / 5)));
    for (int n = 0; n < 3; n++) {
        double step = (const double[]){1, 2, 5}[n] * power;
        if (most / step <= 5) return step;
    }
    return 10 * power;
}

static double x_of(const render_report *r, size_t frame)
{
    return LEFT + (PLOT_WIDE - LEFT - RIGHT) * (r->frame_count > 1 ? (double)frame / (double)(r->frame_count - 1) : 0.5);
}

static double y_of(double ms, double most)
{
    return PLOT_HIGH - BOTTOM - (PLOT_HIGH - TOP - BOTTOM) * ms / most;
}

/* Milliseconds of the stages before one. */
static double below(const render_frame *f, int stage)
{
    double sum = 0;
    for (int n = 0; n < stage; n++) sum += 1000 * f->seconds[n];
    return sum;
}

static void plot_stage(FILE *to, const render_report *r, int stage, double most)
{
    fprintf(to, "<polygon fill=\"%s\" points=\"", plot_colours[stage]);
    for (size_t n = 0; n < r->frame_count; n++)
        fprintf(to, "%.1f,%.1f ", x_of(r, n), y_of(fmin(most, below(&r->frames[n].frame, stage + 1)), most));
    for (size_t n = r->frame_count; n-- > 0;)
        fprintf(to, "%.1f,%.1f ", x_of(r, n), y_of(fmin(most, below(&r->frames[n].frame, stage)), most));
    fprintf(to, "\"/>\n<rect x=\"%d\" y=\"%d\" width=\"12\" height=\"12\" fill=\"%s\"/><text x=\"%d\" y=\"%d\">%s</text>\n",
            PLOT_WIDE - RIGHT + 20, TOP + 22 * (RENDER_STAGES - 1 - stage), plot_colours[stage], PLOT_WIDE - RIGHT + 38,
            TOP + 11 + 22 * (RENDER_STAGES - 1 - stage), render_stage_names[stage]);
}

vxs_result render_report_plot(const render_report *r, const char *path, message *m)
{
    output_file out    = {0};
    vxs_result  result = output_file_open(&out, path, m);
    double      most   = 1e-3;
    if (result != VXS_OK) return result;
    /* in the first frame shaders are made ready: it may stand out of the plot */
    for (size_t n = r->frame_count > 1; n < r->frame_count; n++) most = fmax(most, 1050 * total_of(&r->frames[n].frame));
    fprintf(out.stream,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" font-family=\"sans-serif\" font-size=\"13\">\n",
            PLOT_WIDE, PLOT_HIGH);
    fprintf(out.stream, "<rect width=\"%d\" height=\"%d\" fill=\"white\"/>\n", PLOT_WIDE, PLOT_HIGH);
    for (int n = 0; n < RENDER_STAGES; n++) plot_stage(out.stream, r, n, most);
    for (double ms = 0, step = step_for(most); ms <= most; ms += step)
        fprintf(out.stream, "<path stroke=\"#ccc\" d=\"M%d %.1fH%d\"/><text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%g</text>\n",
                LEFT, y_of(ms, most), PLOT_WIDE - RIGHT, LEFT - 6, y_of(ms, most) + 4, ms);
    fprintf(out.stream, "<text x=\"%d\" y=\"%d\">frames 0 to %zu, milliseconds; %u lights</text>\n</svg>\n", LEFT, PLOT_HIGH - 12,
            r->frame_count - 1, r->light_count);
    result = output_file_commit(&out, m);
    output_file_abort(&out);
    return result;
}
