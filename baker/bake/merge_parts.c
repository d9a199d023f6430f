/* Merging parts; see merge_parts.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/merge_parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/bake/bake_light.h"
#include "baker/bake/bake_squares.h"
#include "baker/bake/light_coder.h"
#include "baker/base/clock.h"
#include "baker/files/input_file.h"

/* All parts of a bake. */
typedef struct part_set {
    part_reader *parts; /* [count] in the given order; count of open ones */
    size_t       count;
    uint32_t    *at; /* [parts of the bake] 1 + index into `parts`; 0: not given */
    part_common  common;
    uint64_t     next; /* number of the next square */
} part_set;

/* the parts ------------------------------------------------------------------------------------------------------------------- */

/* Check that a part is not a duplicate, and belongs to the same bake. */
static vxs_result check_part(const part_set *s, const part_reader *p, run_context *m)
{
    const part_reader *first = &s->parts[0];
    if (p->parts != first->parts)
        return fail(m, VXS_E_CORRUPT, "'%s' is one of %u parts, and '%s' is one of %u: they are not of one bake",
                    input_name(p->path), p->parts, input_name(first->path), first->parts);
    if (p->common.size_bytes != first->common.size_bytes || memcmp(p->common.data, first->common.data, p->common.size_bytes) != 0)
        return fail(
            m, VXS_E_CORRUPT,
            "'%s' and '%s' are parts of different bakes: of other scenes, lights, options, versions, renderers, or --memory",
            input_name(p->path), input_name(first->path));
    if (s->at[p->number - 1])
        return fail(m, VXS_E_ARGUMENT, "'%s' and '%s' are both part %u of %u", input_name(s->parts[s->at[p->number - 1] - 1].path),
                    input_name(p->path), p->number, p->parts);
    return VXS_OK;
}

static vxs_result open_parts(part_set *s, const text_list *paths, run_context *m)
{
    vxs_result r = VXS_OK;
    s->parts     = calloc(paths->count + 1, sizeof *s->parts);
    if (!s->parts) return fail(m, VXS_E_MEMORY, "out of memory for %zu parts", paths->count);
    for (size_t n = 0; n < paths->count && r == VXS_OK; n++) {
        const char  *path = paths->items[n];
        part_reader *p    = &s->parts[s->count++];
        r                 = part_open(p, path, m);
        if (r == VXS_OK && !s->at && !(s->at = calloc(p->parts, sizeof *s->at)))
            r = fail(m, VXS_E_MEMORY, "out of memory for parts");
        if (r == VXS_OK) r = check_part(s, p, m);
        if (r == VXS_OK) s->at[p->number - 1] = (uint32_t)s->count;
    }
    if (r != VXS_OK) return r;
    for (uint32_t n = 0; n < s->parts[0].parts; n++)
        if (!s->at[n])
            return fail(m, VXS_E_ARGUMENT, "part %u of %u is missing: %zu were given", n + 1, s->parts[0].parts, s->count);
    r = part_common_read(&s->common, s->parts[0].common.data, s->parts[0].common.size_bytes);
    return r == VXS_E_CORRUPT ? part_is_damaged(&s->parts[0], m) : r == VXS_OK ? r : fail(m, r, "out of memory for parts");
}

/* columns --------------------------------------------------------------------------------------------------------------------- */

typedef struct part_columns {
    part_set         *set;
    const part_light *of;
    uint32_t          light, map; /* their indices */
    size_t            answered;
    square_cache      cache;
} part_columns;

/* The part that has a square. */
static const part_reader *part_of(const part_set *s, uint64_t number)
{
    return &s->parts[s->at[number % s->parts[0].parts] - 1];
}

/* Return the next stored bounds of the map. */
static vxs_result answer(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    part_columns   *c = data;
    const part_map *p = &c->of->maps[c->map];
    (void)level;
    (void)i;
    (void)j;
    if (c->answered == p->count) return VXS_E_CORRUPT;
    *out = p->answers[c->answered++];
    return VXS_OK;
}

static vxs_result find(void *data, const column_map *columns, uint32_t level, uint32_t i, uint32_t j, square_action *action,
                       vxs_bytes *record, bake_context *ctx)
{
    part_columns      *c      = data;
    uint64_t           number = c->set->next++;
    const part_reader *p      = part_of(c->set, number);
    const part_square *s      = part_find(p, number);
    column_key         key    = part_square_key(number, c->light, c->map, level, i, j);
    (void)columns;
    *action = SQUARE_KNOWN;
    return s ? part_read(p, s, &key, record, ctx->run) : part_is_damaged(p, ctx->run);
}

/* Called only if the record of a square was not sound: an error. So nothing is stored. */
static vxs_result fetch(void *data, uint32_t level, uint32_t i, uint32_t j, column_square *out, bake_context *ctx)
{
    const part_columns *c = data;
    (void)level;
    (void)i;
    (void)j;
    *out = (column_square){0};
    return part_is_damaged(part_of(c->set, c->set->next - 1), ctx->run);
}

static void release(void *data, column_square *square)
{
    (void)data;
    *square = (column_square){0};
}

static void close_map(void *data)
{
    (void)data;
}

static vxs_result open_map(void *data, uint32_t map, column_map *out, bake_context *ctx)
{
    part_columns *c    = data;
    uint32_t      side = 1u << c->of->light.levels;
    (void)ctx;
    c->map      = map;
    c->answered = 0;
    *out        = (column_map){.data     = c,
                               .side_px  = side,
                               .depth_vx = side,
                               .fetch_px = c->of->maps[map].fetch_px,
                               .bounds   = answer,
                               .fetch    = fetch,
                               .release  = release,
                               .close    = close_map,
                               .cache    = &c->cache};
    return VXS_OK;
}

/* the merge ------------------------------------------------------------------------------------------------------------------- */

/* Merge the parts into a file. */
static vxs_result merge_file(part_set *s, const bake_options *o, bake_report *report, bake_context *ctx)
{
    size_t       count = s->common.light_count;
    coded_light *coded = calloc(count, sizeof *coded);
    vxs_bytes    file  = {0};
    report->lights     = calloc(count, sizeof *report->lights);
    vxs_result r       = coded && report->lights ? VXS_OK : fail(ctx->run, VXS_E_MEMORY, "out of memory for %zu lights", count);
    if (r == VXS_OK) {
        for (uint32_t n = 0; n < s->common.light_count && r == VXS_OK; n++) {
            report->light_count++;
            report->lights[n].light = s->common.lights[n].light;

            const part_light *of      = &s->common.lights[n];
            plan_light        planned = {.light = of->light, .map_count = vxs_map_count(&of->light)};
            part_columns      columns = {.set = s, .of = of, .light = n, .cache = {&columns, 0, NULL, find, NULL}};
            column_source     source  = {&columns, planned.map_count, open_map};
            chosen_coder      coding;
            for (uint32_t map = 0; map < planned.map_count; map++) {
                uint64_t across = (1u << of->light.levels) / of->maps[map].fetch_px;
                planned.tiles += across * across;
            }
            snprintf(planned.name, sizeof planned.name, "%.*s", VXS_LIGHT_NAME_BYTES - 1, of->light.name);
            chosen_coder_init(&coding, o, COMPRESS_NONE, NULL);
            r = bake_light(&planned, &source, &coding.coder, &coded[n], ctx);
            chosen_coder_free(&coding);
        }
        uint64_t there = 0;
        for (size_t n = 0; n < s->count; n++) there += s->parts[n].squares.count;
        r = r == VXS_OK && there != s->next ? part_is_damaged(&s->parts[0], ctx->run) : r;
    }
    watch_say(o->watch, "compressing the file");
    if (r == VXS_OK) r = asset_encode(o, coded, report->light_count, s->common.metadata, NULL, &file, ctx->run);
    for (size_t n = 0; n < count && coded; n++) coded_light_free(&coded[n]);
    free(coded);
    if (r == VXS_OK) r = asset_write(o, &file, report, ctx->run);
    free(file.data);
    return r;
}

vxs_result merge_parts(const merge_options *o, merge_report *report, run_context *m)
{
    part_set     set = {.count = 0};
    bake_context ctx = {.run = m, .threads = o->threads, .watch = o->watch, .subject = o->output_path, .begun = clock_seconds()};
    stage_begin(&ctx, STAGE_MERGE);
    vxs_result r = open_parts(&set, &o->paths, m);
    if (r == VXS_OK) {
        bake_options of = set.common.o;
        of.output_path  = o->output_path;
        of.threads      = o->threads;
        of.watch        = o->watch;
        r               = merge_file(&set, &of, &report->lights, &ctx);
        report->parts   = set.parts[0].parts;
        report->squares = set.next;
    }
    stage_begin(&ctx, STAGE_NONE);
    report->lights.peak_bytes    = ctx.peak_bytes;
    report->lights.total_seconds = clock_seconds() - ctx.begun;
    for (size_t n = 0; n < set.count; n++) part_close(&set.parts[n]);
    free(set.parts);
    free(set.at);
    part_common_free(&set.common);
    return r;
}

void merge_report_free(merge_report *r)
{
    bake_report_free(&r->lights);
}
