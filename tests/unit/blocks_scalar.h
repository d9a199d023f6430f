/* The lookups of shaders, word by word, in C: beside those by vectors, which tests/unit/test_lookup_blocks.c includes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BLOCKS_SCALAR_H
#define BLOCKS_SCALAR_H

#include <stdint.h>

uint32_t scalar_shadow(const uint32_t *words, uint32_t map, uint32_t levels, uint32_t i, uint32_t j, uint32_t k);
uint32_t scalar_shadow_count(const uint32_t *words, uint32_t map, uint32_t levels, int32_t i, int32_t j, uint32_t k,
                             int32_t width_px);
uint32_t scalar_shadow_weight(const uint32_t *words, uint32_t map, uint32_t levels, int32_t i, int32_t j, uint32_t across,
                              uint32_t down, uint32_t k, int32_t width_px);
uint32_t scalar_is_full(const uint32_t *words, uint32_t map, uint32_t levels, int32_t i, int32_t j, uint32_t k, int32_t width_px);

#endif
