/* Sampling a map; see map_sample.h.
 *
 * A window is rasterized by hand: every triangle at a texel's centre is kept, and the ray through it walks along them. That is the
 * exit depth that depth_block.c peels, found another way; it is slow per texel, and few are needed.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/map_sample.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/integer.h"
#include "baker/base/parallel.h"
#include "baker/base/random.h"
#include "baker/coding/blocks/block_build.h"
#include "baker/coding/blocks/block_words.h"
#include "baker/columns/sparse/freedom.h"
#include "baker/columns/stored/depth_maps.h"
#include "baker/lab/opengl/depth_block.h"
#include "baker/light/texel_box.h"

enum { CELLS_MAX = 32, MAPS_FEW = 8 }; /* windows a side; maps that are looked at closely */

/* What a sample may cost, however many triangles lie over each other: some two seconds, and 100 MiB beside what follows the triangles, and
 * threads. Real scenes need a tenth of it. */
enum {
    ENTRIES_MAX          = 1 << 24, /* of triangles in windows: beyond it, windows are left out */
    FRAGMENTS_MAX        = 1 << 25, /* of all windows: then no others are begun */
    WINDOW_FRAGMENTS_MAX = 1 << 19, /* of one: its other triangles are not looked at */
};

enum {
    CHUNKS    = 64, /* of triangles, each counted and placed alone: the same at any thread count */
    BATCH     = 16, /* windows that are drawn at once */
    PLACE_MAX = 8,  /* threads that count triangles: each for itself */
};

/* Fronts first among faces at one depth. A facing sheet is seen from one side, and there by the light. */
typedef enum face_kind { FACE_FRONT, FACE_BACK, FACE_SHEET, FACE_FACING_SHEET } face_kind;

typedef struct fragment {
    float     depth;
    uint32_t  texel;
    face_kind kind;
} fragment;

/* Triangles of sheets, of solids that meet nothing, and of those that meet another. */
enum { CLASS_SHEET, CLASS_APART, CLASS_MEETS, CLASSES };

/* Counts of triangles by block, as differences along both axes until they are summed up. */
typedef struct triangle_counts {
    uint32_t side;
    size_t   size;       /* (side + 1)^2 */
    int32_t *of_workers; /* [PLACE_MAX][CLASSES][size]; in the end the first worker has all */
} triangle_counts;

enum { WINDOW_TEXELS_MAX = SAMPLE_WINDOW_PX * SAMPLE_WINDOW_PX, FRAGMENTS_ROOM = WINDOW_FRAGMENTS_MAX + WINDOW_TEXELS_MAX };

/* What a thread draws windows with: it allocates nothing, so that no heap is begun for it, whose size would be left to chance. */
typedef struct canvas {
    fragment *fragments; /* [fragment_count] of FRAGMENTS_ROOM */
    size_t    fragment_count;
    fragment *sorted;                       /* by texel, in each from near to far */
    uint32_t  first[WINDOW_TEXELS_MAX + 1]; /* of each texel */
} canvas;

/* A window that is drawn. */
typedef struct window {
    uint32_t   number;
    size_t     triangles, looked_at, fragments;
    uint32_t   layers; /* the most of its texels */
    depth_maps maps;
} window;

typedef struct sampler {
    map_sample       *s;
    const projection *p;
    const vxs_light  *light;
    int               peels_all;
    coding_choice     coding;
    build_options     build; /* of a DAG */
    column_freedom    freedom;
    uint32_t          threads;
    uint32_t          side_px, window_px, cells, cell_px;
    uint32_t          cell_shift, block_shift;      /* the exponents of cell_px and of a block's side */
    triangle_counts   blocks;                       /* of depth_block.h */
    uint32_t          at[CELLS_MAX * CELLS_MAX][2]; /* texel where each window starts */
    uint32_t          windows;                      /* those of a rank below this are looked at */
    uint8_t          *in_window;                    /* [p->triangle_count] 1: may touch one */
    size_t (*place)[CELLS_MAX * CELLS_MAX];         /* [CHUNKS] how many triangles of a chunk are in a window, then where they go */
    size_t    list_first[CELLS_MAX * CELLS_MAX + 1];
    uint32_t *lists; /* what may touch each window */
    uint64_t  fragments_made;
    canvas   *canvases; /* [threads] */
    window    batch[BATCH];
    uint64_t *hashes[SAMPLE_LEVELS + 1]; /* of all inserted nodes by level, masks last */
    size_t    hash_count[SAMPLE_LEVELS + 1], hash_capacity[SAMPLE_LEVELS + 1];
    block_set set; /* of all windows: a node of one block each */
    int       out_of_memory;
} sampler;

/* what lies where --------------------------------------------------------------------------------------------------------------- */

static void place_windows(sampler *job)
{
    uint32_t places = job->cell_px / job->window_px;
    for (uint32_t n = 0; n < job->cells * job->cells; n++) {
        rng r         = rng_split(1, n);
        job->at[n][0] = n % job->cells * job->cell_px + rng_below(&r, places) * job->window_px;
        job->at[n][1] = n / job->cells * job->cell_px + rng_below(&r, places) * job->window_px;
    }
}

/* Add one to the blocks [u0, u1] x [v0, v1]. */
static void count_square(int32_t *differences, uint32_t side, uint32_t u0, uint32_t v0, uint32_t u1, uint32_t v1)
{
    size_t row = side + 1;
    differences[v0 * row + u0]++;
    differences[v0 * row + u1 + 1]--;
    differences[(v1 + 1) * row + u0]--;
    differences[(v1 + 1) * row + u1 + 1]++;
}

static void sum_up(int32_t *counts, uint32_t side)
{
    size_t row = side + 1;
    for (size_t v = 0; v <= side; v++)
        for (size_t u = 0; u <= side; u++)
            counts[v * row + u] += (u ? counts[v * row + u - 1] : 0) + (v ? counts[(v - 1) * row + u] : 0) -
                                   (u && v ? counts[(v - 1) * row + u - 1] : 0);
}

/* Which window is the rank-th; and, the same function, which rank a window has. Its number's bits the other way round: the first few
 * windows lie all over the map. There is a power of two of them. */
static uint32_t window_of_rank(const sampler *job, uint32_t rank)
{
    uint32_t n = 0;
    for (uint32_t bit = 1; bit < job->cells * job->cells; bit *= 2) n = 2 * n + !!(rank & bit);
    return n;
}

/* Of a triangle, what is in the map. Returns 0 when that is nothing. */
static int box_in_map(const sampler *job, size_t triangle, texel_box *b)
{
    int32_t last = (int32_t)job->side_px - 1;
    *b           = texel_box_of(job->p, triangle);
    if (b->u0 > b->u1 || b->v0 > b->v1 || b->u1 < 0 || b->v1 < 0 || b->u0 > last || b->v0 > last) return 0;
    *b = (texel_box){max_i32(b->u0, 0), max_i32(b->v0, 0), min_i32(b->u1, last), min_i32(b->v1, last)};
    return 1;
}

static void count_in_blocks(sampler *job, size_t t, const texel_box *b, uint32_t worker)
{
    const projection *p     = job->p;
    uint32_t          shift = job->block_shift;
    int of = t >= p->solid_triangle_count ? CLASS_SHEET : job->peels_all || !p->meets || p->meets[t] ? CLASS_MEETS : CLASS_APART;
    count_square(job->blocks.of_workers + (worker * CLASSES + (size_t)of) * job->blocks.size, job->blocks.side,
                 (uint32_t)b->u0 >> shift, (uint32_t)b->v0 >> shift, (uint32_t)b->u1 >> shift, (uint32_t)b->v1 >> shift);
}

/* Count a triangle in the windows that it may touch, or place it there. Returns how many they are. */
static uint32_t walk_windows(sampler *job, size_t t, const texel_box *b, size_t *at, int place)
{
    uint32_t i0 = (uint32_t)b->u0 >> job->cell_shift, i1 = (uint32_t)b->u1 >> job->cell_shift;
    uint32_t j0 = (uint32_t)b->v0 >> job->cell_shift, j1 = (uint32_t)b->v1 >> job->cell_shift, count = 0;
    for (uint32_t y = j0; y <= j1; y++)
        for (uint32_t x = i0; x <= i1; x++) {
            uint32_t n = y * job->cells + x;
            if (!texel_box_touches(b, (int32_t)job->at[n][0], (int32_t)job->at[n][1], (int32_t)job->window_px)) continue;
            count++;
            if (!place)
                at[n]++;
            else if (window_of_rank(job, n) < job->windows)
                job->lists[at[n]++] = (uint32_t)t;
        }
    return count;
}

static void count_chunks(void *user, size_t begin, size_t end, uint32_t worker)
{
    sampler  *job   = user;
    size_t    count = job->p->triangle_count;
    texel_box b;
    for (size_t chunk = begin; chunk < end; chunk++)
        for (size_t t = count * chunk / CHUNKS; t < count * (chunk + 1) / CHUNKS; t++) {
            if (!(job->in_window[t] = (uint8_t)box_in_map(job, t, &b))) continue;
            count_in_blocks(job, t, &b, worker);
            job->in_window[t] = walk_windows(job, t, &b, job->place[chunk], 0) > 0;
        }
}

static void place_chunks(void *user, size_t begin, size_t end, uint32_t worker)
{
    sampler  *job   = user;
    size_t    count = job->p->triangle_count;
    texel_box b;
    (void)worker;
    for (size_t chunk = begin; chunk < end; chunk++)
        for (size_t t = count * chunk / CHUNKS; t < count * (chunk + 1) / CHUNKS; t++)
            if (job->in_window[t] && box_in_map(job, t, &b)) walk_windows(job, t, &b, job->place[chunk], 1);
}

/* Many large triangles lie over each other: look at fewer windows. */
static void leave_out_windows(sampler *job)
{
    size_t entries = 0;
    for (uint32_t rank = 0; rank < job->windows; rank++) {
        uint32_t n = window_of_rank(job, rank);
        for (size_t chunk = 0; chunk < CHUNKS; chunk++) entries += job->place[chunk][n];
        if (rank && entries > ENTRIES_MAX) job->windows = rank;
    }
}

/* Triangles go window by window, in their order in each. Returns how many they are. */
static size_t counts_to_places(sampler *job)
{
    size_t sum = 0;
    for (uint32_t n = 0; n < job->cells * job->cells; n++) {
        job->list_first[n] = sum;
        for (size_t chunk = 0; chunk < CHUNKS && window_of_rank(job, n) < job->windows; chunk++) {
            size_t count         = job->place[chunk][n];
            job->place[chunk][n] = sum;
            sum += count;
        }
    }
    return job->list_first[job->cells * job->cells] = sum;
}

static int place_triangles(sampler *job)
{
    job->in_window = malloc(job->p->triangle_count + 1);
    job->place     = calloc(CHUNKS, sizeof *job->place);
    if (!job->in_window || !job->place) return 0;
    parallel_for(min_u32(job->threads, PLACE_MAX), CHUNKS, 1, count_chunks, job);
    leave_out_windows(job);
    job->lists = malloc((counts_to_places(job) + 1) * sizeof *job->lists);
    if (!job->lists) return 0;
    parallel_for(job->threads, CHUNKS, 1, place_chunks, job);
    return 1;
}

static void count_blocks(sampler *job)
{
    map_sample      *s   = job->s;
    triangle_counts *b   = &job->blocks;
    int32_t         *sum = b->of_workers;
    for (size_t worker = 1; worker < job->threads && worker < PLACE_MAX; worker++)
        for (size_t n = 0; n < CLASSES * b->size; n++) sum[n] += sum[worker * CLASSES * b->size + n];
    for (size_t n = 0; n < CLASSES; n++) sum_up(sum + n * b->size, b->side);
    s->blocks = (uint64_t)b->side * b->side;
    for (uint32_t n = 0; n < s->blocks; n++) {
        size_t   at    = (size_t)(n / b->side) * (b->side + 1) + n % b->side;
        uint64_t sheet = (uint64_t)sum[CLASS_SHEET * b->size + at], apart = (uint64_t)sum[CLASS_APART * b->size + at];
        uint64_t meets = (uint64_t)sum[CLASS_MEETS * b->size + at], all = sheet + apart + meets;
        s->blocks_empty += all == 0;
        s->blocks_peeled += meets > 0;
        s->blocks_not_peeled += apart > 0 && meets == 0;
        s->block_triangles += all;
        s->block_most = max_u64(s->block_most, all);
        s->peeled_triangles += meets > 0 ? apart + meets : 0;
    }
}

static int tile_has_triangles(const triangle_counts *b, uint32_t u0, uint32_t v0, uint32_t across)
{
    for (uint32_t n = 0; n < across * across; n++)
        for (size_t of = 0; of < CLASSES; of++)
            if (b->of_workers[of * b->size + (size_t)(v0 + n / across) * (b->side + 1) + u0 + n % across] > 0) return 1;
    return 0;
}

static void count_tiles(sampler *job)
{
    uint32_t block_px = min_u32(job->side_px, BLOCK_MAX_PX);
    for (uint32_t size = 0; size < TILE_SIZES; size++) {
        uint32_t tile = max_u32(block_px, min_u32(job->side_px, TILE_MAX_PX >> size)), across = tile / block_px;
        for (uint32_t v = 0; v < job->blocks.side; v += across)
            for (uint32_t u = 0; u < job->blocks.side; u += across) {
                job->s->tiles[size]++;
                job->s->tiles_empty[size] += !tile_has_triangles(&job->blocks, u, v, across);
            }
    }
}

/* a window ---------------------------------------------------------------------------------------------------------------------- */

/* What an edge has of a point: positive inside; on the edge itself, one of the two triangles that share it has it. */
static int inside(double value, double du, double dv)
{
    return value > 0 || (value == 0 && (dv > 0 || (dv == 0 && du < 0)));
}

static double least(const double x[3])
{
    double a = x[0] < x[1] ? x[0] : x[1];
    return a < x[2] ? a : x[2];
}

static double most(const double x[3])
{
    double a = x[0] > x[1] ? x[0] : x[1];
    return a > x[2] ? a : x[2];
}

static double within(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

static void rasterize(const sampler *job, canvas *c, uint32_t n, uint32_t t)
{
    const projection *p      = job->p;
    const uint32_t   *corner = p->indices + 3 * (size_t)t;
    double            u[3], v[3], z[3];
    for (int k = 0; k < 3; k++) {
        u[k] = p->vertices[corner[k]].u - job->at[n][0];
        v[k] = p->vertices[corner[k]].v - job->at[n][1];
        z[k] = p->reversed ? -p->vertices[corner[k]].z : p->vertices[corner[k]].z;
    }
    double area = (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0]);
    if (area == 0) return;
    int       thin = area > 0 || t >= p->holed_first || (p->double_sided && p->double_sided[t]);
    face_kind kind = t >= p->solid_triangle_count ? thin ? FACE_SHEET : FACE_FACING_SHEET : area < 0 ? FACE_FRONT : FACE_BACK;
    double    side = area < 0 ? -1 : 1, low = p->reversed ? -1 : 0, high = p->reversed ? 0 : 1;
    double    last = job->window_px - 1;
    int       u0 = (int)within(ceil(least(u) - 0.5), 0, last + 1), u1 = (int)within(floor(most(u) - 0.5), -1, last);
    int       v0 = (int)within(ceil(least(v) - 0.5), 0, last + 1), v1 = (int)within(floor(most(v) - 0.5), -1, last);
    if (u0 > u1 || v0 > v1) return;
    for (int y = v0; y <= v1; y++)
        for (int x = u0; x <= u1; x++) {
            double w[3];
            int    in = 1;
            for (int k = 0; k < 3 && in; k++) {
                int    a = (k + 1) % 3, b = (k + 2) % 3;
                double du = side * (u[b] - u[a]), dv = side * (v[b] - v[a]);
                w[k] = du * (y + 0.5 - v[a]) - dv * (x + 0.5 - u[a]);
                in   = inside(w[k], du, dv);
            }
            if (!in) continue;
            double depth = (w[0] * z[0] + w[1] * z[1] + w[2] * z[2]) / (side * area);
            c->fragments[c->fragment_count++] =
                (fragment){(float)within(depth, low, high), (uint32_t)y * job->window_px + (uint32_t)x, kind};
        }
}

/* Those that are equal here are equal in all that is asked of them: it does not matter which comes first. */
static int compare_fragments(const void *a, const void *b)
{
    const fragment *f = a, *g = b;
    if (f->depth != g->depth) return f->depth < g->depth ? -1 : 1;
    return (f->kind > g->kind) - (f->kind < g->kind);
}

/* Most texels have a few fragments, which a plain insertion has in order before qsort has begun. */
static void sort_near_to_far(fragment *items, uint32_t count)
{
    if (count > 32) {
        qsort(items, count, sizeof *items, compare_fragments);
        return;
    }
    for (uint32_t n = 1; n < count; n++) {
        fragment f = items[n];
        uint32_t k = n;
        for (; k > 0 && compare_fragments(&f, &items[k - 1]) < 0; k--) items[k] = items[k - 1];
        items[k] = f;
    }
}

/* Fragments by texel, in each from near to far. */
static void sort_fragments(canvas *c, uint32_t texels)
{
    memset(c->first, 0, (texels + 1) * sizeof *c->first);
    for (size_t n = 0; n < c->fragment_count; n++) c->first[c->fragments[n].texel + 1]++;
    for (uint32_t n = 0; n < texels; n++) c->first[n + 1] += c->first[n];
    for (size_t n = c->fragment_count; n-- > 0;) c->sorted[--c->first[c->fragments[n].texel + 1]] = c->fragments[n];
    /* every first[n + 1] has become the start of texel n */
    memmove(c->first, c->first + 1, texels * sizeof *c->first);
    c->first[texels] = (uint32_t)c->fragment_count;
    for (uint32_t texel = 0; texel < texels; texel++)
        sort_near_to_far(c->sorted + c->first[texel], c->first[texel + 1] - c->first[texel]);
}

/* The exit where more is free than the insides of solids. */
static float later_exit(const column_freedom *free, const fragment *f, uint32_t count, float exit)
{
    const float none = free->perspective ? 0 : 1;
    if (free->behind && f[count - 1].depth <= exit) return none;
    if (!(free->thickness > 0) || f->kind != FACE_FACING_SHEET) return exit;
    return fminf(fminf((float)freedom_through(free, (double)exit), count > 1 ? f[1].depth : none), none);
}

/* The column of a texel, as depth_block.c means it. Returns the back faces up to the exit. */
static uint32_t walk(const fragment *f, uint32_t count, float *enter, float *exit)
{
    int      open  = 0;
    uint32_t backs = 0;
    float    solid = INFINITY, first_back = INFINITY, sheet = INFINITY, last = INFINITY;
    for (uint32_t n = 0; n < count; n++) {
        if (f[n].kind >= FACE_SHEET) {
            sheet = fminf(sheet, f[n].depth);
            continue;
        }
        solid = fminf(solid, f[n].depth);
        open += f[n].kind == FACE_FRONT ? 1 : -1;
        if (f[n].kind == FACE_FRONT || last < INFINITY) continue;
        backs++;
        first_back = fminf(first_back, f[n].depth);
        if (open <= 0) last = f[n].depth;
    }
    if (sheet < INFINITY && sheet <= solid) {
        *enter = *exit = sheet;
    } else if (solid < INFINITY) {
        *enter = solid;
        *exit  = last < INFINITY ? last : first_back < INFINITY ? first_back : solid;
    }
    return backs;
}

static void take_hash(sampler *job, int level, uint64_t hash)
{
    if (!array_reserve(&job->hashes[level], &job->hash_capacity[level], job->hash_count[level] + 1, sizeof **job->hashes)) {
        job->out_of_memory = 1;
        return;
    }
    job->hashes[level][job->hash_count[level]++] = hash;
}

static vxs_result insert_window(sampler *job, const window *w)
{
    dag           d       = {0};
    column_square columns = depth_maps_square(&w->maps);
    build_stats   stats   = {0};
    vxs_result    r       = dag_build_square(&d, &columns, square_level(job->window_px), 0, 0, &job->build, &stats);
    if (r != VXS_OK) return r;
    job->s->mask_runs += stats.mask_runs;
    job->s->mask_tiles += stats.mask_tiles;
    job->s->masks += d.mask_count;
    for (uint32_t n = 0; n < d.mask_count; n++) take_hash(job, SAMPLE_LEVELS, d.masks[n]);
    for (uint32_t l = 0; l < d.level_count; l++) {
        job->s->nodes[l] += d.level[l].count;
        for (uint32_t n = 0; n < d.level[l].count; n++) take_hash(job, (int)l, d.level[l].hash[n]);
    }
    dag_free(&d);
    return VXS_OK;
}

static int has_pattern(const block_set *set, const block_node *node)
{
    if (!(node->mixed & 1)) return 0;
    const block b = block_at(set, node->block[0]);
    for (const block_tile *t = b.tile; t < b.tile + BLOCK_TILES; t++)
        if (t->kind != TILE_UNIFORM) return 1;
    return 0;
}

/* A window as a node of its own. Where no tile needs a pattern nothing is kept: among its neighbours, the slope that it would have with
 * them settles it. */
static vxs_result build_window(sampler *job, const window *w)
{
    block_set    *set     = &job->set;
    size_t        before  = set->node_count;
    column_square columns = depth_maps_square(&w->maps);
    columns.u_px          = w->number % CELLS_MAX * NODE_PX;
    columns.v_px          = w->number / CELLS_MAX * NODE_PX;
    vxs_result r          = block_build_node(set, &columns, 0, 0, 0);
    if (set->node_count > before && !has_pattern(set, &set->nodes[before])) set->node_count = before;
    return r;
}

static void draw_window(const sampler *job, canvas *c, window *w)
{
    const uint32_t *triangles = job->lists + job->list_first[w->number];
    uint32_t        texels    = job->window_px * job->window_px;
    c->fragment_count         = 0;
    while (w->looked_at < w->triangles && c->fragment_count < WINDOW_FRAGMENTS_MAX)
        rasterize(job, c, w->number, triangles[w->looked_at++]);
    w->fragments = c->fragment_count;
    sort_fragments(c, texels);
    for (uint32_t texel = 0; texel < texels; texel++) {
        uint32_t from = c->first[texel], count = c->first[texel + 1] - from;
        w->maps.enter[texel] = w->maps.exit[texel] = job->p->reversed ? 0 : 1;
        w->layers = max_u32(w->layers, walk(c->sorted + from, count, &w->maps.enter[texel], &w->maps.exit[texel]));
        if (count && freedom_looks_on(&job->freedom))
            w->maps.exit[texel] = later_exit(&job->freedom, c->sorted + from, count, w->maps.exit[texel]);
    }
    depth_maps_reduce(&w->maps, 1);
}

static void draw_some(void *user, size_t begin, size_t end, uint32_t worker)
{
    sampler *job = user;
    for (size_t n = begin; n < end; n++)
        if (job->batch[n].triangles) draw_window(job, &job->canvases[worker], &job->batch[n]);
}

static vxs_result take_window(sampler *job, const window *w)
{
    map_sample *s = job->s;
    s->texels += job->window_px * job->window_px;
    if (!w->triangles) return VXS_OK; /* all lit */
    job->fragments_made += w->fragments;
    uint64_t all = (uint64_t)w->layers * w->triangles / w->looked_at;
    s->layers += all < PEEL_PASSES_MAX ? all : PEEL_PASSES_MAX;
    s->peeled_windows += w->layers > 0;
    return job->coding == CODING_BLOCKS ? build_window(job, w) : insert_window(job, w);
}

/* all windows ------------------------------------------------------------------------------------------------------------------- */

static int compare_hashes(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

static uint64_t different(uint64_t *hashes, size_t count)
{
    uint64_t found = 0;
    if (count) qsort(hashes, count, sizeof *hashes, compare_hashes);
    for (size_t n = 0; n < count; n++) found += !n || hashes[n] != hashes[n - 1];
    return found;
}

/* The windows as a bake would lay them out, if they were all that there is. */
static vxs_result count_blocks_kept(sampler *job)
{
    enum { LEVELS = 13 }; /* of a map with a node for each window */
    palette_sample *p = &job->s->palette;
    block_words     w;
    job->s->mask_tiles = job->set.tile_count;
    vxs_result r       = block_words_lay_out(&w, &job->set, LEVELS, 1, 1);
    if (r != VXS_OK) return r;
    p->blocks        = job->set.node_count;
    p->unique_blocks = w.counts.blocks;
    p->block_words   = w.counts.block_words;
    p->pattern_words = w.counts.pattern_words + w.counts.common_words;
    p->patterns      = (uint64_t)w.counts.patterns + w.counts.own_patterns + w.common_count;
    p->own_patterns  = w.counts.own_patterns;
    block_words_free(&w);
    return VXS_OK;
}

static vxs_result sample_windows(sampler *job)
{
    map_sample *s = job->s;
    vxs_result  r = VXS_OK;
    for (uint32_t rank = 0; rank < job->windows && job->fragments_made < FRAGMENTS_MAX && r == VXS_OK; rank += BATCH) {
        uint32_t count = min_u32(BATCH, job->windows - rank);
        for (uint32_t k = 0; k < count; k++) {
            uint32_t n = window_of_rank(job, rank + k);
            job->batch[k] =
                (window){.number = n, .triangles = job->list_first[n + 1] - job->list_first[n], .maps = job->batch[k].maps};
        }
        parallel_for(job->threads, count, 1, draw_some, job);
        for (uint32_t k = 0; k < count && r == VXS_OK; k++) r = take_window(job, &job->batch[k]);
    }
    if (r != VXS_OK || job->out_of_memory) return VXS_E_MEMORY;
    if (job->coding == CODING_BLOCKS) return count_blocks_kept(job);
    s->unique_masks = different(job->hashes[SAMPLE_LEVELS], job->hash_count[SAMPLE_LEVELS]);
    for (int l = 0; l < SAMPLE_LEVELS; l++) s->unique_nodes += different(job->hashes[l], job->hash_count[l]);
    return VXS_OK;
}

static void sampler_free(sampler *job)
{
    for (int l = 0; l <= SAMPLE_LEVELS; l++) free(job->hashes[l]);
    for (uint32_t n = 0; n < job->threads && job->canvases; n++) {
        free(job->canvases[n].fragments);
        free(job->canvases[n].sorted);
    }
    for (int n = 0; n < BATCH; n++) depth_maps_free(&job->batch[n].maps);
    block_set_free(&job->set);
    free(job->blocks.of_workers);
    free(job->in_window);
    free(job->place);
    free(job->lists);
    free(job->canvases);
    free(job);
}

/* Every 64th texel of a map of 4096; all of small ones; of many maps, fewer. */
static uint32_t windows_a_side(uint32_t side_px, uint32_t maps)
{
    uint32_t windows = side_px / SAMPLE_WINDOW_PX, cells = side_px / 256;
    for (; maps > MAPS_FEW; maps /= 4) cells /= 2;
    cells = cells < 8 ? 8 : cells > CELLS_MAX ? CELLS_MAX : cells;
    return windows < 1 ? 1 : min_u32(windows, cells);
}

static vxs_result make_room(sampler *job, message *m)
{
    uint32_t   block_px    = min_u32(job->side_px, BLOCK_MAX_PX);
    double     log         = job->light->kind != VXS_LIGHT_KIND_DIRECTIONAL ? job->light->voxel_metres : 0;
    vxs_result r           = VXS_OK;
    job->cell_shift        = log2_u32(job->cell_px);
    job->block_shift       = log2_u32(block_px);
    job->blocks.side       = job->side_px / block_px;
    job->blocks.size       = (size_t)(job->blocks.side + 1) * (job->blocks.side + 1);
    job->blocks.of_workers = calloc(PLACE_MAX * CLASSES * job->blocks.size, sizeof *job->blocks.of_workers);
    job->canvases          = calloc(job->threads, sizeof *job->canvases);
    for (int n = 0; n < BATCH && r == VXS_OK; n++)
        r = depth_maps_init(&job->batch[n].maps, job->window_px, job->side_px, log, 1, m);
    if (!job->blocks.of_workers || !job->canvases) return VXS_E_MEMORY;
    for (canvas *c = job->canvases; c < job->canvases + job->threads; c++) {
        c->fragments = malloc(FRAGMENTS_ROOM * sizeof *c->fragments);
        c->sorted    = malloc(FRAGMENTS_ROOM * sizeof *c->sorted);
        if (!c->fragments || !c->sorted) r = VXS_E_MEMORY;
    }
    return r;
}

vxs_result map_sample_take(map_sample *s, const projection *p, const vxs_light *light, int peels_all, uint32_t maps,
                           const bake_options *o, message *m)
{
    memset(s, 0, sizeof *s);
    sampler *job = calloc(1, sizeof *job);
    if (!job) return fail(m, VXS_E_MEMORY, "out of memory for a sample of a map");
    job->s         = s;
    job->p         = p;
    job->light     = light;
    job->peels_all = peels_all;
    job->coding    = o->coding;
    job->build     = (build_options){.rule = o->rule, .reuse = o->reuse};
    job->freedom   = freedom_of(light, o->behind == BEHIND_FREE, o->thickness_m);
    job->threads   = min_u32(max_u32(o->threads, 1), BATCH);
    job->side_px   = 1u << light->levels;
    job->window_px = min_u32(job->side_px, SAMPLE_WINDOW_PX);
    job->cells     = windows_a_side(job->side_px, maps);
    job->cell_px   = job->side_px / job->cells;
    job->windows   = job->cells * job->cells;

    vxs_result r = make_room(job, m);
    if (r == VXS_OK) {
        place_windows(job);
        if (!place_triangles(job)) r = VXS_E_MEMORY;
    }
    if (r == VXS_OK) {
        count_blocks(job);
        count_tiles(job);
        r         = sample_windows(job);
        s->weight = s->texels ? (double)job->side_px * job->side_px / (double)s->texels : 0;
    }
    sampler_free(job);
    if (r == VXS_OK) return VXS_OK;
    memset(s, 0, sizeof *s);
    return fail(m, r, "out of memory for a sample of a map");
}
