/* What baked smoke takes and how near it comes: a plume, a grid of 96 x 96 x 96 samples 80 m wide, over the middle of an asset,
 * baked by sides, nodes and errors; lookups at random lit places in its shadow against the integral along the ray to each place
 * itself.
 *
 *     vxs scene city -o city.glb && vxs bake city.glb -o city.vxs
 *     build/release/tests/bench/baked_smoke city.vxs
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "baker/base/random.h"
#include "baker/base/spread.h"
#include "baker/base/vec3.h"
#include "baker/files/input_file.h"
#include "baker/smoke/smoke_map.h"
#include "runtime/vxs.h"

enum { SAMPLES = 96, BALLS = 60, PLACES = 20000 };

static const double wide_metres = 80, densest = 0.12;

static double between(rng *r, double low, double high)
{
    return low + (high - low) * rng_unit(r);
}

/* A ball of smoke, densest in its middle. */
static void add_ball(float *extinction, const double at[3], double radius, double dense)
{
    double step = wide_metres / (SAMPLES - 1);
    for (int k = 0; k < SAMPLES; k++)
        for (int j = 0; j < SAMPLES; j++)
            for (int i = 0; i < SAMPLES; i++) {
                double x = i * step - wide_metres / 2 - at[0], y = j * step - at[1], z = k * step - wide_metres / 2 - at[2];
                double inside = 1 - (x * x + y * y + z * z) / (radius * radius);
                if (inside > 0) extinction[(k * SAMPLES + j) * SAMPLES + i] += (float)(inside * inside * dense);
            }
}

/* Balls that rise, and widen and thin out as they do. */
static int make_plume(smoke_grid *g)
{
    double step       = wide_metres / (SAMPLES - 1);
    double axes[3][3] = {{step, 0, 0}, {0, step, 0}, {0, 0, step}}, origin[3] = {-wide_metres / 2, 0, -wide_metres / 2};
    rng    r = {1};
    for (int n = 0; n < 3; n++) g->size[n] = SAMPLES;
    if (!(g->extinction = calloc((size_t)SAMPLES * SAMPLES * SAMPLES, sizeof *g->extinction))) return 0;
    for (int n = 0; n < BALLS; n++) {
        double rise = rng_unit(&r), angle = between(&r, 0, 2 * M_PI), out = 0.3 * wide_metres * rise * sqrt(rng_unit(&r));
        double at[3] = {out * cos(angle) + 0.08 * wide_metres * sin(6 * rise), wide_metres * (0.1 + 0.8 * rise), out * sin(angle)};
        add_ball(g->extinction, at, wide_metres * (0.06 + 0.1 * rise) * between(&r, 0.6, 1.4), densest * (1.2 - rise));
    }
    return smoke_grid_place(g, axes, origin);
}

/* What is left of a sun at a place. */
static double left_of(const smoke_grid *g, const vxs_light *sun, const double ws[3], smoke_path *path)
{
    path->count = 0;
    if (!smoke_grid_march(g, ws, sun->direction_ws, -INFINITY, 0, path)) abort();
    return path->count ? exp(-path->thick[path->count - 1]) : 1;
}

static void print_errors(const vxs_asset *asset, const smoke_grid *g)
{
    static double          errors[PLACES];
    const vxs_baked_light *sun    = vxs_asset_light(asset, 0);
    smoke_path             path   = {0};
    rng                    r      = {2};
    double                 square = 0, sum = 0;
    for (int n = 0; n < PLACES;) {
        double ws[3] = {between(&r, -60, 60), between(&r, 0, 80), between(&r, -60, 60)};
        if (vxs_lookup(sun, ws, NULL, vxs_box(1)) != 1) continue;
        double left  = left_of(g, &sun->light, ws, &path),
               error = (double)vxs_smoke_lookup(&sun->light, vxs_asset_smoke(asset, 0), ws) - left;
        if (left > 0.99) continue;
        errors[n++] = fabs(error);
        square += error * error;
        sum += error;
    }
    qsort(errors, PLACES, sizeof *errors, doubles_ascending);
    printf("%.4f | %+.4f | %.4f | %.3f |\n", sqrt(square / PLACES), sum / PLACES, errors[PLACES / 100 * 99], errors[PLACES - 1]);
    smoke_path_free(&path);
}

static int measure(const uint8_t *bytes, size_t size_bytes, const smoke_grid *g, smoke_settings settings)
{
    run_context  m      = {0};
    bake_context ctx    = {.run = &m, .threads = 1};
    vxs_bytes    file   = {.data = malloc(size_bytes), .size_bytes = size_bytes};
    smoke_counts counts = {0};
    vxs_asset   *asset  = NULL;
    if (!file.data) return 0;
    memcpy(file.data, bytes, size_bytes);
    clock_t begun = clock();
    int     done  = smoke_bake(&file, &(smoke_source){.grid = g}, &settings, 12, &counts, &ctx) == VXS_OK;
    double  spent = (double)(clock() - begun) / CLOCKS_PER_SEC;
    done          = done && vxs_asset_open(&asset, file.data, file.size_bytes, NULL) == VXS_OK;
    if (done) {
        printf("| %u | %u | %g | %zu | %.1f | %zu | %llu | %.2f | %.3f | ", settings.side_px, settings.nodes, settings.error,
               counts.curves, (double)counts.nodes / (double)counts.curves, file.size_bytes - size_bytes,
               (unsigned long long)counts.memory_bytes, spent, counts.largest_error);
        print_errors(asset, g);
    }
    vxs_asset_close(asset);
    free(file.data);
    return done;
}

int main(int argc, char **argv)
{
    static const smoke_settings settings[] = {{128, 8, 0.005},  {256, 8, 0.005},  {512, 8, 0.005},   {1024, 8, 0.005},
                                              {2048, 8, 0.005}, {1024, 4, 0.005}, {1024, 16, 0.005}, {1024, 8, 0.02},
                                              {1024, 16, 0.02}, {1024, 16, 0.001}};
    run_context                 m          = {0};
    smoke_grid                  plume      = {0};
    uint8_t                    *bytes;
    size_t                      size_bytes;
    if (argc != 2 || input_read(&bytes, &size_bytes, argv[1], SIZE_MAX, NULL, &m) != VXS_OK || !make_plume(&plume)) {
        fprintf(stderr, "usage: baked_smoke FILE.vxs, whose first light is a sun\n%s\n", m.error);
        return 1;
    }
    printf("| side | nodes | error | curves | nodes each | bytes in the file | in memory | seconds | largest of a curve | RMS | "
           "mean | 99 %% | largest |\n"
           "|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    int done = 1;
    for (size_t n = 0; n < sizeof settings / sizeof *settings && done; n++) done = measure(bytes, size_bytes, &plume, settings[n]);
    smoke_grid_free(&plume);
    free(bytes);
    return !done;
}
