/* What all readers of sections share: findings, memory within a limit, sections by kind, inflation (vxs_reader.h).
 * SPDX-License-Identifier: MIT */
#include "vxs_reader.h"

#include <string.h>
#include <zstd.h>

#include "vxs_bytes.h"
#include "vxs_findings.h"
#include "vxs_frame.h"

void vxs_found(vxs_reader *r, int number, int section, uint64_t offset)
{
    static const struct {
        int         number;
        vxs_result  result;
        const char *text;
    } list[] = {
#define VXS_FINDING_ROW(number, result, text) {number, result, text},
        VXS_FINDINGS(VXS_FINDING_ROW)
#undef VXS_FINDING_ROW
    };
    for (size_t n = 0; n < sizeof list / sizeof *list; n++) {
        if (list[n].number != number) continue;
        if (r->result == VXS_OK) r->result = list[n].result;
        if (r->desc.finding) r->desc.finding(r->desc.finding_user, number, list[n].text, section, offset);
    }
}

void *vxs_reader_try_alloc(vxs_reader *r, uint64_t count, size_t size)
{
    if (count > r->memory_left / size) return NULL;
    void *memory = r->allocator.alloc(count ? count * size : 1, r->allocator.user);
    if (memory) r->memory_left -= count * size;
    return memory;
}

void *vxs_reader_alloc(vxs_reader *r, uint64_t count, size_t size, int section)
{
    if (count > r->memory_left / size) {
        vxs_found(r, 211, section, 0);
        return NULL;
    }
    void *memory = vxs_reader_try_alloc(r, count, size);
    if (!memory && r->result == VXS_OK) r->result = VXS_E_MEMORY;
    return memory;
}

void vxs_reader_free(vxs_reader *r, void *memory, uint64_t count, size_t size)
{
    if (!memory) return;
    r->allocator.free(memory, count ? count * size : 1, r->allocator.user);
    r->memory_left += count * size;
}

int vxs_same_section(const vxs_section *a, const vxs_section *b)
{
    return a->kind == b->kind && a->light == b->light && a->level == b->level;
}

int vxs_find_section(vxs_reader *r, uint32_t kind, uint32_t light, uint32_t level)
{
    vxs_section wanted = {.kind = kind, .light = light, .level = level};
    for (uint32_t n = 0; n < r->out.section_count; n++)
        if (vxs_same_section(&r->out.sections[n], &wanted)) return (int)n;
    vxs_found(r, 209, VXS_IN_HEADER, VXS_HEADER_BYTES);
    return -1;
}

int vxs_check_frame(vxs_reader *r, int section, const uint8_t *from, size_t extra)
{
    const vxs_section *s = &r->out.sections[section];
    if (!vxs_is_frame(from, s->stored_bytes, s->inflated_bytes) || s->inflated_bytes > SIZE_MAX - extra)
        return vxs_found(r, 207, section, s->offset_bytes), 0;
    return 1;
}

uint8_t *vxs_inflate(vxs_reader *r, int section, size_t extra)
{
    const vxs_section *s    = &r->out.sections[section];
    const uint8_t     *from = vxs_stored_bytes(r, section);
    if (!from || !vxs_check_frame(r, section, from, extra)) return NULL;
    uint8_t *to = vxs_reader_alloc(r, s->inflated_bytes + extra, 1, section);
    if (!to) return NULL;
    size_t size = ZSTD_decompressDCtx(r->zstd, to, s->inflated_bytes, from, s->stored_bytes);
    if (ZSTD_isError(size) || size != s->inflated_bytes) {
        vxs_found(r, 207, section, s->offset_bytes);
        vxs_reader_free(r, to, s->inflated_bytes + extra, 1);
        return NULL;
    }
    memset(to + s->inflated_bytes, 0, extra);
    return to;
}
