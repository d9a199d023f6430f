/* The report of a bake; see report.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/report/report.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/base/version.h"
#include "baker/command/report/plan_text.h"
#include "baker/files/json_file.h"
#include "baker/files/run_files.h"

void part_print(FILE *to, const bake_options *o, const bake_report *r)
{
    square_counts squares = report_squares(r);
    char          size[32], plain[PLAIN_BYTES];
    fprintf(to, "part         %u of %u: %s, %s\n", o->part, o->parts,
            is_standard_output(o->output_path) ? "standard output" : plain_text(plain, o->output_path),
            size_text(size, r->file_bytes));
    fprintf(to, "squares      %llu of %llu made, %llu found%s%s\n", (unsigned long long)squares.made,
            (unsigned long long)squares.all, (unsigned long long)(squares.all - squares.made), o->resume_path ? " in " : "",
            o->resume_path ? plain_text(plain, o->resume_path) : "");
    fprintf(to, "time         %.2f s; memory %s\n", r->total_seconds, size_text(size, r->peak_bytes));
}

vxs_result part_write_json(const char *path, const bake_options *o, const bake_report *r, run_context *m)
{
    square_counts squares = report_squares(r);
    json_t       *part    = json_pack("{s:I, s:I, s:I, s:I}", "number", (json_int_t)o->part, "parts", (json_int_t)o->parts, "made",
                                      (json_int_t)squares.made, "found", (json_int_t)(squares.all - squares.made));
    json_t       *root =
        json_pack("{s:s, s:o, s:o, s:b, s:o, s:I, s:o, s:f, s:I}", "vxs", VXS_VERSION, "scene", json_text(o->scene_path), "output",
                  json_text(o->output_path), "unchanged", 0, "part", part, "file_bytes", (json_int_t)r->file_bytes, "warnings",
                  report_warnings_json(m), "total_seconds", r->total_seconds, "peak_bytes", (json_int_t)r->peak_bytes);
    return json_write(path, root, m);
}

void unchanged_print(FILE *to, const bake_options *o, const bake_report *r)
{
    char size[32], warnings[64] = "", plain[PLAIN_BYTES];
    if (r->warning_count) snprintf(warnings, sizeof warnings, "; warnings of its bake: %zu", r->warning_count);
    fprintf(to, "up to date   %s, %s: baked from this scene, these lights and options by vxs " VXS_VERSION "%s\n",
            plain_text(plain, o->output_path), size_text(size, r->file_bytes), warnings);
}

vxs_result unchanged_write_json(const char *path, const bake_options *o, const bake_report *r, run_context *m)
{
    json_t *root = json_pack("{s:s, s:o, s:o, s:b, s:I, s:o, s:f}", "vxs", VXS_VERSION, "scene", json_text(o->scene_path), "output",
                             json_text(o->output_path), "unchanged", 1, "file_bytes", (json_int_t)r->file_bytes, "warnings",
                             report_warnings_json(m), "total_seconds", r->total_seconds);
    return json_write(path, root, m);
}

/* for people ------------------------------------------------------------------------------------------------------------------ */

const char *part_name(char text[32], const vxs_part *part)
{
    if (strcmp(part->kind, "nodes"))
        snprintf(text, 32, "%s", part->kind);
    else
        snprintf(text, 32, "%u^3", part->side_voxels);
    return text;
}

/* Statistics of the columns that a coding found. */
static void print_found(FILE *to, const light_report *l)
{
    if (l->light.coding != VXS_CODING_DAG) {
        const palette_counts *p = &l->palette;
        fprintf(to, "  patterns   %llu tiles of 8 x 8 need one\n", (unsigned long long)l->mask_tiles);
        fprintf(to, "  kept       %llu nodes, %llu blocks, %llu tiles, %llu of them with private palettes, %llu patterns\n",
                (unsigned long long)p->nodes, (unsigned long long)p->blocks, (unsigned long long)p->tiles,
                (unsigned long long)p->private_tiles, (unsigned long long)p->patterns);
        return;
    }
    fprintf(to, "  masks      %llu tiles of 8 x 8 need %llu masks\n", (unsigned long long)l->mask_tiles,
            (unsigned long long)l->mask_runs);
    fprintf(to, "  inserted   %llu nodes, %llu masks\n", (unsigned long long)l->inserted_nodes,
            (unsigned long long)l->inserted_masks);
}

/* The rest of a line, and one more, if maps were rendered. */
static void print_rendering(FILE *to, const depth_stats *s)
{
    if (!s->blocks_rendered) {
        fprintf(to, "\n");
        return;
    }
    fprintf(to, "; rendered in %llu blocks, left out: %llu\n", (unsigned long long)s->blocks_rendered,
            (unsigned long long)s->blocks_empty);
    fprintf(to, "  peeling    in %llu blocks, %llu passes, at most %u for a block; not needed in %llu blocks with solids\n",
            (unsigned long long)s->blocks_peeled, (unsigned long long)s->peel_passes, s->peel_passes_max,
            (unsigned long long)s->blocks_not_peeled);
}

static void print_smoke(FILE *to, const smoke_counts *s)
{
    char a[32], b[32];
    if (!s->curves) return;
    fprintf(to,
            "  smoke      %u x %u texels a map; %zu with a curve, of %.1f nodes, within %.2g of its own ray; %s in memory, %s on "
            "disk\n",
            s->side_px, s->side_px, s->curves, (double)s->nodes / (double)s->curves, s->largest_error,
            size_text(a, s->memory_bytes), size_text(b, s->stored_bytes));
    if (s->lookups.places)
        fprintf(to, "             lookups between rays: RMS error %.2g, %.2g at most, at %u random lit places\n", s->lookups.rms,
                s->lookups.largest, s->lookups.places);
}

static void print_light(FILE *to, const light_report *l)
{
    char     a[TEXELS_BYTES], b[32], c[32];
    unsigned side = 1u << l->light.levels;
    char     name[VXS_LIGHT_NAME_BYTES];
    fprintf(to, "light %s\n", one_line(strcpy(name, l->light.name)));
    fprintf(to, "  map        %u x %u texels of %s, voxels %.4g %s deep\n", side, side, texels_text(a, &l->texels, 4),
            l->light.voxel_metres, l->light.kind == VXS_LIGHT_KIND_DIRECTIONAL ? "m" : "of the distance");
    fprintf(to, "  tiles      %llu, left out without casters: %llu", (unsigned long long)l->tiles,
            (unsigned long long)l->tiles_skipped);
    print_rendering(to, &l->depth);
    print_found(to, l);
    fprintf(to, "  %-12s %10s %12s %12s\n", l->light.coding == VXS_CODING_DAG ? "level" : "part", "count", "memory", "on disk");
    for (const part_report *p = l->parts; p < l->parts + l->part_count; p++)
        fprintf(to, "  %-12s %10u %12s %12s\n", part_name(c, &p->part), p->part.count, size_text(a, p->part.memory_bytes),
                size_text(b, p->stored_bytes));
    fprintf(to, "  size       %s in memory, %s on disk: %.4g and %.4g bit/texel\n", size_text(a, l->memory_bytes),
            size_text(b, l->stored_bytes), 8.0 * (double)l->memory_bytes / light_texels(l),
            8.0 * (double)l->stored_bytes / light_texels(l));
    fprintf(to, "             a 16-bit depth map takes %s, %.4g times as much as the file\n",
            size_text(c, (uint64_t)light_depth16_bytes(l)), light_depth16_bytes(l) / (double)l->stored_bytes);
    print_smoke(to, &l->smoke);
}

void report_print(FILE *to, const bake_options *o, const bake_report *r)
{
    char a[32], b[32], c[32], plain[PLAIN_BYTES];
    fprintf(to, "scene        %s\n", plain_text(plain, o->scene_path));
    report_print_casters(to, r);
    plan_print_decisions(to, r->plan, o, r);
    for (uint32_t n = 0; n < r->light_count; n++) print_light(to, &r->lights[n]);
    squares_print(to, o, r);
    for (size_t n = 0; n < r->left_out_count; n++) {
        char name[VXS_LIGHT_NAME_BYTES];
        fprintf(to, "left out     light %s: %s\n", one_line(strcpy(name, r->left_out[n].name)), r->left_out[n].why);
    }
    fprintf(to, "%-12s %10s %14s %12s\n", "stage", "time", "peak memory", "planned");
    for (int s = 0; s < STAGE_COUNT; s++)
        fprintf(to, "%-12s %7.1f ms %14s %9.1f ms\n", bake_stage_name((bake_stage)s), 1e3 * r->stage[s].seconds,
                size_text(a, r->stage[s].peak_bytes), 1e3 * r->plan->seconds[s]);
    fprintf(to, "%-12s %7.1f ms %14s %9.1f ms, %s; a file of %s\n", "total", 1e3 * r->total_seconds, size_text(a, r->peak_bytes),
            1e3 * r->plan->total_seconds, size_text(b, r->plan->peak_bytes), size_text(c, r->plan->file_bytes));
    if (o->page_path) fprintf(to, "%-12s %7.1f ms    not part of the total: for --report\n", "pictures", 1e3 * r->picture_seconds);
    fprintf(to, "drawn by     %s%s%s\n", r->renderer, r->cpu_class[0] ? ", processors of class " : "", r->cpu_class);
    if (o->points) fprintf(to, "points       %u, %s\n", o->points, size_text(a, r->points_bytes));
    plan_print_savings(to, r->plan, r->file_bytes);
    fprintf(to, "wrote        %s, %s\n", o->output_path ? plain_text(plain, o->output_path) : "baked shadows",
            size_text(a, r->file_bytes));
}

/* for machines ---------------------------------------------------------------------------------------------------------------- */

/* Statistics of a coding: what it found, and what it kept. */
static json_t *coded_json(const light_report *l)
{
    const palette_counts *p = &l->palette;
    if (l->light.coding == VXS_CODING_DAG)
        return json_pack("{s:I, s:I, s:I}", "mask_runs", (json_int_t)l->mask_runs, "inserted_nodes", (json_int_t)l->inserted_nodes,
                         "inserted_masks", (json_int_t)l->inserted_masks);
    return json_pack("{s:{s:I, s:I, s:I, s:I, s:I, s:I}}", "palette_blocks", "pages", (json_int_t)p->pages, "nodes",
                     (json_int_t)p->nodes, "blocks", (json_int_t)p->blocks, "tiles", (json_int_t)p->tiles, "private_tiles",
                     (json_int_t)p->private_tiles, "patterns", (json_int_t)p->patterns);
}

static json_t *light_json(const light_report *l)
{
    double  texels = light_texels(l);
    json_t *parts  = json_array();
    for (const part_report *p = l->parts; p < l->parts + l->part_count; p++)
        json_array_append_new(parts, json_pack("{s:s, s:I, s:I, s:I, s:I}", "kind", p->part.kind, "side_voxels",
                                               (json_int_t)p->part.side_voxels, "count", (json_int_t)p->part.count, "memory_bytes",
                                               (json_int_t)p->part.memory_bytes, "stored_bytes", (json_int_t)p->stored_bytes));
    json_t *o = json_pack("{s:o, s:s, s:I, s:i, s:f, s:o, s:f, s:[f,f,f], s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:o}",
                          "name", json_text(l->light.name), "kind",
                          l->light.kind == VXS_LIGHT_KIND_DIRECTIONAL ? "directional"
                          : l->light.kind == VXS_LIGHT_KIND_SPOT      ? "spot"
                                                                      : "point",
                          "resolution_px", (json_int_t)1 << l->light.levels, "maps", (int)vxs_map_count(&l->light), "texel_m",
                          l->light.texel_metres, "texel_at_casters_m", texels_json(&l->texels), "voxel_m", l->light.voxel_metres,
                          "direction", l->light.direction_ws[0], l->light.direction_ws[1], l->light.direction_ws[2], "tiles",
                          (json_int_t)l->tiles, "tiles_without_casters", (json_int_t)l->tiles_skipped, "blocks_rendered",
                          (json_int_t)l->depth.blocks_rendered, "blocks_without_casters", (json_int_t)l->depth.blocks_empty,
                          "triangles_drawn", (json_int_t)l->depth.triangles_drawn, "blocks_peeled",
                          (json_int_t)l->depth.blocks_peeled, "blocks_not_peeled", (json_int_t)l->depth.blocks_not_peeled,
                          "peel_passes", (json_int_t)l->depth.peel_passes, "peel_passes_max", (json_int_t)l->depth.peel_passes_max,
                          "mask_tiles", (json_int_t)l->mask_tiles, "levels", parts);
    json_t *coded = coded_json(l);
    json_object_update(o, coded);
    json_decref(coded);
    json_t *size = json_pack("{s:I, s:I, s:f, s:f, s:I}", "memory_bytes", (json_int_t)l->memory_bytes, "stored_bytes",
                             (json_int_t)l->stored_bytes, "memory_bit_per_texel", 8.0 * (double)l->memory_bytes / texels,
                             "stored_bit_per_texel", 8.0 * (double)l->stored_bytes / texels, "depth16_bytes",
                             (json_int_t)light_depth16_bytes(l));
    json_object_set_new(o, "size", size);
    if (l->smoke.curves)
        json_object_set_new(o, "smoke",
                            json_pack("{s:i, s:I, s:I, s:I, s:f, s:{s:i, s:f, s:f}, s:I, s:I}", "side_px", (int)l->smoke.side_px,
                                      "texels", (json_int_t)l->smoke.texels, "curves", (json_int_t)l->smoke.curves, "nodes",
                                      (json_int_t)l->smoke.nodes, "largest_error", l->smoke.largest_error, "lookups", "places",
                                      (int)l->smoke.lookups.places, "rms_error", l->smoke.lookups.rms, "largest_error",
                                      l->smoke.lookups.largest, "memory_bytes", (json_int_t)l->smoke.memory_bytes, "stored_bytes",
                                      (json_int_t)l->smoke.stored_bytes));
    return o;
}

json_t *report_json(const bake_options *o, const bake_report *r, const run_context *m)
{
    json_t *lights = json_array();
    for (uint32_t n = 0; n < r->light_count; n++) json_array_append_new(lights, light_json(&r->lights[n]));

    json_t *stages_json = json_array();
    for (int s = 0; s < STAGE_COUNT; s++)
        json_array_append_new(stages_json, json_pack("{s:s, s:f, s:I}", "name", bake_stage_name((bake_stage)s), "seconds",
                                                     r->stage[s].seconds, "peak_bytes", (json_int_t)r->stage[s].peak_bytes));

    uint64_t memory_bytes = 0;
    for (uint32_t n = 0; n < r->light_count; n++) memory_bytes += r->lights[n].memory_bytes;
    json_t *plan_json =
        json_pack("{s:o, s:o, s:o, s:o, s:{s:f, s:I, s:I, s:I}}", "decisions", plan_decisions_json(r->plan, o, r), "lights",
                  plan_lights_json(r->plan), "estimate", plan_estimate_json(r->plan), "savings", plan_savings_json(r->plan),
                  "actual", "total_seconds", r->total_seconds, "peak_bytes", (json_int_t)r->peak_bytes, "file_bytes",
                  (json_int_t)r->file_bytes, "memory_bytes", (json_int_t)memory_bytes);

    json_t *root = json_pack("{s:s, s:o, s:o, s:b, s:o, s:s, s:s, s:I, s:o, s:o, s:o, s:o, s:o, s:o, s:f, s:I}", "vxs", VXS_VERSION,
                             "scene", json_text(o->scene_path), "output", json_text(o->output_path), "unchanged", 0, "options",
                             bake_options_json(o), "renderer", r->renderer, "cpu_class", r->cpu_class, "file_bytes",
                             (json_int_t)r->file_bytes, "casters", report_casters_json(r), "lights", lights, "lights_left_out",
                             report_left_out_json(r), "warnings", report_warnings_json(m), "stages", stages_json, "plan", plan_json,
                             "total_seconds", r->total_seconds, "peak_bytes", (json_int_t)r->peak_bytes);
    square_counts squares = report_squares(r);
    if (o->resume_path)
        json_object_set_new(root, "squares",
                            json_pack("{s:o, s:I, s:I}", "folder", json_text(o->resume_path), "made", (json_int_t)squares.made,
                                      "found", (json_int_t)(squares.all - squares.made)));
    if (o->points)
        json_object_set_new(root, "points",
                            json_pack("{s:I, s:I}", "count", (json_int_t)o->points, "stored_bytes", (json_int_t)r->points_bytes));
    return root;
}

vxs_result report_write_json(const char *path, const bake_options *o, const bake_report *r, run_context *m)
{
    return json_write(path, report_json(o, r, m), m);
}
