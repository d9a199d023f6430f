/* A file while it is read: what vxs_read.c gives the codings to read their sections by, and what they give it. Not installed.
 * The reader belongs to the thread that called vxs_read; what a coding leaves to tasks (vxs_tasks.h) reads it and calls nothing here.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_READER_H
#define VXS_READER_H

#include <zstd.h>

#include "vxs_file.h"

typedef struct vxs_reader vxs_reader;

struct vxs_reader {
    const uint8_t *bytes; /* of the file; only header and directory where sections are loaded */
    uint64_t       size;  /* of the file */
    vxs_read_desc  desc;
    vxs_allocator  allocator;
    uint64_t       memory_left;
    vxs_result     result; /* of the first finding */
    vxs_contents   out;
    ZSTD_DCtx     *zstd;
    /* The stored bytes of a section, whose hash holds, until the next call; NULL: a finding. NULL: they are in the file's bytes */
    const uint8_t *(*load)(vxs_reader *r, int section);
    void            *load_user;
    vxs_baked_smoke *smoke; /* [out.light_count] NULL: no light has any */
    vxs_baked_points points;
};

/* Check the header: of r->bytes the first VXS_HEADER_BYTES are looked at, or all where r->size is less. 0: a finding. */
int vxs_read_header(vxs_reader *r);

/* Check header and directory, and the hashes of sections that are in memory. 0: a finding. */
int vxs_read_head(vxs_reader *r);

/* Read the table of lights, once the head was read and there is a zstd context, and check that sections belong to them. Lights have no words
 * yet. 0: a finding. */
int vxs_read_light_table(vxs_reader *r);

/* Inflate the metadata, where the description asks for it; else check its frame. 0: a finding. */
int vxs_read_metadata(vxs_reader *r);

/* Tell of a finding (vxs_findings.h) at an offset of a section, as it is inflated. */
void vxs_found(vxs_reader *r, int number, int section, uint64_t offset);

/* count elements of `size` bytes, within the limit; NULL (a finding, or VXS_E_MEMORY) otherwise. */
void *vxs_take(vxs_reader *r, uint64_t count, size_t size, int section);

/* The same where nothing is lost without it: NULL is no finding. */
void *vxs_take_spare(vxs_reader *r, uint64_t count, size_t size);

/* The same count and size. Accepts NULL. */
void vxs_give_back(vxs_reader *r, void *memory, uint64_t count, size_t size);

/* The index of a section, or -1: a finding. */
int vxs_find_section(vxs_reader *r, uint32_t kind, uint32_t light, uint32_t level);

/* The inflated bytes of a section and `extra` zeros behind them, to be given back; NULL: a finding. */
uint8_t *vxs_inflate(vxs_reader *r, int section, size_t extra);

/* The bytes of a section as they are stored. */
static inline const uint8_t *vxs_stored_bytes(vxs_reader *r, int section)
{
    return r->load ? r->load(r, section) : r->bytes + r->out.sections[section].offset_bytes;
}

/* vxs_read_dag.c --------------------------------------------------------------------------------------------------------------- */

/* Whether a kind of section is one of the DAG's; whether a light has that section. */
int vxs_is_dag_section(uint32_t kind);
int vxs_dag_has_section(const vxs_light *light, const vxs_section *s);

/* Check the levels and masks of a light, and lay out its words, of which the light table has said how many there are: where the light's words
 * are, if they have a place already. */
void vxs_read_dag(vxs_reader *r, vxs_baked_light *baked);

/* vxs_read_blocks.c ------------------------------------------------------------------------------------------------------------ */

/* The same for palette blocks. Their sections are stored as they are. */
int  vxs_is_blocks_section(uint32_t kind);
void vxs_read_blocks(vxs_reader *r, vxs_baked_light *baked);

/* vxs_read_smoke.c ------------------------------------------------------------------------------------------------------------- */

/* Check the smoke of all lights that have some, and lay out its words. */
void vxs_read_smoke(vxs_reader *r);

/* The section of a light's smoke; -1: it has none. */
int vxs_find_smoke(const vxs_reader *r, uint32_t light);

/* How much a section of smoke has, checked but for its curves: all of a vxs_baked_smoke but its words. */
void vxs_measure_smoke(vxs_reader *r, int section, vxs_baked_smoke *to);

/* Check it again, and its curves, and lay out its words.   words  [measured->word_count] */
void vxs_read_smoke_words(vxs_reader *r, const vxs_baked_smoke *measured, uint32_t *words);

/* smoke  [count] NULL: there is none */
void vxs_smoke_free(vxs_baked_smoke *smoke, uint32_t count, const vxs_allocator *allocator);

/* vxs_read_points.c ------------------------------------------------------------------------------------------------------------ */

/* Check the points, where there are some, and lay out their coordinates. */
void vxs_read_points(vxs_reader *r);

/* Accepts none. */
void vxs_points_free(vxs_baked_points *points, const vxs_allocator *allocator);

/* vxs_read.c ------------------------------------------------------------------------------------------------------------------- */

/* What is read beside the contents, whose layout stays as it is. */
typedef struct vxs_beside {
    vxs_baked_smoke *smoke; /* [light_count] NULL: no light has any */
    vxs_baked_points points;
} vxs_beside;

/* vxs_read, that gives what is beside, too.
 * beside  [out] released with vxs_beside_free. Written only when VXS_OK is returned */
vxs_result vxs_read_beside(vxs_contents *contents, vxs_beside *beside, const void *bytes, size_t size_bytes,
                           const vxs_read_desc *desc);
void       vxs_beside_free(vxs_beside *beside, uint32_t light_count, const vxs_allocator *allocator);

#endif
