/* Any bytes as a .vxs file: where it opens, every way to query it gives the answers that its documentation promises
 * (runtime/vxs_query.h, vxs_stream.h). What single taps say of voxels decides; held against it are lookups of points one by one and
 * many at once, where light first ends, depth maps and lit intervals: of the whole file, of a stream that holds all of it, of one
 * that holds as little as opens, and of one between, whose full answers are those of the whole file and whose coarse ones those of
 * a file without pages.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <string.h>

#include "formats/vxs_space.h"
#include "fuzz.h"
#include "fuzz_places.h"
#include "runtime/vxs_query.h"
#include "runtime/vxs_stream.h"

enum {
    MEMORY_LIMIT_BYTES = 64 << 20,
    LIGHTS             = 8,
    POINTS             = 96,
    COLUMNS            = 48,
    RAYS               = 6,
    INTERVALS_MAX      = 20000,
    MAP_PX             = 20,
    STREAM_LEVELS_MAX  = 13, /* of maps that are opened again and again */
};

static const vxs_filter filters[] = {{1, 0}, {3, 0}, {9, 0}, {17, 0}, {1, 1}, {4, 1}, {17, 1}};
enum { FILTERS = sizeof filters / sizeof *filters };

/* A light as it is queried; the whole one of the file, and the same without pages. Both NULL: it is the whole one. */
typedef struct asked {
    const vxs_baked_light *light, *full, *rough;
} asked;

static int same(float a, float b)
{
    return a == b; /* no answer is NaN */
}

/* 1: voxel (i, j, k) of a map is in shadow, by a single tap. */
static int32_t is_dark(const vxs_baked_light *l, int32_t map, int32_t i, int32_t j, int32_t k)
{
    return (int32_t)vxs_shadow_taps(l->words, &l->light, map, i, j, (uint32_t)k, 1);
}

static int32_t side_of(const vxs_baked_light *l)
{
    return 1 << l->light.levels;
}

/* points ------------------------------------------------------------------------------------------------------------------------- */

/* What a stream says of a point: the same as the whole file where it is full, else the same as a file without pages. */
static void check_stream_point(const asked *a, const double point[3], const double *normal, vxs_filter filter, float lit)
{
    if (!a->full) return;
    int is_full = vxs_lookup_is_full(a->light, point, normal, filter);
    FUZZ_CHECK(same(lit, vxs_lookup(is_full ? a->full : a->rough, point, normal, filter)));
}

/* A single tap without a normal is its voxel's. */
static void check_tap(const vxs_baked_light *l, const double point[3], float lit)
{
    int32_t voxel[3], map = vxs_voxel(&l->light, point, NULL, vxs_box(1), voxel), last = side_of(l) - 1;
    FUZZ_CHECK((map < 0) == (lit == VXS_OUTSIDE));
    if (map < 0) return;
    int32_t k = voxel[2] < last ? voxel[2] : last;
    FUZZ_CHECK(lit == (k < 0 ? 1 : (float)!is_dark(l, map, voxel[0], voxel[1], k)));
}

/* Many at once, with normals and without, of doubles and of floats. */
static void check_points(const asked *a, uint64_t *random)
{
    static double points[3 * POINTS], normals[3 * POINTS];
    static float  floats[3 * POINTS], many[POINTS], batch[POINTS], of_floats[POINTS];
    for (int n = 0; n < POINTS; n++) {
        point_ws(&a->light->light, random, points + 3 * n);
        if (n % 3 == 1) /* near the one before it, as pixels are */
            for (int k = 0; k < 3; k++) {
                double aside      = ((double)random_below_of(random, 2001) - 1000) * 0.005 * a->light->light.texel_metres;
                points[3 * n + k] = points[3 * n - 3 + k] + (isfinite(aside) ? aside : 0);
            }
        for (int k = 0; k < 3; k++) normals[3 * n + k] = n % 4 ? (double)random_below_of(random, 201) / 100 - 1 : k == n % 3;
        for (int k = 0; k < 3; k++)
            floats[3 * n + k] = fabs(points[3 * n + k]) < (double)FLT_MAX ? (float)points[3 * n + k] : 1e30F;
    }
    for (int f = 0; f < FILTERS; f++) {
        vxs_filter filter = filters[f];
        vxs_batch  b      = {.struct_size = sizeof b,
                             .points_ws   = {points, 0, VXS_F64},
                             .normals_ws  = {normals, 0, VXS_F64},
                             .count       = POINTS,
                             .filter      = filter,
                             .lit         = batch};
        vxs_lookup_many(a->light, points, NULL, POINTS, filter, many);
        FUZZ_CHECK(vxs_lookup_batch(a->light, 1, &b) == VXS_OK);
        b.points_ws  = (vxs_vectors){floats, 0, VXS_F32};
        b.normals_ws = (vxs_vectors){0};
        b.lit        = of_floats;
        FUZZ_CHECK(vxs_lookup_batch(a->light, 1, &b) == VXS_OK);
        for (int n = 0; n < POINTS; n++) {
            const double *p = points + 3 * n, *normal = normals + 3 * n;
            const double  exact[3] = {(double)floats[3 * n], (double)floats[3 * n + 1], (double)floats[3 * n + 2]};
            float         single = vxs_lookup(a->light, p, NULL, filter), moved = vxs_lookup(a->light, p, normal, filter);
            FUZZ_CHECK(single == VXS_OUTSIDE || (single >= 0 && single <= 1));
            FUZZ_CHECK(same(many[n], single) && same(batch[n], moved));
            FUZZ_CHECK(same(of_floats[n], vxs_lookup(a->light, exact, NULL, filter)));
            check_stream_point(a, p, NULL, filter, single);
            check_stream_point(a, p, normal, filter, moved);
            if (!filter.is_smooth && filter.width_px == 1) check_tap(a->light, p, single);
        }
    }
}

/* depths ------------------------------------------------------------------------------------------------------------------------- */

/* A texel of a map: near the one before, or anywhere. */
static void next_texel(const vxs_baked_light *l, uint64_t *random, int32_t texel[3])
{
    uint32_t side = (uint32_t)side_of(l), near = random_below_of(random, 3);
    for (int k = 0; k < 2; k++) {
        int32_t moved = texel[k] + (int32_t)random_below_of(random, 17) - 8;
        texel[k]      = near && moved >= 0 && moved < (int32_t)side ? moved : (int32_t)random_below_of(random, side);
    }
    if (!near) texel[2] = (int32_t)random_below_of(random, vxs_map_count(&l->light));
}

/* Where light first ends: all before is lit, that voxel is dark, and of palette blocks all behind it. */
static void check_column(const asked *a, uint64_t *random, const int32_t t[3])
{
    const vxs_baked_light *l      = a->light;
    int                    coarse = 2;
    int32_t                side = side_of(l), depth = vxs_first_shadow(l, t[2], t[0], t[1], &coarse);
    FUZZ_CHECK(depth >= 0 && depth <= side && (coarse == 0 || coarse == 1));
    for (int n = 0; n < 8; n++) {
        int32_t k = n == 0   ? 0
                    : n == 1 ? depth - 1
                    : n == 2 ? depth
                    : n == 3 ? side - 1
                             : (int32_t)random_below_of(random, (uint32_t)side);
        if (k < 0 || k >= side) continue;
        if (k <= depth || l->light.coding == VXS_CODING_BLOCKS) FUZZ_CHECK(is_dark(l, t[2], t[0], t[1], k) == (k >= depth));
    }
    if (a->full) FUZZ_CHECK(depth == vxs_first_shadow(coarse ? a->rough : a->full, t[2], t[0], t[1], NULL));
}

static void check_columns(const asked *a, uint64_t *random)
{
    int32_t texel[3] = {0};
    for (int n = 0; n < COLUMNS; n++) {
        check_column(a, random, texel);
        next_texel(a->light, random, texel);
    }
}

/* The pixel of a depth map, of 2^shift texels a side from (i, j) on. */
static uint32_t pixel_of(const vxs_baked_light *l, const vxs_depth_map_desc *d, int32_t x, int32_t y)
{
    int32_t  side = side_of(l), size = 1 << d->shift, begin = d->which == VXS_DEPTH_CENTRE ? size / 2 : 0;
    int32_t  end   = d->which == VXS_DEPTH_CENTRE ? begin + 1 : size;
    uint32_t found = d->which == VXS_DEPTH_GREATEST ? 0 : UINT32_MAX;
    for (int32_t v = begin; v < end; v++)
        for (int32_t u = begin; u < end; u++) {
            int32_t  i = d->i + x * size + u, j = d->j + y * size + v;
            int      outside = i < 0 || j < 0 || i >= side || j >= side;
            uint32_t depth   = (uint32_t)(outside ? side : vxs_first_shadow(l, d->map, i, j, NULL));
            if (d->which == VXS_DEPTH_GREATEST ? depth > found : depth < found) found = depth;
        }
    return found;
}

static void check_depth_map(const asked *a, uint64_t *random)
{
    static uint32_t        voxels[MAP_PX * MAP_PX];
    const vxs_baked_light *l    = a->light;
    uint32_t               side = (uint32_t)side_of(l), shift = random_below_of(random, 3);
    vxs_depth_map_desc     d = {.struct_size = sizeof d,
                                .map         = (int32_t)random_below_of(random, vxs_map_count(&l->light)),
                                .i           = (int32_t)random_below_of(random, side + 16) - 12,
                                .j           = (int32_t)random_below_of(random, side + 16) - 12,
                                .wide_px     = 1 + random_below_of(random, MAP_PX),
                                .high_px     = 1 + random_below_of(random, MAP_PX),
                                .shift       = shift < l->light.levels ? shift : 0,
                                .which       = random_below_of(random, 3),
                                .voxels      = voxels};
    FUZZ_CHECK(vxs_depth_map(l, &d, NULL) == VXS_OK);
    for (uint32_t y = 0; y < d.high_px; y++)
        for (uint32_t x = 0; x < d.wide_px; x += 1 + shift)
            FUZZ_CHECK(voxels[y * d.wide_px + x] == pixel_of(l, &d, (int32_t)x, (int32_t)y));
}

/* intervals ------------------------------------------------------------------------------------------------------------------------ */

static void check_interval(const asked *a, const vxs_ray *ray, const vxs_interval *i)
{
    int32_t state = clear_state(a->light, ray, i->t_begin, i->t_end, in_doubles);
    FUZZ_CHECK(state < 0 || state == i->state);
    if (!a->full || i->coarse || i->state == VXS_INTERVAL_OUTSIDE) return;
    state = clear_state(a->full, ray, i->t_begin, i->t_end, in_doubles);
    FUZZ_CHECK(state < 0 || state == i->state);
}

static void check_ray(const asked *a, const vxs_ray *ray)
{
    vxs_interval list[32], last = {.t_end = ray->t_begin, .state = -1};
    vxs_lit_walk walk;
    size_t       count = 0, found;
    if (vxs_lit_begin(&walk, a->light, ray) != VXS_OK) return;
    do {
        found = vxs_lit_next(&walk, list, sizeof list / sizeof *list);
        for (size_t n = 0; n < found; last = list[n++], count++) {
            FUZZ_CHECK(list[n].t_begin == last.t_end && list[n].t_end > list[n].t_begin);
            FUZZ_CHECK(list[n].state != last.state || list[n].coarse != last.coarse);
            FUZZ_CHECK((uint32_t)list[n].state <= VXS_INTERVAL_OUTSIDE);
            if (count < 12) check_interval(a, ray, &list[n]);
        }
    } while (found == sizeof list / sizeof *list && count < INTERVALS_MAX);
    if (count < INTERVALS_MAX && ray->t_end > ray->t_begin) FUZZ_CHECK(count && last.t_end == ray->t_end);
}

static void check_rays(const asked *a, uint64_t *random)
{
    for (int n = 0; n < RAYS; n++) {
        static const double ends[] = {1, 1, 0.5, 10, 1e5, INFINITY};
        vxs_ray             ray    = {.t_end = ends[n]};
        double              to[3];
        point_ws(&a->light->light, random, ray.origin_ws);
        point_ws(&a->light->light, random, to);
        for (int k = 0; k < 3; k++) ray.direction_ws[k] = to[k] - ray.origin_ws[k];
        check_ray(a, &ray);
    }
}

/* all of a light ------------------------------------------------------------------------------------------------------------------ */

static void check_light(const asked *a, uint64_t random)
{
    check_points(a, &random);
    check_columns(a, &random);
    for (int n = 0; n < 4; n++) check_depth_map(a, &random);
    check_rays(a, &random);
}

static void check_smoke(const vxs_light *l, const vxs_baked_smoke *smoke, const vxs_baked_smoke *full, uint64_t random)
{
    for (int n = 0; n < POINTS; n++) {
        double point[3];
        point_ws(l, &random, point);
        float left = vxs_smoke_lookup(l, smoke, point);
        FUZZ_CHECK(left >= 0 && left <= 1 && same(left, vxs_smoke_lookup(l, full, point)));
    }
}

/* streams ------------------------------------------------------------------------------------------------------------------------- */

/* A light without pages. */
static vxs_baked_light without_pages(const vxs_baked_light *l)
{
    vxs_baked_light rough = *l;
    uint32_t        count = l->word_count + VXS_BLOCKS_SPARE_WORDS;
    if (l->light.coding != VXS_CODING_BLOCKS) return rough;
    uint32_t *words = malloc(count * sizeof *words);
    FUZZ_CHECK(words);
    memcpy(words, l->words, count * sizeof *words);
    memset(words + 8, 0, words[0] * sizeof *words);
    rough.words = words;
    return rough;
}

static void check_stream(vxs_stream *s, const vxs_asset *whole, int is_ample, uint64_t random)
{
    vxs_stream_focus  all    = {{-1, -1, -1}, {1, 1, 1}, 0, 0};
    vxs_stream_status status = {.struct_size = sizeof status};
    for (int frame = 0; frame < 400; frame++) {
        FUZZ_CHECK(vxs_stream_frame(s, &all, 1, &status) == VXS_OK && !status.pages_failed);
        if (!status.pages_coming && (!status.pages_missing || frame > 4)) break;
    }
    FUZZ_CHECK(!is_ample || !status.pages_missing);
    for (uint32_t n = 0; n < vxs_stream_light_count(s) && n < LIGHTS; n++) {
        const vxs_baked_light *light = vxs_stream_light(s, n);
        vxs_baked_light        rough = without_pages(vxs_asset_light(whole, n));
        check_light(&(asked){light, vxs_asset_light(whole, n), &rough}, random + n);
        check_smoke(&light->light, vxs_stream_smoke(s, n), vxs_asset_smoke(whole, n), random);
        if (rough.words != vxs_asset_light(whole, n)->words) free((uint32_t *)rough.words);
    }
}

static vxs_stream *open_stream(const uint8_t *data, size_t size, uint64_t budget_bytes)
{
    vxs_stream     *stream;
    vxs_stream_desc desc = {.struct_size       = sizeof desc,
                            .bytes             = data,
                            .size_bytes        = size,
                            .budget_bytes      = budget_bytes,
                            .decodes_per_frame = 64,
                            .requests          = 16};
    vxs_result      r    = vxs_stream_open(&stream, &desc);
    FUZZ_CHECK(r == VXS_OK || r == VXS_E_MEMORY);
    return stream;
}

/* The least budget that opens, nearly. */
static uint64_t least_budget(const uint8_t *data, size_t size, uint64_t ample)
{
    uint64_t low = 0, high = ample;
    while (high - low > 256) {
        uint64_t    middle       = low + (high - low) / 2;
        vxs_stream *stream       = open_stream(data, size, middle);
        *(stream ? &high : &low) = middle;
        vxs_stream_close(stream);
    }
    return high;
}

static void check_streams(const uint8_t *data, size_t size, const vxs_asset *whole, uint64_t random)
{
    const uint64_t ample  = 4 * (uint64_t)MEMORY_LIMIT_BYTES;
    uint32_t       levels = 0;
    for (uint32_t n = 0; n < vxs_asset_light_count(whole); n++) {
        uint32_t l = vxs_asset_light(whole, n)->light.levels;
        levels     = l > levels ? l : levels;
    }
    vxs_stream *stream = open_stream(data, size, ample);
    FUZZ_CHECK(stream);
    check_stream(stream, whole, 1, random);
    vxs_stream_close(stream);
    if (levels > STREAM_LEVELS_MAX) return;
    uint64_t       least     = least_budget(data, size, ample);
    const uint64_t budgets[] = {least, least + least / 3};
    for (int n = 0; n < 2; n++) {
        stream = open_stream(data, size, budgets[n]);
        FUZZ_CHECK(stream);
        check_stream(stream, whole, 0, random);
        vxs_stream_close(stream);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    vxs_read_desc desc  = {.memory_limit_bytes = MEMORY_LIMIT_BYTES};
    vxs_asset    *asset = NULL;
    if (vxs_asset_open(&asset, data, size, &desc) != VXS_OK) return 0;
    for (uint32_t n = 0; n < vxs_asset_light_count(asset) && n < LIGHTS; n++)
        check_light(&(asked){.light = vxs_asset_light(asset, n)}, size + n);
    check_streams(data, size, asset, size);
    vxs_asset_close(asset);
    return 0;
}
