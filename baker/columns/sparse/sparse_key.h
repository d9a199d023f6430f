/* Key of a square: a hash of everything that its columns are computed from, and of nothing else in the map.
 *
 * The columns follow from: the triangles in the bins of the square, in order; which neighbouring triangles there share a patch, not
 * the numbers of the patches; the position of the square and of its bins; the scale of depths. So the key stays the same when other
 * parts of the map change. Casters, position and name of the light count only as far as they change these triangles.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SPARSE_KEY_H
#define SPARSE_KEY_H

#include "baker/columns/sparse/leaf.h"
#include "baker/columns/sparse/triangle_bins.h"
#include "baker/scene/fingerprint.h"

/* Fingerprints of the alpha masks of a map. Zero it. */
typedef struct sparse_keys {
    mask_fingerprint *masks; /* of the casters' alpha masks; NULL: not computed yet */
} sparse_keys;

/* Returns VXS_OK or VXS_E_MEMORY. */
vxs_result sparse_key(sparse_keys *k, const leaf_desc *d, const triangle_bins *bins, texel_square at, column_key *out);

void sparse_keys_free(sparse_keys *k);

#endif
