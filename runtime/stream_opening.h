/* Data of a stream during open: stream_plan.c computes sizes, stream_open.c lays out and fills the block. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef STREAM_OPENING_H
#define STREAM_OPENING_H

#include "stream.h"
#include "vxs_reader.h"

/* A light to open. */
typedef struct light_plan {
    uint32_t           number;                          /* index in the file */
    int                resident_section, pages_section; /* of palette blocks, like sizes */
    vxs_resident_sizes sizes;
    uint32_t           word_count; /* of its resident part, or of a whole DAG */
    uint64_t           work_bytes; /* memory needed while it is read */
    vxs_baked_smoke    smoke;      /* without words; all 0: no smoke */
} light_plan;

typedef struct opening {
    vxs_reader             r;
    const vxs_stream_desc *desc;
    stream_source          source;
    vxs_allocator          allocator;
    uint8_t               *loaded; /* the last loaded section */
    uint64_t               loaded_bytes;
    light_plan            *lights; /* [light_count] */
    uint32_t               light_count, page_count, node_count, tool_count, request_count;
    uint64_t               resident_words, all_words, work_bytes, buffer_bytes; /* buffer_bytes: upper bound for one request */
    int                    small, fast;                                         /* whether any light is packed small, packed fast */
    vxs_stream            *s;
    uint8_t               *work, *work_end; /* part of the room that is not yet used */
} opening;

static inline uint64_t sum_or_max(uint64_t a, uint64_t b)
{
    return a > UINT64_MAX - b ? UINT64_MAX : a + b;
}

/* Read bytes of the file. 0: failed, and the result is set. */
int  vxs_stream_read(opening *o, uint64_t offset, uint64_t size_bytes, void *to);
void vxs_stream_forget_loaded(opening *o);

/* Load function of vxs_reader: returns a section, valid until the next load. NULL: failed. */
const uint8_t *vxs_stream_load(vxs_reader *r, int section);

/* Read header and directory. 0: failed, and the result is set; so for vxs_stream_plan. */
int vxs_stream_read_head(opening *o);

/* Find the lights to open and the sizes of their resident data. The table of lights must have been read. */
int vxs_stream_plan(opening *o);

#endif
