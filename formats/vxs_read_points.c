/* Reading points of casters: every check of formats/vxs.md section 16, and their coordinates.
 * SPDX-License-Identifier: MIT */
#include <math.h>

#include "vxs_bytes.h"
#include "vxs_points.h"
#include "vxs_reader.h"

/* Whether all places are finite, also at the last unit. */
static int head_valid(const vxs_baked_points *p)
{
    for (int n = 0; n < 3; n++)
        if (!isfinite(p->low_ws[n]) || !isfinite(p->low_ws[n] + 65535 * p->step_metres)) return 0;
    return isfinite((float)p->square_metres) && p->square_metres > 0 && isfinite(p->step_metres) && p->step_metres > 0 &&
           p->count >= 1 && p->count <= VXS_POINTS_MAX;
}

static vxs_baked_points head_of(const uint8_t *content)
{
    vxs_baked_points p = {.count         = vxs_load32(content + VXS_POINTS_POINT_COUNT),
                          .square_metres = vxs_load_f64(content + VXS_POINTS_SQUARE_METRES),
                          .step_metres   = vxs_load_f64(content + VXS_POINTS_STEP_METRES)};
    for (int n = 0; n < 3; n++) p.low_ws[n] = vxs_load_f64(content + VXS_POINTS_LOW + 8 * n);
    return p;
}

/* Decode codes stored as differences from the previous code, with a plane for each byte. 0: a finding. */
static int decode(vxs_reader *r, int section, const uint8_t *planes, uint32_t count, uint16_t *coordinates)
{
    uint64_t code = 0;
    for (uint32_t n = 0; n < count; n++) {
        for (uint32_t plane = 0; plane < VXS_POINT_PLANES; plane++)
            code += (uint64_t)planes[(size_t)plane * count + n] << 8 * plane;
        if (code >> 8 * VXS_POINT_PLANES) return vxs_found(r, 703, section, VXS_POINTS_PREFIX_BYTES + n), 0;
        for (uint32_t i = 0; i < 3; i++) *coordinates++ = vxs_point_coordinate(code >> i);
    }
    return 1;
}

static void read_content(vxs_reader *r, int section, const uint8_t *content, uint64_t size)
{
    if (size < VXS_POINTS_PREFIX_BYTES) {
        vxs_found(r, 701, section, 0);
        return;
    }
    vxs_baked_points p = head_of(content);
    p.section          = (uint32_t)section;
    if (!head_valid(&p)) {
        vxs_found(r, 702, section, 0);
        return;
    }
    if (size != VXS_POINTS_PREFIX_BYTES + (uint64_t)p.count * VXS_POINT_PLANES) {
        vxs_found(r, 701, section, VXS_POINTS_POINT_COUNT);
        return;
    }
    uint16_t *coordinates = vxs_take(r, p.count, 3 * sizeof *coordinates, section);
    if (!coordinates) return;
    p.coordinates = coordinates;
    r->points     = p;
    decode(r, section, content + VXS_POINTS_PREFIX_BYTES, p.count, coordinates);
}

void vxs_read_points(vxs_reader *r)
{
    for (uint32_t n = 0; n < r->out.section_count; n++) {
        const vxs_section *s = &r->out.sections[n];
        if (s->kind != VXS_KIND_POINTS || s->light != VXS_NO_LIGHT || r->points.coordinates) continue;
        uint8_t *content = vxs_inflate(r, (int)n, 0);
        if (!content) return;
        read_content(r, (int)n, content, s->inflated_bytes);
        vxs_give_back(r, content, s->inflated_bytes, 1);
    }
}

void vxs_points_free(vxs_baked_points *points, const vxs_allocator *a)
{
    if (points->coordinates) a->free((void *)points->coordinates, points->count * 3 * sizeof *points->coordinates, a->user);
}
