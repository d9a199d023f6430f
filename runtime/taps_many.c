/* Cache of tile depths of palette blocks; see taps_many.h.
 * SPDX-License-Identifier: MIT */
#include "taps_many.h"

#include <string.h>

/* cache of tile depths ---------------------------------------------------------------------------------------------------------- */

/* Times in units of about what a lookup saves when its tiles are in the cache: cost of decoding a tile, and initial and greatest
 * credit. When the credit is used up, lookups walk the blocks during a rest. Each rest is twice as long as the last one, until
 * the credit reaches its maximum. */
enum { PRICE_FOR_TAP = 6, PRICE_FOR_FILTER = 2, CREDIT_AT_FIRST = 48, CREDIT_MOST = 1000, REST_LEAST = 64, REST_MOST = 1 << 14 };

int vxs_tap_cache_serves(const vxs_baked_light *baked)
{
    return baked->light.coding == VXS_CODING_BLOCKS && baked->light.levels <= VXS_CACHE_LEVELS_MAX;
}

void vxs_tap_cache_init(vxs_tap_cache *cache, const vxs_baked_light *baked)
{
    cache->baked        = baked;
    cache->cursor_map   = 0;
    cache->cursor.block = 0;
    cache->credit       = CREDIT_AT_FIRST;
    cache->rest         = 0;
    cache->next_rest    = REST_LEAST;
    memset(cache->tag, 0, sizeof cache->tag);
}

static uint32_t place_of(int32_t tile_x, int32_t tile_y)
{
    return (uint32_t)((tile_x & (VXS_CACHE_TILES - 1)) | (tile_y & (VXS_CACHE_TILES - 1)) * VXS_CACHE_TILES);
}

/* Decode a tile into the cache, and pay for it with credit; start a rest when that is used up. 0: the tile's page is missing. */
static int keep_tile(vxs_tap_cache *c, uint32_t map, int32_t tile_x, int32_t tile_y, int32_t price)
{
    int32_t              depth[64];
    uint32_t             place = place_of(tile_x, tile_y);
    const vxs_blocks_map m     = {c->baked->words, map, c->baked->light.levels};
    c->credit -= price;
    if (c->credit < 0) {
        c->rest      = c->next_rest;
        c->next_rest = c->next_rest < REST_MOST ? 2 * c->next_rest : REST_MOST;
        c->credit    = CREDIT_AT_FIRST;
    }
    if (map != c->cursor_map) c->cursor.block = 0;
    c->cursor_map = map;
    int found     = vxs_tile_depths(m, &c->cursor, tile_x, tile_y, depth);
    if (found == VXS_TILE_MISSING) return 0;

    int      whole = found == VXS_TILE_WHOLE;
    int32_t  x     = (int32_t)(place % VXS_CACHE_TILES) * 8;
    int16_t *to    = c->depth + place / VXS_CACHE_TILES * 8 * VXS_CACHE_PITCH + x, less[64], least, greatest;
    for (int n = 0; n < 64; n++) less[n] = (int16_t)((whole ? depth[0] : depth[n]) - 1);
    least = greatest = less[0];
    for (int n = 0; n < 64; n++) {
        least    = less[n] < least ? less[n] : least;
        greatest = less[n] > greatest ? less[n] : greatest;
    }
    c->least[place]    = least;
    c->greatest[place] = greatest;
    for (int y = 0; y < 8; y++, to += VXS_CACHE_PITCH) {
        memcpy(to, less + 8 * y, 8 * sizeof *to);
        if (x < VXS_CACHE_PITCH - VXS_CACHE_PX) memcpy(to + VXS_CACHE_PX, to, 8 * sizeof *to);
    }
    return 1;
}

/* Count the texels in a square of width_px x width_px texels of the cache whose depth is less than k. Rows wrap around at the
 * end of the cache. */
#ifdef VXS_VECTORS

typedef int16_t eight __attribute__((vector_size(16), aligned(2), may_alias));

/* Compares eight texels of a row at once; texels beyond the square are read but not counted. */
static inline uint32_t count_texels(const int16_t *depths, int32_t column, int32_t row, int32_t width_px, int32_t k)
{
    static const eight lane = {0, 1, 2, 3, 4, 5, 6, 7};
    eight              sum = {0}, limit = sum + (int16_t)k;
    for (int32_t x = 0; x < width_px; x += 8) {
        eight strip = {0};
        for (int32_t y = 0; y < width_px; y++)
            strip -= *(const eight *)(depths + ((row + y) & (VXS_CACHE_PX - 1)) * VXS_CACHE_PITCH + column + x) < limit;
        sum += strip & (lane < (int16_t)(width_px - x));
    }
    uint64_t two[2];
    memcpy(two, &sum, sizeof two);
    two[0] += two[1];
    two[0] += two[0] >> 32;
    return (uint32_t)(two[0] + (two[0] >> 16)) & 0xffff;
}

/* Sum each column with the weights of its rows, at most 256 * 17. The first width_px columns form one box, and all but the first
 * column the box one texel beside it. */
static inline uint32_t weigh_texels(const int16_t *depths, int32_t column, vxs_smooth_box box, int32_t width_px, int32_t k)
{
    static const eight lane = {0, 1, 2, 3, 4, 5, 6, 7};
    uint16_t           columns[(VXS_FILTER_MAX / 8 + 1) * 8];
    eight              limit = (eight){0} + (int16_t)k;
    vxs_words4         sums  = {0};
    for (int32_t x = 0; x <= width_px; x += 8) {
        eight strip = {0}, dark[2];
        for (int32_t y = 1; y < width_px; y++)
            strip -= *(const eight *)(depths + ((box.y + y) & (VXS_CACHE_PX - 1)) * VXS_CACHE_PITCH + column + x) < limit;
        for (int32_t y = 0; y < 2; y++)
            dark[y] =
                *(const eight *)(depths + ((box.y + y * width_px) & (VXS_CACHE_PX - 1)) * VXS_CACHE_PITCH + column + x) < limit;
        strip = (strip << 8) + (dark[0] & (int16_t)(256 - box.down)) + (dark[1] & (int16_t)box.down);
        memcpy(columns + x, &strip, sizeof strip);
        vxs_words4 pairs = (vxs_words4)(strip & (lane < (int16_t)(width_px - x)));
        sums += (pairs & 0xffff) + (pairs >> 16);
    }
    uint32_t first = sums[0] + sums[1] + sums[2] + sums[3];
    return (256 - box.across) * first + box.across * (first - columns[0] + columns[width_px]);
}

#else

static inline uint32_t count_texels(const int16_t *depths, int32_t column, int32_t row, int32_t width_px, int32_t k)
{
    uint32_t count = 0;
    for (int32_t y = 0; y < width_px; y++)
        for (int32_t x = 0; x < width_px; x++) count += depths[((row + y) & (VXS_CACHE_PX - 1)) * VXS_CACHE_PITCH + column + x] < k;
    return count;
}

static inline uint32_t weigh_texels(const int16_t *depths, int32_t column, vxs_smooth_box box, int32_t width_px, int32_t k)
{
    int32_t right = box.across > 0,
            down  = box.down > 0; /* with an offset of 0 the texels beyond are not cached, and their weight is 0 */
    return vxs_weighted(
        box, count_texels(depths, column, box.y, width_px, k), count_texels(depths, column + right, box.y, width_px, k),
        count_texels(depths, column, box.y + down, width_px, k), count_texels(depths, column + right, box.y + down, width_px, k));
}

#endif

static uint32_t walked(const vxs_tap_cache *c, uint32_t map, int32_t i, int32_t j, int32_t k, int32_t width_px)
{
    return vxs_walk_taps(c->baked, (int32_t)map, i, j, (uint32_t)k, width_px);
}

/* A lookup in the cache earns credit, which pays for tiles. */
static void earn(vxs_tap_cache *c)
{
    if (c->credit < CREDIT_MOST)
        c->credit++;
    else
        c->next_rest = REST_LEAST;
}

/* Ensure that a tile is in the cache; 0: its page is missing. */
static inline int have_tile(vxs_tap_cache *c, uint32_t map, int32_t tile_x, int32_t tile_y, int32_t price)
{
    uint32_t place = place_of(tile_x, tile_y), tag = 1 + ((uint32_t)tile_x | (uint32_t)tile_y << 12 | map << 24);
    if (c->tag[place] == tag) return 1;
    if (!keep_tile(c, map, tile_x, tile_y, price)) return 0;
    c->tag[place] = tag;
    return 1;
}

/* A rectangle of texels of a map, x1 and y1 included. */
typedef struct texels {
    int32_t x0, y0, x1, y1;
} texels;

/* State of the tiles of some texels at a depth. */
typedef enum kind { LIT, DARK, MIXED, MISSING } kind;

static inline kind classify_tiles(vxs_tap_cache *c, uint32_t map, texels box, int32_t k)
{
    int16_t least = INT16_MAX, greatest = INT16_MIN;
    for (int32_t y = box.y0 >> 3; y <= box.y1 >> 3; y++)
        for (int32_t x = box.x0 >> 3; x <= box.x1 >> 3; x++) {
            if (!have_tile(c, map, x, y, PRICE_FOR_FILTER)) return MISSING;
            uint32_t place = place_of(x, y);
            least          = c->least[place] < least ? c->least[place] : least;
            greatest       = c->greatest[place] > greatest ? c->greatest[place] : greatest;
        }
    return k <= least ? LIT : k > greatest ? DARK : MIXED;
}

uint32_t vxs_cached_taps(vxs_tap_cache *c, uint32_t map, int32_t i, int32_t j, int32_t k, int32_t width_px)
{
    int32_t half_px = width_px / 2, last = (1 << c->baked->light.levels) - 1 - half_px, x0 = i - half_px, y0 = j - half_px;
    if (c->rest > 0) {
        c->rest--;
        return walked(c, map, i, j, k, width_px);
    }
    if (x0 < 0 || y0 < 0 || i > last || j > last) return walked(c, map, i, j, k, width_px);

    earn(c);
    if (width_px == 1) {
        if (!have_tile(c, map, i >> 3, j >> 3, PRICE_FOR_TAP)) return walked(c, map, i, j, k, 1);
        return c->depth[(j & (VXS_CACHE_PX - 1)) * VXS_CACHE_PITCH + (i & (VXS_CACHE_PX - 1))] < k;
    }
    kind found = classify_tiles(c, map, (texels){x0, y0, i + half_px, j + half_px}, k);
    if (found == MISSING) return walked(c, map, i, j, k, width_px);
    if (found != MIXED) return found == DARK ? (uint32_t)(width_px * width_px) : 0;
    int32_t column = x0 & (VXS_CACHE_PX - 1);
    if (width_px == 9) return count_texels(c->depth, column, y0, 9, k); /* the most common size: loops with constant bounds */
    return count_texels(c->depth, column, y0, width_px, k);
}

uint32_t vxs_cached_part(vxs_tap_cache *c, vxs_place place, int32_t k, int32_t width_px)
{
    vxs_smooth_box box  = vxs_smooth_box_at(place.voxel[0], place.voxel[1], place.across, place.down, width_px);
    texels         all  = {box.x, box.y, box.x + width_px - (box.across == 0), box.y + width_px - (box.down == 0)};
    int32_t        side = 1 << c->baked->light.levels, tries = c->rest <= 0;
    kind           found = MISSING;
    if (!tries) c->rest--;
    if (tries && all.x0 >= 0 && all.y0 >= 0 && all.x1 < side && all.y1 < side) {
        earn(c);
        found = classify_tiles(c, (uint32_t)place.map, all, k);
    }
    if (found == MISSING) return vxs_walk_part(c->baked, place, (uint32_t)k, width_px);
    if (found != MIXED) return found == DARK ? 65536 * (uint32_t)(width_px * width_px) : 0;
    int32_t column = box.x & (VXS_CACHE_PX - 1);
    if (width_px == 9) return weigh_texels(c->depth, column, box, 9, k); /* as above */
    return weigh_texels(c->depth, column, box, width_px, k);
}

/* path through a DAG ------------------------------------------------------------------------------------------------------------ */

void vxs_dag_path_init(vxs_dag_path *path, const vxs_baked_light *baked, uint32_t map)
{
    path->words  = baked->words;
    path->levels = baked->light.levels;
    path->root   = baked->light.flags & VXS_LIGHT_CUBE ? vxs_face_root(baked->words, map) : 0;
    path->x = path->y = path->z = ~0u; /* no slice has this position, so that the first walk starts at the root */
    path->end                   = path->levels - 3;
    path->state                 = 2;
    path->node[path->end]       = path->root;
}

/* Mask of a slice, as vxs_slice. */
static inline vxs_mask slice(vxs_dag_path *path, uint32_t x, uint32_t y, uint32_t k)
{
    const uint32_t *dag = path->words;
    uint32_t        z = k >> 3, differ = (x ^ path->x) | (y ^ path->y) | (z ^ path->z), level = path->levels - 3;
    while (level > path->end && !(differ >> (level - 1))) level--; /* same child as in the last walk */
    if (level == path->end && path->state < 2 && !(differ >> (level - 1))) return vxs_uniform_mask(path->state);

    uint32_t node = path->node[level], states, state;
    path->x       = x;
    path->y       = y;
    path->z       = z;
    path->state   = 2;
    for (; level > 0; level--) {
        uint32_t bit = level - 1, xy = (x >> bit & 1) | (y >> bit & 1) << 1, c = xy | (z >> bit & 1) << 2;
        path->node[level] = node;
        states            = vxs_word(dag, node);
        state             = states >> 2 * c & 3;
        if (state == VXS_CHILD_SAME) {
            c     = xy;
            state = VXS_CHILD_OWN;
        }
        if (state != VXS_CHILD_OWN) {
            path->end   = level;
            path->state = state;
            return vxs_uniform_mask(state);
        }
        node = vxs_word(dag, node + 1 + vxs_popcount(vxs_own(states) & ((1u << 2 * c) - 1)));
    }

    path->end     = 0;
    path->node[0] = node;
    states        = vxs_word(dag, node);
    state         = states >> 2 * (k & 7) & 3;
    if (state < VXS_CHILD_OWN) return vxs_uniform_mask(state);
    uint32_t at = vxs_word(dag, node + vxs_popcount(vxs_own(states) & ((2u << 2 * (k & 7)) - 1)));
    return (vxs_mask){vxs_word(dag, at), vxs_word(dag, at + 1)};
}

uint32_t vxs_dag_path_shadow(vxs_dag_path *path, uint32_t i, uint32_t j, uint32_t k)
{
    vxs_mask mask = slice(path, i >> 3, j >> 3, k);
    return (j & 4 ? mask.high : mask.low) >> ((i & 7) + 8 * (j & 3)) & 1;
}

uint32_t vxs_dag_path_count(vxs_dag_path *path, int32_t i, int32_t j, uint32_t k, int32_t width_px)
{
    int32_t  half_px = width_px / 2, side = 1 << path->levels;
    int32_t  x0 = i < half_px ? 0 : i - half_px, y0 = j < half_px ? 0 : j - half_px;
    int32_t  x1 = i >= side - half_px ? side : i + half_px + 1, y1 = j >= side - half_px ? side : j + half_px + 1;
    uint32_t count = 0;
    for (int32_t y = y0 & ~7; y < y1; y += 8)
        for (int32_t x = x0 & ~7; x < x1; x += 8) {
            vxs_mask mask = slice(path, (uint32_t)x >> 3, (uint32_t)y >> 3, k);
            if (mask.low | mask.high) count += vxs_count_covered(mask, x0 - x, x1 - x, y0 - y, y1 - y);
        }
    return count;
}

uint32_t vxs_dag_path_weight(vxs_dag_path *path, vxs_smooth_box box, uint32_t k, int32_t width_px)
{
    int32_t  side = 1 << path->levels, x0 = box.x < 0 ? 0 : box.x, y0 = box.y < 0 ? 0 : box.y;
    int32_t  x1 = box.x + width_px + (box.across > 0), y1 = box.y + width_px + (box.down > 0);
    uint32_t sum = 0;
    x1           = x1 < side ? x1 : side;
    y1           = y1 < side ? y1 : side;
    for (int32_t y = y0 & ~7; y < y1; y += 8)
        for (int32_t x = x0 & ~7; x < x1; x += 8) {
            vxs_mask mask = slice(path, (uint32_t)x >> 3, (uint32_t)y >> 3, k);
            if (mask.low | mask.high) sum += vxs_weigh_mask(mask, box, box.x - x, box.y - y, width_px, 1);
        }
    return sum;
}
