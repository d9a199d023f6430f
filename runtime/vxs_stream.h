/* Streaming: lookups in a level larger than the memory available for it. Used with vxs.h, whose lookups work at any time.
 *
 *     vxs_stream_desc desc = {.struct_size = sizeof desc, .path = "level.vxs", .budget_bytes = 4 << 20, .threads = 1};
 *     vxs_stream     *stream;
 *     if (vxs_stream_open(&stream, &desc) != VXS_OK) ...
 *     const vxs_baked_light *sun = vxs_stream_light(stream, 0);
 *     for each frame:
 *         vxs_stream_focus eye = vxs_stream_camera(position_ws, 200);
 *         vxs_stream_frame(stream, &eye, 1, NULL);                  // decoded pages appear, missing pages are requested
 *         float lit = vxs_lookup(sun, position_ws, normal_ws, vxs_box(9));   // any thread
 *     vxs_stream_close(stream);
 *
 * Open reads the data that all lookups need: the resident part of each light, with its coarse level. Lights of palette blocks
 * also have pages. They are loaded in order of distance and evicted by least recent use. Where a page is missing, all taps of a
 * filter give the coarse answer (formats/vxs.md 13.1), and vxs_lookup_is_full returns 0. A light that is a DAG has no pages: open
 * reads all of it. Baked smoke is always resident too, so vxs_smoke_lookup returns the same as with the whole file open.
 *
 * **Frames.** The set of present pages changes in vxs_stream_frame only. No thread may do lookups during that call; at any other
 * time any number of threads may. Pages are read and decoded into memory that lookups do not read.
 *
 * **Memory.** A stream holds one block, allocated by open and never larger than the budget: bookkeeping, decoding memory of
 * threads (0.6 MiB each, 0.15 MiB where pages are packed fast), read buffers, and the words of lights and smoke. During open the
 * directory, metadata and points take more, also within the budget. Not counted are zstd contexts, about 160 KiB for each
 * decoding thread, and thread stacks. After open nothing is allocated.
 *
 * **Words.** The words of all lights are in one array: resident parts, then smoke, then pages. So the GPU's copy is one buffer or
 * texture; vxs_gl.h maintains one. To maintain it yourself, upload the array once, and after each frame the ranges of
 * vxs_stream_changes.
 *
 * A stream has no global state and never prints. The bytes may be hostile: all are checked before lookups use them.
 * Public.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_STREAM_H
#define VXS_STREAM_H

#include "vxs.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct vxs_stream         vxs_stream;
typedef struct vxs_stream_request vxs_stream_request;

/* Result of a read callback. */
typedef enum vxs_stream_answer {
    VXS_STREAM_FAILED  = 0, /* the bytes are not available now; they are requested again, after longer and longer waits */
    VXS_STREAM_READ    = 1, /* the bytes are in the buffer */
    VXS_STREAM_PENDING = 2, /* vxs_stream_read_done will be called when the read has ended */
} vxs_stream_answer;

/* Called when a page could not be loaded.
 * light, page  index of the stream's light, and of the page in it
 * result       VXS_E_READ: its bytes could not be read. It is tried again, VXS_STREAM_ATTEMPTS times in all, 8, 16, 32.. frames
 *              later. VXS_E_CORRUPT: its bytes are invalid. It is not tried again until vxs_stream_retry
 * finding      number in vxs_findings.h for a corrupt page: 503 to 505; else 0 */
typedef void vxs_stream_failed_fn(void *user, uint32_t light, uint32_t page, vxs_result result, int finding);

enum { VXS_STREAM_ATTEMPTS = 6, VXS_STREAM_THREADS_MAX = 16, VXS_STREAM_REQUESTS_MAX = 64 };

/* Zero it, then set struct_size, one of the three sources, and a budget. It is copied, but not what it points to. */
typedef struct vxs_stream_desc {
    size_t struct_size; /* the caller's sizeof(vxs_stream_desc); 0: up to and including failed_user */

    const char *path;       /* a file, UTF-8; read by position, so that threads share it */
    const void *bytes;      /* [size_bytes] in memory; borrowed until vxs_stream_close, never copied */
    uint64_t    size_bytes; /* of the file, for sources other than `path` */
    /* Read size_bytes at offset into a buffer. Called by the threads that decode, once at a time for each request, so several
     * calls may run at once. Open calls it on the caller's thread with request NULL; then PENDING counts as FAILED. */
    vxs_stream_answer (*read)(void *user, uint64_t offset, uint32_t size_bytes, void *buffer, vxs_stream_request *request);
    void *read_user;

    uint64_t budget_bytes; /* see **Memory** above */

    uint32_t
        threads; /* own threads, which read and decode; 0: vxs_stream_frame or submit's threads do. Up to VXS_STREAM_THREADS_MAX */
    /* Call run(job) once, soon, on any thread of the caller. At most `threads` jobs at once, or 1 if that is 0. NULL: not used */
    void (*submit)(void *user, void (*run)(void *job), void *job);
    void    *submit_user;
    uint32_t requests; /* pages read or decoded at once; 0: threads + 1. Each has a buffer unless the bytes are in memory */
    uint32_t decodes_per_frame; /* without threads and submit: most pages that a frame decodes; 0: 1 */

    const vxs_allocator  *allocator;   /* NULL: malloc and free; copied */
    const char *const    *light_names; /* [light_name_count] lights to open, in this order; NULL: all */
    uint32_t              light_name_count;
    vxs_finding_fn       *finding; /* why open failed; NULL: not wanted */
    void                 *finding_user;
    vxs_stream_failed_fn *failed; /* called in vxs_stream_frame; NULL: not wanted */
    void                 *failed_user;
    /* Called by open with the file's metadata, if any: JSON text, valid during the call. NULL: metadata is not read */
    void (*metadata)(void *user, const char *text, size_t size_bytes);
    void *metadata_user;
    /* Called by open with points on casters, if any, valid during the call. NULL: points are not read */
    void (*points)(void *user, const vxs_baked_points *points);
    void *points_user;
} vxs_stream_desc;

/* Open a file: reads header, directory, table of lights, and for each wanted light its resident part, page table and smoke. Smoke
 * is read twice, because its size is known only from its content.
 * stream  [out] NULL on failure
 * Returns VXS_OK; VXS_E_ARGUMENT: not exactly one source, too many threads or requests, an unknown light name, an invalid
 * struct_size as for vxs_read; VXS_E_NO_FILE, VXS_E_READ; VXS_E_MEMORY: out of memory, or the budget is too small (then finding 211);
 * VXS_E_NOT_VXS and others as vxs_asset_open. A budget without room for any page is valid: then all answers are coarse. */
vxs_result vxs_stream_open(vxs_stream **stream, const vxs_stream_desc *desc);

/* Waits until no request is in progress. Pending reads of a callback must be completed before, or by another thread. Accepts
 * NULL. */
void vxs_stream_close(vxs_stream *stream);

uint32_t vxs_stream_light_count(const vxs_stream *stream);

/* Returns light `index`, in file order or that of light_names; NULL when index is not below the light count. Valid until
 * vxs_stream_close. Its word_count covers its resident part; pages are behind the resident parts of all lights. Its part_count is
 * 0. */
const vxs_baked_light *vxs_stream_light(const vxs_stream *stream, uint32_t index);

/* Returns the light with this name; NULL when there is none or name is NULL. */
const vxs_baked_light *vxs_stream_find_light(const vxs_stream *stream, const char *name);

/* Returns the baked smoke of light `index`, for vxs_smoke_lookup; NULL when it has none. Valid until vxs_stream_close, also
 * during frames. Its index in the array of all words is smoke->words - vxs_stream_words(stream, &count). */
const vxs_baked_smoke *vxs_stream_smoke(const vxs_stream *stream, uint32_t index);

/* Where lookups will be: a box in world space, metres. For a camera both ends are its position. A box with a number that is not
 * finite, or with min above max, requests nothing. */
typedef struct vxs_stream_focus {
    double min_ws[3], max_ws[3];
    double radius_metres; /* pages whose volume is farther from the box are not wanted; 0: no limit */
    double weight;        /* above 0: distances are divided by it: weight 2 halves them; 0: 1 */
} vxs_stream_focus;

static inline vxs_stream_focus vxs_stream_camera(const double position_ws[3], double radius_metres)
{
    vxs_stream_focus f = {{position_ws[0], position_ws[1], position_ws[2]}, {position_ws[0], position_ws[1], position_ws[2]}, 0, 0};
    f.radius_metres    = radius_metres;
    return f;
}

/* Current counts, except where noted. struct_size: the caller's sizeof(vxs_stream_status); 0: up to and including `left` */
typedef struct vxs_stream_status {
    size_t   struct_size;
    uint64_t bytes_held;     /* size of the block; never more than the budget */
    uint64_t bytes_resident; /* of these, words of resident parts, smoke, and present pages */
    uint64_t bytes_room;     /* of these, room for pages */
    uint64_t bytes_read;     /* read since open began */
    uint32_t pages;          /* of all lights */
    uint32_t pages_resident;
    uint32_t pages_wanted;                   /* within the radius of a focus */
    uint32_t pages_missing;                  /* of the wanted pages: not present */
    uint32_t pages_coming;                   /* being read or decoded */
    uint32_t pages_failed;                   /* failed pages: not requested again, or not yet */
    uint32_t reads, decodes, appeared, left; /* pages, in this frame or since the last one */
} vxs_stream_status;

/* Frame boundary: decoded pages appear, pages that must make room disappear, and missing pages are requested, the nearest first.
 * A page stays while it is among the nearest that fit; a page at equal distance does not replace it.
 * foci    [count]; 0: nothing new is requested
 * status  [out] or NULL
 * Returns VXS_OK; VXS_E_ARGUMENT: a struct_size that no version had, or foci NULL with count above 0; then nothing is done.
 * Without threads and submit it also reads and decodes. Threads: during the call no other thread may do lookups or call any
 * function of the stream except vxs_stream_read_done. */
vxs_result vxs_stream_frame(vxs_stream *stream, const vxs_stream_focus *foci, uint32_t count, vxs_stream_status *status);

/* Report the end of a pending read; the request is invalid afterwards. Any thread. ok: 0: the read failed */
void vxs_stream_read_done(vxs_stream_request *request, int ok);

/* Wait until no page is being read or decoded. Behind a loading screen call this and vxs_stream_frame in turn until no page is
 * missing. Without threads and submit it returns at once. */
void vxs_stream_wait(vxs_stream *stream);

/* Request failed pages again, also corrupt ones. Call it between frames, with the same thread rules as vxs_stream_frame. */
void vxs_stream_retry(vxs_stream *stream);

/* Returns the array of all words, [*count]. The words of light n start at index vxs_stream_first_word(stream, n): the first_word
 * of vxs_light_constants_of. */
const uint32_t *vxs_stream_words(const vxs_stream *stream, uint32_t *count);
uint32_t        vxs_stream_first_word(const vxs_stream *stream, uint32_t light);

typedef struct vxs_stream_range {
    uint32_t first_word, word_count;
} vxs_stream_range;

/* Returns the range of the names of a light's pages in the array of all words: one word for each page, 0 while the page is
 * missing. Empty for a DAG. */
vxs_stream_range vxs_stream_names(const vxs_stream *stream, uint32_t light);

/* Returns the words of page `page` of a light; empty while it is missing. */
vxs_stream_range vxs_stream_page(const vxs_stream *stream, uint32_t light, uint32_t page);

/* Returns the words changed by the last frame, [*count] ranges, for updating a copy; valid until the next frame. */
const vxs_stream_range *vxs_stream_changes(const vxs_stream *stream, uint32_t *count);

#ifdef __cplusplus
}
#endif
#endif
