/* The page about one bake; see bake_page.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/page/bake_page.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/version.h"
#include "baker/files/output_file.h"
#include "baker/page/html.h"
#include "baker/report/plan_text.h"

enum { LIGHTS_SHOWN = 30 };

static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

static double map_texels(const light_report *l)
{
    return ldexp(vxs_light_map_count(&l->light), 2 * (int)l->light.levels);
}

static void print_cell(FILE *to, const char *text)
{
    fputs("<td class=\"text\">", to);
    html_text(to, text);
    fputs("</td>", to);
}

static void print_count_cell(FILE *to, uint64_t count)
{
    fputs("<td>", to);
    html_count(to, (double)count);
    fputs("</td>", to);
}

static void print_bytes_cell(FILE *to, uint64_t bytes)
{
    fputs("<td>", to);
    html_bytes(to, (double)bytes);
    fputs("</td>", to);
}

/* sums over all lights -------------------------------------------------------------------------------------------------------- */

/* levels[n]: nodes of side 2^n voxels; levels[0]: masks. */
enum { SUM_LEVELS = 32 };

typedef struct sums {
    uint64_t     memory_bytes, stored_bytes, mask_tiles, mask_runs, inserted_nodes, inserted_masks, nodes;
    double       texels;
    level_report levels[SUM_LEVELS];
} sums;

static sums sums_of(const bake_report *r)
{
    sums s = {0};
    for (uint32_t n = 0; n < r->light_count; n++) {
        const light_report *l = &r->lights[n];
        s.memory_bytes += l->memory_bytes;
        s.stored_bytes += l->stored_bytes;
        s.mask_tiles += l->mask_tiles;
        s.mask_runs += l->mask_runs;
        s.inserted_nodes += l->inserted_nodes;
        s.inserted_masks += l->inserted_masks;
        s.texels += map_texels(l);
        for (uint32_t k = 0; k < l->level_count; k++) {
            const level_report *from = &l->level[k];
            level_report       *sum  = &s.levels[from->side_voxels ? log2_u32(from->side_voxels) : 0];
            sum->count += from->count;
            sum->memory_bytes += from->memory_bytes;
            sum->stored_bytes += from->stored_bytes;
            if (from->side_voxels) s.nodes += from->count;
        }
    }
    return s;
}

/* "masks", "8³" */
static const char *level_name(char name[32], int level)
{
    snprintf(name, 32, level ? "%.0f³" : "masks", ldexp(1, level));
    return name;
}

/* Masks stand apart, nodes fade from fine to coarse. */
static void level_colour(char colour[8], int level)
{
    double shade = fmin(1, fmax(0, (level - 3) / 8.0));
    if (level)
        snprintf(colour, 8, "#%02x%02x%02x", (int)(0x24 + shade * 0xa4), (int)(0x54 + shade * 0x84), (int)(0x8c + shade * 0x5c));
    else
        strcpy(colour, "#d0702a");
}

/* the answers ----------------------------------------------------------------------------------------------------------------- */

static void print_facts(FILE *to, const bake_report *r, const sums *s)
{
    const bake_plan *plan = r->plan;
    fputs("<div class=\"facts\">\n<div><small>How big?</small><b>", to);
    html_bytes(to, (double)r->file_bytes);
    fputs("</b><small>on disk; planned ", to);
    html_bytes(to, (double)plan->file_bytes);
    fprintf(to, "</small></div>\n<div><small>For a texel?</small><b>%.3g bit</b><small>a 16-bit depth map takes ",
            8 * (double)r->file_bytes / s->texels);
    html_count(to, round(2 * s->texels / (double)r->file_bytes));
    fputs(" times as much", to);
    fputs("</small></div>\n<div><small>When loaded?</small><b>", to);
    html_bytes(to, (double)s->memory_bytes);
    fputs("</b><small>in memory; planned ", to);
    html_bytes(to, (double)plan->memory_bytes);
    fputs("</small></div>\n<div><small>How long?</small><b>", to);
    html_seconds(to, r->total_seconds);
    fputs("</b><small>to bake; planned ", to);
    html_seconds(to, plan->total_seconds);
    fputs("</small></div>\n<div><small>How much memory?</small><b>", to);
    html_bytes(to, (double)r->peak_bytes);
    fputs("</b><small>at the peak; planned ", to);
    html_bytes(to, (double)plan->peak_bytes);
    fputs("</small></div>\n</div>\n", to);
}

/* where the bytes go ---------------------------------------------------------------------------------------------------------- */

static void print_levels(FILE *to, const bake_report *r, const sums *s)
{
    char   name[32], colour[8];
    double file = (double)r->file_bytes, head = file - (double)s->stored_bytes;
    fputs("<div class=\"stack\">", to);
    for (int n = 0; n < SUM_LEVELS; n++) {
        if (!s->levels[n].stored_bytes) continue;
        level_colour(colour, n);
        fprintf(to, "<i style=\"width:%.2f%%;background:%s\"></i>", 100 * (double)s->levels[n].stored_bytes / file, colour);
    }
    fprintf(to, "<i style=\"width:%.2f%%;background:#8d8a80\"></i></div>\n", 100 * head / file);
    fputs("<p class=\"soft\">The file from its finest level to its coarsest. Masks say of 8 x 8 texels at one depth which are "
          "dark; nodes of n³ voxels say where which masks and smaller nodes lie. Equal ones are stored once.</p>\n"
          "<div class=\"table\"><table>\n<thead><tr><th class=\"text\">level</th><th>count</th><th>on disk</th>"
          "<th class=\"text\">share of the file</th><th></th><th>in memory</th></tr></thead>\n<tbody>\n",
          to);
    for (int n = 0; n < SUM_LEVELS; n++) {
        const level_report *l = &s->levels[n];
        if (!l->count) continue;
        level_colour(colour, n);
        fprintf(to, "<tr><td class=\"text\">%s</td>", level_name(name, n));
        print_count_cell(to, l->count);
        print_bytes_cell(to, l->stored_bytes);
        fprintf(to, "<td class=\"bar\"><i style=\"width:%.1f%%;background:%s\"></i></td><td>", 100 * (double)l->stored_bytes / file,
                colour);
        html_percent(to, (double)l->stored_bytes / file);
        fputs("</td>", to);
        print_bytes_cell(to, l->memory_bytes);
        fputs("</tr>\n", to);
    }
    fputs("<tr><td class=\"text\">head</td><td></td>", to);
    print_bytes_cell(to, (uint64_t)fmax(0, head));
    fprintf(to, "<td class=\"bar\"><i style=\"width:%.1f%%;background:#8d8a80\"></i></td><td>", 100 * head / file);
    html_percent(to, head / file);
    fputs("</td><td></td></tr>\n</tbody></table></div>\n<p>", to);
    html_count(to, (double)s->mask_tiles);
    fputs(" of ", to);
    html_count(to, s->texels / 64);
    fputs(" tiles of 8 x 8 texels need masks, because no single depth parts them into light and shadow; they need ", to);
    html_count(to, (double)s->mask_runs);
    fputs(", of which ", to);
    html_count(to, s->levels[0].count);
    fputs(" differ and are stored. Of ", to);
    html_count(to, (double)s->inserted_nodes);
    fputs(" nodes ", to);
    html_count(to, (double)s->nodes);
    fputs(" are left.</p>\n", to);
}

static const char *kind_of(const vxs_light *l)
{
    return l->kind == VXS_LIGHT_KIND_DIRECTIONAL ? "sun" : l->kind == VXS_LIGHT_KIND_SPOT ? "spot" : "point";
}

static int by_stored_bytes(const void *a, const void *b)
{
    const light_report *p = *(const light_report *const *)a, *q = *(const light_report *const *)b;
    if (p->stored_bytes != q->stored_bytes) return p->stored_bytes < q->stored_bytes ? 1 : -1;
    return (p > q) - (p < q);
}

static vxs_result print_lights(FILE *to, const bake_report *r, message *m)
{
    const light_report **sorted = calloc(r->light_count + 1, sizeof *sorted);
    if (!sorted) return fail(m, VXS_E_MEMORY, "out of memory for %u lights", r->light_count);
    for (uint32_t n = 0; n < r->light_count; n++) sorted[n] = &r->lights[n];
    qsort(sorted, r->light_count, sizeof *sorted, by_stored_bytes);
    fputs("<h3>By light</h3>\n<div class=\"table\"><table>\n<thead><tr><th class=\"text\">light</th><th "
          "class=\"text\">kind</th><th>maps</th>"
          "<th>texels a side</th><th>of a texel</th><th>on disk</th><th class=\"text\">share of the file</th><th>in memory</th>"
          "<th>bit/texel</th><th>tiles with masks</th><th>masks needed</th></tr></thead>\n<tbody>\n",
          to);
    uint32_t shown = r->light_count > LIGHTS_SHOWN ? LIGHTS_SHOWN : r->light_count;
    for (uint32_t n = 0; n < shown; n++) {
        const light_report *l = sorted[n];
        fputs("<tr>", to);
        print_cell(to, l->light.name);
        print_cell(to, kind_of(&l->light));
        fprintf(to, "<td>%u</td><td>%u</td><td>%.3g m</td>", vxs_light_map_count(&l->light), 1u << l->light.levels,
                l->light.texel_metres);
        print_bytes_cell(to, l->stored_bytes);
        fputs("<td class=\"bar\">", to);
        html_bar(to, (double)l->stored_bytes / (double)r->file_bytes);
        fputs("</td>", to);
        print_bytes_cell(to, l->memory_bytes);
        fprintf(to, "<td>%.3f</td>", 8 * (double)l->stored_bytes / map_texels(l));
        print_count_cell(to, l->mask_tiles);
        print_count_cell(to, l->mask_runs);
        fputs("</tr>\n", to);
    }
    fputs("</tbody></table></div>\n", to);
    if (shown < r->light_count) {
        uint64_t bytes = 0;
        for (uint32_t n = shown; n < r->light_count; n++) bytes += sorted[n]->stored_bytes;
        fprintf(to, "<p class=\"soft\">%u smaller lights take ", r->light_count - shown);
        html_bytes(to, (double)bytes);
        fputs(" together.</p>\n", to);
    }
    free(sorted);
    return VXS_OK;
}

/* pictures -------------------------------------------------------------------------------------------------------------------- */

/* Masks that a tile needs, from few to many; until: of the class, inclusive. */
static const struct {
    uint8_t     until;
    uint8_t     colour[3];
    const char *name;
} mask_classes[] = {{1, {0xf7, 0xd5, 0x7e}, "1"},   {2, {0xf5, 0xb0, 0x41}, "2"},     {4, {0xea, 0x7d, 0x2f}, "3–4"},
                    {8, {0xd1, 0x45, 0x3b}, "5–8"}, {16, {0x9c, 0x1f, 0x5f}, "9–16"}, {64, {0x4c, 0x12, 0x6b}, "17–64"}};

enum { MASK_CLASSES = sizeof mask_classes / sizeof *mask_classes };

/* Depths that nearly all of a map lies between, so that one far thing does not make all else look flat. */
static void depth_range(const uint16_t *depth, size_t count, double *from, double *until)
{
    uint32_t histogram[1024] = {0}, seen = 0, sum = 0;
    for (size_t n = 0; n < count; n++)
        if (depth[n] != PICTURE_NO_CASTER) histogram[depth[n] / 64]++, seen++;
    *from  = 0;
    *until = PICTURE_NO_CASTER;
    for (int n = 0; n < 1024; n++) {
        if (sum <= seen / 200) *from = 64.0 * n;
        if (sum < seen - seen / 200) *until = 64.0 * n + 64;
        sum += histogram[n];
    }
}

/* Depth at a pixel or, beside the map and where there is no caster, at the one that it is compared with. */
static double depth_near(const uint16_t *depth, uint32_t side, int64_t x, int64_t y, double otherwise)
{
    if (x < 0 || y < 0 || x >= side || y >= side) return otherwise;
    uint16_t d = depth[(size_t)y * side + (size_t)x];
    return d == PICTURE_NO_CASTER ? otherwise : d;
}

/* Lightness of each pixel, 0 to 1: near is light, and slopes are lit from the upper left. rise: of a unit of depth, in pixels. */
static void shade(float *light, const uint16_t *depth, uint32_t side, double rise)
{
    double from, until;
    depth_range(depth, (size_t)side * side, &from, &until);
    for (uint32_t y = 0; y < side; y++)
        for (uint32_t x = 0; x < side; x++) {
            double d  = depth[(size_t)y * side + x];
            double gx = (depth_near(depth, side, (int64_t)x + 1, y, d) - depth_near(depth, side, (int64_t)x - 1, y, d)) / 2 * rise;
            double gy = (depth_near(depth, side, x, (int64_t)y + 1, d) - depth_near(depth, side, x, (int64_t)y - 1, d)) / 2 * rise;
            /* the surface looks towards the light of the map: its normal is (gx, gy, 1), shortened */
            double facing               = (0.7 - 0.45 * gx - 0.45 * gy) / sqrt(1 + gx * gx + gy * gy);
            double tone                 = 1 - 0.55 * fmin(1, fmax(0, (d - from) / fmax(1, until - from)));
            light[(size_t)y * side + x] = (float)(tone * fmin(1, fmax(0.15, 0.35 + 0.85 * facing)));
        }
}

static void grey(uint8_t rgba[4], double lightness)
{
    uint8_t level = (uint8_t)(255 * fmin(1, fmax(0, lightness))) & 0xfc; /* fewer levels, smaller pages */
    rgba[0] = rgba[1] = rgba[2] = level;
    rgba[3]                     = 255;
}

static void draw_depths(uint8_t *rgba, const float *light, const uint16_t *depth, uint32_t side)
{
    for (size_t n = 0; n < (size_t)side * side; n++)
        if (depth[n] == PICTURE_NO_CASTER)
            memset(rgba + 4 * n, 0, 4);
        else
            grey(rgba + 4 * n, light[n]);
}

/* Faint shapes, and the colour of its class where a pixel's tiles need masks. */
static void draw_masks(uint8_t *rgba, const float *light, const uint16_t *depth, const light_picture *p, uint32_t map)
{
    const uint8_t *masks = p->masks + (size_t)map * p->mask_px * p->mask_px;
    uint32_t       side = p->side_px, wide = side / p->mask_px;
    for (uint32_t y = 0; y < side; y++)
        for (uint32_t x = 0; x < side; x++) {
            size_t  n    = (size_t)y * side + x;
            uint8_t runs = masks[(size_t)(y / wide) * p->mask_px + x / wide];
            if (!runs && depth[n] == PICTURE_NO_CASTER) {
                memset(rgba + 4 * n, 0, 4);
            } else if (!runs) {
                grey(rgba + 4 * n, 0.62 + 0.3 * light[n]);
            } else {
                int class = 0;
                while (runs > mask_classes[class].until) class ++;
                memcpy(rgba + 4 * n, mask_classes[class].colour, 3);
                rgba[4 * n + 3] = 255;
            }
        }
}

static void begin_figure(FILE *to, const char *what, const light_picture *p, uint32_t map)
{
    static const char *const ways[] = {"along x", "against x", "along y", "against y", "along z", "against z"};
    fprintf(to, "<figure><h3>%s", what);
    if (p->map_count > 1) fprintf(to, ", map %u of 6, %s", map + 1, ways[map]);
    fputs("</h3>\n", to);
}

static vxs_result print_map(FILE *to, const light_picture *p, const vxs_light *light, uint32_t map, message *m)
{
    uint32_t        side   = p->side_px;
    size_t          count  = (size_t)side * side;
    const uint16_t *depth  = p->depth + map * count;
    float          *shades = malloc(count * sizeof *shades);
    uint8_t        *rgba   = malloc(4 * count);
    vxs_result r = shades && rgba ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for a picture of %u x %u pixels", side, side);
    if (r == VXS_OK) {
        double texels = (double)p->map_px / side, voxels = (double)p->map_px / PICTURE_NO_CASTER;
        shade(shades, depth, side, voxels * light->voxel_metres / (texels * light->texel_metres));
        draw_depths(rgba, shades, depth, side);
        begin_figure(to, "Depths", p, map);
        r = html_png(to, rgba, side, side, 4, "depth map, near surfaces light", m);
        fputs("</figure>\n", to);
    }
    if (r == VXS_OK) {
        draw_masks(rgba, shades, depth, p, map);
        begin_figure(to, "Masks", p, map);
        r = html_png(to, rgba, side, side, 4, "the same place: how many masks its tiles need", m);
        fputs("</figure>\n", to);
    }
    free(rgba);
    free(shades);
    return r;
}

static void print_mask_key(FILE *to)
{
    fputs("<div class=\"key\"><span>masks that an 8 x 8 tile needs:</span>", to);
    for (int n = 0; n < MASK_CLASSES; n++)
        fprintf(to, "<span><i style=\"background:#%02x%02x%02x\"></i>%s</span>", mask_classes[n].colour[0],
                mask_classes[n].colour[1], mask_classes[n].colour[2], mask_classes[n].name);
    fputs("<span><i style=\"background:#c9c9c9\"></i>none</span></div>\n", to);
}

static vxs_result print_picture(FILE *to, const light_picture *p, const bake_report *r, message *m)
{
    const light_report *l      = &r->lights[p->light];
    vxs_result          result = VXS_OK;
    fputs("<h3>", to);
    html_text(to, l->light.name);
    fprintf(to, ": %u map%s of %u x %u texels, ", p->map_count, p->map_count > 1 ? "s" : "", p->map_px, p->map_px);
    html_bytes(to, (double)l->stored_bytes);
    fputs("</h3>\n<div class=\"pairs\">\n", to);
    for (uint32_t map = 0; map < p->map_count && result == VXS_OK; map++) result = print_map(to, p, &l->light, map, m);
    fputs("</div>\n", to);
    if (p->mask_tiles > 1)
        fprintf(to, "<p class=\"soft\">A pixel stands for %u tiles: the one that needs most of them counts.</p>\n", p->mask_tiles);
    return result;
}

static vxs_result print_pictures(FILE *to, const bake_report *r, message *m)
{
    vxs_result result             = VXS_OK;
    int        done[PICTURES_MAX] = {0};
    fputs(
        "<h2>What the light sees, and where it takes masks</h2>\n"
        "<p>On the left the map's depths, as the light sees them: near is light, no caster is blank. On the right the same place, "
        "coloured where shadows take masks: there, and in the nodes above them, the bytes go. Edges of shadows, leaves, grass and "
        "wires show; so do sheets, whose every slope is an edge.</p>\n",
        to);
    print_mask_key(to);
    for (uint32_t k = 0; k < r->picture_count && result == VXS_OK; k++) {
        uint32_t next = 0;
        while (done[next]) next++;
        for (uint32_t n = next + 1; n < r->picture_count; n++)
            if (!done[n] && r->lights[r->pictures[n].light].stored_bytes > r->lights[r->pictures[next].light].stored_bytes)
                next = n;
        done[next] = 1;
        result     = print_picture(to, &r->pictures[next], r, m);
    }
    if (r->picture_count < r->light_count)
        fprintf(to, "<p class=\"soft\">%u more lights are not pictured.</p>\n", r->light_count - r->picture_count);
    return result;
}

/* what would make it smaller -------------------------------------------------------------------------------------------------- */

static void print_sheet_hint(FILE *to, const bake_report *r)
{
    const casters *c      = &r->casters;
    int            reason = COMPONENT_SOLID + 1;
    size_t         sheets = c->triangle_count - c->solid_triangle_count;
    for (int kind = COMPONENT_SOLID + 1; kind < COMPONENT_KINDS; kind++)
        if (c->triangles_of_kind[kind] > c->triangles_of_kind[reason]) reason = kind;
    if (sheets * 20 < c->triangle_count) return;
    fputs("<li>", to);
    html_percent(to, (double)sheets / (double)c->triangle_count);
    fputs(
        " of the triangles are sheets. Only solids have an inside that nobody asks about, where the builder is free to choose what "
        "repeats. Most of these, ",
        to);
    html_count(to, (double)c->triangles_of_kind[reason]);
    html_textf(to, ", are %s", component_kind_name((component_kind)reason));
    fputs(": <code>vxs health</code> names them, and <code>vxs mend</code> closes what can be closed.</li>\n", to);
}

static void print_hints(FILE *to, const bake_options *o, const bake_report *r)
{
    uint32_t side = 8, largest = 0;
    for (uint32_t n = 0; n < r->light_count; n++) {
        if (1u << r->lights[n].light.levels > side) side = 1u << r->lights[n].light.levels;
        if (r->lights[n].stored_bytes > r->lights[largest].stored_bytes) largest = n;
    }
    fputs("<h2>What would make it smaller</h2>\n<ul>\n", to);
    if (o->closed == CLOSED_OFF)
        fputs("<li><code>--closed off</code> makes a sheet of every solid; without it they are told apart.</li>\n", to);
    else
        print_sheet_hint(to, r);
    if (o->rule == MASK_RULE_SHADOW) fputs("<li><code>--rule greedy</code> takes the fewest masks.</li>\n", to);
    if (!o->reuse) fputs("<li><code>--reuse on</code> does not make again what equals its neighbour.</li>\n", to);
    if (o->stop != STOP_FINAL) fputs("<li><code>--stop final</code> merges what is equal.</li>\n", to);
    if (o->exit == EXIT_BACK) fputs("<li><code>--exit auto</code> looks for the exit of the union where solids meet.</li>\n", to);
    if (r->light_count > 1) {
        fputs("<li>The largest light, ", to);
        html_text(to, r->lights[largest].light.name);
        fputs(", takes ", to);
        html_percent(to, (double)r->lights[largest].stored_bytes / (double)r->file_bytes);
        fputs(" of the file. A narrower cone or a shorter range reaches fewer casters.</li>\n", to);
    }
    if (!o->region_given)
        fputs("<li><code>--region</code> bakes only the box that will be looked up; all of the scene still casts into it.</li>\n",
              to);
    if (side > 8)
        fprintf(to,
                "<li>Half the resolution, <code>--resolution %u</code>: shadows end in lines and surfaces, so a file is often "
                "about half as large then. <code>vxs plan</code> estimates it.</li>\n",
                side / 2);
    if (o->zstd_level < 19) fputs("<li><code>--level 19</code> compresses harder, and takes longer to write.</li>\n", to);
    fputs("</ul>\n", to);
}

/* time, plan, casters --------------------------------------------------------------------------------------------------------- */

static void print_stages(FILE *to, const bake_report *r)
{
    double most = 0;
    for (int s = 0; s < STAGE_COUNT; s++) most = fmax(most, fmax(r->stage[s].seconds, r->plan->seconds[s]));
    fputs("<h2>Where the time goes</h2>\n<p class=\"soft\">Broad bars are what it took, narrow ones what was planned.</p>\n"
          "<div class=\"table\"><table>\n<thead><tr><th class=\"text\">stage</th><th>took</th><th>planned</th><th></th>"
          "<th>peak memory</th></tr></thead>\n<tbody>\n",
          to);
    for (int s = 0; s < STAGE_COUNT; s++) {
        fprintf(to, "<tr><td class=\"text\">%s</td><td>", bake_stage_name((bake_stage)s));
        html_seconds(to, r->stage[s].seconds);
        fputs("</td><td>", to);
        html_seconds(to, r->plan->seconds[s]);
        fprintf(to, "</td><td class=\"bar\"><i style=\"width:%.1f%%\"></i><u style=\"width:%.1f%%\"></u></td>",
                most > 0 ? 100 * r->stage[s].seconds / most : 0, most > 0 ? 100 * r->plan->seconds[s] / most : 0);
        print_bytes_cell(to, r->stage[s].peak_bytes);
        fputs("</tr>\n", to);
    }
    fputs("</tbody>\n<tfoot><tr><td class=\"text\">total</td><td>", to);
    html_seconds(to, r->total_seconds);
    fputs("</td><td>", to);
    html_seconds(to, r->plan->total_seconds);
    fputs("</td><td></td>", to);
    print_bytes_cell(to, r->peak_bytes);
    fputs("</tr></tfoot></table></div>\n<p class=\"soft\">OpenGL by ", to);
    html_text(to, r->renderer);
    fputs(".</p>\n", to);
}

static void print_decisions(FILE *to, const bake_options *o, const bake_report *r)
{
    plan_decision decisions[PLAN_DECISIONS_MAX];
    size_t        count = plan_decisions(r->plan, o, r, decisions);
    fputs("<h2>What was decided, and why</h2>\n<div class=\"table\"><table>\n<tbody>\n", to);
    for (size_t n = 0; n < count; n++) {
        fputs("<tr>", to);
        print_cell(to, decisions[n].name);
        print_cell(to, decisions[n].choice);
        fputs("<td class=\"long\">", to);
        html_text(to, decisions[n].reason);
        fputs("</td></tr>\n", to);
    }
    fputs("</tbody></table></div>\n", to);
}

static void print_casters(FILE *to, const bake_report *r)
{
    const casters *c = &r->casters;
    fputs(
        "<h2>What casts shadows</h2>\n<div class=\"table\"><table>\n<thead><tr><th class=\"text\">components</th><th>how many</th>"
        "<th>triangles</th><th></th></tr></thead>\n<tbody>\n",
        to);
    for (int kind = COMPONENT_SOLID; kind < COMPONENT_KINDS; kind++) {
        size_t triangles = kind == COMPONENT_SOLID ? c->solid_triangle_count : c->triangles_of_kind[kind];
        if (!c->component_count[kind]) continue;
        fputs("<tr><td class=\"text\">", to);
        html_textf(to, kind == COMPONENT_SOLID ? "solids" : "sheets: %s", component_kind_name((component_kind)kind));
        fputs("</td>", to);
        print_count_cell(to, c->component_count[kind]);
        print_count_cell(to, triangles);
        fputs("<td class=\"bar\">", to);
        html_bar(to, c->triangle_count ? (double)triangles / (double)c->triangle_count : 0);
        fputs("</td></tr>\n", to);
    }
    fprintf(to, "</tbody></table></div>\n<p class=\"soft\">They fill %.4g x %.4g x %.4g m.</p>\n",
            r->casters_max_ws[0] - r->casters_min_ws[0], r->casters_max_ws[1] - r->casters_min_ws[1],
            r->casters_max_ws[2] - r->casters_min_ws[2]);
}

static void print_left_out(FILE *to, const bake_report *r, const message *m)
{
    if (r->left_out_count) fputs("<h2>Lights left out</h2>\n<ul>\n", to);
    for (size_t n = 0; n < r->left_out_count && n < LIGHTS_SHOWN; n++) {
        fputs("<li>", to);
        html_text(to, r->left_out[n].name);
        fputs(": ", to);
        html_text(to, r->left_out[n].why);
        fputs("</li>\n", to);
    }
    if (r->left_out_count > LIGHTS_SHOWN) fprintf(to, "<li>and %zu more</li>\n", r->left_out_count - LIGHTS_SHOWN);
    if (r->left_out_count) fputs("</ul>\n", to);
    if (m->warning_count) fputs("<h2>Warnings</h2>\n<ul>\n", to);
    for (size_t n = 0; n < m->warning_count; n++) {
        fputs("<li>", to);
        html_text(to, m->warnings[n]);
        fputs("</li>\n", to);
    }
    if (m->warning_count) fputs("</ul>\n", to);
}

/* all ------------------------------------------------------------------------------------------------------------------------- */

static vxs_result print_page(FILE *to, const bake_options *o, const bake_report *r, message *m)
{
    const sums s = sums_of(r);
    vxs_result result;
    char       title[256];
    snprintf(title, sizeof title, "%.200s: its bake", base_name(o->scene_path));
    html_begin(to, title);
    fputs("<h1>The shadows of ", to);
    html_text(to, base_name(o->scene_path));
    fputs("</h1>\n<p class=\"soft\">", to);
    html_count(to, (double)r->casters.triangle_count);
    fprintf(to, " triangles and %u light%s, baked to ", r->light_count, r->light_count > 1 ? "s" : "");
    html_text(to, strcmp(o->output_path, "-") ? base_name(o->output_path) : "standard output");
    fprintf(to, " by vxs %s on %u thread%s.</p>\n", VXS_VERSION, o->threads, o->threads > 1 ? "s" : "");
    print_facts(to, r, &s);
    fputs("<h2>Where the bytes go</h2>\n", to);
    print_levels(to, r, &s);
    if ((result = print_lights(to, r, m)) != VXS_OK) return result;
    if ((result = print_pictures(to, r, m)) != VXS_OK) return result;
    print_hints(to, o, r);
    print_stages(to, r);
    print_decisions(to, o, r);
    print_casters(to, r);
    print_left_out(to, r, m);
    html_end(to);
    return VXS_OK;
}

vxs_result bake_page_write(const char *path, const bake_options *o, const bake_report *r, message *m)
{
    output_file out    = {0};
    vxs_result  result = output_file_open(&out, path, m);
    if (result == VXS_OK) result = print_page(out.stream, o, r, m);
    if (result == VXS_OK) result = output_file_commit(&out, m);
    output_file_abort(&out);
    return result;
}
