/* How long lookups take: a million scattered points in the map of a file's first light, beside a plain depth map of floats.
 *
 * Two sets of points: anywhere in the map's volume, where most walks end early; and within a voxel of where a column turns
 * from lit to shadowed, where they go down to the masks. Both methods start from the same points in world space and
 * transform them alike. Each time is the median of RUNS, one thread. Prints JSON. SPDX-License-Identifier: GPL-3.0-or-later
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "formats/vxs_lookup.h"
#include "runtime/vxs.h"

enum { POINTS = 1000000, RUNS = 5, FILTER_PX = 9 };

typedef struct bench {
    const vxs_light *light;
    double          *points_ws; /* [3 * POINTS] */
    float           *lit;       /* [POINTS] answers, so that no work can be left out */
    float           *depth;     /* [side * side] in voxels; what it holds does not change the time */
    double           ws_from_ls[12];
} bench;

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* splitmix64: a fixed sequence of numbers in [0, 1) */
static double next_random(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z          = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z          = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

/* The rows of ls_from_ws are at right angles to each other: its inverse has them as columns, over their squared lengths. */
static void invert(const double m[12], double out[12])
{
    for (int row = 0; row < 3; row++) {
        const double *r      = m + 4 * row;
        double        square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
        for (int n = 0; n < 3; n++) out[4 * n + row] = r[n] / square;
    }
    for (int n = 0; n < 3; n++) out[4 * n + 3] = -(out[4 * n] * m[3] + out[4 * n + 1] * m[7] + out[4 * n + 2] * m[11]);
}

static void set_point(bench *b, size_t n, const double vx[3])
{
    const double *m = b->ws_from_ls;
    for (int i = 0; i < 3; i++)
        b->points_ws[3 * n + (size_t)i] = m[4 * i] * vx[0] + m[4 * i + 1] * vx[1] + m[4 * i + 2] * vx[2] + m[4 * i + 3];
}

/* The first shadowed voxel of a texel's column, which is lit in front of it and dark behind; side when there is none. */
static uint32_t shadow_start(const vxs_light *light, uint32_t i, uint32_t j)
{
    uint32_t lit = 0, dark = 1u << light->levels;
    while (lit < dark) {
        uint32_t middle = lit + (dark - lit) / 2;
        if (vxs_shadow(light->words, 0, light->levels, i, j, middle))
            dark = middle;
        else
            lit = middle + 1;
    }
    return dark;
}

static void scatter(bench *b, int near_surface)
{
    uint64_t state = 1;
    double   side  = (double)(1u << b->light->levels);
    for (size_t n = 0; n < POINTS; n++) {
        double vx[3];
        for (int i = 0; i < 3; i++) vx[i] = side * next_random(&state);
        if (near_surface) vx[2] = shadow_start(b->light, (uint32_t)vx[0], (uint32_t)vx[1]) + 2 * vx[2] / side - 1;
        set_point(b, n, vx);
    }
}

static void by_file(bench *b, int filter_px)
{
    vxs_lookup_many(b->light, b->points_ws, NULL, POINTS, filter_px, b->lit);
}

static void by_depth_map(bench *b, int filter_px)
{
    int32_t side = 1 << b->light->levels, half = filter_px / 2;
    for (size_t n = 0; n < POINTS; n++) {
        int32_t voxel[3], dark = 0;
        vxs_voxel(b->light, b->points_ws + 3 * n, NULL, filter_px, voxel);
        for (int32_t y = voxel[1] - half; y <= voxel[1] + half; y++)
            for (int32_t x = voxel[0] - half; x <= voxel[0] + half; x++)
                if (x >= 0 && y >= 0 && x < side && y < side)
                    dark += b->depth[(size_t)y * (size_t)side + (size_t)x] <= (float)voxel[2];
        b->lit[n] = 1 - (float)dark / (float)(filter_px * filter_px);
    }
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

static double median_seconds(bench *b, void (*ask)(bench *, int), int filter_px)
{
    double times[RUNS];
    for (int n = 0; n < RUNS; n++) {
        double start = seconds();
        ask(b, filter_px);
        times[n] = seconds() - start;
    }
    qsort(times, RUNS, sizeof *times, compare_doubles);
    return times[RUNS / 2];
}

static void measure(bench *b, const char *name, int near_surface)
{
    scatter(b, near_surface);
    printf("  \"%s\": {\"tap_1_seconds\": %.6f, \"tap_81_seconds\": %.6f, \"depth_map_tap_1_seconds\": %.6f, "
           "\"depth_map_tap_81_seconds\": %.6f, ",
           name, median_seconds(b, by_file, 1), median_seconds(b, by_file, FILTER_PX), median_seconds(b, by_depth_map, 1),
           median_seconds(b, by_depth_map, FILTER_PX));
    by_file(b, 1);
    size_t lit = 0;
    for (size_t n = 0; n < POINTS; n++) lit += b->lit[n] != 0;
    printf("\"lit_share\": %.4f}", (double)lit / POINTS);
}

int main(int argc, char **argv)
{
    vxs_asset *asset = NULL;
    vxs_result r     = argc == 2 ? vxs_asset_open_file(&asset, argv[1], NULL) : VXS_E_ARGUMENT;
    if (r != VXS_OK) {
        fprintf(stderr, "lookups: %s: usage is lookups FILE.vxs\n", vxs_result_text(r));
        return 2;
    }
    bench  b      = {.light = vxs_asset_light(asset, 0)};
    size_t side   = (size_t)1 << b.light->levels;
    int    status = 0;
    b.points_ws   = malloc(3 * sizeof *b.points_ws * POINTS);
    b.lit         = malloc(sizeof *b.lit * POINTS);
    b.depth       = malloc(side * side * sizeof *b.depth);
    if (!b.points_ws || !b.lit || !b.depth) {
        fprintf(stderr, "lookups: out of memory\n");
        status = 6;
        goto done;
    }
    invert(b.light->ls_from_ws, b.ws_from_ls);
    uint64_t state = 2;
    for (size_t n = 0; n < side * side; n++) b.depth[n] = (float)((double)side * next_random(&state));

    printf("{\n  \"points\": %d, \"runs\": %d, \"resolution_px\": %zu,\n", POINTS, RUNS, side);
    measure(&b, "volume", 0);
    printf(",\n");
    measure(&b, "surface", 1);
    printf("\n}\n");
done:
    free(b.points_ws);
    free(b.lit);
    free(b.depth);
    vxs_asset_close(asset);
    return status;
}
