/* Writing a light that is a DAG: its levels and masks; formats/vxs.md section 7.
 * SPDX-License-Identifier: MIT */
#include <stdlib.h>
#include <string.h>

#include "vxs_bytes.h"
#include "vxs_writer.h"

_Static_assert(VXS_REF_LIT == VXS_CHILD_LIT && VXS_REF_SHADOW == VXS_CHILD_SHADOW, "lit is 0 and shadow is 1 in every enumeration");

int vxs_dag_fits(const vxs_dag_view *view, const vxs_light *light)
{
    if (view->level_count != light->levels - 2) return 0;
    for (uint32_t map = 0; map < vxs_map_count(light); map++)
        if (view->roots[map] >= view->count[view->level_count - 1]) return 0;
    return 1;
}

/* Encode a level: its nodes in the order in which the level above first refers to them (vxs.md section 7).
 * order  [count] nodes of this level, as indices of `view`
 * below  [out] [*below_count] the same for the level below, or for the masks
 * number [size of that level] scratch */
static vxs_result encode_level(vxs_bytes *content, const vxs_dag_view *view, uint32_t level, const uint32_t *order, uint32_t count,
                               uint32_t *below, uint32_t *below_count, uint32_t *number, uint64_t *words)
{
    content->size_bytes = 0;
    uint8_t *head       = vxs_append(content, 4 + (size_t)count * 2);
    if (!head) return VXS_E_MEMORY;
    vxs_store32(head, count);
    *words += count;
    *below_count = 0;
    for (uint32_t n = 0; n < count; n++) {
        const uint32_t *child  = view->nodes[level] + (size_t)order[n] * 8;
        uint32_t        states = 0;
        for (unsigned c = 0; c < 8; c++) {
            /* VXS_CHILD_SAME saves the offset of a child that repeats its neighbour nearer the light */
            unsigned nearer = level ? 4 : 1;
            int      same   = c >= nearer && child[c] == child[c - nearer];
            uint32_t state  = child[c] < VXS_REF_FIRST ? child[c] : same ? VXS_CHILD_SAME : VXS_CHILD_OWN;
            states |= state << (2 * c);
            if (state != VXS_CHILD_OWN) continue;

            uint32_t *seen = &number[child[c] - VXS_REF_FIRST];
            uint32_t  code = *seen ? *below_count + 1 - *seen : 0;
            if (!*seen) {
                below[(*below_count)++] = child[c] - VXS_REF_FIRST;
                *seen                   = *below_count;
            }
            do { /* seven bits a byte; the highest bit: more follow */
                uint8_t *at = vxs_append(content, 1);
                if (!at) return VXS_E_MEMORY;
                *at = (uint8_t)((code & 0x7f) | (code > 0x7f ? 0x80 : 0));
                code >>= 7;
            } while (code);
            ++*words;
        }
        vxs_store16(content->data + 4 + (size_t)n * 2, (uint16_t)states);
    }
    return VXS_OK;
}

vxs_result vxs_write_dag(vxs_sections *s, const vxs_dag_view *view, uint32_t maps, uint32_t light, uint32_t *word_count)
{
    vxs_bytes content = {0};
    uint64_t  words   = maps > 1 ? maps : 0; /* words with the starts of the roots */
    uint32_t  count   = maps;
    uint32_t *order   = malloc(maps * sizeof *order);
    if (!order) return VXS_E_MEMORY;
    memcpy(order, view->roots, maps * sizeof *order);
    vxs_result r = VXS_OK;
    for (uint32_t level = view->level_count; level-- > 0 && r == VXS_OK;) {
        uint32_t  room        = level ? view->count[level - 1] : view->mask_count;
        uint32_t *below       = malloc(((size_t)room + 1) * sizeof *below);
        uint32_t *number      = calloc((size_t)room + 1, sizeof *number);
        uint32_t  below_count = 0;
        r = below && number ? encode_level(&content, view, level, order, count, below, &below_count, number, &words) : VXS_E_MEMORY;
        if (r == VXS_OK) r = vxs_add_section(s, VXS_KIND_LEVEL, 0, light, level, &content);
        free(number);
        free(order);
        order = below;
        count = below_count;
    }
    if (r == VXS_OK) {
        content.size_bytes = 0;
        uint8_t *at        = vxs_append(&content, (size_t)count * 8);
        if (!at && count) r = VXS_E_MEMORY;
        for (uint32_t n = 0; n < count && at; n++, at += 8) vxs_store64(at, view->masks[order[n]]);
    }
    if (r == VXS_OK) r = vxs_add_section(s, VXS_KIND_MASKS, 0, light, 0, &content);
    words += (words & 1) + (uint64_t)count * 2; /* masks start at even words */
    if (r == VXS_OK && words > UINT32_MAX) r = VXS_E_ARGUMENT;
    *word_count = (uint32_t)words;
    free(order);
    free(content.data);
    return r;
}
