/* Comparing files with depth maps; see check.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/exact/check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "formats/vxs_space.h"

#include "baker/bake/plan.h"
#include "baker/base/parallel.h"
#include "baker/base/random.h"
#include "baker/columns/sparse/sparse_triangles.h"
#include "tests/columns/brute.h"
#include "tests/exact/coded_runs.h"
#include "tests/exact/silhouettes.h"

enum { WINDOW_VX = 3, RANDOM_VOXELS = 16, EACH_VOXEL_MAX_VX = 64 };

/* The depths of a tile of a map in voxels: what ends before `enter` has to be lit, what begins behind `exit` has to be dark. */
typedef struct tile_depths {
    uint32_t side_px;
    double  *enter, *exit; /* [side_px * side_px] rows of texels */
} tile_depths;

/* A tile of a map while it is compared. */
typedef struct check {
    const check_desc *d;
    tile_depths       depths;
    const depth_maps *maps;  /* rendered; or NULL */
    const brute      *brute; /* or this */
    uint32_t          map;
    uint32_t          side_vx;
    uint32_t          i0, j0; /* first texel of the rendered tile in the map */
    uint64_t          seed;
    const map_tile   *listed; /* tiles to be queried; NULL: random ones */
    tally            *worker; /* [PARALLEL_THREADS_MAX * file_count] */
} check;

/* A depth as it was sampled, in voxels: shares of the whole, or near / distance of a perspective map, negative, whose logarithm is
 * divided by a voxel's. */
static double voxels(const check *c, float depth)
{
    if (c->maps->voxel_log == 0) return (double)depth * c->side_vx;
    return depth == 0 ? c->side_vx : fmin(log(-1 / (double)depth) / c->maps->voxel_log, c->side_vx);
}

/* filling in the depths of a tile
 * -------------------------------------------------------------------------------------------------------------------- */

static void fill_rows(void *user, size_t begin, size_t end, uint32_t worker)
{
    check *c = user;
    (void)worker;
    for (size_t j = begin; j < end; j++)
        for (uint32_t i = 0; i < c->depths.side_px; i++) {
            size_t at = j * c->depths.side_px + i;
            if (c->brute) {
                brute_column column = brute_at(c->brute, c->i0 + i, c->j0 + (uint32_t)j);
                c->depths.enter[at] = column.e_least;
                c->depths.exit[at]  = column.x_most;
            } else {
                c->depths.enter[at] = voxels(c, c->maps->enter[at]);
                c->depths.exit[at]  = voxels(c, c->maps->exit[at]);
            }
        }
}

/* voxel by voxel: the lookup of every voxel, or of those where columns change
 * -------------------------------------------------------------------------- */

static void ask_voxel(const check *c, uint32_t file, tally *t, uint32_t i, uint32_t j, uint32_t k)
{
    size_t   at = (size_t)j * c->depths.side_px + i;
    int32_t  u = (int32_t)(c->i0 + i), v = (int32_t)(c->j0 + j);
    uint32_t dark = vxs_shadow_taps(c->d->files[file].words, c->d->files[file].light, (int32_t)c->map, u, v, k, 1);
    t->lookups++;
    t->wrong_shadow += dark && (double)k + 1 <= c->depths.enter[at];
    t->wrong_lit += !dark && (double)k >= c->depths.exit[at];
}

static void ask_window(const check *c, uint32_t file, tally *t, uint32_t i, uint32_t j, double depth)
{
    int64_t at = (int64_t)depth;
    for (int64_t k = at - WINDOW_VX; k <= at + WINDOW_VX; k++)
        if (k >= 0 && k < c->side_vx) ask_voxel(c, file, t, i, j, (uint32_t)k);
}

/* Voxels around both depths of a column, at both ends, and anywhere. */
static void ask_column(const check *c, uint32_t file, tally *t, uint32_t i, uint32_t j, rng *random)
{
    size_t at = (size_t)j * c->depths.side_px + i;
    ask_window(c, file, t, i, j, c->depths.enter[at]);
    ask_window(c, file, t, i, j, c->depths.exit[at]);
    ask_voxel(c, file, t, i, j, 0);
    ask_voxel(c, file, t, i, j, c->side_vx - 1);
    for (int k = 0; k < RANDOM_VOXELS; k++) ask_voxel(c, file, t, i, j, rng_below(random, c->side_vx));
}

static void ask_random_columns(void *user, size_t begin, size_t end, uint32_t worker)
{
    const check *c = user;
    for (uint32_t file = 0; file < c->d->file_count; file++) {
        tally *t = &c->worker[worker * c->d->file_count + file];
        for (size_t n = begin; n < end; n++) {
            rng      random = rng_split(c->seed, n);
            uint32_t i = rng_below(&random, c->depths.side_px), j = rng_below(&random, c->depths.side_px);
            uint64_t before = t->lookups;
            ask_column(c, file, t, i, j, &random);
            t->voxels += t->lookups - before;
            t->columns++;
        }
    }
}

/* all voxels of 8 x 8 texels, by runs of equal slices
 * ---------------------------------------------------------------- */

/* The columns of an 8 x 8 tile in whole voxels: those that must be lit are [0, lit_end), those that must be dark [dark_begin,
 * ...). */
typedef struct tile_columns {
    uint32_t lit_end[64], dark_begin[64];
    uint32_t lit_end_max, dark_begin_min;
} tile_columns;

typedef struct asked_tile {
    const tile_columns *columns;
    uint32_t            at_vx; /* where the next run has to begin */
    tally              *t;
} asked_tile;

static void ask_run(void *user, uint32_t begin, uint32_t end, uint64_t dark, int misread)
{
    asked_tile *a            = user;
    /* most runs are all lit before every surface, or all dark behind: nothing can be wrong in them */
    int         may_be_wrong = (dark && begin < a->columns->lit_end_max) || (~dark && end > a->columns->dark_begin_min);
    for (uint32_t n = 0; may_be_wrong && n < 64; n++) {
        uint32_t lit_end = a->columns->lit_end[n], dark_begin = a->columns->dark_begin[n];
        if (dark >> n & 1)
            a->t->wrong_shadow += lit_end <= begin ? 0 : min_u32(end, lit_end) - begin;
        else
            a->t->wrong_lit += dark_begin >= end ? 0 : end - (dark_begin > begin ? dark_begin : begin);
    }
    a->t->misread += misread || begin != a->at_vx;
    a->t->voxels += (uint64_t)64 * (end - begin);
    a->at_vx = end;
}

static void ask_tile(const check *c, uint32_t x, uint32_t y, uint32_t worker)
{
    tile_columns columns = {.lit_end_max = 0, .dark_begin_min = c->side_vx};
    for (uint32_t n = 0; n < 64; n++) {
        size_t at              = (size_t)(8 * y + n / 8) * c->depths.side_px + 8 * x + n % 8;
        columns.lit_end[n]     = (uint32_t)fmax(0, floor(c->depths.enter[at])); /* by brute force, a hair less than 0 */
        columns.dark_begin[n]  = (uint32_t)ceil(c->depths.exit[at]);
        columns.lit_end_max    = max_u32(columns.lit_end_max, columns.lit_end[n]);
        columns.dark_begin_min = min_u32(columns.dark_begin_min, columns.dark_begin[n]);
    }
    for (uint32_t file = 0; file < c->d->file_count; file++) {
        tally     *t = &c->worker[worker * c->d->file_count + file];
        asked_tile a = {&columns, 0, t};
        coded_runs(c->d->files[file].words, c->d->files[file].light, c->map, c->i0 / 8 + x, c->j0 / 8 + y, ask_run, &a);
        t->misread += a.at_vx != c->side_vx;
        t->columns += 64;
        for (uint32_t n = 0; c->side_vx <= EACH_VOXEL_MAX_VX && n < 64 * c->side_vx; n++)
            ask_voxel(c, file, t, 8 * x + n % 8, 8 * y + n / 8 % 8, n / 64);
    }
}

static void ask_rows(void *user, size_t begin, size_t end, uint32_t worker)
{
    const check *c = user;
    for (size_t y = begin; y < end; y++)
        for (uint32_t x = 0; x < c->depths.side_px / 8; x++) ask_tile(c, x, (uint32_t)y, worker);
}

static void add_tallies(const check *c)
{
    for (size_t n = 0; n < (size_t)PARALLEL_THREADS_MAX * c->d->file_count; n++) {
        tally *to = &c->d->files[n % c->d->file_count].sum, *from = &c->worker[n];
        to->columns += from->columns;
        to->voxels += from->voxels;
        to->lookups += from->lookups;
        to->wrong_lit += from->wrong_lit;
        to->wrong_shadow += from->wrong_shadow;
        to->misread += from->misread;
        memset(from, 0, sizeof *from);
    }
}

/* a few tiles, by brute force
 * ---------------------------------------------------------------------------------------- */

/* A texel: anywhere, or every other time where an edge of a triangle passes. */
static void choose_texel(const check *c, rng *random, uint32_t *u, uint32_t *v)
{
    const projection *p = c->brute->p;
    *u = rng_below(random, c->side_vx), *v = rng_below(random, c->side_vx);
    if (!p->triangle_count || rng_below(random, 2)) return;
    const uint32_t  *corner = p->indices + 3 * (size_t)rng_below(random, (uint32_t)p->triangle_count);
    const vertex_ls *a = &p->vertices[corner[0]], *b = &p->vertices[corner[1]];
    double           along = rng_unit(random), x = a->u + along * (b->u - a->u), y = a->v + along * (b->v - a->v);
    if (x < 0 || x >= c->side_vx || y < 0 || y >= c->side_vx) return;
    *u = (uint32_t)x, *v = (uint32_t)y;
}

static void ask_tiles(void *user, size_t begin, size_t end, uint32_t worker)
{
    for (size_t n = begin; n < end; n++) {
        check    c = *(const check *)user;
        double   enter[64], exit[64];
        rng      random = rng_split(c.seed, n);
        uint32_t u, v;
        if (c.listed)
            u = 8 * c.listed[n].i, v = 8 * c.listed[n].j;
        else
            choose_texel(&c, &random, &u, &v);
        c.depths = (tile_depths){8, enter, exit};
        c.i0     = u / 8 * 8;
        c.j0     = v / 8 * 8;
        fill_rows(&c, 0, 8, worker);
        ask_tile(&c, 0, 0, worker);
        for (uint32_t file = 0; file < c.d->file_count; file++)
            for (uint32_t texel = 0; texel < 64; texel++)
                ask_column(&c, file, &c.worker[worker * c.d->file_count + file], texel % 8, texel / 8, &random);
    }
}

/* Random tiles, and those around silhouettes. */
static vxs_result ask_some_tiles(check *c, run_context *m)
{
    const check_desc *d      = c->d;
    map_tile         *listed = NULL;
    size_t            count  = 0;
    c->seed                  = rng_split(d->seed, c->map).state;
    parallel_for(d->threads, (d->columns + 63) / 64, 1, ask_tiles, c);
    if (d->silhouettes) {
        vxs_result r = silhouette_tiles(&listed, &count, c->brute->p, c->side_vx, d->silhouettes, c->seed);
        if (r != VXS_OK) return fail(m, r, "out of memory for tiles around silhouettes");
        c->listed = listed;
        parallel_for(d->threads, count, 1, ask_tiles, c);
        free(listed);
    }
    add_tallies(c);
    return VXS_OK;
}

/* a map
 * --------------------------------------------------------------------------------------------------------------------- */

/* Depths are depths, and a column without a solid is entered and left at once. */
static uint64_t insane_texels(const depth_maps *maps, const depth_maps *solids)
{
    uint64_t count  = 0;
    size_t   texels = (size_t)maps->side_px * maps->side_px;
    float    near = maps->voxel_log == 0 ? 0 : -1, far = near + 1;
    for (size_t n = 0; n < texels; n++) {
        float e = maps->enter[n], x = maps->exit[n];
        count += !(near <= e && e <= x && x <= far) || ((!solids || solids->enter[n] == far) && e != x);
    }
    return count;
}

/* Render the tile (i, j) of a map. One renderer at a time sets up the context. */
static vxs_result render(const check_desc *d, const casters *c, exit_mode exit, int map, depth_maps *maps, uint32_t i, uint32_t j,
                         run_context *m)
{
    depth_renderer *renderer = NULL;
    vxs_result      r        = depth_renderer_create(&renderer, d->gl, c, d->light, map, exit, d->threads, m);
    if (r == VXS_OK) r = depth_renderer_tile(renderer, maps, i, j, m);
    depth_renderer_destroy(renderer);
    return r;
}

/* Render the tile (i, j) and count what cannot be in it. */
static vxs_result render_tile(const check_desc *d, int map, depth_maps *maps, depth_maps *solids, uint32_t i, uint32_t j,
                              run_context *m)
{
    casters    all = *d->casters, solids_only;
    int        any = all.solid_triangle_count != 0;
    vxs_result r;
    all.solid_meets            = NULL; /* what a plan found out is not trusted: all solids are peeled */
    solids_only                = all;
    solids_only.triangle_count = solids_only.holed_first = all.solid_triangle_count;
    solids_only.alpha_mask_count                         = 0;
    if ((r = render(d, &all, d->exit, map, maps, i, j, m)) != VXS_OK) return r;
    if (any && (r = render(d, &solids_only, EXIT_BACK, map, solids, i, j, m)) != VXS_OK) return r;
    uint64_t insane = insane_texels(maps, any ? solids : NULL);
    for (uint32_t file = 0; file < d->file_count; file++) d->files[file].sum.insane += insane;
    return VXS_OK;
}

static vxs_result check_tile(check *c, depth_maps *maps, depth_maps *solids, uint32_t tiles, uint32_t n, run_context *m)
{
    const check_desc *d    = c->d;
    uint32_t          tile = c->depths.side_px, i = n % tiles, j = n / tiles;
    vxs_result        r = c->brute ? VXS_OK : render_tile(d, (int)c->map, maps, solids, i, j, m);
    if (r != VXS_OK) return r;
    c->i0   = i * tile;
    c->j0   = j * tile;
    c->seed = rng_split(d->seed + c->map, n).state;
    parallel_for(d->threads, tile, 4, fill_rows, c);
    if (d->columns)
        parallel_for(d->threads, d->columns / (tiles * tiles), 1024, ask_random_columns, c);
    else
        parallel_for(d->threads, tile / 8, 1, ask_rows, c);
    add_tallies(c);
    return VXS_OK;
}

static vxs_result init_depths(check *c, depth_maps *maps, depth_maps *solids, uint32_t tile, double voxel_log, run_context *m)
{
    const check_desc *d      = c->d;
    size_t            texels = (size_t)tile * tile;
    int               any    = d->casters->solid_triangle_count != 0;
    c->worker                = calloc((size_t)PARALLEL_THREADS_MAX * d->file_count, sizeof *c->worker);
    c->depths = (tile_depths){tile, malloc(texels * sizeof *c->depths.enter), malloc(texels * sizeof *c->depths.exit)};
    if (!c->worker || !c->depths.enter || !c->depths.exit) return fail(m, VXS_E_MEMORY, "out of memory");
    if (d->brute) return VXS_OK;
    vxs_result r = depth_maps_init(maps, tile, c->side_vx, voxel_log, any, m);
    return r == VXS_OK && any ? depth_maps_init(solids, tile, c->side_vx, voxel_log, 1, m) : r;
}

vxs_result check_map(const check_desc *d, int map, run_context *m)
{
    depth_maps maps = {0}, solids = {0};
    projection p    = {0};
    brute      b    = {0};
    uint32_t   side = 1u << d->light->levels;
    uint32_t   tile = min_u32(side, TILE_MAX_PX), tiles = side / tile; /* a side */
    double     voxel_log = d->light->kind == VXS_LIGHT_KIND_DIRECTIONAL ? 0 : d->light->voxel_metres;
    check      c         = {.d = d, .maps = &maps, .map = (uint32_t)map, .side_vx = side};
    vxs_result r         = init_depths(&c, &maps, &solids, tile, voxel_log, m);
    if (r == VXS_OK && d->brute) {
        c.brute = &b;
        r       = projection_init(&p, d->casters, d->light, map, d->threads, m);
        if (r == VXS_OK && !brute_init(&b, &p, side, 1 << sparse_grid(side), voxel_log, d->exit == EXIT_BACK))
            r = fail(m, VXS_E_MEMORY, "out of memory");
        b.free_behind = d->behind;
        b.thickness   = d->thickness / (voxel_log == 0 ? d->light->voxel_metres : d->light->near_metres);
    }
    if (d->brute && d->columns) {
        if (r == VXS_OK) r = ask_some_tiles(&c, m);
        tiles = 0;
    }
    for (uint32_t n = 0; n < tiles * tiles && r == VXS_OK; n++) r = check_tile(&c, &maps, &solids, tiles, n, m);
    free(c.worker);
    free(c.depths.enter);
    free(c.depths.exit);
    depth_maps_free(&maps);
    depth_maps_free(&solids);
    brute_free(&b);
    projection_free(&p);
    return r;
}
