/* One page, or one resident part, to bytes, where a test needs no working memory that is kept and no nodes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PAGE_ENCODED_H
#define PAGE_ENCODED_H

#include <stdlib.h>

#include "formats/vxs_page.h"

static inline vxs_result page_encoded(vxs_bytes *out, const uint32_t *words, uint32_t word_count, const vxs_page_node *nodes,
                                      uint32_t node_count, const vxs_common *common)
{
    vxs_page_encoder *e = vxs_page_encoder_new();
    vxs_result        r = e ? vxs_page_encode(e, out, words, word_count, nodes, node_count, common) : VXS_E_MEMORY;
    vxs_page_encoder_free(e);
    return r;
}

static inline vxs_result resident_encoded(vxs_bytes *out, const uint32_t *words, uint32_t word_count, uint32_t levels,
                                          uint32_t map_count, const vxs_common *common)
{
    vxs_page_nodes nodes;
    vxs_result     r = vxs_resident_encode(out, &nodes, words, word_count, levels, map_count, common);
    free(nodes.nodes);
    free(nodes.page_first);
    return r;
}

#endif
