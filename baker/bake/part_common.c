/* Serialization of the data common to all parts; see part_common.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/part_common.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/byte_stream.h"

enum { CHOICES = 5, NUMBERS = 20, LIGHT_BYTES = VXS_LIGHT_NAME_BYTES + 4 * 4 + 8 * NUMBERS, ANSWER_BYTES = 16 };

/* Pointers to the numbers of a light, in the order of the struct. */
static void numbers_of(vxs_light *l, double *of[NUMBERS])
{
    size_t at = 0;
    for (int n = 0; n < 12; n++) of[at++] = &l->ls_from_ws[n];
    of[at++] = &l->texel_metres;
    of[at++] = &l->voxel_metres;
    for (int n = 0; n < 3; n++) of[at++] = &l->direction_ws[n];
    of[at++] = &l->near_metres;
    of[at++] = &l->cos_outer;
    of[at++] = &l->range_metres;
}

/* writing --------------------------------------------------------------------------------------------------------------------- */

static int put_text(vxs_bytes *out, const char *text)
{
    return put64(out, strlen(text)) && put_bytes(out, text, strlen(text));
}

static int put_map(vxs_bytes *out, const part_map *p)
{
    int ok = put32(out, p->fetch_px) && put64(out, p->count);
    for (const column_bounds *b = p->answers; b < p->answers + p->count && ok; b++)
        ok = put32s(out, (uint32_t[]){b->emin, b->emax, b->xmin, b->xmax}, 4);
    return ok;
}

static int put_light(vxs_bytes *out, const part_light *p)
{
    vxs_light l = p->light;
    double   *of[NUMBERS];
    uint8_t   bytes[8];
    numbers_of(&l, of);
    int ok = put_bytes(out, l.name, sizeof l.name) && put32s(out, (uint32_t[]){l.kind, l.flags, l.levels, l.coding}, 4);
    for (int n = 0; n < NUMBERS && ok; n++) {
        vxs_store_f64(bytes, *of[n]);
        ok = put_bytes(out, bytes, sizeof bytes);
    }
    for (uint32_t map = 0; map < vxs_map_count(&l) && ok; map++) ok = put_map(out, &p->maps[map]);
    return ok;
}

vxs_result part_common_write(const part_common *c, vxs_bytes *out)
{
    const uint32_t choices[CHOICES] = {c->o.coding, c->o.pack, c->o.rule, (uint32_t)c->o.reuse, c->o.zstd_level};
    int ok = put32s(out, choices, CHOICES) && put_text(out, c->made_by) && put_text(out, c->metadata) && put64(out, c->light_count);
    for (size_t n = 0; n < c->light_count && ok; n++) ok = put_light(out, &c->lights[n]);
    return ok ? VXS_OK : VXS_E_MEMORY;
}

/* reading --------------------------------------------------------------------------------------------------------------------- */

static vxs_result take_text(byte_reader *from, char **text)
{
    if (!has(from, 1, 8)) return VXS_E_CORRUPT;
    uint64_t size = take64(from);
    if (!has(from, size, 1) || memchr(from->at, 0, size)) return VXS_E_CORRUPT;
    *text = strndup((const char *)take_bytes(from, size), size);
    return *text ? VXS_OK : VXS_E_MEMORY;
}

static int are_choices(const uint32_t c[CHOICES])
{
    return c[0] <= CODING_BLOCKS && c[1] <= PACK_FAST && c[2] <= MASK_RULE_SHADOW && c[3] <= 1 && c[4] >= 1 && c[4] <= 19;
}

static vxs_result take_map(byte_reader *from, part_map *p, uint32_t side_px)
{
    if (!has(from, 1, 12)) return VXS_E_CORRUPT;
    p->fetch_px      = take32(from);
    uint64_t answers = take64(from);
    if (p->fetch_px < 8 || p->fetch_px > side_px || p->fetch_px & (p->fetch_px - 1)) return VXS_E_CORRUPT;
    if (!has(from, answers, ANSWER_BYTES)) return VXS_E_CORRUPT;
    if (!array_reserve(&p->answers, &p->capacity, answers + 1, sizeof *p->answers)) return VXS_E_MEMORY;
    for (; p->count < answers; p->count++) {
        uint32_t b[4];
        take32s(from, b, 4);
        if (b[0] > b[1] || b[2] > b[3] || b[1] > side_px || b[3] > side_px) return VXS_E_CORRUPT;
        p->answers[p->count] = (column_bounds){b[0], b[1], b[2], b[3]};
    }
    return VXS_OK;
}

static vxs_result take_light(byte_reader *from, part_common *c)
{
    double *of[NUMBERS];
    if (!has(from, 1, LIGHT_BYTES)) return VXS_E_CORRUPT;
    if (!array_reserve(&c->lights, &c->light_capacity, c->light_count + 1, sizeof *c->lights)) return VXS_E_MEMORY;
    part_light *p = &c->lights[c->light_count++];
    vxs_light  *l = &p->light;
    *p            = (part_light){.maps = {{0}}};
    memcpy(l->name, take_bytes(from, sizeof l->name), sizeof l->name);
    l->kind   = take32(from);
    l->flags  = take32(from);
    l->levels = take32(from);
    l->coding = take32(from);
    if (l->levels < 3 || l->levels > 18 || l->coding != (c->o.coding == CODING_DAG ? VXS_CODING_DAG : VXS_CODING_BLOCKS))
        return VXS_E_CORRUPT;
    numbers_of(l, of);
    for (int n = 0; n < NUMBERS; n++) *of[n] = vxs_load_f64(take_bytes(from, 8));
    vxs_result r = VXS_OK;
    for (uint32_t map = 0; map < vxs_map_count(l) && r == VXS_OK; map++) r = take_map(from, &p->maps[map], 1u << l->levels);
    return r;
}

vxs_result part_common_read(part_common *c, const void *bytes, size_t size_bytes)
{
    byte_reader from = {bytes, size_bytes};
    uint32_t    choices[CHOICES];
    if (!has(&from, CHOICES, 4)) return VXS_E_CORRUPT;
    take32s(&from, choices, CHOICES);
    if (!are_choices(choices)) return VXS_E_CORRUPT;
    c->o         = (bake_options){.coding     = (coding_choice)choices[0],
                                  .pack       = (pack_choice)choices[1],
                                  .rule       = (mask_rule)choices[2],
                                  .reuse      = (int)choices[3],
                                  .stop       = STOP_FINAL,
                                  .zstd_level = choices[4]};
    vxs_result r = take_text(&from, &c->made_by);
    if (r == VXS_OK) r = take_text(&from, &c->metadata);
    if (r == VXS_OK && !has(&from, 1, 8)) r = VXS_E_CORRUPT;
    uint64_t lights = r == VXS_OK ? take64(&from) : 0;
    if (lights > VXS_LIGHTS_MAX) r = VXS_E_CORRUPT;
    for (uint64_t n = 0; n < lights && r == VXS_OK; n++) r = take_light(&from, c);
    return r == VXS_OK && (from.left || !lights) ? VXS_E_CORRUPT : r;
}

void part_common_free(part_common *c)
{
    for (size_t n = 0; n < c->light_count; n++)
        for (uint32_t map = 0; map < VXS_CUBE_FACES; map++) free(c->lights[n].maps[map].answers);
    free(c->lights);
    free(c->made_by);
    free(c->metadata);
    *c = (part_common){.light_count = 0};
}
