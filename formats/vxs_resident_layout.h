/* Layout of the words of a resident part (formats/vxs.md 13.1), shared by all code that reads or writes them. Internal to
 * vxs_page_*.c and vxs_resident_*.c. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_RESIDENT_LAYOUT_H
#define VXS_RESIDENT_LAYOUT_H

#include "vxs_page.h"

enum {
    RESIDENT_WORDS      = 8,  /* words before the words of pages */
    RESIDENT_HEAD_BYTES = 16, /* stored head: its sizes */
    CELL_SQUARES        = 8,  /* squares on a side of a cell of the top */
    CELL_LEVELS         = 15,
    SQUARE_DEPTH_END    = (1 << 18) + 1,
};

static const uint32_t top_uniform = 0x80000000u;

/* Number of squares of 256 x 256 texels on a side of a map. */
static inline uint32_t squares_of(uint32_t levels)
{
    return levels <= 8 ? 1 : 1u << (levels - 8);
}

/* Word of entry (x, y) of a top; or of its cell, if the whole cell has one depth. */
static inline uint32_t top_at(const uint32_t *words, uint32_t top, uint32_t levels, uint32_t x, uint32_t y)
{
    uint32_t side = squares_of(levels);
    if (levels < CELL_LEVELS) return top + 2 * (y * side + x);
    uint32_t at = top + y / CELL_SQUARES * (side / CELL_SQUARES) + x / CELL_SQUARES;
    return words[at] & top_uniform ? at : words[at] + 2 * (y % CELL_SQUARES * CELL_SQUARES + x % CELL_SQUARES);
}

/* Base of a node, from the second word of its entry. */
static inline int32_t square_base(uint32_t bounds, uint32_t levels)
{
    return (int32_t)((bounds & 0xffff) << (levels > 16 ? levels - 16 : 0));
}

/* Every other bit of n. */
static inline uint32_t even_bits(uint32_t n)
{
    n &= 0x55555555;
    n = (n | n >> 1) & 0x33333333;
    n = (n | n >> 2) & 0x0f0f0f0f;
    n = (n | n >> 4) & 0x00ff00ff;
    return (n | n >> 8) & 0xffff;
}

/* Index of the node at an offset of a page, whose nodes are first..end - 1, in ascending order; `none` if there is none. */
static inline uint32_t node_at(const vxs_page_node *nodes, uint32_t first, uint32_t end, uint32_t offset, uint32_t none)
{
    while (first < end) {
        uint32_t middle = first + (end - first) / 2;
        if (nodes[middle].offset == offset) return middle;
        if (nodes[middle].offset < offset)
            first = middle + 1;
        else
            end = middle;
    }
    return none;
}

#endif
