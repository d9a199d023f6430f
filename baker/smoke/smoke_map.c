/* The map of curves of a light; see smoke_map.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/smoke/smoke_map.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/integer.h"
#include "baker/base/memory.h"
#include "baker/base/parallel.h"
#include "baker/base/portable_math.h"
#include "baker/base/random.h"
#include "baker/base/vec3.h"
#include "formats/vxs_smoke.h"
#include "formats/vxs_space.h"
#include "runtime/vxs.h"
#include "runtime/vxs_query.h"

enum { TILE_PX = SMOKE_TILE_PX, TILE_TEXELS = TILE_PX * TILE_PX, ENDS_PX_MOST = 2 * TILE_PX + 2 };
enum { PLACES_ASKED = 1000 };
enum { SIDE_LEAST = 64, SIDE_MOST = 1024, SIDE_OF_CAPSULES = 256 }; /* of maps without a given side */

/* Scratch of a worker. */
typedef struct tools {
    smoke_path    path, of_grid, of_capsules; /* the first is the sum of both */
    smoke_changes changes;
} tools;

/* The map of curves of a light. Its arrays belong to it. */
typedef struct smoke_map {
    vxs_smoke_view view; /* of the arrays below; counts NULL: the light loses nothing in smoke */
    uint8_t       *counts;
    uint32_t      *nodes;
    size_t         texel_count, curve_count, node_count;
    size_t         word_count;    /* size in memory (formats/vxs.md section 15) */
    double         largest_error; /* of a curve, without interpolation */
    smoke_lookups  lookups;
} smoke_map;

/* A map in work. */
typedef struct maker {
    smoke_source           source;
    smoke_bins             bins; /* of capsules */
    const vxs_baked_light *baked;
    smoke_settings         settings;
    uint32_t               levels, tiles_across, workers;
    smoke_units            units;
    uint8_t               *counts;     /* [maps * 4^levels] */
    uint32_t             **tile_nodes; /* [tiles] owned; NULL: the tile has none */
    tools                 *tools;      /* [workers] */
    double                *errors;     /* [workers] largest error */
    int                   *failed;     /* [workers] 1: no memory */
} maker;

/* A tile of curves. */
typedef struct tile {
    size_t   number;
    int32_t  map, x, y; /* position of its first texel */
    int      has_ends;
    uint32_t px; /* pixels of `ends` in a row: half a texel, or a texel if it is as small as one of the light's */
    uint32_t ends[ENDS_PX_MOST * ENDS_PX_MOST]; /* last lit depth in each pixel, voxels; from the pixel before the tile on */
} tile;

static int is_sun(const vxs_light *light)
{
    return light->kind == VXS_LIGHT_KIND_DIRECTIONAL;
}

/* space ------------------------------------------------------------------------------------------------------------------------ */

/* The depth of a voxel's near side, metres along the map's axis. */
static double metres_of(const vxs_light *light, double voxel)
{
    return is_sun(light) ? voxel * light->voxel_metres : light->near_metres * portable_exp(voxel * light->voxel_metres);
}

/* Depth of a point in one of the light's maps. */
static double depth_of(const vxs_light *light, int32_t map, const double ws[3])
{
    double ls[3], turned[3];
    vxs_ls_from_ws(light, ws, 1, ls);
    if (is_sun(light)) return ls[2] * light->voxel_metres;
    vxs_face_from_ls(vxs_face_of_map(light, map), ls, turned);
    return turned[2];
}

/* The ray through the centre of a texel: at depth d it is at from + d * way. */
static void ray_of(const maker *k, int32_t map, double x, double y, double from[3], double way[3])
{
    vxs_light light = k->baked->light;
    double    texel = ldexp(1, (int)(light.levels - k->levels)), ends[2][3];
    for (int metres = 1; metres <= 2; metres++) {
        double at[3] = {(x + 0.5) * texel, (y + 0.5) * texel, 0};
        /* a copy of a punctual light has its near plane at that depth: vxs_point calls exp, which is exact for 0 alone */
        if (is_sun(&light))
            at[2] = metres / light.voxel_metres;
        else
            light.near_metres = metres;
        vxs_point(&light, map, at, ends[metres - 1]);
    }
    vec3_sub(ends[1], ends[0], way);
    vec3_sub(ends[0], way, from);
}

/* Choose units that cover the depths of all smoke; a punctual light's light begins at its near plane. Returns 0: light does not
 * reach the smoke. */
static int find_units(maker *k)
{
    const vxs_light   *light    = &k->baked->light;
    const scene_smoke *capsules = k->source.capsules;
    double             range[2] = {INFINITY, -INFINITY}; /* depths of smoke: least, greatest */
    for (int32_t map = 0; map < (int32_t)vxs_map_count(light); map++) {
        for (int corner = 0; corner < 8 && k->source.grid; corner++) {
            double ws[3];
            smoke_grid_corner(k->source.grid, corner, ws);
            double depth = depth_of(light, map, ws);
            range[0]     = fmin(range[0], depth);
            range[1]     = fmax(range[1], depth);
        }
        for (uint32_t n = 0; capsules && n < capsules->count; n++) smoke_capsule_depths(capsules, n, light, map, range);
    }
    double least = range[0], most = range[1];
    if (!is_sun(light)) {
        least = fmax(least, 0);
        if (light->range_metres > 0) most = fmin(most, light->range_metres);
    }
    float first = (float)least, step;
    while ((double)first > least) first = nextafterf(first, -INFINITY);
    step = (float)((most - (double)first) / 65535);
    while ((double)first + 65535 * (double)step < most) step = nextafterf(step, INFINITY);
    k->units = (smoke_units){(double)first, (double)step};
    return most > least && step > 0;
}

/* Curves along a side: their spacing at the grid is about that of its samples. SIDE_OF_CAPSULES without a grid. */
static uint32_t side_of(const smoke_source *source, const vxs_light *light)
{
    double   middle[3], far[3], at[3], wide = ldexp(light->texel_metres, (int)light->levels);
    uint32_t side = SIDE_LEAST;
    if (!source->grid) return SIDE_OF_CAPSULES;
    smoke_grid_middle(source->grid, middle);
    smoke_grid_corner(source->grid, 0, far);
    vec3_sub(far, middle, far);
    vxs_ls_from_ws(light, middle, 1, at); /* punctual lights: distance in metres, by which maps are wider there */
    if (!is_sun(light)) wide *= fmax(sqrt(vec3_dot(at, at)), sqrt(vec3_dot(far, far)));
    while (side < SIDE_MOST && wide / side > 1.01 * smoke_grid_spacing(source->grid)) side *= 2;
    return side;
}

/* curves ----------------------------------------------------------------------------------------------------------------------- */

/* The path of a ray, also behind opaque smoke.
 * x, y  texels from the tile's first, within half a texel around the tile
 * Returns 0 without memory */
static int find_ray_path(const maker *k, const tile *t, double x, double y, tools *w)
{
    double from[3], way[3];
    ray_of(k, t->map, t->x + x, t->y + y, from, way);
    double range = k->baked->light.range_metres, begin = is_sun(&k->baked->light) ? -INFINITY : 0;
    double end       = range > 0 ? range / sqrt(vec3_dot(way, way)) : INFINITY;
    w->of_grid.count = w->of_capsules.count = 0;
    if (k->source.grid && !smoke_grid_march(k->source.grid, from, way, begin, end, &w->of_grid)) return 0;
    if (k->source.capsules) {
        const size_t *first = k->bins.first + t->number;
        if (!smoke_capsules_march(k->source.capsules, k->bins.capsules + first[0], first[1] - first[0], from, way, begin, end,
                                  &w->changes, &w->of_capsules))
            return 0;
    }
    return smoke_path_sum(&w->of_grid, &w->of_capsules, &w->path);
}

/* The path of a texel's ray, up to the end of light.   Returns 0 without memory */
static int find_path(const maker *k, tile *t, uint32_t x, uint32_t y, tools *w)
{
    if (!find_ray_path(k, t, x, y, w)) return 0;
    if (!w->path.count) return 1;
    if (!t->has_ends) {
        uint32_t           halves = k->levels < k->baked->light.levels, pixels = halves ? 2 : 1;
        int32_t            size = 1 << (k->baked->light.levels - k->levels - halves);
        vxs_depth_map_desc desc = {.map     = t->map,
                                   .i       = (t->x * (int32_t)pixels - 1) * size,
                                   .j       = (t->y * (int32_t)pixels - 1) * size,
                                   .wide_px = pixels * TILE_PX + 2,
                                   .high_px = pixels * TILE_PX + 2,
                                   .shift   = k->baked->light.levels - k->levels - halves,
                                   .which   = VXS_DEPTH_GREATEST,
                                   .voxels  = t->ends};
        t->px                   = desc.wide_px;
        t->has_ends             = 1;
        if (vxs_depth_map(k->baked, &desc, NULL) != VXS_OK) return 0;
    }

    /* cut where light has ended for all points that use a texel's curve; x and y count from the tile's first texel */
    uint32_t pixels = (t->px - 2) / TILE_PX, last = 0;
    for (uint32_t j = y * pixels; j < (y + 1) * pixels + 2; j++)
        for (uint32_t i = x * pixels; i < (x + 1) * pixels + 2; i++) last = max_u32(last, t->ends[j * t->px + i]);
    smoke_path_cut(&w->path, last < 1u << k->baked->light.levels ? metres_of(&k->baked->light, last + 1.0) : INFINITY);
    return 1;
}

static tile tile_of(const maker *k, size_t number)
{
    size_t in_map = (size_t)k->tiles_across * k->tiles_across;
    return (tile){.number = number,
                  .map    = (int32_t)(number / in_map),
                  .x      = (int32_t)(number % k->tiles_across) * TILE_PX,
                  .y      = (int32_t)(number % in_map / k->tiles_across) * TILE_PX};
}

static void make_tile(maker *k, size_t number, uint32_t worker)
{
    tools   *w      = &k->tools[worker];
    uint8_t *counts = k->counts + number * TILE_TEXELS;
    tile     t      = tile_of(k, number);
    uint32_t nodes[TILE_TEXELS * VXS_SMOKE_NODES_MAX], count = 0;
    for (uint32_t n = 0; n < TILE_TEXELS; n++) {
        if (!find_path(k, &t, n % TILE_PX, n / TILE_PX, w)) goto failed;
        counts[n]         = (uint8_t)smoke_path_nodes(&w->path, &k->units, k->settings.error, k->settings.nodes, nodes + count);
        k->errors[worker] = fmax(k->errors[worker], smoke_path_error(&w->path, &k->units, nodes + count, counts[n]));
        count += counts[n];
    }
    if (!count) return;
    if (!(k->tile_nodes[number] = malloc(count * sizeof *nodes))) goto failed;
    memcpy(k->tile_nodes[number], nodes, count * sizeof *nodes);
    return;
failed:
    k->failed[worker] = 1;
}

static void make_tiles(void *user, size_t begin, size_t end, uint32_t worker)
{
    maker *k = user;
    for (size_t n = begin; n < end && !k->failed[worker]; n++) make_tile(k, n, worker);
}

/* all tiles ------------------------------------------------------------------------------------------------------------------- */

static uint64_t tile_count(const maker *k)
{
    return (uint64_t)vxs_map_count(&k->baked->light) * k->tiles_across * k->tiles_across;
}

static int take_memory(maker *k)
{
    k->counts     = calloc(tile_count(k), TILE_TEXELS);
    k->tile_nodes = calloc(tile_count(k), sizeof *k->tile_nodes);
    k->tools      = calloc(k->workers, sizeof *k->tools);
    k->errors     = calloc(k->workers, sizeof *k->errors);
    k->failed     = calloc(k->workers, sizeof *k->failed);
    if (!k->counts || !k->tile_nodes || !k->tools || !k->errors || !k->failed) return 0;
    return !k->source.capsules || smoke_bins_make(&k->bins, k->source.capsules, &k->baked->light, k->levels);
}

/* Concatenate the nodes of all tiles; leaves the map empty if there are none. */
static int put_together(maker *k, smoke_map *map)
{
    map->texel_count = tile_count(k) * TILE_TEXELS;
    for (size_t n = 0; n < map->texel_count; n++) {
        map->node_count += k->counts[n];
        map->curve_count += k->counts[n] > 0;
    }
    for (uint32_t n = 0; n < k->workers; n++) map->largest_error = fmax(map->largest_error, k->errors[n]);
    if (!map->node_count) return 1;
    map->word_count = 3 + tile_count(k) + map->node_count;
    if (!(map->nodes = malloc(map->node_count * sizeof *map->nodes))) return 0;
    uint32_t *to = map->nodes;
    for (size_t number = 0; number < tile_count(k); number++) {
        size_t count = 0;
        for (int n = 0; n < TILE_TEXELS; n++) count += k->counts[number * TILE_TEXELS + (size_t)n];
        if (count) memcpy(to, k->tile_nodes[number], count * sizeof *to);
        if (count) map->word_count += TILE_TEXELS / 2;
        to += count;
    }
    map->counts = k->counts;
    k->counts   = NULL;
    map->view   = (vxs_smoke_view){k->levels, (float)k->units.first_metres, (float)k->units.step_metres, map->counts, map->nodes};
    return 1;
}

/* lookups ---------------------------------------------------------------------------------------------------------------------- */

/* Words that lookups read, as formats/vxs_smoke.h has them.   Returns NULL without memory; freed by the caller */
static uint32_t *words_of(const maker *k, const smoke_map *map)
{
    uint32_t       *words = calloc(map->word_count, sizeof *words), at = 3 + (uint32_t)tile_count(k);
    const float     units[2] = {map->view.first_metres, map->view.step_metres};
    const uint32_t *nodes    = map->nodes;
    if (!words) return NULL;
    words[0] = map->view.levels;
    memcpy(words + 1, units, sizeof units);
    for (size_t number = 0; number < tile_count(k); number++) {
        const uint8_t *counts = map->counts + number * TILE_TEXELS;
        uint32_t       sum    = 0;
        for (uint32_t n = 0; n < TILE_TEXELS; n++) {
            sum += counts[n];
            if (sum) words[at + n / 2] |= sum << (n % 2 * 16);
        }
        if (!sum) continue;
        words[3 + number] = at;
        memcpy(words + at + TILE_TEXELS / 2, nodes, sum * sizeof *nodes);
        nodes += sum;
        at += TILE_TEXELS / 2 + sum;
    }
    return words;
}

/* Error of a lookup at a random lit point within half a texel of a curve; in the smoke, or behind it.
 * off  [out] NAN: no such point was found.   Returns 0 without memory */
static int try_lookup(const maker *k, const uint32_t *words, size_t texel, rng *r, double *off)
{
    const vxs_light *light = &k->baked->light;
    const tile       t     = tile_of(k, texel / TILE_TEXELS);
    double           x = texel % TILE_PX + rng_unit(r) - 0.5, y = texel % TILE_TEXELS / TILE_PX + rng_unit(r) - 0.5;
    double           scale = ldexp(1, (int)(light->levels - k->levels)), part = fmin(2 * rng_unit(r), 1), from[3], way[3], ws[3];
    smoke_path      *path = &k->tools->path;
    *off                  = NAN;
    if (!find_ray_path(k, &t, x, y, k->tools)) return 0;
    if (!path->count) return 1;
    int32_t first = vxs_first_shadow(k->baked, t.map, (int32_t)((t.x + x + 0.5) * scale), (int32_t)((t.y + y + 0.5) * scale), NULL);
    double  last = path->depth[path->count - 1], end = first < 0 ? last : fmin(last, metres_of(light, first - 0.01));
    double  depth = path->depth[0] + part * (end - path->depth[0]);
    ray_of(k, t.map, t.x + x, t.y + y, from, way);
    vec3_mad(from, depth, way, ws);
    if (end > path->depth[0] && vxs_lookup(k->baked, ws, NULL, vxs_box(1)) == 1)
        *off = fabs(vxs_smoke_left(words, light, ws) - portable_exp(-smoke_path_thick(path, depth)));
    return 1;
}

/* Measure lookups at points spread over all curves.   Returns 0 without memory */
static int measure_lookups(maker *k, smoke_map *map)
{
    rng       r      = {1};
    size_t    curves = 0, asked = 0;
    double    square = 0;
    uint32_t *words  = map->node_count ? words_of(k, map) : NULL;
    int       done   = words || !map->node_count;
    for (size_t n = 0; n < map->texel_count && map->node_count && done; n++) {
        if (!map->counts[n]) continue;
        for (curves++; asked < PLACES_ASKED && asked * map->curve_count < curves * PLACES_ASKED && done; asked++) {
            double off;
            done = try_lookup(k, words, n, &r, &off);
            if (!done || isnan(off)) continue;
            square += off * off;
            map->lookups.largest = fmax(map->lookups.largest, off);
            map->lookups.places++;
        }
    }
    if (map->lookups.places) map->lookups.rms = sqrt(square / map->lookups.places);
    free(words);
    return done;
}

/* Make the map of a light.
 * baked  a light with its words: each curve ends where they end the light
 * map    [out]
 * Returns VXS_OK, VXS_E_MEMORY, or what context_check returns. The result does not depend on the number of threads. */
static vxs_result smoke_map_make(smoke_map *map, const smoke_source *source, const vxs_baked_light *baked,
                                 const smoke_settings *settings, bake_context *ctx)
{
    maker k = {
        .source = *source, .baked = baked, .settings = *settings, .workers = max_u32(ctx->threads, 1), .levels = VXS_LEVELS_MIN};
    uint32_t side = settings->side_px ? settings->side_px : side_of(source, &baked->light);
    while (k.levels < baked->light.levels && 1u << k.levels < side) k.levels++;
    k.tiles_across = 1u << (k.levels - 3);
    if (!find_units(&k)) return context_check(ctx);
    vxs_result r =
        memory_check(tile_count(&k) * (TILE_TEXELS + sizeof *k.tile_nodes), ctx->run,
                     "%u x %u curves of smoke a map of light '%s' need", 1u << k.levels, 1u << k.levels, baked->light.name);
    if (r != VXS_OK) return r;
    int done = take_memory(&k);
    if (done) parallel_for(ctx->threads, tile_count(&k), 4, make_tiles, &k);
    for (uint32_t n = 0; n < k.workers && done; n++) done = !k.failed[n];
    done = done && put_together(&k, map) && measure_lookups(&k, map);

    for (size_t n = 0; k.tile_nodes && n < tile_count(&k); n++) free(k.tile_nodes[n]);
    for (uint32_t n = 0; k.tools && n < k.workers; n++) {
        smoke_path_free(&k.tools[n].path);
        smoke_path_free(&k.tools[n].of_grid);
        smoke_path_free(&k.tools[n].of_capsules);
        free(k.tools[n].changes.list);
    }
    smoke_bins_free(&k.bins);
    free(k.counts);
    free(k.tile_nodes);
    free(k.tools);
    free(k.errors);
    free(k.failed);

    return done ? context_check(ctx) : fail(ctx->run, VXS_E_MEMORY, "out of memory for the smoke of light '%s'", baked->light.name);
}

/* Replace a file by one with the smoke of its lights, if any light has smoke.
 * maps  [light count of the contents] */
static vxs_result add_smoke(vxs_bytes *file, const vxs_contents *contents, const smoke_map *maps, int zstd_level, run_context *m)
{
    vxs_bytes       with  = {0};
    uint32_t        some  = 0;
    vxs_smoke_view *views = calloc(contents->light_count, sizeof *views);
    vxs_result      r     = views ? VXS_OK : VXS_E_MEMORY;
    if (!views) goto done;
    for (uint32_t n = 0; n < contents->light_count; n++) {
        views[n] = maps[n].view;
        some += maps[n].counts != NULL;
    }
    if (!some) goto done;
    if ((r = vxs_write_smoke(&with, file->data, file->size_bytes, contents, views, zstd_level)) != VXS_OK) goto done;
    free(file->data);
    *file = with;
    with  = (vxs_bytes){0};
done:
    free(views);
    free(with.data);
    if (r == VXS_OK) return r;
    return fail(m, r, "smoke cannot be encoded: %s", r == VXS_E_MEMORY ? "out of memory" : "there is too much of it");
}

vxs_result smoke_bake(vxs_bytes *file, const smoke_source *source, const smoke_settings *settings, int zstd_level,
                      smoke_counts *counts, bake_context *ctx)
{
    vxs_contents  contents = {0};
    vxs_parallel  threads  = parallel_lent(ctx->threads);
    vxs_read_desc desc     = {.parallel = &threads};
    vxs_result    r        = vxs_read(&contents, file->data, file->size_bytes, &desc);
    if (r != VXS_OK) return fail(ctx->run, r, "the encoded asset cannot be read back for its smoke: %s", vxs_result_text(r));
    smoke_map *maps = calloc(contents.light_count, sizeof *maps);
    if (!maps) r = fail(ctx->run, VXS_E_MEMORY, "out of memory for the smoke of %u lights", contents.light_count);
    for (uint32_t n = 0; n < contents.light_count && r == VXS_OK; n++) {
        watch_say(ctx->watch, "light %s: smoke", contents.lights[n].light.name);
        r = smoke_map_make(&maps[n], source, &contents.lights[n], settings, ctx);
    }
    if (r != VXS_OK || (r = add_smoke(file, &contents, maps, zstd_level, ctx->run)) != VXS_OK) goto done;
    for (uint32_t n = 0; n < contents.light_count; n++)
        counts[n] = (smoke_counts){.side_px       = maps[n].counts ? 1u << maps[n].view.levels : 0,
                                   .texels        = maps[n].texel_count,
                                   .curves        = maps[n].curve_count,
                                   .nodes         = maps[n].node_count,
                                   .largest_error = maps[n].largest_error,
                                   .lookups       = maps[n].lookups,
                                   .memory_bytes  = maps[n].word_count * 4};
done:
    for (uint32_t n = 0; maps && n < contents.light_count; n++) {
        free(maps[n].counts);
        free(maps[n].nodes);
    }
    free(maps);
    vxs_contents_free(&contents);
    return r;
}
