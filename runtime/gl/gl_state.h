/* The object of vxs_gl.h, and what its files share. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef GL_STATE_H
#define GL_STATE_H

#include "gl_api.h"
#include "vxs_gl.h"

/* An array of 32-bit words on the graphics processor: a buffer, or a texture whose rows are a power of two wide. */
typedef struct gl_words {
    gl_name  name;
    uint32_t count; /* words; texels are of `lanes` words */
    uint32_t wide;  /* texture: texels in a row */
    uint32_t lanes; /* texture: 1, or 4 */
} gl_words;

/* Words that are to be uploaded. */
typedef struct gl_range {
    const uint32_t *words;
    uint32_t        first, count;
} gl_range;

/* A page of a stream. */
typedef struct gl_page {
    uint32_t light, page;
} gl_page;

struct vxs_gl {
    gl_api        api;
    vxs_allocator memory;
    int           is_es, version; /* 430, 310 */
    int           is_texture;
    uint32_t      first_binding;

    vxs_gl_light        *lights;    /* [light_count] */
    vxs_light_constants *constants; /* [light_count] */
    uint32_t            *smoke; /* [light_count] where each light's smoke starts among the words; 0: it has none. NULL: none has */
    uint32_t             smoke_word; /* where that table lies among the words */
    uint32_t             light_count;
    gl_words             words, rows, lists; /* rows: the lights' constants. lists: name 0 until there are some */

    gl_range *ranges; /* [range_capacity] a ring: range_count from range_first on are to be uploaded */
    uint32_t  range_first, range_count, range_capacity;
    uint64_t  bytes_left, bytes_uploaded;

    const vxs_stream *stream;      /* NULL: there is none, and nothing of the following */
    gl_page          *pages;       /* [page_count] of all lights */
    uint32_t         *names;       /* [page_count] as the graphics processor has them */
    uint32_t          page_count;
    uint32_t          coming;      /* the page that is uploaded next, or in part */
    uint32_t          coming_name; /* in part: its name by then; 0: no word of it is uploaded */
    uint32_t          coming_done; /* words */

    gl_name culling; /* the program; 0 until it is asked for */
    char    head[512];
};

/* Make room.   Returns 0 when the context has none; then there is nothing to delete. */
int vxs_gl_words_make(const vxs_gl *gl, gl_words *w, uint64_t count, uint32_t lanes, uint32_t wide);

void vxs_gl_words_delete(const vxs_gl *gl, gl_words *w);

/* Upload words [first, first + count). */
void vxs_gl_words_write(const vxs_gl *gl, const gl_words *w, const uint32_t *words, uint32_t first, uint32_t count);

/* As uniform `name` of a program, or as a storage buffer, this is number `place` from first_binding on. */
void vxs_gl_words_bind(const vxs_gl *gl, const gl_words *w, uint32_t place);

void *vxs_gl_take(const vxs_gl *gl, uint64_t count, size_t size);
void  vxs_gl_give_back(const vxs_gl *gl, void *memory, uint64_t count, size_t size);

/* gl_stream.c: lights of a stream and how many words it has; what is resident, to be uploaded; then what has changed, as vxs_gl_upload says.
 * room_words  that may be uploaded beside names that are taken away.   Returns the bytes that are left */
uint32_t   vxs_gl_stream_lights(vxs_gl *gl);
vxs_result vxs_gl_stream_put(vxs_gl *gl);
void       vxs_gl_stream_take_away(vxs_gl *gl);
uint64_t   vxs_gl_stream_upload(vxs_gl *gl, size_t room_words);

/* The texts of shaders (made by the Makefile from the files of these names). */
extern const char vxs_gl_text_words_glsl[], vxs_gl_text_smoke_lights_glsl[], vxs_gl_text_cull_glsl[], vxs_gl_text_vxs_lookup_h[],
    vxs_gl_text_vxs_lookup_blocks_h[], vxs_gl_text_vxs_space_h[], vxs_gl_text_vxs_cull_h[];

#endif
