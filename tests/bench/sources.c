/* sources: where the columns of a map that is rendered and of one straight from triangles differ, and why.
 *
 *     sources SCENE... [--sun X,Y,Z]... [--resolution N]... [--list N] [--json FILE]
 *
 * Every texel's column, in whole voxels, is compared with brute force (tests/columns/brute.h): the sparse source has to lie within
 * it, and is `wrong` where it does not. Where the rendered one is another, something has to explain that:
 *
 *     depth    both depths lie on the same surfaces: they are the same but for rounding, and for what EDGE_PX is worth on a
 *     surface's slope
 *     edge     the texel's centre lies within EDGE_PX of an edge of a triangle, or of a hole's, which is what OpenGL's grid of
 *     1/256 texel may
 *              move it by; and what was rendered is the depth of such a triangle, or of one that surely covers the centre, and not
 *              behind one
 *     tie      light enters at the same surface, and leaves elsewhere: two surfaces are so close together where it leaves first
 *     that they
 *              have swapped places
 *
 * Anything else is unexplained. --list prints so many differing texels of each kind. The exit status is 1 where a texel is wrong or
 * unexplained.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/base/vec3.h"
#include "baker/base/version.h"
#include "baker/columns/sparse/sparse_columns.h"
#include "baker/columns/sparse/sparse_triangles.h"
#include "baker/command/options/options.h"
#include "baker/files/json_file.h"
#include "baker/lab/opengl/depth_gl.h"
#include "baker/light/light_fit.h"
#include "tests/columns/brute.h"
#include "tests/gl_choice.h"

/* What single precision moves corners by is less than the grid, but may be more on the plane of a thin triangle. */
#define EDGE_PX   (1.0 / 256)
#define CORNER_PX (1.0 / 4096)
#define DEPTH_EPS 0x1p-22 /* of the whole depth: what it may be off */

enum { LISTED_MAX = 100 };

static const char *const usual_suns[] = {"0.3,-1,0.2", "-1,-0.25,0.6"};
enum { USUAL_SUNS = sizeof usual_suns / sizeof *usual_suns };

typedef enum why { WHY_UNEXPLAINED, WHY_EDGE, WHY_DEPTH, WHY_TIE, WHYS } why;
static const char *const why_names[WHYS] = {"unexplained", "edge", "depth", "tie"};

/* A texel that differs. */
typedef struct listed {
    uint32_t u, v;
    why      why;
    double   rendered[2], found[2]; /* enter and exit depth, voxels */
} listed;

typedef struct source_counts {
    uint64_t columns, wrong, differ[WHYS];
    size_t   listed_count[WHYS];
    listed   listed[WHYS][LISTED_MAX];
} source_counts;

/* A triangle that a ray meets, surely or perhaps. */
typedef struct near_hit {
    double low, high; /* shares of the whole depth */
    int    sure, solid;
} near_hit;

/* A map that is looked at. */
typedef struct comparison {
    const projection    *p;
    const brute         *b;
    const depth_maps    *maps;
    const column_square *sparse;
    source_counts       *worker; /* [PARALLEL_THREADS_MAX] */
    size_t               listed_max;
} comparison;

/* --- what a ray may meet ------------------------------------------------------------------------------------------------- */

static double distance_to_edge(const vertex_ls *a, const vertex_ls *b, double u, double v)
{
    double du = b->u - a->u, dv = b->v - a->v, length2 = du * du + dv * dv;
    double along = length2 > 0 ? fmin(fmax(((u - a->u) * du + (v - a->v) * dv) / length2, 0), 1) : 0;
    return hypot(u - a->u - along * du, v - a->v - along * dv);
}

/* Shares of the corners at a point. Returns the area, 0 where the triangle is seen from its edge. */
static double shares_of(const vertex_ls *const c[3], double u, double v, double share[3])
{
    double area = (c[1]->u - c[0]->u) * (c[2]->v - c[0]->v) - (c[2]->u - c[0]->u) * (c[1]->v - c[0]->v);
    for (int k = 0; k < 3 && area != 0; k++) {
        const vertex_ls *a = c[(k + 1) % 3], *b = c[(k + 2) % 3];
        share[k] = ((a->u - u) * (b->v - v) - (b->u - u) * (a->v - v)) / area;
    }
    return area;
}

static int is_opaque_at(const projection *p, size_t t, const double share[3])
{
    size_t mask = 0;
    double u = 0, v = 0, q = 0;
    while (t >= p->alpha_mask_first[mask + 1]) mask++;
    const alpha_mask *m = &p->casters->alpha_masks[mask];
    for (int k = 0; k < 3; k++) {
        u += share[k] * (double)p->uvq[t - p->holed_first][k].u;
        v += share[k] * (double)p->uvq[t - p->holed_first][k].v;
        q += share[k] * (double)p->uvq[t - p->holed_first][k].q;
    }
    return alpha_mask_opaque(m, &p->casters->images[m->image], u / q, v / q);
}

/* How many of the centre and eight points EDGE_PX about it are no hole of a triangle. */
static int opaque_around(const projection *p, size_t t, const vertex_ls *const c[3], double u, double v)
{
    int count = 0;
    for (int n = 0; n < 9; n++) {
        double share[3];
        if (shares_of(c, u + (n % 3 - 1) * EDGE_PX, v + (n / 3 - 1) * EDGE_PX, share) != 0) count += is_opaque_at(p, t, share);
    }
    return count;
}

/* Returns 0 where the ray of a texel's centre stays clear of a triangle. */
static int meet_near(const projection *p, size_t t, double u, double v, near_hit *out)
{
    const vertex_ls *c[3];
    double           share[3] = {0}, away = INFINITY, longest = 0, z = 0, least = INFINITY, most = -INFINITY;
    for (int k = 0; k < 3; k++) {
        c[k]  = &p->vertices[p->indices[3 * t + (size_t)k]];
        least = fmin(least, c[k]->z);
        most  = fmax(most, c[k]->z);
    }
    for (int k = 0; k < 3; k++) {
        const vertex_ls *next = c[(k + 1) % 3];
        away                  = fmin(away, distance_to_edge(c[k], next, u, v));
        longest               = fmax(longest, hypot(next->u - c[k]->u, next->v - c[k]->v));
    }
    double area   = shares_of(c, u, v, share);
    int    inside = area != 0 && share[0] >= 0 && share[1] >= 0 && share[2] >= 0;
    if (!inside && away > EDGE_PX) return 0;
    *out = (near_hit){least, most, inside && away > EDGE_PX, t < p->solid_triangle_count};
    if (area != 0) {
        for (int k = 0; k < 3; k++) z += share[k] * c[k]->z;
        double slope = hypot((c[1]->z - c[0]->z) * (c[2]->v - c[0]->v) - (c[2]->z - c[0]->z) * (c[1]->v - c[0]->v),
                             (c[2]->z - c[0]->z) * (c[1]->u - c[0]->u) - (c[1]->z - c[0]->z) * (c[2]->u - c[0]->u)) /
                       fabs(area);
        double off = slope * (EDGE_PX + longest * longest / fabs(area) * CORNER_PX);
        out->low   = fmax(2 * least - most, z - off);
        out->high  = fmin(2 * most - least, z + off);
    }
    out->low  = fmin(fmax(out->low, 0), 1) - DEPTH_EPS;
    out->high = fmax(fmin(out->high, 1), 0) + DEPTH_EPS;
    if (t < p->holed_first) return 1;
    int opaque = opaque_around(p, t, c, u, v);
    out->sure &= opaque == 9;
    return opaque != 0;
}

/* --- why a texel differs --------------------------------------------------------------------------------------------------- */

static int is_within(const near_hit *h, double depth)
{
    return h->low <= depth && depth <= h->high;
}

/* Whether two depths lie on one surface, or behind all. */
static int is_one_surface(const near_hit *hits, size_t count, double a, double b)
{
    int one = a >= 1 && b >= 1;
    for (size_t n = 0; n < count; n++) one |= is_within(&hits[n], a) && is_within(&hits[n], b);
    return one;
}

/* Whether two surfaces that cannot be distinguished lie at a depth. */
static int is_tie(const near_hit *hits, size_t count, double depth)
{
    for (size_t a = 0; a < count; a++)
        for (size_t b = 0; b < count && is_within(&hits[a], depth); b++)
            if (a != b && hits[a].low <= hits[b].high && hits[b].low <= hits[a].high) return 1;
    return 0;
}

/* rendered, found  enter and exit depth, shares of the whole */
static why why_of(const comparison *c, uint32_t u, uint32_t v, const double rendered[2], const double found[2])
{
    near_hit hits[BRUTE_HITS_MAX];
    size_t   count = 0, cell = (size_t)(v / c->b->cell_px) * c->b->across + u / c->b->cell_px;
    int      perhaps = 0, entered = rendered[0] >= 1, left = rendered[1] >= 1 || rendered[1] == rendered[0];
    for (size_t n = c->b->first[cell]; n < c->b->first[cell + 1] && count < BRUTE_HITS_MAX; n++)
        count += (size_t)meet_near(c->p, c->b->ids[n], u + 0.5, v + 0.5, &hits[count]);
    for (size_t n = 0; n < count; n++) {
        if (hits[n].sure && hits[n].high < rendered[0]) return WHY_UNEXPLAINED;
        perhaps |= !hits[n].sure;
        entered |= is_within(&hits[n], rendered[0]);
        left |= hits[n].solid && is_within(&hits[n], rendered[1]);
    }
    int same_enter = is_one_surface(hits, count, rendered[0], found[0]);
    if (same_enter && is_one_surface(hits, count, rendered[1], found[1])) return WHY_DEPTH;
    if (perhaps) return entered && left ? WHY_EDGE : WHY_UNEXPLAINED;
    return same_enter && left && is_tie(hits, count, fmin(rendered[1], found[1])) ? WHY_TIE : WHY_UNEXPLAINED;
}

static void compare_texel(const comparison *c, source_counts *n, uint32_t u, uint32_t v, uint32_t e, uint32_t x)
{
    size_t       at    = (size_t)v * c->b->side_px + u;
    double       side  = c->b->side_px;
    double       enter = c->maps->enter[at], exit = c->maps->exit[at];
    brute_column found = brute_at(c->b, u, v);
    n->columns++;
    n->wrong += e < floor(found.e_least) || x > ceil(found.x_most) || e > x;
    if (floor(enter * side) >= floor(found.e_least) && floor(enter * side) <= floor(found.e_most) &&
        ceil(exit * side) >= ceil(found.x_least) && ceil(exit * side) <= ceil(found.x_most))
        return;
    const double rendered[2] = {enter, exit};
    const double between[2]  = {(found.e_least + found.e_most) / 2 / side,
                                (exit * side > found.x_most ? found.x_most : found.x_least) / side};
    why          because     = why_of(c, u, v, rendered, between);
    n->differ[because]++;
    if (n->listed_count[because] < c->listed_max)
        n->listed[because][n->listed_count[because]++] =
            (listed){u, v, because, {enter * side, exit * side}, {found.e_least, found.x_most}};
}

static void compare_tile_rows(void *user, size_t begin, size_t end, uint32_t worker)
{
    const comparison *c = user;
    column_tile       t;
    for (size_t j = begin; j < end; j++)
        for (uint32_t i = 0; i < c->b->side_px / 8; i++) {
            c->sparse->tile(c->sparse->data, i, (uint32_t)j, &t);
            for (uint32_t n = 0; n < 64; n++)
                compare_texel(c, &c->worker[worker], 8 * i + n % 8, 8 * (uint32_t)j + n / 8, t.e[n], t.x[n]);
        }
}

/* --- a map ----------------------------------------------------------------------------------------------------------------- */

static void add_counts(source_counts *to, const source_counts *from, size_t listed_max)
{
    to->columns += from->columns;
    to->wrong += from->wrong;
    for (int n = 0; n < WHYS; n++) {
        to->differ[n] += from->differ[n];
        for (size_t k = 0; k < from->listed_count[n] && to->listed_count[n] < listed_max; k++)
            to->listed[n][to->listed_count[n]++] = from->listed[n][k];
    }
}

/* Compare all texels: maps are rendered already, the square is the sparse source's. */
static vxs_result compare_map(source_counts *sum, const projection *p, const depth_maps *maps, const column_square *sparse,
                              size_t listed_max, uint32_t threads, run_context *m)
{
    brute          b      = {0};
    source_counts *worker = calloc(PARALLEL_THREADS_MAX, sizeof *worker);
    vxs_result     r      = VXS_OK;
    if (!brute_init(&b, p, maps->side_px, 1 << sparse_grid(maps->side_px), 0, 0) || !worker)
        r = fail(m, VXS_E_MEMORY, "out of memory");
    if (r == VXS_OK) {
        comparison c = {p, &b, maps, sparse, worker, listed_max};
        parallel_for(threads, maps->side_px / 8, 1, compare_tile_rows, &c);
        for (int n = 0; n < PARALLEL_THREADS_MAX; n++) add_counts(sum, &worker[n], listed_max);
    }
    free(worker);
    brute_free(&b);
    return r;
}

/* A scene's casters under a sun. */
static vxs_result compare_sun(source_counts *sum, gl_context *gl, casters *all, const double sun[3], uint32_t side,
                              size_t listed_max, bake_context *ctx)
{
    light_shape     shape    = {.kind = LIGHT_DIRECTIONAL};
    light_fit_desc  fit      = {.name = "sun", .shape = &shape, .resolution = side};
    depth_maps      maps     = {0};
    depth_renderer *renderer = NULL;
    projection      p        = {0};
    column_map      map      = {0};
    column_square   square   = {0};
    vxs_light       light;
    vxs_result      r;
    if (!vec3_unit(sun, shape.direction_ws)) return fail(ctx->run, VXS_E_ARGUMENT, "--sun: expected a direction, not zero");
    all->solid_meets = NULL; /* what a plan would find out is not trusted: all solids are peeled */
    if ((r = light_fit(&light, all, &fit, ctx->run)) != VXS_OK) return r;
    sparse_columns columns = {.casters = all, .light = &light, .fetch_px = side};
    column_source  source  = sparse_columns_source(&columns);
    if ((r = depth_maps_init(&maps, side, side, 0, all->solid_triangle_count != 0, ctx->run)) != VXS_OK) goto done;
    if ((r = depth_renderer_create(&renderer, gl, all, &light, 0, EXIT_AUTO, ctx->threads, ctx->run)) != VXS_OK) goto done;
    if ((r = depth_renderer_tile(renderer, &maps, 0, 0, ctx->run)) != VXS_OK) goto done;
    if ((r = projection_init(&p, all, &light, 0, ctx->threads, ctx->run)) != VXS_OK) goto done;
    if ((r = source.open(source.data, 0, &map, ctx)) != VXS_OK) goto done;
    if ((r = map.fetch(map.data, square_level(side), 0, 0, &square, ctx)) != VXS_OK) goto done;
    r = compare_map(sum, &p, &maps, &square, listed_max, ctx->threads, ctx->run);
    map.release(map.data, &square);
done:
    if (map.data) map.close(map.data);
    projection_free(&p);
    depth_renderer_destroy(renderer);
    depth_maps_free(&maps);
    return r;
}

/* --- what is printed ------------------------------------------------------------------------------------------------------- */

static const char *name_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static json_t *row_json(const char *path, const char *sun, uint32_t side, const source_counts *n)
{
    json_t *list = json_array();
    for (int w = 0; w < WHYS; w++)
        for (size_t k = 0; k < n->listed_count[w]; k++) {
            const listed *l = &n->listed[w][k];
            json_array_append_new(list, json_pack("{s:s, s:[I,I], s:[f,f], s:[f,f]}", "why", why_names[w], "texel",
                                                  (json_int_t)l->u, (json_int_t)l->v, "rendered", l->rendered[0], l->rendered[1],
                                                  "found", l->found[0], l->found[1]));
        }
    return json_pack("{s:s, s:s, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:o}", "scene", name_of(path), "sun", sun, "resolution_px",
                     (json_int_t)side, "columns", (json_int_t)n->columns, "wrong", (json_int_t)n->wrong, "depth",
                     (json_int_t)n->differ[WHY_DEPTH], "edge", (json_int_t)n->differ[WHY_EDGE], "tie",
                     (json_int_t)n->differ[WHY_TIE], "unexplained", (json_int_t)n->differ[WHY_UNEXPLAINED], "texels", list);
}

static void print_row(const char *path, const char *sun, uint32_t side, const source_counts *n)
{
    printf("%-32s %-14s %5u %10llu columns, of which differ %7llu in depth, %6llu at edges, %6llu in ties, %4llu unexplained; %llu "
           "wrong\n",
           name_of(path), sun, side, (unsigned long long)n->columns, (unsigned long long)n->differ[WHY_DEPTH],
           (unsigned long long)n->differ[WHY_EDGE], (unsigned long long)n->differ[WHY_TIE],
           (unsigned long long)n->differ[WHY_UNEXPLAINED], (unsigned long long)n->wrong);
    for (int w = 0; w < WHYS; w++)
        for (size_t k = 0; k < n->listed_count[w]; k++)
            printf("    %u,%u %s: rendered %.4f to %.4f, found %.4f to %.4f\n", n->listed[w][k].u, n->listed[w][k].v, why_names[w],
                   n->listed[w][k].rendered[0], n->listed[w][k].rendered[1], n->listed[w][k].found[0], n->listed[w][k].found[1]);
    fflush(stdout);
}

/* A scene under all suns at all resolutions. */
static vxs_result compare_scene(json_t *rows, gl_context *gl, const char *path, const text_list *suns, const number_list *sides,
                                size_t listed_max, bake_context *ctx)
{
    scene          s   = {0};
    casters        all = {0};
    source_counts *n   = malloc(sizeof *n);
    vxs_result     r   = n ? VXS_OK : fail(ctx->run, VXS_E_MEMORY, "out of memory");
    if (r == VXS_OK) r = scene_load_gltf(&s, path, NULL, ctx->run);
    if (r == VXS_OK) r = casters_for_maps(&all, &s, CLOSED_AUTO, ctx->threads, ctx->run);
    for (size_t k = 0; k < suns->count * sides->count && r == VXS_OK; k++) {
        const char *sun  = suns->items[k % suns->count];
        uint32_t    side = sides->items[k / suns->count];
        double      way[3];
        int         end = 0;
        memset(n, 0, sizeof *n);
        if (sscanf(sun, "%lf,%lf,%lf%n", &way[0], &way[1], &way[2], &end) != 3 || sun[end])
            r = fail(ctx->run, VXS_E_ARGUMENT, "--sun %s: expected 3 numbers", sun);
        else if ((r = compare_sun(n, gl, &all, way, side, listed_max, ctx)) == VXS_OK) {
            print_row(path, sun, side, n);
            json_array_append_new(rows, row_json(path, sun, side, n));
            ctx->run->wrong |= n->wrong || n->differ[WHY_UNEXPLAINED];
        }
    }
    free(n);
    casters_free(&all);
    scene_free(&s);
    return r;
}

int main(int argc, char **argv)
{
    text_list    paths = {0}, suns = {0};
    number_list  sides   = {0};
    uint32_t     threads = parallel_default_threads(), list = 0;
    const char  *json_path = NULL;
    const option options[] = {
        {"SCENE", OPTION_INPUTS, &paths, FILE_SCENE, 0, NULL, NULL, "glTF 2.0 scenes", NULL},
        {"--sun", OPTION_TEXTS, &suns, 0, 0, NULL, "X,Y,Z", "the way light travels; repeated for more (default two)", NULL},
        {"--resolution", OPTION_U32S, &sides, 8, TILE_MAX_PX, NULL, "N", "texels a side; repeated for more (default 1024)", NULL},
        {"--list", OPTION_U32, &list, 0, LISTED_MAX, NULL, "N", "differing texels of each kind to print (default 0)", NULL},
        {"--json", OPTION_OUTPUT, &json_path, 0, 0, ".json", "FILE", "the counts and texels as JSON", NULL},
        {"--threads", OPTION_U32, &threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "threads (default: all)", NULL}};
    const command_line line = COMMAND_LINE("sources", "SCENE... [options]", "Where rendered maps and others differ.", options);
    run_context        m    = {0};
    gl_context        *gl   = NULL;
    bake_context       ctx  = {.run = &m, .threads = threads};
    json_t            *rows = json_array();
    int                help_shown;
    vxs_result         r = options_parse(&line, argc, argv, &help_shown, &m);
    if (r != VXS_OK || help_shown) goto done;
    ctx.threads = threads;
    if (!sides.count) sides = (number_list){{1024}, 1};
    for (size_t n = 0; n < sides.count && r == VXS_OK; n++)
        if (sides.items[n] & (sides.items[n] - 1))
            r = fail(&m, VXS_E_ARGUMENT, "--resolution %u: expected a power of two", sides.items[n]);
    text_list usual = {(const char **)usual_suns, USUAL_SUNS, USUAL_SUNS};
    if (r == VXS_OK) r = gl_context_create(&gl, gl_choice(), threads, &m);
    for (size_t n = 0; n < paths.count && r == VXS_OK; n++)
        r = compare_scene(rows, gl, paths.items[n], suns.count ? &suns : &usual, &sides, list, &ctx);
    if (r == VXS_OK && json_path)
        r = json_write(json_path, json_pack("{s:s, s:f, s:O}", "vxs", VXS_VERSION, "edge_px", EDGE_PX, "rows", rows), &m);
done:
    json_decref(rows);
    free(paths.items);
    free(suns.items);
    if (gl) gl_context_destroy(gl);
    return command_end(&m, r);
}
