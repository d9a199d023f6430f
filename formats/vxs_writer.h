/* State of a file being written: interface between vxs_write.c, the writers of sections, and vxs_sections.c, which they share. Not
 * installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_WRITER_H
#define VXS_WRITER_H

#include <zstd.h>

#include "vxs_write_file.h"

/* The sections so far: directory entries and stored bytes, joined at the end. */
typedef struct vxs_sections {
    vxs_bytes           entries; /* VXS_ENTRY_BYTES each; offsets are filled in at the end */
    vxs_bytes           stored;
    ZSTD_CCtx          *zstd;
    int                 zstd_level;
    uint32_t            version; /* of the file */
    const vxs_parallel *parallel;
} vxs_sections;

/* A zstd context for a level; NULL: no memory. Release with ZSTD_freeCCtx. */
ZSTD_CCtx *vxs_compressor(int zstd_level);

/* Append `size` bytes to `b` and return them; NULL: no memory. */
uint8_t *vxs_append(vxs_bytes *b, size_t size);

/* Compress the content and append it as a section. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result vxs_add_section(vxs_sections *s, uint32_t kind, uint32_t flags, uint32_t light, uint32_t level,
                           const vxs_bytes *content);

/* Append a section of a light, stored as it is, not as a zstd frame. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result vxs_add_stored(vxs_sections *s, uint32_t kind, uint32_t light, const vxs_bytes *content);

/* vxs_write_dag.c -------------------------------------------------------------------------------------------------------------- */

/* Whether a DAG has the levels of a light, and a root for each of its maps. */
int vxs_dag_fits(const vxs_dag_view *view, const vxs_light *light);

/* Write the sections of light number `light`: level of the roots first, masks last. Each map has its own root node, even if
 * two roots are equal.
 * word_count  [out] number of words for a reader
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT if the number of words exceeds 32 bits. */
vxs_result vxs_write_dag(vxs_sections *s, const vxs_dag_view *view, uint32_t maps, uint32_t light, uint32_t *word_count);

/* vxs_write_blocks.c ----------------------------------------------------------------------------------------------------------- */

/* What becomes the sections of a light. */
typedef struct vxs_encoded_light vxs_encoded_light;

/* Encode the lights of palette blocks, all pages side by side; lights of other codings are left out. Errors of pages are those of
 * vxs_write_blocks.
 * lights  borrowed until vxs_encoded_free
 * out     [count], also on failure; NULL without memory
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT if the words are not in canonical order, if the common patterns do not match them,
 * or if the packing is unknown. */
vxs_result vxs_encode_blocks(vxs_encoded_light **out, const vxs_sections *s, const vxs_write_light *lights, uint32_t count);
void       vxs_encoded_free(vxs_encoded_light *lights, uint32_t count);

/* Write the sections of light number `number`: resident part, then pages. What was encoded of it is released.
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT as vxs_encode_blocks. */
vxs_result vxs_write_blocks(vxs_sections *s, vxs_encoded_light *lights, uint32_t number);

/* vxs_write_extras.c ------------------------------------------------------------------------------------------------------------ */

/* Write the smoke section of light number `number`.
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT as vxs_write_smoke. */
vxs_result vxs_add_smoke(vxs_sections *s, const vxs_smoke_view *smoke, const vxs_light *light, uint32_t number);

/* Write the section of points.
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT as vxs_write. */
vxs_result vxs_add_points(vxs_sections *s, const vxs_points_view *view);

#endif
