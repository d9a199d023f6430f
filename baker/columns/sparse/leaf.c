/* Columns of a tile; see leaf.h.
 *
 * Texels are bits: which of them a triangle covers is whole numbers, and so is, once triangles are in order of depth, which of them it is
 * the first to meet and how many solids are open there. So depths are computed only where light enters or leaves. In order means that
 * depths of triangles that share a texel are apart; texels where they are not are sorted one by one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/leaf.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/array.h"
#include "baker/columns/sparse/lanes.h"
#include "baker/columns/sparse/lean.h"
#include "baker/scene/alpha_mask.h"

enum {
    OPEN_BITS = 8,   /* of the count of solids that are open; texels in more of them are sorted alone */
    MET_MAX   = 256, /* faces that are held against others; where more lie over each other, texels are sorted alone */
    FEW_FACES = 32   /* so many are sorted by insertion */
};

#define ALL_TEXELS UINT64_MAX

/* A triangle that may touch the tile. */
typedef struct leaf_face {
    const sparse_triangle *t;
    double                 lo, hi;  /* depths in the tile from the plane on that it leans on (lean.h) */
    double                 hi_most; /* of faces up to this one that were met */
    uint64_t               texels;  /* that it covers: bit u + 8 v; of `asked` ones */
    uint64_t               asked;
    uint64_t               met; /* of texels, those that had not left when it was met */
    uint32_t               id, covers;
} leaf_face;

/* What faces are sorted by. */
typedef struct leaf_place {
    double   depth;
    uint32_t face;
} leaf_place;

/* The texels of a tile while it is looked at. */
typedef struct leaf {
    const leaf_desc    *d;
    const square_bound *bound;
    int64_t             x0, y0; /* centre of the first texel, subtexels */
    uint64_t            unmet;  /* texels that have met nothing */
    uint64_t            inside; /* that are in a solid */
    uint64_t            left;   /* that light has left, and of which it matters what lies behind; none where nothing more is free */
    uint64_t            tangled; /* where depths are not apart */
    int                 frees;   /* 1: free behind the last surface */
    double              known;   /* the list lacks nothing that begins before it */
    uint64_t            open[OPEN_BITS];
    leaf_face          *faces;
    leaf_place         *places; /* [count] in order; [met] of those that texels have met which had not left */
    size_t              met;
    size_t              solids;
    double             *depths; /* [LANES * solids] of those that some texels of a row meet; INFINITY where one does not */
    uint8_t            *backs;  /* [solids] 1: of a back face */
    size_t              count;
    double              e[64], x[64]; /* depths, INFINITY where there is none */
} leaf;

static int64_t px_of(const leaf *f)
{
    return (int64_t)1 << f->d->triangles->grid;
}

/* coverage -------------------------------------------------------------------------------------------------------------------- */

/* The rows of the tile that a triangle may touch: [*begin, *end). */
static void rows_of(const leaf *f, const sparse_triangle *t, int *begin, int *end)
{
    const uint32_t grid = f->d->triangles->grid;
    const int64_t  y0   = min_i32(min_i32(t->y[0], t->y[1]), t->y[2]) - f->y0,
                  y1    = max_i32(max_i32(t->y[0], t->y[1]), t->y[2]) - f->y0;
    *begin              = y0 <= 0 ? 0 : (int)((y0 + px_of(f) - 1) >> grid < 8 ? (y0 + px_of(f) - 1) >> grid : 8);
    *end                = y1 < 0 ? 0 : (int)(y1 >> grid < 7 ? (y1 >> grid) + 1 : 8);
}

/* The texels whose centres are in a triangle. */
static uint64_t covered(const leaf *f, const sparse_triangle *t)
{
    i64s     at[3][8 / LANES], down[3];
    uint64_t outside = 0;
    int      begin, end;
    rows_of(f, t, &begin, &end);
    if (begin >= end) return 0;
    for (int k = 0; k < 3; k++) {
        const sparse_edge e      = sparse_edge_of(t, k);
        const int64_t     across = e.a * px_of(f), first = sparse_edge_at(&e, f->x0, f->y0 + begin * px_of(f));
        for (int n = 0; n < 8 / LANES; n++) at[k][n] = i64s_ramp(first + n * LANES * across, across);
        down[k] = i64s_all(e.b * px_of(f));
    }
    for (int row = begin; row < end; row++)
        for (int n = 0; n < 8 / LANES; n++) {
            outside |= (uint64_t)i64s_negative(at[0][n] | at[1][n] | at[2][n]) << (8 * row + n * LANES);
            for (int k = 0; k < 3; k++) at[k][n] += down[k];
        }
    return ~outside & (ALL_TEXELS << 8 * begin) & (ALL_TEXELS >> (64 - 8 * end));
}

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

static double x_of(const leaf *f, int texel)
{
    return (double)(f->x0 + (texel & 7) * px_of(f));
}

static double y_of(const leaf *f, int texel)
{
    return (double)(f->y0 + (texel >> 3) * px_of(f));
}

static uint64_t without_holes(const leaf *f, uint32_t id, uint64_t texels)
{
    for (uint64_t rest = texels; rest; rest &= rest - 1) {
        int n = __builtin_ctzll(rest);
        if (is_hole(f->d->triangles, id, x_of(f, n), y_of(f, n))) texels &= ~((uint64_t)1 << n);
    }
    return texels;
}

/* depths ---------------------------------------------------------------------------------------------------------------------- */

static void put_depths(const leaf *f, double depths[64], const sparse_triangle *t, uint64_t texels)
{
    const f64s x = f64s_ramp((double)f->x0, (double)px_of(f)), step = f64s_all((double)(LANES * px_of(f)));
    for (int row = 0; row < 8; row++) {
        if (!(texels >> 8 * row & 0xff)) continue;
        f64s at = x;
        for (int n = 0; n < 8 / LANES; n++, at += step) {
            uint32_t bits = (uint32_t)(texels >> (8 * row + n * LANES)) & ((1u << LANES) - 1);
            double  *to   = depths + 8 * row + n * LANES;
            if (bits) f64s_store(to, f64s_select(bits, lanes_depth(t, at, y_of(f, 8 * row)), f64s_load(to)));
        }
    }
}

/* Which of the texels a triangle meets behind another one, or, without another, behind a depth. */
static uint64_t met_behind(const leaf *f, const sparse_triangle *t, const sparse_triangle *other, double depth, uint64_t texels)
{
    f64s     limit  = f64s_all(depth);
    uint64_t behind = 0;
    for (int first = 0; first < 64; first += LANES) {
        if (!(texels >> first & ((1u << LANES) - 1))) continue;
        f64s x = f64s_ramp(x_of(f, first), (double)px_of(f));
        if (other) limit = lanes_depth(other, x, y_of(f, first));
        behind |= (uint64_t)i64s_negative((i64s)(lanes_depth(t, x, y_of(f, first)) > limit)) << first;
    }
    return behind & texels;
}

/* Depths that are not behind a triangle, in texels that it covers. */
static void end_depths(const leaf *f, double depths[64], const sparse_triangle *t, uint64_t texels)
{
    double met[64];
    put_depths(f, met, t, texels);
    for (; texels; texels &= texels - 1) {
        int n     = __builtin_ctzll(texels);
        depths[n] = least(depths[n], met[n]);
    }
}

/* Whether light leaves the triangle where its thickness ends. */
static int is_thick(const leaf *f, const sparse_triangle *t)
{
    return f->d->freedom.thickness > 0 && t->kind & SPARSE_FACES;
}

static void put_depth(double depths[64], uint64_t texels, double depth)
{
    for (; texels; texels &= texels - 1) depths[__builtin_ctzll(texels)] = depth;
}

/* in order of depth ----------------------------------------------------------------------------------------------------------- */

static void count_up(leaf *f, uint64_t texels)
{
    for (int n = 0; n < OPEN_BITS && texels; n++) {
        uint64_t carry = f->open[n] & texels;
        f->open[n] ^= texels;
        texels = carry;
    }
    f->tangled |= texels;
}

/* Returns which of the texels are at zero then. None is there before. */
static uint64_t count_down(leaf *f, uint64_t texels)
{
    uint64_t left = texels, some = 0;
    for (int n = 0; n < OPEN_BITS; n++) {
        uint64_t borrow = ~f->open[n] & left;
        f->open[n] ^= left;
        left = borrow;
        some |= f->open[n];
    }
    return texels & ~some;
}

/* Texels meet a sheet first, and light leaves it. */
static void meet_sheet(leaf *f, const sparse_triangle *t, uint64_t texels)
{
    put_depths(f, f->x, t, texels);
    if (f->frees || is_thick(f, t)) f->left |= texels;
    for (uint64_t rest = is_thick(f, t) ? texels : 0; rest; rest &= rest - 1) {
        int n   = __builtin_ctzll(rest);
        f->x[n] = freedom_through(&f->d->freedom, f->x[n]);
    }
}

/* Texels meet a triangle that is apart from all before it. */
static void meet(leaf *f, const sparse_triangle *t, uint64_t texels)
{
    uint64_t met = texels & f->unmet, within = texels & f->inside, next = texels & f->left, done;
    if (next) end_depths(f, f->x, t, next);
    f->left &= ~next;
    put_depths(f, f->e, t, met);
    f->unmet &= ~met;
    if (sparse_is_sheet(t)) {
        meet_sheet(f, t, met);
        return;
    }
    if (!sparse_is_exit(t)) {
        f->inside |= met;
        count_up(f, met | within);
        return;
    }
    uint64_t behind = 0; /* where the list lacks some */
    if (t->zmax > f->known) behind = met_behind(f, t, NULL, f->known, met | within);
    done = met | behind | (f->d->nearest_back ? within : count_down(f, within & ~behind));
    put_depths(f, f->x, t, done);
    for (uint64_t rest = behind; rest; rest &= rest - 1) {
        int n   = __builtin_ctzll(rest);
        f->x[n] = least(f->x[n], f->bound->left_out);
    }
    f->inside &= ~done;
    if (f->frees) f->left |= done;
}

/* all triangles --------------------------------------------------------------------------------------------------------------- */

/* Front faces are sorted by their nearest depths and back faces by their middles, as walls are: the ones end where a floor begins, the others
 * begin where a roof ends. */
static void lean_faces(leaf *f, const square_list *l, texel_square square)
{
    const lean w = lean_of(l, f->d->triangles, square);
    for (f->count = 0; f->count < l->count; f->count++) {
        const square_entry    *e    = &l->items[f->count];
        const sparse_triangle *t    = &f->d->triangles->all[e->id];
        leaf_face             *face = &f->faces[f->count];
        face->t                     = t;
        face->id                    = e->id;
        face->texels = face->asked = 0;
        face->covers               = e->bits & ENTRY_COVERS;
        lean_range(&w, e, t, &face->lo, &face->hi);
        f->places[f->count] = (leaf_place){sparse_is_exit(t) ? (face->lo + face->hi) / 2 : face->lo, (uint32_t)f->count};
    }
}

static int compare_places(const void *a, const void *b)
{
    const leaf_place *p = a, *q = b;
    return p->depth < q->depth ? -1 : p->depth > q->depth ? 1 : p->face < q->face ? -1 : 1;
}

static void sort_places(leaf_place *places, size_t count)
{
    if (count > FEW_FACES) {
        qsort(places, count, sizeof *places, compare_places);
        return;
    }
    for (size_t n = 1; n < count; n++) {
        leaf_place place = places[n];
        size_t     to    = n;
        for (; to && places[to - 1].depth > place.depth; to--) places[to] = places[to - 1];
        places[to] = place;
    }
}

/* Face n in order. */
static leaf_face *face_at(const leaf *f, size_t n)
{
    return &f->faces[f->places[n].face];
}

/* Find out which of some texels a face covers. */
static void ask(const leaf *f, leaf_face *face, uint64_t texels)
{
    uint64_t covers = texels & (face->covers ? ALL_TEXELS : covered(f, face->t));
    if (face->t->kind & SPARSE_HOLED) covers = without_holes(f, face->id, covers);
    face->texels |= covers;
    face->asked |= texels;
}

/* Which of its texels meet a face that is no later than another one which they have met already. */
static uint64_t tangles(const leaf *f, const leaf_face *face)
{
    const leaf_face *before;
    uint64_t         tangled = 0;
    for (size_t n = f->met; n-- && (before = face_at(f, n))->hi_most >= face->lo;) {
        const uint64_t both = before->met & face->texels & ~tangled;
        if (both && before->hi >= face->lo)
            tangled |= before->lo > face->hi ? both : both & ~met_behind(f, face->t, before->t, 0, both);
    }
    return tangled;
}

/* Meet all faces in order. Only texels that have not left yet matter, those of which it matters what is next, and those that may have left
 * too early. */
static void meet_all(leaf *f)
{
    double hi_most = -INFINITY;
    for (size_t n = 0; n < f->count; n++) {
        leaf_face     *face    = face_at(f, n);
        const uint64_t pending = f->unmet | f->inside | f->left;
        if (!pending && face->lo > hi_most) continue;
        ask(f, face, ALL_TEXELS);
        if (!face->texels) continue;
        f->tangled |= tangles(f, face);
        face->met = face->texels & pending;
        if (!face->met) continue;
        if (f->met == MET_MAX) {
            f->tangled = ALL_TEXELS;
            return;
        }
        meet(f, face->t, face->met);
        face->hi_most = hi_most  = greatest(hi_most, face->hi);
        f->places[f->met++].face = (uint32_t)(face - f->faces); /* those that were met stay, in order */
    }
}

/* where depths are not apart -------------------------------------------------------------------------------------------------- */

/* Front faces less back faces up to a layer of back faces; and the next layer, where it is nearer than *next. */
static f64s count_open(const leaf *f, f64s layer, f64s *next)
{
    const f64s none = f64s_all(INFINITY), one = f64s_all(1);
    f64s       open = f64s_all(0);
    for (size_t n = 0; n < f->solids; n++) {
        f64s z      = f64s_load(f->depths + n * LANES);
        i64s before = (i64s)(z <= layer);
        f64s counts = (f64s)((i64s)one & before);
        if (f->backs[n]) {
            open -= counts;
            *next = f64s_min(*next, f64s_choose(before, none, z));
        } else {
            open += counts;
        }
    }
    return open;
}

/* Where light leaves the solids that it has entered, in the texels that are `open`. */
static f64s exits_of(const leaf *f, f64s layer, i64s open)
{
    const f64s none = f64s_all(INFINITY), known = f64s_all(f->known), left_out = f64s_all(f->bound->left_out);
    f64s       exit = left_out;
    for (;;) {
        open &= (i64s)(layer < none);
        i64s behind = open & (i64s)(layer > known);
        exit        = f64s_choose(behind, f64s_min(layer, left_out), exit);
        open &= ~behind;
        if (!i64s_negative(open)) return exit;
        f64s next = none, inside = f64s_all(0);
        if (!f->d->nearest_back) inside = count_open(f, layer, &next);
        i64s done = open & (i64s)(inside <= f64s_all(0));
        exit      = f64s_choose(done, layer, exit);
        open &= ~done;
        layer = next;
    }
}

/* The same of one texel, by sorting all that it meets.   lane  of depths */
static double exit_of(leaf *f, int lane)
{
    size_t  count = 0;
    int64_t open  = 0;
    for (size_t n = 0; n < f->solids; n++) {
        double z = f->depths[LANES * n + (size_t)lane];
        if (z < INFINITY) f->places[count++] = (leaf_place){z, f->backs[n]}; /* front faces first of those at one depth */
    }
    sort_places(f->places, count);
    for (size_t n = 0; n < count; n++) {
        const leaf_place *hit = &f->places[n];
        if (!hit->face) {
            open++;
            continue;
        }
        if (hit->depth > f->known) return least(hit->depth, f->bound->left_out);
        if (--open <= 0 || f->d->nearest_back) return hit->depth;
    }
    return f->bound->left_out;
}

static f64s exits_by_sorting(leaf *f, uint32_t texels)
{
    double exits[LANES];
    for (int lane = 0; lane < LANES; lane++) exits[lane] = texels >> lane & 1 ? exit_of(f, lane) : INFINITY;
    return f64s_load(exits);
}

/* All that texels of a row meet, as far as it says what is free besides the insides of solids. */
typedef struct free_depths {
    f64s first, next, last;
    f64s thick; /* the first of what is thick */
} free_depths;

static void add_depths(free_depths *d, f64s z, uint32_t met, int thick)
{
    d->next  = f64s_min(d->next, f64s_max(d->first, z));
    d->first = f64s_min(d->first, z);
    d->last  = f64s_max(d->last, f64s_select(met, z, f64s_all(-INFINITY)));
    if (thick) d->thick = f64s_min(d->thick, z);
}

/* Exits where more is free. */
static f64s later_exits(const leaf *f, const free_depths *d, f64s exits)
{
    const f64s none = f64s_all(INFINITY);
    double     through[LANES];
    f64s_store(through, d->first);
    for (int n = 0; n < LANES; n++) through[n] = freedom_through(&f->d->freedom, through[n]);
    f64s x = f64s_choose((i64s)(d->thick == d->first), f64s_min(f64s_load(through), d->next), exits);
    return f->frees ? f64s_choose((i64s)(d->last <= exits), none, x) : x;
}

/* A few texels of a row by the depths of all that they meet.   texels  bits, as f64s_select has them; `first` is the first */
static void untangle(leaf *f, uint32_t texels, int first)
{
    const f64s  none = f64s_all(INFINITY), x0 = f64s_ramp(x_of(f, first), (double)px_of(f));
    const int   looks_on = freedom_looks_on(&f->d->freedom);
    f64s        sheet = none, solid = none, back = none;
    free_depths all = {none, none, f64s_all(-INFINITY), none};
    f->solids       = 0;
    for (const leaf_face *face = f->faces; face < f->faces + f->count; face++) {
        const uint32_t met = (uint32_t)(face->texels >> first) & texels;
        if (!met) continue;
        f64s z = f64s_select(met, lanes_depth(face->t, x0, y_of(f, first)), none);
        if (looks_on) add_depths(&all, z, met, is_thick(f, face->t));
        if (sparse_is_sheet(face->t)) {
            sheet = f64s_min(sheet, z);
            continue;
        }
        solid = f64s_min(solid, z);
        if (sparse_is_exit(face->t)) back = f64s_min(back, z);
        f->backs[f->solids] = (uint8_t)sparse_is_exit(face->t);
        f64s_store(f->depths + LANES * f->solids++, z);
    }
    i64s solid_first = (i64s)(solid < sheet);
    f64s exits       = f->solids > FEW_FACES ? exits_by_sorting(f, i64s_negative(solid_first)) : exits_of(f, back, solid_first);
    f64s e = f64s_min(solid, sheet), x = f64s_choose(solid_first, exits, e);
    if (looks_on) x = later_exits(f, &all, x);
    f64s_store(f->e + first, f64s_select(texels, e, f64s_load(f->e + first)));
    f64s_store(f->x + first, f64s_select(texels, x, f64s_load(f->x + first)));
}

static void untangle_all(leaf *f)
{
    for (size_t n = 0; n < f->count && f->tangled; n++)
        if (f->tangled & ~f->faces[n].asked) ask(f, &f->faces[n], f->tangled & ~f->faces[n].asked);
    for (int first = 0; first < 64 && f->tangled; first += LANES) {
        uint32_t texels = (uint32_t)(f->tangled >> first) & ((1u << LANES) - 1);
        if (texels) untangle(f, texels, first);
    }
}

/* the tile -------------------------------------------------------------------------------------------------------------------- */

/* Depths in voxels, those of exits rounded up. */
static void round_depths(depth_scale s, const double depths[64], int up, uint32_t voxels[64])
{
    const f64s far = f64s_all(depth_none(s)), near = f64s_all(depth_none(s) - 1), depth_vx = f64s_all(s.depth_vx);
    double     in_voxels[LANES];
    for (int n = 0; n < 64; n += LANES) {
        f64s z = f64s_min(f64s_max(f64s_load(depths + n), near), far);
        if (s.voxel_log == 0) {
            z *= depth_vx;
        } else {
            f64s_store(in_voxels, z);
            for (int k = 0; k < LANES; k++) in_voxels[k] = depth_in_voxels(s, in_voxels[k]);
            z = f64s_load(in_voxels);
        }
        i32s down = __builtin_convertvector(z, i32s);
        if (up) down -= __builtin_convertvector((i64s)(__builtin_convertvector(down, f64s) < z), i32s);
        memcpy(voxels + n, &down, sizeof down);
    }
}

/* Whether one depth parts the columns; then their bounds say so. */
static int is_parted(const leaf *f, column_bounds *b)
{
    const depth_scale s = f->d->scale;
    f64s              e = f64s_load(f->e), x = f64s_load(f->x);
    for (int n = LANES; n < 64; n += LANES) {
        e = f64s_max(e, f64s_load(f->e + n));
        x = f64s_min(x, f64s_load(f->x + n));
    }
    b->emin = b->emax = depth_down(s, depth_clamped(s, f64s_greatest(e)));
    b->xmin = b->xmax = depth_up(s, depth_clamped(s, f64s_least(x)));
    return b->emax <= b->xmin;
}

int AT_LEVEL(leaf_columns)(leaf_scratch *s, const leaf_desc *d, const square_list *l, const square_bound *b, texel_square square,
                           column_tile *out, column_bounds *bounds)
{
    leaf f;
    if (!array_reserve(&s->faces, &s->face_capacity, l->count, sizeof *s->faces)) return 0;
    if (!array_reserve(&s->places, &s->place_capacity, l->count, sizeof *s->places)) return 0;
    if (!array_reserve(&s->backs, &s->back_capacity, l->count, sizeof *s->backs)) return 0;
    if (!array_reserve(&s->depths, &s->depth_capacity, l->count * LANES, sizeof *s->depths)) return 0;
    f.d       = d;
    f.bound   = b;
    f.x0      = ((int64_t)(2 * square.u + 1) << d->triangles->grid) / 2;
    f.y0      = ((int64_t)(2 * square.v + 1) << d->triangles->grid) / 2;
    f.unmet   = ALL_TEXELS;
    f.inside  = 0;
    f.left    = 0;
    f.tangled = 0;
    f.frees   = d->freedom.behind && !b->behind;
    f.known   = f.frees ? INFINITY : b->enter_most;
    f.met     = 0;
    f.faces   = s->faces;
    f.places  = s->places;
    f.backs   = s->backs;
    f.depths  = s->depths;
    memset(f.open, 0, sizeof f.open);
    lean_faces(&f, l, square);
    sort_places(f.places, f.count);
    meet_all(&f);
    put_depth(f.e, f.unmet, INFINITY);
    put_depth(f.x, f.unmet, INFINITY);
    put_depth(f.x, f.inside, b->left_out);
    if (f.frees) put_depth(f.x, f.left, INFINITY);
    untangle_all(&f);
    if (!d->every_texel && is_parted(&f, bounds)) return 1;
    round_depths(d->scale, f.e, 0, out->e);
    round_depths(d->scale, f.x, 1, out->x);
    *bounds = tile_bounds(out);
    return 1;
}
