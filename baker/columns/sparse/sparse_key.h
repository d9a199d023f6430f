/* The key of a square: all that its columns are computed from, and nothing else of the map.
 *
 * Columns follow from the triangles of the bins that the square lies in, in their order; from which neighbours in it are of one patch, not
 * from the patches' numbers; from where the square and its bins are; from the scale of depths. So what is elsewhere may change, and the
 * key stays. Casters of the light, its place and its name are in it only as far as they move these triangles.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SPARSE_KEY_H
#define SPARSE_KEY_H

#include "baker/columns/sparse/leaf.h"
#include "baker/columns/sparse/triangle_bins.h"
#include "baker/scene/fingerprint.h"

/* What is known of the alpha masks of a map. Zero it. */
typedef struct sparse_keys {
    mask_fingerprint *masks; /* of the casters' alpha masks; NULL: nobody has asked yet */
} sparse_keys;

/* Returns VXS_OK or VXS_E_MEMORY. */
vxs_result sparse_key(sparse_keys *k, const leaf_desc *d, const triangle_bins *bins, texel_square at, column_key *out);

void sparse_keys_free(sparse_keys *k);

#endif
