/* Writing what lies beside shadows: baked smoke and points of casters; formats/vxs.md sections 15 and 16.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "vxs_bytes.h"
#include "vxs_writer.h"

/* smoke ------------------------------------------------------------------------------------------------------------------------- */

enum { TILE_TEXELS = 64, NODE_BYTES = 4 };

/* State of writing smoke, tile by tile. */
typedef struct smoke_writer {
    const vxs_smoke_view *view;
    size_t                tiles; /* of all maps */
    uint32_t              tile_count, node_count;
    uint8_t              *mask, *counts, *nodes;
} smoke_writer;

static const uint8_t *counts_of(const smoke_writer *w, size_t tile)
{
    return w->view->counts + tile * TILE_TEXELS;
}

static int has_curve(const uint8_t counts[TILE_TEXELS])
{
    static const uint8_t none[TILE_TEXELS] = {0};
    return memcmp(counts, none, sizeof none) != 0;
}

static void put_tiles(smoke_writer *w)
{
    const uint32_t *nodes = w->view->nodes;
    for (size_t tile = 0; tile < w->tiles; tile++) {
        const uint8_t *counts = counts_of(w, tile);
        if (!has_curve(counts)) continue;
        w->mask[tile >> 3] |= (uint8_t)(1u << (tile & 7));
        memcpy(w->counts, counts, TILE_TEXELS);
        w->counts += TILE_TEXELS;
        for (int n = 0; n < TILE_TEXELS; nodes += counts[n++]) {
            /* Write nodes as differences from the previous one, with a plane for each byte. */
            uint32_t count = counts[n];
            uint32_t depth = 0, left = 0xffff;
            for (uint32_t k = 0; k < count; k++) {
                uint32_t number = ((nodes[k] & 0xffff) - depth) | (left - (nodes[k] >> 16)) << 16;
                for (uint32_t plane = 0; plane < NODE_BYTES; plane++)
                    w->nodes[(size_t)plane * w->node_count] = (uint8_t)(number >> 8 * plane);
                w->nodes++;
                depth = nodes[k] & 0xffff;
                left  = nodes[k] >> 16;
            }
        }
    }
}

static vxs_result encode_smoke(smoke_writer *w, vxs_bytes *content)
{
    size_t   mask = (w->tiles + 7) / 8, counts = (size_t)w->tile_count * TILE_TEXELS;
    size_t   size = VXS_SMOKE_PREFIX_BYTES + mask + counts + (size_t)w->node_count * NODE_BYTES;
    uint8_t *head = vxs_append(content, size);
    uint32_t first, step;
    if (!head) return VXS_E_MEMORY;
    memset(head, 0, size);
    memcpy(&first, &w->view->first_metres, sizeof first);
    memcpy(&step, &w->view->step_metres, sizeof step);
    vxs_store32(head + VXS_SMOKE_LEVELS, w->view->levels);
    vxs_store32(head + VXS_SMOKE_FIRST_METRES, first);
    vxs_store32(head + VXS_SMOKE_STEP_METRES, step);
    vxs_store32(head + VXS_SMOKE_NODE_COUNT, w->node_count);
    w->mask   = head + VXS_SMOKE_PREFIX_BYTES;
    w->counts = w->mask + mask;
    w->nodes  = w->counts + counts;
    put_tiles(w);
    return VXS_OK;
}

vxs_result vxs_add_smoke(vxs_sections *s, const vxs_smoke_view *smoke, const vxs_light *light, uint32_t number)
{
    vxs_bytes content = {0};
    if (!(smoke->levels >= VXS_LEVELS_MIN && smoke->levels <= VXS_SMOKE_LEVELS_MAX && smoke->levels <= light->levels &&
          smoke->step_metres > 0 && isfinite(smoke->first_metres) && isfinite(smoke->first_metres + 65535 * smoke->step_metres)))
        return VXS_E_ARGUMENT;
    smoke_writer w = {.view = smoke, .tiles = (size_t)vxs_map_count(light) << (2 * (smoke->levels - 3))};

    /* count tiles and nodes */
    uint64_t at = 0;
    for (size_t tile = 0; tile < w.tiles; tile++) {
        const uint8_t *counts = counts_of(&w, tile);
        w.tile_count += (uint32_t)has_curve(counts);
        for (int n = 0; n < TILE_TEXELS; at += counts[n++]) {
            const uint32_t *nodes = w.view->nodes + at;
            if (counts[n] > VXS_SMOKE_NODES_MAX || at > INT32_MAX) return VXS_E_ARGUMENT;
            for (uint32_t k = 1; k < counts[n]; k++) /* depths grow, and transmittance falls */
                if ((nodes[k] & 0xffff) < (nodes[k - 1] & 0xffff) || nodes[k] >> 16 > nodes[k - 1] >> 16) return VXS_E_ARGUMENT;
        }
    }
    w.node_count = (uint32_t)at;

    vxs_result r = encode_smoke(&w, &content);
    if (r == VXS_OK) r = vxs_add_section(s, VXS_KIND_SMOKE, VXS_SECTION_OPTIONAL, number, 0, &content);
    free(content.data);
    return r;
}

/* points ------------------------------------------------------------------------------------------------------------------------ */

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
            double   unit  = floor((view->places_ws[3 * (size_t)n + i] - low[i]) / step + 0.5);
            uint64_t whole = (uint64_t)fmin(fmax(unit, 0), 65535); /* its bits become bits i, i + 3, i + 6, ... */
            for (uint32_t bit = 0; bit < 16; bit++) codes[n] |= (whole >> bit & 1) << (3 * bit + i);
        }
    }
    qsort(codes, view->count, sizeof *codes, by_size);
}

vxs_result vxs_add_points(vxs_sections *s, const vxs_points_view *view)
{
    double low[3], step;
    if (view->count < 1 || view->count > VXS_POINTS_MAX || !(view->step_metres > 0)) return VXS_E_ARGUMENT;
    if (!(view->square_metres > 0) || !isfinite((float)view->square_metres) || !find_box(view, low, &step)) return VXS_E_ARGUMENT;
    vxs_bytes  content = {0};
    uint64_t  *codes   = malloc(view->count * sizeof *codes);
    uint8_t   *to      = vxs_append(&content, VXS_POINTS_PREFIX_BYTES + (size_t)view->count * VXS_POINT_CODE_BYTES);
    vxs_result r       = codes && to ? VXS_OK : VXS_E_MEMORY;
    if (r == VXS_OK) {
        put_codes(view, low, step, codes);
        vxs_store_f64(to + VXS_POINTS_SQUARE_METRES, view->square_metres);
        vxs_store_f64(to + VXS_POINTS_STEP_METRES, step);
        for (int i = 0; i < 3; i++) vxs_store_f64(to + VXS_POINTS_LOW + 8 * i, low[i]);
        vxs_store32(to + VXS_POINTS_POINT_COUNT, view->count);
        for (uint32_t n = 0; n < view->count; n++) {
            uint64_t less = codes[n] - (n ? codes[n - 1] : 0);
            for (size_t plane = 0; plane < VXS_POINT_CODE_BYTES; plane++)
                to[VXS_POINTS_PREFIX_BYTES + plane * view->count + n] = (uint8_t)(less >> 8 * plane);
        }
        r = vxs_add_section(s, VXS_KIND_POINTS, VXS_SECTION_OPTIONAL, VXS_NO_LIGHT, 0, &content);
    }
    free(codes);
    free(content.data);
    return r;
}
