/* Sampling a map; see map_sample.h.
 *
 * A window is rasterized by hand: every triangle at a texel's centre is kept, and the ray through it walks along them. That is the
 * exit depth that depth_block.c peels, found another way; it is slow per texel, and few are needed.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/map_sample.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/integer.h"
#include "baker/base/random.h"
#include "baker/columns/opengl/depth_block.h"
#include "baker/columns/stored/depth_maps.h"

enum { CELLS_MAX = 32 }; /* windows a side */

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
    uint32_t  count, capacity;
} triangle_list;

/* Counts of triangles by block, as differences along both axes until they are summed up. */
typedef struct block_counts {
    uint32_t side;
    int32_t *all, *solid, *meet; /* [(side + 1)^2] */
} block_counts;

typedef struct sampler {
    map_sample       *s;
    const projection *p;
    const vxs_light  *light;
    int               peels_all, reuse;
    mask_rule         rule;
    uint32_t          side_px, window_px, cells, cell_px;
    block_counts      blocks;
    uint32_t          at[CELLS_MAX * CELLS_MAX][2]; /* texel where each window starts */
    triangle_list     lists[CELLS_MAX * CELLS_MAX]; /* what may touch it */
    fragment_list     fragments;
    fragment         *sorted;
    uint32_t         *first; /* [window texels + 1] */
    depth_maps        maps;
    uint64_t         *hashes[SAMPLE_LEVELS + 1]; /* of all inserted nodes by level, masks last */
    size_t            hash_count[SAMPLE_LEVELS + 1], hash_capacity[SAMPLE_LEVELS + 1];
    int               out_of_memory;
} sampler;

static int reserve(void **items, size_t *capacity, size_t needed, size_t size)
{
    if (needed <= *capacity) return 1;
    size_t more  = needed < 1024 ? 1024 : needed * 2;
    void  *grown = realloc(*items, more * size);
    if (!grown) return 0;
    *items    = grown;
    *capacity = more;
    return 1;
}

/* what lies where --------------------------------------------------------------------------------------------------------------- */

static void place_windows(sampler *j)
{
    uint32_t places = j->cell_px / j->window_px;
    for (uint32_t n = 0; n < j->cells * j->cells; n++) {
        rng r       = rng_split(1, n);
        j->at[n][0] = n % j->cells * j->cell_px + rng_below(&r, places) * j->window_px;
        j->at[n][1] = n / j->cells * j->cell_px + rng_below(&r, places) * j->window_px;
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

static void add_to_windows(sampler *j, uint32_t triangle, const texel_box *b)
{
    uint32_t i0 = (uint32_t)b->u0 / j->cell_px, i1 = (uint32_t)b->u1 / j->cell_px;
    uint32_t j0 = (uint32_t)b->v0 / j->cell_px, j1 = (uint32_t)b->v1 / j->cell_px;
    for (uint32_t y = j0; y <= j1; y++)
        for (uint32_t x = i0; x <= i1; x++) {
            uint32_t n = y * j->cells + x;
            if (!texel_box_touches(b, (int32_t)j->at[n][0], (int32_t)j->at[n][1], (int32_t)j->window_px)) continue;
            triangle_list *l        = &j->lists[n];
            size_t         capacity = l->capacity;
            if (!reserve((void **)&l->items, &capacity, (size_t)l->count + 1, sizeof *l->items)) {
                j->out_of_memory = 1;
                return;
            }
            l->capacity          = (uint32_t)capacity;
            l->items[l->count++] = triangle;
        }
}

static void place_triangles(sampler *j)
{
    const projection *p    = j->p;
    int32_t           last = (int32_t)j->side_px - 1;
    uint32_t          px   = min_u32(j->side_px, BLOCK_MAX_PX);
    for (size_t t = 0; t < p->triangle_count && !j->out_of_memory; t++) {
        texel_box b = texel_box_of(p, t);
        if (b.u0 > b.u1 || b.v0 > b.v1 || b.u1 < 0 || b.v1 < 0 || b.u0 > last || b.v0 > last) continue;
        b.u0        = b.u0 < 0 ? 0 : b.u0;
        b.v0        = b.v0 < 0 ? 0 : b.v0;
        b.u1        = b.u1 > last ? last : b.u1;
        b.v1        = b.v1 > last ? last : b.v1;
        uint32_t u0 = (uint32_t)b.u0 / px, v0 = (uint32_t)b.v0 / px, u1 = (uint32_t)b.u1 / px, v1 = (uint32_t)b.v1 / px;
        count_square(j->blocks.all, j->blocks.side, u0, v0, u1, v1);
        if (t < p->solid_triangle_count) count_square(j->blocks.solid, j->blocks.side, u0, v0, u1, v1);
        if (t < p->solid_triangle_count && (j->peels_all || !p->meets || p->meets[t]))
            count_square(j->blocks.meet, j->blocks.side, u0, v0, u1, v1);
        add_to_windows(j, (uint32_t)t, &b);
    }
}

static void count_blocks(sampler *j)
{
    map_sample   *s = j->s;
    block_counts *b = &j->blocks;
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
        s->peeled_triangles += b->meet[at] > 0 ? (uint64_t)b->solid[at] : 0;
    }
}

static int tile_has_triangles(const block_counts *b, uint32_t u0, uint32_t v0, uint32_t across)
{
    for (uint32_t n = 0; n < across * across; n++)
        if (b->all[(size_t)(v0 + n / across) * (b->side + 1) + u0 + n % across] > 0) return 1;
    return 0;
}

static void count_tiles(sampler *j)
{
    uint32_t block_px = min_u32(j->side_px, BLOCK_MAX_PX);
    for (uint32_t size = 0; size < TILE_SIZES; size++) {
        uint32_t tile = max_u32(block_px, min_u32(j->side_px, TILE_MAX_PX >> size)), across = tile / block_px;
        for (uint32_t v = 0; v < j->blocks.side; v += across)
            for (uint32_t u = 0; u < j->blocks.side; u += across) {
                j->s->tiles[size]++;
                j->s->tiles_empty[size] += !tile_has_triangles(&j->blocks, u, v, across);
            }
    }
}

/* a window ---------------------------------------------------------------------------------------------------------------------- */

/* What an edge has of a point: positive inside; on the edge itself, one of the two triangles that share it has it. */
static int inside(double value, double du, double dv)
{
    return value > 0 || (value == 0 && (dv > 0 || (dv == 0 && du < 0)));
}

static void rasterize(sampler *j, uint32_t n, uint32_t t)
{
    const projection *p = j->p;
    const uint32_t   *c = p->indices + 3 * (size_t)t;
    double            u[3], v[3], z[3];
    for (int k = 0; k < 3; k++) {
        u[k] = p->vertices[c[k]].u - j->at[n][0];
        v[k] = p->vertices[c[k]].v - j->at[n][1];
        z[k] = p->reversed ? -p->vertices[c[k]].z : p->vertices[c[k]].z;
    }
    double area = (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0]);
    if (area == 0) return;
    face_kind kind = t >= p->solid_triangle_count ? FACE_SHEET : area < 0 ? FACE_FRONT : FACE_BACK;
    double    side = area < 0 ? -1 : 1, low = p->reversed ? -1 : 0, high = p->reversed ? 0 : 1;
    double    last = j->window_px - 1;
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
            fragment_list *l = &j->fragments;
            if (!reserve((void **)&l->items, &l->capacity, l->count + 1, sizeof *l->items)) {
                j->out_of_memory = 1;
                return;
            }
            double depth         = (w[0] * z[0] + w[1] * z[1] + w[2] * z[2]) / (side * area);
            l->items[l->count++] = (fragment){(float)fmin(fmax(depth, low), high), (uint32_t)y * j->window_px + (uint32_t)x, kind};
        }
}

static int nearer(const fragment *a, const fragment *b)
{
    return a->depth != b->depth ? a->depth < b->depth : a->kind < b->kind;
}

/* Fragments by texel, in each from near to far. */
static void sort_fragments(sampler *j, uint32_t texels)
{
    const fragment_list *l = &j->fragments;
    memset(j->first, 0, (texels + 1) * sizeof *j->first);
    for (size_t n = 0; n < l->count; n++) j->first[l->items[n].texel + 1]++;
    for (uint32_t n = 0; n < texels; n++) j->first[n + 1] += j->first[n];
    for (size_t n = l->count; n-- > 0;) j->sorted[--j->first[l->items[n].texel + 1]] = l->items[n];
    /* every first[n + 1] has become the start of texel n */
    memmove(j->first, j->first + 1, texels * sizeof *j->first);
    j->first[texels] = (uint32_t)l->count;
    for (uint32_t texel = 0; texel < texels; texel++)
        for (uint32_t n = j->first[texel] + 1; n < j->first[texel + 1]; n++) {
            fragment f = j->sorted[n];
            uint32_t k = n;
            for (; k > j->first[texel] && nearer(&f, &j->sorted[k - 1]); k--) j->sorted[k] = j->sorted[k - 1];
            j->sorted[k] = f;
        }
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

static void take_hash(sampler *j, int level, uint64_t hash)
{
    if (!reserve((void **)&j->hashes[level], &j->hash_capacity[level], j->hash_count[level] + 1, sizeof **j->hashes)) {
        j->out_of_memory = 1;
        return;
    }
    j->hashes[level][j->hash_count[level]++] = hash;
}

static vxs_result insert_window(sampler *j)
{
    dag           d       = {0};
    column_square columns = depth_maps_square(&j->maps);
    build_options o       = {.rule = j->rule, .reuse = j->reuse};
    build_stats   stats   = {0};
    vxs_result    r       = dag_build_square(&d, &columns, square_level(j->window_px), 0, 0, &o, &stats);
    if (r != VXS_OK) return r;
    j->s->mask_runs += stats.mask_runs;
    j->s->mask_tiles += stats.mask_tiles;
    j->s->masks += d.mask_count;
    for (uint32_t n = 0; n < d.mask_count; n++) take_hash(j, SAMPLE_LEVELS, d.masks[n]);
    for (uint32_t l = 0; l < d.level_count; l++) {
        j->s->nodes[l] += d.level[l].count;
        for (uint32_t n = 0; n < d.level[l].count; n++) take_hash(j, (int)l, d.level[l].hash[n]);
    }
    dag_free(&d);
    return VXS_OK;
}

static vxs_result look_at(sampler *j, uint32_t n)
{
    uint32_t    texels = j->window_px * j->window_px;
    map_sample *s      = j->s;
    s->texels += texels;
    if (!j->lists[n].count) return VXS_OK; /* all lit */

    j->fragments.count = 0;
    for (uint32_t k = 0; k < j->lists[n].count && !j->out_of_memory; k++) rasterize(j, n, j->lists[n].items[k]);
    fragment *sorted = realloc(j->sorted, (j->fragments.count + 1) * sizeof *sorted);
    if (!sorted || j->out_of_memory) return VXS_E_MEMORY;
    j->sorted = sorted;
    sort_fragments(j, texels);

    uint32_t layers = 0;
    for (uint32_t texel = 0; texel < texels; texel++) {
        uint32_t from = j->first[texel], count = j->first[texel + 1] - from;
        j->maps.enter[texel] = j->maps.exit[texel] = j->p->reversed ? 0 : 1;
        uint32_t backs                             = walk(j->sorted + from, count, &j->maps.enter[texel], &j->maps.exit[texel]);
        layers                                     = backs > layers ? backs : layers;
    }
    s->layers += layers;
    s->peeled_windows += layers > 0;
    depth_maps_reduce(&j->maps, 1);
    return insert_window(j);
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

static vxs_result look_at_all(sampler *j)
{
    map_sample *s = j->s;
    vxs_result  r = VXS_OK;
    for (uint32_t n = 0; n < j->cells * j->cells && r == VXS_OK; n++) r = look_at(j, n);
    if (r != VXS_OK || j->out_of_memory) return VXS_E_MEMORY;
    s->unique_masks = different(j->hashes[SAMPLE_LEVELS], j->hash_count[SAMPLE_LEVELS]);
    for (int l = 0; l < SAMPLE_LEVELS; l++) s->unique_nodes += different(j->hashes[l], j->hash_count[l]);
    return VXS_OK;
}

static void sampler_free(sampler *j)
{
    for (int n = 0; n < CELLS_MAX * CELLS_MAX; n++) free(j->lists[n].items);
    for (int l = 0; l <= SAMPLE_LEVELS; l++) free(j->hashes[l]);
    free(j->blocks.all);
    free(j->fragments.items);
    free(j->sorted);
    free(j->first);
    depth_maps_free(&j->maps);
    free(j);
}

/* Every 64th texel of a map of 4096; all of small ones. */
static uint32_t windows_a_side(uint32_t side_px)
{
    uint32_t windows = side_px / SAMPLE_WINDOW_PX, cells = side_px / 256;
    cells = cells < 8 ? 8 : cells > CELLS_MAX ? CELLS_MAX : cells;
    return windows < 1 ? 1 : min_u32(windows, cells);
}

vxs_result map_sample_take(map_sample *s, const projection *p, const vxs_light *light, int peels_all, mask_rule rule, int reuse,
                           message *m)
{
    memset(s, 0, sizeof *s);
    sampler *j = calloc(1, sizeof *j);
    if (!j) return fail(m, VXS_E_MEMORY, "out of memory for a sample of a map");
    j->s         = s;
    j->p         = p;
    j->light     = light;
    j->peels_all = peels_all;
    j->reuse     = reuse;
    j->rule      = rule;
    j->side_px   = 1u << light->levels;
    j->window_px = min_u32(j->side_px, SAMPLE_WINDOW_PX);
    j->cells     = windows_a_side(j->side_px);
    j->cell_px   = j->side_px / j->cells;

    uint32_t   texels = j->window_px * j->window_px;
    vxs_result r      = VXS_E_MEMORY;
    j->blocks.side    = j->side_px / min_u32(j->side_px, BLOCK_MAX_PX);
    size_t blocks     = (size_t)(j->blocks.side + 1) * (j->blocks.side + 1);
    j->blocks.all     = calloc(3 * blocks, sizeof *j->blocks.all);
    j->first          = malloc((texels + 1) * sizeof *j->first);
    double log        = light->kind != VXS_LIGHT_KIND_DIRECTIONAL ? light->voxel_metres : 0;
    if (j->blocks.all && j->first && depth_maps_init(&j->maps, j->window_px, j->side_px, log, 1, m) == VXS_OK) {
        j->blocks.solid = j->blocks.all + blocks;
        j->blocks.meet  = j->blocks.solid + blocks;
        place_windows(j);
        place_triangles(j);
        count_blocks(j);
        count_tiles(j);
        r         = j->out_of_memory ? VXS_E_MEMORY : look_at_all(j);
        s->weight = s->texels ? (double)j->side_px * j->side_px / (double)s->texels : 0;
    }
    sampler_free(j);
    if (r == VXS_OK) return VXS_OK;
    memset(s, 0, sizeof *s);
    return fail(m, r, "out of memory for a sample of a map");
}
