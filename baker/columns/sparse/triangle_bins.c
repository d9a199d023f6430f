/* Binning by boxes; see triangle_bins.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/triangle_bins.h"

#include <stdlib.h>

#include "baker/base/integer.h"
#include "baker/base/parallel.h"

enum {
    CHUNKS         = 64, /* chunks of triangles, counted and placed separately, so that bins do not depend on the number of
                            threads */
    IDS_A_TRIANGLE = 8,  /* on average, at most */
    LEAST_CELL_PX  = 256,
};

typedef struct binner {
    triangle_bins          *b;
    const sparse_triangles *s;
    uint32_t                cell_log2; /* subtexels of a cell */
    size_t                 *place;     /* [CHUNKS * cells^2] number of ids of a chunk in a cell, then their position */
} binner;

typedef struct cell_range {
    uint32_t i0, i1, j0, j1;
} cell_range;

static uint32_t cell_of(const binner *w, int32_t subtexels)
{
    return subtexels < 0 ? 0 : min_u32((uint32_t)subtexels >> w->cell_log2, w->b->cells - 1);
}

/* Returns 0 if the triangle's box is outside the map. */
static int cells_of(const binner *w, const sparse_triangle *t, cell_range *r)
{
    int32_t x0 = min_i32(min_i32(t->x[0], t->x[1]), t->x[2]), x1 = max_i32(max_i32(t->x[0], t->x[1]), t->x[2]);
    int32_t y0 = min_i32(min_i32(t->y[0], t->y[1]), t->y[2]), y1 = max_i32(max_i32(t->y[0], t->y[1]), t->y[2]);
    int32_t side = (int32_t)(w->b->cells << w->cell_log2);
    *r           = (cell_range){cell_of(w, x0), cell_of(w, x1), cell_of(w, y0), cell_of(w, y1)};
    return x1 >= 0 && y1 >= 0 && x0 <= side && y0 <= side;
}

static void walk_chunk(binner *w, size_t chunk, int place)
{
    triangle_bins *b     = w->b;
    size_t         count = (size_t)b->cells * b->cells, *at = w->place + chunk * count;
    cell_range     r;
    for (size_t n = w->s->count * chunk / CHUNKS; n < w->s->count * (chunk + 1) / CHUNKS; n++) {
        if (!cells_of(w, &w->s->all[n], &r)) continue;
        for (uint32_t j = r.j0; j <= r.j1; j++)
            for (uint32_t i = r.i0; i <= r.i1; i++) {
                size_t *to = &at[(size_t)j * b->cells + i];
                if (place) b->ids[*to] = (uint32_t)n;
                ++*to;
            }
    }
}

static void count_chunks(void *user, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    for (size_t n = begin; n < end; n++) walk_chunk(user, n, 0);
}

static void place_chunks(void *user, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    for (size_t n = begin; n < end; n++) walk_chunk(user, n, 1);
}

/* Order ids by cell, and in each cell by chunk. Returns their number. */
static size_t counts_to_places(binner *w)
{
    size_t cells = (size_t)w->b->cells * w->b->cells, sum = 0;
    for (size_t cell = 0; cell < cells; cell++) {
        w->b->first[cell] = sum;
        for (size_t chunk = 0; chunk < CHUNKS; chunk++) {
            size_t *at = &w->place[chunk * cells + cell], count = *at;
            *at = sum;
            sum += count;
        }
    }
    return w->b->first[cells] = sum;
}

static vxs_result bin(binner *w, uint32_t side_px, uint32_t threads)
{
    triangle_bins *b = w->b;
    for (b->cells = max_u32(min_u32(BINS_A_SIDE_MAX, side_px / LEAST_CELL_PX), 1);; b->cells /= 2) {
        size_t cells = (size_t)b->cells * b->cells;
        b->cell_px   = side_px / b->cells;
        w->cell_log2 = log2_u32(b->cell_px) + w->s->grid;
        free(w->place);
        free(b->first);
        w->place = calloc(CHUNKS * cells, sizeof *w->place);
        b->first = malloc((cells + 1) * sizeof *b->first);
        if (!w->place || !b->first) return VXS_E_MEMORY;
        parallel_for(threads, CHUNKS, 1, count_chunks, w);
        if (counts_to_places(w) <= IDS_A_TRIANGLE * (w->s->count + cells) || b->cells == 1) break;
    }
    b->ids = malloc((b->first[(size_t)b->cells * b->cells] + 1) * sizeof *b->ids);
    if (!b->ids) return VXS_E_MEMORY;
    parallel_for(threads, CHUNKS, 1, place_chunks, w);
    return VXS_OK;
}

vxs_result triangle_bins_init(triangle_bins *b, const sparse_triangles *s, uint32_t side_px, uint32_t threads)
{
    binner w     = {.b = b, .s = s};
    *b           = (triangle_bins){0};
    vxs_result r = bin(&w, side_px, threads);
    free(w.place);
    return r;
}

void triangle_bins_free(triangle_bins *b)
{
    free(b->first);
    free(b->ids);
    *b = (triangle_bins){0};
}
