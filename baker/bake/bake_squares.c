/* Keys and cache of cached squares; see bake_squares.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/bake_squares.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/bake/cache/cache_folder.h"
#include "baker/bake/provenance.h"
#include "baker/base/array.h"
#include "baker/base/byte_stream.h"
#include "baker/base/version.h"
#include "baker/files/json_value.h"

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

/* Append it to out. Returns VXS_OK or VXS_E_MEMORY. */
static vxs_result part_common_write(const part_common *c, vxs_bytes *out)
{
    const uint32_t choices[CHOICES] = {c->o.coding, c->o.pack, c->o.rule, (uint32_t)c->o.reuse, c->o.zstd_level};
    int ok = put32s(out, choices, CHOICES) && put_text(out, c->made_by) && put_text(out, c->metadata) && put64(out, c->light_count);
    for (size_t n = 0; n < c->light_count && ok; n++) {
        vxs_light l = c->lights[n].light;
        double   *of[NUMBERS];
        uint8_t   bytes[8];
        numbers_of(&l, of);
        ok = put_bytes(out, l.name, sizeof l.name) && put32s(out, (uint32_t[]){l.kind, l.flags, l.levels, l.coding}, 4);
        for (int k = 0; k < NUMBERS && ok; k++) {
            vxs_store_f64(bytes, *of[k]);
            ok = put_bytes(out, bytes, sizeof bytes);
        }
        for (const part_map *p = c->lights[n].maps; p < c->lights[n].maps + vxs_map_count(&l) && ok; p++) {
            ok = put32(out, p->fetch_px) && put64(out, p->count);
            for (const column_bounds *b = p->answers; b < p->answers + p->count && ok; b++)
                ok = put32s(out, (uint32_t[]){b->emin, b->emax, b->xmin, b->xmax}, 4);
        }
    }
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
    if (!(choices[0] <= CODING_BLOCKS && choices[1] <= PACK_FAST && choices[2] <= MASK_RULE_SHADOW && choices[3] <= 1 &&
          choices[4] >= 1 && choices[4] <= 19))
        return VXS_E_CORRUPT;
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

/* Increase it with any change of the results of squares that does not change the version number. */
#define SQUARES_MADE_BY "vxs " VXS_VERSION " squares 2"

static column_key with_text(column_key before, const char *text)
{
    return column_key_with(before, text, strlen(text) + 1);
}

vxs_result bake_squares_open(bake_squares *k, const bake_options *o, const bake_report *report, run_context *m)
{
    vxs_result r = VXS_OK;

    /* the coding and its build options; without the order of compression, which does not change results */
    const build_options b         = build_options_of(o, COMPRESS_NONE);
    const uint32_t      choices[] = {o->coding, o->coding == CODING_DAG ? (uint32_t)b.rule : 0,
                                o->coding == CODING_DAG ? (uint32_t)b.reuse : 0, o->coding == CODING_DAG ? (uint32_t)b.share : 0};
    k->coding                     = column_key_with(with_text((column_key){0, 0}, SQUARES_MADE_BY), choices, sizeof choices);

    k->others = o->others;
    if (o->resume_path) {
        r            = cache_folder_open(&k->store, o->resume_path, m);
        k->has_store = r == VXS_OK;
    }
    if (r == VXS_OK && o->parts) {
        k->has_part = 1;
        k->common.o = *o;
        r           = part_begin(&k->part, o->output_path, o->part, o->parts, m);
        if (r == VXS_OK && asprintf(&k->common.made_by, "%s, %s, %s", SQUARES_MADE_BY, report->renderer, report->cpu_class) < 0) {
            k->common.made_by = NULL;
            r                 = fail(m, VXS_E_MEMORY, "out of memory for the part of a bake");
        }
    }
    if (r != VXS_OK || !stores_squares(o)) return r;

    /* all input of the bake, and the renderer */
    char *inputs = json_whole_text(report->inputs, JSON_COMPACT | JSON_SORT_KEYS);
    if (!inputs) return fail(m, VXS_E_MEMORY, "out of memory for the key of a bake");
    k->bake = with_text(with_text(with_text((column_key){0, 0}, inputs), report->renderer), report->cpu_class);
    free(inputs);
    return VXS_OK;
}

vxs_result bake_squares_end_part(bake_squares *k, bake_report *report, run_context *m)
{
    vxs_bytes common   = {0};
    k->common.metadata = provenance_text(report);
    vxs_result r       = k->common.metadata ? part_common_write(&k->common, &common) : VXS_E_MEMORY;
    if (r != VXS_OK) fail(m, r, "out of memory for the part of a bake");
    if (r == VXS_OK) r = part_end(&k->part, &common, m);
    report->file_bytes = k->part.at;
    free(common.data);
    return r;
}

void bake_squares_close(bake_squares *k)
{
    cache_folder_close(&k->store);
    part_abort(&k->part);
    part_common_free(&k->common);
    *k = (bake_squares){.has_store = 0};
}

/* a light --------------------------------------------------------------------------------------------------------------------- */

/* is_for_others: squares made here go to the process that adds them. is_store_only: another process adds them, or a merge does. */
static int is_for_others(const bake_squares *k)
{
    return k->others && !k->others->adds;
}

static int is_store_only(const bake_squares *k)
{
    return k->has_part || is_for_others(k);
}

column_key part_square_key(uint64_t number, uint32_t light, uint32_t map, uint32_t level, uint32_t i, uint32_t j)
{
    const uint64_t place[] = {number, light, map, level, i, j};
    return column_key_with((column_key){0, 0}, place, sizeof place);
}

/* Get a square that another process has made. */
static vxs_result receive_square(light_squares *l, vxs_bytes *record, run_context *m)
{
    bake_squares *k    = l->squares;
    int           made = 0;
    vxs_result    r    = k->others->receive(k->others->data, l->number, &l->asked, record, &made, m);
    l->report->squares_made += (uint64_t)made;
    return r == VXS_OK && k->has_store ? cache_folder_use(&k->store, &l->asked, m) : r;
}

/* Hand a square to the process that adds it, or to the part. Does nothing if this process adds it. */
static vxs_result send_square(const light_squares *l, const vxs_bytes *record, int made, run_context *m)
{
    bake_squares *k = l->squares;
    if (k->has_part) return part_add(&k->part, l->number, &l->part_key, record, m);
    return is_for_others(k) ? k->others->send(k->others->data, l->number, &l->asked, record, made, m) : VXS_OK;
}

/* Look up a square of this process in the cache. */
static vxs_result find_stored(light_squares *l, square_action *action, vxs_bytes *record, run_context *m)
{
    bake_squares *k     = l->squares;
    int           found = 0;
    vxs_result    r     = k->has_store ? cache_folder_find(&k->store, &l->asked, record, &found, m) : VXS_OK;
    if (r == VXS_OK && found) r = send_square(l, record, 0, m);
    *action = !found ? SQUARE_MAKE : is_store_only(k) ? SQUARE_LEAVE : SQUARE_KNOWN;
    return r;
}

static vxs_result find(void *data, const column_map *columns, uint32_t level, uint32_t i, uint32_t j, square_action *action,
                       vxs_bytes *record, bake_context *ctx)
{
    light_squares *l = data;
    bake_squares  *k = l->squares;
    vxs_result     r = VXS_OK;
    l->number        = k->next++;
    *action          = k->has_part && !part_has(&k->part, l->number) ? SQUARE_LEAVE : SQUARE_MAKE;
    if (k->others) r = k->others->claim(k->others->data, l->number, action, ctx->run);
    if (r != VXS_OK || *action == SQUARE_LEAVE) return r;
    l->report->squares++;
    l->part_key = part_square_key(l->number, l->light, l->map, level, i, j);
    stage_begin(ctx, STAGE_MAPS);
    if (k->has_store || k->others) {
        const uint32_t of_all[] = {columns->side_px, columns->depth_vx, l->map, level, i, j};
        column_key     of_columns;
        if (columns->key)
            r = columns->key(columns->data, level, i, j, &of_columns);
        else
            of_columns = column_key_with(l->squares->bake, &l->light, sizeof l->light);
        l->asked = column_key_with(column_key_with(l->squares->coding, of_all, sizeof of_all), &of_columns, sizeof of_columns);
    }
    if (r != VXS_OK) fail(ctx->run, r, "out of memory for the key of a square");
    if (r == VXS_OK) r = *action == SQUARE_KNOWN ? receive_square(l, record, ctx->run) : find_stored(l, action, record, ctx->run);
    stage_begin(ctx, STAGE_NONE);
    return r;
}

static vxs_result store(void *data, const vxs_bytes *record, bake_context *ctx)
{
    light_squares *l = data;
    bake_squares  *k = l->squares;
    vxs_result     r = VXS_OK;
    l->report->squares_made++;
    stage_begin(ctx, STAGE_MAPS);
    if (k->has_store) r = cache_folder_store(&k->store, &l->asked, record, ctx->run);
    if (r == VXS_OK) r = send_square(l, record, 1, ctx->run);
    stage_begin(ctx, STAGE_NONE);
    return r;
}

/* Store the bounds that maps give in the common data of a part. */
static vxs_result note(void *data, const column_bounds *bounds)
{
    light_squares *l = data;
    part_map      *p = &l->squares->common.lights[l->squares->common.light_count - 1].maps[l->map];
    if (!array_reserve(&p->answers, &p->capacity, p->count + 1, sizeof *p->answers)) return VXS_E_MEMORY;
    p->answers[p->count++] = *bounds;
    return VXS_OK;
}

static vxs_result open_map(void *data, uint32_t map, column_map *out, bake_context *ctx)
{
    light_squares *l      = data;
    part_common   *common = &l->squares->common;
    vxs_result     r      = l->under.open(l->under.data, map, out, ctx);
    l->map                = map;
    if (r != VXS_OK) return r;
    out->cache = &l->cache;
    if (l->squares->has_part) common->lights[common->light_count - 1].maps[map].fetch_px = out->fetch_px;
    return VXS_OK;
}

vxs_result light_squares_source(light_squares *l, bake_squares *k, column_source *source, const vxs_light *light,
                                light_report *report, run_context *m)
{
    part_common *c = &k->common;
    if (!k->has_store && !k->has_part && !k->others) return VXS_OK;
    *l      = (light_squares){.squares = k,
                              .under   = *source,
                              .cache   = {l, is_store_only(k), k->has_part ? note : NULL, find, store},
                              .report  = report,
                              .light   = k->lights++};
    *source = (column_source){l, l->under.map_count, open_map};
    if (!k->has_part) return VXS_OK;
    if (!array_reserve(&c->lights, &c->light_capacity, c->light_count + 1, sizeof *c->lights))
        return fail(m, VXS_E_MEMORY, "out of memory for the part of a bake");
    c->lights[c->light_count++] = (part_light){.light = *light};
    return VXS_OK;
}
