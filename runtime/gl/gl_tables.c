/* Tables of lights of palette blocks; see gl_tables.h.
 * SPDX-License-Identifier: MIT */
#include "gl_tables.h"

#include <string.h>

#include "tile_depths.h"

enum {
    WHOLE_BIT    = (int)0x80000000,
    MISSING_BIT  = 0x40000000,
    NODE_WORDS   = 4 + 64,
    BLOCK_WORDS  = 2 + 2 * 16,
    RECORD_WORDS = 63 + 2 * 6,
    SLOTS_FIRST  = 4096,
    NEVER        = 0x3fffffff, /* a depth that no k reaches, whatever the slope adds to it */
    UNUSED       = 0x7fffffff  /* a delta that no depth has */
};

/* Least and greatest depth of texels. */
typedef struct depth_bounds {
    int32_t least, greatest;
} depth_bounds;

static const depth_bounds no_depths = {INT32_MAX, -1};

/* A light whose tables are made. */
typedef struct maker {
    gl_tables        *tables;
    vxs_blocks_map    map;
    vxs_block_cursor  cursor;
    vxs_depths_square square; /* that is read */
    vxs_blocks_node   node;
} maker;

/* memory ---------------------------------------------------------------------------------------------------------------------- */

static void free_words(gl_tables *t)
{
    if (t->words) t->memory.free(t->words, t->capacity * sizeof *t->words, t->memory.user);
    t->words = NULL;
    t->count = t->capacity = 0;
}

static void free_slots(gl_tables *t)
{
    if (t->slots) t->memory.free(t->slots, t->slot_count * sizeof *t->slots, t->memory.user);
    t->slots      = NULL;
    t->slot_count = t->record_count = 0;
}

void vxs_gl_tables_free(gl_tables *tables)
{
    free_words(tables);
    free_slots(tables);
}

void vxs_gl_tables_begin(gl_tables *tables, uint32_t first, uint32_t most)
{
    if (tables->slots) memset(tables->slots, 0, tables->slot_count * sizeof *tables->slots);
    tables->record_count = tables->count = 0;
    tables->first                        = first;
    tables->most                         = most;
}

/* Append words of 0.   at  [out] the first of them */
static vxs_result append(gl_tables *t, uint32_t count, uint32_t *at)
{
    *at = t->count;
    if (count > t->most - t->count) return VXS_E_ARGUMENT;
    if (count > t->capacity - t->count) {
        uint64_t  wanted   = 2 * ((uint64_t)t->count + count) + 1024;
        uint32_t  capacity = wanted < t->most ? (uint32_t)wanted : t->most;
        uint32_t *words    = t->memory.alloc(capacity * sizeof *words, t->memory.user);
        if (!words) return VXS_E_MEMORY;
        if (t->count) memcpy(words, t->words, t->count * sizeof *words);
        uint32_t kept = t->count;
        free_words(t);
        t->words    = words;
        t->capacity = capacity;
        t->count    = kept;
    }
    memset(t->words + t->count, 0, count * sizeof *t->words);
    t->count += count;
    return VXS_OK;
}

/* records --------------------------------------------------------------------------------------------------------------------- */

/* Make the record of a tile. Returns its number of words.
 * least, bits  [out] of the tile;   record  [RECORD_WORDS] */
static uint32_t record_of(const int32_t depth[64], int32_t *least, uint32_t *bits, uint32_t *record)
{
    int32_t  sorted[64], rank[64] = {0}, now = depth[0];
    uint32_t count = 0, words = 0, step;
    for (int n = 1; n < 64; n++) now = depth[n] < now ? depth[n] : now;
    do { /* loops that compilers turn into vectors */
        step            = UINT32_MAX;
        sorted[count++] = now;
        for (int n = 0; n < 64; n++) rank[n] += depth[n] > now;
        for (int n = 0; n < 64; n++) {
            uint32_t more = (uint32_t)(depth[n] - now) - 1; /* of depths that are not deeper: above 2^31 */
            step          = more < step ? more : step;
        }
        now += (int32_t)(step + 1);
    } while (step < 0x80000000u);
    for (*bits = 0; 1u << *bits < count;) ++*bits;
    *least = sorted[0];
    for (uint32_t level = 0; level < *bits; level++) /* of the search tree */
        for (uint32_t n = 0; n < 1u << level; n++) {
            uint32_t index  = (2 * n + 1) << (*bits - level - 1);
            record[words++] = index < count ? (uint32_t)(sorted[index] - *least) : UNUSED;
        }
    uint64_t eight[8] = {0}; /* ranks, a byte each */
    for (int n = 0; n < 64; n++) eight[n >> 3] |= (uint64_t)rank[n] << 8 * (n & 7);
    for (uint32_t bit = *bits; bit-- > 0;)
        for (int half = 0; half < 2; half++, words++) {
            record[words] = 0;
            for (int n = 0; n < 4; n++) { /* the product has bit 0 of byte n at bit 56 + n */
                uint64_t ones = eight[4 * half + n] >> bit & 0x0101010101010101u;
                record[words] |= (uint32_t)(ones * 0x0102040810204080u >> 56) << 8 * n;
            }
        }
    return words;
}

static uint32_t hash_of(const uint32_t *words, uint32_t count)
{
    uint64_t hash = 0x9e3779b97f4a7c15u;
    for (uint32_t n = 0; n < count; n++) {
        hash = (hash ^ words[n]) * 0xff51afd7ed558ccdu;
        hash ^= hash >> 29;
    }
    return (uint32_t)(hash >> 32);
}

static vxs_result grow_slots(gl_tables *t)
{
    uint32_t        count = t->slot_count ? 2 * t->slot_count : SLOTS_FIRST, records = t->record_count;
    gl_record_slot *slots = t->memory.alloc(count * sizeof *slots, t->memory.user);
    if (!slots) return VXS_E_MEMORY;
    memset(slots, 0, count * sizeof *slots);
    for (uint32_t n = 0; n < t->slot_count; n++) {
        uint32_t to = t->slots[n].hash & (count - 1);
        if (!t->slots[n].at) continue;
        while (slots[to].at) to = (to + 1) & (count - 1);
        slots[to] = t->slots[n];
    }
    free_slots(t);
    t->slots        = slots;
    t->slot_count   = count;
    t->record_count = records;
    return VXS_OK;
}

/* Find a record, or append it.   at  [out] where it is */
static vxs_result put_record(gl_tables *t, const uint32_t *record, uint32_t count, uint32_t *at)
{
    vxs_result r = 2 * t->record_count >= t->slot_count ? grow_slots(t) : VXS_OK;
    if (r != VXS_OK) return r;
    uint32_t        hash = hash_of(record, count), n = hash & (t->slot_count - 1);
    gl_record_slot *slot = &t->slots[n];
    for (; slot->at; slot = &t->slots[n = (n + 1) & (t->slot_count - 1)]) {
        *at = slot->at;
        if (slot->hash == hash && t->count - *at >= count && !memcmp(t->words + *at, record, count * sizeof *record)) return VXS_OK;
    }
    if ((r = append(t, count, at)) != VXS_OK) return r;
    memcpy(t->words + *at, record, count * sizeof *record);
    *slot = (gl_record_slot){*at, hash};
    t->record_count++;
    return VXS_OK;
}

/* blocks ---------------------------------------------------------------------------------------------------------------------- */

/* What the slope of the node adds to k at a tile of it. */
static int32_t slope_at(const maker *m, int32_t tile_x, int32_t tile_y)
{
    return vxs_blocks_tile_depth(m->node, tile_x & 31, tile_y & 31) - m->node.k;
}

/* Whether a block has one depth by its record alone.   depth  [out] it */
static int is_whole(const maker *m, int32_t tile_x, int32_t tile_y, int32_t *depth)
{
    uint32_t         c     = (uint32_t)((tile_x >> 2 & 7) | (tile_y >> 2 & 7) << 3);
    vxs_blocks_block block = vxs_blocks_find_block(m->map.words, m->node, c);
    int64_t          base  = (int64_t)block.base - m->node.k;
    if (block.at) return 0;
    *depth = base < NEVER ? (int32_t)base : NEVER;
    /* where depths are clamped to the bounds of the square, they differ from what the record holds */
    for (int n = 0; n < 4; n++) {
        int64_t at_corner = base - slope_at(m, tile_x + 3 * (n & 1), tile_y + 3 * (n >> 1));
        if (at_corner < m->square.least) return 0;
        if (at_corner > m->square.greatest && m->square.greatest < 1 << m->map.levels) return 0;
    }
    return 1;
}

static void add_bounds(depth_bounds *b, int32_t least, int32_t greatest)
{
    b->least    = least < b->least ? least : b->least;
    b->greatest = greatest > b->greatest ? greatest : b->greatest;
}

/* Add the depths of a block of one depth, which has the slope. */
static void add_whole(const maker *m, int32_t tile_x, int32_t tile_y, int32_t depth, depth_bounds *b)
{
    int32_t side = 1 << m->map.levels;
    for (int n = 0; n < 4; n++) {
        int32_t at_corner = depth - slope_at(m, tile_x + 3 * (n & 1), tile_y + 3 * (n >> 1));
        at_corner         = at_corner < 0 ? 0 : at_corner < side ? at_corner : side;
        add_bounds(b, at_corner, at_corner);
    }
}

/* Read the depths of a tile, with the slope, and add those without it to the bounds. Returns whether they are all depth[0]. */
static int read_tile(maker *m, int32_t tile_x, int32_t tile_y, int32_t depth[64], depth_bounds *b)
{
    int whole = vxs_tile_depths(m->map, &m->cursor, tile_x, tile_y, depth) == VXS_TILE_WHOLE, slope = slope_at(m, tile_x, tile_y);
    for (int n = 0; n < (whole ? 1 : 64); n++) {
        add_bounds(b, depth[n], depth[n]);
        depth[n] = depth[n] >> m->map.levels ? NEVER : depth[n] + slope;
    }
    return whole;
}

/* Make a block.
 * tile_x, tile_y  its first tile
 * word            [out] of the node
 * b               [in, out] its depths are added */
static vxs_result make_block(maker *m, int32_t tile_x, int32_t tile_y, uint32_t *word, depth_bounds *b)
{
    gl_tables   *t    = m->tables;
    depth_bounds own  = no_depths;
    int32_t      side = (1 << m->map.levels) / 8, depth[64], first = 0, least;
    uint32_t     at, bits, record[RECORD_WORDS], place = 0;
    *word = (uint32_t)WHOLE_BIT;
    if (tile_x >= side || tile_y >= side) return VXS_OK;
    if (is_whole(m, tile_x, tile_y, &first)) {
        *word |= (uint32_t)first;
        add_whole(m, tile_x, tile_y, first, b);
        return VXS_OK;
    }
    vxs_result r     = append(t, BLOCK_WORDS, &at);
    int        whole = 1;
    for (int n = 0; n < 16 && r == VXS_OK; n++) {
        int32_t x = tile_x + (n & 3), y = tile_y + (n >> 2);
        if (x >= side || y >= side) continue;
        bits = 0;
        if (!read_tile(m, x, y, depth, &own)) {
            uint32_t count = record_of(depth, &least, &bits, record);
            if (bits) r = put_record(t, record, count, &place);
        } else
            least = depth[0];
        if (n == 0) first = least;
        whole &= !bits && least == first;
        t->words[at + 2 + 2 * (uint32_t)n]     = (uint32_t)least;
        t->words[at + 2 + 2 * (uint32_t)n + 1] = bits ? bits << 28 | (t->first + place) : 0;
    }
    if (r != VXS_OK) return r;
    t->words[at]     = (uint32_t)own.least;
    t->words[at + 1] = (uint32_t)own.greatest;
    add_bounds(b, own.least, own.greatest);
    if (whole) t->count = at;
    *word = whole ? *word | (uint32_t)first : t->first + at;
    return VXS_OK;
}

/* lights ---------------------------------------------------------------------------------------------------------------------- */

static uint32_t squares_across(const vxs_light *light)
{
    return 1u << (light->levels > 8 ? light->levels - 8 : 0);
}

uint32_t vxs_gl_tables_square_count(const vxs_light *light)
{
    return vxs_map_count(light) * squares_across(light) * squares_across(light);
}

uint32_t vxs_gl_tables_missing(const vxs_baked_light *baked, uint32_t square, uint32_t *page)
{
    uint32_t levels = baked->light.levels, wide = squares_across(&baked->light), x = square % wide, y = square / wide % wide;
    uint32_t entry = vxs_blocks_entry(baked->words, square / wide / wide, levels, x, y), place = baked->words[entry];
    *page = place >> 16;
    if (place < (uint32_t)WHOLE_BIT) return MISSING_BIT | baked->words[entry + 1] >> 16;
    *page = UINT32_MAX;
    place &= ~(uint32_t)WHOLE_BIT;
    return (uint32_t)WHOLE_BIT | (place < 1u << levels ? place : 1u << levels);
}

/* Make a square, whose page is loaded.   word  [out] of the top */
static vxs_result make_square(maker *m, const vxs_baked_light *baked, uint32_t square, uint32_t *word)
{
    uint32_t     wide = squares_across(&baked->light), x = square % wide, y = square / wide % wide, map = square / wide / wide;
    int32_t      i = (int32_t)x << 8, j = (int32_t)y << 8;
    depth_bounds b = no_depths;
    uint32_t     at, page;
    if (map != m->map.map) m->cursor = (vxs_block_cursor){0};
    m->map.map = map;
    m->square  = vxs_depths_square_at(m->map.words, map, m->map.levels, i, j);
    *word      = (uint32_t)(WHOLE_BIT | m->square.least);
    if (m->square.coarse) return VXS_E_ARGUMENT;
    if (m->square.least == m->square.greatest) return VXS_OK;
    m->node      = vxs_depths_node_of(m->map.words, map, m->map.levels, i, j, m->square.least);
    vxs_result r = append(m->tables, NODE_WORDS, &at);
    if (r != VXS_OK) return r;
    *word                    = m->tables->first + at;
    m->tables->words[at]     = m->node.slope;
    m->tables->words[at + 3] = vxs_gl_tables_missing(baked, square, &page);
    for (uint32_t n = 0; n < 64 && r == VXS_OK; n++) {
        uint32_t block;
        r                            = make_block(m, (int32_t)(32 * x + 4 * (n & 7)), (int32_t)(32 * y + 4 * (n >> 3)), &block, &b);
        m->tables->words[at + 4 + n] = block;
    }
    m->tables->words[at + 1] = (uint32_t)b.least;
    m->tables->words[at + 2] = (uint32_t)b.greatest;
    return r;
}

static maker maker_of(gl_tables *tables, const vxs_baked_light *baked)
{
    return (maker){.tables = tables, .map = {.words = baked->words, .levels = baked->light.levels}};
}

vxs_result vxs_gl_tables_add(gl_tables *tables, const vxs_baked_light *baked, uint32_t *start)
{
    uint32_t   count = vxs_gl_tables_square_count(&baked->light), top;
    maker      m     = maker_of(tables, baked);
    vxs_result r     = append(tables, count, &top);
    *start           = tables->first + top;
    for (uint32_t n = 0; n < count && r == VXS_OK; n++) {
        uint32_t word;
        r                      = make_square(&m, baked, n, &word);
        tables->words[top + n] = word;
    }
    free_slots(tables);
    return r;
}

vxs_result vxs_gl_tables_add_square(gl_tables *tables, const vxs_baked_light *baked, gl_square *square)
{
    maker m = maker_of(tables, baked);
    return make_square(&m, baked, square->number, &square->word);
}
