/* How fast lookups are, beside rays.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COMPARE_TIME_H
#define COMPARE_TIME_H

#include "baker/truth/compare_points.h"

/* Fill a result's time, and that of its filters. Only points that the map reaches count: others cost nothing, and would flatter.
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result compare_measure_time(const comparison *c, compare_result *out, message *m);

#endif
