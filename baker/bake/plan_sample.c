/* Samples of a light's maps; see plan.h.
 *
 * Each map is divided into cells. Each cell has one window of 32 x 32 texels, at a position that depends on the cell's number. A
 * window is made as in a bake: columns from the sparse source, from only the triangles that may touch a window; then masks and
 * inserted nodes, or palette blocks. Blocks and tiles with triangles are counted for whole maps.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/plan.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/cpu.h"
#include "baker/base/parallel.h"
#include "baker/base/random.h"
#include "baker/coding/blocks/blocks.h"
#include "baker/columns/sparse/sparse_columns.h"
#include "baker/light/projection.h"

enum {
    WINDOW_PX   = 4 << SAMPLE_LEVELS,
    CELLS_MAX   = 32,      /* a side */
    MAPS_FEW    = 8,       /* most maps that are sampled densely */
    ENTRIES_MAX = 1 << 22, /* limit for triangles in windows; if more overlap, windows are left out */
    WORKERS_MAX = 8,       /* threads that count triangles, each with its own counts */
    BATCH       = 16,      /* windows that are made at once */
};

/* Triangles of sheets, of solids without peeling, of solids with peeling. */
enum { CLASS_SHEET, CLASS_APART, CLASS_MEETS, CLASSES };

typedef struct window {
    uint32_t    cell; /* number of its cell */
    vxs_result  result;
    block_set   set; /* used: this one, or the DAG */
    dag         dag;
    build_stats stats;
} window;

typedef struct sampler {
    light_sample       *s;
    const vxs_light    *light;
    const bake_options *o;
    const casters      *c;
    int                 peels_all;
    uint32_t            workers;
    uint32_t            side_px, window_px;
    uint32_t            blocks, cells;                /* along a side of a map */
    uint32_t            block_log2, cell_log2;        /* log2 of their sides in texels */
    uint32_t            at[CELLS_MAX * CELLS_MAX][2]; /* column and row of each window, in windows */
    block_set           set;                          /* of the windows of all maps: nodes of one block each */
    dag_merger          merger;

    /* of the current map */
    uint32_t   map;
    projection p;
    uint8_t   *kept;                          /* [p.triangle_count] 1: may touch a window */
    int32_t   *counts;                        /* [workers][CLASSES][counts_size] of triangles by block */
    size_t     counts_size;                   /* (blocks + 1)^2: differences along both axes, then sums */
    size_t (*entries)[CELLS_MAX * CELLS_MAX]; /* [workers] triangles that may touch each window */
    column_map columns;
    window     batch[BATCH];
} sampler;

/* counts by block and window -------------------------------------------------------------------------------------------------- */

/* Place a window in each cell: every 64th texel of a map of 4096; all of small maps; fewer for many maps. */
static void place_windows(sampler *job, uint32_t maps)
{
    uint32_t windows = job->side_px / job->window_px, cells = job->side_px / 256;
    for (; maps > MAPS_FEW; maps /= 4) cells /= 2;
    job->cells      = min_u32(windows, max_u32(8, min_u32(cells, CELLS_MAX)));
    job->cell_log2  = log2_u32(job->side_px / job->cells);
    uint32_t places = windows / job->cells;
    for (uint32_t n = 0; n < job->cells * job->cells; n++) {
        rng r         = rng_split(1, n);
        job->at[n][0] = n % job->cells * places + rng_below(&r, places);
        job->at[n][1] = n / job->cells * places + rng_below(&r, places);
    }
}

static int class_of(const sampler *job, size_t triangle)
{
    const projection *p = &job->p;
    if (triangle >= p->solid_triangle_count) return CLASS_SHEET;
    if (job->o->maps == MAPS_SPARSE || job->o->exit == EXIT_BACK) return CLASS_APART;
    return job->peels_all || !p->meets || p->meets[triangle] ? CLASS_MEETS : CLASS_APART;
}

/* Count a triangle in each window that its box touches. Returns 1 if there are any. */
static int count_in_windows(const sampler *job, const texel_box *b, size_t *entries)
{
    int32_t side = (int32_t)job->window_px, shift = (int32_t)job->cell_log2, found = 0;
    for (int32_t y = b->v0 >> shift; y <= b->v1 >> shift; y++)
        for (int32_t x = b->u0 >> shift; x <= b->u1 >> shift; x++) {
            uint32_t n       = (uint32_t)y * job->cells + (uint32_t)x;
            int      touches = texel_box_touches(b, (int32_t)job->at[n][0] * side, (int32_t)job->at[n][1] * side, side);
            entries[n] += (size_t)touches;
            found |= touches;
        }
    return found;
}

static void count_triangles(void *user, size_t begin, size_t end, uint32_t worker)
{
    sampler *job  = user;
    int32_t  last = (int32_t)job->side_px - 1;
    for (size_t t = begin; t < end; t++) {
        texel_box b  = texel_box_of(&job->p, t);
        job->kept[t] = 0;
        if (b.u0 > b.u1 || b.v0 > b.v1 || b.u1 < 0 || b.v1 < 0 || b.u0 > last || b.v0 > last) continue;
        b = (texel_box){max_i32(b.u0, 0), max_i32(b.v0, 0), min_i32(b.u1, last), min_i32(b.v1, last)};

        /* count the triangle, by its class, in the blocks that its box touches */
        int32_t *counts = job->counts + (worker * CLASSES + (size_t)class_of(job, t)) * job->counts_size;
        int32_t  shift = (int32_t)job->block_log2, row = (int32_t)job->blocks + 1;
        int32_t  u0 = b.u0 >> shift, u1 = (b.u1 >> shift) + 1, v0 = b.v0 >> shift, v1 = (b.v1 >> shift) + 1;
        counts[v0 * row + u0]++;
        counts[v0 * row + u1]--;
        counts[v1 * row + u0]--;
        counts[v1 * row + u1]++;

        job->kept[t] = (uint8_t)count_in_windows(job, &b, job->entries[worker]);
    }
}

/* Triangles of a class that may touch a block. */
static uint64_t count_of(const sampler *job, int of, uint32_t u, uint32_t v)
{
    return (uint64_t)job->counts[(size_t)of * job->counts_size + (size_t)v * (job->blocks + 1) + u];
}

static void add_blocks(const sampler *job)
{
    light_sample *s = job->s;
    for (uint32_t n = 0; n < job->blocks * job->blocks; n++) {
        uint32_t u = n % job->blocks, v = n / job->blocks;
        uint64_t apart = count_of(job, CLASS_APART, u, v), meets = count_of(job, CLASS_MEETS, u, v);
        uint64_t all = count_of(job, CLASS_SHEET, u, v) + apart + meets;
        s->blocks++;
        s->blocks_empty += all == 0;
        s->blocks_peeled += meets > 0;
        s->blocks_not_peeled += apart > 0 && meets == 0;
        s->block_triangles += all;
        s->block_most = max_u64(s->block_most, all);
    }
}

/* Tiles of TILE_MAX_PX >> size texels a side, or the whole map. */
static void add_tiles(const sampler *job, uint32_t size)
{
    uint32_t across = max_u32(1, min_u32(job->side_px, TILE_MAX_PX >> size) >> job->block_log2); /* blocks along a side of a tile */
    uint32_t tiles  = job->blocks / across;
    for (uint32_t n = 0; n < tiles * tiles; n++) {
        uint64_t all = 0;
        for (uint32_t k = 0; k < across * across; k++)
            for (int of = 0; of < CLASSES; of++)
                all += count_of(job, of, n % tiles * across + k % across, n / tiles * across + k / across);
        job->s->tiles[size]++;
        job->s->tiles_empty[size] += all == 0;
    }
}

/* windows --------------------------------------------------------------------------------------------------------------------- */

static int has_pattern(const block_set *set, const packed_node *node)
{
    if (!(node->mixed & 1)) return 0;
    const block b = block_at(set, *node_parts(set, node));
    for (const block_tile *t = b.tile; t < b.tile + BLOCK_TILES; t++)
        if (t->kind != TILE_UNIFORM) return 1;
    return 0;
}

static vxs_result make_window(const sampler *job, window *w)
{
    build_options build   = {.rule = job->o->rule, .reuse = job->o->reuse};
    uint32_t      level   = square_level(job->window_px);
    column_map    columns = job->columns;
    column_square square;
    vxs_result    r = columns.fetch(columns.data, level, job->at[w->cell][0], job->at[w->cell][1], &square, NULL);
    if (r != VXS_OK) return r;
    if (job->o->coding == CODING_DAG) {
        r = dag_build_square(&w->dag, &square, level, 0, 0, &build, &w->stats);
    } else {
        /* Build the window as a node of its own. If no tile needs a pattern, nothing is kept: in a bake, the slope of the
         * surrounding node settles it. */
        int           cpu  = cpu_level();
        column_square node = square;
        w->set             = (block_set){.patterns.cpu = cpu, .privates.cpu = cpu};
        node.u_px          = w->cell % CELLS_MAX * NODE_PX;
        node.v_px          = w->cell / CELLS_MAX * NODE_PX;
        r                  = block_build_node(&w->set, &node, job->map, 0, 0);
        if (w->set.node_count && !has_pattern(&w->set, w->set.nodes)) block_set_free(&w->set);
    }
    columns.release(columns.data, &square);
    return r;
}

static void make_windows(void *user, size_t begin, size_t end, uint32_t worker)
{
    sampler *job = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) job->batch[n].result = make_window(job, &job->batch[n]);
}

static vxs_result add_window(sampler *job, window *w)
{
    light_sample *s = job->s;
    if (w->result != VXS_OK) return w->result;
    if (job->o->coding == CODING_BLOCKS) return block_set_merge(&job->set, &w->set);
    s->mask_tiles += w->stats.mask_tiles;
    s->mask_runs += w->stats.mask_runs;
    s->masks += w->dag.mask_count;
    for (uint32_t l = 0; l < w->dag.level_count; l++) s->nodes[l] += w->dag.level[l].count;
    return dag_merger_add(&job->merger, &w->dag, job->map, square_level(job->window_px), job->at[w->cell][0], job->at[w->cell][1]);
}

/* Cell of a rank: the rank with its bits reversed, so that the first cells are spread over the whole map. */
static uint32_t cell_of_rank(const sampler *job, uint32_t rank)
{
    uint32_t n = 0;
    for (uint32_t bit = 1; bit < job->cells * job->cells; bit *= 2) n = 2 * n + !!(rank & bit);
    return n;
}

/* Number of windows to make: fewer if many large triangles overlap. */
static uint32_t count_windows(const sampler *job)
{
    size_t   entries = 0;
    uint32_t rank    = 0;
    for (; rank < job->cells * job->cells; rank++) {
        for (uint32_t worker = 0; worker < job->workers; worker++) entries += job->entries[worker][cell_of_rank(job, rank)];
        if (rank && entries > ENTRIES_MAX) break;
    }
    return rank;
}

/* maps ------------------------------------------------------------------------------------------------------------------------ */

static vxs_result sample_map(sampler *job, run_context *m)
{
    const bake_options *o      = job->o;
    bake_context        ctx    = {.run = m, .threads = o->threads};
    sparse_columns      source = {.casters          = job->c,
                                  .light            = job->light,
                                  .free_behind      = o->behind == BEHIND_FREE,
                                  .thickness_metres = o->thickness_metres,
                                  .nearest_back     = o->exit == EXIT_BACK,
                                  .fetch_px         = job->window_px};
    vxs_result          r      = projection_init(&job->p, job->c, job->light, (int)job->map, o->threads, m);
    if (r != VXS_OK) return r;
    if (!(job->kept = malloc(job->p.triangle_count + 1))) return VXS_E_MEMORY;
    memset(job->counts, 0, job->workers * CLASSES * job->counts_size * sizeof *job->counts);
    memset(job->entries, 0, job->workers * sizeof *job->entries);
    parallel_for(job->workers, job->p.triangle_count, 4096, count_triangles, job);
    job->s->triangles += job->p.triangle_count;

    size_t row = job->blocks + 1, all = CLASSES * job->counts_size;
    for (size_t n = all; n < job->workers * all; n++) job->counts[n % all] += job->counts[n];
    for (size_t n = 0; n < all; n++) {
        size_t at = n % job->counts_size, u = at % row, v = at / row;
        job->counts[n] += (u ? job->counts[n - 1] : 0) + (v ? job->counts[n - row] : 0) - (u && v ? job->counts[n - row - 1] : 0);
    }

    add_blocks(job);
    for (uint32_t size = 0; size < TILE_SIZES; size++) add_tiles(job, size);

    if ((r = projection_keep(&job->p, job->kept)) != VXS_OK) return r;
    if ((r = sparse_columns_open(&source, &job->p, &job->columns, &ctx)) != VXS_OK) return r;

    /* make all windows of a map, and add them in an order that does not depend on the number of threads */
    uint32_t windows = count_windows(job);
    r                = VXS_OK;
    for (uint32_t rank = 0; rank < windows && r == VXS_OK; rank += BATCH) {
        uint32_t count = min_u32(BATCH, windows - rank);
        for (uint32_t k = 0; k < count; k++) job->batch[k] = (window){.cell = cell_of_rank(job, rank + k)};
        parallel_for(job->o->threads, count, 1, make_windows, job);
        for (window *w = job->batch; w < job->batch + count; w++) {
            if (r == VXS_OK) r = add_window(job, w);
            block_set_free(&w->set);
            dag_free(&w->dag);
        }
    }
    job->s->weight += windows;

    job->columns.close(job->columns.data);
    return r;
}

static vxs_result sample_maps(sampler *job, run_context *m)
{
    uint32_t   maps = vxs_map_count(job->light), windows = job->side_px / job->window_px;
    int        is_dag = job->o->coding == CODING_DAG;
    vxs_result r      = is_dag ? dag_merger_init(&job->merger, job->side_px, maps, 1) : VXS_OK;
    job->counts       = malloc(job->workers * CLASSES * job->counts_size * sizeof *job->counts);
    job->entries      = malloc(job->workers * sizeof *job->entries);
    if (!job->counts || !job->entries) r = VXS_E_MEMORY;
    for (job->map = 0; job->map < maps && r == VXS_OK; job->map++) {
        r = sample_map(job, m);
        projection_free(&job->p);
        free(job->kept);
        job->kept = NULL;
    }
    if (r != VXS_OK) return r;
    job->s->weight = (double)maps * windows * windows / job->s->weight;
    if (!is_dag) {
        /* lay out the windows as a bake would, as if they were the whole */
        enum { LEVELS = 13 }; /* of a map with a node for each window */
        light_sample *s = job->s;
        block_words   w;
        r = block_words_lay_out(&w, &job->set, LEVELS, maps, job->o->threads);
        if (r != VXS_OK) return r;
        s->mask_tiles       = job->set.tile_count;
        s->palette_blocks   = job->set.node_count;
        s->unique_blocks    = w.counts.blocks;
        s->block_words      = w.counts.block_words;
        s->pattern_words    = w.counts.pattern_words + w.counts.common_words;
        s->patterns         = (uint64_t)w.counts.patterns + w.counts.private_patterns + w.common_count;
        s->private_patterns = w.counts.private_patterns;
        block_words_free(&w);
        return VXS_OK;
    }
    job->s->unique_masks = job->merger.merged.mask_count;
    for (int l = 0; l < SAMPLE_LEVELS; l++) job->s->unique_nodes += job->merger.merged.level[l].count;
    return VXS_OK;
}

vxs_result plan_sample_light(plan_light *l, const bake_plan *plan, uint32_t maps, const bake_options *o, const casters *c,
                             run_context *m)
{
    sampler *job = malloc(sizeof *job);
    if (!job) return fail(m, VXS_E_MEMORY, "out of memory for a sample of a map");
    l->sample        = (light_sample){0};
    *job             = (sampler){.s         = &l->sample,
                                 .light     = &l->light,
                                 .o         = o,
                                 .c         = c,
                                 .peels_all = plan->peels_all,
                                 .workers   = min_u32(max_u32(o->threads, 1), WORKERS_MAX),
                                 .side_px   = 1u << l->light.levels};
    job->window_px   = min_u32(job->side_px, WINDOW_PX);
    job->block_log2  = log2_u32(min_u32(job->side_px, BLOCK_MAX_PX));
    job->blocks      = job->side_px >> job->block_log2;
    job->counts_size = (size_t)(job->blocks + 1) * (job->blocks + 1);
    place_windows(job, maps);
    vxs_result r = sample_maps(job, m);
    free(job->counts);
    free(job->entries);
    block_set_free(&job->set);
    dag_merger_free(&job->merger);
    free(job);
    return r == VXS_OK ? r : fail(m, r, "out of memory for a sample of a map");
}
