/* A file to stream, and what its lookups have to say: the same file opened whole, and a copy of it in which no page is there.
 * Include after <cmocka.h>.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef STREAM_SAMPLE_H
#define STREAM_SAMPLE_H

#include "runtime/vxs_stream.h"
#include "tests/unit/blocks_built.h"
#include "tests/unit/dag_sample.h"

enum { STREAM_LIGHTS = 4 };

typedef struct stream_sample {
    vxs_bytes        file;
    vxs_asset       *full;
    vxs_baked_light *coarse; /* as the full ones, without pages */
    uint32_t         light_count, page_count;
    uint32_t         dag; /* the light that is none of palette blocks, or light_count */
} stream_sample;

static inline vxs_write_light stream_light_of(const block_words *w, uint32_t levels, uint32_t kind, uint32_t flags,
                                              uint32_t packing, const char *name)
{
    dag_sample      of = {.levels = levels};
    vxs_write_light l =
        kind == VXS_LIGHT_KIND_DIRECTIONAL ? dag_sample_light(&of, name) : dag_sample_punctual(&of, name, kind, flags);
    l.light.coding = VXS_CODING_BLOCKS;
    l.blocks       = (vxs_blocks_view){w->words, w->count, w->common_kinds, w->common_count, packing};
    return l;
}

/* Lights without pages. */
static inline vxs_baked_light *stream_coarse_lights(const vxs_asset *asset)
{
    uint32_t         count  = vxs_asset_light_count(asset);
    vxs_baked_light *coarse = calloc(count, sizeof *coarse);
    for (uint32_t n = 0; n < count; n++) {
        const vxs_baked_light *full  = vxs_asset_light(asset, n);
        uint32_t              *words = malloc((full->word_count + 4) * sizeof *words);
        memcpy(words, full->words, full->word_count * sizeof *words);
        memset(words + full->word_count, 0, 4 * sizeof *words);
        if (full->light.coding == VXS_CODING_BLOCKS) memset(words + 8, 0, words[0] * sizeof *words);
        coarse[n]       = *full;
        coarse[n].words = words;
    }
    return coarse;
}

static inline void stream_sample_open(stream_sample *s)
{
    s->coarse     = NULL;
    s->page_count = 0;
    assert_int_equal(vxs_asset_open(&s->full, s->file.data, s->file.size_bytes, NULL), VXS_OK);
    s->light_count = s->dag = vxs_asset_light_count(s->full);
    s->coarse               = stream_coarse_lights(s->full);
    for (uint32_t n = 0; n < s->light_count; n++) {
        const vxs_baked_light *l = vxs_asset_light(s->full, n);
        if (l->light.coding == VXS_CODING_BLOCKS)
            s->page_count += l->words[0];
        else
            s->dag = n;
    }
}

/* A sun, a point light and a spot light of palette blocks, packed both ways, and a sun that is a DAG. */
static inline void stream_file_build(vxs_bytes *out, uint64_t seed)
{
    block_words w[3] = {words_of_maps(10, 1, MAPS_NOISE, seed), words_of_maps(9, 6, MAPS_NOISE, seed + 1),
                        words_of_maps(9, 1, MAPS_BOXES, seed + 7)};
    dag_sample  dag;
    rng         r = {seed};
    dag_sample_init(&dag, &r, 6, 100);
    vxs_write_light lights[STREAM_LIGHTS] = {
        stream_light_of(&w[0], 10, VXS_LIGHT_KIND_DIRECTIONAL, 0, seed & 1 ? VXS_PACKING_FAST : VXS_PACKING_SMALL, "sun"),
        stream_light_of(&w[1], 9, VXS_LIGHT_KIND_POINT, VXS_LIGHT_CUBE, seed & 2 ? VXS_PACKING_FAST : VXS_PACKING_SMALL, "lamp"),
        stream_light_of(&w[2], 9, VXS_LIGHT_KIND_SPOT, 0, VXS_PACKING_SMALL, "spot"),
        dag_sample_light(&dag, "moon"),
    };
    vxs_write_desc desc = {.lights = lights, .light_count = STREAM_LIGHTS, .zstd_level = 1, .metadata = "{}"};
    assert_int_equal(vxs_write(out, &desc), VXS_OK);
    for (int n = 0; n < 3; n++) block_words_free(&w[n]);
    dag_sample_free(&dag);
}

/* Of a few seeds, whose files are built once in a program: they are most of what a test takes. */
static inline void stream_sample_init(stream_sample *s, uint64_t seed)
{
    static vxs_bytes built[6];
    vxs_bytes       *file = &built[seed];
    assert_in_range(seed, 0, 5);
    if (!file->data) stream_file_build(file, seed);
    *s           = (stream_sample){.file = *file};
    s->file.data = memcpy(malloc(file->size_bytes), file->data, file->size_bytes);
    stream_sample_open(s);
}

static inline void stream_sample_free(stream_sample *s)
{
    for (uint32_t n = 0; n < s->light_count; n++) free((uint32_t *)s->coarse[n].words);
    free(s->coarse);
    vxs_asset_close(s->full);
    free(s->file.data);
}

/* A point in the volume of a light, or near it. */
static inline void stream_random_point(const vxs_light *light, rng *r, double point_ws[3])
{
    double side  = (double)(1u << light->levels), at[3];
    int    faces = (int)vxs_map_count(light);
    for (int k = 0; k < 3; k++) at[k] = side * rng_between(r, -200, 4296) / 4096.0;
    if (!rng_below(r, 3)) at[rng_below(r, 2)] = 256 * rng_between(r, 0, (int32_t)(side / 256)) + rng_between(r, -900, 900) / 100.0;
    vxs_point(light, rng_between(r, 0, faces - 1), at, point_ws);
}

/* How many lookups were full, coarse, and coarse with another answer than the full one. */
typedef struct stream_tally {
    uint32_t full, coarse, other;
} stream_tally;

/* Lookups in a stream's light: each gives the answer of the file, or what a file without pages says. */
static inline void stream_check_light(const stream_sample *s, const vxs_baked_light *light, uint32_t number, rng *r, int count,
                                      stream_tally *tally)
{
    const vxs_baked_light *full = vxs_asset_light(s->full, number);
    for (int n = 0; n < count; n++) {
        double     point[3], normal[3] = {0, 1, 0};
        vxs_filter filter = vxs_box(1 + 2 * rng_between(r, 0, VXS_FILTER_MAX / 2));
        if (!rng_below(r, 3)) filter = vxs_smooth(rng_between(r, 1, VXS_FILTER_MAX));
        stream_random_point(&full->light, r, point);
        float  found = vxs_lookup(light, point, n & 1 ? normal : NULL, filter);
        float  several[40];
        double points[120];
        for (int k = 0; k < 120; k++) points[k] = point[k % 3];
        vxs_lookup_many(light, points, NULL, 40, filter, several);
        if (several[39] != vxs_lookup(light, point, NULL, filter))
            fail_msg("light %u, filter %d, smooth %d: %g of many", number, filter.width_px, filter.is_smooth, (double)several[39]);
        float exact   = vxs_lookup(full, point, n & 1 ? normal : NULL, filter);
        float rough   = vxs_lookup(&s->coarse[number], point, n & 1 ? normal : NULL, filter);
        int   is_full = vxs_lookup_is_full(light, point, n & 1 ? normal : NULL, filter);
        if (found != (is_full ? exact : rough))
            fail_msg("light %u, filter %d, smooth %d: %g, %s, expected %g or %g", number, filter.width_px, filter.is_smooth,
                     (double)found, is_full ? "full" : "coarse", (double)exact, (double)rough);
        tally->full += is_full != 0;
        tally->coarse += !is_full;
        tally->other += !is_full && exact != rough;
    }
}

static inline void stream_check(const stream_sample *s, const vxs_stream *stream, rng *r, int count, stream_tally *tally)
{
    for (uint32_t n = 0; n < vxs_stream_light_count(stream); n++)
        stream_check_light(s, vxs_stream_light(stream, n), n, r, count, tally);
}

static inline vxs_stream_desc stream_desc_of(const stream_sample *s, uint64_t budget_bytes)
{
    return (vxs_stream_desc){.struct_size  = sizeof(vxs_stream_desc),
                             .bytes        = s->file.data,
                             .size_bytes   = s->file.size_bytes,
                             .budget_bytes = budget_bytes};
}

/* The least budget that opens. */
static inline uint64_t stream_least_budget(vxs_stream_desc desc)
{
    uint64_t low = 0, high = 64 << 20;
    while (high - low > 1) {
        vxs_stream *stream;
        desc.budget_bytes = low + (high - low) / 2;
        vxs_result r      = vxs_stream_open(&stream, &desc);
        assert_true(r == VXS_OK || r == VXS_E_MEMORY);
        *(r == VXS_OK ? &high : &low) = desc.budget_bytes;
        vxs_stream_close(stream);
    }
    return high;
}

/* Frames until nothing is missing. */
static inline vxs_stream_status stream_fill(vxs_stream *stream, const vxs_stream_focus *focus)
{
    vxs_stream_status status = {.struct_size = sizeof status};
    for (int frame = 0; frame < 10000; frame++) {
        assert_int_equal(vxs_stream_frame(stream, focus, 1, &status), VXS_OK);
        if (!status.pages_missing) break;
        vxs_stream_wait(stream);
    }
    return status;
}

static const double           stream_middle[3] = {0, 0, 0};
static const vxs_stream_focus stream_all       = {{-1, -1, -1}, {1, 1, 1}, 0, 0}; /* no radius: every page is wanted */

#endif
