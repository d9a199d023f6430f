/* Answers of the C library, for tests of the runtime as WebAssembly.
 *
 *     answers open FILE...          a line for each: result, first finding, its section and offset
 *     answers ask FILE <POINTS      blocks of bytes: name [32], size as uint64, content. POINTS: position and normal, 6 doubles each
 *     answers time FILE <POINTS     medians: open in ms; lookups in ns for each point: single and many, 1 x 1 and 9 x 9
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "runtime/vxs_query.h"

enum { RAYS = 300, INTERVALS = 64, SHIFT = 3, ROUNDS = 15 };

typedef struct bytes {
    unsigned char *at;
    size_t         size;
} bytes;

static bytes read_all(FILE *from)
{
    bytes  b        = {0};
    size_t capacity = 0, got;
    do {
        if (b.size == capacity) b.at = realloc(b.at, capacity = 2 * capacity + (1 << 16));
        if (!b.at) exit(3);
        b.size += got = fread(b.at + b.size, 1, capacity - b.size, from);
    } while (got);
    return b;
}

static bytes read_file(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file) exit(3);
    bytes b = read_all(file);
    fclose(file);
    return b;
}

/* open ------------------------------------------------------------------------------------------------------------------------- */

typedef struct finding {
    int                number, section;
    unsigned long long offset;
} finding;

static void keep_first(void *user, int number, const char *text, int section, uint64_t offset)
{
    finding *f = user;
    (void)text;
    if (!f->number) *f = (finding){number, section, offset};
}

static void open_file(const char *path)
{
    bytes         b     = read_file(path);
    finding       first = {0, -1, 0};
    vxs_read_desc desc  = {.struct_size = sizeof desc, .finding = keep_first, .finding_user = &first, .metadata = 1};
    vxs_asset    *asset;
    vxs_result    r = vxs_asset_open(&asset, b.at, b.size, &desc);
    printf("%d %d %d %llu\n", r, first.number, first.section, first.offset);
    vxs_asset_close(asset);
    free(b.at);
}

/* ask -------------------------------------------------------------------------------------------------------------------------- */

static void put(const char *what, uint32_t light, const void *data, uint64_t size)
{
    char name[48] = {0};
    snprintf(name, sizeof name, "%s %u", what, light);
    fwrite(name, 1, 32, stdout);
    fwrite(&size, sizeof size, 1, stdout);
    fwrite(data, 1, size, stdout);
}

static void put_lookups(const vxs_baked_light *l, uint32_t number, const double *points, size_t count)
{
    static const struct {
        const char *name;
        vxs_filter  filter;
    } filters[]    = {{"box 1", {1, 0}}, {"box 9", {9, 0}}, {"smooth 4", {4, 1}}, {"smooth 9", {9, 1}}};
    float   *lit   = malloc(2 * count * sizeof *lit);
    int32_t *voxel = malloc(4 * count * sizeof *voxel);
    if (!lit || !voxel) exit(3);
    for (size_t f = 0; f < sizeof filters / sizeof *filters; f++) {
        for (size_t n = 0; n < count; n++) {
            lit[n]         = vxs_lookup(l, points + 6 * n, NULL, filters[f].filter);
            lit[count + n] = vxs_lookup(l, points + 6 * n, points + 6 * n + 3, filters[f].filter);
        }
        put(filters[f].name, number, lit, 2 * count * sizeof *lit);
    }
    for (size_t n = 0; n < count; n++)
        voxel[4 * n] = vxs_voxel(&l->light, points + 6 * n, points + 6 * n + 3, vxs_box(9), voxel + 4 * n + 1);
    put("voxel", number, voxel, 4 * count * sizeof *voxel);
    int32_t side = 1 << l->light.levels;
    for (size_t n = 0; n < count; n++) {
        const int32_t *at = voxel + 4 * n;
        int32_t        i = at[1] & (side - 1), j = at[2] & (side - 1);
        ((int32_t *)lit)[n] = vxs_first_shadow(l, at[0] < 0 ? 0 : at[0], i, j, NULL);
    }
    put("first shadow", number, lit, count * sizeof *lit);
    free(lit);
    free(voxel);
}

static void put_rays(const vxs_baked_light *l, uint32_t number, const double *points, size_t count)
{
    double *all  = NULL;
    size_t  size = 0;
    for (size_t n = 0; n < count && n < RAYS; n++) {
        const double *p   = points + 6 * n;
        vxs_ray       ray = {{p[0], p[1], p[2]}, {p[3], p[4], p[5]}, 0, n % 2 ? INFINITY : 50};
        vxs_lit_walk  walk;
        vxs_interval  found[INTERVALS];
        size_t        got = INTERVALS;
        if (vxs_lit_begin(&walk, l, &ray) != VXS_OK) continue;
        while (got == INTERVALS) {
            got = vxs_lit_next(&walk, found, INTERVALS);
            all = realloc(all, (size + 3 * got + 1) * sizeof *all);
            for (size_t k = 0; k < got; k++) {
                all[size++] = found[k].t_begin;
                all[size++] = found[k].t_end;
                all[size++] = found[k].state;
            }
        }
    }
    put("rays", number, all, size * sizeof *all);
    free(all);
}

static void put_depths(const vxs_baked_light *l, uint32_t number)
{
    static const char *const names[] = {"centre", "least", "greatest"};
    uint32_t                 side    = (1u << l->light.levels) >> SHIFT;
    uint32_t                *depth   = malloc((size_t)side * side * 4);
    if (!depth) exit(3);
    for (uint32_t which = 0; which < 6; which++) {
        vxs_depth_map_desc to = {.map     = (int32_t)vxs_map_count(&l->light) - 1,
                                 .wide_px = side,
                                 .high_px = side,
                                 .shift   = SHIFT,
                                 .which   = which % 3,
                                 .voxels  = which < 3 ? NULL : depth,
                                 .depths  = which < 3 ? (float *)depth : NULL};
        char               name[32];
        snprintf(name, sizeof name, "%s %s", which < 3 ? "depths" : "voxels", names[which % 3]);
        if (vxs_depth_map(l, &to, NULL) != VXS_OK) exit(3);
        put(name, number, depth, (uint64_t)side * side * 4);
    }
    free(depth);
}

static void ask(const char *path, const double *points, size_t count)
{
    const double origin[3] = {1, 2, 3};
    vxs_asset   *asset;
    if (vxs_asset_open_file(&asset, path, NULL) != VXS_OK) exit(3);
    for (uint32_t n = 0; n < vxs_asset_light_count(asset); n++) {
        const vxs_baked_light *l = vxs_asset_light(asset, n);
        vxs_light_constants    c = vxs_light_constants_of(&l->light, origin, 7);
        put("constants", n, &c, sizeof c);
        put("matrix", n, l->light.ls_from_ws, sizeof l->light.ls_from_ws);
        put("words", n, l->words, 4 * (uint64_t)l->word_count);
        put_lookups(l, n, points, count);
        put_rays(l, n, points, count);
        put_depths(l, n);
        float *left = malloc(count * sizeof *left);
        if (!left) exit(3);
        for (size_t k = 0; k < count; k++) left[k] = vxs_smoke_lookup(&l->light, vxs_asset_smoke(asset, n), points + 6 * k);
        put("smoke", n, left, count * sizeof *left);
        free(left);
    }
    const vxs_baked_points *casters = vxs_asset_points(asset);
    if (casters) {
        float *out = malloc(16 * (size_t)casters->count);
        if (!out) exit(3);
        vxs_points_unpack(casters, origin, out);
        put("points", 0, out, 16 * (uint64_t)casters->count);
        free(out);
    }
    vxs_asset_close(asset);
}

/* time ------------------------------------------------------------------------------------------------------------------------- */

static double now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(double *values)
{
    qsort(values, ROUNDS, sizeof *values, compare);
    return values[ROUNDS / 2];
}

static void measure(const char *path, const double *points, size_t count)
{
    bytes         b    = read_file(path);
    vxs_read_desc desc = {.struct_size = sizeof desc, .metadata = 1};
    vxs_asset    *asset;
    float        *lit = malloc(count * sizeof *lit);
    double        t[5][ROUNDS], *packed = malloc(3 * count * sizeof *packed);
    if (!lit || !packed) exit(3);
    for (size_t n = 0; n < count; n++) memcpy(packed + 3 * n, points + 6 * n, 3 * sizeof *packed);
    for (int r = 0; r < ROUNDS; r++) {
        double begin = now_ms();
        if (vxs_asset_open(&asset, b.at, b.size, &desc) != VXS_OK) exit(3);
        t[0][r] = now_ms() - begin;
        for (int k = 0; k < 4; k++) {
            const vxs_baked_light *l      = vxs_asset_light(asset, 0);
            vxs_filter             filter = vxs_box(k % 2 ? 9 : 1);
            begin                         = now_ms();
            if (k < 2)
                for (size_t n = 0; n < count; n++) lit[n] = vxs_lookup(l, packed + 3 * n, NULL, filter);
            else
                vxs_lookup_many(l, packed, NULL, count, filter, lit);
            t[k + 1][r] = 1e6 * (now_ms() - begin) / (double)count;
        }
        vxs_asset_close(asset);
    }
    for (int k = 0; k < 5; k++) printf("%.2f%c", median(t[k]), k < 4 ? ' ' : '\n');
    free(lit);
    free(packed);
    free(b.at);
}

int main(int argc, char **argv)
{
    if (argc < 3) return 2;
    if (!strcmp(argv[1], "open")) {
        for (int n = 2; n < argc; n++) open_file(argv[n]);
        return 0;
    }
    bytes  b     = read_all(stdin);
    size_t count = b.size / 48;
    (strcmp(argv[1], "ask") ? measure : ask)(argv[2], (const double *)(void *)b.at, count);
    free(b.at);
    return 0;
}
