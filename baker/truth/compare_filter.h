/* Filtered lookups against the same filter over rays.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COMPARE_FILTER_H
#define COMPARE_FILTER_H

#include "baker/truth/compare_points.h"

/* Of COMPARE_FILTER_POINTS_MAX points at most, spread over all of the kind.
 * out  [out] written only when VXS_OK is returned.   Returns VXS_OK or VXS_E_MEMORY. */
vxs_result compare_filtered(const comparison *c, compare_kind kind, uint32_t filter_px, compare_error *out, message *m);

#endif
