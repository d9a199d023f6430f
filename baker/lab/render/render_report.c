/* Measurements of frames; see render_report.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/render_report.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/spread.h"
#include "baker/base/text.h"
#include "baker/base/version.h"
#include "baker/files/json_value.h"
#include "baker/files/output_file.h"

static int has_stage(const render_report *r, int stage)
{
    if (stage == RENDER_SMOKE) return r->facts->smoke_lights != NULL;
    if (stage == RENDER_AREA) return r->areas && r->areas->shares;
    if (stage == RENDER_SKY) return r->sky != NULL;
    return stage == RENDER_UPLOAD   ? r->budget_bytes != 0
           : stage == RENDER_MOVING ? r->options->moving != NULL
                                    : stage != RENDER_FOG || r->options->fog;
}

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

static double full_share(const render_frame *f)
{
    return f->surface_pixels ? (double)f->full_pixels / (double)f->surface_pixels : 1;
}

static json_t *milliseconds(double seconds)
{
    return json_real(rounded(1000 * seconds, 4));
}

/* A number of a stream's frame, in JSON and as a column. */
typedef struct stream_number {
    const char *name;
    double      value;
    int         whole;
} stream_number;

enum { STREAM_NUMBERS = 10 };

static void stream_numbers(const drawn_frame *d, stream_number numbers[STREAM_NUMBERS])
{
    const stream_number all[STREAM_NUMBERS] = {
        {"wait_ms", 1000 * d->wait_seconds, 0},
        {"read_bytes", (double)d->read_bytes, 1},
        {"uploaded_bytes", (double)d->frame.uploaded_bytes, 1},
        {"waiting_bytes", (double)d->frame.waiting_bytes, 1},
        {"resident_bytes", (double)d->stream.bytes_resident, 1},
        {"pages", d->stream.pages, 1},
        {"pages_resident", d->stream.pages_resident, 1},
        {"pages_appeared", d->stream.appeared, 1},
        {"pages_left", d->stream.left, 1},
        {"full_share", full_share(&d->frame), 0},
    };
    memcpy(numbers, all, sizeof all);
}

static json_t *frame_json(const render_report *r, const drawn_frame *d)
{
    const render_frame *f      = &d->frame;
    json_t             *stages = json_object();
    for (int n = 0; n < RENDER_STAGES; n++)
        if (has_stage(r, n)) json_set(&stages, render_stage_names[n], milliseconds(f->seconds[n]));
    json_t *o = json_pack("{s:o, s:o, s:o, s:o, s:I, s:f, s:i}", "eye", json_vector(d->camera.eye_ws), "target",
                          json_vector(d->camera.target_ws), "ms", stages, "total_ms", milliseconds(total_of(f)), "surface_samples",
                          (json_int_t)f->surface_pixels, "lights_per_sample", rounded(lights_per_pixel(f), 4), "longest_list",
                          (int)f->longest_list);
    if (r->options->fog) json_set(&o, "fog_lights", fog_plan_counts(&f->fog));
    if (r->options->moving)
        json_set(&o, "moving",
                 json_pack("{s:i, s:i, s:i}", "lights", (int)f->moving.lights, "maps", (int)f->moving.maps, "left_out",
                           (int)f->moving.left_out));
    if (r->facts->smoke_lights) json_set(&o, "smoke_lights", smoke_plan_counts(&f->smoke));
    if (r->areas) json_set(&o, "area_lights", area_plan_counts(&f->area));
    if (r->budget_bytes) {
        stream_number n[STREAM_NUMBERS];
        json_t       *stream = json_object();
        stream_numbers(d, n);
        for (int k = 0; k < STREAM_NUMBERS; k++)
            json_set(&stream, n[k].name, n[k].whole ? json_integer((json_int_t)n[k].value) : json_real(rounded(n[k].value, 4)));
        json_set(&o, "stream", stream);
    }
    return o;
}

/* Medians of stages and of their sums, without the first frame if there are several: it compiles shaders. */
static json_t *median_json(const render_report *r)
{
    size_t  skipped = r->frame_count > 1, count = r->frame_count - skipped;
    double *values = malloc(count * sizeof *values);
    json_t *o      = values ? json_object() : NULL;
    for (int stage = 0; stage <= RENDER_STAGES && values; stage++) {
        if (!has_stage(r, stage)) continue;
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

static json_t *fog_json(const render_report *r)
{
    const render_options *o    = r->options;
    const fog_plan       *last = &r->frames[r->frame_count - 1].frame.fog;
    json_t               *top  = o->fog->top_ws < INFINITY ? json_real(o->fog->top_ws) : json_null();
    json_t               *fog  = json_pack("{s:o, s:o, s:f, s:o, s:s}", "extinction_per_metre", json_vector(o->fog->extinction),
                                           "scattering_per_metre", json_vector(o->fog->scattering), "anisotropy", o->fog->anisotropy, "top_metres",
                                           top, "by", fog_by_names[o->fog_by]);
    if (o->moving || r->facts->smoke_lights || last->by_angles || o->fog_by == FOG_BY_MARCH || o->fog_by == FOG_BY_ANGLES)
        json_set(&fog, "steps", json_integer(o->fog_steps));
    if (o->fog_is_half) json_set(&fog, "is_half", json_true());
    if (r->facts->fog_grid) json_set(&fog, "grid", json_integer(r->facts->fog_grid));
    json_set(&fog, "lights", fog_plan_lights(r->facts->fog_lights, r->lights, r->light_count));
    json_set(&fog, "left_out", fog_plan_left_out(last, o->fog_by, r->light_count));
    return fog;
}

json_t *render_report_json(const render_report *r)
{
    const render_options *q      = r->options;
    json_t               *frames = json_array();
    for (size_t n = 0; n < r->frame_count; n++) json_append(&frames, frame_json(r, &r->frames[n]));
    json_t *o = json_pack("{s:s, s:o, s:o, s:o, s:i, s:i, s:i, s:i, s:b, s:i, s:b, s:I}", "generator", "vxs " VXS_VERSION, "scene",
                          json_text(r->scene_path), "asset", json_text(r->asset_path), "renderer", json_text(r->facts->name),
                          "width_px", (int)q->width_px, "height_px", (int)q->height_px, "samples", (int)q->samples, "filter_px",
                          q->filter.width_px, "smooth", q->filter.is_smooth, "lights", (int)r->light_count, "culling",
                          r->facts->culls, "word_bytes", (json_int_t)r->word_bytes);
    if (r->options->fog) json_set(&o, "fog", fog_json(r));
    if (r->moving_path) json_set(&o, "moving", json_text(r->moving_path));
    if (r->facts->smoke_lights)
        json_set(&o, "smoke",
                 json_pack("{s:i, s:i, s:o}", "capsules", (int)r->capsules, "side_px", (int)q->smoke_side, "lights",
                           smoke_plan_lights(r->facts->smoke_lights, r->lights, r->light_count)));
    if (r->areas) json_set(&o, "area", area_plan_json(&r->frames[r->frame_count - 1].frame.area, r->areas));
    if (r->sky) json_set(&o, "sky", sky_plan_json(r->sky));
    if (r->budget_bytes) {
        json_set(&o, "budget_bytes", json_integer((json_int_t)r->budget_bytes));
        json_set(&o, "held_bytes", json_integer((json_int_t)r->frames[0].stream.bytes_held));
    }
    json_set(&o, "frames", frames);
    json_set(&o, "median_ms", median_json(r));
    const truth_difference *d = r->difference;
    if (d)
        json_set(&o, "difference",
                 json_pack("{s:I, s:f, s:I, s:I}", "samples", (json_int_t)d->asked, "mean", rounded(d->mean, 4), "too_dark",
                           (json_int_t)d->too_dark, "too_light", (json_int_t)d->too_light));
    return o;
}

void render_report_print(FILE *to, const render_report *r, int verbose)
{
    const render_frame *last   = &r->frames[r->frame_count - 1].frame;
    const moving_plan  *moving = &last->moving;
    if (r->options->moving) {
        fprintf(to, "moving       seen by %u light%s in %u depth map%s", moving->lights, moving->lights == 1 ? "" : "s",
                moving->maps, moving->maps == 1 ? "" : "s");
        if (moving->left_out) fprintf(to, ", not by %u more: %d maps are drawn in a frame", moving->left_out, MOVING_MAPS);
        fputc('\n', to);
    }
    if (r->facts->smoke_lights)
        smoke_plan_print(to, &last->smoke, r->capsules, r->options->smoke_side, r->facts->smoke_lights, r->lights, r->light_count,
                         verbose);
    if (r->areas) area_plan_print(to, &last->area, r->areas, verbose);
    if (r->sky) sky_plan_print(to, r->sky, verbose);
    if (r->options->fog)
        fog_plan_print(to, &last->fog, r->options->fog_by, r->facts->fog_lights, r->lights, r->light_count, verbose);
}

vxs_result render_report_csv(const render_report *r, const char *path, run_context *m)
{
    output_file   out    = {0};
    vxs_result    result = output_file_open(&out, path, m);
    stream_number numbers[STREAM_NUMBERS];
    if (result != VXS_OK) return result;
    stream_numbers(&r->frames[0], numbers);
    fputs("frame,eye_x,eye_y,eye_z,target_x,target_y,target_z", out.stream);
    for (int n = 0; n < RENDER_STAGES; n++)
        if (has_stage(r, n)) fprintf(out.stream, ",%s_ms", render_stage_names[n]);
    fputs(",total_ms,surface_samples,lights_per_sample,longest_list", out.stream);
    for (int k = 0; k < STREAM_NUMBERS && r->budget_bytes; k++) fprintf(out.stream, ",%s", numbers[k].name);
    fputc('\n', out.stream);
    for (size_t n = 0; n < r->frame_count; n++) {
        const drawn_frame *d = &r->frames[n];
        fprintf(out.stream, "%zu", n);
        for (int k = 0; k < 6; k++) fprintf(out.stream, ",%.6g", k < 3 ? d->camera.eye_ws[k] : d->camera.target_ws[k - 3]);
        for (int k = 0; k < RENDER_STAGES; k++)
            if (has_stage(r, k)) fprintf(out.stream, ",%.4g", 1000 * d->frame.seconds[k]);
        fprintf(out.stream, ",%.4g,%llu,%.4g,%u", 1000 * total_of(&d->frame), (unsigned long long)d->frame.surface_pixels,
                lights_per_pixel(&d->frame), d->frame.longest_list);
        stream_numbers(d, numbers);
        for (int k = 0; k < STREAM_NUMBERS && r->budget_bytes; k++)
            fprintf(out.stream, numbers[k].whole ? ",%.0f" : ",%.4g", numbers[k].value);
        fputc('\n', out.stream);
    }
    result = output_file_commit(&out, m);
    output_file_abort(&out);
    return result;
}

/* plot ------------------------------------------------------------------------------------------------------------------------- */

enum { PLOT_WIDE = 900, PLOT_HIGH = 360, LEFT = 60, RIGHT = 150, TOP = 20, BOTTOM = 40, STREAM_HIGH = 160 };

static const char *const plot_colours[RENDER_STAGES] = {"#66ccee", "#117733", "#4477aa", "#ddaa99", "#ccbb44",
                                                        "#cc6677", "#228833", "#88ccee", "#aa3377", "#999999"};

static double x_of(const render_report *r, size_t frame)
{
    return LEFT + (PLOT_WIDE - LEFT - RIGHT) * (r->frame_count > 1 ? (double)frame / (double)(r->frame_count - 1) : 0.5);
}

static double y_of(double ms, double most)
{
    return PLOT_HIGH - BOTTOM - (PLOT_HIGH - TOP - BOTTOM) * ms / most;
}

/* The sum of the stages below one in the plot, milliseconds. */
static double below(const render_frame *f, int stage)
{
    double sum = 0;
    for (int n = 0; n < stage; n++) sum += 1000 * f->seconds[n];
    return sum;
}

/* Uploaded bytes of each frame but the first as bars; the share of samples that are answered in full as a line. */
static void plot_stream(FILE *to, const render_report *r)
{
    const double foot = PLOT_HIGH + STREAM_HIGH - BOTTOM, high = STREAM_HIGH - BOTTOM - 10;
    uint64_t     most = 1;
    char         a[32], b[32], c[32];
    for (size_t n = 1; n < r->frame_count; n++)
        if (r->frames[n].frame.uploaded_bytes > most) most = r->frames[n].frame.uploaded_bytes;
    fputs("<path stroke=\"#66ccee\" stroke-width=\"3\" d=\"", to);
    for (size_t n = 1; n < r->frame_count; n++)
        fprintf(to, "M%.1f %.1fv%.1f", x_of(r, n), foot, -high * (double)r->frames[n].frame.uploaded_bytes / (double)most);
    fputs("\"/>\n<polyline fill=\"none\" stroke=\"#228833\" stroke-width=\"2\" points=\"", to);
    for (size_t n = 0; n < r->frame_count; n++)
        fprintf(to, "%.1f,%.1f ", x_of(r, n), foot - high * full_share(&r->frames[n].frame));
    fprintf(to, "\"/>\n<path stroke=\"#ccc\" d=\"M%d %.1fH%dM%d %.1fH%d\"/>\n", LEFT, foot, PLOT_WIDE - RIGHT, LEFT, foot - high,
            PLOT_WIDE - RIGHT);
    fprintf(to,
            "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">100 %%</text><text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">0</text>\n",
            LEFT - 6, foot - high + 4, LEFT - 6, foot + 4);
    fprintf(to, "<text x=\"%d\" y=\"%.1f\" fill=\"#228833\">in full</text>\n", PLOT_WIDE - RIGHT + 20, foot - high + 4);
    fprintf(to, "<text x=\"%d\" y=\"%.1f\">samples in full; bytes uploaded, %s at most; %s resident of %s</text>\n", LEFT,
            foot + 28, size_text(a, most), size_text(b, r->frames[r->frame_count - 1].stream.bytes_resident),
            size_text(c, r->budget_bytes));
}

vxs_result render_report_plot(const render_report *r, const char *path, run_context *m)
{
    output_file out    = {0};
    vxs_result  result = output_file_open(&out, path, m);
    double      most   = 1e-3;
    int         high   = PLOT_HIGH + (r->budget_bytes ? STREAM_HIGH : 0);
    if (result != VXS_OK) return result;
    /* the first frame compiles shaders: it may exceed the plot */
    for (size_t n = r->frame_count > 1; n < r->frame_count; n++) most = fmax(most, 1050 * total_of(&r->frames[n].frame));
    fprintf(out.stream,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" font-family=\"sans-serif\" font-size=\"13\">\n",
            PLOT_WIDE, high);
    fprintf(out.stream, "<rect width=\"%d\" height=\"%d\" fill=\"white\"/>\n", PLOT_WIDE, high);
    for (int n = 0; n < RENDER_STAGES; n++)
        if (has_stage(r, n)) {
            FILE *to = out.stream;
            fprintf(to, "<polygon fill=\"%s\" points=\"", plot_colours[n]);
            for (size_t k = 0; k < r->frame_count; k++)
                fprintf(to, "%.1f,%.1f ", x_of(r, k), y_of(fmin(most, below(&r->frames[k].frame, n + 1)), most));
            for (size_t k = r->frame_count; k-- > 0;)
                fprintf(to, "%.1f,%.1f ", x_of(r, k), y_of(fmin(most, below(&r->frames[k].frame, n)), most));
            fprintf(to, "\"/>\n<rect x=\"%d\" y=\"%d\" width=\"12\" height=\"12\" fill=\"%s\"/><text x=\"%d\" y=\"%d\">%s</text>\n",
                    PLOT_WIDE - RIGHT + 20, TOP + 22 * (RENDER_STAGES - 1 - n), plot_colours[n], PLOT_WIDE - RIGHT + 38,
                    TOP + 11 + 22 * (RENDER_STAGES - 1 - n), render_stage_names[n]);
        }

    /* 1, 2 or 5 times a power of ten: the smallest such that five steps or fewer reach the top */
    double power = pow(10, floor(log10(most / 5))), step = power;
    for (int n = 1; n < 4 && !(most / step <= 5); n++) step = (const double[]){1, 2, 5, 10}[n] * power;
    for (double ms = 0; ms <= most; ms += step)
        fprintf(out.stream, "<path stroke=\"#ccc\" d=\"M%d %.1fH%d\"/><text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%g</text>\n",
                LEFT, y_of(ms, most), PLOT_WIDE - RIGHT, LEFT - 6, y_of(ms, most) + 4, ms);
    fprintf(out.stream, "<text x=\"%d\" y=\"%d\">frames 0 to %zu, milliseconds; %u lights</text>\n", LEFT, PLOT_HIGH - 12,
            r->frame_count - 1, r->light_count);
    if (r->budget_bytes) plot_stream(out.stream, r);
    fputs("</svg>\n", out.stream);
    result = output_file_commit(&out, m);
    output_file_abort(&out);
    return result;
}
