/* Filters from a command line; see options.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/options/options.h"

#include <stdio.h>

static vxs_result box_check(uint32_t width_px, run_context *m)
{
    if (width_px % 2) return VXS_OK;
    return fail(m, VXS_E_ARGUMENT, "--filter %u: expected an odd number from 1 to %d; --smooth may be even", width_px,
                VXS_FILTER_MAX);
}

vxs_result filter_check(const filter_choice *c, run_context *m)
{
    if (c->box_given && c->smooth_given)
        return fail(m, VXS_E_ARGUMENT, "--filter and --smooth exclude each other: expected one filter");
    return box_check(c->box_px, m);
}

vxs_filter filter_of(const filter_choice *c)
{
    return c->smooth_given ? vxs_smooth((int32_t)c->smooth_px) : vxs_box((int32_t)c->box_px);
}

vxs_result filters_take(const number_list *boxes, const number_list *smooth, vxs_filter *filters, uint32_t *count, run_context *m)
{
    vxs_result r = VXS_OK;
    *count       = 0;
    for (size_t n = 0; n < boxes->count && r == VXS_OK; n++) {
        r = box_check(boxes->items[n], m);
        if (r == VXS_OK && boxes->items[n] > 1) filters[(*count)++] = vxs_box((int32_t)boxes->items[n]);
    }
    for (size_t n = 0; smooth && n < smooth->count; n++) filters[(*count)++] = vxs_smooth((int32_t)smooth->items[n]);
    return r;
}

const char *filter_text(char text[32], vxs_filter filter)
{
    snprintf(text, 32, "%d x %d%s", filter.width_px, filter.width_px, filter.is_smooth ? " smooth" : "");
    return text;
}
