/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "blocks_scalar.h"

#define VXS_SCALAR
#include "formats/vxs_lookup_blocks.h"

uint32_t scalar_shadow(const uint32_t *words, uint32_t map, uint32_t levels, uint32_t i, uint32_t j, uint32_t k)
{
    return vxs_blocks_shadow(words, map, levels, i, j, k);
}

uint32_t scalar_shadow_count(const uint32_t *words, uint32_t map, uint32_t levels, int32_t i, int32_t j, uint32_t k,
                             int32_t width_px)
{
    return vxs_blocks_shadow_count(words, map, levels, i, j, k, width_px);
}

uint32_t scalar_shadow_weight(const uint32_t *words, uint32_t map, uint32_t levels, int32_t i, int32_t j, uint32_t across,
                              uint32_t down, uint32_t k, int32_t width_px)
{
    return vxs_blocks_shadow_weight(words, map, levels, i, j, across, down, k, width_px);
}

uint32_t scalar_is_full(const uint32_t *words, uint32_t map, uint32_t levels, int32_t i, int32_t j, uint32_t k, int32_t width_px)
{
    return vxs_blocks_is_full(words, map, levels, i, j, k, width_px);
}
