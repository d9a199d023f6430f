/* Grouping; see group.h.
 *
 *     items ---by range of keys, chunk by chunk---> ranges ---by key---> members
 *
 * Chunks of items are counted and placed independently, then ranges of keys. Each range fits a cache.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/group.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/integer.h"
#include "baker/base/pages.h"
#include "baker/base/parallel.h"

enum { CHUNKS_MAX = 64, CHUNK_LEAST = 4096, RANGES_MAX = 256 };

typedef struct grouper {
    uint32_t       *first, *members;
    const uint32_t *key_of;
    size_t          count, key_count;
    size_t          chunks, ranges;
    uint32_t        shift;  /* a range has 1 << shift keys */
    uint32_t       *ranged; /* [count] items grouped by range */
    uint32_t        range_first[RANGES_MAX + 1];
    uint32_t        place[CHUNKS_MAX][RANGES_MAX]; /* number of items of a chunk in a range; later, where they go */
} grouper;

static void count_chunks(void *user, size_t begin, size_t end, uint32_t worker)
{
    grouper *g = user;
    (void)worker;
    for (size_t chunk = begin; chunk < end; chunk++)
        for (size_t n = g->count * chunk / g->chunks; n < g->count * (chunk + 1) / g->chunks; n++)
            g->place[chunk][g->key_of[n] >> g->shift]++;
}

static void counts_to_places(grouper *g)
{
    uint32_t place = 0;
    for (size_t range = 0; range < g->ranges; range++) {
        g->range_first[range] = place;
        for (size_t chunk = 0; chunk < g->chunks; chunk++) {
            uint32_t count         = g->place[chunk][range];
            g->place[chunk][range] = place;
            place += count;
        }
    }
    g->range_first[g->ranges] = place;
}

static void place_chunks(void *user, size_t begin, size_t end, uint32_t worker)
{
    grouper *g = user;
    (void)worker;
    for (size_t chunk = begin; chunk < end; chunk++)
        for (size_t n = g->count * chunk / g->chunks; n < g->count * (chunk + 1) / g->chunks; n++)
            g->ranged[g->place[chunk][g->key_of[n] >> g->shift]++] = (uint32_t)n;
}

/* Place the items of each range. Afterwards first[key] is where the next key begins. */
static void place_ranges(void *user, size_t begin, size_t end, uint32_t worker)
{
    grouper *g = user;
    (void)worker;
    for (size_t range = begin; range < end; range++) {
        size_t   low = range << g->shift, high = (range + 1) << g->shift;
        uint32_t place = g->range_first[range];
        for (size_t key = low; key < high && key < g->key_count; key++) g->first[key] = 0;
        for (uint32_t i = place; i < g->range_first[range + 1]; i++) g->first[g->key_of[g->ranged[i]]]++;
        for (size_t key = low; key < high && key < g->key_count; key++) {
            uint32_t count = g->first[key];
            g->first[key]  = place;
            place += count;
        }
        for (uint32_t i = g->range_first[range]; i < g->range_first[range + 1]; i++)
            g->members[g->first[g->key_of[g->ranged[i]]]++] = g->ranged[i];
    }
}

vxs_result group_by_key(uint32_t *first, uint32_t *members, const uint32_t *key_of, size_t count, size_t key_count,
                        uint32_t threads)
{
    grouper  *g      = malloc(sizeof *g);
    uint32_t *ranged = pages_alloc((count + 1) * sizeof *ranged);
    int       ok     = g && ranged;
    if (ok) {
        *g = (grouper){
            .first = first, .members = members, .key_of = key_of, .count = count, .key_count = key_count, .ranged = ranged};
        while (key_count > (size_t)RANGES_MAX << g->shift) g->shift++;
        g->chunks = 1 + count / CHUNK_LEAST < CHUNKS_MAX ? 1 + count / CHUNK_LEAST : CHUNKS_MAX;
        g->ranges = key_count ? ((key_count - 1) >> g->shift) + 1 : 0;
        parallel_for(threads, g->chunks, 1, count_chunks, g);
        counts_to_places(g);
        parallel_for(threads, g->chunks, 1, place_chunks, g);
        parallel_for(threads, g->ranges, 1, place_ranges, g);
        memmove(first + 1, first, key_count * sizeof *first);
        first[0] = 0;
    }
    free(ranged);
    free(g);
    return ok ? VXS_OK : VXS_E_MEMORY;
}
