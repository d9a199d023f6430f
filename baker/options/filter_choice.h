/* Widths of filters from a command line.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FILTER_CHOICE_H
#define FILTER_CHOICE_H

#include "baker/options/options.h"
#include "formats/vxs_format.h"

/* The most different widths above 1 that there are: odd, to VXS_FILTER_MAX. */
enum { FILTER_WIDTHS_MAX = VXS_FILTER_MAX / 2 };

/* Returns VXS_OK, or VXS_E_ARGUMENT for an even width. filter_px: from 1 to VXS_FILTER_MAX. */
vxs_result filter_check(uint32_t filter_px, message *m);

/* The widths above 1: single taps need no mention.
 * given       none twice, from 1 to VXS_FILTER_MAX
 * filters_px  [FILTER_WIDTHS_MAX] in the order given;   count  [out]
 * Returns VXS_OK or VXS_E_ARGUMENT. */
vxs_result filters_take(const number_list *given, uint32_t *filters_px, uint32_t *count, message *m);

#endif
