/* A merged multiresolution hierarchy of depth intervals; see rival.h.
 *
 * After Scandolo, Bauszat and Eisemann, "Merged Multiresolution Hierarchies for Shadow Map Compression", Computer Graphics Forum
 * 35(7), 2016, and the hierarchies that it merges ("Compressed Multiresolution Hierarchies for High-Quality Precomputed Shadows",
 * 35(2), 2016), as they are described; no code of theirs was seen. Taken from there:
 *
 *   - a texel is right at every depth from where light enters the first solid to where it leaves: [e, x];
 *   - a quadtree over the map. Where its children's intervals have a depth in common, a node needs one depth for all of them;
 *   - other depths are relative to the parent's, so that subtrees that differ by a constant are the same subtree;
 *   - equal subtrees are one, found by hash.
 *
 * Done here in its own way:
 *
 *   - the interval stays with a subtree as long as possible: a subtree is contents (steps and subtrees below) and the interval of
 *     depths at its root for which the contents are right. Only the root of the map takes a depth, at the end;
 *   - a node's own depth is one that most of its children can take, of several such the farthest from the light. To any other child
 *     it takes a step, of those that are right the roundest in binary, so that equal ones are met: with that, files of the city and
 *     of Sponza are 2 to 5 % smaller than with steps that keep intervals wide, or with the depth nearest to the light;
 *   - a depth at or behind the far side of the map is as good as any other there: empty texels have an interval, too;
 *   - contents do not say how large they are, so that subtrees of different levels may be one.
 *
 * In memory a node is words:
 *
 *     word 0   bits 2c, 2c+1: child c = x + 2y; the low bit: it has a step, else it takes its parent's depth; the high bit: it is a
 *              node, else it has one depth all over. Bits 16..31: the first step, signed, voxels
 *     word     the second and third step, when there are more than one (there are never four: one child takes the node's depth)
 *     words    for each child that is a node, where it starts, in the order of c
 *
 * On disk nodes lie in the order in which they are first referred to, breadth first; a reference is a varint, 0 for a node that was
 * not met before, else how far back it is numbered. States, references and steps are a zstd frame each.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>
#include <zstd.h>

#include "formats/vxs_lookup.h" /* before dag.h: a lookup calls its light's words `dag` */

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "baker/base/ref_table.h"
#include "tests/bench/rival.h"

/* building --------------------------------------------------------------------------------------------------------------------- */

enum { UNIFORM = 0, NODE_FIRST = 1, DEPTH_FAR = 32767 }; /* references; the farthest depth, so that steps have 16 bits */

typedef struct interval_node {
    uint32_t child[4]; /* UNIFORM, or NODE_FIRST + index */
    int32_t  step[4];  /* voxels, from the node's depth to the child's; 0: the same */
} interval_node;

/* Contents, and the depths at its root for which they are right. */
typedef struct subtree {
    uint32_t ref;
    int32_t  low, high; /* voxels */
} subtree;

typedef struct builder {
    const column_square *columns;
    interval_node       *nodes;
    uint32_t             count, capacity;
    ref_table            table;
    int                  failed;
} builder;

/* Of the numbers [low, high], which do not include 0, the one with the most zeros at its binary end. */
static int32_t roundest(int32_t low, int32_t high)
{
    if (high < 0) return -roundest(-high, -low);
    int32_t mask = 0;
    while ((high & ~(2 * mask + 1)) >= low) mask = 2 * mask + 1;
    return high & ~mask;
}

/* The reference to a node of these contents. */
static uint32_t node_ref(builder *b, const interval_node *node)
{
    uint64_t hash = XXH3_64bits(node, sizeof *node), at;
    b->failed |= !ref_table_reserve(&b->table, 1);
    if (b->failed) return UNIFORM;
    at = ref_table_first(&b->table, hash);
    for (uint32_t found; (found = ref_table_match(&b->table, hash, &at)); at = ref_table_next(&b->table, at))
        if (!memcmp(&b->nodes[found - NODE_FIRST], node, sizeof *node)) return found;
    if (b->count == b->capacity) {
        uint32_t       capacity = b->capacity ? 2 * b->capacity : 4096;
        interval_node *nodes    = realloc(b->nodes, capacity * sizeof *nodes);
        if (!nodes) {
            b->failed = 1;
            return UNIFORM;
        }
        b->nodes    = nodes;
        b->capacity = capacity;
    }
    b->nodes[b->count] = *node;
    ref_table_put(&b->table, hash, at, NODE_FIRST + b->count);
    return NODE_FIRST + b->count++;
}

static int holds(const subtree *s, int32_t depth)
{
    return s->low <= depth && depth <= s->high;
}

/* A depth that most of the four can take, of several such where the farthest interval begins. */
static int32_t common_depth(const subtree child[4])
{
    int32_t best = 0;
    int     most = 0;
    for (int n = 0; n < 4; n++) {
        int32_t depth = child[n].low; /* where an interval begins is where one more can take it */
        int     count = 0;
        for (int c = 0; c < 4; c++) count += holds(&child[c], depth);
        if (count > most || (count == most && depth > best)) {
            most = count;
            best = depth;
        }
    }
    return best;
}

static int32_t least(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static int32_t most(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

static subtree join(builder *b, const subtree child[4])
{
    int32_t       depth = common_depth(child);
    subtree       all   = {UNIFORM, 0, DEPTH_FAR};
    interval_node node;
    int           is_uniform = 1;
    memset(&node, 0, sizeof node);
    for (int c = 0; c < 4; c++) {
        node.child[c] = child[c].ref;
        is_uniform &= child[c].ref == UNIFORM && holds(&child[c], depth);
        if (!holds(&child[c], depth)) continue;
        all.low  = most(all.low, child[c].low);
        all.high = least(all.high, child[c].high);
    }
    if (is_uniform) return all;

    for (int c = 0; c < 4; c++) {
        if (holds(&child[c], depth)) continue;
        node.step[c] = roundest(child[c].low - all.high, child[c].high - all.low);
        all.low      = most(all.low, child[c].low - node.step[c]);
        all.high     = least(all.high, child[c].high - node.step[c]);
    }
    all.ref = node_ref(b, &node);
    return all;
}

/* Right from e to x. Lit to the far side, or free to there, is right at any depth that lies behind. */
static subtree column(const builder *b, uint32_t e, uint32_t x)
{
    return (subtree){UNIFORM, (int32_t)e, x >= b->columns->depth_vx ? DEPTH_FAR : (int32_t)x};
}

static subtree build_tile(builder *b, uint32_t i, uint32_t j)
{
    column_tile t;
    subtree     s[64];
    b->columns->tile(b->columns->data, i, j, &t);
    for (int n = 0; n < 64; n++) s[n] = column(b, t.e[n], t.x[n]);
    for (int side = 4; side; side /= 2)
        for (int y = 0; y < side; y++)
            for (int x = 0; x < side; x++) {
                const subtree *near = s + 2 * y * 2 * side + 2 * x, *next = near + 2 * side;
                s[y * side + x] = join(b, (const subtree[4]){near[0], near[1], next[0], next[1]});
            }
    return s[0];
}

/* The square (i, j) of 8 << level texels. */
static subtree build_square(builder *b, uint32_t level, uint32_t i, uint32_t j)
{
    column_bounds bounds;
    b->columns->bounds(b->columns->data, level, i, j, &bounds);
    subtree child[4];
    if (bounds.emax <= bounds.xmin) return column(b, bounds.emax, bounds.xmin);
    if (level == 0) return build_tile(b, i, j);
    for (uint32_t c = 0; c < 4; c++) child[c] = build_square(b, level - 1, 2 * i + (c & 1), 2 * j + (c >> 1));
    return join(b, child);
}

/* the file --------------------------------------------------------------------------------------------------------------------- */

enum { STREAM_STATES, STREAM_REFERENCES, STREAM_STEPS, STREAM_COUNT };

/* At the start of a file; the streams follow. */
typedef struct intervals_head {
    uint32_t levels, node_count;
    int32_t  root_depth;
    uint32_t stored_bytes[STREAM_COUNT], bytes[STREAM_COUNT];
} intervals_head;

typedef struct stream {
    uint8_t *data;
    size_t   size;
} stream;

static uint32_t child_state(const interval_node *node, int c)
{
    return (node->child[c] != UNIFORM) << 1 | (node->step[c] != 0);
}

/* The reachable nodes as streams, the largest that they may become allocated: 4 references of 5 bytes, 3 steps of 2 bytes. */
static int write_streams(const builder *b, uint32_t root, stream out[STREAM_COUNT])
{
    uint32_t *order = malloc((size_t)b->count * sizeof *order), *number = calloc(b->count, sizeof *number), met = 1;
    size_t    room[STREAM_COUNT] = {b->count, (size_t)b->count * 20, (size_t)b->count * 6};
    int       ok                 = order && number;
    for (int n = 0; n < STREAM_COUNT; n++) ok &= (out[n].data = malloc(room[n])) != NULL;
    if (!ok) goto done;
    order[0]                  = root - NODE_FIRST;
    number[root - NODE_FIRST] = met;
    for (uint32_t n = 0; n < met; n++) {
        const interval_node *node   = &b->nodes[order[n]];
        uint32_t             states = 0;
        for (int c = 0; c < 4; c++) {
            states |= child_state(node, c) << 2 * c;
            if (node->step[c]) {
                uint8_t *at = out[STREAM_STEPS].data + out[STREAM_STEPS].size;
                at[0]       = (uint8_t)node->step[c];
                at[1]       = (uint8_t)(node->step[c] >> 8);
                out[STREAM_STEPS].size += 2;
            }
            if (node->child[c] == UNIFORM) continue;
            uint32_t *seen = &number[node->child[c] - NODE_FIRST];
            uint32_t  code = *seen ? met + 1 - *seen : 0;
            if (!*seen) {
                order[met] = node->child[c] - NODE_FIRST;
                *seen      = ++met;
            }
            for (; code > 0x7f; code >>= 7) out[STREAM_REFERENCES].data[out[STREAM_REFERENCES].size++] = (uint8_t)(code | 0x80);
            out[STREAM_REFERENCES].data[out[STREAM_REFERENCES].size++] = (uint8_t)code;
        }
        out[STREAM_STATES].data[out[STREAM_STATES].size++] = (uint8_t)states;
    }
done:
    free(order);
    free(number);
    return ok;
}

static vxs_result write_file(const builder *b, uint32_t levels, subtree root, vxs_bytes *file)
{
    stream         streams[STREAM_COUNT] = {{NULL, 0}};
    intervals_head head                  = {.levels = levels, .root_depth = root.low};
    size_t         bound                 = sizeof head;
    int            ok                    = root.ref == UNIFORM || write_streams(b, root.ref, streams);
    for (int n = 0; n < STREAM_COUNT; n++) bound += ZSTD_compressBound(streams[n].size);
    *file           = (vxs_bytes){.data = ok ? malloc(bound) : NULL, .size_bytes = sizeof head, .capacity_bytes = bound};
    ok              = file->data != NULL;
    head.node_count = (uint32_t)streams[STREAM_STATES].size;
    for (int n = 0; n < STREAM_COUNT && ok; n++) {
        size_t stored = ZSTD_compress(file->data + file->size_bytes, bound - file->size_bytes, streams[n].data, streams[n].size,
                                      RIVAL_ZSTD_LEVEL);
        ok            = !ZSTD_isError(stored);
        head.stored_bytes[n] = (uint32_t)stored;
        head.bytes[n]        = (uint32_t)streams[n].size;
        if (ok) file->size_bytes += stored;
    }
    if (ok) memcpy(file->data, &head, sizeof head);
    for (int n = 0; n < STREAM_COUNT; n++) free(streams[n].data);
    return ok ? VXS_OK : VXS_E_MEMORY;
}

static vxs_result intervals_build(rival_maps *maps, const void *options, vxs_bytes *file)
{
    (void)options;
    depth_maps_reduce(&maps->maps, 1);
    column_square columns = depth_maps_square(&maps->maps);
    builder       b       = {.columns = &columns};
    subtree       root    = build_square(&b, maps->levels - 3, 0, 0);
    vxs_result    r       = b.failed ? VXS_E_MEMORY : write_file(&b, maps->levels, root, file);
    free(b.nodes);
    ref_table_free(&b.table);
    return r;
}

/* opening ---------------------------------------------------------------------------------------------------------------------- */

typedef struct intervals {
    uint32_t *words;
    uint32_t  word_count; /* 0: one depth all over */
    uint32_t  levels;
    int32_t   root_depth;
} intervals;

static uint32_t steps_of(uint32_t states)
{
    return vxs_popcount(states & 0x55u);
}

static uint32_t node_words(uint32_t states)
{
    return 1 + (steps_of(states) > 1) + vxs_popcount(states & 0xaau);
}

static uint32_t take_step(const uint8_t **at)
{
    uint32_t step = (uint32_t)((*at)[0] | (*at)[1] << 8);
    *at += 2;
    return step;
}

static uint32_t take_reference(const uint8_t **at)
{
    uint32_t code = 0;
    for (int shift = 0;; shift += 7) {
        uint8_t byte = *(*at)++;
        code |= (uint32_t)(byte & 0x7f) << shift;
        if (byte < 0x80) return code;
    }
}

/* The bytes are our own: what is checked is that there is memory. start: [count + 1] where each node's words start. */
static void read_nodes(intervals *v, const stream s[STREAM_COUNT], const uint32_t *start)
{
    const uint8_t *reference = s[STREAM_REFERENCES].data, *step = s[STREAM_STEPS].data;
    uint32_t       met = 1;
    for (size_t n = 0; n < s[STREAM_STATES].size; n++) {
        uint32_t  states = s[STREAM_STATES].data[n], steps = steps_of(states);
        uint32_t *at = v->words + start[n];
        *at++        = states | (steps > 0 ? take_step(&step) << 16 : 0);
        if (steps > 1) {
            *at = take_step(&step);
            *at++ |= steps > 2 ? take_step(&step) << 16 : 0;
        }
        for (uint32_t c = vxs_popcount(states & 0xaau); c; c--) {
            uint32_t code = take_reference(&reference);
            *at++         = start[code ? met - code : met];
            met += !code;
        }
    }
}

static vxs_result intervals_open(const rival_maps *maps, const void *options, const vxs_bytes *file, rival_asset *asset)
{
    stream         s[STREAM_COUNT] = {{NULL, 0}};
    const uint8_t *at              = file->data + sizeof(intervals_head);
    intervals     *v               = calloc(1, sizeof *v);
    uint32_t      *start           = NULL;
    intervals_head head;
    int            ok = v != NULL;
    (void)maps;
    (void)options;
    memcpy(&head, file->data, sizeof head);
    for (int n = 0; n < STREAM_COUNT && ok; n++) {
        s[n] = (stream){malloc(head.bytes[n] + 1), head.bytes[n]};
        ok   = s[n].data && ZSTD_decompress(s[n].data, s[n].size, at, head.stored_bytes[n]) == s[n].size;
        at += head.stored_bytes[n];
    }
    start = malloc(((size_t)head.node_count + 1) * sizeof *start);
    ok    = ok && start;
    if (ok) {
        start[0] = 0;
        for (uint32_t n = 0; n < head.node_count; n++) start[n + 1] = start[n] + node_words(s[STREAM_STATES].data[n]);
        *v       = (intervals){.word_count = start[head.node_count], .levels = head.levels, .root_depth = head.root_depth};
        v->words = malloc((size_t)v->word_count * sizeof *v->words + 1);
        ok       = v->words != NULL;
    }
    if (ok) read_nodes(v, s, start);
    for (int n = 0; n < STREAM_COUNT; n++) free(s[n].data);
    free(start);
    if (!ok) free(v);
    if (ok) *asset = (rival_asset){v, (uint64_t)v->word_count * sizeof *v->words};
    return ok ? VXS_OK : VXS_E_MEMORY;
}

static void intervals_close(void *state)
{
    intervals *v = state;
    free(v->words);
    free(v);
}

/* lookups ---------------------------------------------------------------------------------------------------------------------- */

/* Where a walk has come to. */
typedef struct place {
    uint32_t node;
    int32_t  depth;
    int      is_node; /* 0: the depth holds all over the square */
} place;

static inline place child_place(const uint32_t *words, place at, uint32_t c)
{
    uint32_t states = words[at.node], before = (1u << 2 * c) - 1, state = states >> 2 * c & 3;
    if (state & 1) {
        uint32_t nth  = steps_of(states & before);
        uint32_t step = nth ? words[at.node + 1] >> 16 * (nth - 1) : states >> 16;
        at.depth += (int16_t)step;
    }
    at.is_node = state >> 1;
    if (at.is_node) at.node = words[at.node + 1 + (steps_of(states) > 1) + vxs_popcount(states & before & 0xaau)];
    return at;
}

static place root_place(const intervals *v)
{
    return (place){0, v->root_depth, v->word_count != 0};
}

static uint32_t is_dark(const intervals *v, voxel_at voxel)
{
    place at = root_place(v);
    for (uint32_t bit = v->levels; at.is_node;) {
        bit--;
        at = child_place(v->words, at, ((uint32_t)voxel.i >> bit & 1) | ((uint32_t)voxel.j >> bit & 1) << 1);
    }
    return voxel.k >= at.depth;
}

/* Taps of the box in the square of `side` texels at (x, y) that are in shadow at depth k: the quadtree is walked once for all of
 * them. */
static uint32_t dark_taps(const uint32_t *words, place at, int32_t x, int32_t y, int32_t side, tap_box box, int32_t k)
{
    int32_t x0 = most(x, box.x0), x1 = least(x + side, box.x1), y0 = most(y, box.y0), y1 = least(y + side, box.y1), half = side / 2;
    if (x0 >= x1 || y0 >= y1) return 0;
    if (!at.is_node) return k >= at.depth ? (uint32_t)((x1 - x0) * (y1 - y0)) : 0;
    uint32_t dark = 0;
    for (uint32_t c = 0; c < 4; c++) {
        int32_t cx = x + (c & 1 ? half : 0), cy = y + (c & 2 ? half : 0);
        if (cx >= x1 || cy >= y1 || cx + half <= x0 || cy + half <= y0) continue;
        dark += dark_taps(words, child_place(words, at, c), cx, cy, half, box, k);
    }
    return dark;
}

static void intervals_count_dark(const void *state, const voxel_at *at, size_t count, vxs_filter filter, uint32_t *dark)
{
    const intervals *v    = state;
    int32_t          side = 1 << v->levels;
    for (size_t n = 0; n < count; n++)
        dark[n] = filter.width_px == 1
                      ? is_dark(v, at[n])
                      : dark_taps(v->words, root_place(v), 0, 0, side, tap_box_at(at[n], filter.width_px, side), at[n].k);
}

const rival interval_rivals[] = {
    {"merged intervals", "multiresolution hierarchy of depth intervals, equal subtrees merged up to a depth offset", NULL, 0,
     intervals_build, intervals_open, intervals_count_dark, intervals_close},
    {.name = NULL},
};
