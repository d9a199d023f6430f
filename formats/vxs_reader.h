/* State of a file being read: interface between vxs_read.c, the readers of sections, and vxs_reader.c, which they share. Not
 * installed. The reader belongs to the thread that called vxs_read. Tasks of a coding (vxs_tasks.h) only read it, and call no
 * function of this header.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_READER_H
#define VXS_READER_H

#include <zstd.h>

#include "vxs_file.h"

enum { VXS_IN_HEADER = -1 }; /* section of findings in the header and the directory */

typedef struct vxs_reader vxs_reader;

struct vxs_reader {
    const uint8_t *bytes; /* of the file; only header and directory if sections are loaded by `load` */
    uint64_t       size;  /* of the file */
    vxs_read_desc  desc;
    vxs_allocator  allocator;
    uint64_t       memory_left;
    vxs_result     result; /* of the first finding */
    vxs_contents   out;
    ZSTD_DCtx     *zstd;
    /* Returns the stored bytes of a section, with a valid hash, until the next call; NULL: a finding. If `load` is NULL, all
     * sections are in `bytes` */
    const uint8_t *(*load)(vxs_reader *r, int section);
    void            *load_user;
    vxs_baked_smoke *smoke; /* [out.light_count] NULL: no light has smoke */
    vxs_baked_points points;
    int              is_written; /* the bytes come from vxs_write: see vxs_read_written */
};

/* Report a finding (vxs_findings.h) at an offset of the inflated section. */
void vxs_found(vxs_reader *r, int number, int section, uint64_t offset);

/* Allocate count elements of `size` bytes within the limit; NULL: a finding, or VXS_E_MEMORY. */
void *vxs_reader_alloc(vxs_reader *r, uint64_t count, size_t size, int section);

/* The same for optional memory: NULL is not a finding. */
void *vxs_reader_try_alloc(vxs_reader *r, uint64_t count, size_t size);

/* Free memory from vxs_reader_alloc or vxs_reader_try_alloc, with the same count and size. Accepts NULL. */
void vxs_reader_free(vxs_reader *r, void *memory, uint64_t count, size_t size);

/* Whether two sections are of the same kind, light and level. */
int vxs_same_section(const vxs_section *a, const vxs_section *b);

/* Index of a section, or -1: a finding. */
int vxs_find_section(vxs_reader *r, uint32_t kind, uint32_t light, uint32_t level);

/* Whether a section, stored at `from`, is one frame of the inflated size in the directory, without inflating it; 0: a finding.
 * extra  bytes that the caller wants behind the inflated ones */
int vxs_check_frame(vxs_reader *r, int section, const uint8_t *from, size_t extra);

/* Inflated bytes of a section, followed by `extra` zeros; to be freed with vxs_reader_free. NULL: a finding. */
uint8_t *vxs_inflate(vxs_reader *r, int section, size_t extra);

/* Stored bytes of a section. */
static inline const uint8_t *vxs_stored_bytes(vxs_reader *r, int section)
{
    return r->load ? r->load(r, section) : r->bytes + r->out.sections[section].offset_bytes;
}

/* vxs_read_dag.c --------------------------------------------------------------------------------------------------------------- */

/* Whether a kind of section belongs to DAGs; whether a light has this section. */
int vxs_is_dag_section(uint32_t kind);
int vxs_dag_has_section(const vxs_light *light, const vxs_section *s);

/* Check the levels and masks of a light, and write its words; the light table has their number. If the light already has
 * memory for its words, they are written there. */
void vxs_read_dag(vxs_reader *r, vxs_baked_light *baked);

/* vxs_read_blocks.c ------------------------------------------------------------------------------------------------------------ */

/* The same for palette blocks. Their sections are not zstd frames (VXS_SECTION_STORED). */
int  vxs_is_blocks_section(uint32_t kind);
void vxs_read_blocks(vxs_reader *r, vxs_baked_light *baked);

/* vxs_read_extras.c: smoke ------------------------------------------------------------------------------------------------------ */

/* Check the smoke of all lights that have some, and write its words. */
void vxs_read_smoke(vxs_reader *r);

/* The section with the smoke of a light; -1: none. */
int vxs_find_smoke(const vxs_reader *r, uint32_t light);

/* Check a section of smoke except its curves, and set all of a vxs_baked_smoke except its words. */
void vxs_measure_smoke(vxs_reader *r, int section, vxs_baked_smoke *to);

/* Check the section again, with its curves, and write its words.   words  [measured->word_count] */
void vxs_read_smoke_words(vxs_reader *r, const vxs_baked_smoke *measured, uint32_t *words);

/* smoke  [count] or NULL */
void vxs_smoke_free(vxs_baked_smoke *smoke, uint32_t count, const vxs_allocator *allocator);

/* vxs_read_extras.c: points ----------------------------------------------------------------------------------------------------- */

/* Check the points, if there are any, and write their coordinates. */
void vxs_read_points(vxs_reader *r);

/* Accepts points without coordinates. */
void vxs_points_free(vxs_baked_points *points, const vxs_allocator *allocator);

/* vxs_read.c ------------------------------------------------------------------------------------------------------------------- */

/* Check the header: reads the first VXS_HEADER_BYTES of r->bytes, or all if r->size is less. 0: a finding. */
int vxs_read_header(vxs_reader *r);

/* Check header and directory, and the hashes of sections that are in memory. 0: a finding. */
int vxs_read_head(vxs_reader *r);

/* Read the table of lights, and check that each section belongs to a light. Needs the head and a zstd context. The lights
 * have no words yet. 0: a finding. */
int vxs_read_light_table(vxs_reader *r);

/* Inflate the metadata if the description wants it; else only check its frame. 0: a finding. */
int vxs_read_metadata(vxs_reader *r);

/* Content that is not in vxs_contents, because the layout of that struct must not change. */
typedef struct vxs_extras {
    vxs_baked_smoke *smoke; /* [light_count] NULL: no light has smoke */
    vxs_baked_points points;
} vxs_extras;

/* vxs_read, with smoke and points.
 * extras      [out] release with vxs_extras_free; written only if VXS_OK is returned
 * is_written  as vxs_read_written */
vxs_result vxs_read_extras(vxs_contents *contents, vxs_extras *extras, const void *bytes, size_t size_bytes,
                           const vxs_read_desc *desc, int is_written);
void       vxs_extras_free(vxs_extras *extras, uint32_t light_count, const vxs_allocator *allocator);

/* vxs_read of bytes that vxs_write has just made. Pages packed small or fine are not decoded: vxs_page_encode has checked that
 * they decode to their words. All else is checked, and pages are marked as not loaded. */
vxs_result vxs_read_written(vxs_contents *contents, const void *bytes, size_t size_bytes, const vxs_read_desc *desc);

#endif
