/* Cells, timed in rounds and held against what is wanted; see volumes_bench.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/bench/volumes_bench.h"

#include <math.h>
#include <stdlib.h>

#include "baker/measure/clock.h"
#include "baker/opengl/gl.h"

enum { SLOW_ROUNDS = 3 };

static double finished(const bench *b)
{
    b->gl->Finish();
    return clock_seconds();
}

static vxs_volumes_light light_of(const bench *b)
{
    return (vxs_volumes_light){.baked = b->number, .colour = {1, 1, 1}, .cos_inner = 1, .radius_metres = (float)b->radius_metres};
}

static vxs_result draw(bench *b, const cell *c, int camera)
{
    vxs_volumes_light light = light_of(b);
    vxs_result        r     = vxs_volumes_begin(b->volumes, &b->frames[camera]);
    return r == VXS_OK ? c->technique->draw(b, &light, c->state, c->value) : r;
}

void volumes_open_cells(bench *b, cell *cells, size_t *count)
{
    for (size_t t = 0; t < volumes_technique_count; t++)
        for (uint32_t n = 0; n < b->values && volumes_techniques[t].values[n]; n++) {
            cell  *c        = &cells[(*count)++];
            double since    = finished(b);
            *c              = (cell){.technique = &volumes_techniques[t], .value = volumes_techniques[t].values[n]};
            c->is_refused   = volumes_techniques[t].open(b, &c->state, c->value) != VXS_OK || draw(b, c, 0) != VXS_OK;
            c->open_seconds = finished(b) - since;
        }
}

/* What takes long differs little from round to round. */
static uint32_t rounds_of(const bench *b, const cell *c)
{
    return c->seconds[0] > 1 && b->rounds > SLOW_ROUNDS ? SLOW_ROUNDS : b->rounds;
}

vxs_result volumes_time_cells(bench *b, cell *cells, size_t count, message *m)
{
    for (uint32_t round = 0; round < b->rounds; round++)
        for (size_t n = 0; n < count; n++) {
            if (cells[n].is_refused || round >= rounds_of(b, &cells[n])) continue;
            double since = finished(b);
            if (draw(b, &cells[n], 0) != VXS_OK) return fail(m, VXS_E_GL, "%s cannot be drawn", cells[n].technique->name);
            cells[n].seconds[round] = finished(b) - since;
        }
    for (size_t n = 0; n < count; n++)
        if (!cells[n].is_refused) cells[n].spread = spread_of(cells[n].seconds, rounds_of(b, &cells[n]));
    return VXS_OK;
}

vxs_result volumes_judge(bench *b, cell *c, message *m)
{
    float     *read  = malloc(4 * b->pixels * sizeof *read);
    double    *found = malloc(3 * CAMERAS * b->pixels * sizeof *found);
    vxs_result r     = read && found ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for a picture");
    for (int camera = 0; camera < CAMERAS && r == VXS_OK; camera++) {
        if ((r = draw(b, c, camera)) != VXS_OK) break;
        b->gl->GetTextureImage(vxs_volumes_airlight(b->volumes), 0, GL_RGBA, GL_FLOAT, (GLsizei)(4 * b->pixels * sizeof *read),
                               read);
        for (size_t n = 0; n < 3 * b->pixels; n++) found[3 * (size_t)camera * b->pixels + n] = (double)read[4 * (n / 3) + n % 3];
    }
    if (r == VXS_OK) {
        c->all       = picture_error_of(found, b->wanted, b->pixels, b->classes, PIXEL_CLASSES);
        c->elsewhere = picture_error_of(found, b->wanted, b->pixels, b->classes, PIXELS_ELSEWHERE);
        c->epipole   = picture_error_of(found, b->wanted, b->pixels, b->classes, PIXELS_EPIPOLE);
        c->flicker   = picture_flicker_of(found, b->wanted, CAMERAS, b->pixels);
    }
    free(read);
    free(found);
    return r;
}

void volumes_find_front(cell *cells, size_t count)
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
