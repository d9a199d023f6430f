/* See lookup_many_scalar.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#define VXS_SCALAR

#include "lookup_many_scalar.h"

#define vxs_lookup_batch      scalar_lookup_batch
#define vxs_cached_taps       scalar_cached_taps
#define vxs_cached_part       scalar_cached_part
#define vxs_tap_cache_init    scalar_tap_cache_init
#define vxs_tap_cache_serves  scalar_tap_cache_serves
#define vxs_tile_depths       scalar_tile_depths
#define vxs_depth_square_at   scalar_depth_square_at
#define vxs_dag_first_shadows scalar_dag_first_shadows
#define vxs_dag_path_init     scalar_dag_path_init
#define vxs_dag_path_shadow   scalar_dag_path_shadow
#define vxs_dag_path_count    scalar_dag_path_count
#define vxs_dag_path_weight   scalar_dag_path_weight
#include "runtime/taps_many.c"
#include "runtime/tile_depths.c"

#include "runtime/lookup_many.c"
