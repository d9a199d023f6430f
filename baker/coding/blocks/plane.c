/* Planes through ranges; see plane.h.
 *
 * Take the two texels that a plane misses by most, one in front and one behind. Together they bound the room of every plane by a
 * function that is linear in its slopes. The slopes move to the nearest ones for which all bounds so far leave room. If there
 * are none, no plane exists.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/plane.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/simd.h"
#include "baker/coding/blocks/patterns.h"

enum {
    MOVES       = 7,                 /* most moves of a plane */
    ROOM        = PLANE_ONE - 1,     /* wanted room: one of the possible depths is then a whole voxel */
    ROOM_LEAST  = PLANE_ONE / 4,     /* least room otherwise: the unit of depths of private planes */
    SPARE       = 8,                 /* additional room, for rounding of slopes */
    SLOPE_ZEROS = 7,                 /* low bits of slopes that may be rounded to zero */
    SLOPE_END   = PLANE_FREE / 64,   /* limit for which depths in an area of 32 x 32 texels are exact */
    NEAR        = 3 * PLANE_ONE / 2, /* distance of texels that may still join a plane */
    WINDOW      = 3,                 /* side of the areas from which pairs of planes start */
    FEW_WINDOWS = 4                  /* of these areas that are tried where little time is allowed */
};

int plane_shift(const plane *p)
{
    int shift = 0;
    while (abs(p->across) >> shift > 32767 || abs(p->down) >> shift > 32767) shift++;
    return shift;
}

/* Range of depths at texel (0, 0) of the area for which the plane passes through all ranges. */
typedef struct plane_room {
    float   low, high;
    int32_t low_in, high_in; /* quadrants that limit it, in front and behind: four for each tile, [0, 4 * count) */
} plane_room;

static inline float size_of(const plane_room *r)
{
    return r->high - r->low;
}

/* Depths in the rows of a quadrant: the first row, and the differences to the next rows. */
typedef struct quadrant_depths {
    f32x4 first, down;
} quadrant_depths;

static inline quadrant_depths depths_at(const plane *p, const plane_ranges *t, int q)
{
    const f32x4 across = {0, (float)p->across, (float)(2 * p->across), (float)(3 * p->across)};
    return (quadrant_depths){across + f32x4_all((float)(p->across * (t->x + 4 * (q & 1)) + p->down * (t->y + 4 * (q >> 1)))),
                             f32x4_all((float)p->down)};
}

static plane_room room_of(const plane *p, const plane_ranges *const *tiles, int count)
{
    f32x4 low = f32x4_all(-PLANE_FREE), high = f32x4_all(PLANE_FREE);
    i32x4 low_in = i32x4_all(0), high_in = i32x4_all(0);
    for (int n = 0; n < 4 * count; n++) {
        const plane_ranges *t = tiles[n / 4];
        int                 q = n & 3;
        if (!(t->quadrants >> q & 1)) continue;
        quadrant_depths at = depths_at(p, t, q);
        f32x4           row[4], least[4], most[4];
        row[0] = at.first;
        for (int y = 1; y < 4; y++) row[y] = row[y - 1] + at.down;
        for (int y = 0; y < 4; y++) {
            least[y] = f32x4_load(t->low + 16 * q + 4 * y) - row[y];
            most[y]  = f32x4_load(t->high + 16 * q + 4 * y) - row[y];
        }
        f32x4 l = f32x4_max(f32x4_max(least[0], least[1]), f32x4_max(least[2], least[3]));
        f32x4 h = f32x4_min(f32x4_min(most[0], most[1]), f32x4_min(most[2], most[3]));
        low_in  = i32x4_select((i32x4)(l > low), i32x4_all(n), low_in);
        high_in = i32x4_select((i32x4)(h < high), i32x4_all(n), high_in);
        low     = f32x4_max(low, l);
        high    = f32x4_min(high, h);
    }
    plane_room room = {low[0], high[0], low_in[0], high_in[0]};
    for (int lane = 1; lane < 4; lane++) {
        if (low[lane] > room.low) {
            room.low    = low[lane];
            room.low_in = low_in[lane];
        }
        if (high[lane] < room.high) {
            room.high    = high[lane];
            room.high_in = high_in[lane];
        }
    }
    return room;
}

typedef struct texel_place {
    int32_t x, y;
} texel_place;

/* The first texel of a quadrant whose range ends at the end of the room.   ranges  low ones, or high ones */
static texel_place bounding_texel(const plane *p, const plane_ranges *t, int q, const float *ranges, float end)
{
    quadrant_depths at = depths_at(p, t, q);
    u32x4           apart[4];
    for (int row = 0; row < 4; row++, at.first += at.down)
        apart[row] = ~(u32x4)(f32x4_load(ranges + 16 * q + 4 * row) - at.first == f32x4_all(end));
    int n = __builtin_ctz(u32x4_zeros(apart) | 1u << 15);
    return (texel_place){t->x + 4 * (q & 1) + n % 4, t->y + 4 * (q >> 1) + n / 4};
}

/* A bound: planes have at most rest + across * x + down * y room, because of two texels, one in front and one behind. */
typedef struct room_bound {
    double x, y, rest;
} room_bound;

/* Move the slopes to the nearest ones for which all bounds leave `room`. Only the last bound is violated now. So the result is on
 * the line where the last bound leaves exactly `room`, in the part that each other bound allows. Returns 0 if there is none, or
 * it is too steep. */
static int move(plane *p, const room_bound *bounds, int count, double room)
{
    const room_bound *last   = &bounds[count - 1];
    double            square = last->x * last->x + last->y * last->y, from = -SLOPE_END, to = SLOPE_END;
    if (square == 0) return 0;
    double by     = (room - last->rest - last->x * p->across - last->y * p->down) / square;
    double across = p->across + by * last->x, down = p->down + by * last->y;
    for (const room_bound *b = bounds; b < last; b++) {
        double steep = last->x * b->y - last->y * b->x, lacks = room - b->rest - b->x * across - b->y * down;
        if (steep > 0)
            from = lacks > from * steep ? lacks / steep : from;
        else if (steep < 0)
            to = lacks > to * steep ? lacks / steep : to;
        else if (lacks > 0)
            return 0;
    }
    if (from > to) return 0;
    double along = from > 0 ? from : to < 0 ? to : 0;
    across -= along * last->y;
    down += along * last->x;
    if (across > SLOPE_END || across < -SLOPE_END || down > SLOPE_END || down < -SLOPE_END) return 0;
    p->across = (int32_t)floor(across + 0.5);
    p->down   = (int32_t)floor(down + 0.5);
    return 1;
}

/* Number in [low, high] divisible by the largest power of two, up to PLANE_ONE; low < high. */
static int32_t roundest(int32_t low, int32_t high)
{
    for (int32_t step = PLANE_ONE; step > 1; step /= 2)
        if ((high & -step) >= low) return high & -step;
    return high;
}

/* Depth of texel (0, 0) of an area relative to the least corner. */
static int32_t first_over_least(const plane *p, int32_t side)
{
    return (p->across < 0 ? -p->across * (side - 1) : 0) + (p->down < 0 ? -p->down * (side - 1) : 0);
}

/* Choose the depth within the room. */
static void place(plane *p, const plane_room *room, int32_t side)
{
    int32_t over = first_over_least(p, side);
    p->least     = roundest((int32_t)room->low - over, (int32_t)room->high - over);
}

int plane_place(plane *p, const plane_ranges *const *tiles, int count, int32_t side, int32_t least_room)
{
    plane_room room = room_of(p, tiles, count);
    if (room.high - room.low < (float)least_room) return 0;
    place(p, &room, side);
    return 1;
}

plane plane_rounded(const plane *p, int zeros)
{
    int32_t half = 1 << zeros >> 1;
    return (plane){(p->across + half) & -(1 << zeros), (p->down + half) & -(1 << zeros), 0};
}

int plane_fit(plane *p, const plane_ranges *const *tiles, int count, int32_t side)
{
    /* move slopes until there is enough room, and keep those with most room */
    plane      at   = *p;
    int32_t    aim  = ROOM;
    plane_room room = {1, 0, 0, 0};
    room_bound bounds[MOVES];
    for (int n = 0; n < MOVES; n++) {
        plane_room here = room_of(&at, tiles, count);
        if (size_of(&here) > size_of(&room)) {
            room = here;
            *p   = at;
        }
        if (size_of(&room) >= aim) break;

        const plane_ranges *in_front = tiles[here.low_in / 4], *behind = tiles[here.high_in / 4];
        texel_place         a = bounding_texel(&at, in_front, here.low_in & 3, in_front->low, here.low);
        texel_place         b = bounding_texel(&at, behind, here.high_in & 3, behind->high, here.high);
        double              x = a.x - b.x, y = a.y - b.y;
        bounds[n] = (room_bound){x, y, (double)size_of(&here) - x * at.across - y * at.down};

        if (move(&at, bounds, n + 1, aim + SPARE)) continue;
        if (aim == ROOM_LEAST || size_of(&room) >= ROOM_LEAST || !move(&at, bounds, n + 1, ROOM_LEAST + SPARE)) break;
        aim = ROOM_LEAST;
    }
    if (size_of(&room) < 0) return 0;
    int shift = plane_shift(p);
    if (!shift) {
        place(p, &room, side);
        return 1;
    }
    *p = plane_rounded(p, shift);
    return plane_shift(p) == shift && plane_place(p, tiles, count, side, 0);
}

static int depth_zeros(const plane *p)
{
    return __builtin_ctz((uint32_t)p->least | PLANE_ONE);
}

void plane_round(plane *p, const plane_ranges *t)
{
    for (int zeros = SLOPE_ZEROS; zeros > plane_shift(p); zeros--) {
        plane next = plane_rounded(p, zeros);
        if (plane_shift(&next) > zeros || !plane_place(&next, &t, 1, 8, 0) || depth_zeros(&next) < depth_zeros(p)) continue;
        *p = next;
        return;
    }
}

plane plane_start(const plane_ranges *t)
{
    int first = pattern_texel(0, 0), right = pattern_texel(7, 0), bottom = pattern_texel(0, 7);
    return (plane){(int32_t)(t->low[right] - t->low[first]) / 7, (int32_t)(t->low[bottom] - t->low[first]) / 7, 0};
}

/* parts of tiles -------------------------------------------------------------------------------------------------------------- */

/* The ranges that bound the plane of some texels. */
static void ranges_of(plane_ranges *part, const plane_ranges *t, uint64_t texels, plane_others others)
{
    const i32x4 bit = {1, 2, 4, 8}, nearest = (i32x4)f32x4_all(-PLANE_FREE), farthest = (i32x4)f32x4_all(PLANE_FREE);
    part->x = part->y = 0;
    part->quadrants   = t->quadrants;
    for (int q = 0; q < 4 && others == OTHERS_ANYWHERE; q++)
        if (!(texels >> 16 * q & 0xffff)) part->quadrants &= ~(1u << q);
    for (int n = 0; n < 64; n += 4) {
        i32x4 in  = (i32x4)((i32x4_all((int32_t)(texels >> n & 15)) & bit) != i32x4_all(0));
        i32x4 low = (i32x4)f32x4_load(t->low + n), high = (i32x4)f32x4_load(t->high + n);
        if (others != OTHERS_BEHIND) low = i32x4_select(in, low, nearest);
        if (others != OTHERS_BEFORE) high = i32x4_select(in, high, farthest);
        memcpy(part->low + n, &low, sizeof low);
        memcpy(part->high + n, &high, sizeof high);
    }
}

void plane_round_texels(plane *p, const plane_ranges *t, uint64_t texels)
{
    plane_ranges part;
    ranges_of(&part, t, texels, OTHERS_ANYWHERE);
    plane_round(p, &part);
}

int plane_fit_texels(plane *p, const plane_ranges *t, uint64_t texels, plane_others others)
{
    plane_ranges        part;
    const plane_ranges *tile = &part;
    ranges_of(&part, t, texels, others);
    if (!plane_fit(p, &tile, 1, 8)) return 0;
    if (others != OTHERS_ANYWHERE) plane_round(p, &part);
    return 1;
}

/* The texels of a tile of 8 x 8 whose ranges, widened by `margin`, contain the plane. */
static uint64_t plane_texels(const plane *p, const plane_ranges *t, int32_t margin)
{
    float    first  = (float)(p->least + first_over_least(p, 8));
    uint64_t texels = 0;
    for (int q = 0; q < 4; q++) {
        quadrant_depths at = depths_at(p, t, q);
        for (int row = 16 * q; row < 16 * q + 16; row += 4, at.first += at.down) {
            f32x4 low = f32x4_load(t->low + row) - (float)margin, high = f32x4_load(t->high + row) + (float)margin;
            texels |= (uint64_t)i32x4_bits((i32x4)(low <= at.first + first) & (i32x4)(high >= at.first + first)) << row;
        }
    }
    return texels;
}

/* Start slopes for a set of texels, from differences of neighbours. */
static plane start_of_texels(const plane_ranges *t, uint64_t texels)
{
    for (int y = 0; y < 7; y++)
        for (int x = 0; x < 7; x++) {
            int at = pattern_texel(x, y), right = pattern_texel(x + 1, y), below = pattern_texel(x, y + 1);
            if (texels >> at & texels >> right & texels >> below & 1)
                return (plane){(int32_t)(t->low[right] - t->low[at]), (int32_t)(t->low[below] - t->low[at]), 0};
        }
    return (plane){0, 0, 0};
}

static uint64_t window_texels(int x, int y)
{
    uint64_t texels = 0;
    for (int v = y; v < y + WINDOW; v++)
        for (int u = x; u < x + WINDOW; u++) texels |= 1ull << pattern_texel(u, v);
    return texels;
}

/* Whether the lines of three texels in a window leave room for a plane: most windows that have none are found so. */
static int window_may_fit(const plane_ranges *t, int x, int y)
{
    static const int8_t lines[][4] = {{0, 0, 1, 0}, {0, 1, 1, 0}, {0, 2, 1, 0}, {0, 0, 0, 1},
                                      {1, 0, 0, 1}, {2, 0, 0, 1}, {0, 0, 1, 1}, {2, 0, -1, 1}}; /* first texel, step */
    for (unsigned n = 0; n < sizeof lines / sizeof *lines; n++) {
        const int8_t *l = lines[n];
        int           a = pattern_texel(x + l[0], y + l[1]), between = pattern_texel(x + l[0] + l[2], y + l[1] + l[3]);
        int           b = pattern_texel(x + l[0] + 2 * l[2], y + l[1] + 2 * l[3]);
        if (t->low[a] + t->low[b] > 2 * t->high[between] || t->high[a] + t->high[b] < 2 * t->low[between]) return 0;
    }
    return 1;
}

/* Fit a plane through a window, and add other texels one by one if they join. Returns the texels; 0: no plane. */
static uint64_t grow(plane *p, const plane_ranges *t, uint64_t window)
{
    *p = start_of_texels(t, window);
    if (!plane_fit_texels(p, t, window, OTHERS_ANYWHERE)) return 0;
    uint64_t on = plane_texels(p, t, 0);
    for (int n = 0; n < 4; n++) {
        plane    next = *p;
        uint64_t near = plane_texels(p, t, NEAR);
        if (near == on) break;
        if (!plane_fit_texels(&next, t, near, OTHERS_ANYWHERE)) {
            /* some texels belong to another plane: fit again to those on this one, which gives better slopes */
            next = *p;
            if (!plane_fit_texels(&next, t, on, OTHERS_ANYWHERE)) break;
        }
        uint64_t now = plane_texels(&next, t, 0);
        if (__builtin_popcountll(now) <= __builtin_popcountll(on)) break;
        *p = next;
        on = now;
    }
    return on;
}

int plane_fit_pair(plane pair[2], uint64_t *second, const plane_ranges *t, int thorough)
{
    static const int8_t window[][2] = {{0, 0}, {5, 5}, {5, 0}, {0, 5}, {2, 2}, {3, 0}, {0, 3}, {5, 3}, {3, 5}, {3, 3}};
    const unsigned      count       = thorough ? sizeof window / sizeof *window : FEW_WINDOWS;
    uint64_t            tried       = 0;
    for (unsigned n = 0; n < count; n++) {
        uint64_t texels = window_texels(window[n][0], window[n][1]);
        if ((texels & tried) == texels) continue; /* tried: no plane passes through the other texels */
        if (!window_may_fit(t, window[n][0], window[n][1])) continue;
        uint64_t on = grow(&pair[0], t, texels);
        tried |= on;
        *second = ~on;
        if (!on) continue;
        if (!*second) return 1;
        pair[1] = start_of_texels(t, *second);
        if (plane_fit_texels(&pair[1], t, *second, OTHERS_ANYWHERE)) return 1;
    }
    return 0;
}

/* blocks ---------------------------------------------------------------------------------------------------------------------- */

enum {
    BLOCK_PX    = 32,
    SEEDS       = 6,
    TILE_NEAR   = 3 * PLANE_ONE / 8, /* distance of tiles that may still join the plane of a block */
    BLOCK_ZEROS = 2,                 /* low bits of slopes that may be rounded to zero */
    BLOCK_ROOM  = PLANE_ONE / 2      /* room that is left then */
};

static uint32_t fit_tiles(plane *p, const plane_ranges tiles[16], uint32_t on)
{
    const plane_ranges *list[16];
    int                 count = 0;
    for (uint32_t rest = on; rest; rest &= rest - 1) list[count++] = &tiles[__builtin_ctz(rest)];
    return plane_fit(p, list, count, BLOCK_PX) ? on : 0;
}

/* The most tiles that one plane with these slopes passes through at one depth, if they are more than `enough`.
 * flat  candidates
 * room  [out] of the plane in all of them
 * Returns 0 if they are not more. */
static uint32_t tiles_on_slopes(const plane *p, const plane_ranges tiles[16], uint32_t flat, int enough, plane_room *room)
{
    plane_room rooms[16];
    uint32_t   most = 0;
    for (uint32_t rest = flat; rest; rest &= rest - 1) {
        int                 n    = __builtin_ctz(rest);
        const plane_ranges *tile = &tiles[n];
        rooms[n]                 = room_of(p, &tile, 1);
        if (rooms[n].low <= rooms[n].high) continue;
        flat ^= 1u << n;
        if (__builtin_popcount(flat) <= enough) return 0;
    }
    for (uint32_t at = flat; at; at &= at - 1) {
        uint32_t on = 0;
        for (uint32_t rest = flat; rest; rest &= rest - 1) {
            int n = __builtin_ctz(rest), of = __builtin_ctz(at);
            if (rooms[n].low <= rooms[of].low && rooms[of].low <= rooms[n].high) on |= 1u << n;
        }
        if (__builtin_popcount(on) > __builtin_popcount(most)) most = on;
    }
    if (__builtin_popcount(most) <= enough) return 0;
    *room = rooms[__builtin_ctz(most)];
    for (uint32_t rest = most; rest; rest &= rest - 1) {
        const plane_room *of = &rooms[__builtin_ctz(rest)];
        room->low            = of->low > room->low ? of->low : room->low;
        room->high           = of->high < room->high ? of->high : room->high;
    }
    return most;
}

/* Tiles that a plane through the block comes near. */
static uint32_t tiles_near(const plane *p, const plane_ranges tiles[16], uint32_t mixed)
{
    int32_t  first = p->least + first_over_least(p, BLOCK_PX);
    uint32_t near  = 0;
    for (uint32_t rest = mixed; rest; rest &= rest - 1) {
        int                 n    = __builtin_ctz(rest);
        const plane_ranges *tile = &tiles[n];
        plane_room          room = room_of(p, &tile, 1);
        if (room.low - TILE_NEAR <= (float)first && (float)first <= room.high + TILE_NEAR) near |= 1u << n;
    }
    return near;
}

/* Grow from one tile to all tiles that its plane passes through. */
static uint32_t tiles_about(plane *p, const plane_ranges tiles[16], uint32_t mixed, uint32_t flat, int seed)
{
    uint32_t on = 1u << seed;
    *p          = plane_start(&tiles[seed]);
    if (!(flat & on) || !fit_tiles(p, tiles, on)) return 0;
    for (int n = 0; n < 4; n++) {
        plane    next = *p;
        uint32_t near = tiles_near(p, tiles, mixed) | on;
        if (near == on) break;
        if (!fit_tiles(&next, tiles, near)) {
            /* some of them are not on it: try only neighbours of tiles that are */
            uint32_t beside = (on << 1 & 0xeeee) | (on >> 1 & 0x7777) | on << 4 | on >> 4;
            near            = (near & beside) | on;
            next            = *p;
            if (near == on || !fit_tiles(&next, tiles, near)) break;
        }
        *p = next;
        on = near;
    }
    plane_room room;
    uint32_t   most = tiles_on_slopes(p, tiles, flat, __builtin_popcount(on) - 1, &room);
    if (!most) return on;
    place(p, &room, BLOCK_PX);
    return most;
}

/* Give a plane rounder slopes, unless they leave it little room: it is then the same in more blocks. */
static void round_for_block(plane *p, const plane_ranges tiles[16], uint32_t on)
{
    for (int zeros = BLOCK_ZEROS; zeros > plane_shift(p); zeros--) {
        plane      next = plane_rounded(p, zeros);
        plane_room room;
        if (!tiles_on_slopes(&next, tiles, on, __builtin_popcount(on) - 1, &room) || size_of(&room) < BLOCK_ROOM) continue;
        place(&next, &room, BLOCK_PX);
        *p = next;
        return;
    }
}

void plane_remember(plane recent[PLANES_RECENT], plane p)
{
    int n = 0;
    while (n < PLANES_RECENT - 1 && (recent[n].across != p.across || recent[n].down != p.down)) n++;
    for (; n > 0; n--) recent[n] = recent[n - 1];
    recent[0] = p;
}

uint32_t plane_of_block(plane *p, const plane_ranges tiles[16], uint32_t mixed, uint32_t flat, plane recent[PLANES_RECENT])
{
    uint32_t best = 0, tried = 0;
    for (int n = 0; n < PLANES_RECENT && best != mixed; n++) {
        plane_room room;
        uint32_t   on = tiles_on_slopes(&recent[n], tiles, flat, __builtin_popcount(best), &room);
        if (!on) continue;
        best = on;
        *p   = recent[n];
        place(p, &room, BLOCK_PX);
    }
    for (int seeds = 0; seeds < SEEDS && best != mixed; seeds++) {
        plane    next;
        uint32_t left = mixed & ~tried & ~best;
        if (!left) break;
        int      seed = __builtin_ctz(left);
        uint32_t on   = tiles_about(&next, tiles, mixed, flat, seed);
        tried |= 1u << seed | on;
        if (__builtin_popcount(on) <= __builtin_popcount(best)) continue;
        best = on;
        *p   = next;
        round_for_block(p, tiles, on);
    }
    if (__builtin_popcount(best) < PLANE_TILES_MIN) return 0;
    plane_remember(recent, *p);
    return best;
}

uint32_t plane_passes(const plane *p, const plane_ranges tiles[16], uint32_t some)
{
    float    first = (float)(p->least + first_over_least(p, BLOCK_PX));
    uint32_t on    = 0;
    for (uint32_t rest = some; rest; rest &= rest - 1) {
        const plane_ranges *tile = &tiles[__builtin_ctz(rest)];
        plane_room          room = room_of(p, &tile, 1);
        if (room.low <= first && first <= room.high) on |= rest & -rest;
    }
    return on;
}

int plane_of_all(plane *p, const plane_ranges tiles[16])
{
    plane_room room;
    if (!tiles_on_slopes(p, tiles, 0xffff, 15, &room)) return 0;
    place(p, &room, BLOCK_PX);
    return 1;
}
