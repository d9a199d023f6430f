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

int filter_px_of(const filter_choice *c)
{
    return (int)(c->smooth_given ? VXS_SMOOTH + c->smooth_px : c->box_px);
}

vxs_result filters_take(const number_list *boxes, const number_list *smooth, uint32_t *filters_px, uint32_t *count, run_context *m)
{
    vxs_result r = VXS_OK;
    *count       = 0;
    for (size_t n = 0; n < boxes->count && r == VXS_OK; n++) {
        r = box_check(boxes->items[n], m);
        if (r == VXS_OK && boxes->items[n] > 1) filters_px[(*count)++] = boxes->items[n];
    }
    for (size_t n = 0; smooth && n < smooth->count; n++) filters_px[(*count)++] = VXS_SMOOTH + smooth->items[n];
    return r;
}

const char *filter_text(char text[32], uint32_t filter_px)
{
    uint32_t width = filter_px % VXS_SMOOTH;
    snprintf(text, 32, "%u x %u%s", width, width, filter_px < VXS_SMOOTH ? "" : " smooth");
    return text;
}
