/* The runtime for JavaScript: functions of vxs.h, vxs_query.h and vxs_stream.h with arguments that WebAssembly can pass. vxs.mjs
 * calls them. There is no global state: JavaScript owns all memory, through malloc and free.
 *
 * A light is a const vxs_baked_light *, of an asset or of a stream. Vectors are passed as three doubles. Arguments have been
 * checked by the caller, except where a function returns a result.
 * SPDX-License-Identifier: MIT */
#include <emscripten.h>
#include <stdlib.h>
#include <string.h>

#include "vxs_query.h"
#include "vxs_stream.h"

#define EXPORT EMSCRIPTEN_KEEPALIVE

/* errors ------------------------------------------------------------------------------------------------------------------------- */

/* Why a file could not be opened: the first finding. */
typedef struct web_error {
    uint32_t    result, finding; /* finding: 0: none */
    int32_t     section;         /* -1: header and directory */
    const char *text;
    double      offset_bytes;
} web_error;

static void found(void *user, int number, const char *text, int section, uint64_t offset)
{
    web_error *e = user;
    if (e->finding) return;
    e->finding      = (uint32_t)number;
    e->text         = text;
    e->section      = section;
    e->offset_bytes = (double)offset;
}

/* The results that come without a finding have texts of their own: vxs_result_text() also has those of bakes. */
static void *keep_error(web_error *error, vxs_result result, void *object)
{
    error->result = result;
    if (!error->text)
        error->text = result == VXS_E_MEMORY     ? "out of memory"
                      : result == VXS_E_ARGUMENT ? "an argument is outside its range"
                                                 : "a file cannot be read";
    return object;
}

/* assets ------------------------------------------------------------------------------------------------------------------------- */

/* memory_limit  bytes; 0: the default of vxs_read_desc
 * error         [out]
 * Returns an asset; NULL: see `error` */
EXPORT vxs_asset *web_open(const uint8_t *bytes, size_t size_bytes, double memory_limit, web_error *error)
{
    vxs_asset          *asset;
    const vxs_read_desc desc = {.struct_size        = sizeof desc,
                                .memory_limit_bytes = (uint64_t)memory_limit,
                                .finding            = found,
                                .finding_user       = error,
                                .metadata           = 1};
    memset(error, 0, sizeof *error);
    vxs_result r = vxs_asset_open(&asset, bytes, size_bytes, &desc);
    return keep_error(error, r, asset);
}

EXPORT void web_close(vxs_asset *asset)
{
    vxs_asset_close(asset);
}

EXPORT uint32_t web_light_count(const vxs_asset *asset)
{
    return vxs_asset_light_count(asset);
}

EXPORT const vxs_baked_light *web_light(const vxs_asset *asset, uint32_t index)
{
    return vxs_asset_light(asset, index);
}

/* Returns NUL-terminated JSON text; NULL: none */
EXPORT const char *web_metadata(const vxs_asset *asset)
{
    return vxs_asset_contents(asset)->metadata;
}

EXPORT const vxs_baked_points *web_points(const vxs_asset *asset)
{
    return vxs_asset_points(asset);
}

EXPORT uint32_t web_point_count(const vxs_baked_points *points)
{
    return points->count;
}

/* out  [4 * count] */
EXPORT void web_unpack_points(const vxs_baked_points *points, double x, double y, double z, float *out)
{
    vxs_points_unpack(points, (const double[3]){x, y, z}, out);
}

/* lights ------------------------------------------------------------------------------------------------------------------------- */

/* out  [28] in the order below. Returns the name */
EXPORT const char *web_describe(const vxs_baked_light *baked, double *out)
{
    const vxs_light *l = &baked->light;
    *out++             = l->kind;
    *out++             = l->coding;
    *out++             = l->levels;
    *out++             = vxs_map_count(l);
    *out++             = l->flags & VXS_LIGHT_BOUNDED;
    *out++             = baked->packing;
    *out++             = baked->word_count;
    *out++             = l->texel_metres;
    *out++             = l->voxel_metres;
    *out++             = l->near_metres;
    *out++             = l->range_metres;
    *out++             = l->cos_outer;
    *out++             = l->direction_ws[0];
    *out++             = l->direction_ws[1];
    *out++             = l->direction_ws[2];
    memcpy(out, l->ls_from_ws, sizeof l->ls_from_ws);
    return l->name;
}

EXPORT const uint32_t *web_words(const vxs_baked_light *baked)
{
    return baked->words;
}

/* out  [96] bytes */
EXPORT void web_constants(const vxs_baked_light *baked, double x, double y, double z, uint32_t first_word, vxs_light_constants *out)
{
    *out = vxs_light_constants_of(&baked->light, (const double[3]){x, y, z}, first_word);
}

/* to  [high_px][wide_px] uint32_t if voxels is not 0, else float
 * Returns a vxs_result; all arguments are checked */
EXPORT uint32_t web_depth_map(const vxs_baked_light *baked, int32_t map, int32_t i, int32_t j, uint32_t wide_px, uint32_t high_px,
                              uint32_t shift, uint32_t which, uint32_t voxels, void *to)
{
    const vxs_depth_map_desc desc = {.struct_size = sizeof desc,
                                     .map         = map,
                                     .i           = i,
                                     .j           = j,
                                     .wide_px     = wide_px,
                                     .high_px     = high_px,
                                     .shift       = shift,
                                     .which       = which,
                                     .voxels      = voxels ? to : NULL,
                                     .depths      = voxels ? NULL : to};
    return vxs_depth_map(baked, &desc, NULL);
}

#ifndef VXS_WEB_CORE

/* lookups: a normal of (0, 0, 0) is none ------------------------------------------------------------------------------------------ */

EXPORT float web_lookup(const vxs_baked_light *baked, double x, double y, double z, double nx, double ny, double nz,
                        int32_t width_px, int32_t is_smooth)
{
    const vxs_filter filter = {width_px, is_smooth};
    return vxs_lookup(baked, (const double[3]){x, y, z}, (const double[3]){nx, ny, nz}, filter);
}

EXPORT int web_is_full(const vxs_baked_light *baked, double x, double y, double z, double nx, double ny, double nz,
                       int32_t width_px, int32_t is_smooth)
{
    const vxs_filter filter = {width_px, is_smooth};
    return vxs_lookup_is_full(baked, (const double[3]){x, y, z}, (const double[3]){nx, ny, nz}, filter);
}

/* points, normals  [3 * count]; normals NULL: none;   type  VXS_F32, VXS_F64 of points, and of normals */
EXPORT void web_lookup_many(const vxs_baked_light *baked, const void *points, uint32_t point_type, const void *normals,
                            uint32_t normal_type, uint32_t count, int32_t width_px, int32_t is_smooth, float *lit)
{
    const vxs_batch batch = {.struct_size = sizeof batch,
                             .points_ws   = {.data = points, .type = point_type},
                             .normals_ws  = {.data = normals, .type = normal_type},
                             .count       = count,
                             .filter      = {width_px, is_smooth},
                             .lit         = lit};
    vxs_lookup_batch(baked, 1, &batch);
}

/* voxel  [out] [3] */
EXPORT int web_voxel(const vxs_baked_light *baked, double x, double y, double z, double nx, double ny, double nz, int32_t width_px,
                     int32_t is_smooth, int32_t *voxel)
{
    const vxs_filter filter = {width_px, is_smooth};
    return vxs_voxel(&baked->light, (const double[3]){x, y, z}, (const double[3]){nx, ny, nz}, filter, voxel);
}

/* point  [out] [3] */
EXPORT void web_point(const vxs_baked_light *baked, int32_t map, double u, double v, double k, double *point)
{
    vxs_point(&baked->light, map, (const double[3]){u, v, k}, point);
}

EXPORT int32_t web_first_shadow(const vxs_baked_light *baked, int32_t map, int32_t i, int32_t j)
{
    return vxs_first_shadow(baked, map, i, j, NULL);
}

/* rays --------------------------------------------------------------------------------------------------------------------------- */

EXPORT uint32_t web_walk_bytes(void)
{
    return sizeof(vxs_lit_walk);
}

/* ray  [8] origin, direction, t_begin, t_end.   Returns a vxs_result */
EXPORT uint32_t web_lit_begin(vxs_lit_walk *walk, const vxs_baked_light *baked, const vxs_ray *ray)
{
    return vxs_lit_begin(walk, baked, ray);
}

/* intervals  [capacity] of 24 bytes: t_begin, t_end as doubles, state and coarse as int32.   Returns how many were written */
EXPORT uint32_t web_lit_next(vxs_lit_walk *walk, vxs_interval *intervals, uint32_t capacity)
{
    return vxs_lit_next(walk, intervals, capacity);
}

/* smoke -------------------------------------------------------------------------------------------------------------------------- */

EXPORT const vxs_baked_smoke *web_smoke(const vxs_asset *asset, uint32_t index)
{
    return vxs_asset_smoke(asset, index);
}

/* count  [out] */
EXPORT const uint32_t *web_smoke_words(const vxs_baked_smoke *smoke, uint32_t *count)
{
    *count = smoke->word_count;
    return smoke->words;
}

EXPORT float web_smoke_lookup(const vxs_baked_light *baked, const vxs_baked_smoke *smoke, double x, double y, double z)
{
    return vxs_smoke_lookup(&baked->light, smoke, (const double[3]){x, y, z});
}

/* streams ------------------------------------------------------------------------------------------------------------------------ */

/* JavaScript's side of a stream, which it finds by `id`. web_read: a vxs_stream_answer; it calls web_stream_done later if that is
 * VXS_STREAM_PENDING. */
#define IMPORT(name) __attribute__((import_module("env"), import_name(#name))) name
extern uint32_t IMPORT(web_read)(uint32_t id, double offset, uint32_t size_bytes, void *buffer, vxs_stream_request *request);
extern void     IMPORT(web_failed)(uint32_t id, uint32_t light, uint32_t page, uint32_t result, int32_t finding);

typedef struct web_stream {
    vxs_stream *stream;
    uint32_t    id;
    char       *metadata; /* NUL-terminated; NULL: none */
} web_stream;

static vxs_stream_answer read_bytes(void *user, uint64_t offset, uint32_t size_bytes, void *buffer, vxs_stream_request *request)
{
    return (vxs_stream_answer)web_read(((web_stream *)user)->id, (double)offset, size_bytes, buffer, request);
}

static void page_failed(void *user, uint32_t light, uint32_t page, vxs_result result, int finding)
{
    web_failed(((web_stream *)user)->id, light, page, result, finding);
}

static void keep_metadata(void *user, const char *text, size_t size_bytes)
{
    web_stream *s = user;
    s->metadata   = malloc(size_bytes + 1);
    if (s->metadata) memcpy(s->metadata, text, size_bytes);
    if (s->metadata) s->metadata[size_bytes] = 0;
}

EXPORT void web_stream_close(web_stream *s)
{
    vxs_stream_close(s->stream);
    free(s->metadata);
    free(s);
}

/* names  [name_count] lights to open; name_count 0: all
 * Returns NULL on failure. After VXS_E_READ JavaScript gets the bytes that were missing, and tries again */
EXPORT web_stream *web_stream_open(uint32_t id, double size_bytes, double budget_bytes, uint32_t requests,
                                   uint32_t decodes_per_frame, const char *const *names, uint32_t name_count, web_error *error)
{
    memset(error, 0, sizeof *error);
    web_stream *s = calloc(1, sizeof *s);
    if (!s) return keep_error(error, VXS_E_MEMORY, NULL);
    s->id                      = id;
    const vxs_stream_desc desc = {.struct_size       = sizeof desc,
                                  .size_bytes        = (uint64_t)size_bytes,
                                  .read              = read_bytes,
                                  .read_user         = s,
                                  .budget_bytes      = (uint64_t)budget_bytes,
                                  .requests          = requests,
                                  .decodes_per_frame = decodes_per_frame,
                                  .light_names       = name_count ? names : NULL,
                                  .light_name_count  = name_count,
                                  .finding           = found,
                                  .finding_user      = error,
                                  .failed            = page_failed,
                                  .failed_user       = s,
                                  .metadata          = keep_metadata,
                                  .metadata_user     = s};
    vxs_result            r    = vxs_stream_open(&s->stream, &desc);
    if (r == VXS_OK) return keep_error(error, r, s);
    web_stream_close(s);
    return keep_error(error, r, NULL);
}

EXPORT const char *web_stream_metadata(const web_stream *s)
{
    return s->metadata;
}

EXPORT uint32_t web_stream_light_count(const web_stream *s)
{
    return vxs_stream_light_count(s->stream);
}

EXPORT const vxs_baked_light *web_stream_light(const web_stream *s, uint32_t index)
{
    return vxs_stream_light(s->stream, index);
}

EXPORT const vxs_baked_smoke *web_stream_smoke(const web_stream *s, uint32_t index)
{
    return vxs_stream_smoke(s->stream, index);
}

EXPORT uint32_t web_stream_first_word(const web_stream *s, uint32_t light)
{
    return vxs_stream_first_word(s->stream, light);
}

/* count  [out] */
EXPORT const uint32_t *web_stream_words(const web_stream *s, uint32_t *count)
{
    return vxs_stream_words(s->stream, count);
}

/* foci  [count]
 * out   [14] the fields of vxs_stream_status in their order */
EXPORT void web_stream_frame(web_stream *s, const vxs_stream_focus *foci, uint32_t count, double *out)
{
    vxs_stream_status t = {.struct_size = sizeof t};
    vxs_stream_frame(s->stream, foci, count, &t);
    const uint64_t bytes[] = {t.bytes_held, t.bytes_resident, t.bytes_room, t.bytes_read};
    const uint32_t pages[] = {t.pages,        t.pages_resident, t.pages_wanted, t.pages_missing, t.pages_coming,
                              t.pages_failed, t.reads,          t.decodes,      t.appeared,      t.left};
    for (size_t n = 0; n < sizeof bytes / sizeof *bytes; n++) *out++ = (double)bytes[n];
    for (size_t n = 0; n < sizeof pages / sizeof *pages; n++) *out++ = pages[n];
}

EXPORT void web_stream_done(vxs_stream_request *request, int ok)
{
    vxs_stream_read_done(request, ok);
}

EXPORT void web_stream_retry(web_stream *s)
{
    vxs_stream_retry(s->stream);
}

/* Pairs of first word and word count.   count  [out] of pairs */
EXPORT const vxs_stream_range *web_stream_changes(const web_stream *s, uint32_t *count)
{
    return vxs_stream_changes(s->stream, count);
}

#endif
