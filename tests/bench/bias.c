/* bias: what the bias of lookups with a normal costs and saves. Planes that nothing shades are looked up on both sides, and so is
 * the ground behind walls; for suns, spots and points, with and without a caster that makes voxels deeper than texels are wide.
 *
 *     bias [--stages N] [--points N] [--largest N] [--json FILE]
 *
 * For each kind of light, N planes and N walls are baked in maps of 256 texels a side to --largest and in both codings, and each
 * plane is looked up at --points points with each filter. Printed, and written as JSON (docs/bias.schema.json), for each light and
 * filter:
 *
 *     dark        of points of the plane that the light meets at a cosine of 0.08 or more, the part that is not wholly lit: shadow
 *     acne
 *     lost        the light that they lose, a mean
 *     back        the light that reaches the other side of the plane, a mean
 *     gap         how much of the ground behind a wall's foot is lit, in texels: peter-panning
 *     shift       how far the edge of the wall's shadow is moved into the shadow, in texels
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <jansson.h>

#include "baker/base/version.h"
#include "baker/command/options/options.h"
#include "baker/files/json_file.h"
#include "tests/bench/bias_stage.h"

enum { KINDS = 3, OTHER_CASTERS = 3, FILTERS = 7, STEPS = 400, WALL_SIDE_MIN = 1024 };

static const char *const kind_names[KINDS]                          = {"sun", "spot", "point"};
static const double      other_casters_metres[KINDS][OTHER_CASTERS] = {{0, 60, 600}, {0, 0.03, 0.005}, {0, 0.03, 0.005}};
static const vxs_filter  filters[FILTERS]                           = {{1, 0}, {3, 0}, {9, 0}, {17, 0}, {2, 1}, {9, 1}, {16, 1}};

typedef struct tally {
    double points, dark, lost, back_points, back, walls, gap, shift;
} tally;

static void measure_plane(const bias_setup *o, uint64_t seed, uint32_t points, tally *t)
{
    bias_stage             s     = bias_stage_make(o, seed);
    vxs_asset             *asset = bias_stage_bake(&s, o);
    const vxs_baked_light *baked = vxs_asset_light(asset, 0);
    const double          *up = s.axes_ws[2], down[3] = {-up[0], -up[1], -up[2]};
    rng                    r = rng_split(seed, o->side_px);
    for (uint32_t n = 0; n < points; n++) {
        double p[3];
        bias_draw_point(&s, o, &r, p);
        for (int f = 0; f < FILTERS; f++) {
            double front = (double)vxs_lookup(baked, p, up, filters[f]), back = (double)vxs_lookup(baked, p, down, filters[f]);
            if (front != VXS_OUTSIDE) t[f].points++, t[f].dark += front < 1, t[f].lost += 1 - front;
            if (back != VXS_OUTSIDE) t[f].back_points++, t[f].back += back;
        }
    }
    vxs_asset_close(asset);
}

/* Along axis 0: where the shadow of the wall's top ends, and on which line. */
static void shadow_end(const bias_stage *s, const bias_setup *o, double *x, double *y)
{
    *x = bias_wall_x(o) * BIAS_PUNCTUAL_METRES / (BIAS_PUNCTUAL_METRES - BIAS_WALL_METRES);
    *y = 0;
    if (o->kind != VXS_BAKE_DIRECTIONAL) return;
    double up = vec3_dot(s->to_light_ws, s->axes_ws[2]);
    *x        = -BIAS_WALL_METRES * vec3_dot(s->to_light_ws, s->axes_ws[0]) / up;
    *y        = -BIAS_WALL_METRES * vec3_dot(s->to_light_ws, s->axes_ws[1]) / up;
}

/* The lit length of the ground along axis 0 from x, in metres; the same at slightly different y, for texels have sides. */
static double lit_metres(const bias_stage *s, const vxs_baked_light *baked, vxs_filter filter, double x, double y, double length,
                         rng *r)
{
    double sum = 0;
    for (int n = 0; n < STEPS; n++) {
        double p[3];
        bias_point(s, x + length * (n + rng_unit(r)) / STEPS, y + 0.1 * (rng_unit(r) - 0.5), 0, p);
        sum += (double)vxs_lookup(baked, p, s->axes_ws[2], filter);
    }
    return sum * length / STEPS;
}

static void measure_wall(const bias_setup *o, uint64_t seed, tally *t)
{
    bias_stage             s     = bias_stage_make(o, seed);
    vxs_asset             *asset = bias_stage_bake(&s, o);
    const vxs_baked_light *baked = vxs_asset_light(asset, 0);
    rng                    r     = rng_split(seed, o->side_px);
    double                 foot  = bias_wall_x(o), end, end_y, ends[2][3], texel[2];
    shadow_end(&s, o, &end, &end_y);
    bias_point(&s, foot, 0, 0, ends[0]);
    bias_point(&s, end, end_y, 0, ends[1]);
    for (int n = 0; n < 2; n++) {
        double from_light[3];
        vec3_sub(ends[n], s.light_ws, from_light);
        texel[n] = baked->light.texel_metres * (o->kind == VXS_BAKE_DIRECTIONAL ? 1 : sqrt(vec3_dot(from_light, from_light)));
    }
    double behind = fmin(40 * texel[0], 0.4 * (end - foot)), about = fmin(40 * texel[1], 0.3);
    for (int f = 0; f < FILTERS; f++) {
        t[f].walls++;
        t[f].gap += lit_metres(&s, baked, filters[f], foot, 0, behind, &r) / texel[0];
        t[f].shift += (lit_metres(&s, baked, filters[f], end - about, end_y, 2 * about, &r) - about) / texel[1];
    }
    vxs_asset_close(asset);
}

static void measure(int kind, int other, uint32_t stages, uint32_t points, uint32_t largest_px, tally *t)
{
    for (uint32_t side_px = 256; side_px <= largest_px; side_px *= 4)
        for (int coding = 0; coding < 2; coding++)
            for (uint32_t n = 0; n < stages; n++) {
                bias_setup o = {.kind                = (vxs_bake_light_kind)kind,
                                .other_caster_metres = other_casters_metres[kind][other],
                                .side_px             = side_px,
                                .coding              = coding ? VXS_BAKE_DAG : VXS_BAKE_BLOCKS};
                measure_plane(&o, n, points, t);
                o.wall = 1;
                if (side_px >= WALL_SIDE_MIN) measure_wall(&o, n, t);
            }
}

static void report(json_t *rows, int kind, int other, const tally *t, vxs_filter filter)
{
    double dark = t->dark / t->points, lost = t->lost / t->points, back = t->back / t->back_points;
    double gap = t->gap / t->walls, shift = t->shift / t->walls;
    printf("%-6s %9g m %3d%-7s %10.0f %11.8f %11.8f %9.6f %8.3f %8.3f\n", kind_names[kind], other_casters_metres[kind][other],
           filter.width_px, filter.is_smooth ? " smooth" : "", t->points, dark, lost, back, gap, shift);
    json_array_append_new(rows, json_pack("{s:s, s:f, s:i, s:b, s:I, s:f, s:f, s:f, s:f, s:f}", "light", kind_names[kind],
                                          "other_caster_m", other_casters_metres[kind][other], "filter_px", filter.width_px,
                                          "smooth", filter.is_smooth, "points", (json_int_t)t->points, "dark", dark, "lost", lost,
                                          "back", back, "gap_texels", gap, "shift_texels", shift));
}

int main(int argc, char **argv)
{
    uint32_t     stages = 20, points = 1000, largest_px = 16384;
    const char  *json_path = NULL;
    const option options[] = {
        {"--stages", OPTION_U32, &stages, 1, 100000, NULL, "N", "planes, and walls, of each kind (default 20)", NULL},
        {"--points", OPTION_U32, &points, 1, 100000000, NULL, "N", "of each plane (default 1000)", NULL},
        {"--largest", OPTION_U32, &largest_px, WALL_SIDE_MIN, 16384, NULL, "N", "texels a side of the largest map (default 16384)",
         NULL},
        {"--json", OPTION_OUTPUT, &json_path, 0, 0, ".json", "FILE", "the figures as JSON", NULL}};
    const command_line line = COMMAND_LINE("bias", "[options]", "What the bias of lookups with a normal costs and saves.", options);
    run_context        m    = {0};
    int                help_shown;
    vxs_result         r = options_parse(&line, argc, argv, &help_shown, &m);
    if (r != VXS_OK || help_shown) return command_end(&m, r);

    json_t *rows = json_array();
    printf("%-6s %11s %10s %10s %11s %11s %9s %8s %8s\n", "light", "caster", "filter", "points", "dark", "lost", "back", "gap",
           "shift");
    for (int kind = 0; kind < KINDS; kind++)
        for (int other = 0; other < OTHER_CASTERS; other++) {
            tally t[FILTERS] = {{0}};
            measure(kind, other, stages, points, largest_px, t);
            for (int f = 0; f < FILTERS; f++) report(rows, kind, other, &t[f], filters[f]);
        }
    json_t *root = json_pack("{s:s, s:I, s:I, s:o}", "vxs", VXS_VERSION, "stages", (json_int_t)stages, "points", (json_int_t)points,
                             "rows", rows);
    if (json_path)
        r = json_write(json_path, root, &m);
    else
        json_decref(root);
    return command_end(&m, r);
}
