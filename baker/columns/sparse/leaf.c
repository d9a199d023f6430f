/* Columns of a tile; see leaf.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/leaf.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/array.h"
#include "baker/scene/alpha_mask.h"

enum { HALF_PX = SUBTEXELS_PER_PX / 2, PAIRS = 32 }; /* pairs of texels: rows of four */

/* The texels of a tile while it is looked at: depths, INFINITY where there is none. */
typedef struct leaf {
    const leaf_desc    *d;
    const square_bound *bound;
    double              x0, y0;                                  /* centre of the first texel, subtexels */
    f64x2               sheet[PAIRS], solid[PAIRS], back[PAIRS]; /* nearest of each */
    size_t              solids, backs;                           /* triangles */
} leaf;

/* depths of a triangle -------------------------------------------------------------------------------------------------------- */

static f64x2 pair_x(const leaf *f, int pair)
{
    double x = f->x0 + 2 * SUBTEXELS_PER_PX * (pair & 3);
    return (f64x2){x, x + SUBTEXELS_PER_PX};
}

static double pair_y(const leaf *f, int pair)
{
    return f->y0 + SUBTEXELS_PER_PX * (pair >> 2);
}

static void depths_of(const leaf *f, const sparse_triangle *t, int covers, f64x2 depths[PAIRS])
{
    const sparse_edge e[3] = {sparse_edge_of(t, 0), sparse_edge_of(t, 1), sparse_edge_of(t, 2)};
    const f64x2       zero = f64x2_all(0), none = f64x2_all(INFINITY);
    for (int pair = 0; pair < PAIRS; pair++) {
        f64x2  x = pair_x(f, pair);
        double y = pair_y(f, pair);
        f64x2  z = sparse_depth(t, x, y);
        if (!covers) {
            i64x2 inside = f64x2_all(e[0].a) * x + f64x2_all(e[0].b * y + e[0].c) >= zero;
            inside &= f64x2_all(e[1].a) * x + f64x2_all(e[1].b * y + e[1].c) >= zero;
            inside &= f64x2_all(e[2].a) * x + f64x2_all(e[2].b * y + e[2].c) >= zero;
            z = f64x2_select(inside, z, none);
        }
        depths[pair] = z;
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
    depths_of(f, &f->d->triangles->all[id], 0, depths);
    for (int n = 0; n < 64; n++) {
        double z = depths[n / 2][n % 2], *nearest = (double *)&f->sheet[n / 2] + n % 2;
        if (z < *nearest && !is_hole(f->d->triangles, id, pair_x(f, n / 2)[n % 2], pair_y(f, n / 2))) *nearest = z;
    }
}

/* all triangles --------------------------------------------------------------------------------------------------------------- */

static void keep_nearest(f64x2 nearest[PAIRS], const f64x2 depths[PAIRS])
{
    for (int pair = 0; pair < PAIRS; pair++) nearest[pair] = f64x2_min(nearest[pair], depths[pair]);
}

static int add_triangle(leaf *f, leaf_scratch *s, const square_entry *e)
{
    const sparse_triangle *t = &f->d->triangles->all[e->id];
    if (sparse_is_sheet(t)) {
        f64x2 depths[PAIRS];
        depths_of(f, t, e->bits & ENTRY_COVERS, depths);
        keep_nearest(f->sheet, depths);
        return 1;
    }
    if (!array_reserve(&s->depths, &s->depth_capacity, (f->solids + 1) * PAIRS, sizeof *s->depths)) return 0;
    if (!array_reserve(&s->is_exit, &s->exit_capacity, f->solids + 1, sizeof *s->is_exit)) return 0;
    f64x2 *depths = s->depths + f->solids * PAIRS;
    depths_of(f, t, e->bits & ENTRY_COVERS, depths);
    keep_nearest(f->solid, depths);
    if (sparse_is_exit(t)) keep_nearest(f->back, depths);
    f->backs += (size_t)sparse_is_exit(t);
    s->is_exit[f->solids++] = (uint8_t)sparse_is_exit(t);
    return 1;
}

/* exits ----------------------------------------------------------------------------------------------------------------------- */

static int any(i64x2 mask)
{
    return i64x2_bits(mask) != 0;
}

/* Where light leaves the solids that it has entered, in the texels of a pair that are `open`. */
static f64x2 exits_of(const leaf *f, const leaf_scratch *s, int pair, i64x2 open)
{
    const f64x2 none = f64x2_all(INFINITY), known = f64x2_all(f->bound->enter_most), one = f64x2_all(1), zero = f64x2_all(0);
    const f64x2 left_out = f64x2_all(f->bound->left_out);
    f64x2       layer = f->back[pair], exit = left_out;
    open &= layer < none;
    for (int n = 0; n < EXIT_LAYERS_MAX && any(open); n++) {
        f64x2 next = none, inside = zero;
        for (size_t k = 0; k < f->solids && !f->d->nearest_back; k++) {
            f64x2 z      = s->depths[k * PAIRS + (size_t)pair];
            i64x2 before = z <= layer;
            f64x2 counts = (f64x2)((i64x2)one & before);
            inside += s->is_exit[k] ? -counts : counts;
            if (s->is_exit[k]) next = f64x2_min(next, f64x2_select(before, none, z));
        }
        i64x2 behind = layer > known, done = open & ((inside <= zero) | behind);
        exit  = f64x2_select(done, f64x2_select(behind, f64x2_min(layer, left_out), layer), exit);
        layer = next;
        open &= ~done & (layer < none);
    }
    return f64x2_select(open, f->back[pair], exit);
}

/* the tile -------------------------------------------------------------------------------------------------------------------- */

static void write_pair(const leaf *f, const leaf_scratch *s, int pair, column_tile *out)
{
    const f64x2 far = f64x2_all(f->d->scale.voxel_log != 0 ? 0 : 1), near = far - f64x2_all(1);
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
    leaf f = {.d     = d,
              .bound = b,
              .x0    = (double)square.u * SUBTEXELS_PER_PX + HALF_PX,
              .y0    = (double)square.v * SUBTEXELS_PER_PX + HALF_PX};
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
