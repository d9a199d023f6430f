/* Reports of rivals; see rival_report.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/bench/rival_report.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/version.h"
#include "baker/files/json_file.h"
#include "baker/lab/bench/machine.h"

/* figures ---------------------------------------------------------------------------------------------------------------------- */

typedef enum figure {
    FIGURE_DISK,
    FIGURE_MEMORY,
    FIGURE_BUILD,
    FIGURE_OPEN,
    FIGURE_TAP_VOLUME,
    FIGURE_FILTER_VOLUME,
    FIGURE_TAP_EDGE,
    FIGURE_FILTER_EDGE,
    FIGURE_TAP_SCREEN,
    FIGURE_FILTER_SCREEN,
    FIGURE_SMOOTH_VOLUME,
    FIGURE_SMOOTH_EDGE,
    FIGURE_SMOOTH_SCREEN,
    FIGURE_COUNT
} figure;

static const char *const figure_names[FIGURE_COUNT] = {"on disk",
                                                       "in memory",
                                                       "maps to file",
                                                       "file to lookups",
                                                       "1 tap, anywhere",
                                                       "9 x 9, anywhere",
                                                       "1 tap, at edges",
                                                       "9 x 9, at edges",
                                                       "1 tap, in a picture",
                                                       "9 x 9, in a picture",
                                                       "9 x 9 smooth, anywhere",
                                                       "9 x 9 smooth, at edges",
                                                       "9 x 9 smooth, in a picture"};

/* A figure that a rival does not have is 0. */
static spread figure_of(const rival_result *r, figure f)
{
    switch (f) {
    case FIGURE_DISK: return (spread){(double)r->file_bytes, (double)r->file_bytes, (double)r->file_bytes};
    case FIGURE_MEMORY: return (spread){(double)r->memory_bytes, (double)r->memory_bytes, (double)r->memory_bytes};
    case FIGURE_BUILD: return r->build_s;
    case FIGURE_OPEN: return r->open_s;
    case FIGURE_TAP_VOLUME: return r->lookup_ns[LOOKUP_TAP][POINTS_VOLUME];
    case FIGURE_FILTER_VOLUME: return r->lookup_ns[LOOKUP_BOX][POINTS_VOLUME];
    case FIGURE_TAP_EDGE: return r->lookup_ns[LOOKUP_TAP][POINTS_EDGE];
    case FIGURE_FILTER_EDGE: return r->lookup_ns[LOOKUP_BOX][POINTS_EDGE];
    case FIGURE_TAP_SCREEN: return r->lookup_ns[LOOKUP_TAP][POINTS_SCREEN];
    case FIGURE_FILTER_SCREEN: return r->lookup_ns[LOOKUP_BOX][POINTS_SCREEN];
    case FIGURE_SMOOTH_VOLUME: return r->lookup_ns[LOOKUP_SMOOTH][POINTS_VOLUME];
    case FIGURE_SMOOTH_EDGE: return r->lookup_ns[LOOKUP_SMOOTH][POINTS_EDGE];
    default: return r->lookup_ns[LOOKUP_SMOOTH][POINTS_SCREEN];
    }
}

/* Less memory or disk than vxs, or in the slowest run quicker than vxs in the quickest. */
static int beats(const rival_result *r, const rival_result *vxs, figure f)
{
    spread s = figure_of(r, f);
    return s.median > 0 && s.max < figure_of(vxs, f).min;
}

static int is_size(figure f)
{
    return f == FIGURE_DISK || f == FIGURE_MEMORY;
}

static int is_lookup(figure f)
{
    return f >= FIGURE_TAP_VOLUME;
}

/* "508.1 KiB", "43.1 ms (42.7 to 44.0)", "46 ns (45 to 47)"; "" for 0. */
static const char *figure_text(char text[64], spread s, figure f)
{
    text[0] = 0;
    if (s.median <= 0) return text;
    if (is_size(f))
        size_text(text, (uint64_t)s.median);
    else if (is_lookup(f))
        snprintf(text, 64, "%.0f ns (%.0f to %.0f)", s.median, s.min, s.max);
    else
        snprintf(text, 64, "%.1f ms (%.1f to %.1f)", 1e3 * s.median, 1e3 * s.min, 1e3 * s.max);
    return text;
}

/* tables ----------------------------------------------------------------------------------------------------------------------- */

enum { COLUMNS_MAX = 13, CELL_BYTES = 64 };

typedef struct table {
    char (*rows)[COLUMNS_MAX][CELL_BYTES]; /* [row_count] the first is the head */
    size_t row_count;
    int    column_count; /* of the head */
    int    at;           /* of the row in work */
} table;

static void cell(table *t, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void cell(table *t, const char *format, ...)
{
    va_list values;
    va_start(values, format);
    vsnprintf(t->rows[t->row_count - 1][t->at++], CELL_BYTES, format, values);
    va_end(values);
}

static void begin_row(table *t, const char *name)
{
    t->row_count++;
    t->at = 0;
    cell(t, "%s", name);
}

/* A figure, and its ratio to that of vxs. */
static void figure_cells(table *t, const rival_result *r, const rival_result *vxs, figure f)
{
    spread s = figure_of(r, f), own = figure_of(vxs, f);
    char   text[64];
    cell(t, "%s", figure_text(text, s, f));
    if (s.median > 0 && own.median > 0)
        cell(t, "%.2f", s.median / own.median);
    else
        cell(t, "%s", "");
}

/* Markdown, in columns for readers of the plain text. */
static void print_table(FILE *to, const table *t)
{
    int width[COLUMNS_MAX] = {0};
    for (size_t row = 0; row < t->row_count; row++)
        for (int c = 0; c < t->column_count; c++) {
            int length = (int)strlen(t->rows[row][c]);
            width[c]   = length > width[c] ? length : width[c];
        }
    for (size_t row = 0; row < t->row_count; row++) {
        for (int c = 0; c < t->column_count; c++) fprintf(to, c ? "| %*s " : "| %-*s ", width[c], t->rows[row][c]);
        fputs("|\n", to);
        for (int c = 0; c < t->column_count && !row; c++) {
            fputc('|', to);
            for (int n = !!c; n < width[c] + 2; n++) fputc('-', to);
            if (c) fputc(':', to);
        }
        if (!row) fputs("|\n", to);
    }
    fputc('\n', to);
}

static int print_figures(FILE *to, const rival_report *report, const char *name, figure first, figure last)
{
    const rival_result *vxs = report->results;
    table               t   = {.rows = calloc(report->count + 1, sizeof *t.rows)};
    if (!t.rows) return 0;
    begin_row(&t, name);
    for (figure f = first; f <= last; f++) {
        cell(&t, "%s", figure_names[f]);
        cell(&t, "of vxs");
    }
    t.column_count = t.at;
    for (const rival_result *r = vxs; r < vxs + report->count; r++) {
        if (first >= FIGURE_SMOOTH_VOLUME && !(r->rival->traits & RIVAL_SMOOTH)) continue;
        begin_row(&t, r->rival->name);
        for (figure f = first; f <= last; f++) figure_cells(&t, r, vxs, f);
    }
    print_table(to, &t);
    free(t.rows);
    return 1;
}

static int print_wrong(FILE *to, const rival_report *report)
{
    double texels = (double)((uint64_t)1 << 2 * report->maps->levels);
    table  t      = {.rows = calloc(report->count + 1, sizeof *t.rows)};
    if (!t.rows) return 0;
    begin_row(&t, "answers");
    cell(&t, "bit/texel on disk");
    cell(&t, "voxels asked");
    cell(&t, "wrongly lit");
    cell(&t, "wrongly dark");
    cell(&t, "filters asked");
    cell(&t, "unlike their taps");
    t.column_count = t.at;
    for (const rival_result *r = report->results; r < report->results + report->count; r++) {
        begin_row(&t, r->rival->name);
        if (r->file_bytes)
            cell(&t, "%.3f", 8 * (double)r->file_bytes / texels);
        else
            cell(&t, "%s", "");
        cell(&t, "%ju", (uintmax_t)r->voxels);
        cell(&t, "%ju", (uintmax_t)r->wrong_lit);
        cell(&t, "%ju", (uintmax_t)r->wrong_dark);
        cell(&t, "%ju", (uintmax_t)(r->filters[LOOKUP_BOX] + r->filters[LOOKUP_SMOOTH]));
        cell(&t, "%ju", (uintmax_t)(r->wrong_filters[LOOKUP_BOX] + r->wrong_filters[LOOKUP_SMOOTH]));
    }
    print_table(to, &t);
    free(t.rows);
    return 1;
}

static void print_losses(FILE *to, const rival_result *r, const rival_result *vxs)
{
    int losses = 0;
    for (figure f = 0; f < FIGURE_COUNT; f++) {
        if (!beats(r, vxs, f)) continue;
        if (losses++)
            fputs("; ", to);
        else
            fprintf(to, "- %s: ", r->rival->name);
        fprintf(to, "%s %.2f", figure_names[f], figure_of(r, f).median / figure_of(vxs, f).median);
    }
    if (losses) fputc('\n', to);
}

int rival_report_print(FILE *to, const rival_report *report)
{
    const measure_options *o    = report->options;
    unsigned               side = 1u << report->maps->levels, threads = report->maps->threads;
    bench_machine          here = {0};
    int                    ok   = machine_describe(&here);
    if (ok)
        fprintf(
            to,
            "%s, light %s, %u x %u texels, %zu triangles; vxs %s on %s, %u cores, %.0f GiB; medians of %u runs (least to most), "
            "%u thread%s, %u points\n\n",
            report->scene_path, report->maps->light.name, side, side, report->maps->casters.triangle_count, VXS_VERSION,
            here.processor, (unsigned)here.cores, (double)here.memory_bytes / (1 << 30), o->runs, threads,
            threads > 1 ? "s of the clock for files and opening, else one of processor time" : ", processor time", o->points);
    machine_free(&here);
    ok = ok && print_figures(to, report, "rival", FIGURE_DISK, FIGURE_OPEN) &&
         print_figures(to, report, "a lookup", FIGURE_TAP_VOLUME, FIGURE_FILTER_SCREEN) &&
         print_figures(to, report, "a smooth lookup", FIGURE_SMOOTH_VOLUME, FIGURE_SMOOTH_SCREEN) && print_wrong(to, report);
    fputs("Where vxs is beaten (less memory or disk, or the slowest run quicker than its quickest), and the ratio:\n\n", to);
    for (size_t n = 1; n < report->count; n++) print_losses(to, &report->results[n], report->results);
    fputc('\n', to);
    return ok;
}

/* JSON ------------------------------------------------------------------------------------------------------------------------- */

static json_t *spread_json(spread s)
{
    return s.median > 0 ? json_pack("{s:f, s:f, s:f}", "median", s.median, "min", s.min, "max", s.max) : json_null();
}

static json_t *bytes_json(uint64_t bytes)
{
    return bytes ? json_integer((json_int_t)bytes) : json_null();
}

static json_t *lookups_json(const rival_result *r, point_set set)
{
    static const char *const points[LOOKUP_KINDS] = {"tap_points", "filter_points", "smooth_points"};
    static const char *const times[LOOKUP_KINDS]  = {"tap_ns", "filter_ns", "smooth_ns"};
    json_t                  *lookups              = json_object();
    for (int n = 0; n < LOOKUP_KINDS; n++) {
        json_object_set_new(lookups, points[n], json_integer((json_int_t)r->points[n][set]));
        json_object_set_new(lookups, times[n], spread_json(r->lookup_ns[n][set]));
    }
    return lookups;
}

static json_t *result_json(const rival_result *r, const rival_result *vxs)
{
    json_t *beaten = json_array();
    for (figure f = 0; f < FIGURE_COUNT; f++)
        if (beats(r, vxs, f)) json_array_append_new(beaten, json_string(figure_names[f]));
    json_t *lookups = json_pack("{s:o, s:o, s:o}", "volume", lookups_json(r, POINTS_VOLUME), "edge", lookups_json(r, POINTS_EDGE),
                                "screen", lookups_json(r, POINTS_SCREEN));
    json_t *wrong =
        json_pack("{s:I, s:I, s:I, s:I, s:I, s:I, s:I}", "voxels", (json_int_t)r->voxels, "wrong_lit", (json_int_t)r->wrong_lit,
                  "wrong_dark", (json_int_t)r->wrong_dark, "filters", (json_int_t)r->filters[LOOKUP_BOX], "wrong_filters",
                  (json_int_t)r->wrong_filters[LOOKUP_BOX], "smooth", (json_int_t)r->filters[LOOKUP_SMOOTH], "wrong_smooth",
                  (json_int_t)r->wrong_filters[LOOKUP_SMOOTH]);
    return json_pack("{s:s, s:s, s:b, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "name", r->rival->name, "what", r->rival->what, "rays",
                     r->rival->traits & RIVAL_RAYS, "file_bytes", bytes_json(r->file_bytes), "memory_bytes",
                     bytes_json(r->memory_bytes), "build_seconds", spread_json(r->build_s), "open_seconds", spread_json(r->open_s),
                     "lookups", lookups, "check", wrong, "beats_vxs", beaten);
}

static json_t *picture_json(const measure_options *o)
{
    const camera_pose *c = &o->camera.camera;
    return json_pack("{s:I, s:I, s:[f, f, f], s:[f, f, f], s:f}", "width_px", (json_int_t)o->width_px, "height_px",
                     (json_int_t)o->height_px, "eye_ws", c->eye_ws[0], c->eye_ws[1], c->eye_ws[2], "target_ws", c->target_ws[0],
                     c->target_ws[1], c->target_ws[2], "fov_degrees", c->fov_degrees);
}

json_t *rival_report_json(const rival_report *report)
{
    const measure_options *o       = report->options;
    bench_machine          here    = {0};
    json_t                *results = json_array();
    for (size_t n = 0; n < report->count; n++) json_array_append_new(results, result_json(&report->results[n], report->results));
    json_t *place =
        machine_describe(&here)
            ? json_pack("{s:o, s:I, s:I, s:s, s:s}", "processor", json_text(here.processor), "cores", (json_int_t)here.cores,
                        "memory_bytes", (json_int_t)here.memory_bytes, "system", here.system, "renderer", report->maps->renderer)
            : NULL;
    machine_free(&here);
    return json_pack("{s:s, s:o, s:o, s:s, s:I, s:I, s:f, s:I, s:I, s:I, s:I, s:o, s:I, s:I, s:o}", "vxs", VXS_VERSION, "machine",
                     place, "scene", json_text(report->scene_path), "light", report->maps->light.name, "resolution_px",
                     (json_int_t)1 << report->maps->levels, "triangles", (json_int_t)report->maps->casters.triangle_count,
                     "maps_seconds", report->maps->seconds, "threads", (json_int_t)report->maps->threads, "runs",
                     (json_int_t)o->runs, "points", (json_int_t)o->points, "seed", (json_int_t)o->seed, "picture", picture_json(o),
                     "filter_px", (json_int_t)FILTER_PX, "zstd_level", (json_int_t)RIVAL_ZSTD_LEVEL, "rivals", results);
}
