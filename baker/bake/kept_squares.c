/* Squares that are kept; see kept_squares.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/kept_squares.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/version.h"
#include "baker/files/json_file.h"
#include "baker/kept/kept_square.h"

/* Raise it with any change of what a square becomes that a version number does not tell of. */
#define SQUARES_MADE_BY "vxs " VXS_VERSION " squares 1"

static column_key with_text(column_key before, const char *text)
{
    return column_key_with(before, text, strlen(text) + 1);
}

/* The coding, and how it builds: not in which order it finds what is equal. */
static column_key coding_key(const bake_options *o)
{
    const build_options b         = build_options_of(o, COMPRESS_NONE);
    const uint32_t      choices[] = {o->coding, o->coding == CODING_DAG ? (uint32_t)b.rule : 0,
                                o->coding == CODING_DAG ? (uint32_t)b.reuse : 0, o->coding == CODING_DAG ? (uint32_t)b.share : 0};
    return column_key_with(with_text((column_key){0, 0}, SQUARES_MADE_BY), choices, sizeof choices);
}

/* All that goes in, and who renders. */
static vxs_result bake_key(column_key *key, const bake_report *report, message *m)
{
    char *inputs = json_print(report->inputs, JSON_COMPACT | JSON_SORT_KEYS);
    if (!inputs) return fail(m, VXS_E_MEMORY, "out of memory for the key of a bake");
    *key = with_text(with_text(with_text((column_key){0, 0}, inputs), report->renderer), report->cpu_class);
    free(inputs);
    return VXS_OK;
}

vxs_result kept_squares_open(kept_squares *k, const bake_options *o, const bake_report *report, message *m)
{
    if (!o->resume_path) return VXS_OK;
    vxs_result r = square_store_open(&k->store, o->resume_path, m);
    k->is_open   = r == VXS_OK;
    k->coding    = coding_key(o);
    return r == VXS_OK ? bake_key(&k->bake, report, m) : r;
}

void kept_squares_close(kept_squares *k)
{
    square_store_close(&k->store);
    *k = (kept_squares){.is_open = 0};
}

/* a light --------------------------------------------------------------------------------------------------------------------- */

static vxs_result square_key(const kept_light *l, const column_map *columns, uint32_t level, uint32_t i, uint32_t j,
                             column_key *key)
{
    const uint32_t of_all[] = {columns->side_px, columns->depth_vx, l->map, level, i, j};
    column_key     of_columns;
    vxs_result     r = VXS_OK;
    if (columns->key)
        r = columns->key(columns->data, level, i, j, &of_columns);
    else
        of_columns = column_key_with(l->squares->bake, &l->light, sizeof l->light);
    *key = column_key_with(column_key_with(l->squares->coding, of_all, sizeof of_all), &of_columns, sizeof of_columns);
    return r;
}

static vxs_result ask(void *data, const column_map *columns, uint32_t level, uint32_t i, uint32_t j, square_fate *fate,
                      vxs_bytes *record, bake_context *ctx)
{
    kept_light *l     = data;
    int         found = 0;
    stage_begin(ctx, STAGE_MAPS);
    vxs_result r = square_key(l, columns, level, i, j, &l->asked);
    if (r != VXS_OK) fail(ctx->message, r, "out of memory for the key of a square");
    if (r == VXS_OK) r = square_store_find(&l->squares->store, &l->asked, record, &found, ctx->message);
    stage_begin(ctx, STAGE_NONE);
    if (found) *fate = SQUARE_KNOWN;
    l->report->squares++;
    return r;
}

static vxs_result keep(void *data, const vxs_bytes *record, bake_context *ctx)
{
    kept_light *l = data;
    l->report->squares_made++;
    stage_begin(ctx, STAGE_MAPS);
    vxs_result r = square_store_keep(&l->squares->store, &l->asked, record, ctx->message);
    stage_begin(ctx, STAGE_NONE);
    return r;
}

static vxs_result open_map(void *data, uint32_t map, column_map *out, bake_context *ctx)
{
    kept_light *l = data;
    vxs_result  r = l->under.open(l->under.data, map, out, ctx);
    l->map        = map;
    if (r == VXS_OK) out->keeper = &l->keeper;
    return r;
}

column_source kept_light_source(kept_light *l, kept_squares *k, column_source under, uint32_t light, light_report *report)
{
    *l = (kept_light){.squares = k, .under = under, .keeper = {l, 0, ask, keep}, .report = report, .light = light};
    return k->is_open ? (column_source){l, under.map_count, open_map} : under;
}
