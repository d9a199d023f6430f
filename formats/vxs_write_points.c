/* Writing points of casters; formats/vxs.md section 16.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>

#include "vxs_bytes.h"
#include "vxs_points.h"
#include "vxs_writer.h"

/* Low corner of the bounding box of the points, and metres per unit.   Returns 0 if a place is NaN or infinite. */
static int find_box(const vxs_points_view *view, double low[3], double *step)
{
    double high[3], size = 0;
    for (int i = 0; i < 3; i++) low[i] = high[i] = view->places_ws[i];
    for (size_t n = 0; n < 3 * (size_t)view->count; n++) {
        double at = view->places_ws[n];
        if (!isfinite(at)) return 0;
        low[n % 3]  = fmin(low[n % 3], at);
        high[n % 3] = fmax(high[n % 3], at);
    }
    for (int i = 0; i < 3; i++) size = fmax(size, high[i] - low[i]);
    *step = fmax(view->step_metres, size / 65535);
    return isfinite(*step);
}

static int by_size(const void *a, const void *b)
{
    uint64_t p = *(const uint64_t *)a, q = *(const uint64_t *)b;
    return (p > q) - (p < q);
}

static void put_codes(const vxs_points_view *view, const double low[3], double step, uint64_t *codes)
{
    for (uint32_t n = 0; n < view->count; n++) {
        codes[n] = 0;
        for (uint32_t i = 0; i < 3; i++) {
            double unit = floor((view->places_ws[3 * (size_t)n + i] - low[i]) / step + 0.5);
            codes[n] |= vxs_point_code((uint32_t)fmin(fmax(unit, 0), 65535)) << i;
        }
    }
    qsort(codes, view->count, sizeof *codes, by_size);
}

static void encode(const vxs_points_view *view, const double low[3], double step, const uint64_t *codes, uint8_t *to)
{
    uint8_t *planes = to + VXS_POINTS_PREFIX_BYTES;
    vxs_store_f64(to + VXS_POINTS_SQUARE_METRES, view->square_metres);
    vxs_store_f64(to + VXS_POINTS_STEP_METRES, step);
    for (int i = 0; i < 3; i++) vxs_store_f64(to + VXS_POINTS_LOW + 8 * i, low[i]);
    vxs_store32(to + VXS_POINTS_POINT_COUNT, view->count);
    for (uint32_t n = 0; n < view->count; n++) {
        uint64_t less = codes[n] - (n ? codes[n - 1] : 0);
        for (uint32_t plane = 0; plane < VXS_POINT_PLANES; plane++)
            planes[(size_t)plane * view->count + n] = (uint8_t)(less >> 8 * plane);
    }
}

vxs_result vxs_add_points(vxs_sections *s, const vxs_points_view *view)
{
    double low[3], step;
    if (view->count < 1 || view->count > VXS_POINTS_MAX || !(view->step_metres > 0)) return VXS_E_ARGUMENT;
    if (!(view->square_metres > 0) || !isfinite((float)view->square_metres) || !find_box(view, low, &step)) return VXS_E_ARGUMENT;
    vxs_bytes  content = {0};
    uint64_t  *codes   = malloc(view->count * sizeof *codes);
    uint8_t   *to      = vxs_append(&content, VXS_POINTS_PREFIX_BYTES + (size_t)view->count * VXS_POINT_PLANES);
    vxs_result r       = codes && to ? VXS_OK : VXS_E_MEMORY;
    if (r == VXS_OK) {
        put_codes(view, low, step, codes);
        encode(view, low, step, codes, to);
        r = vxs_add_section(s, VXS_KIND_POINTS, VXS_SECTION_OPTIONAL, VXS_NO_LIGHT, 0, &content);
    }
    free(codes);
    free(content.data);
    return r;
}
