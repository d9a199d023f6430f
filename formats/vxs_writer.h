/* A file while it is written: what vxs_write.c gives the codings to write their sections by, and what they give it. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_WRITER_H
#define VXS_WRITER_H

#include <zstd.h>

#include "vxs_file.h"

/* The sections so far: directory entries and stored bytes, put together at the end. */
typedef struct vxs_sections {
    vxs_bytes           entries; /* VXS_ENTRY_BYTES each; offsets are filled in at the end */
    vxs_bytes           stored;
    ZSTD_CCtx          *zstd;
    int                 zstd_level;
    uint32_t            version; /* of the file */
    const vxs_parallel *parallel;
} vxs_sections;

/* One that compresses at a level, or NULL without memory. Release with ZSTD_freeCCtx. */
ZSTD_CCtx *vxs_compressor(int zstd_level);

/* `size` more bytes at the end of `b`, or NULL without memory. */
uint8_t *vxs_append(vxs_bytes *b, size_t size);

/* One more section, with content that is yet to be compressed. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result vxs_add_section(vxs_sections *s, uint32_t kind, uint32_t flags, uint32_t light, uint32_t level,
                           const vxs_bytes *content);

/* One more section of a light, whose content is stored as it is. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result vxs_add_stored(vxs_sections *s, uint32_t kind, uint32_t light, const vxs_bytes *content);

/* vxs_write_dag.c -------------------------------------------------------------------------------------------------------------- */

/* Whether a DAG has the levels of a light, and a root for each of its maps. */
int vxs_dag_fits(const vxs_dag_view *view, const vxs_light *light);

/* Sections of light number `light`: the roots' level first, the masks last. A root is a node of its own for each map, even where two are
 * equal.
 * word_count  [out] what a reader will need
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT when words cannot be counted in 32 bits. */
vxs_result vxs_write_dag(vxs_sections *s, const vxs_dag_view *view, uint32_t maps, uint32_t light, uint32_t *word_count);

/* vxs_write_blocks.c ----------------------------------------------------------------------------------------------------------- */

/* Sections of light number `number`: its resident part, then its pages.
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT when its words are not in canonical order, or its common patterns are others, or its packing
 * is none. */
vxs_result vxs_write_blocks(vxs_sections *s, const vxs_blocks_view *view, const vxs_light *light, uint32_t number);

/* vxs_write_smoke.c ------------------------------------------------------------------------------------------------------------ */

/* The section of light number `number`.
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT as vxs_write_smoke. */
vxs_result vxs_add_smoke(vxs_sections *s, const vxs_smoke_view *smoke, const vxs_light *light, uint32_t number);

/* vxs_write_points.c ----------------------------------------------------------------------------------------------------------- */

/* Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT as vxs_write. */
vxs_result vxs_add_points(vxs_sections *s, const vxs_points_view *view);

#endif
