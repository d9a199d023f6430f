/* Streaming: lookups in a level that is larger than the memory it is given. Beside vxs.h, whose lookups answer all along.
 *
 *     vxs_stream_desc desc = {.struct_size = sizeof desc, .path = "level.vxs", .budget_bytes = 4 << 20, .threads = 1};
 *     vxs_stream     *stream;
 *     if (vxs_stream_open(&stream, &desc) != VXS_OK) ...
 *     const vxs_baked_light *sun = vxs_stream_light(stream, 0);
 *     for each frame:
 *         vxs_stream_focus eye = vxs_stream_camera(position_ws, 200);
 *         vxs_stream_frame(stream, &eye, 1, NULL);                  // what has come appears, what is wanted is asked for
 *         float lit = vxs_lookup(sun, position_ws, normal_ws, 9);   // any thread
 *     vxs_stream_close(stream);
 *
 * Open reads what all lookups need: the resident part of each light, with its coarse level. Lights of palette blocks have pages besides,
 * which come by distance and leave by least recent use; where one is missing, answers are the coarse level's (formats/vxs.md 13.1), for
 * all taps of a filter at once, and vxs_lookup_is_full says so. A light that is a DAG has no pages: all of it is read by open.
 * So is baked smoke of lights that have some: always there, and vxs_smoke_lookup says what it says of the file opened whole.
 *
 * **Frames.** Which pages are there changes in vxs_stream_frame and nowhere else. During that call nobody may look up; at any other time
 * any number of threads may, while pages are read and decoded where no lookup goes.
 *
 * **Memory.** Everything that a stream holds is one block, taken by open from the allocator and never more than the budget: bookkeeping,
 * what threads decode by (0.4 MiB each, 0.15 where pages are packed fast), buffers for reads, and the words of lights and of their
 * smoke. While open works it takes some more besides for the directory, for metadata and for points, within the budget too. Not counted
 * are the contexts of zstd, some 160 KiB for each thread that decodes, and stacks of threads. After open nothing is allocated.
 *
 * **Words.** The words of all lights lie in one array, resident parts first, then smoke, pages behind them, so that a GPU's copy is one
 * buffer or texture: vxs_gl.h keeps one. By hand, upload it once, and after each frame the ranges that vxs_stream_changes names.
 *
 * A stream keeps no global state and never prints. Bytes may be hostile: all are checked before they are looked up.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_STREAM_H
#define VXS_STREAM_H

#include "vxs.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct vxs_stream         vxs_stream;
typedef struct vxs_stream_request vxs_stream_request;

/* What a callback that reads has done. */
typedef enum vxs_stream_answer {
    VXS_STREAM_FAILED  = 0, /* the bytes cannot be had now: they will be asked for again, later and later */
    VXS_STREAM_READ    = 1, /* they are in the buffer */
    VXS_STREAM_PENDING = 2, /* vxs_stream_read_done will say so */
} vxs_stream_answer;

/* What happened to a page that could not be had.
 * light, page  numbers: of the stream's light, and of the page in it
 * result       VXS_E_READ: its bytes could not be read; it is tried again, up to VXS_STREAM_ATTEMPTS times, 8, 16, 32.. frames later;
 *              VXS_E_CORRUPT: they break a rule. It is not tried again until vxs_stream_retry
 * finding      of a corrupt one, its number in vxs_findings.h: 503 to 505; else 0 */
typedef void vxs_stream_failed_fn(void *user, uint32_t light, uint32_t page, vxs_result result, int finding);

enum { VXS_STREAM_ATTEMPTS = 6, VXS_STREAM_THREADS_MAX = 16, VXS_STREAM_REQUESTS_MAX = 64 };

/* Zero it, set struct_size, one of three sources, and a budget. Copied but for what it points to. */
typedef struct vxs_stream_desc {
    size_t struct_size; /* sizeof(vxs_stream_desc), as the caller knows it; 0: up to and with failed_user */

    const char *path;       /* a file; read by position, so that threads share it */
    const void *bytes;      /* [size_bytes] in memory; borrowed until vxs_stream_close, never copied */
    uint64_t    size_bytes; /* of the file, where it is not `path` */
    /* Read size_bytes from offset on into a buffer. Called by threads that decode, one call for each request at a time, so by several at
     * once; while open works, by the caller's thread and with a request that is NULL: then PENDING is FAILED. */
    vxs_stream_answer (*read)(void *user, uint64_t offset, uint32_t size_bytes, void *buffer, vxs_stream_request *request);
    void *read_user;

    uint64_t budget_bytes; /* see above */

    uint32_t
        threads; /* own ones that read and decode; 0: vxs_stream_frame does, or submit's threads. Up to VXS_STREAM_THREADS_MAX */
    /* Have run(job) called once, soon, on any thread of the caller's; `threads` jobs at once at most, one if that is 0. NULL: not used */
    void (*submit)(void *user, void (*run)(void *job), void *job);
    void *submit_user;
    uint32_t
        requests; /* pages that are read or decoded at once; 0: one more than threads. Each has a buffer unless bytes are in memory */
    uint32_t decodes_per_frame; /* without threads and submit: pages that a frame decodes at most; 0: 1 */

    const vxs_allocator  *allocator;   /* NULL: malloc and free; copied */
    const char *const    *light_names; /* [light_name_count] lights that are opened, in this order; NULL: all */
    uint32_t              light_name_count;
    vxs_finding_fn       *finding; /* what was wrong when open failed; NULL: nobody asks */
    void                 *finding_user;
    vxs_stream_failed_fn *failed; /* called in vxs_stream_frame; NULL: nobody asks */
    void                 *failed_user;
    /* Called by open with the file's metadata, if it has any: JSON text, gone when the call returns. NULL: it is left as it lies in the file */
    void (*metadata)(void *user, const char *text, size_t size_bytes);
    void *metadata_user;
    /* Called by open with points of what casts, if the file has any, gone when the call returns. NULL: they are not read */
    void (*points)(void *user, const vxs_baked_points *points);
    void *points_user;
} vxs_stream_desc;

/* Open a file: header, directory, table of lights, and of each light that is wanted its resident part, its table of pages and its smoke.
 * Smoke is read twice, since how much room it takes is seen only inside.
 * stream  [out] NULL on failure
 * Returns VXS_OK; VXS_E_ARGUMENT: not one source, too many threads or requests, no light of a name, a struct_size as for vxs_read;
 * VXS_E_READ; VXS_E_MEMORY: no memory, or more is needed than the budget (then finding 211); VXS_E_NOT_VXS and others as vxs_asset_open.
 * A budget that has no room for any page is enough: all answers are coarse. */
vxs_result vxs_stream_open(vxs_stream **stream, const vxs_stream_desc *desc);

/* Waits until no request is under way; those of a callback that are pending have to be done by another thread, or before. Accepts NULL. */
void vxs_stream_close(vxs_stream *stream);

uint32_t vxs_stream_light_count(const vxs_stream *stream);

/* Light `index`, in file order or that of light_names; NULL when there are fewer. Valid until vxs_stream_close. Its word_count is that of its
 * resident part; pages lie behind those of all lights. It has no parts. */
const vxs_baked_light *vxs_stream_light(const vxs_stream *stream, uint32_t index);

/* The light of a name, or NULL; of no name, NULL. */
const vxs_baked_light *vxs_stream_find_light(const vxs_stream *stream, const char *name);

/* What baked smoke leaves of light `index`, for vxs_smoke_lookup; NULL where it has none. Valid until vxs_stream_close, during frames,
 * too. Among the words of all lights it starts at number smoke->words - vxs_stream_words(stream, &count). */
const vxs_baked_smoke *vxs_stream_smoke(const vxs_stream *stream, uint32_t index);

/* Where lookups will be: a box in world space, metres; of a camera both ends are its position. One with a number that is not finite, or of
 * which an end is beyond the other, asks for nothing. */
typedef struct vxs_stream_focus {
    double min_ws[3], max_ws[3];
    double radius_metres; /* pages whose volume is farther from the box are not wanted; 0: all are */
    double weight;        /* above 0: distances are divided by it, so that twice the weight is half as far; 0: 1 */
} vxs_stream_focus;

static inline vxs_stream_focus vxs_stream_camera(const double position_ws[3], double radius_metres)
{
    vxs_stream_focus f = {{position_ws[0], position_ws[1], position_ws[2]}, {position_ws[0], position_ws[1], position_ws[2]}, 0, 0};
    f.radius_metres    = radius_metres;
    return f;
}

/* Counts are of now, unless they say since when. struct_size: as the caller knows it; 0: up to and with `left` */
typedef struct vxs_stream_status {
    size_t   struct_size;
    uint64_t bytes_held;     /* all of it: the block. Never more than the budget */
    uint64_t bytes_resident; /* of it, words of resident parts, of smoke, and of pages that are there */
    uint64_t bytes_room;     /* of it, room for pages */
    uint64_t bytes_read;     /* since open began */
    uint32_t pages;          /* of all lights */
    uint32_t pages_resident;
    uint32_t pages_wanted;                   /* within the radius of a focus */
    uint32_t pages_missing;                  /* of these: not there */
    uint32_t pages_coming;                   /* being read or decoded */
    uint32_t pages_failed;                   /* that are not asked for, or not yet */
    uint32_t reads, decodes, appeared, left; /* pages, in this frame or since the last one */
} vxs_stream_status;

/* The frame boundary: pages that have come appear, pages that have to make room disappear, and what is wanted and missing is asked for, the
 * nearest first. A page stays while it is among the nearest that fit, and one of equal distance does not replace it.
 * foci    [count] may be none: then nothing new is asked for
 * status  [out] or NULL
 * Returns VXS_OK; VXS_E_ARGUMENT: a struct_size that no version had, or no foci where count says some, and nothing is done. Without threads it reads and decodes, too. Threads: nobody else looks up,
 * or calls anything but vxs_stream_read_done, during the call. */
vxs_result vxs_stream_frame(vxs_stream *stream, const vxs_stream_focus *foci, uint32_t count, vxs_stream_status *status);

/* A read that was pending has ended; the request is forgotten. Any thread. ok: 0: it failed */
void vxs_stream_read_done(vxs_stream_request *request, int ok);

/* Wait until no page is being read or decoded: behind a loading screen call this and vxs_stream_frame in turn until no page is missing. Without
 * threads it returns at once. */
void vxs_stream_wait(vxs_stream *stream);

/* Ask again for pages that failed, corrupt ones too. Between frames, as vxs_stream_frame. */
void vxs_stream_retry(vxs_stream *stream);

/* The array of all words, [*count]; of light n, the words start at number vxs_stream_first_word(stream, n), what vxs_light_constants_of asks
 * for. */
const uint32_t *vxs_stream_words(const vxs_stream *stream, uint32_t *count);
uint32_t        vxs_stream_first_word(const vxs_stream *stream, uint32_t light);

typedef struct vxs_stream_range {
    uint32_t first_word, word_count;
} vxs_stream_range;

/* Where the names of a light's pages lie among all words, a word a page: 0 while it is not there. None of a light that is a DAG. */
vxs_stream_range vxs_stream_names(const vxs_stream *stream, uint32_t light);

/* The words of page n of those; none while it is not there. */
vxs_stream_range vxs_stream_page(const vxs_stream *stream, uint32_t light, uint32_t page);

/* Words that the last frame changed, [*count] ranges, for a copy to follow; valid until the next one. */
const vxs_stream_range *vxs_stream_changes(const vxs_stream *stream, uint32_t *count);

#ifdef __cplusplus
}
#endif
#endif
