/* cracks: how much light falls between sheets that meet.
 *
 *     cracks [--millions N] [--resolution N] [--split on|off] [--maps all|gl|sparse] [--seed N]
 *     cracks --scene FILE [--resolution N] [--split on|off] [--maps all|gl|sparse]
 *
 * Panels (tests/columns/panels.h) without gaps and with gaps of 1e-7 to 1e-5 m, in the light of a sun, a spot and a point light,
 * from both sources, until N million columns of each source were looked at. The exit status is 1 where one leaks that no gap
 * explains.
 *
 * Of a scene, under two suns: columns that are far deeper than all eight around them, and what the triangles of the file say there
 * in doubles, before anything is joined or snapped. Where they cover the texel's centre, nothing explains the light; where they
 * leave it free, but cover all that is a 64th of a texel away, it falls through a hairline, which may be a gap or rounding.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>
#include <stdlib.h>

#include "baker/base/parallel.h"
#include "baker/command/options/options.h"
#include "tests/columns/panels.h"
#include "tests/gl_choice.h"

static const double gaps_metres[] = {0, 1e-7, 3e-7, 1e-6, 3e-6, 1e-5};
enum { GAPS = sizeof gaps_metres / sizeof *gaps_metres, KINDS = LIGHT_POINT + 1, SOURCES = 2 };

static const char *const source_names[SOURCES] = {"gl", "sparse"};

typedef struct counted {
    leak_counts of[SOURCES][KINDS][GAPS];
} counted;

static leak_counts sum_of(const counted *c, uint32_t source)
{
    leak_counts sum = {0};
    for (int n = 0; n < KINDS * GAPS; n++) {
        const leak_counts *one = &c->of[source][n / GAPS][n % GAPS];
        sum.columns += one->columns;
        sum.in_gaps += one->in_gaps;
        sum.beside_gaps += one->beside_gaps;
        sum.unexplained += one->unexplained;
    }
    return sum;
}

static void print_counts(const counted *c)
{
    printf("%-7s %-12s %8s %12s %10s %12s %12s\n", "maps", "light", "gap (m)", "columns", "in gaps", "beside gaps", "unexplained");
    for (int s = 0; s < SOURCES; s++)
        for (int n = 0; n < KINDS * GAPS; n++) {
            const leak_counts *one = &c->of[s][n / GAPS][n % GAPS];
            if (one->columns)
                printf("%-7s %-12s %8.0e %12llu %10llu %12llu %12llu\n", source_names[s], light_kind_name((light_kind)(n / GAPS)),
                       gaps_metres[n % GAPS], (unsigned long long)one->columns, (unsigned long long)one->in_gaps,
                       (unsigned long long)one->beside_gaps, (unsigned long long)one->unexplained);
        }
    for (uint32_t s = 0; s < SOURCES; s++) {
        leak_counts sum = sum_of(c, s);
        if (sum.columns)
            printf("%-7s %-12s %8s %12llu %10llu %12llu %12llu\n", source_names[s], "all", "", (unsigned long long)sum.columns,
                   (unsigned long long)sum.in_gaps, (unsigned long long)sum.beside_gaps, (unsigned long long)sum.unexplained);
    }
}

/* --- scenes ------------------------------------------------------------------------------------------------------------ */

static const double suns[][3] = {{0.3, -1, 0.2}, {-0.4, -1, -0.25}};
enum { SUNS = sizeof suns / sizeof *suns, DEEPER_VX = 8 };

/* Whether an opaque triangle of a projection lies before a depth, at a point of the map. */
static int is_covered(const projection *p, double u, double v, double depth)
{
    for (size_t t = 0; t < p->holed_first; t++) {
        const vertex_ls *a = &p->vertices[p->indices[3 * t]], *b = &p->vertices[p->indices[3 * t + 1]],
                        *c = &p->vertices[p->indices[3 * t + 2]];
        if (fmax(a->u, fmax(b->u, c->u)) < u || fmin(a->u, fmin(b->u, c->u)) > u || fmax(a->v, fmax(b->v, c->v)) < v ||
            fmin(a->v, fmin(b->v, c->v)) > v)
            continue;
        double wa = (b->u - u) * (c->v - v) - (c->u - u) * (b->v - v), wb = (c->u - u) * (a->v - v) - (a->u - u) * (c->v - v),
               wc = (a->u - u) * (b->v - v) - (b->u - u) * (a->v - v), area = wa + wb + wc;
        if (area == 0 || fmin(wa / area, fmin(wb / area, wc / area)) < 0) continue;
        if ((wa * a->z + wb * b->z + wc * c->z) / area < depth) return 1;
    }
    return 0;
}

typedef struct deep_counts {
    uint64_t columns, deeper, hairlines, unexplained;
} deep_counts;

/* What the triangles say of a column that is deeper than those around it. */
static void judge_deep(deep_counts *n, const projection *p, double u, double v, double depth)
{
    int around = 1;
    n->deeper++;
    for (int k = 0; k < 9 && around; k++)
        if (k != 4) around = is_covered(p, u + (k % 3 - 1) / 64.0, v + (k / 3 - 1) / 64.0, depth);
    if (!around) return;
    if (is_covered(p, u, v, depth))
        n->unexplained++;
    else
        n->hairlines++;
}

static void judge_map(deep_counts *n, const projection *p, const uint32_t *e, uint32_t side)
{
    for (uint32_t v = 1; v + 1 < side; v++)
        for (uint32_t u = 1; u + 1 < side; u++) {
            const uint32_t *at     = &e[(size_t)v * side + u];
            uint32_t        around = 0;
            n->columns += *at < side;
            for (int k = 0; k < 9; k++)
                if (k != 4) around = max_u32(around, at[(k / 3 - 1) * (ptrdiff_t)side + k % 3 - 1]);
            if (*at > around + DEEPER_VX) judge_deep(n, p, u + 0.5, v + 0.5, (*at - 2.0) / side);
        }
}

/* All enter depths of a map.   e  [side^2] */
static vxs_result fetch_depths(uint32_t *e, const column_source *source, bake_context *ctx)
{
    column_map map;
    vxs_result r = source->open(source->data, 0, &map, ctx);
    if (r != VXS_OK) return r;
    uint32_t across = map.side_px / map.fetch_px, level = square_level(map.fetch_px);
    for (uint32_t n = 0; n < across * across && r == VXS_OK; n++) {
        column_square q;
        column_tile   t;
        if ((r = map.fetch(map.data, level, n % across, n / across, &q, ctx)) != VXS_OK) break;
        for (uint32_t k = 0, tiles = q.side_px / 8; k < tiles * tiles && (r = q.tile(q.data, k % tiles, k / tiles, &t)) == VXS_OK;
             k++)
            for (uint32_t row = 0; row < 8; row++)
                memcpy(&e[((size_t)q.v_px + 8 * (k / tiles) + row) * map.side_px + q.u_px + 8 * (k % tiles)], &t.e[8 * row],
                       8 * sizeof *e);
        map.release(map.data, &q);
    }
    map.close(map.data);
    return r;
}

/* A scene under one sun.
 * whole  its casters as the file has them;   made  those that the map is of */
static vxs_result judge_sun(deep_counts *n, gl_context *gl, const casters *whole, const casters *made, const double sun[3],
                            uint32_t side, bake_context *ctx)
{
    light_shape    shape = {.kind = LIGHT_DIRECTIONAL, .direction_ws = {sun[0], sun[1], sun[2]}};
    light_fit_desc fit   = {.name = "sun", .shape = &shape, .resolution = side};
    uint32_t      *e     = malloc((size_t)side * side * sizeof *e);
    projection     p     = {0};
    vxs_light      light;
    vxs_result     r;
    if (!e) return fail(ctx->run, VXS_E_MEMORY, "out of memory");
    make_unit(shape.direction_ws);
    if ((r = light_fit(&light, made, &fit, ctx->run)) != VXS_OK) goto done;
    rendered_columns rendered = {.device = gl, .casters = made, .light = &light, .tile_px = min_u32(side, TILE_MAX_PX)};
    sparse_columns   sparse   = {.casters = made, .light = &light, .fetch_px = rendered.tile_px};
    column_source    source   = gl ? opengl_columns_source(&rendered) : sparse_columns_source(&sparse);
    r                         = fetch_depths(e, &source, ctx);
    opengl_columns_free(&rendered);
    if (r == VXS_OK && (r = projection_init(&p, whole, &light, 0, ctx->threads, ctx->run)) == VXS_OK) judge_map(n, &p, e, side);
    projection_free(&p);
done:
    free(e);
    return r;
}

static vxs_result judge_scene(const char *path, gl_context *gl, int maps, casters_maker *make, uint32_t side, bake_context *ctx)
{
    run_context *m     = ctx->run;
    scene        s     = {0};
    casters      whole = {0}, made = {0};
    vxs_result   r;
    if ((r = scene_load_gltf(&s, path, NULL, m)) != VXS_OK) goto done;
    if ((r = casters_from_scene(&whole, &s, CLOSED_OFF, ctx->threads, m)) != VXS_OK ||
        (r = make(&made, &s, CLOSED_OFF, ctx->threads, m)) != VXS_OK)
        goto done;
    for (int source = 0; source < SOURCES && r == VXS_OK; source++) {
        deep_counts n = {0};
        for (int sun = 0; sun < SUNS && r == VXS_OK && (!maps || maps == source + 1); sun++)
            r = judge_sun(&n, source ? NULL : gl, &whole, &made, suns[sun], side, ctx);
        if (n.columns)
            printf("%-7s %11llu columns, %6llu far deeper than all around, %5llu through hairlines, %5llu unexplained\n",
                   source_names[source], (unsigned long long)n.columns, (unsigned long long)n.deeper,
                   (unsigned long long)n.hairlines, (unsigned long long)n.unexplained);
        m->wrong |= n.unexplained != 0;
    }
done:
    casters_free(&whole);
    casters_free(&made);
    scene_free(&s);
    return r;
}

int main(int argc, char **argv)
{
    uint32_t     millions = 100, side = 4096, threads = parallel_default_threads(), seed = 0;
    int          splits = 0, maps = 0;
    const char  *scene_path = NULL;
    const option options[]  = {
         {"--scene", OPTION_INPUT, &scene_path, FILE_SCENE, 0, NULL, "FILE", "a scene in place of panels", NULL},
         {"--millions", OPTION_U32, &millions, 1, 1000000, NULL, "N", "of columns, of each source (default 100)", NULL},
         {"--resolution", OPTION_U32, &side, 512, 16384, NULL, "N", "texels a side, a power of two (default 4096)", NULL},
         {"--split", OPTION_CHOICE, &splits, 0, 0, "on|off", NULL, "whether edges are split (default on)", NULL},
         {"--maps", OPTION_CHOICE, &maps, 0, 0, "all|gl|sparse", NULL, "the sources (default all)", NULL},
         {"--seed", OPTION_U32, &seed, 0, UINT32_MAX, NULL, "N", "the first of the scenes (default 0)", NULL},
         {"--threads", OPTION_U32, &threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "threads (default: all)", NULL}};
    const command_line line = COMMAND_LINE("cracks", "[options]", "Light that falls between sheets that meet.", options);
    run_context        m    = {0};
    gl_context        *gl   = NULL;
    counted            c    = {0};
    bake_context       ctx  = {.run = &m};
    int                help_shown;
    vxs_result         r = options_parse(&line, argc, argv, &help_shown, &m);
    if (r != VXS_OK || help_shown) goto done;
    ctx.threads = threads;
    if (side & (side - 1)) {
        r = fail(&m, VXS_E_ARGUMENT, "--resolution %u: expected a power of two", side);
        goto done;
    }
    if ((r = gl_context_create(&gl, gl_choice(), threads, &m)) != VXS_OK) goto done;
    if (scene_path) {
        r = judge_scene(scene_path, gl, maps, splits ? casters_from_scene : casters_for_maps, side, &ctx);
        goto done;
    }
    for (uint32_t s = 0; s < SOURCES && r == VXS_OK; s++)
        for (uint64_t n = seed; r == VXS_OK && (!maps || maps == (int)s + 1) && sum_of(&c, s).columns < 1000000ull * millions; n++)
            r = panels_leaks(&c.of[s][n / GAPS % KINDS][n % GAPS], s ? NULL : gl, n, gaps_metres[n % GAPS],
                             (light_kind)(n / GAPS % KINDS), splits ? casters_from_scene : casters_for_maps, side, &ctx);
    print_counts(&c);
    m.wrong = sum_of(&c, 0).unexplained || sum_of(&c, 1).unexplained;
done:
    if (gl) gl_context_destroy(gl);
    return command_end(&m, r);
}
