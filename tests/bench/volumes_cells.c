/* Cells, timed in rounds and held against what is wanted; see volumes_bench.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/bench/volumes_bench.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "baker/base/clock.h"
#include "baker/lab/opengl/gl.h"

enum { SLOW_ROUNDS = 3 };

double volumes_colour(const float pixel[4], int channel)
{
    return (double)pixel[channel];
}

static double finished(const bench *b)
{
    struct timespec t;
    b->gl->Finish();
    if (b->clock == CLOCK_WALL) return clock_seconds();
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Where each part of a frame begins and ends. Timestamps are read when all is drawn, because reading waits. */
typedef struct frame_clock {
    double seconds[PARTS + 1];
    GLuint queries[PARTS + 1];
} frame_clock;

static void mark(const bench *b, frame_clock *c, int n)
{
    if (b->clock == CLOCK_TIMER)
        ((PFNGLQUERYCOUNTERPROC)b->gl->lookup("glQueryCounter"))(c->queries[n], GL_TIMESTAMP);
    else
        c->seconds[n] = finished(b);
}

static technique_step *step_of(const technique *t, int part)
{
    return part < BEFORE_MAX ? t->before[part] : t->draw;
}

/* parts  [PARTS] [out] seconds of each; 0 where a technique has no such step */
static void read_clock(const bench *b, frame_clock *c, const technique *t, double *parts)
{
    PFNGLGETQUERYOBJECTUI64VPROC read = (PFNGLGETQUERYOBJECTUI64VPROC)b->gl->lookup("glGetQueryObjectui64v");
    int                          last = 0;
    for (int n = 0; n <= PARTS; n++) {
        GLuint64 nanoseconds = 0;
        if (n > 0 && !step_of(t, n - 1)) {
            parts[n - 1] = 0;
            continue;
        }
        if (b->clock == CLOCK_TIMER) {
            read(c->queries[n], GL_QUERY_RESULT, &nanoseconds);
            c->seconds[n] = 1e-9 * (double)nanoseconds;
        }
        if (n > 0) parts[n - 1] = c->seconds[n] - c->seconds[last];
        last = n;
    }
}

/* parts  [PARTS] [out] seconds of each */
static vxs_result draw(bench *b, const cell *c, const vxs_volumes_frame *frame, double *parts)
{
    frame_clock clock;
    if (b->clock == CLOCK_TIMER) ((PFNGLGENQUERIESPROC)b->gl->lookup("glGenQueries"))(PARTS + 1, clock.queries);
    b->gl->Finish();
    mark(b, &clock, 0);
    vxs_result r = vxs_volumes_begin(b->volumes, frame);
    for (int n = 0; n < PARTS && r == VXS_OK; n++) {
        technique_step *step = step_of(c->technique, n);
        if (step) r = step(b, c->state, c->value);
        if (step) mark(b, &clock, n + 1);
    }
    if (r == VXS_OK) read_clock(b, &clock, c->technique, parts);
    if (b->clock == CLOCK_TIMER) ((PFNGLDELETEQUERIESPROC)b->gl->lookup("glDeleteQueries"))(PARTS + 1, clock.queries);
    return r;
}

static vxs_result open_cell(bench *b, cell *c)
{
    return c->technique->open ? c->technique->open(b, &c->state, c->value) : VXS_OK;
}

static int is_of(const char *text, const technique *t, uint32_t value)
{
    char name[64];
    return snprintf(name, sizeof name, "%s:%u", t->name, value) < (int)sizeof name && !strcmp(name, text);
}

static int is_measured(const bench *b, const technique *t, uint32_t value)
{
    int is_named = 0;
    for (size_t n = 0; n < b->cell_texts.count; n++) is_named |= is_of(b->cell_texts.items[n], t, value);
    return is_named || !b->cell_texts.count;
}

static vxs_result check_cells(const bench *b, run_context *m)
{
    for (size_t n = 0; n < b->cell_texts.count; n++) {
        int is_known = 0;
        for (size_t t = 0; t < b->technique_count; t++)
            for (uint32_t v = 0; b->techniques[t].values[v]; v++)
                is_known |= is_of(b->cell_texts.items[n], &b->techniques[t], b->techniques[t].values[v]);
        if (!is_known) return fail(m, VXS_E_ARGUMENT, "--cell %s: no technique has this setting", b->cell_texts.items[n]);
    }
    return VXS_OK;
}

static void open_cells(bench *b, cell *cells, size_t *count)
{
    for (size_t t = 0; t < b->technique_count; t++)
        for (uint32_t n = 0; n < b->values && b->techniques[t].values[n]; n++) {
            if (!is_measured(b, &b->techniques[t], b->techniques[t].values[n])) continue;
            double parts[PARTS];
            cell  *c        = &cells[(*count)++];
            double since    = finished(b);
            *c              = (cell){.technique = &b->techniques[t], .value = b->techniques[t].values[n]};
            c->is_refused   = open_cell(b, c) != VXS_OK || draw(b, c, b->frames, parts) != VXS_OK;
            c->open_seconds = finished(b) - since;
        }
}

/* What takes long differs little from round to round. */
static uint32_t rounds_of(const bench *b, const cell *c)
{
    if (c->seconds[0] > 10) return 1;
    return c->seconds[0] > 1 && b->rounds > SLOW_ROUNDS ? SLOW_ROUNDS : b->rounds;
}

static vxs_result time_cell(bench *b, cell *c, uint32_t round)
{
    double            parts[PARTS];
    vxs_volumes_frame one = b->frames[0];
    one.view.width_px = one.view.height_px = 1;
    if (b->has_creation && draw(b, c, &one, parts) == VXS_OK)
        for (int n = 0; n < PARTS; n++) c->creation[round] += parts[n];
    vxs_result r = draw(b, c, b->frames, parts);
    for (int n = 0; n < PARTS && r == VXS_OK; n++) {
        c->parts[n][round] = parts[n];
        c->seconds[round] += parts[n];
    }
    return r;
}

static void find_medians(const bench *b, cell *c)
{
    uint32_t rounds = rounds_of(b, c);
    for (int n = 0; n < PARTS; n++) c->part_medians[n] = spread_of(c->parts[n], rounds).median;
    c->creation_median = spread_of(c->creation, rounds).median;
    c->spread          = spread_of(c->seconds, rounds);
}

static vxs_result time_cells(bench *b, cell *cells, size_t count, run_context *m)
{
    for (uint32_t round = 0; round < b->rounds; round++)
        for (size_t n = 0; n < count; n++) {
            if (cells[n].is_refused || (round && round >= rounds_of(b, &cells[n]))) continue;
            vxs_result r = time_cell(b, &cells[n], round);
            if (r != VXS_OK) return fail(m, VXS_E_GL, "%s cannot be drawn", cells[n].technique->name);
        }
    for (size_t n = 0; n < count; n++)
        if (!cells[n].is_refused) find_medians(b, &cells[n]);
    return VXS_OK;
}

static vxs_result judge(bench *b, cell *c, run_context *m)
{
    float     *read  = malloc(4 * b->pixels * sizeof *read);
    double    *found = malloc(3 * CAMERAS * b->pixels * sizeof *found), parts[PARTS];
    vxs_result r     = read && found ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for a picture");
    for (uint32_t camera = 0; camera < b->cameras && r == VXS_OK; camera++) {
        if ((r = draw(b, c, &b->frames[camera], parts)) != VXS_OK) {
            r = fail(m, r, "%s cannot be drawn", c->technique->name);
            break;
        }
        b->gl->GetTextureImage(b->picture, 0, GL_RGBA, GL_FLOAT, (GLsizei)(4 * b->pixels * sizeof *read), read);
        for (size_t n = 0; n < 3 * b->pixels; n++)
            found[3 * (size_t)camera * b->pixels + n] = b->value_of(read + n / 3 * 4, (int)(n % 3));
    }
    if (r == VXS_OK) {
        c->all       = picture_error_of(found, b->wanted, b->pixels, b->classes, PIXEL_CLASSES);
        c->elsewhere = picture_error_of(found, b->wanted, b->pixels, b->classes, PIXELS_ELSEWHERE);
        c->flicker   = picture_flicker_of(found, b->wanted, b->cameras, b->pixels);
        if (b->classes) c->epipole = picture_error_of(found, b->wanted, b->pixels, b->classes, PIXELS_EPIPOLE);
        if (c->technique->bytes) c->bytes = c->technique->bytes(b, c->state, c->value);
    }
    free(read);
    free(found);
    return r;
}

static void find_front(cell *cells, size_t count)
{
    for (size_t n = 0; n < count; n++) {
        double least = cells[n].spread.median;
        if (cells[n].is_refused) continue;
        for (size_t k = 0; k < count; k++)
            if (!cells[k].is_refused && cells[k].all.relative_rms <= cells[n].all.relative_rms)
                least = fmin(least, cells[k].spread.median);
        cells[n].behind = cells[n].spread.median / least;
    }
}

vxs_result volumes_measure(bench *b, run_context *m)
{
    size_t     count = 0;
    cell      *cells = calloc(CELLS_MAX, sizeof *cells);
    vxs_result r     = cells ? check_cells(b, m) : fail(m, VXS_E_MEMORY, "out of memory");
    if (r == VXS_OK) open_cells(b, cells, &count);
    if (r == VXS_OK) r = time_cells(b, cells, count, m);
    for (size_t n = 0; n < count && r == VXS_OK; n++)
        if (!cells[n].is_refused) r = judge(b, &cells[n], m);
    if (r == VXS_OK) {
        find_front(cells, count);
        r = volumes_report(b, cells, count, m);
    }
    for (size_t n = 0; n < count; n++)
        if (cells[n].technique->close) cells[n].technique->close(cells[n].state);
    free(cells);
    return r;
}
