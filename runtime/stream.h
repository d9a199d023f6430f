/* A stream from within: what its files share. Each of them has one idea:
 *
 *     stream_plan.c     what open reads first: which lights there are, how large they are
 *     stream_open.c     from a file to a block of memory: where things lie in it, what is known of pages
 *     stream_source.c   bytes from a path, memory or the caller
 *     stream_choose.c   which pages are wanted, the nearest first
 *     stream_room.c     where in the array of words a page goes, and which pages leave for it
 *     stream_work.c     requests: read and decoded by threads, or by the frame
 *     stream.c          the frame, and what is asked of a stream
 *
 * The block, in this order; the array of words is all from `words` to its end, tail and all:
 *
 *     vxs_stream | lights | pages | lists | tools | words: resident parts, smoke | room for pages | tail: nodes of tools, buffers of requests
 *
 * Who may touch what: lights and what is constant of pages, anybody. The rest of pages, lists, and words of tables of pages: the frame.
 * Requests: under the lock; but what one decodes to and from, who has it in hand.
 * Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef STREAM_H
#define STREAM_H

#include "platform.h"
#include "vxs_read_page.h"
#include "vxs_stream.h"

enum {
    FIRST_PAGE_WORD = 8,          /* of the table of pages, among a light's words */
    ROOM_ALIGN      = 16,         /* words: pages share no cache line */
    STORED_MAX      = 1 << 19,    /* bytes of a page: twice its words, more than any has */
    FAR_METRES      = 1000000000, /* beyond any map */
};

typedef struct stream_light {
    vxs_paged_light paged; /* nodes and page_first are gone when open ends */
    uint32_t        first_word, first_page, page_count;
    vxs_baked_smoke smoke; /* words NULL: it has none */
} stream_light;

typedef enum page_state { PAGE_AWAY, PAGE_COMING, PAGE_HERE, PAGE_BROKEN } page_state;

typedef struct stream_page {
    uint64_t   offset_bytes, hash; /* of its stored bytes, in the file */
    uint32_t   stored_bytes, word_count;
    uint32_t   light;
    uint32_t   first_square, node_count; /* in z order, map after map: where its first node is found, and how many it has */
    float      min[3], max[3];           /* its volume: metres along the axes of light space (light_space in stream_choose.c) */
    page_state state;
    uint32_t   place;             /* its first word in the array; COMING and HERE */
    float      rank;              /* distance, less for those that are here or coming; FLT_MAX: not wanted */
    uint32_t   kept;              /* the last frame in which it was among the nearest that fit */
    uint32_t   attempts, next_at; /* reads that failed, and the frame from which on it is tried again */
} stream_page;

typedef enum request_state {
    REQUEST_FREE,
    REQUEST_QUEUED,  /* for a thread to take */
    REQUEST_WORKING, /* a thread has it in hand */
    REQUEST_PENDING, /* the caller reads */
    REQUEST_DONE,    /* for the next frame */
} request_state;

struct vxs_stream_request {
    vxs_stream   *stream;
    request_state state;
    uint32_t      page, order;         /* order: of asking */
    uint8_t      *buffer;              /* [buffer_bytes] NULL where bytes are in memory */
    int           asked, answered, ok; /* the read: was called, has ended, and how */
    int           decoded, finding;
};

typedef struct stream_tools {
    vxs_stream    *stream;
    vxs_page_tools decode;
    vxs_page_node *nodes; /* [nodes_max] */
    int            busy;  /* submitted to the caller's threads */
    os_thread      thread;
} stream_tools;

typedef struct stream_source {
    const uint8_t *bytes;
    int            is_file;
    os_file        file;
    vxs_stream_answer (*read)(void *user, uint64_t offset, uint32_t size_bytes, void *buffer, vxs_stream_request *request);
    void    *user;
    uint64_t size_bytes;
    uint64_t bytes_read; /* by open; then counted by frames */
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
    uint32_t  word_count, room_first, room_end; /* of the array; the room is words room_first..room_end - 1 */
    uint32_t *in_room;                          /* [in_room_count] pages that have a place, in its order */
    uint32_t  in_room_count;

    uint32_t *heap; /* [page_count] */
    vxs_stream_range
        *changes; /* [page_count + 4 * request_count]: a page leaves once a frame, and two words.. appear of each request, twice */
    uint32_t change_count;
    uint32_t frame, wanted, heap_count;

    stream_tools       *tools;                    /* [tool_count] */
    uint32_t            tool_count, thread_count; /* threads that were started */
    vxs_stream_request *requests;                 /* [request_count] */
    uint32_t            request_count, buffer_bytes, nodes_max, order;
    os_mutex            lock;
    os_signal           work, rest;        /* something is queued, or all is to end; something has ended */
    int                 can_work, closing; /* lock and signals are there; all is to end */

    vxs_stream_status status; /* counts of this frame, and since open */
};

/* stream_source.c */
vxs_result        vxs_stream_source_open(stream_source *source, const vxs_stream_desc *desc);
void              vxs_stream_source_close(stream_source *source);
vxs_stream_answer vxs_stream_source_read(const stream_source *source, uint64_t offset, uint32_t size_bytes, void *buffer,
                                         vxs_stream_request *request);

/* stream_choose.c: the volume of a page, from squares of its light's maps; all ranks; the pages to keep. */
void vxs_stream_page_add_square(stream_page *page, const vxs_light *light, uint32_t map, uint32_t x, uint32_t y, uint32_t bounds);
void vxs_stream_rank_pages(vxs_stream *s, const vxs_stream_focus *foci, uint32_t count);
/* Take the next nearest page from the heap that vxs_stream_rank_pages made. 0: none is left. */
int  vxs_stream_next_nearest(vxs_stream *s, uint32_t *page);

/* stream_room.c */
uint32_t vxs_stream_room_words(const stream_page *page);
/* Find a place for a page, and have others leave for it. 0: there is none. */
int      vxs_stream_room_take(vxs_stream *s, uint32_t page);
void     vxs_stream_room_give_back(vxs_stream *s, uint32_t page);
void     vxs_stream_show(vxs_stream *s, uint32_t page, int there);

/* stream_work.c */
int                 vxs_stream_work_start(vxs_stream *s);
void                vxs_stream_work_end(vxs_stream *s);
/* Whether there is a request left; ask for a page that has a place. */
int                 vxs_stream_can_ask(vxs_stream *s);
void                vxs_stream_ask(vxs_stream *s, uint32_t page);
/* Decode up to so many pages that are asked for, here and now. */
void                vxs_stream_work_here(vxs_stream *s, uint32_t count);
/* The next request that is done, to be released; NULL: none is. */
vxs_stream_request *vxs_stream_next_done(vxs_stream *s);
void                vxs_stream_release(vxs_stream_request *request);

#endif
