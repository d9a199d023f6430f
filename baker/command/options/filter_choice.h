/* Filters from a command line: boxes of whole texels by --filter, smooth ones by --smooth.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FILTER_CHOICE_H
#define FILTER_CHOICE_H

#include "baker/command/options/options.h"
#include "formats/vxs_format.h"

/* The maximum number of different filters besides single taps: boxes of odd widths, up to VXS_FILTER_MAX, and smooth ones of any
 * width. */
enum { FILTERS_MAX = VXS_FILTER_MAX / 2 + VXS_FILTER_MAX };

/* The filter of a command that takes one filter. */
typedef struct filter_choice {
    uint32_t box_px, smooth_px; /* widths, 1 to VXS_FILTER_MAX; box_px holds the default */
    int      box_given, smooth_given;
} filter_choice;

/* Option rows.   choice  a filter_choice;   help  of --filter */
/* clang-format off */
#define FILTER_ROWS(choice, help)                                                                                                  \
    {"--filter", OPTION_U32, &(choice).box_px, 1, VXS_FILTER_MAX, NULL, "K", help, &(choice).box_given},                           \
    {"--smooth", OPTION_U32, &(choice).smooth_px, 1, VXS_FILTER_MAX, NULL, "K",                                                    \
     "a smooth K x K filter in its place, about the point itself, K even or odd, 1 to 17 texels", &(choice).smooth_given}
/* clang-format on */

/* Returns VXS_OK, or VXS_E_ARGUMENT when both are given, or for a box of even width. */
vxs_result filter_check(const filter_choice *c, message *m);

/* The filter as vxs_lookup takes it. */
int filter_px_of(const filter_choice *c);

static inline int filter_given(const filter_choice *c)
{
    return c->box_given || c->smooth_given;
}

/* Collect the filters of a command that takes several: the boxes, then the smooth filters. Boxes of width 1, single taps, are
 * skipped: the callers always measure them.
 * boxes, smooth  each without duplicates, from 1 to VXS_FILTER_MAX; smooth may be NULL
 * filters_px     [FILTERS_MAX] each in the order given;   count  [out]
 * Returns VXS_OK, or VXS_E_ARGUMENT for a box of even width. */
vxs_result filters_take(const number_list *boxes, const number_list *smooth, uint32_t *filters_px, uint32_t *count, message *m);

/* "9 x 9", "9 x 9 smooth".   filter_px  as for vxs_lookup */
const char *filter_text(char text[32], uint32_t filter_px);

#endif
