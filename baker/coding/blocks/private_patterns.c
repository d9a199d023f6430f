/* Private-palette patterns; see private_patterns.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/blocks/private_patterns.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/cpu.h"
#include "baker/base/simd.h"
#include "baker/coding/blocks/patterns.h"
#include "baker/coding/blocks/stabbing_set.h"

#ifdef __x86_64__
#include <immintrin.h>
#endif

enum { PAIRS = 4, GROUP = 16, SHIFTS = 8, MARGIN = 1024, BYTES_HALVES_MIN = 19 /* least size of depths in bytes */ };

/* So many depths take more than PRIVATE_PLANES_HALVES_MAX halves: 1 for the head, 4 for depths in bytes, 4 for states of masks, and two
 * masks, as a quadrant changes once more than it has masks of its own. */
enum { MANY_DEPTHS = 8 };

/* Pairs of texels that are compared first, spread over the tile: the depth difference of a pair does not depend on the base. */
static const int pair_texels[PAIRS][2] = {{0, 63}, {22, 41}, {15, 51}, {28, 37}};

typedef struct private_known {
    int16_t  depth[64];
    uint32_t id;
} private_known;

/* Pairs of GROUP patterns, which are searched at once. */
typedef struct pair_group {
    int16_t deeper[PAIRS][GROUP];
} pair_group;

/* Ranges in 16 bits, relative to `floor`; clamping excludes no choice. */
typedef struct half_ranges {
    int16_t low[64], high[64];
    int32_t floor;
} half_ranges;

static int32_t greatest_low(const tile_ranges *t)
{
    int32_t greatest = t->low[0];
    for (int n = 1; n < 64; n++) greatest = t->low[n] > greatest ? t->low[n] : greatest;
    return greatest;
}

/* Whether there is a base with which all depths are in their ranges. */
static int fits_at(const half_ranges *t, const int16_t depth[64], int *base)
{
    i16x8 least = i16x8_all(0), most = i16x8_all(INT16_MAX);
    for (int n = 0; n < 64; n += 8) {
        i16x8 d = i16x8_load(depth + n);
        least   = i16x8_max(least, i16x8_subs(i16x8_load(t->low + n), d));
        most    = i16x8_min(most, i16x8_subs(i16x8_load(t->high + n), d));
        if (i16x8_any((i16x8)(least > most))) return 0;
    }
    *base = i16x8_greatest(least);
    return *base <= i16x8_least(most);
}

/* Range of the depth difference of each pair. */
typedef struct pair_ranges {
    int16_t low[PAIRS], high[PAIRS];
} pair_ranges;

/* Bits of the patterns of a group that the pairs do not rule out. */
typedef uint32_t find_possible(const pair_group *g, const pair_ranges *r);

static ALWAYS_INLINE uint32_t possible(const pair_group *g, const pair_ranges *r)
{
    i16x8 a = i16x8_all(0), b = i16x8_all(0);
    for (int n = 0; n < PAIRS; n++) {
        i16x8 low = i16x8_all(r->low[n]), high = i16x8_all(r->high[n]);
        i16x8 x = i16x8_load(g->deeper[n]), y = i16x8_load(g->deeper[n] + GROUP / 2);
        a |= (i16x8)(x < low) | (i16x8)(x > high);
        b |= (i16x8)(y < low) | (i16x8)(y > high);
        if (n == PAIRS / 2 - 1 && i16x8_bits(a, b) == 0xffff) return 0;
    }
    return ~i16x8_bits(a, b) & 0xffff;
}

#ifdef __x86_64__

CPU_TARGET_AVX2 static ALWAYS_INLINE uint32_t possible_avx2(const pair_group *g, const pair_ranges *r)
{
    __m256i out = _mm256_setzero_si256();
    for (int n = 0; n < PAIRS; n++) {
        __m256i deeper = _mm256_loadu_si256((const __m256i *)(const void *)g->deeper[n]);
        out            = _mm256_or_si256(out, _mm256_cmpgt_epi16(_mm256_set1_epi16(r->low[n]), deeper));
        out            = _mm256_or_si256(out, _mm256_cmpgt_epi16(deeper, _mm256_set1_epi16(r->high[n])));
    }
    __m128i bytes = _mm_packs_epi16(_mm256_castsi256_si128(out), _mm256_extracti128_si256(out, 1));
    return ~(uint32_t)_mm_movemask_epi8(bytes) & 0xffff;
}

#endif

static uint32_t last_bit(uint32_t bits)
{
    return 31 - (uint32_t)__builtin_clz(bits);
}

/* Returns the place of a pattern that fits, or the count. */
static ALWAYS_INLINE size_t search_by(find_possible *find, const private_set *s, const half_ranges *t, int *base)
{
    size_t window = s->thorough ? PRIVATE_WINDOW : PRIVATE_WINDOW_LESS,
           stop   = s->known_count > window ? s->known_count - window : 0;
    pair_ranges r;
    for (int n = 0; n < PAIRS; n++) {
        int from = pair_texels[n][0], to = pair_texels[n][1];
        r.low[n]  = (int16_t)(t->low[to] - t->high[from]);
        r.high[n] = (int16_t)(t->high[to] - t->low[from]);
    }
    for (size_t end = s->known_count; end > stop;) {
        size_t   first = (end - 1) / GROUP * GROUP;
        uint32_t hits  = find(&s->groups[first / GROUP], &r) & ((2u << (end - 1 - first)) - 1);
        for (; hits; hits &= ~(1u << last_bit(hits))) {
            size_t at = first + last_bit(hits);
            if (at >= stop && fits_at(t, s->known[at].depth, base)) return at;
        }
        end = first;
    }
    return s->known_count;
}

#ifdef __x86_64__

CPU_TARGET_AVX2 static size_t search_avx2(const private_set *s, const half_ranges *t, int *base)
{
    return search_by(possible_avx2, s, t, base);
}

#endif

static size_t search(const private_set *s, const half_ranges *t, int *base)
{
#ifdef __x86_64__
    if (s->cpu >= CPU_AVX2) return search_avx2(s, t, base);
#endif
    return search_by(possible, s, t, base);
}

/* choosing -------------------------------------------------------------------------------------------------------------------- */

/* Predict a depth from earlier texels: by a plane through three of them, or a line through two. */
static int32_t predicted(int32_t d[8][8], int x, int y)
{
    if (x && y) return d[y][x - 1] + d[y - 1][x] - d[y - 1][x - 1];
    if (x) return x > 1 ? 2 * d[0][x - 1] - d[0][x - 2] : d[0][0];
    return y > 1 ? 2 * d[y - 1][0] - d[y - 2][0] : d[0][0];
}

/* Choose depths in bytes, in steps of 1 << shift, each as near to its prediction as its range allows. Returns 0 if they do not
 * fit. */
static int choose_bytes(private_pattern *p, const tile_ranges *t, int shift, int32_t *base)
{
    int32_t first = least_high(t), last = greatest_low(t), step = 1 << shift, d[8][8], least = 255;
    if ((last - first + step - 1) >> shift > 255) return 0;
    for (int y = 0; y < 8; y++)
        for (int x = 0; x < 8; x++) {
            int     n   = pattern_texel(x, y);
            int32_t low = t->low[n] <= first ? 0 : (t->low[n] - first + step - 1) >> shift, high = (t->high[n] - first) >> shift;
            high = high > 255 ? 255 : high;
            if (low > high) return 0;
            int32_t near = x || y ? predicted(d, x, y) : (low + high) / 2;
            d[y][x]      = near < low ? low : near > high ? high : near;
            least        = d[y][x] < least ? d[y][x] : least;
        }
    for (int y = 0; y < 8; y++)
        for (int x = 0; x < 8; x++) p->depth[pattern_texel(x, y)] = (d[y][x] - least) << shift;
    *base = first + (least << shift);
    return 1;
}

/* The fewest depths that a tile needs. */
typedef struct fewest_depths {
    stab_group groups[64];
    int        count;
} fewest_depths;

static void find_fewest(fewest_depths *f, const half_ranges *halves, int cpu)
{
    intervals s;
    s.count = 64;
    memcpy(s.low, halves->low, sizeof halves->low);
    memcpy(s.high, halves->high, sizeof halves->high);
    f->count = minimum_stabbing_set(&s, f->groups, 64, cpu);
}

/* Choose depths that take few halves: few distinct ones, or bytes.
 * halves, few  NULL: the depths span too much
 * Returns the number of halves. */
static uint32_t choose_depths(private_pattern *p, const tile_ranges *t, const half_ranges *halves, const fewest_depths *few,
                              int32_t *base)
{
    uint16_t        code[PRIVATE_HALVES_MAX];
    private_pattern bytes;
    int32_t         base_of_bytes;
    if (halves) {
        int16_t points[64];
        uint8_t low[64], high[64], index[64];
        for (int n = 0; n < few->count; n++) points[n] = few->groups[n].low;
        points_of_ranges(halves->low, halves->high, 64, points, few->count, low, high);
        pattern_choose_within(low, high, index);
        for (int n = 0; n < 64; n++) p->depth[n] = points[index[n]] - points[0];
        *base = halves->floor + points[0];
    } else { /* choose each as near to the first as its range allows */
        *base = least_high(t);
        for (int n = 0; n < 64; n++) p->depth[n] = t->low[n] > *base ? t->low[n] - *base : 0;
    }

    /* Make the least depth 0. */
    int32_t least = p->depth[0];
    for (int n = 1; n < 64; n++) least = p->depth[n] < least ? p->depth[n] : least;
    for (int n = 0; n < 64; n++) p->depth[n] -= least;
    *base += least;

    p->plane_halves        = 0;
    uint32_t halves_of_few = private_encode(p->depth, code);
    for (int shift = 0; shift < SHIFTS && halves_of_few > BYTES_HALVES_MIN; shift++) {
        if (!choose_bytes(&bytes, t, shift, &base_of_bytes)) continue;
        uint32_t count = private_encode(bytes.depth, code);
        if (count >= halves_of_few) break;
        memcpy(p->depth, bytes.depth, sizeof p->depth);
        *base = base_of_bytes;
        return count;
    }
    return halves_of_few;
}

/* Whether a search can compare all depths in 16 bits. */
static int in_halves(const int32_t depth[64])
{
    for (int n = 0; n < 64; n++)
        if (depth[n] > INT16_MAX) return 0;
    return 1;
}

static void take_planes(private_pattern *p, const private_planes *planes, int32_t *base)
{
    memcpy(p->depth, planes->depth, sizeof p->depth);
    memcpy(p->planes, planes->halves, sizeof p->planes);
    p->plane_halves = planes->count;
    *base           = planes->base;
}

/* Choose one plane, or depths, or two planes if these are certain to take less. */
static void choose(const private_set *s, private_pattern *p, const tile_ranges *t, const half_ranges *halves,
                   const private_planes *planes, int32_t *base)
{
    private_planes pair;
    fewest_depths  few;
    if (planes->count && (!halves || in_halves(planes->depth))) {
        take_planes(p, planes, base);
        return;
    }
    few.count = 0;
    if (halves) find_fewest(&few, halves, s->cpu);
    const int many = few.count >= MANY_DEPTHS;
    if (!many && choose_depths(p, t, halves, &few, base) <= PRIVATE_PLANES_HALVES_MAX) return;
    private_plane_pair(&pair, t, s->thorough);
    if (pair.count && (!halves || in_halves(pair.depth)))
        take_planes(p, &pair, base);
    else if (many)
        choose_depths(p, t, halves, &few, base);
}

uint32_t private_pattern_encode(const private_pattern *p, uint16_t *halves)
{
    if (!p->plane_halves) return private_encode(p->depth, halves);
    memcpy(halves, p->planes, p->plane_halves * sizeof *halves);
    return p->plane_halves;
}

/* Narrow the pattern's ranges by one more tile. */
static void narrow(private_pattern *p, const tile_ranges *t, int32_t base)
{
    for (int n = 0; n < 64; n++) {
        int32_t low = t->low[n] - base, high = t->high[n] - base;
        p->may.low[n]  = low > p->may.low[n] ? low : p->may.low[n];
        p->may.high[n] = high < p->may.high[n] ? high : p->may.high[n];
    }
}

static vxs_result remember(private_set *s, const private_pattern *p, uint32_t id)
{
    size_t at = s->known_count;
    if (!array_reserve(&s->known, &s->known_capacity, at + 1, sizeof *s->known)) return VXS_E_MEMORY;
    if (!array_reserve(&s->groups, &s->group_capacity, at / GROUP + 1, sizeof *s->groups)) return VXS_E_MEMORY;
    if (at % GROUP == 0) s->groups[at / GROUP] = (pair_group){0};
    private_known *k = &s->known[at];
    k->id            = id;
    for (int n = 0; n < 64; n++) k->depth[n] = (int16_t)p->depth[n];
    for (int n = 0; n < PAIRS; n++)
        s->groups[at / GROUP].deeper[n][at % GROUP] = (int16_t)(k->depth[pair_texels[n][1]] - k->depth[pair_texels[n][0]]);
    s->known_count++;
    return VXS_OK;
}

/* Add a new pattern.   like  the pattern to copy; NULL: choose one, which may be `planes` */
static vxs_result add(private_set *s, const tile_ranges *t, const half_ranges *halves, const private_planes *planes,
                      const private_pattern *like, uint32_t *id, int32_t *base)
{
    if (!array_reserve(&s->patterns, &s->pattern_capacity, s->count + 1, sizeof *s->patterns)) return VXS_E_MEMORY;
    private_pattern *p = &s->patterns[s->count];
    *base              = 0;
    if (like)
        *p = *like;
    else
        choose(s, p, t, halves, planes, base);
    for (int n = 0; n < 64; n++) {
        p->may.low[n]  = t->low[n] - *base;
        p->may.high[n] = t->high[n] - *base;
    }
    *id = (uint32_t)s->count;
    if (halves && remember(s, p, *id) != VXS_OK) return VXS_E_MEMORY;
    s->count++;
    return VXS_OK;
}

static vxs_result find(private_set *s, const tile_ranges *t, const private_planes *planes, const private_pattern *like,
                       uint32_t *id, int32_t *base)
{
    half_ranges halves;
    int         at_half;
    halves.floor = least_high(t) - MARGIN;
    if (greatest_low(t) - halves.floor > INT16_MAX - MARGIN) return add(s, t, NULL, planes, like, id, base);
    for (int n = 0; n < 64; n++) {
        int32_t low = t->low[n] - halves.floor, high = t->high[n] - halves.floor;
        halves.low[n]  = (int16_t)(low < 0 ? 0 : low);
        halves.high[n] = (int16_t)(high > INT16_MAX ? INT16_MAX : high);
    }
    size_t at = search(s, &halves, &at_half);
    if (at == s->known_count) return add(s, t, &halves, planes, like, id, base);
    *id   = s->known[at].id;
    *base = halves.floor + at_half;
    narrow(&s->patterns[*id], t, *base);

    /* move the pattern halfway to where searches begin */
    size_t        to  = at + (s->known_count - at) / 2;
    private_known was = s->known[at];
    s->known[at]      = s->known[to];
    s->known[to]      = was;
    for (int n = 0; n < PAIRS; n++) {
        int16_t *x = &s->groups[at / GROUP].deeper[n][at % GROUP], *y = &s->groups[to / GROUP].deeper[n][to % GROUP], pair = *x;
        *x = *y;
        *y = pair;
    }
    return VXS_OK;
}

vxs_result private_find(private_set *s, const tile_ranges *t, const private_planes *planes, uint32_t *id, int32_t *base)
{
    return find(s, t, planes, NULL, id, base);
}

vxs_result private_adopt(private_set *s, const private_pattern *p, uint32_t *id, int32_t *base)
{
    return find(s, &p->may, NULL, p, id, base);
}

void private_set_free(private_set *s)
{
    free(s->patterns);
    free(s->known);
    free(s->groups);
    memset(s, 0, sizeof *s);
}
