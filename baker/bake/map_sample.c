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
#include "baker/base/random.h"
#include "baker/blocks/block_build.h"
#include "baker/blocks/block_words.h"
#include "baker/columns/opengl/depth_block.h"
#include "baker/columns/stored/depth_maps.h"

enum { CELLS_MAX = 32 }; /* windows a side */

/* What a sample may cost, however many triangles lie over each other: some two seconds, and 100 MiB beside what follows the triangles.
 * Real scenes need a tenth of it. */
enum {
    ENTRIES_MAX          = 1 << 24, /* of triangles in the lists of windows: beyond it, windows are left out */
    FRAGMENTS_MAX        = 1 << 25, /* of all windows: then no other is begun */
    WINDOW_FRAGMENTS_MAX = 1 << 21, /* of one: its other triangles are not looked at */
};

typedef enum face_kind { FACE_FRONT, FACE_BACK, FACE_SHEET } face_kind; /* fronts first among faces at one depth */

typedef struct fragment {
    float     depth;
    uint32_t  texel;
    face_kind kind;
} fragment;

typedef struct fragment_list {
    fragment *items;
    size_t    count, capacity;
} fragment_list;

typedef struct triangle_list {
    uint32_t *items;
    size_t    count, capacity;
} triangle_list;

/* Counts of triangles by block, as differences along both axes until they are summed up. */
typedef struct triangle_counts {
    uint32_t side;
    int32_t *all, *solid, *meet; /* [(side + 1)^2] */
} triangle_counts;

typedef struct sampler {
    map_sample       *s;
    const projection *p;
    const vxs_light  *light;
    int               peels_all;
    coding_choice     coding;
    build_options     build; /* of a DAG */
    uint32_t          side_px, window_px, cells, cell_px;
    triangle_counts   blocks;                       /* of depth_block.h */
    uint32_t          at[CELLS_MAX * CELLS_MAX][2]; /* texel where each window starts */
    triangle_list     lists[CELLS_MAX * CELLS_MAX]; /* what may touch it */
    uint32_t          windows;                      /* those of a rank below this are looked at */
    size_t            entries;                      /* in all lists */
    uint64_t          fragments_made;
    fragment_list     fragments;
    fragment         *sorted; /* by texel, in each from near to far */
    size_t            sorted_capacity;
    uint32_t         *first; /* [window texels + 1] */
    depth_maps        maps;
    uint64_t         *hashes[SAMPLE_LEVELS + 1]; /* of all inserted nodes by level, masks last */
    size_t            hash_count[SAMPLE_LEVELS + 1], hash_capacity[SAMPLE_LEVELS + 1];
    block_set         set; /* of all windows: a node of one block each */
    int               out_of_memory;
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

/* Many large triangles lie over each other: look at fewer windows. */
static void leave_out_windows(sampler *job)
{
    for (; job->entries > ENTRIES_MAX && job->windows > 1; job->windows--) {
        triangle_list *l = &job->lists[window_of_rank(job, job->windows - 1)];
        job->entries -= l->count;
        free(l->items);
        *l = (triangle_list){0};
    }
}

static void add_to_windows(sampler *job, uint32_t triangle, const texel_box *b)
{
    uint32_t i0 = (uint32_t)b->u0 / job->cell_px, i1 = (uint32_t)b->u1 / job->cell_px;
    uint32_t j0 = (uint32_t)b->v0 / job->cell_px, j1 = (uint32_t)b->v1 / job->cell_px;
    for (uint32_t y = j0; y <= j1; y++)
        for (uint32_t x = i0; x <= i1; x++) {
            uint32_t n = y * job->cells + x;
            if (!texel_box_touches(b, (int32_t)job->at[n][0], (int32_t)job->at[n][1], (int32_t)job->window_px)) continue;
            if (job->windows < job->cells * job->cells && window_of_rank(job, n) >= job->windows) continue;
            triangle_list *l = &job->lists[n];
            if (!array_reserve(&l->items, &l->capacity, l->count + 1, sizeof *l->items)) {
                job->out_of_memory = 1;
                return;
            }
            l->items[l->count++] = triangle;
            job->entries++;
        }
    if (job->entries > ENTRIES_MAX) leave_out_windows(job);
}

static void place_triangles(sampler *job)
{
    const projection *p    = job->p;
    int32_t           last = (int32_t)job->side_px - 1;
    uint32_t          px   = min_u32(job->side_px, BLOCK_MAX_PX);
    for (size_t t = 0; t < p->triangle_count && !job->out_of_memory; t++) {
        texel_box b = texel_box_of(p, t);
        if (b.u0 > b.u1 || b.v0 > b.v1 || b.u1 < 0 || b.v1 < 0 || b.u0 > last || b.v0 > last) continue;
        b.u0        = b.u0 < 0 ? 0 : b.u0;
        b.v0        = b.v0 < 0 ? 0 : b.v0;
        b.u1        = b.u1 > last ? last : b.u1;
        b.v1        = b.v1 > last ? last : b.v1;
        uint32_t u0 = (uint32_t)b.u0 / px, v0 = (uint32_t)b.v0 / px, u1 = (uint32_t)b.u1 / px, v1 = (uint32_t)b.v1 / px;
        count_square(job->blocks.all, job->blocks.side, u0, v0, u1, v1);
        if (t < p->solid_triangle_count) count_square(job->blocks.solid, job->blocks.side, u0, v0, u1, v1);
        if (t < p->solid_triangle_count && (job->peels_all || !p->meets || p->meets[t]))
            count_square(job->blocks.meet, job->blocks.side, u0, v0, u1, v1);
        add_to_windows(job, (uint32_t)t, &b);
    }
}

static void count_blocks(sampler *job)
{
    map_sample      *s = job->s;
    triangle_counts *b = &job->blocks;
    sum_up(b->all, b->side);
    sum_up(b->solid, b->side);
    sum_up(b->meet, b->side);
    s->blocks = (uint64_t)b->side * b->side;
    for (uint32_t n = 0; n < s->blocks; n++) {
        size_t at = (size_t)(n / b->side) * (b->side + 1) + n % b->side;
        s->blocks_empty += b->all[at] == 0;
        s->blocks_peeled += b->meet[at] > 0;
        s->blocks_not_peeled += b->solid[at] > 0 && b->meet[at] == 0;
        s->block_triangles += (uint64_t)b->all[at];
        s->block_most = max_u64(s->block_most, (uint64_t)b->all[at]);
        s->peeled_triangles += b->meet[at] > 0 ? (uint64_t)b->solid[at] : 0;
    }
}

static int tile_has_triangles(const triangle_counts *b, uint32_t u0, uint32_t v0, uint32_t across)
{
    for (uint32_t n = 0; n < across * across; n++)
        if (b->all[(size_t)(v0 + n / across) * (b->side + 1) + u0 + n % across] > 0) return 1;
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

static void rasterize(sampler *job, uint32_t n, uint32_t t)
{
    const projection *p = job->p;
    const uint32_t   *c = p->indices + 3 * (size_t)t;
    double            u[3], v[3], z[3];
    for (int k = 0; k < 3; k++) {
        u[k] = p->vertices[c[k]].u - job->at[n][0];
        v[k] = p->vertices[c[k]].v - job->at[n][1];
        z[k] = p->reversed ? -p->vertices[c[k]].z : p->vertices[c[k]].z;
    }
    double area = (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0]);
    if (area == 0) return;
    face_kind kind = t >= p->solid_triangle_count ? FACE_SHEET : area < 0 ? FACE_FRONT : FACE_BACK;
    double    side = area < 0 ? -1 : 1, low = p->reversed ? -1 : 0, high = p->reversed ? 0 : 1;
    double    last = job->window_px - 1;
    int       u0   = (int)fmax(0, ceil(fmin(fmin(u[0], u[1]), u[2]) - 0.5)),
        u1         = (int)fmin(last, floor(fmax(fmax(u[0], u[1]), u[2]) - 0.5));
    int v0         = (int)fmax(0, ceil(fmin(fmin(v[0], v[1]), v[2]) - 0.5)),
        v1         = (int)fmin(last, floor(fmax(fmax(v[0], v[1]), v[2]) - 0.5));
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
            fragment_list *l = &job->fragments;
            if (!array_reserve(&l->items, &l->capacity, l->count + 1, sizeof *l->items)) {
                job->out_of_memory = 1;
                return;
            }
            double depth = (w[0] * z[0] + w[1] * z[1] + w[2] * z[2]) / (side * area);
            l->items[l->count++] =
                (fragment){(float)fmin(fmax(depth, low), high), (uint32_t)y * job->window_px + (uint32_t)x, kind};
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
static void sort_fragments(sampler *job, uint32_t texels)
{
    const fragment_list *l = &job->fragments;
    memset(job->first, 0, (texels + 1) * sizeof *job->first);
    for (size_t n = 0; n < l->count; n++) job->first[l->items[n].texel + 1]++;
    for (uint32_t n = 0; n < texels; n++) job->first[n + 1] += job->first[n];
    for (size_t n = l->count; n-- > 0;) job->sorted[--job->first[l->items[n].texel + 1]] = l->items[n];
    /* every first[n + 1] has become the start of texel n */
    memmove(job->first, job->first + 1, texels * sizeof *job->first);
    job->first[texels] = (uint32_t)l->count;
    for (uint32_t texel = 0; texel < texels; texel++)
        sort_near_to_far(job->sorted + job->first[texel], job->first[texel + 1] - job->first[texel]);
}

/* The column of a texel, as depth_block.c means it. Returns the back faces up to the exit. */
static uint32_t walk(const fragment *f, uint32_t count, float *enter, float *exit)
{
    int      open  = 0;
    uint32_t backs = 0;
    float    solid = INFINITY, first_back = INFINITY, sheet = INFINITY, last = INFINITY;
    for (uint32_t n = 0; n < count; n++) {
        if (f[n].kind == FACE_SHEET) {
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

static vxs_result insert_window(sampler *job)
{
    dag           d       = {0};
    column_square columns = depth_maps_square(&job->maps);
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
    const block *b = block_at(set, node->block[0]);
    for (const block_tile *t = b->tile; t < b->tile + BLOCK_TILES; t++)
        if (t->kind != TILE_UNIFORM) return 1;
    return 0;
}

/* Window n as a node of its own. Where no tile needs a pattern nothing is kept: among its neighbours, the slope that it would have with
 * them settles it. */
static vxs_result build_window(sampler *job, uint32_t n)
{
    block_set    *set     = &job->set;
    size_t        before  = set->node_count;
    column_square columns = depth_maps_square(&job->maps);
    columns.u_px          = n % CELLS_MAX * NODE_PX;
    columns.v_px          = n / CELLS_MAX * NODE_PX;
    vxs_result r          = block_build_node(set, &columns, 0, 0, 0);
    if (set->node_count > before && !has_pattern(set, &set->nodes[before])) set->node_count = before;
    return r;
}

static vxs_result sample_window(sampler *job, uint32_t n)
{
    uint32_t    texels = job->window_px * job->window_px;
    map_sample *s      = job->s;
    s->texels += texels;
    if (!job->lists[n].count) return VXS_OK; /* all lit */

    size_t looked_at     = 0;
    job->fragments.count = 0;
    while (looked_at < job->lists[n].count && job->fragments.count < WINDOW_FRAGMENTS_MAX && !job->out_of_memory)
        rasterize(job, n, job->lists[n].items[looked_at++]);
    job->fragments_made += job->fragments.count;
    if (job->out_of_memory || !array_reserve(&job->sorted, &job->sorted_capacity, job->fragments.count + 1, sizeof *job->sorted))
        return VXS_E_MEMORY;
    sort_fragments(job, texels);

    uint32_t layers = 0;
    for (uint32_t texel = 0; texel < texels; texel++) {
        uint32_t from = job->first[texel], count = job->first[texel + 1] - from;
        job->maps.enter[texel] = job->maps.exit[texel] = job->p->reversed ? 0 : 1;
        uint32_t backs = walk(job->sorted + from, count, &job->maps.enter[texel], &job->maps.exit[texel]);
        layers         = backs > layers ? backs : layers;
    }
    uint64_t all = (uint64_t)layers * job->lists[n].count / looked_at;
    s->layers += all < PEEL_PASSES_MAX ? all : PEEL_PASSES_MAX;
    s->peeled_windows += layers > 0;
    depth_maps_reduce(&job->maps, 1);
    return job->coding == CODING_BLOCKS ? build_window(job, n) : insert_window(job);
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
    for (uint32_t rank = 0; rank < job->windows && job->fragments_made < FRAGMENTS_MAX && r == VXS_OK; rank++)
        r = sample_window(job, window_of_rank(job, rank));
    if (r != VXS_OK || job->out_of_memory) return VXS_E_MEMORY;
    if (job->coding == CODING_BLOCKS) return count_blocks_kept(job);
    s->unique_masks = different(job->hashes[SAMPLE_LEVELS], job->hash_count[SAMPLE_LEVELS]);
    for (int l = 0; l < SAMPLE_LEVELS; l++) s->unique_nodes += different(job->hashes[l], job->hash_count[l]);
    return VXS_OK;
}

static void sampler_free(sampler *job)
{
    for (int n = 0; n < CELLS_MAX * CELLS_MAX; n++) free(job->lists[n].items);
    for (int l = 0; l <= SAMPLE_LEVELS; l++) free(job->hashes[l]);
    block_set_free(&job->set);
    free(job->blocks.all);
    free(job->fragments.items);
    free(job->sorted);
    free(job->first);
    depth_maps_free(&job->maps);
    free(job);
}

/* Every 64th texel of a map of 4096; all of small ones. */
static uint32_t windows_a_side(uint32_t side_px)
{
    uint32_t windows = side_px / SAMPLE_WINDOW_PX, cells = side_px / 256;
    cells = cells < 8 ? 8 : cells > CELLS_MAX ? CELLS_MAX : cells;
    return windows < 1 ? 1 : min_u32(windows, cells);
}

vxs_result map_sample_take(map_sample *s, const projection *p, const vxs_light *light, int peels_all, const bake_options *o,
                           message *m)
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
    job->side_px   = 1u << light->levels;
    job->window_px = min_u32(job->side_px, SAMPLE_WINDOW_PX);
    job->cells     = windows_a_side(job->side_px);
    job->cell_px   = job->side_px / job->cells;
    job->windows   = job->cells * job->cells;

    uint32_t   texels = job->window_px * job->window_px;
    vxs_result r      = VXS_E_MEMORY;
    job->blocks.side  = job->side_px / min_u32(job->side_px, BLOCK_MAX_PX);
    size_t blocks     = (size_t)(job->blocks.side + 1) * (job->blocks.side + 1);
    job->blocks.all   = calloc(3 * blocks, sizeof *job->blocks.all);
    job->first        = malloc((texels + 1) * sizeof *job->first);
    double log        = light->kind != VXS_LIGHT_KIND_DIRECTIONAL ? light->voxel_metres : 0;
    if (job->blocks.all && job->first && depth_maps_init(&job->maps, job->window_px, job->side_px, log, 1, m) == VXS_OK) {
        job->blocks.solid = job->blocks.all + blocks;
        job->blocks.meet  = job->blocks.solid + blocks;
        place_windows(job);
        place_triangles(job);
        count_blocks(job);
        count_tiles(job);
        r         = job->out_of_memory ? VXS_E_MEMORY : sample_windows(job);
        s->weight = s->texels ? (double)job->side_px * job->side_px / (double)s->texels : 0;
    }
    sampler_free(job);
    if (r == VXS_OK) return VXS_OK;
    memset(s, 0, sizeof *s);
    return fail(m, r, "out of memory for a sample of a map");
}
