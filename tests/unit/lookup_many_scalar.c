/* See lookup_many_scalar.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#define VXS_SCALAR

#include "lookup_many_scalar.h"

#define vxs_lookup_batch     scalar_lookup_batch
#define vxs_cached_taps      scalar_cached_taps
#define vxs_cached_part      scalar_cached_part
#define vxs_tap_cache_init   scalar_tap_cache_init
#define vxs_tap_cache_serves scalar_tap_cache_serves
#define vxs_tile_depths      scalar_tile_depths
#define vxs_depth_square_at  scalar_depth_square_at
#include "runtime/block_depths.c"
#include "runtime/tap_cache.c"

#include "runtime/lookup_many.c"
