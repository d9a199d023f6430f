/* Keys of squares; see sparse_key.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/sparse_key.h"

#include <stdlib.h>
#include <string.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "baker/base/integer.h"

enum { HASHED_AT_ONCE = 64 };

/* A triangle as it is hashed: 8-byte numbers, so that there is no padding. */
typedef struct hashed_triangle {
    int64_t  x[3], y[3];
    double   zmin, zmax, gx, gy, slack;
    uint64_t bits; /* kind, ends, and whether its patch is that of the triangle before it */
} hashed_triangle;

/* Additional data of a triangle with holes. */
typedef struct hashed_holes {
    mask_fingerprint mask;
    float            uvq[3][3];
    uint32_t         none; /* 0, padding */
} hashed_holes;

static hashed_triangle hashed(const sparse_triangle *t, int same_patch)
{
    hashed_triangle h = {.zmin = t->zmin, .zmax = t->zmax, .gx = t->gx, .gy = t->gy, .slack = t->slack};
    for (int k = 0; k < 3; k++) {
        h.x[k] = t->x[k];
        h.y[k] = t->y[k];
    }
    h.bits = (uint64_t)t->kind | (uint64_t)t->ends << 8 | (uint64_t)(same_patch != 0) << 16;
    return h;
}

static void hash_holes(XXH3_state_t *state, const sparse_keys *keys, const sparse_triangles *s, uint32_t id)
{
    size_t       n = id - s->holed_first;
    hashed_holes h = {.mask = keys->masks[s->mask_of[n]]};
    for (int k = 0; k < 3; k++) {
        h.uvq[k][0] = s->uvq[n][k].u;
        h.uvq[k][1] = s->uvq[n][k].v;
        h.uvq[k][2] = s->uvq[n][k].q;
    }
    XXH3_128bits_update(state, &h, sizeof h);
}

/* Hash the triangles of a cell in order. */
static void hash_cell(XXH3_state_t *state, const sparse_keys *keys, const sparse_triangles *s, const uint32_t *ids, size_t count)
{
    hashed_triangle some[HASHED_AT_ONCE];
    size_t          held    = 0;
    uint64_t        of_cell = count;
    XXH3_128bits_update(state, &of_cell, sizeof of_cell);
    for (size_t n = 0; n < count; n++) {
        some[held++] = hashed(&s->all[ids[n]], n && s->all[ids[n]].patch == s->all[ids[n - 1]].patch);
        if (held < HASHED_AT_ONCE && n + 1 < count) continue;
        XXH3_128bits_update(state, some, held * sizeof *some);
        held = 0;
    }
    for (size_t n = 0; n < count; n++)
        if (ids[n] >= s->holed_first) hash_holes(state, keys, s, ids[n]);
}

static vxs_result know_masks(sparse_keys *k, const casters *c)
{
    if (k->masks) return VXS_OK;
    if (!(k->masks = malloc((c->alpha_mask_count + 1) * sizeof *k->masks))) return VXS_E_MEMORY;
    for (size_t n = 0; n < c->alpha_mask_count; n++)
        k->masks[n] = alpha_mask_fingerprint(&c->alpha_masks[n], &c->images[c->alpha_masks[n].image]);
    return VXS_OK;
}

vxs_result sparse_key(sparse_keys *k, const leaf_desc *d, const triangle_bins *bins, texel_square at, column_key *out)
{
    vxs_result   r = know_masks(k, d->triangles->casters);
    XXH3_state_t state;
    if (r != VXS_OK) return r;
    const uint64_t place[] = {
        at.u, at.v, at.side, bins->cell_px, d->scale.depth_vx, (uint64_t)(d->nearest_back != 0), (uint64_t)(d->every_texel != 0)};
    uint32_t cells = max_u32(at.side / bins->cell_px, 1), i = at.u / bins->cell_px, j = at.v / bins->cell_px;
    XXH3_128bits_reset(&state);
    XXH3_128bits_update(&state, place, sizeof place);
    const double measures[] = {d->scale.voxel_log, d->dont_care.thickness, d->dont_care.behind != 0};
    XXH3_128bits_update(&state, measures, sizeof measures);
    for (uint32_t cell = 0; cell < cells * cells; cell++) {
        const size_t *first = bins->first + (size_t)(j + cell / cells) * bins->cells + i + cell % cells;
        hash_cell(&state, k, d->triangles, bins->ids + first[0], first[1] - first[0]);
    }
    XXH128_hash_t hash = XXH3_128bits_digest(&state);
    *out               = (column_key){hash.low64, hash.high64};
    return VXS_OK;
}

void sparse_keys_free(sparse_keys *k)
{
    free(k->masks);
    *k = (sparse_keys){0};
}
