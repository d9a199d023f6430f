/* intervals: how long exact lit intervals of eye rays take, beside marches of the same rays by single lookups.
 *
 *     intervals --file FILE [--file FILE]... [--eyes N] [--metres M] [--afar M] [--runs R] [--json FILE]
 *
 * Eyes stand 2 m in front of random places where the first light of a file ends (--afar: so many metres), and look level, each at a
 * picture of
 * 32 x 32 rays with a field of view of 60 degrees, --metres long. All files are queried in turns, --runs times; the median counts.
 * Standard output says of each file how long a ray takes by intervals, how many it has, and what marches of 64 and 256 lookups
 * take.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "baker/base/clock.h"
#include "baker/base/random.h"
#include "baker/base/spread.h"
#include "baker/base/vec3.h"
#include "baker/command/options/options.h"
#include "baker/files/json_file.h"
#include "runtime/vxs_query.h"

enum { SIDE_PX = 32, ABOVE_METRES = 2, WAYS = 3, RUNS_MAX = 99 };

static const int march_samples[WAYS] = {0, 64, 256}; /* 0: intervals */

typedef struct intervals_options {
    text_list   paths;
    const char *json_path;
    uint32_t    eyes, metres, afar, runs;
} intervals_options;

/* A file, its rays, and what they took. */
typedef struct asked {
    vxs_asset *asset;
    vxs_ray   *rays;
    double     lit[WAYS], intervals; /* metres of a ray, and how many */
    double     us[WAYS][RUNS_MAX];
} asked;

static size_t ray_count(const intervals_options *o)
{
    return (size_t)o->eyes * SIDE_PX * SIDE_PX;
}

static double unit(rng *r)
{
    return rng_u32(r) / 4294967296.0;
}

/* In front of where light ends in some texel. */
static void place_eye(const vxs_baked_light *l, rng *r, double metres, double eye_ws[3])
{
    int32_t side = (int32_t)1 << l->light.levels, i, j, depth, map = 0;
    do {
        map   = (int32_t)rng_below(r, vxs_map_count(&l->light));
        i     = (int32_t)rng_below(r, (uint32_t)side);
        j     = (int32_t)rng_below(r, (uint32_t)side);
        depth = vxs_first_shadow(l, map, i, j, NULL);
    } while (depth == side || depth == 0);
    double at[3] = {i + 0.5, j + 0.5, depth};
    vxs_point(&l->light, map, at, eye_ws);
    eye_ws[1] += metres;
}

static void look_around(const vxs_baked_light *l, rng *r, const intervals_options *o, vxs_ray *rays)
{
    double eye_ws[3], turn = 6.283185307179586 * unit(r), forward[3] = {cos(turn), 0, sin(turn)},
                      right[3] = {-sin(turn), 0, cos(turn)};
    double up[3] = {0, 1, 0}, edge = tan(3.14159265358979 / 6);
    if (o->afar) { /* and down */
        forward[1] = -1;
        vec3_unit(forward, forward);
        vec3_cross(right, forward, up);
    }
    place_eye(l, r, o->afar ? o->afar : ABOVE_METRES, eye_ws);
    for (int y = 0; y < SIDE_PX; y++)
        for (int x = 0; x < SIDE_PX; x++, rays++) {
            double u = edge * ((x + 0.5) / SIDE_PX * 2 - 1), v = edge * ((y + 0.5) / SIDE_PX * 2 - 1);
            *rays = (vxs_ray){.t_end = o->metres};
            for (int n = 0; n < 3; n++) {
                rays->origin_ws[n]    = eye_ws[n];
                rays->direction_ws[n] = forward[n] + u * right[n] - v * up[n];
            }
            vec3_unit(rays->direction_ws, rays->direction_ws);
        }
}

static double lit_by_intervals(const vxs_baked_light *l, const vxs_ray *ray, size_t *count)
{
    vxs_lit_walk walk;
    vxs_interval found[16];
    double       lit = 0;
    size_t       some;
    if (vxs_lit_begin(&walk, l, ray) != VXS_OK) return 0;
    do {
        some = vxs_lit_next(&walk, found, 16);
        for (size_t n = 0; n < some; n++) lit += found[n].state == VXS_INTERVAL_LIT ? found[n].t_end - found[n].t_begin : 0;
        *count += some;
    } while (some == 16);
    return lit;
}

static double lit_by_march(const vxs_baked_light *l, const vxs_ray *ray, int samples)
{
    double lit = 0, step = ray->t_end / samples, p[3];
    for (int n = 0; n < samples; n++) {
        vec3_mad(ray->origin_ws, (n + 0.5) * step, ray->direction_ws, p);
        lit += vxs_lookup(l, p, NULL, vxs_box(1)) == 1 ? step : 0;
    }
    return lit;
}

static void ask(const intervals_options *o, asked *a, int way, uint32_t run)
{
    const vxs_baked_light *l     = vxs_asset_light(a->asset, 0);
    size_t                 count = 0, rays = ray_count(o);
    double                 lit = 0, begun = clock_seconds();
    for (size_t n = 0; n < rays; n++)
        lit += march_samples[way] ? lit_by_march(l, &a->rays[n], march_samples[way]) : lit_by_intervals(l, &a->rays[n], &count);
    a->us[way][run] = (clock_seconds() - begun) * 1e6 / (double)rays;
    a->lit[way]     = lit / (double)rays;
    if (way == 0) a->intervals = (double)count / (double)rays;
}

static vxs_result open_file(const intervals_options *o, const char *path, asked *a, run_context *m)
{
    rng        r = {1};
    vxs_result e = vxs_asset_open_file(&a->asset, path, NULL);
    if (e != VXS_OK) return fail(m, e, "%s: %s", path, vxs_result_text(e));
    a->rays = malloc(ray_count(o) * sizeof *a->rays);
    if (!a->rays) return fail(m, VXS_E_MEMORY, "out of memory");
    for (uint32_t n = 0; n < o->eyes; n++)
        look_around(vxs_asset_light(a->asset, 0), &r, o, a->rays + (size_t)n * SIDE_PX * SIDE_PX);
    return VXS_OK;
}

static json_t *report(const intervals_options *o, const char *path, asked *a)
{
    const vxs_light *light = &vxs_asset_light(a->asset, 0)->light;
    double           us[WAYS];
    for (int way = 0; way < WAYS; way++) us[way] = spread_of(a->us[way], o->runs).median;
    printf("%s: %u x %u texels; %.1f intervals and %.2f lit metres a ray\n", path, 1u << light->levels, 1u << light->levels,
           a->intervals, a->lit[0]);
    printf("    intervals %6.2f us a ray; marches of 64 %6.2f, of 256 %6.2f (%.2f and %.2f lit metres)\n", us[0], us[1], us[2],
           a->lit[1], a->lit[2]);
    return json_pack("{s:s, s:I, s:I, s:f, s:f, s:f, s:f, s:f}", "file", path, "resolution_px", (json_int_t)(1u << light->levels),
                     "rays", (json_int_t)ray_count(o), "intervals", a->intervals, "lit_metres", a->lit[0], "intervals_us", us[0],
                     "march_64_us", us[1], "march_256_us", us[2]);
}

static vxs_result run(const intervals_options *o, run_context *m)
{
    size_t     count = o->paths.count;
    asked     *all   = calloc(count, sizeof *all);
    json_t    *files = json_array();
    vxs_result r     = all && files ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory");
    for (size_t n = 0; n < count && r == VXS_OK; n++) r = open_file(o, o->paths.items[n], &all[n], m);
    for (uint32_t turn = 0; turn < o->runs && r == VXS_OK; turn++)
        for (int way = 0; way < WAYS; way++)
            for (size_t n = 0; n < count; n++) ask(o, &all[n], way, turn);
    for (size_t n = 0; n < count && r == VXS_OK; n++) json_array_append_new(files, report(o, o->paths.items[n], &all[n]));
    if (r == VXS_OK && o->json_path)
        r = json_write(o->json_path, files, m);
    else
        json_decref(files);
    for (size_t n = 0; n < count && all; n++) {
        vxs_asset_close(all[n].asset);
        free(all[n].rays);
    }
    free(all);
    return r;
}

int main(int argc, char **argv)
{
    intervals_options o     = {.eyes = 64, .metres = 100, .runs = 7};
    const option options[]  = {{"--file", OPTION_TEXTS, &o.paths, 0, 0, NULL, "FILE", "file of vxs bake; may be given again", NULL},
                               {"--eyes", OPTION_U32, &o.eyes, 1, 10000, NULL, "N", "pictures of 32 x 32 rays (default 64)", NULL},
                               {"--metres", OPTION_U32, &o.metres, 1, 1000000, NULL, "M", "length of rays (default 100)", NULL},
                               {"--afar", OPTION_U32, &o.afar, 0, 1000000, NULL, "M", "eyes so far above, looking down", NULL},
                               {"--runs", OPTION_U32, &o.runs, 1, RUNS_MAX, NULL, "R", "medians of R runs (default 7)", NULL},
                               {"--json", OPTION_OUTPUT, &o.json_path, 0, 0, ".json", "FILE", "the figures as JSON", NULL}};
    const command_line line = COMMAND_LINE("intervals", "[options]", "Exact lit intervals of rays, and marches.", options);
    run_context        m    = {0};
    int                help_shown;
    vxs_result         r = options_parse(&line, argc, argv, &help_shown, &m);
    if (r == VXS_OK && !help_shown) r = run(&o, &m);
    free(o.paths.items);
    return command_end(&m, r);
}
