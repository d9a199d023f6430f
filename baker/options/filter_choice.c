/* Widths of filters from a command line; see filter_choice.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/options/filter_choice.h"

vxs_result filter_check(uint32_t filter_px, message *m)
{
    if (filter_px % 2) return VXS_OK;
    return fail(m, VXS_E_ARGUMENT, "--filter %u: expected an odd number from 1 to %d", filter_px, VXS_FILTER_MAX);
}

vxs_result filters_take(const number_list *given, uint32_t *filters_px, uint32_t *count, message *m)
{
    vxs_result r = VXS_OK;
    *count       = 0;
    for (size_t n = 0; n < given->count && r == VXS_OK; n++) {
        r = filter_check(given->items[n], m);
        if (r == VXS_OK && given->items[n] > 1) filters_px[(*count)++] = given->items[n];
    }
    return r;
}
