/* Lookups of many points without vectors, as compilers that have none make them: the same sources once more.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LOOKUP_MANY_SCALAR_H
#define LOOKUP_MANY_SCALAR_H

#include "runtime/vxs_query.h"

vxs_result scalar_lookup_batch(const vxs_baked_light *lights, uint32_t light_count, const vxs_batch *batch);

#endif
