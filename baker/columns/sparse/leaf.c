/* Columns of a tile; see leaf.h.
 *
 * Integer arithmetic gives the texels that a triangle covers, as bits. Each of these texels keeps the triangle's depth if it is
 * among the nearest of its kind. These depths usually give the exit: the next front face lies behind the back face. Only
 * otherwise all faces are counted.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/leaf.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "baker/base/array.h"
#include "baker/base/cpu.h"
#include "baker/columns/sparse/lanes.h"
#include "baker/scene/scene.h"

enum {
    LAYERS    = 2,  /* nearest back faces that are checked for the exit without counting */
    FEW_FACES = 32, /* up to this number, all faces are counted for each layer of back faces; above it, the faces of a texel are
                       sorted */
    EDGE_LONG = 1 << 27, /* |a| + |b| of an edge; 16 times this must fit 32 bits, but for the sign */
};

#define ALL_TEXELS UINT64_MAX

/* A triangle that covers some texels of the tile. */
typedef struct leaf_face {
    const sparse_triangle *t;
    sparse_tags            tags;
    uint64_t               texels; /* covered texels: bit u + 8 v */
} leaf_face;

/* A face that a texel meets. */
typedef struct leaf_hit {
    double depth;
    int    is_exit;
} leaf_hit;

/* Nearest depths of the texels of a tile, in order; INFINITY where there is none. */
typedef struct nearest_depths {
    double        room[LAYERS + 1][64];
    const double *layers[LAYERS + 1]; /* the first `count` in `room`, the others all INFINITY */
    int           count, most;
} nearest_depths;

/* The texels of a tile during evaluation. */
typedef struct leaf {
    const leaf_desc    *d;
    const square_bound *bound;
    int64_t             x0, y0;           /* centre of the first texel, subtexels */
    double              x_of[8], y_of[8]; /* centres of texels */
    int                 free_behind;      /* 1: don't-care voxels behind the last surface */
    double              known;            /* the list has all triangles that begin before this depth; less than INFINITY */
    leaf_face          *faces;
    size_t              count;
    nearest_depths      front, back, sheet; /* of solids' front and back faces; of sheets */
    double              e[64], x[64];

    /* faces of solids, if they are counted */
    double   *depths; /* [LANES * solids] */
    uint8_t  *backs;  /* [solids] 1: of a back face */
    size_t    solids;
    leaf_hit *hits; /* [solids] scratch for sorting */
} leaf;

static int64_t px_of(const leaf *f)
{
    return (int64_t)1 << f->d->triangles->grid;
}

/* coverage -------------------------------------------------------------------------------------------------------------------- */

/* Texels outside an edge, whatever its length. */
static uint64_t outside_long(const leaf *f, const sparse_edge *e)
{
    const i64s across  = e->a * px_of(f) * (i64s)EACH_LANE((int64_t));
    uint64_t   outside = 0;
    for (int first = 0; first < 64; first += LANES) {
        const int64_t at = sparse_edge_at(e, f->x0 + (first & 7) * px_of(f), f->y0 + (first >> 3) * px_of(f));
        outside |= (uint64_t)i64s_negative(at + across) << first;
    }
    return outside;
}

/* Edge functions of LANES triangles in a tile.
 *
 * From one texel to the next an edge function changes by a multiple of the subtexels of a texel. So it has the sign of its quotient
 * by them, rounded down, and that fits 32 bits if the edge is not long: a quotient too large changes its sign nowhere in the tile. */
typedef struct tile_edges {
    i32s     first[3], across[3], down[3]; /* of the first texel; from it to the next one, and to the next row */
    uint32_t is_long[3];                   /* bits of the triangles whose edge is too long: its numbers are 0 */
} tile_edges;

static inline tile_edges edges_of(const leaf *f, const uint32_t ids[LANES])
{
    const lanes_corners corners = lanes_corners_of(f->d->triangles, ids);
    const int64_t       most    = 8 * EDGE_LONG;
    tile_edges          edges;
    for (int k = 0; k < 3; k++) {
        const lanes_edge e    = lanes_edge_of(&corners, k, f->x0, f->y0);
        const i64s       fits = (i64s_length(e.a) + i64s_length(e.b) - EDGE_LONG) >> 63, first = e.at >> f->d->triangles->grid;
        const i64s       above = (most - first) >> 63, below = (first + most) >> 63;
        edges.first[k]   = __builtin_convertvector(((first & ~(above | below)) | (most & above) | (-most & below)) & fits, i32s);
        edges.across[k]  = __builtin_convertvector(e.a & fits, i32s);
        edges.down[k]    = __builtin_convertvector(e.b & fits, i32s);
        edges.is_long[k] = i64s_negative(~fits);
    }
    return edges;
}

/* Texels whose centres are in a triangle. */
static inline uint64_t covered(const leaf *f, const tile_edges *e, int lane, uint32_t id)
{
    u32rows  at[3], down[3];
    uint64_t outside = 0;
    for (int k = 0; k < 3; k++) {
        at[k]   = u32rows_ramp(e->first[k][lane], e->across[k][lane], e->down[k][lane]);
        down[k] = (uint32_t)e->down[k][lane] * ROWS - (u32rows){0};
    }
    for (int row = 0; row < 8; row += ROWS) {
        outside |= (uint64_t)u32rows_negative(at[0] | at[1] | at[2]) << 8 * row;
        for (int k = 0; k < 3; k++) at[k] += down[k];
    }
    for (int k = 0; k < 3; k++)
        if (e->is_long[k] >> lane & 1) {
            const sparse_edge edge = sparse_edge_of(&f->d->triangles->all[id], k);
            outside |= outside_long(f, &edge);
        }
    return ~outside;
}

/* Twice the area of a point and the edge from corner k to the next. */
static double share_of(const sparse_triangle *t, int k, double x, double y)
{
    int n = k < 2 ? k + 1 : 0;
    return ((double)t->x[n] - t->x[k]) * (y - t->y[k]) - ((double)t->y[n] - t->y[k]) * (x - t->x[k]);
}

static uint64_t without_holes(const leaf *f, uint32_t id, uint64_t texels)
{
    const sparse_triangles *s    = f->d->triangles;
    const hole_uvq         *uvq  = s->uvq[id - s->holed_first];
    const alpha_mask       *mask = &s->casters->alpha_masks[s->mask_of[id - s->holed_first]];
    for (uint64_t rest = texels; rest; rest &= rest - 1) {
        int    n = __builtin_ctzll(rest);
        double x = f->x_of[n & 7], y = f->y_of[n >> 3], u = 0, v = 0, q = 0;
        for (int k = 0; k < 3; k++) {
            double share = share_of(&s->all[id], k < 2 ? k + 1 : 0, x, y); /* weight of the corner opposite to the edge */
            u += share * (double)uvq[k].u;
            v += share * (double)uvq[k].v;
            q += share * (double)uvq[k].q;
        }
        if (!alpha_mask_opaque(mask, &s->casters->images[mask->image], u / q, v / q)) texels &= ~((uint64_t)1 << n);
    }
    return texels;
}

/* nearest depths -------------------------------------------------------------------------------------------------------------- */

static uint32_t bits_of(uint64_t texels, int first)
{
    return (uint32_t)(texels >> first) & ((1u << LANES) - 1);
}

/* Depths of a triangle in LANES texels from `first` on.   bits  the covered ones */
static f64s depths_of(const leaf *f, const sparse_triangle *t, int first, uint32_t bits)
{
    const f64s rise = lanes_rise(t, f64s_load(f->x_of + (first & 7)));
    return f64s_select(bits, lanes_depth(t, rise, lanes_fall(t, f64s_all(f->y_of[first >> 3]))), f64s_all(INFINITY));
}

/* Insert depths of a triangle into `count` layers. more: those that are displaced from the last one become the next layer. */
static ALWAYS_INLINE void insert(const leaf *f, const sparse_triangle *t, uint64_t texels, nearest_depths *k, int count, int more)
{
    const sparse_triangle plane = *t; /* a copy, so that the compiler need not reload it after stores of depths */
    double                falls[8];
    const int             begin = more ? 0 : __builtin_ctzll(texels) & ~7, end = more ? 64 : 64 - __builtin_clzll(texels);
    for (int n = 0; n < 8; n += LANES) f64s_store(falls + n, lanes_fall(&plane, f64s_load(f->y_of + n)));
    for (int n = 0; n < 8; n += LANES) {
        const f64s rise = lanes_rise(&plane, f64s_load(f->x_of + n));
        for (int first = begin + n; first < end; first += 8) {
            f64s z =
                f64s_select(bits_of(texels, first), lanes_depth(&plane, rise, falls[first >> 3] - (f64s){0}), f64s_all(INFINITY));
            for (int layer = 0; layer < count; layer++) {
                const f64s before = f64s_load(k->room[layer] + first);
                f64s_store(k->room[layer] + first, f64s_min(before, z));
                z = f64s_max(before, z);
            }
            if (more) f64s_store(k->room[count] + first, z);
        }
    }
}

static void keep_depths(const leaf *f, const sparse_triangle *t, uint64_t texels, nearest_depths *k)
{
    const int more = k->count < k->most;
    switch (2 * k->count + more) {
    case 1: insert(f, t, texels, k, 0, 1); break;
    case 2: insert(f, t, texels, k, 1, 0); break;
    case 3: insert(f, t, texels, k, 1, 1); break;
    case 4: insert(f, t, texels, k, 2, 0); break;
    case 5: insert(f, t, texels, k, 2, 1); break;
    default: insert(f, t, texels, k, LAYERS + 1, 0);
    }
    if (more) {
        k->layers[k->count] = k->room[k->count];
        k->count++;
    }
}

static void no_depths(nearest_depths *k, int most)
{
#define EIGHT INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, INFINITY
    static const double none[64] = {EIGHT, EIGHT, EIGHT, EIGHT, EIGHT, EIGHT, EIGHT, EIGHT};
    for (int n = 0; n <= LAYERS; n++) k->layers[n] = none;
    k->count = 0;
    k->most  = most;
}

/* Nearest depths in LANES texels from `first` on. */
static f64s first_of(const leaf *f, int first)
{
    return f64s_min(f64s_load(f->sheet.layers[0] + first),
                    f64s_min(f64s_load(f->front.layers[0] + first), f64s_load(f->back.layers[0] + first)));
}

/* Of the texels that a triangle covers, those without a hole. If surfaces behind do not matter, the alpha mask of a sheet is read
 * only where the sheet is met first. */
static uint64_t opaque(const leaf *f, uint32_t id, sparse_tags tags, uint64_t texels)
{
    if (sparse_is_sheet(tags) && !dont_care_needs_next(&f->d->dont_care)) {
        /* the texels in which no surface lies before the triangle */
        uint64_t met = 0;
        for (int first = 0; first < 64; first += LANES) {
            const f64s z = depths_of(f, &f->d->triangles->all[id], first, bits_of(texels, first));
            met |= (uint64_t)i64s_negative((i64s)(z <= first_of(f, first))) << first;
        }
        texels = met & texels;
    }
    return without_holes(f, id, texels);
}

static void meet(leaf *f, uint32_t id, sparse_tags tags, uint64_t texels)
{
    const sparse_triangle *t = &f->d->triangles->all[id];
    f->faces[f->count++]     = (leaf_face){t, tags, texels};
    keep_depths(f, t, texels, sparse_is_sheet(tags) ? &f->sheet : sparse_is_exit(tags) ? &f->back : &f->front);
}

/* Triangles with holes come last. */
static void meet_all(leaf *f, const square_list *l)
{
    no_depths(&f->front, LAYERS + 1);
    no_depths(&f->back, LAYERS);
    no_depths(&f->sheet, 1);
    f->count = 0;
    for (size_t begin = 0; begin < l->count; begin += LANES) {
        tile_edges edges;
        uint32_t   ids[LANES], covers = 1;
        for (size_t n = 0; n < LANES; n++) {
            const square_entry *e = &l->items[begin + n < l->count ? begin + n : l->count - 1];
            ids[n]                = e->id;
            covers &= e->bits; /* ENTRY_COVERS is bit 0 */
        }
        if (!covers) edges = edges_of(f, ids);
        for (size_t n = begin; n < begin + LANES && n < l->count; n++) {
            const uint32_t    id     = l->items[n].id;
            const sparse_tags tags   = l->tags[n];
            uint64_t          texels = ALL_TEXELS;
            if (!(l->items[n].bits & ENTRY_COVERS)) texels = covered(f, &edges, (int)(n - begin), id);
            if (tags.kind & SPARSE_HOLED) texels = opaque(f, id, tags, texels);
            if (texels) meet(f, id, tags, texels);
        }
    }
}

/* exits from solids ----------------------------------------------------------------------------------------------------------- */

/* Number of front faces less back faces, up to a layer of back faces; *next becomes the next layer, if that is nearer. */
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

/* Exit depth for a texel that exits by a layer of back faces: this layer, or a face missing in the list. */
static f64s exit_by(const leaf *f, f64s layer)
{
    return f64s_choose((i64s)(layer > f64s_all(f->known)), f64s_min(layer, f64s_all(f->bound->left_out)), layer);
}

/* Exit depths of the texels in `open`, by counting from a layer of back faces on. */
static f64s exits_by_counting(const leaf *f, f64s layer, i64s open)
{
    f64s exits = f64s_all(INFINITY);
    while (i64s_negative(open)) {
        f64s       next = f64s_all(INFINITY);
        const i64s more = (i64s)(count_open(f, layer, &next) > f64s_all(0)) & (i64s)(layer <= f64s_all(f->known));
        exits           = f64s_choose(open & ~more, exit_by(f, layer), exits);
        open &= more;
        layer = next;
    }
    return exits;
}

static int compare_hits(const void *a, const void *b)
{
    const leaf_hit *p = a, *q = b;
    if (p->depth != q->depth) return p->depth < q->depth ? -1 : 1;
    return p->is_exit - q->is_exit; /* front faces first */
}

/* The same for one texel, by sorting all of its faces.   lane  of the depths */
static double exit_by_sorting(const leaf *f, int lane)
{
    size_t  count = 0;
    int64_t open  = 0;
    for (size_t n = 0; n < f->solids; n++) {
        double z = f->depths[LANES * n + (size_t)lane];
        if (z < INFINITY) f->hits[count++] = (leaf_hit){z, f->backs[n]};
    }
    qsort(f->hits, count, sizeof *f->hits, compare_hits);
    for (size_t n = 0; n < count; n++) {
        const leaf_hit *hit = &f->hits[n];
        open += hit->is_exit ? -1 : 1;
        if (hit->is_exit && hit->depth > f->known) return least(hit->depth, f->bound->left_out);
        if (hit->is_exit && open <= 0) return hit->depth;
    }
    return f->bound->left_out;
}

static f64s exits_by_sorting(const leaf *f, uint32_t texels)
{
    double exits[LANES];
    for (int lane = 0; lane < LANES; lane++) exits[lane] = texels >> lane & 1 ? exit_by_sorting(f, lane) : INFINITY;
    return f64s_load(exits);
}

/* Exit depths from solids in LANES texels from `first` on.   open  texels that enter a solid */
static f64s exits_of(leaf *f, int first, i64s open)
{
    const i64s count = i64s_all(f->d->nearest_back ? 0 : -1);
    f64s       exits = f64s_all(INFINITY);
    for (int n = 0; n < LAYERS && i64s_negative(open); n++) {
        const f64s back = f64s_load(f->back.layers[n] + first), front = f64s_load(f->front.layers[n + 1] + first);
        const i64s more = (i64s)(front <= back) & (i64s)(back <= f64s_all(f->known)) & count; /* the ray may have entered another
                                                                                                 solid before */
        exits           = f64s_choose(open & ~more, exit_by(f, back), exits);
        open &= more;
    }
    const uint32_t texels = i64s_negative(open);
    if (!texels) return exits;

    /* depths of all solids that some of these texels meet */
    f->solids = 0;
    for (const leaf_face *face = f->faces; face < f->faces + f->count; face++) {
        const uint32_t met = bits_of(face->texels, first) & texels;
        if (!met || sparse_is_sheet(face->tags)) continue;
        f->backs[f->solids] = (uint8_t)sparse_is_exit(face->tags);
        f64s_store(f->depths + LANES * f->solids++, depths_of(f, face->t, first, met));
    }

    const f64s others =
        f->solids > FEW_FACES ? exits_by_sorting(f, texels) : exits_by_counting(f, f64s_load(f->back.layers[0] + first), open);
    return f64s_choose(open, others, exits);
}

/* more don't-care voxels ------------------------------------------------------------------------------------------------------ */

/* Exit depths of LANES texels from `first` on, with more don't-care voxels than the insides of solids: uses all surfaces. */
static f64s later_exits(const leaf *f, int first, f64s exits)
{
    const f64s none    = f64s_all(INFINITY);
    f64s       nearest = none, next = none, last = -none, thick = none; /* thick: nearest surface with a thickness */
    double     through[LANES];
    for (const leaf_face *face = f->faces; face < f->faces + f->count; face++) {
        const uint32_t met = bits_of(face->texels, first);
        if (!met) continue;
        f64s z  = depths_of(f, face->t, first, met);
        next    = f64s_min(next, f64s_max(nearest, z));
        nearest = f64s_min(nearest, z);
        last    = f64s_max(last, f64s_select(met, z, -none));
        if (f->d->dont_care.thickness > 0 && face->tags.kind & SPARSE_FACES) /* the exit is at the end of its thickness */
            thick = f64s_min(thick, z);
    }
    f64s_store(through, nearest);
    for (int n = 0; n < LANES; n++) through[n] = dont_care_through(&f->d->dont_care, through[n]);
    f64s x = f64s_choose((i64s)(thick == nearest), f64s_min(f64s_load(through), next), exits);
    return f->free_behind ? f64s_choose((i64s)(last <= exits), none, x) : x;
}

/* the tile -------------------------------------------------------------------------------------------------------------------- */

/* The depths that separate lit from shadowed, in LANES texels. */
typedef struct parting {
    f64s enter_most, exit_least;
} parting;

/* Compute LANES columns from `first` on. */
static void find_columns(leaf *f, int first, parting *p)
{
    const f64s e    = first_of(f, first);
    const i64s open = (i64s)(e < f64s_load(f->sheet.layers[0] + first));
    f64s       x    = e;
    if (i64s_negative(open)) x = f64s_choose(open, exits_of(f, first, open), e);
    if (dont_care_needs_next(&f->d->dont_care)) x = later_exits(f, first, x);
    f64s_store(f->e + first, e);
    f64s_store(f->x + first, x);
    p->enter_most = f64s_max(p->enter_most, e);
    p->exit_least = f64s_min(p->exit_least, x);
}

PORTABLE_LOG(depth_logs, f64s, u64s)

static inline int are_equal(f64s a, f64s b)
{
    return !i64s_negative((i64s)(a != b));
}

/* Round depths to voxels: down, or up for exit depths.   least, most  [out] of the voxels */
static void round_depths(depth_scale s, const double depths[64], int up, uint32_t voxels[64], uint32_t *least, uint32_t *most)
{
    const f64s far = f64s_all(depth_none(s)), near = f64s_all(depth_none(s) - 1), depth_vx = f64s_all(s.depth_vx);
    f64s       low = f64s_all(INFINITY), high = f64s_all(0), last = far, of_last = depth_vx;
    for (int n = 0; n < 64; n += LANES) {
        f64s z = f64s_min(f64s_max(f64s_load(depths + n), near), far);
        /* as depth_in_voxels, bit by bit */
        if (s.voxel_log == 0) {
            z *= depth_vx;
        } else if (are_equal(z, last)) { /* exits often are, and a logarithm takes longer than this look */
            z = of_last;
        } else {
            last = z;
            z = of_last = f64s_min(f64s_max(-depth_logs(0 - z) / f64s_all(s.voxel_log), f64s_all(0)), depth_vx);
        }
        const i32s whole = up ? f64s_up(z) : __builtin_convertvector(z, i32s);
        memcpy(voxels + n, &whole, sizeof whole);
        low  = f64s_min(low, z);
        high = f64s_max(high, z);
    }
    *least = (uint32_t)(up ? ceil(f64s_least(low)) : f64s_least(low));
    *most  = (uint32_t)(up ? ceil(f64s_greatest(high)) : f64s_greatest(high));
}

/* Whether several depths separate lit from shadowed in all columns; sets the bounds if so. */
static int is_parted(depth_scale s, const parting *p, column_bounds *b)
{
    b->emin = b->emax = depth_down(s, depth_clamped(s, f64s_greatest(p->enter_most)));
    b->xmin = b->xmax = depth_up(s, depth_clamped(s, f64s_least(p->exit_least)));
    return b->emax < b->xmin;
}

/* Arrays for the faces of a list. Returns 0 without memory. */
static int make_room(leaf *f, leaf_scratch *s, size_t count)
{
    const size_t each = LANES_MAX * sizeof *f->depths + sizeof *f->faces + sizeof *f->hits + sizeof *f->backs;
    if (!array_reserve(&s->room, &s->capacity, count, each)) return 0;
    f->depths = s->room;
    f->faces  = (leaf_face *)(f->depths + LANES * count);
    f->hits   = (leaf_hit *)(f->faces + count);
    f->backs  = (uint8_t *)(f->hits + count);
    return 1;
}

int AT_LEVEL(leaf_columns)(leaf_scratch *s, const leaf_desc *d, const square_list *l, const square_bound *b, texel_square square,
                           column_tile *out, column_bounds *bounds)
{
    leaf    f;
    parting p = {f64s_all(-INFINITY), f64s_all(INFINITY)};
    if (!make_room(&f, s, l->count)) return 0;
    f.d     = d;
    f.bound = b;
    f.x0    = ((int64_t)(2 * square.u + 1) << d->triangles->grid) / 2;
    f.y0    = ((int64_t)(2 * square.v + 1) << d->triangles->grid) / 2;
    for (int n = 0; n < 8; n++) {
        f.x_of[n] = (double)(f.x0 + n * px_of(&f));
        f.y_of[n] = (double)(f.y0 + n * px_of(&f));
    }
    f.free_behind = d->dont_care.behind && !b->behind;
    f.known       = f.free_behind ? DBL_MAX : b->enter_most;
    meet_all(&f, l);
    for (int first = 0; first < 64; first += LANES) find_columns(&f, first, &p);
    if (!d->every_texel && is_parted(d->scale, &p, bounds)) return 1;
    round_depths(d->scale, f.e, 0, out->e, &bounds->emin, &bounds->emax);
    round_depths(d->scale, f.x, 1, out->x, &bounds->xmin, &bounds->xmax);
    return 1;
}
