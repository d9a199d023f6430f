/* Baking one light; see bake_light.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/bake_light.h"

#include <stdio.h>
#include <stdlib.h>

#include "baker/base/parallel.h"
#include "baker/files/output_file.h"
#include "formats/vxs_reader.h"
#include "runtime/vxs.h"

vxs_result bake_light(const plan_light *planned, const column_source *source, const light_coder *coder, coded_light *out,
                      bake_context *ctx)
{
    char   doing[sizeof ctx->doing];
    double seconds = 0;
    snprintf(doing, sizeof doing, "light %s: square", planned->name);
    for (int s = STAGE_MAPS; s <= STAGE_MERGE; s++) seconds += planned->seconds[s];
    steps_begin(ctx, (uint32_t)planned->tiles, seconds / (double)planned->tiles, doing);
    vxs_result r = coder->begin(coder->data, &planned->light);
    for (uint32_t map = 0; map < source->map_count && r == VXS_OK; map++) {
        column_map columns;
        if ((r = source->open(source->data, map, &columns, ctx)) != VXS_OK) break;
        r = coder->add_map(coder->data, map, &columns, ctx);
        columns.close(columns.data);
    }
    stage_begin(ctx, STAGE_MERGE);
    if (r == VXS_OK && out) r = coder->finish(coder->data, out);
    stage_begin(ctx, STAGE_NONE);
    if (r != VXS_OK) fail(ctx->run, r, "%s while baking light '%s'", vxs_result_text(r), planned->name);
    return r;
}

vxs_result asset_encode(const bake_options *o, const coded_light *coded, uint32_t light_count, const char *metadata,
                        const vxs_points_view *points, vxs_bytes *out, run_context *m)
{
    vxs_write_light *lights = calloc(light_count, sizeof *lights);
    vxs_result       r      = VXS_E_MEMORY;
    if (lights && metadata) {
        for (uint32_t n = 0; n < light_count; n++) lights[n] = coded[n].written;
        vxs_parallel   threads = parallel_lent(o->threads);
        vxs_write_desc desc    = {.lights      = lights,
                                  .light_count = light_count,
                                  .metadata    = metadata,
                                  .zstd_level  = (int)o->zstd_level,
                                  .parallel    = &threads,
                                  .points      = points};
        r                      = vxs_write(out, &desc);
    }
    free(lights);
    if (r == VXS_OK) return r;
    return fail(m, r, "the asset cannot be encoded: %s",
                r == VXS_E_MEMORY ? "out of memory"
                                  : "it is too large for the format, or this is a fault of vxs; try another --resolution or "
                                    "--coding dag, and report the scene if that works");
}

vxs_result asset_write(const bake_options *o, const vxs_bytes *file, bake_report *report, run_context *m)
{
    vxs_contents  contents = {0};
    output_file   out      = {0};
    vxs_parallel  threads  = parallel_lent(o->threads);
    vxs_read_desc desc     = {.parallel = &threads};
    vxs_result    r        = vxs_read_written(&contents, file->data, file->size_bytes, &desc);
    if (r != VXS_OK) return fail(m, r, "the encoded asset cannot be read back, nothing was written: %s", vxs_result_text(r));

    /* sizes by part, as a reader sees them */
    for (uint32_t s = 0; s < contents.section_count; s++)
        if (contents.sections[s].kind == VXS_KIND_POINTS) report->points_bytes = contents.sections[s].stored_bytes;
    for (uint32_t n = 0; n < contents.light_count; n++) {
        const vxs_baked_light *baked = &contents.lights[n];
        light_report          *light = &report->lights[n];
        light->light                 = baked->light;
        light->memory_bytes          = (uint64_t)baked->word_count * 4;
        light->part_count            = baked->part_count;
        for (uint32_t p = 0; p < baked->part_count; p++) {
            /* a section with several parts counts for the first of them */
            int is_first = !p || baked->parts[p].section != baked->parts[p - 1].section;
            light->parts[p] =
                (part_report){baked->parts[p], is_first ? contents.sections[baked->parts[p].section].stored_bytes : 0};
        }
        for (uint32_t s = 0; s < contents.section_count; s++)
            if (contents.sections[s].light == n)
                *(contents.sections[s].kind == VXS_KIND_SMOKE ? &light->smoke.stored_bytes : &light->stored_bytes) +=
                    contents.sections[s].stored_bytes;
    }

    vxs_contents_free(&contents);
    report->file_bytes = file->size_bytes;

    if (!o->output_path) return VXS_OK;
    if ((r = output_file_open(&out, o->output_path, m)) != VXS_OK) return r;
    if ((r = output_file_write(&out, file->data, file->size_bytes, m)) == VXS_OK) r = output_file_commit(&out, m);
    output_file_abort(&out);
    return r;
}
