/* Columns of a tile; see leaf.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/leaf.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/array.h"
#include "baker/base/integer.h"
#include "baker/scene/alpha_mask.h"

enum { HALF_PX = SUBTEXELS_PER_PX / 2, PAIRS = 32 }; /* pairs of texels: rows of four */

/* The texels of a tile while it is looked at: depths, INFINITY where there is none. */
typedef struct leaf {
    const leaf_desc    *d;
    const square_bound *bound;
    double              x0, y0;                                  /* centre of the first texel, subtexels */
    f64x2               sheet[PAIRS], solid[PAIRS], back[PAIRS]; /* nearest of each */
    size_t              solids;                                  /* triangles */
} leaf;

/* depths of a triangle -------------------------------------------------------------------------------------------------------- */

static f64x2 pair_x(const leaf *f, int pair)
{
    double x = f->x0 + 2 * SUBTEXELS_PER_PX * (pair & 3);
    return (f64x2){x, x + SUBTEXELS_PER_PX};
}

static double row_y(const leaf *f, int row)
{
    return f->y0 + SUBTEXELS_PER_PX * row;
}

/* Of a triangle that covers the tile. */
static void depths_of_whole(const leaf *f, const sparse_triangle *t, f64x2 depths[PAIRS])
{
    for (int pair = 0; pair < PAIRS; pair++) depths[pair] = sparse_depth(t, pair_x(f, pair), row_y(f, pair >> 2));
}

static void depths_of(const leaf *f, const sparse_triangle *t, f64x2 depths[PAIRS])
{
    const sparse_edge e[3] = {sparse_edge_of(t, 0), sparse_edge_of(t, 1), sparse_edge_of(t, 2)};
    const f64x2       zero = f64x2_all(0), none = f64x2_all(INFINITY);
    f64x2             along[3][4]; /* the edges' a x, the same in all rows */
    for (int k = 0; k < 3; k++)
        for (int n = 0; n < 4; n++) along[k][n] = f64x2_all(e[k].a) * pair_x(f, n);
    const double y0 = min_i32(min_i32(t->y[0], t->y[1]), t->y[2]), y1 = max_i32(max_i32(t->y[0], t->y[1]), t->y[2]);
    for (int row = 0; row < 8; row++) {
        double y = row_y(f, row);
        if (y < y0 || y > y1) { /* most triangles are small */
            for (int n = 0; n < 4; n++) depths[4 * row + n] = none;
            continue;
        }
        f64x2 of_row[3];
        for (int k = 0; k < 3; k++) of_row[k] = f64x2_all(e[k].b * y + e[k].c);
        for (int n = 0; n < 4; n++) {
            i64x2 inside =
                (along[0][n] + of_row[0] >= zero) & (along[1][n] + of_row[1] >= zero) & (along[2][n] + of_row[2] >= zero);
            depths[4 * row + n] = f64x2_select(inside, sparse_depth(t, pair_x(f, n), y), none);
        }
    }
}

/* holes ----------------------------------------------------------------------------------------------------------------------- */

/* Twice the area of a point and the edge from corner k to the next. */
static double share_of(const sparse_triangle *t, int k, double x, double y)
{
    int n = k < 2 ? k + 1 : 0;
    return ((double)t->x[n] - t->x[k]) * (y - t->y[k]) - ((double)t->y[n] - t->y[k]) * (x - t->x[k]);
}

static int is_hole(const sparse_triangles *s, uint32_t id, double x, double y)
{
    const sparse_triangle *t    = &s->all[id];
    const hole_uvq        *uvq  = s->uvq[id - s->holed_first];
    const alpha_mask      *mask = &s->casters->alpha_masks[s->mask_of[id - s->holed_first]];
    double                 u = 0, v = 0, q = 0;
    for (int k = 0; k < 3; k++) {
        double share = share_of(t, k < 2 ? k + 1 : 0, x, y); /* of the corner that the edge does not touch */
        u += share * (double)uvq[k].u;
        v += share * (double)uvq[k].v;
        q += share * (double)uvq[k].q;
    }
    return !alpha_mask_opaque(mask, &s->casters->images[mask->image], u / q, v / q);
}

/* A texel that something nearer hides is not asked about. */
static void add_holed(leaf *f, uint32_t id)
{
    f64x2 depths[PAIRS];
    depths_of(f, &f->d->triangles->all[id], depths);
    for (int n = 0; n < 64; n++) {
        double z = depths[n / 2][n % 2], *nearest = (double *)&f->sheet[n / 2] + n % 2;
        if (z < *nearest && !is_hole(f->d->triangles, id, pair_x(f, n / 2)[n % 2], row_y(f, n / 8))) *nearest = z;
    }
}

/* all triangles --------------------------------------------------------------------------------------------------------------- */

static void keep_nearest(f64x2 nearest[PAIRS], const f64x2 depths[PAIRS])
{
    for (int pair = 0; pair < PAIRS; pair++) nearest[pair] = f64x2_min(nearest[pair], depths[pair]);
}

static int add_triangle(leaf *f, leaf_scratch *s, const square_entry *e)
{
    const sparse_triangle *t                                            = &f->d->triangles->all[e->id];
    void (*find_depths)(const leaf *, const sparse_triangle *, f64x2 *) = e->bits & ENTRY_COVERS ? depths_of_whole : depths_of;
    if (sparse_is_sheet(t)) {
        f64x2 depths[PAIRS];
        find_depths(f, t, depths);
        keep_nearest(f->sheet, depths);
        return 1;
    }
    if (!array_reserve(&s->depths, &s->depth_capacity, (f->solids + 1) * PAIRS, sizeof *s->depths)) return 0;
    if (!array_reserve(&s->is_exit, &s->exit_capacity, f->solids + 1, sizeof *s->is_exit)) return 0;
    f64x2 *depths = s->depths + f->solids * PAIRS;
    find_depths(f, t, depths);
    keep_nearest(f->solid, depths);
    if (sparse_is_exit(t)) keep_nearest(f->back, depths);
    s->is_exit[f->solids++] = (uint8_t)sparse_is_exit(t);
    return 1;
}

/* exits ----------------------------------------------------------------------------------------------------------------------- */

static int any(i64x2 mask)
{
    return i64x2_bits(mask) != 0;
}

/* Front faces less back faces up to a layer of back faces; and the next layer, where it is nearer than *next. */
static f64x2 count_open(const leaf *f, const leaf_scratch *s, int pair, f64x2 layer, f64x2 *next)
{
    const f64x2 none = f64x2_all(INFINITY), one = f64x2_all(1);
    f64x2       open = f64x2_all(0);
    for (size_t k = 0; k < f->solids; k++) {
        f64x2 z      = s->depths[k * PAIRS + (size_t)pair];
        i64x2 before = z <= layer;
        f64x2 counts = (f64x2)((i64x2)one & before);
        if (s->is_exit[k]) {
            open -= counts;
            *next = f64x2_min(*next, f64x2_select(before, none, z));
        } else {
            open += counts;
        }
    }
    return open;
}

/* Where light leaves the solids that it has entered, in the texels of a pair that are `open`. */
static f64x2 exits_of(const leaf *f, const leaf_scratch *s, int pair, i64x2 open)
{
    const f64x2 none = f64x2_all(INFINITY), known = f64x2_all(f->bound->enter_most), left_out = f64x2_all(f->bound->left_out);
    f64x2       layer = f->back[pair], exit = left_out;
    open &= layer < none;
    for (int n = 0; n < EXIT_LAYERS_MAX && any(open); n++) {
        i64x2 behind = open & (layer > known);
        exit         = f64x2_select(behind, f64x2_min(layer, left_out), exit);
        open &= ~behind;
        if (!any(open)) return exit;
        f64x2 next = none, inside = f64x2_all(0);
        if (!f->d->nearest_back) inside = count_open(f, s, pair, layer, &next);
        i64x2 done = open & (inside <= f64x2_all(0));
        exit       = f64x2_select(done, layer, exit);
        open &= ~done;
        if (!any(open)) return exit;
        layer = next;
        open &= layer < none;
    }
    return f64x2_select(open, f->back[pair], exit);
}

/* the tile -------------------------------------------------------------------------------------------------------------------- */

static void write_pair(const leaf *f, const leaf_scratch *s, int pair, column_tile *out)
{
    const f64x2 far = f64x2_all(depth_none(f->d->scale)), near = far - f64x2_all(1);
    i64x2       solid_first = f->solid[pair] < f->sheet[pair];
    f64x2       e = f64x2_min(f->solid[pair], f->sheet[pair]), x = e;
    if (any(solid_first)) x = f64x2_select(solid_first, exits_of(f, s, pair, solid_first), x);
    e = f64x2_min(f64x2_max(e, near), far);
    x = f64x2_min(f64x2_max(x, near), far);
    for (int n = 0; n < 2; n++) {
        out->e[2 * pair + n] = depth_down(f->d->scale, e[n]);
        out->x[2 * pair + n] = depth_up(f->d->scale, x[n]);
    }
}

int leaf_columns(leaf_scratch *s, const leaf_desc *d, const square_list *l, const square_bound *b, texel_square square,
                 column_tile *out)
{
    leaf f;
    f.d      = d;
    f.bound  = b;
    f.x0     = (double)square.u * SUBTEXELS_PER_PX + HALF_PX;
    f.y0     = (double)square.v * SUBTEXELS_PER_PX + HALF_PX;
    f.solids = 0;
    for (int pair = 0; pair < PAIRS; pair++) f.sheet[pair] = f.solid[pair] = f.back[pair] = f64x2_all(INFINITY);
    for (size_t n = 0; n < l->count; n++)
        if (l->items[n].id < d->triangles->holed_first && !add_triangle(&f, s, &l->items[n])) return 0;
    for (size_t n = 0; n < l->count; n++)
        if (l->items[n].id >= d->triangles->holed_first) add_holed(&f, l->items[n].id);
    for (int pair = 0; pair < PAIRS; pair++) write_pair(&f, s, pair, out);
    return 1;
}

void leaf_scratch_free(leaf_scratch *s)
{
    free(s->depths);
    free(s->is_exit);
    *s = (leaf_scratch){0};
}
