/* Patches: triangles of a map that lie side by side and face the same way.
 *
 * Away from the ends of a patch every point of the map is covered by as many of its triangles as its neighbours are: where one ends, the
 * next begins. So a square of texels in which no end of the patch lies is covered as often everywhere as in one of its texels, and what is
 * made of thousands of small triangles bounds a square as a single large one does.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PATCHES_H
#define PATCHES_H

#include "baker/light/projection.h"

/* Find the patches of a projection.
 * patch_of  [out] [p->triangle_count] the number of its first triangle; triangles with holes, and those that face no way, are alone
 * ends      [out] [p->triangle_count] bit k: the edge from corner k to the next is an end of the patch
 * facing    [p->triangle_count] 1 and -1 the two ways, 0: seen from its edge
 * Returns VXS_OK or VXS_E_MEMORY.  The same at any thread count. */
vxs_result patches_find(uint32_t *patch_of, uint8_t *ends, const int8_t *facing, const projection *p, uint32_t threads);

#endif
