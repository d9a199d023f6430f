/* Bounds of all parts of a fetched square, level by level: each is the union of its four finer ones.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BOUNDS_PYRAMID_H
#define BOUNDS_PYRAMID_H

#include "baker/columns/columns.h"

/* Fill the coarser levels from level 0.
 * pyramid  [l]: rows of (tiles >> l)^2 squares of 8 << l texels, down to one square; level 0 is given
 * tiles    along a side, a power of two
 * threads  that share the work; the result does not depend on it */
void bounds_pyramid_reduce(column_bounds *const *pyramid, uint32_t tiles, uint32_t threads);

#endif
