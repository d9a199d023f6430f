/* A merger as bytes; see merge.h. All numbers are little-endian.
 *
 *     offset  size  what
 *          0     8  "vxs part"
 *          8     4  version, 2
 *         12     4  levels of the merged DAG, [1, 16]
 *         16     4  maps, 1 or 6
 *         20     4  stacks
 *         24        the merged DAG (dag_file.h)
 *                   stacks: map, level, i, j, runs, each 4 bytes; then its runs: reference and end, each 4 bytes
 *    end - 8     8  XXH64 of all bytes before
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "baker/dag/dag_file.h"
#include "baker/dag/merge.h"

static const char magic[8] = {'v', 'x', 's', ' ', 'p', 'a', 'r', 't'};
enum { PART_VERSION = 2, FIXED_BYTES = 24, STACK_BYTES = 20, RUN_BYTES = 8, TRAILER_BYTES = 8 };

/* saving ---------------------------------------------------------------------------------------------------------------------- */

static int put_stack(vxs_bytes *out, const dag_stack *s, uint32_t map, uint32_t level, uint32_t i, uint32_t j)
{
    int ok = put32(out, map) && put32(out, level) && put32(out, i) && put32(out, j) && put32(out, s->count);
    for (uint32_t n = 0; n < s->count && ok; n++) ok = put32(out, s->runs[n].ref) && put32(out, s->runs[n].end);
    return ok;
}

/* The stacks below square `at`; counted in *count. */
static int put_squares(const dag_merger *g, vxs_bytes *out, uint32_t at, uint32_t map, uint32_t level, uint32_t i, uint32_t j,
                       uint32_t *count)
{
    const merge_square *q  = &g->squares[at];
    int                 ok = 1;
    if (q->stack.runs) {
        ++*count;
        return put_stack(out, &q->stack, map, level, i, j);
    }
    for (uint32_t c = 0; c < 4 && q->parts && ok; c++)
        ok = put_squares(g, out, q->parts + c, map, level - 1, 2 * i + (c & 1), 2 * j + (c >> 1), count);
    return ok;
}

vxs_result dag_merger_save(const dag_merger *g, vxs_bytes *out)
{
    const dag *d      = &g->merged;
    uint32_t   stacks = 0;
    size_t     start  = out->size_bytes;
    if (!g->unify) return VXS_E_ARGUMENT;
    int ok = put_bytes(out, magic, sizeof magic) && put32(out, PART_VERSION) && put32(out, d->level_count) &&
             put32(out, g->map_count) && put32(out, 0) && dag_put(d, out);
    for (uint32_t map = 0; map < g->map_count && ok; map++) ok = put_squares(g, out, map, map, d->level_count - 1, 0, 0, &stacks);
    if (!ok) return VXS_E_MEMORY;
    vxs_store32(out->data + start + FIXED_BYTES - 4, stacks);
    return put64(out, XXH64(out->data + start, out->size_bytes - start, 0)) ? VXS_OK : VXS_E_MEMORY;
}

/* loading --------------------------------------------------------------------------------------------------------------------- */

static vxs_result load_runs(byte_reader *r, const dag *d, uint32_t level, dag_stack *s)
{
    uint32_t slabs = 1u << (d->level_count - 1 - level), end = 0;
    for (uint32_t n = 0; n < s->count; n++) {
        s->runs[n]     = (stack_run){take32(r), 0};
        s->runs[n].end = take32(r);
        if (s->runs[n].ref >= REF_FIRST && s->runs[n].ref - REF_FIRST >= d->level[level].count) return VXS_E_CORRUPT;
        if (s->runs[n].end <= end || s->runs[n].end > slabs) return VXS_E_CORRUPT;
        end = s->runs[n].end;
    }
    return end == slabs ? VXS_OK : VXS_E_CORRUPT;
}

static vxs_result load_stack(byte_reader *r, dag_merger *g)
{
    if (!has(r, 1, STACK_BYTES)) return VXS_E_CORRUPT;
    uint32_t   map = take32(r), level = take32(r), i = take32(r), j = take32(r);
    dag_stack  s = {.count = take32(r)};
    vxs_result result;
    if (level >= g->merged.level_count || !s.count || !has(r, s.count, RUN_BYTES)) return VXS_E_CORRUPT;
    if (!(s.runs = malloc(s.count * sizeof *s.runs))) return VXS_E_MEMORY;
    if ((result = load_runs(r, &g->merged, level, &s)) != VXS_OK) {
        free(s.runs);
        return result;
    }
    result = dag_merger_add_stack(g, map, level, i, j, &s);
    return result == VXS_E_ARGUMENT ? VXS_E_CORRUPT : result;
}

/* What the bytes hold, as it lies there: equal subtrees are not unified yet. */
static vxs_result load_parts(byte_reader *r, dag_merger *stored)
{
    uint32_t   levels = take32(r), maps = take32(r), stacks = take32(r);
    vxs_result result;
    if (levels < 1 || levels > DAG_LEVELS_MAX || (maps != 1 && maps != VXS_CUBE_FACES)) return VXS_E_CORRUPT;
    if ((result = dag_merger_init(stored, 4u << levels, maps, 1)) != VXS_OK) return result;
    if ((result = dag_take(&stored->merged, r)) != VXS_OK) return result;
    for (uint32_t n = 0; n < stacks; n++)
        if ((result = load_stack(r, stored)) != VXS_OK) return result;
    return r->left == 0 ? VXS_OK : VXS_E_CORRUPT;
}

vxs_result dag_merger_load(dag_merger *g, const void *bytes, size_t size_bytes)
{
    dag_merger  stored = {0};
    byte_reader r      = {bytes, size_bytes};
    vxs_result  result;
    memset(g, 0, sizeof *g);
    if (size_bytes < FIXED_BYTES + TRAILER_BYTES) return VXS_E_TRUNCATED;
    if (memcmp(bytes, magic, sizeof magic)) return VXS_E_CORRUPT;
    if (vxs_load32(r.at + sizeof magic) != PART_VERSION) return VXS_E_VERSION;
    if (vxs_load64(r.at + size_bytes - TRAILER_BYTES) != XXH64(bytes, size_bytes - TRAILER_BYTES, 0)) return VXS_E_CORRUPT;
    r = (byte_reader){r.at + sizeof magic + 4, size_bytes - sizeof magic - 4 - TRAILER_BYTES};

    result = load_parts(&r, &stored);
    if (result == VXS_OK) result = dag_merger_init(g, 4u << stored.merged.level_count, stored.map_count, 1);
    if (result == VXS_OK) result = dag_merger_merge(g, &stored);
    if (result != VXS_OK) dag_merger_free(g);
    dag_merger_free(&stored);
    return result;
}
