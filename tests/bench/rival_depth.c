/* Depth maps, looked up texel by texel; see rival.h.
 *
 * 16 bits: the enter depth, rounded down to 65536 steps. While a voxel is a whole number of steps that answers right: lit voxels
 * end at or before a depth that is a step of its own, and what comes after e is free or dark. Maps of more than 65536 voxels would
 * get wrong answers. Compression is for the file alone: a lookup needs the map as it was.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>
#include <zlib.h>
#include <zstd.h>

#include "tests/bench/rival.h"

typedef enum depth_codec { CODEC_RAW, CODEC_DEFLATE, CODEC_ZSTD } depth_codec;

typedef struct depth_options {
    depth_codec codec;
    int         level;
} depth_options;

static size_t map_bytes(const rival_maps *maps)
{
    return ((size_t)1 << 2 * maps->levels) * sizeof(uint16_t);
}

static uint16_t *sixteen_bits(const rival_maps *maps)
{
    size_t    texels = (size_t)1 << 2 * maps->levels;
    uint16_t *map    = malloc(texels * sizeof *map);
    for (size_t n = 0; n < texels && map; n++) {
        float steps = maps->maps.enter[n] * 65536;
        map[n]      = (uint16_t)(steps < 65535 ? steps : 65535);
    }
    return map;
}

/* Takes the map. */
static vxs_result pack(const depth_options *o, uint16_t *map, size_t size, vxs_bytes *file)
{
    if (o->codec == CODEC_RAW) {
        *file = (vxs_bytes){(uint8_t *)map, size, size};
        return VXS_OK;
    }
    size_t bound = o->codec == CODEC_ZSTD ? ZSTD_compressBound(size) : compressBound(size);
    *file        = (vxs_bytes){.data = malloc(bound), .capacity_bytes = bound};
    int failed   = !file->data;
    if (!failed && o->codec == CODEC_ZSTD) {
        file->size_bytes = ZSTD_compress(file->data, bound, map, size, o->level);
        failed           = ZSTD_isError(file->size_bytes) != 0;
    } else if (!failed) {
        uLongf packed    = bound;
        failed           = compress2(file->data, &packed, (const Bytef *)map, size, o->level) != Z_OK;
        file->size_bytes = packed;
    }
    free(map);
    return failed ? VXS_E_MEMORY : VXS_OK;
}

static vxs_result depth_build(rival_maps *maps, const void *options, vxs_bytes *file)
{
    uint16_t *map = sixteen_bits(maps);
    return map ? pack(options, map, map_bytes(maps), file) : VXS_E_MEMORY;
}

typedef struct depth_map {
    uint16_t    *sixteen; /* owned; or */
    const float *depth;   /* borrowed */
    uint32_t     levels;
} depth_map;

static vxs_result unpack(const depth_options *o, const vxs_bytes *file, uint16_t *map, size_t size)
{
    uLongf found = size;
    if (o->codec == CODEC_RAW)
        memcpy(map, file->data, size);
    else if (o->codec == CODEC_ZSTD)
        found = ZSTD_decompress(map, size, file->data, file->size_bytes);
    else if (uncompress((Bytef *)map, &found, file->data, file->size_bytes) != Z_OK)
        found = 0;
    return found == size ? VXS_OK : VXS_E_CORRUPT;
}

static vxs_result depth_open(const rival_maps *maps, const void *options, const vxs_bytes *file, rival_asset *asset)
{
    depth_map *d   = malloc(sizeof *d);
    uint16_t  *map = malloc(map_bytes(maps));
    vxs_result r   = d && map ? unpack(options, file, map, map_bytes(maps)) : VXS_E_MEMORY;
    if (r != VXS_OK) {
        free(d);
        free(map);
        return r;
    }
    *d     = (depth_map){.sixteen = map, .levels = maps->levels};
    *asset = (rival_asset){d, map_bytes(maps)};
    return VXS_OK;
}

static vxs_result float_open(const rival_maps *maps, const void *options, const vxs_bytes *file, rival_asset *asset)
{
    depth_map *d = malloc(sizeof *d);
    (void)options;
    (void)file;
    if (!d) return VXS_E_MEMORY;
    *d     = (depth_map){.depth = maps->maps.enter, .levels = maps->levels};
    *asset = (rival_asset){d, 2 * map_bytes(maps)};
    return VXS_OK;
}

static void depth_count_dark(const void *state, const voxel_at *at, size_t count, vxs_filter filter, uint32_t *dark)
{
    const depth_map *d = state;
    for (size_t n = 0; n < count; n++) {
        tap_box  box   = tap_box_at(at[n], filter.width_px, 1 << d->levels);
        uint32_t depth = (uint32_t)at[n].k << (16 - d->levels);
        dark[n]        = 0;
        for (int32_t y = box.y0; y < box.y1; y++) {
            const uint16_t *row = d->sixteen + ((size_t)y << d->levels);
            for (int32_t x = box.x0; x < box.x1; x++) dark[n] += row[x] <= depth;
        }
    }
}

static void float_count_dark(const void *state, const voxel_at *at, size_t count, vxs_filter filter, uint32_t *dark)
{
    const depth_map *d     = state;
    float            voxel = 1.0f / (float)(1 << d->levels); /* a power of two: nothing is rounded */
    for (size_t n = 0; n < count; n++) {
        tap_box box   = tap_box_at(at[n], filter.width_px, 1 << d->levels);
        float   depth = (float)at[n].k * voxel;
        dark[n]       = 0;
        for (int32_t y = box.y0; y < box.y1; y++) {
            const float *row = d->depth + ((size_t)y << d->levels);
            for (int32_t x = box.x0; x < box.x1; x++) dark[n] += row[x] <= depth;
        }
    }
}

static void depth_close(void *state)
{
    depth_map *d = state;
    free(d->sixteen);
    free(d);
}

#define DEPTH_RIVAL(name, what, ...)                                                                                               \
    {                                                                                                                              \
        name, what, &(const depth_options){__VA_ARGS__}, 0, depth_build, depth_open, depth_count_dark, depth_close                 \
    }

const rival depth_rivals[] = {
    DEPTH_RIVAL("16-bit depth map", "enter depths as they are", CODEC_RAW, 0),
    DEPTH_RIVAL("16-bit, deflate", "zlib level 6", CODEC_DEFLATE, 6),
    DEPTH_RIVAL("16-bit, zstd -3", "what zstd does when it is not told otherwise", CODEC_ZSTD, 3),
    DEPTH_RIVAL("16-bit, zstd -19", "as small as zstd makes it without more memory", CODEC_ZSTD, 19),
    {"float depth map", "enter depths as they were rendered, in memory", NULL, 0, NULL, float_open, float_count_dark, depth_close},
    {.name = NULL},
};
