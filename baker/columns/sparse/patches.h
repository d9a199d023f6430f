/* Patches: adjacent triangles of a map that face the same way.
 *
 * Away from the border of a patch, the number of its triangles that cover a point is constant: where one triangle ends, the next
 * begins. So if no border of the patch crosses a square of texels, the patch covers each texel as often as any other. Thousands of
 * small triangles then bound the square as a single large triangle does.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PATCHES_H
#define PATCHES_H

#include "baker/light/projection.h"

/* Find the patches of a projection.
 * patch_of  [out] [p->triangle_count] index of the first triangle of the patch. Triangles with holes, and those with facing 0,
 *           are patches alone
 * ends      [out] [p->triangle_count] bit k: the edge from corner k to the next is on the border of the patch
 * facing    [p->triangle_count] 1 and -1: the two sides, 0: seen edge-on
 * Returns VXS_OK or VXS_E_MEMORY. The result does not depend on the number of threads. */
vxs_result patches_find(uint32_t *patch_of, uint8_t *ends, const int8_t *facing, const projection *p, uint32_t threads);

#endif
