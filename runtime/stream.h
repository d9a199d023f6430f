/* Internals of a stream, shared by its files:
 *
 *     stream_plan.c     what open reads first: the wanted lights and their sizes
 *     stream_open.c     from a file to a block of memory: its layout, page data
 *     stream_choose.c   which pages are wanted, the nearest first; where in the array of words a page goes, and which pages are
 *     evicted stream_work.c     requests: read and decoded by threads, or by the frame; bytes from a path, memory or the caller
 *     stream.c          the frame, and the queries of a stream
 *
 * Order of the block; the array of words extends from `words` to its end, tail included:
 *
 *     vxs_stream | lights | pages | lists | tools | words: resident parts, smoke | room for pages | tail: nodes, buffers
 *
 * Access: lights and the constant fields of pages: any thread. The other fields of pages, the lists, and the words of page
 * tables: the frame. Requests: under the lock, except for the memory that a request decodes from and to: the thread that works on
 * it.
 * Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef STREAM_H
#define STREAM_H

#include "platform.h"
#include "vxs_read_blocks.h"
#include "vxs_stream.h"

enum {
    ROOM_ALIGN = 16,         /* words: pages share no cache line */
    STORED_MAX = 1 << 19,    /* most stored bytes of a page: twice the bytes of its words */
    FAR_METRES = 1000000000, /* larger than any map */
};

typedef struct stream_light {
    vxs_paged_light paged; /* nodes and page_first are valid during open only */
    uint32_t        first_word, first_page, page_count;
    vxs_baked_smoke smoke; /* words NULL: no smoke */
} stream_light;

typedef enum page_state { PAGE_AWAY, PAGE_COMING, PAGE_HERE, PAGE_BROKEN } page_state;

typedef struct stream_page {
    uint64_t   offset_bytes, hash; /* of its stored bytes in the file */
    uint32_t   stored_bytes, word_count;
    uint32_t   light;
    uint32_t   first_square, node_count; /* z-order number of its first node's square, map after map; number of its nodes */
    float      min[3], max[3];           /* box of its volume, metres along the axes of light space (stream_choose.c) */
    page_state state;
    uint32_t   place;             /* index of its first word in the array; for COMING and HERE */
    float      rank;              /* distance, reduced for HERE and COMING; FLT_MAX: not wanted */
    uint32_t   kept;              /* last frame in which it was among the nearest that fit */
    uint32_t   attempts, next_at; /* failures, and the first frame in which it is tried again */
} stream_page;

typedef enum request_state {
    REQUEST_FREE,
    REQUEST_QUEUED,  /* waits for a thread */
    REQUEST_WORKING, /* a thread works on it */
    REQUEST_PENDING, /* the caller is reading */
    REQUEST_DONE,    /* waits for the next frame */
} request_state;

struct vxs_stream_request {
    vxs_stream   *stream;
    request_state state;
    uint32_t      page, order;         /* order: of the requests */
    uint8_t      *buffer;              /* [buffer_bytes]; NULL when the bytes are in memory */
    int           asked, answered, ok; /* the read: was started, has ended, succeeded */
    int           decoded, finding;
};

typedef struct stream_tools {
    vxs_stream    *stream;
    vxs_page_tools decode;
    vxs_page_node *nodes; /* [nodes_max] */
    int            busy;  /* submitted to the caller's threads: 0 no, 1 waiting, 2 running */
    os_thread      thread;
} stream_tools;

typedef struct stream_source {
    const uint8_t *bytes;
    int            is_file;
    os_file        file;
    vxs_stream_answer (*read)(void *user, uint64_t offset, uint32_t size_bytes, void *buffer, vxs_stream_request *request);
    void    *user;
    uint64_t size_bytes;
    uint64_t bytes_read; /* during open; then updated by frames */
} stream_source;

struct vxs_stream {
    vxs_stream_desc desc;
    vxs_allocator   allocator;
    size_t          block_bytes;
    stream_source   source;

    vxs_baked_light *baked;
    stream_light    *lights;
    uint32_t         light_count;
    stream_page     *pages;
    uint32_t         page_count;

    uint32_t *words;
    uint32_t  word_count, room_first, room_end; /* of the array; the room for pages is words room_first..room_end - 1 */
    uint32_t *in_room;                          /* [in_room_count] pages that have a place, in order of place */
    uint32_t  in_room_count;

    uint32_t *heap; /* [page_count] */
    vxs_stream_range
            *changes; /* [page_count + 4 * request_count]: each page is evicted at most once; each request adds two ranges, twice */
    uint32_t change_count;
    uint32_t frame, wanted, heap_count;

    stream_tools       *tools;                    /* [tool_count] */
    uint32_t            tool_count, thread_count; /* thread_count: started threads */
    vxs_stream_request *requests;                 /* [request_count] */
    uint32_t            request_count, buffer_bytes, nodes_max, order;
    os_mutex            lock;
    os_signal           work, rest;        /* work: a request is queued, or closing; rest: a request or job has ended */
    int                 can_work, closing; /* can_work: lock and signals are initialized */

    vxs_stream_status status; /* counts of this frame */
};

/* stream_work.c */
vxs_result        vxs_stream_source_open(stream_source *source, const vxs_stream_desc *desc);
void              vxs_stream_source_close(stream_source *source);
vxs_stream_answer vxs_stream_source_read(const stream_source *source, uint64_t offset, uint32_t size_bytes, void *buffer,
                                         vxs_stream_request *request);

/* stream_choose.c: add a square of a light's map to a page's volume; rank all pages. */
void vxs_stream_page_add_square(stream_page *page, const vxs_light *light, uint32_t map, uint32_t x, uint32_t y, uint32_t bounds);
void vxs_stream_rank_pages(vxs_stream *s, const vxs_stream_focus *foci, uint32_t count);
/* Take the next nearest page from the heap that vxs_stream_rank_pages built. 0: none is left. */
int  vxs_stream_next_nearest(vxs_stream *s, uint32_t *page);

/* stream_choose.c */
uint32_t vxs_stream_room_words(const stream_page *page);
/* Find a place for a page, and evict other pages for it. 0: there is none. */
int      vxs_stream_room_alloc(vxs_stream *s, uint32_t page);
void     vxs_stream_room_free(vxs_stream *s, uint32_t page);
void     vxs_stream_show(vxs_stream *s, uint32_t page, int there);

/* stream_work.c */
int                 vxs_stream_work_start(vxs_stream *s);
void                vxs_stream_work_end(vxs_stream *s);
/* Whether a request is free. */
int                 vxs_stream_can_ask(vxs_stream *s);
/* Request a page that has a place; a request must be free. */
void                vxs_stream_ask(vxs_stream *s, uint32_t page);
/* On the calling thread, start queued reads and decode up to `count` pages. */
void                vxs_stream_work_here(vxs_stream *s, uint32_t count);
/* Returns the oldest done request, which the caller releases; NULL: none. */
vxs_stream_request *vxs_stream_next_done(vxs_stream *s);
void                vxs_stream_release(vxs_stream_request *request);

#endif
