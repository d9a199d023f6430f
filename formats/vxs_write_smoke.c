/* Writing baked smoke; formats/vxs.md section 15.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "vxs_bytes.h"
#include "vxs_writer.h"

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
    for (int n = 0; n < TILE_TEXELS; n++)
        if (counts[n]) return 1;
    return 0;
}

/* Whether the format can store a curve. */
static int curve_fits(const uint32_t *nodes, uint32_t count)
{
    if (count > VXS_SMOKE_NODES_MAX) return 0;
    for (uint32_t n = 1; n < count; n++)
        if ((nodes[n] & 0xffff) < (nodes[n - 1] & 0xffff) || nodes[n] >> 16 > nodes[n - 1] >> 16) return 0;
    return 1;
}

/* Count tiles and nodes. 0: the format cannot store a curve. */
static int count_curves(smoke_writer *w)
{
    uint64_t at = 0;
    for (size_t tile = 0; tile < w->tiles; tile++) {
        const uint8_t *counts = counts_of(w, tile);
        w->tile_count += (uint32_t)has_curve(counts);
        for (int n = 0; n < TILE_TEXELS; at += counts[n++])
            if (!curve_fits(w->view->nodes + at, counts[n]) || at > INT32_MAX) return 0;
    }
    w->node_count = (uint32_t)at;
    return 1;
}

/* Write nodes as differences from the previous one, with a plane for each byte. */
static void put_curve(smoke_writer *w, const uint32_t *nodes, uint32_t count)
{
    uint32_t depth = 0, left = 0xffff;
    for (uint32_t n = 0; n < count; n++) {
        uint32_t number = ((nodes[n] & 0xffff) - depth) | (left - (nodes[n] >> 16)) << 16;
        for (uint32_t plane = 0; plane < NODE_BYTES; plane++)
            w->nodes[(size_t)plane * w->node_count] = (uint8_t)(number >> 8 * plane);
        w->nodes++;
        depth = nodes[n] & 0xffff;
        left  = nodes[n] >> 16;
    }
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
        for (int n = 0; n < TILE_TEXELS; nodes += counts[n++]) put_curve(w, nodes, counts[n]);
    }
}

static vxs_result encode(smoke_writer *w, vxs_bytes *content)
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

static int map_fits(const vxs_smoke_view *v, const vxs_light *light)
{
    return v->levels >= VXS_LEVELS_MIN && v->levels <= VXS_SMOKE_LEVELS_MAX && v->levels <= light->levels && v->step_metres > 0 &&
           isfinite(v->first_metres) && isfinite(v->first_metres + 65535 * v->step_metres);
}

vxs_result vxs_add_smoke(vxs_sections *s, const vxs_smoke_view *smoke, const vxs_light *light, uint32_t number)
{
    vxs_bytes content = {0};
    if (!map_fits(smoke, light)) return VXS_E_ARGUMENT;
    smoke_writer w = {.view = smoke, .tiles = (size_t)vxs_map_count(light) << (2 * (smoke->levels - 3))};
    if (!count_curves(&w)) return VXS_E_ARGUMENT;
    vxs_result r = encode(&w, &content);
    if (r == VXS_OK) r = vxs_add_section(s, VXS_KIND_SMOKE, VXS_SECTION_OPTIONAL, number, 0, &content);
    free(content.data);
    return r;
}
