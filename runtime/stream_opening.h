/* A stream while it is opened: what stream_plan.c finds out, and stream_open.c lays out and fills. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef STREAM_OPENING_H
#define STREAM_OPENING_H

#include "stream.h"
#include "vxs_reader.h"

/* A light that is wanted. */
typedef struct light_plan {
    uint32_t           number;                          /* in the file */
    int                resident_section, pages_section; /* of palette blocks, as the next */
    vxs_resident_sizes sizes;
    uint32_t           word_count; /* of its resident part, or of all of a DAG */
    uint64_t           work_bytes; /* while it is read */
    vxs_baked_smoke    smoke;      /* without words; all 0: it has none */
} light_plan;

typedef struct opening {
    vxs_reader             r;
    const vxs_stream_desc *desc;
    stream_source          source;
    vxs_allocator          allocator;
    uint8_t               *loaded; /* the section that was loaded last */
    uint64_t               loaded_bytes;
    light_plan            *lights; /* [light_count] */
    uint32_t               light_count, page_count, node_count, tool_count, request_count;
    uint64_t               resident_words, all_words, work_bytes, buffer_bytes; /* buffer_bytes: of one, at most */
    int                    small, fast;                                         /* whether there is one that is packed so */
    vxs_stream            *s;
    uint8_t               *work, *work_end; /* of the room, that is not yet taken */
} opening;

static inline uint64_t sum_or_max(uint64_t a, uint64_t b)
{
    return a > UINT64_MAX - b ? UINT64_MAX : a + b;
}

/* Read bytes of the file. 0: the result is set. */
int  vxs_stream_read(opening *o, uint64_t offset, uint64_t size_bytes, void *to);
void vxs_stream_forget_loaded(opening *o);

/* vxs_reader's load: what it gave last is forgotten. */
const uint8_t *vxs_stream_load(vxs_reader *r, int section);

/* Header and directory. 0: a finding, and so of the next. */
int vxs_stream_read_head(opening *o);

/* Which lights are wanted, and how large what there has to be of them is; the table of lights is there. */
int vxs_stream_plan(opening *o);

#endif
