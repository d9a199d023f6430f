/* Serialization of square records; see square_record.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/square_record.h"

#include "baker/base/byte_stream.h"
#include "formats/vxs_frame.h"

enum {
    HEAD_BYTES  = 16, /* of a step */
    STEP_BYTES  = 16, /* rest of a step of either kind */
    PACK_LEVEL  = 1,  /* of zstd: fast against the build */
    BUILT_LIMIT = 1 << 30
};

static record_step *next_step(square_record *r)
{
    if (!array_reserve(&r->steps, &r->capacity, r->count + 1, sizeof *r->steps)) return NULL;
    return &r->steps[r->count++];
}

vxs_result record_add_settled(square_record *r, uint32_t level, uint32_t i, uint32_t j, const column_bounds *bounds)
{
    record_step *s = next_step(r);
    if (!s) return VXS_E_MEMORY;
    *s = (record_step){.level = level, .i = i, .j = j, .bounds = *bounds};
    return VXS_OK;
}

vxs_result record_add_built(square_record *r, uint32_t level, uint32_t i, uint32_t j)
{
    record_step *s = next_step(r);
    if (!s) return VXS_E_MEMORY;
    *s = (record_step){.level = level, .i = i, .j = j, .is_built = 1};
    r->built_count++;
    return VXS_OK;
}

vxs_result record_pack(const vxs_bytes *built, vxs_bytes *frame)
{
    if (built->size_bytes > BUILT_LIMIT) return VXS_E_ARGUMENT;
    if (!array_reserve(&frame->data, &frame->capacity_bytes, ZSTD_compressBound(built->size_bytes), 1)) return VXS_E_MEMORY;
    frame->size_bytes = ZSTD_compress(frame->data, frame->capacity_bytes, built->data, built->size_bytes, PACK_LEVEL);
    return ZSTD_isError(frame->size_bytes) ? VXS_E_MEMORY : VXS_OK;
}

vxs_result record_unpack(const record_step *s, vxs_bytes *built)
{
    if (!vxs_is_frame(s->frame, s->frame_bytes, s->built_bytes)) return VXS_E_CORRUPT;
    ZSTD_DCtx *zstd = ZSTD_createDCtx();
    vxs_result r    = VXS_E_MEMORY;
    if (zstd && array_reserve(&built->data, &built->capacity_bytes, s->built_bytes, 1))
        r = vxs_inflate_frame(built->data, s->built_bytes, s->frame, s->frame_bytes, zstd) ? VXS_OK : VXS_E_CORRUPT;
    built->size_bytes = s->built_bytes;
    ZSTD_freeDCtx(zstd);
    return r;
}

/* writing --------------------------------------------------------------------------------------------------------------------- */

static int put_step(vxs_bytes *out, const record_step *s, uint64_t built_bytes, uint64_t frame_bytes)
{
    const column_bounds *b = &s->bounds;
    if (!put32s(out, (uint32_t[]){s->level, s->i, s->j, s->is_built ? 1 : 0}, 4)) return 0;
    if (s->is_built) return put64(out, built_bytes) && put64(out, frame_bytes);
    return put32s(out, (uint32_t[]){b->emin, b->emax, b->xmin, b->xmax}, 4);
}

vxs_result record_write(const square_record *r, const vxs_bytes *frames, const uint64_t *built_bytes, vxs_bytes *out)
{
    int    ok    = put32(out, (uint32_t)r->count);
    size_t built = 0;
    for (const record_step *s = r->steps; s < r->steps + r->count && ok; s++) {
        ok = put_step(out, s, s->is_built ? built_bytes[built] : 0, s->is_built ? frames[built].size_bytes : 0);
        built += s->is_built != 0;
    }
    for (size_t n = 0; n < built && ok; n++) ok = put_bytes(out, frames[n].data, frames[n].size_bytes);
    return ok ? VXS_OK : VXS_E_MEMORY;
}

/* reading --------------------------------------------------------------------------------------------------------------------- */

static int take_step(byte_reader *from, record_step *s, uint32_t depth_vx)
{
    if (!has(from, 1, HEAD_BYTES + STEP_BYTES)) return 0;
    s->level      = take32(from);
    s->i          = take32(from);
    s->j          = take32(from);
    uint32_t kind = take32(from);
    s->is_built   = kind == 1;
    if (kind > 1) return 0;
    if (s->is_built) {
        s->built_bytes = take64(from);
        s->frame_bytes = take64(from);
        return s->built_bytes <= BUILT_LIMIT;
    }
    s->bounds = (column_bounds){take32(from), 0, 0, 0};
    take32s(from, &s->bounds.emax, 1);
    take32s(from, &s->bounds.xmin, 1);
    take32s(from, &s->bounds.xmax, 1);
    return s->bounds.emin <= s->bounds.emax && s->bounds.xmin <= s->bounds.xmax && s->bounds.emax <= depth_vx &&
           s->bounds.xmax <= depth_vx;
}

vxs_result record_read(square_record *r, const void *bytes, size_t size_bytes, uint32_t level, uint32_t i, uint32_t j,
                       uint32_t depth_vx)
{
    byte_reader from = {bytes, size_bytes};
    uint64_t    at   = 0;
    if (!has(&from, 1, 4)) return VXS_E_CORRUPT;
    uint32_t count = take32(&from);
    if (!has(&from, count, HEAD_BYTES + STEP_BYTES)) return VXS_E_CORRUPT;
    for (uint32_t n = 0; n < count; n++) {
        record_step *s = next_step(r);
        if (!s) return VXS_E_MEMORY;
        *s = (record_step){0};
        if (!take_step(&from, s, depth_vx)) return VXS_E_CORRUPT;

        /* the step must begin at `at`, in z order, counted in squares of the least size from the corner */
        if (s->level > level) return VXS_E_CORRUPT;
        uint32_t down = level - s->level;
        uint64_t z    = 0;
        if (s->i >> down != i || s->j >> down != j) return VXS_E_CORRUPT;
        for (uint32_t bit = 0; bit < down; bit++)
            z |= (uint64_t)(s->i >> bit & 1) << 2 * bit | (uint64_t)(s->j >> bit & 1) << (2 * bit + 1);
        if (z << 2 * s->level != at) return VXS_E_CORRUPT;
        at += 1ull << 2 * s->level;

        r->built_count += s->is_built != 0;
    }
    for (record_step *s = r->steps; s < r->steps + r->count; s++) {
        if (!s->is_built) continue;
        if (!has(&from, s->frame_bytes, 1)) return VXS_E_CORRUPT;
        s->frame = take_bytes(&from, s->frame_bytes);
    }
    return at == 1ull << 2 * level && !from.left ? VXS_OK : VXS_E_CORRUPT;
}

void record_free(square_record *r)
{
    free(r->steps);
    *r = (square_record){0};
}
