/* flight: a camera flies over a baked level that is larger than its memory.
 *
 *     flight FILE [--budget BYTES] [--threads N] [--speed MPS] [--radius METRES] [--json FILE]
 *
 * The camera flies across the map of the file's first light, from corner to corner, 20 m in front of the first surface that light
 * meets, with 60 frames a second. In each frame it requests points on such surfaces around it, up to 100 m away, with a 9 x 9
 * filter: how many answers are full, and whether they are the answer of the whole file. Without threads pages are decoded in the
 * frame, one at most; with threads frames keep their time. Figures go to FILE as JSON (docs/flight.schema.json).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "baker/base/clock.h"
#include "baker/base/random.h"
#include "baker/base/spread.h"
#include "baker/base/version.h"
#include "baker/command/options/options.h"
#include "baker/files/json_file.h"
#include "runtime/vxs_stream.h"

enum { POINTS = 200, FILTER_PX = 9, AROUND_METRES = 100, ABOVE_METRES = 20, FRAMES_PER_SECOND = 60 };

typedef struct flight_options {
    const char *path, *json_path;
    uint64_t    budget_bytes;
    uint32_t    threads, speed_mps, radius_metres;
} flight_options;

typedef struct flight {
    const flight_options *options;
    vxs_asset            *whole; /* what is right, and where surfaces are; not counted */
    vxs_stream           *stream;
    double                open_seconds;
    uint64_t              open_bytes, asked, full;
    uint32_t              frames, coarse_frames, appeared, left;
    double               *frame_seconds; /* [frames] */
    vxs_stream_status     last;
    rng                   random;
} flight;

/* The point on the first surface that light meets in a texel of map 0: shadow begins there. 0: none does. */
static int surface_at(const flight *f, double u, double v, double point_ws[3])
{
    const vxs_baked_light *l    = vxs_asset_light(f->whole, 0);
    int32_t                last = (1 << l->light.levels) - 1, low = -1, high = last;
    double                 at[3] = {u, v, last + 0.5};
    vxs_point(&l->light, 0, at, point_ws);
    if (vxs_lookup(l, point_ws, NULL, vxs_box(1)) != 0) return 0;
    while (high - low > 1) {
        int32_t middle = low + (high - low) / 2;
        at[2]          = middle + 0.5;
        vxs_point(&l->light, 0, at, point_ws);
        *(vxs_lookup(l, point_ws, NULL, vxs_box(1)) == 0 ? &high : &low) = middle;
    }
    at[2] = high + 0.5;
    vxs_point(&l->light, 0, at, point_ws);
    return 1;
}

/* Where the camera is at a part, 0 to 1, of its way, and its place in the map. */
static void camera_at(const flight *f, double part, double eye_ws[3], double at[2])
{
    const vxs_light *light = &vxs_asset_light(f->whole, 0)->light;
    double           side  = (double)(1u << light->levels), far[3];
    at[0] = at[1] = (0.15 + 0.7 * part) * side;
    far[0]        = at[0];
    far[1]        = at[1];
    far[2]        = side / 2;
    if (!surface_at(f, at[0], at[1], eye_ws)) vxs_point(light, 0, far, eye_ws);
    for (int k = 0; k < 3; k++) eye_ws[k] -= ABOVE_METRES * light->direction_ws[k];
}

/* What lookups around the camera say; 0: one says what it must not. */
static int look_around(flight *f, const double at[2], uint32_t *coarse)
{
    const vxs_baked_light *whole = vxs_asset_light(f->whole, 0), *here = vxs_stream_light(f->stream, 0);
    double                 reach = AROUND_METRES / whole->light.texel_metres;
    for (int n = 0; n < POINTS; n++) {
        double angle = 6.2831853 * rng_below(&f->random, 4096) / 4096, away = reach * rng_below(&f->random, 4096) / 4096, point[3];
        if (!surface_at(f, at[0] + away * cos(angle), at[1] + away * sin(angle), point)) continue;
        int full = vxs_lookup_is_full(here, point, NULL, vxs_box(FILTER_PX));
        if (full && vxs_lookup(here, point, NULL, vxs_box(FILTER_PX)) != vxs_lookup(whole, point, NULL, vxs_box(FILTER_PX)))
            return 0;
        f->asked++;
        f->full += (uint64_t)full;
        *coarse += !full;
    }
    return 1;
}

static void keep_time(double frame_began)
{
    double left = 1.0 / FRAMES_PER_SECOND - (clock_seconds() - frame_began);
    if (left <= 0) return;
    struct timespec wait = {0, (long)(left * 1e9)};
    nanosleep(&wait, NULL);
}

static vxs_result fly(flight *f, run_context *m)
{
    double metres = 0.7 * sqrt(2) * (double)(1u << vxs_asset_light(f->whole, 0)->light.levels) *
                    vxs_asset_light(f->whole, 0)->light.texel_metres;
    f->frames        = (uint32_t)(metres / f->options->speed_mps * FRAMES_PER_SECOND) + 1;
    f->frame_seconds = calloc(f->frames, sizeof *f->frame_seconds);
    if (!f->frame_seconds) return fail(m, VXS_E_MEMORY, "out of memory");
    for (uint32_t n = 0; n < f->frames; n++) {
        double   eye_ws[3], at[2], began = clock_seconds();
        uint32_t coarse = 0;
        camera_at(f, (double)n / f->frames, eye_ws, at);
        vxs_stream_focus eye  = vxs_stream_camera(eye_ws, f->options->radius_metres);
        double           from = clock_seconds();
        f->last               = (vxs_stream_status){.struct_size = sizeof f->last};
        if (vxs_stream_frame(f->stream, &eye, 1, &f->last) != VXS_OK) return fail(m, VXS_E_ARGUMENT, "no frame");
        f->frame_seconds[n] = clock_seconds() - from;
        f->appeared += f->last.appeared;
        f->left += f->last.left;
        if (!look_around(f, at, &coarse)) return fail(m, VXS_E_CORRUPT, "%s: a full answer is another", f->options->path);
        f->coarse_frames += coarse > 0;
        if (f->options->threads) keep_time(began);
    }
    return VXS_OK;
}

static json_t *report(flight *f)
{
    const flight_options  *o   = f->options;
    const vxs_baked_light *l   = vxs_asset_light(f->whole, 0);
    double                 sum = 0, *ms = f->frame_seconds;
    for (uint32_t n = 0; n < f->frames; n++) sum += ms[n] *= 1e3;
    qsort(ms, f->frames, sizeof *ms, doubles_ascending);
    double mean = sum / f->frames, high = ms[f->frames - 1 - f->frames / 100], most = ms[f->frames - 1];
    printf("%s: %u x %u texels, %u KiB, %u threads, %u m/s, within %u m\n", o->path, 1u << l->light.levels, 1u << l->light.levels,
           (unsigned)(o->budget_bytes / 1024), o->threads, o->speed_mps, o->radius_metres);
    printf("open     %.1f ms, %.1f KiB read, room for %.1f KiB of pages\n", 1e3 * f->open_seconds, (double)f->open_bytes / 1024,
           (double)f->last.bytes_room / 1024);
    printf("answers  %.3f %% full of %llu; %u of %u frames with a coarse one\n", 100.0 * (double)f->full / (double)f->asked,
           (unsigned long long)f->asked, f->coarse_frames, f->frames);
    printf("pages    %u came, %u left, of %u; %.1f KiB read\n", f->appeared, f->left, f->last.pages,
           (double)f->last.bytes_read / 1024);
    printf("frame    %.3f ms, 99 of 100 below %.3f ms, at most %.3f ms\n", mean, high, most);
    return json_pack(
        "{s:s, s:s, s:I, s:I, s:I, s:I, s:I, s:{s:f, s:I}, s:I, s:I, s:{s:I, s:I}, s:{s:I, s:I}, s:{s:I, s:I, s:I}, s:I, "
        "s:{s:f, s:f, s:f}}",
        "vxs", VXS_VERSION, "file", o->path, "resolution_px", (json_int_t)(1u << l->light.levels), "threads",
        (json_int_t)o->threads, "speed_mps", (json_int_t)o->speed_mps, "radius_m", (json_int_t)o->radius_metres, "budget_bytes",
        (json_int_t)o->budget_bytes, "open", "seconds", f->open_seconds, "bytes_read", (json_int_t)f->open_bytes, "held_bytes",
        (json_int_t)f->last.bytes_held, "room_bytes", (json_int_t)f->last.bytes_room, "answers", "asked", (json_int_t)f->asked,
        "full", (json_int_t)f->full, "frames", "all", (json_int_t)f->frames, "coarse", (json_int_t)f->coarse_frames, "pages", "all",
        (json_int_t)f->last.pages, "appeared", (json_int_t)f->appeared, "left", (json_int_t)f->left, "bytes_read",
        (json_int_t)f->last.bytes_read, "frame_ms", "mean", mean, "p99", high, "max", most);
}

static vxs_result open_both(flight *f, run_context *m)
{
    const flight_options *o = f->options;
    vxs_stream_desc desc    = {.struct_size = sizeof desc, .path = o->path, .threads = o->threads, .budget_bytes = o->budget_bytes};
    vxs_result      r       = vxs_asset_open_file(&f->whole, o->path, NULL);
    if (r != VXS_OK) return fail(m, r, "%s: %s", o->path, vxs_result_text(r));
    double began = clock_seconds();
    if ((r = vxs_stream_open(&f->stream, &desc)) != VXS_OK) return fail(m, r, "%s: %s", o->path, vxs_result_text(r));
    f->open_seconds = clock_seconds() - began;
    f->last         = (vxs_stream_status){.struct_size = sizeof f->last};
    vxs_stream_frame(f->stream, NULL, 0, &f->last);
    f->open_bytes = f->last.bytes_read;
    return VXS_OK;
}

int main(int argc, char **argv)
{
    flight_options o         = {.budget_bytes = 4 << 20, .speed_mps = 30, .radius_metres = 150};
    const option   options[] = {
          {"FILE", OPTION_TEXT, &o.path, 1, 0, NULL, NULL, "file of vxs bake", NULL},
          {"--budget", OPTION_BYTES, &o.budget_bytes, 0, 0, NULL, "BYTES", "what the stream may hold (default 4M)", NULL},
          {"--threads", OPTION_U32, &o.threads, 0, VXS_STREAM_THREADS_MAX, NULL, "N", "of the stream (default 0)", NULL},
          {"--speed", OPTION_U32, &o.speed_mps, 1, 10000, NULL, "MPS", "metres a second (default 30)", NULL},
          {"--radius", OPTION_U32, &o.radius_metres, 1, 1000000, NULL, "METRES", "how far pages are wanted (default 150)", NULL},
          {"--json", OPTION_OUTPUT, &o.json_path, 0, 0, ".json", "FILE", "the figures as JSON", NULL}};
    const command_line line = COMMAND_LINE("flight", "FILE [options]", "A flight over a baked level.", options);
    run_context        m    = {0};
    flight             f    = {.options = &o, .random = {1}};
    int                help_shown;
    vxs_result         r = options_parse(&line, argc, argv, &help_shown, &m);
    if (r == VXS_OK && !help_shown) {
        if ((r = open_both(&f, &m)) == VXS_OK) r = fly(&f, &m);
        json_t *figures = r == VXS_OK ? report(&f) : NULL;
        if (figures && o.json_path)
            r = json_write(o.json_path, figures, &m);
        else
            json_decref(figures);
    }
    vxs_stream_close(f.stream);
    vxs_asset_close(f.whole);
    free(f.frame_seconds);
    return command_end(&m, r);
}
