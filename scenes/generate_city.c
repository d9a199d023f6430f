/* A city of closed boxes.
 *
 * All coordinates are integers in units of 1/64 m until a vertex is written, and buildings are turned by Pythagorean triples
 * (3-4-5, 5-12-13, ...), whose sines and cosines are fractions: one division and one rounding to float make a coordinate.
 *
 *        _|_                antenna         A block is a list of boxes in order of importance, each standing on an earlier one:
 *     __|___|_              roof clutter    the first box of every lot, the kerb, the second boxes (tiers, wings,
 *    |  tier  |_            wall clutter    towers) and so on, street lamps, clutter on roofs and walls. The triangle
 *   _|________|_            sunk 1 to 2 m   budget is divided evenly among the blocks; each uses as many boxes as it can
 *  |            |  ___                      from the front of its list. The size of clutter is chosen so that the list
 *  |    base    |   |       lamp            is always long enough.
 *  |            |   |
 * _|____________|___|_      kerb
 *  ground
 *
 * No box is inside another: a box of a building extends above or beside those that it meets. Each piece of clutter on a surface
 * has its own cell. From all boxes of its lot except the one that it is fixed to, it is more than a metre away, which is the
 * greatest extent of wall clutter.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/integer.h"
#include "scenes/generate.h"

#include <assert.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "baker/base/random.h"
#include "scenes/generate_parts.h"

/* lengths in units of 1/64 m */
enum {
    METRE         = 64,
    BLOCK         = 60 * METRE,
    STREET        = 12 * METRE,
    PITCH         = BLOCK + STREET,
    SIDEWALK      = 3 * METRE,
    LOT_MIN       = 24 * METRE, /* a side at least this long may be split once more */
    LOT_MAX       = 32 * METRE, /* a side that must be cut */
    HEIGHT_MIN    = 8 * METRE,
    HEIGHT_MAX    = 120 * METRE,
    KERB_TOP      = 10,
    PROTRUSION    = METRE,     /* maximum extent of wall clutter */
    CLEARANCE     = METRE + 4, /* distance of clutter from other boxes: more than this */
    CELL_MAX      = 4 * METRE, /* side of a cell of clutter */
    CELL_MIN      = 4,
    WALL_START    = 5 * METRE / 2, /* minimum height of wall clutter */
    LOTS_MAX      = 32,            /* a lot is 0.4 LOT_MIN = 9.6 m at least: 31 fit in 54 x 54 m */
    LOT_BOXES_MAX = 4,
    LAMPS         = 12,
    LAMP_BELOW    = 8, /* a spot's distance below the arm, and from the arm's end */
    BOX_VERTICES  = 8,
    BOX_TRIANGLES = 12
};

/* Position and rotation of a building: about +Y by the angle with that cosine and sine. */
typedef struct frame {
    int32_t x, z;
    int32_t cosine, sine, radius; /* cosine^2 + sine^2 = radius^2 */
} frame;

typedef struct box {
    frame   at;
    int32_t low[3], high[3]; /* in the frame; Y as in the world */
} box;

typedef struct rectangle {
    int32_t low[2], high[2]; /* X and Z */
} rectangle;

typedef struct lot {
    rectangle area;
    size_t    box_count; /* of the building; each stands on an earlier one */
    box       boxes[LOT_BOXES_MAX];
} lot;

typedef struct block {
    int32_t  x, z; /* centre */
    int32_t  tallest;
    uint64_t seed;
    size_t   lot_count;
    lot      lots[LOTS_MAX];
} block;

static const frame turns[] = {{0, 0, 4, 3, 5},   {0, 0, 3, 4, 5},   {0, 0, 12, 5, 13}, {0, 0, 5, 12, 13},
                              {0, 0, 15, 8, 17}, {0, 0, 24, 7, 25}, {0, 0, 21, 20, 29}};

/* The boxes as triangles. */

static size_t box_count(const glb_scene *s)
{
    return s->triangle_count / BOX_TRIANGLES;
}

/* Append a box to the scene's last mesh. */
static void emit(parts *p, const box *b)
{
    const frame *f    = &b->at;
    uint32_t     last = 0;
    for (int c = 0; c < BOX_VERTICES; c++) {
        int64_t x = c & 1 ? b->high[0] : b->low[0];
        int64_t y = c & 2 ? b->high[1] : b->low[1];
        int64_t z = c & 4 ? b->high[2] : b->low[2];

        int64_t turned_x = (int64_t)f->x * f->radius + f->cosine * x + f->sine * z;
        int64_t turned_z = (int64_t)f->z * f->radius + f->cosine * z - f->sine * x;

        last = parts_vertex(p, (double)turned_x / (f->radius * METRE), (double)y / METRE, (double)turned_z / (f->radius * METRE));
    }
    parts_box_triangles(p, last + 1 - BOX_VERTICES);
}

/* Whether two boxes are CLEARANCE apart along an axis of `a`'s frame. */
static bool is_beside(const box *a, const box *b)
{
    double low[2] = {1e30, 1e30}, high[2] = {-1e30, -1e30};
    for (int c = 0; c < 4; c++) {
        double x = c & 1 ? b->high[0] : b->low[0], z = c & 2 ? b->high[2] : b->low[2];
        double world_x = (b->at.cosine * x + b->at.sine * z) / b->at.radius + (b->at.x - a->at.x);
        double world_z = (b->at.cosine * z - b->at.sine * x) / b->at.radius + (b->at.z - a->at.z);
        double p[2]    = {(a->at.cosine * world_x - a->at.sine * world_z) / a->at.radius,
                          (a->at.cosine * world_z + a->at.sine * world_x) / a->at.radius};
        for (int i = 0; i < 2; i++) {
            if (p[i] < low[i]) low[i] = p[i];
            if (p[i] > high[i]) high[i] = p[i];
        }
    }
    return low[0] > a->high[0] + CLEARANCE || high[0] < a->low[0] - CLEARANCE || low[1] > a->high[2] + CLEARANCE ||
           high[1] < a->low[2] - CLEARANCE;
}

static bool is_clear(const box *a, const box *b)
{
    return a->low[1] > b->high[1] || a->high[1] < b->low[1] || is_beside(a, b) || is_beside(b, a);
}

/* Lots and buildings. */

/* Split the longer side near its middle until the lots have the size of a building. */
static void split_into_lots(block *k, rng *r, rectangle area)
{
    int     axis = area.high[0] - area.low[0] >= area.high[1] - area.low[1] ? 0 : 1;
    int32_t side = area.high[axis] - area.low[axis];
    if (side <= LOT_MIN || (side <= LOT_MAX && rng_below(r, 3) == 0)) {
        assert(k->lot_count < LOTS_MAX);
        k->lots[k->lot_count++] = (lot){.area = area};
        return;
    }
    rectangle first = area, second = area;
    first.high[axis] = second.low[axis] = area.low[axis] + side * rng_between(r, 400, 600) / 1000;
    split_into_lots(k, r, first);
    split_into_lots(k, r, second);
}

static int32_t foundation(rng *r)
{
    return -rng_between(r, METRE / 2, 3 * METRE / 2);
}

static void add_box(lot *l, frame at, int32_t x0, int32_t x1, int32_t z0, int32_t z1, int32_t bottom, int32_t top)
{
    assert(l->box_count < LOT_BOXES_MAX && x0 < x1 && z0 < z1 && bottom < top);
    l->boxes[l->box_count++] = (box){at, {x0, bottom, z0}, {x1, top, z1}};
}

/* Boxes that get narrower upwards, each sunk into the one below. */
static void build_tiers(lot *l, rng *r, frame at, int32_t a, int32_t b, int32_t height)
{
    int32_t count = height < 24 * METRE ? 2 : rng_between(r, 2, LOT_BOXES_MAX);
    int32_t x[2] = {-a, a}, z[2] = {-b, b};
    int32_t bottom = foundation(r);
    for (int32_t i = 1; i <= count; i++) {
        int32_t top = i == count ? height : height * i / count - rng_between(r, 0, METRE);
        add_box(l, at, x[0], x[1], z[0], z[1], bottom, top);
        bottom = top - rng_between(r, METRE, 2 * METRE);
        x[0] += a * rng_between(r, 6, 22) / 100;
        x[1] -= a * rng_between(r, 6, 22) / 100;
        z[0] += b * rng_between(r, 6, 22) / 100;
        z[1] -= b * rng_between(r, 6, 22) / 100;
    }
}

/* A low base over the lot, and a rotated tower on it. */
static void build_podium(lot *l, rng *r, frame base, int32_t a, int32_t b, frame tower, int32_t reach, int32_t height)
{
    int32_t top  = rng_between(r, 4 * METRE, min_i32(height / 2, 14 * METRE));
    int32_t half = reach * rng_between(r, 65, 92) / 100;
    add_box(l, base, -a, a, -b, b, foundation(r), top);
    add_box(l, tower, -half, half, -half * 9 / 10, half, top - rng_between(r, METRE, 2 * METRE), height);
}

static void build(lot *l, rng *r, int32_t tallest)
{
    rectangle p = l->area; /* the lot less the gaps to its neighbours */
    for (int i = 0; i < 2; i++) {
        p.low[i] += rng_between(r, 5 * METRE / 4, 2 * METRE);
        p.high[i] -= rng_between(r, 5 * METRE / 4, 2 * METRE);
    }
    int32_t a = (p.high[0] - p.low[0]) / 2, b = (p.high[1] - p.low[1]) / 2, narrow = min_i32(a, b);
    frame   straight = {p.low[0] + a, p.low[1] + b, 1, 0, 1};

    frame turned  = turns[rng_below(r, sizeof turns / sizeof *turns)];
    turned.x      = straight.x;
    turned.z      = straight.z;
    int32_t reach = narrow * turned.radius / (turned.cosine + turned.sine); /* half the side of a rotated square that fits */
    if (rng_below(r, 2)) turned.sine = -turned.sine;

    int32_t top    = max_i32(HEIGHT_MIN, min_i32(tallest, 10 * narrow));
    int32_t height = min_i32(rng_between(r, HEIGHT_MIN, top), rng_between(r, HEIGHT_MIN, top)); /* most are low */
    if (rng_below(r, 4) == 0) height = rng_between(r, HEIGHT_MIN, top);

    switch (rng_below(r, 10)) {
    case 0:
    case 1: add_box(l, straight, -a, a, -b, b, foundation(r), height); break;
    case 2: add_box(l, turned, -reach, reach, -reach, reach, foundation(r), height); break;
    case 3:
    case 4: build_tiers(l, r, straight, a, b, height); break;
    case 5: build_tiers(l, r, turned, reach, reach, height); break;
    case 6:
    case 7: {
        /* a main box and one or two lower wings that cross its side: plans in the shape of an L, a T or a cross */
        int32_t back = -b * rng_between(r, 20, 50) / 100, front = b * rng_between(r, 10, 40) / 100;
        int32_t left = a * rng_between(r, -95, -30) / 100, right = a * rng_between(r, 20, 95) / 100;

        add_box(l, straight, -a, a, back, front, foundation(r), height);
        /* compilers call the functions of an argument list in different orders: one draw a statement */
        int32_t tall = height * rng_between(r, 45, 90) / 100;
        add_box(l, straight, left, right, back / 2, b, foundation(r), tall);
        if (rng_below(r, 2)) {
            tall = height * rng_between(r, 45, 90) / 100;
            add_box(l, straight, left / 2, right / 2, -b, front / 2, foundation(r), tall);
        }
    } break;
    default: build_podium(l, r, straight, a, b, turned, reach, max_i32(height, 2 * HEIGHT_MIN)); break;
    }
}

/* Street lamps: along each side of the block, poles with an arm over the street. */

static void make_lamp(const block *k, uint32_t index, box lamp[2])
{
    static const frame sides[4] = {{0, 0, 1, 0, 1}, {0, 0, 0, 1, 1}, {0, 0, -1, 0, 1}, {0, 0, 0, -1, 1}};
    rng                r        = rng_split(k->seed, 1000 + index);
    frame              at       = sides[index % 4];
    at.x                        = k->x;
    at.z                        = k->z;
    int32_t x                   = (int32_t)(index / 4 * 19 + 11) * METRE - BLOCK / 2 + rng_between(&r, -METRE, METRE);
    int32_t z                   = BLOCK / 2 - METRE / 2;
    int32_t top                 = 7 * METRE + rng_between(&r, 0, 16);

    lamp[0] = (box){at, {x - 5, -rng_between(&r, 16, 48), z - 5}, {x + 5, top, z + 5}};
    lamp[1] = (box){at, {x - 3, top - 20, z}, {x + 3, top - 12, z + rng_between(&r, 2 * METRE, 3 * METRE)}};
}

/* Clutter: a box in a cell of a roof or a wall. */

/* A part of [low, low + cell) that does not touch its ends. */
static void place_in_cell(rng *r, int32_t low, int32_t cell, int32_t least, int32_t most, int32_t *from, int32_t *to)
{
    int32_t length = rng_between(r, max_i32(1, least), max_i32(1, most));
    *from          = low + rng_between(r, 1, cell - 1 - length);
    *to            = *from + length;
}

/* Depth by which clutter intersects the box that it is fixed to; 0 is mere contact, which occurs in real levels. */
static int32_t sink(rng *r, int32_t most)
{
    return rng_below(r, 4) ? rng_between(r, 1, most) : 0;
}

/* axis, is_high: the wall faces along X (0) or Z (2), towards negative or positive values. */
static void place_on_wall(box *out, const box *host, int axis, bool is_high, int32_t u, int32_t y, int32_t cell, rng *r)
{
    int     along  = 2 - axis;
    int32_t out_by = rng_between(r, 8, PROTRUSION), in_by = sink(r, 12);

    out->at = host->at;
    place_in_cell(r, u, cell, cell / 3, min_i32(cell * 7 / 8, cell - 2), &out->low[along], &out->high[along]);
    place_in_cell(r, y, cell, cell / 8, cell / 2, &out->low[1], &out->high[1]);
    out->low[axis]  = is_high ? host->high[axis] - in_by : host->low[axis] - out_by;
    out->high[axis] = is_high ? host->high[axis] + out_by : host->low[axis] + in_by;
}

/* All ways to put clutter of one kind on a block. Walks over the same cells give the same boxes, so that one walk can count them
 * and the next can choose. */
typedef struct clutter_walk {
    const block *k;
    bool         on_roofs; /* else on walls */
    int32_t      cell;     /* side */
    uint32_t     found;    /* [out] number of boxes that are clear of all others */

    /* when choosing: add `wanted` of the `available` boxes to the scene, every choice equally likely (selection sampling, Knuth,
     * "The Art of Computer Programming", volume 2, algorithm S) */
    parts   *chosen; /* NULL: only count */
    uint32_t wanted, available;
    rng      choice;
} clutter_walk;

/* A face of the lot's box `host`: its roof (axis 1), or the wall that faces along X (0) or Z (2), in negative or positive
 * direction. */
static void walk_surface(clutter_walk *w, const lot *l, size_t host, int axis, bool is_high, uint64_t *stream)
{
    const box *h      = &l->boxes[host];
    uint64_t   cells  = rng_split(w->k->seed, (*stream)++).state;
    int        across = axis == 1 ? 0 : 2 - axis, along = axis == 1 ? 2 : 1;
    int32_t    first = axis == 1 ? h->low[along] : max_i32(h->low[along], WALL_START);
    for (int32_t v = first; v + w->cell <= h->high[along]; v += w->cell)
        for (int32_t u = h->low[across]; u + w->cell <= h->high[across]; u += w->cell) {
            box clutter;
            rng r = rng_split(cells++, 0);
            if (axis == 1) {
                int32_t cell    = w->cell;
                bool    antenna = rng_below(&r, 6) == 0;
                int32_t least = antenna ? 3 : cell / 3, most = antenna ? 8 : cell * 7 / 8;
                int32_t tall = antenna ? rng_between(&r, 2 * METRE, 10 * METRE) : rng_between(&r, cell / 4, cell);

                clutter.at = h->at;
                most       = min_i32(most, cell - 2);
                least      = min_i32(least, most);
                place_in_cell(&r, u, cell, least, most, &clutter.low[0], &clutter.high[0]);
                place_in_cell(&r, v, cell, least, most, &clutter.low[2], &clutter.high[2]);
                clutter.low[1]  = h->high[1] - sink(&r, 16);
                clutter.high[1] = h->high[1] + tall;
            } else
                place_on_wall(&clutter, h, axis, is_high, u, v, w->cell, &r);

            size_t clear = 0; /* of so many boxes of the lot */
            while (clear < l->box_count && (clear == host || is_clear(&clutter, &l->boxes[clear]))) clear++;
            if (clear < l->box_count) continue;
            w->found++;
            if (w->chosen && rng_below(&w->choice, w->available--) < w->wanted) emit(w->chosen, &clutter), w->wanted--;
        }
}

static void walk_clutter(clutter_walk *w)
{
    w->found        = 0;
    uint64_t stream = 2000;
    for (size_t i = 0; i < w->k->lot_count; i++)
        for (size_t host = 0; host < w->k->lots[i].box_count; host++) {
            for (int side = 0; side < 4 && !w->on_roofs; side++)
                walk_surface(w, &w->k->lots[i], host, side & 1 ? 2 : 0, side & 2, &stream);
            if (w->on_roofs) walk_surface(w, &w->k->lots[i], host, 1, true, &stream);
        }
}

static uint32_t count_clutter(const block *k, bool on_roofs, int32_t cell)
{
    clutter_walk w = {.k = k, .on_roofs = on_roofs, .cell = cell};
    walk_clutter(&w);
    return w.found;
}

static void choose_clutter(parts *p, const block *k, bool on_roofs, int32_t cell, uint32_t wanted, uint32_t available)
{
    clutter_walk w = {.k = k, .on_roofs = on_roofs, .cell = cell, .chosen = p, .wanted = wanted, .available = available};
    w.choice       = rng_split(k->seed, on_roofs ? 3 : 4);
    walk_clutter(&w);
}

/* Blocks and the city. */

/* Add kerb, buildings and lamps, most important first, until there are `budget` boxes. Returns their number. */
static uint32_t make_structure(parts *p, const block *k, uint32_t budget)
{
    uint32_t made = 0;
    for (size_t rank = 0; rank < LOT_BOXES_MAX; rank++) {
        for (size_t i = 0; i < k->lot_count; i++)
            if (rank < k->lots[i].box_count && made < budget) emit(p, &k->lots[i].boxes[rank]), made++;
        if (rank == 0 && made < budget) {
            rng r    = rng_split(k->seed, 2);
            box kerb = {
                {k->x, k->z, 1, 0, 1}, {-BLOCK / 2, -rng_between(&r, 16, 32), -BLOCK / 2}, {BLOCK / 2, KERB_TOP, BLOCK / 2}};
            emit(p, &kerb), made++;
        }
    }
    for (uint32_t i = 0; i < LAMPS; i++) {
        box lamp[2];
        make_lamp(k, i, lamp);
        for (int part = 0; part < 2 && made < budget; part++, made++) emit(p, &lamp[part]);
    }
    return made;
}

static bool make_boxes(parts *p, const block *k, uint32_t i, uint32_t j, uint32_t budget)
{
    char name[32];
    if (!budget) return true;
    snprintf(name, sizeof name, "block %u %u", i, j);
    parts_mesh(p, name, 0);

    /* half the clutter goes on roofs, as long as a quarter of their cells stays free; the cells shrink until there are enough */
    uint32_t wanted = budget - make_structure(p, k, budget);
    for (int32_t cell = CELL_MAX; wanted && cell >= CELL_MIN; cell = cell * 4 / 5) {
        uint32_t roofs = count_clutter(k, true, cell), walls = count_clutter(k, false, cell);
        if ((uint64_t)(roofs + walls) * 3 < (uint64_t)wanted * 4) continue;

        uint32_t on_roofs = min_i32((int32_t)(wanted / 2), (int32_t)(roofs - roofs / 4));
        if (wanted - on_roofs > walls) on_roofs = wanted - walls;
        choose_clutter(p, k, true, cell, on_roofs, roofs);
        choose_clutter(p, k, false, cell, wanted - on_roofs, walls);
        return true;
    }
    return !wanted;
}

/* The lamps with both of their boxes are the first of the block's lamps. */
static void make_spots(parts *p, const block *k, size_t box_first, uint32_t budget, uint32_t count, uint32_t *made)
{
    city_lamp lamps[LAMPS];
    uint32_t  structure = 1; /* boxes of the kerb and the buildings */
    for (size_t i = 0; i < k->lot_count; i++) structure += (uint32_t)k->lots[i].box_count;
    uint32_t   lamp_count = budget > structure ? min_i32((int32_t)(budget - structure) / 2, LAMPS) : 0;
    city_block c          = {lamps,
                             lamp_count,
                             box_first,
                             box_count(p->s) - box_first,
                             (double)k->x / METRE,
                             (double)k->z / METRE,
                             (double)BLOCK / 2 / METRE,
                             (double)STREET / METRE};
    for (uint32_t i = 0; i < lamp_count; i++) {
        box lamp[2];
        make_lamp(k, i, lamp);

        /* under the far end of its arm */
        const frame *f = &lamp[1].at; /* of radius 1 */
        double       x = (double)(lamp[1].low[0] + lamp[1].high[0]) / 2, z = lamp[1].high[2] - LAMP_BELOW;
        lamps[i] = (city_lamp){{(f->x + (f->cosine * x + f->sine * z)) / METRE, (double)(lamp[1].low[1] - LAMP_BELOW) / METRE,
                                (f->z + (f->cosine * z - f->sine * x)) / METRE},
                               {f->cosine, 0, -f->sine},
                               {f->sine, 0, f->cosine}};
    }
    add_city_spots(p, &c, rng_split(k->seed, 5), count, made);
}

static bool make_block(parts *p, const city_options *o, uint64_t index, uint32_t budget, uint32_t *spots_made)
{
    const uint64_t blocks = (uint64_t)o->blocks * o->blocks;
    uint32_t       i = (uint32_t)(index % o->blocks), j = (uint32_t)(index / o->blocks);
    uint32_t       spots     = (uint32_t)(o->spots * (index + 1) / blocks - o->spots * index / blocks);
    size_t         box_first = box_count(p->s);
    block          k;
    if (!budget && !spots) return true;

    k.seed      = rng_split(o->seed, (uint64_t)j * CITY_BLOCKS_MAX + i + 1).state;
    rng r       = rng_split(k.seed, 1);
    k.x         = (int32_t)i * PITCH - (int32_t)(o->blocks - 1) * PITCH / 2;
    k.z         = (int32_t)j * PITCH - (int32_t)(o->blocks - 1) * PITCH / 2;
    k.lot_count = 0;

    /* towers are in the middle of the city, and sometimes outside */
    int32_t x = (int32_t)(2 * i + 1) - (int32_t)o->blocks, z = (int32_t)(2 * j + 1) - (int32_t)o->blocks;
    int32_t far2 = 2 * (int32_t)blocks, near2 = far2 - (x * x + z * z);
    k.tallest = 20 * METRE + (HEIGHT_MAX - 20 * METRE) * (near2 * 100 / far2) / 100 * (near2 * 100 / far2) / 100;
    if (rng_below(&r, 8) == 0) k.tallest = HEIGHT_MAX;

    int32_t half = BLOCK / 2 - SIDEWALK;
    split_into_lots(&k, &r, (rectangle){{k.x - half, k.z - half}, {k.x + half, k.z + half}});
    for (size_t l = 0; l < k.lot_count; l++) {
        rng building = rng_split(k.seed, 100 + l);
        build(&k.lots[l], &building, k.tallest);
    }

    if (!make_boxes(p, &k, i, j, budget)) return false;
    make_spots(p, &k, box_first, budget, spots, spots_made);
    return true;
}

vxs_result generate_city(glb_scene *s, const city_options *o, run_context *m)
{
    const size_t   boxes  = (o->triangles + BOX_TRIANGLES / 2) / BOX_TRIANGLES;
    const uint64_t blocks = (uint64_t)o->blocks * o->blocks, shared = boxes - 1;
    uint32_t       spots_made = 0;
    parts          p          = parts_begin(s, "city");

    parts_sun(&p, o->sun);
    double half = (double)((int32_t)o->blocks * PITCH / 2 + 20 * METRE) / METRE;
    parts_box_at(&p, "ground", -half, half, -2, 0, -half, half);
    for (uint64_t b = 0; b < blocks; b++) {
        uint32_t budget = (uint32_t)(shared * (b + 1) / blocks - shared * b / blocks);
        if (!make_block(&p, o, b, budget, &spots_made)) {
            glb_scene_free(s);
            return fail(m, VXS_E_ARGUMENT, "--triangles %u: too many for %u x %u blocks, expected fewer, or more --blocks",
                        o->triangles, o->blocks, o->blocks);
        }
    }
    assert(p.out_of_memory || box_count(s) == boxes);
    return parts_end(&p, m);
}
