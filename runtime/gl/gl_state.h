/* The vxs_gl object, and functions shared by its files. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef GL_STATE_H
#define GL_STATE_H

#include "gl_api.h"
#include "gl_tables.h"
#include "vxs_gl.h"

/* An array of 32-bit words on the GPU: a buffer, or a texture whose row length is a power of two for words. */
typedef struct gl_words {
    gl_name  name;
    uint32_t count; /* words; a texel has `lanes` words */
    uint32_t wide;  /* texture: texels in a row */
    uint32_t lanes; /* texture: 1, or 4 */
} gl_words;

/* Words in the upload queue. */
typedef struct gl_range {
    const uint32_t *words;
    uint32_t        first, count;
} gl_range;

/* A page of a stream. The rest is for tables. */
typedef struct gl_page {
    uint32_t light, page;
    uint32_t first_square, square_count;
    uint32_t first_word, word_count; /* of its tables on the GPU. 0: there are none, because no gap had word_count words */
} gl_page;

/* Room for tables, for each word that they are made of. They take 4 to 5.5, in the scenes that were measured. */
enum { TABLES_PER_WORD = 8 };

struct vxs_gl {
    gl_api        api;
    vxs_allocator memory;
    vxs_log_fn   *log;
    void         *user;
    int           is_es, version; /* such as 430, 310 */
    int           is_texture;
    uint32_t      first_binding;

    vxs_gl_light        *lights;     /* [light_count] */
    vxs_light_constants *constants;  /* [light_count] */
    uint32_t            *smoke;      /* [light_count] first word of each light's smoke, 0: none; NULL: no light has smoke */
    uint32_t             smoke_word; /* first word of that table */
    uint32_t             light_count;
    gl_words             words, rows, lists; /* rows: the lights' constants. lists: name 0 before the first lists */

    gl_range *ranges; /* [range_capacity] ring buffer: upload queue of range_count ranges from range_first on */
    uint32_t  range_first, range_count, range_capacity;
    uint64_t  bytes_left, bytes_uploaded;

    const vxs_stream *stream; /* NULL: none, and the following fields are unused */
    gl_page          *pages;  /* [page_count] of all lights */
    uint32_t         *names;  /* [page_count] names as uploaded to the GPU */
    uint32_t          page_count;
    uint32_t          coming;      /* page that is uploaded next, or is partly uploaded */
    uint32_t          coming_name; /* partly uploaded: its name at that time; 0: none of its words is uploaded */
    uint32_t          coming_done; /* words of it uploaded so far */

    gl_tables tables;      /* until they are uploaded; then they have no words. Of a stream: those of a page */
    uint32_t  table_count; /* words of all tables, or for them; 0: shaders read words alone */

    uint32_t  *tops;                   /* [top_count] of a stream: the tops of all lights, at top_word among all words */
    uint32_t   top_word, top_count;    /* behind them is the room for tables of pages */
    uint32_t   tops_first, tops_end;   /* range to be uploaded again */
    uint32_t   room_first, room_count; /* index among all words */
    uint32_t  *placed;                 /* [placed_count] pages with tables on the GPU, by first_word */
    uint32_t   placed_count;
    gl_square *squares; /* [square_count] of all pages, page by page */
    uint32_t   square_count;
    uint32_t   coming_squares; /* squares of the page that is uploaded next whose tables are made */
    int        said_no_room;

    gl_name culling; /* compute program; 0 before first use */
    char    head[512];
};

/* Report why a function fails, and the remedy. Returns r. */
vxs_result vxs_gl_fail(const vxs_gl *gl, vxs_result r, const char *text);

/* Allocate an array on the GPU. Returns 0 when that fails; then there is nothing to delete. */
int vxs_gl_words_make(const vxs_gl *gl, gl_words *w, uint64_t count, uint32_t lanes, uint32_t wide);

void vxs_gl_words_delete(const vxs_gl *gl, gl_words *w);

/* Upload words [first, first + count). */
void vxs_gl_words_write(const vxs_gl *gl, const gl_words *w, const uint32_t *words, uint32_t first, uint32_t count);

/* Bind an array: as texture at unit, or storage buffer at binding, first_binding + place. */
void vxs_gl_words_bind(const vxs_gl *gl, const gl_words *w, uint32_t place);

/* Read the first words of a buffer: valid until vxs_gl_words_unmap. Returns NULL on failure; then there is nothing to unmap. */
const uint32_t *vxs_gl_words_map(const vxs_gl *gl, const gl_words *w, uint32_t count);
void            vxs_gl_words_unmap(const vxs_gl *gl);

typedef struct gl_rectangle {
    int x, y, wide, high;
} gl_rectangle;

/* Make a square depth texture of 16 or 32 bits, as vxs_gl_depth_texture describes it. Returns 0 on failure. */
gl_name vxs_gl_depths_make(const vxs_gl *gl, uint32_t side_px, uint32_t bits);

/* Write depths, rows without gaps, whose size is a multiple of 4 bytes or which are one row.
 * buffer  0: depths is a pointer; else a place in this buffer */
void vxs_gl_depths_write(const vxs_gl *gl, gl_name texture, uint32_t bits, gl_rectangle to, gl_name buffer, const void *depths);

/* Compile a compute program behind the texts of vxs_gl_texts; more lines of its head come before them.
 * texts  [count]
 * Returns 0 when that fails, which is reported (vxs_gl_fail). */
gl_name vxs_gl_compute(const vxs_gl *gl, const char *head, const char *const *texts, int count);

/* Whether vxs_gl_compute can be used: storage buffers and the functions of compute shaders. */
int vxs_gl_can_compute(const vxs_gl *gl);

/* The state that a compute pass changes. */
typedef struct gl_pass {
    int program, unit, texture, sampler;
} gl_pass;

/* Use a program with a depth texture at unit 0, which is free because words are in a buffer; and restore the state. */
gl_pass vxs_gl_begin_pass(const vxs_gl *gl, gl_name program, gl_name depths);
void    vxs_gl_end_pass(const vxs_gl *gl, const gl_pass *pass);

/* Set the uniforms of view.glsl. */
void vxs_gl_set_view(const vxs_gl *gl, gl_name program, const vxs_view *view);

/* Bind a buffer to a storage buffer binding. */
void vxs_gl_words_bind_at(const vxs_gl *gl, const gl_words *w, uint32_t binding);

void *vxs_gl_alloc(const vxs_gl *gl, uint64_t count, size_t size);
void  vxs_gl_free(const vxs_gl *gl, void *memory, uint64_t count, size_t size);

/* Queue words for upload. */
vxs_result vxs_gl_put_words(vxs_gl *gl, const uint32_t *words, uint32_t first, uint32_t count);

/* Returns the greatest number of words of tables: what the caller wants, and what fits into one buffer beside other words.
 * standard  if the caller has no wish;   others  number of the other words */
uint32_t vxs_gl_most_table_words(const vxs_gl *gl, const vxs_gl_desc *desc, uint64_t standard, uint64_t others);

/* Returns the most words that smoke of all lights takes, with its table. */
uint64_t vxs_gl_smoke_words(const vxs_gl *gl, const vxs_gl_desc *desc);

/* gl_whole.c: vxs_gl_whole_lights makes tables, fills the lights, and counts the words of both; vxs_gl_whole_put queues them. */
vxs_result vxs_gl_whole_lights(vxs_gl *gl, const vxs_gl_desc *desc, uint64_t *words);
vxs_result vxs_gl_whole_put(vxs_gl *gl, const vxs_gl_desc *desc);

/* gl_stream.c: vxs_gl_stream_lights fills the lights and returns the stream's word count; vxs_gl_stream_put queues the resident
 * words; vxs_gl_stream_detach and vxs_gl_stream_upload apply page changes, as described at vxs_gl_upload.
 * room_words  most words to upload, not counting what hides pages
 * vxs_gl_stream_upload returns the number of bytes left. */
uint32_t   vxs_gl_stream_lights(vxs_gl *gl);
vxs_result vxs_gl_stream_put(vxs_gl *gl);
void       vxs_gl_stream_detach(vxs_gl *gl);
uint64_t   vxs_gl_stream_upload(vxs_gl *gl, size_t room_words);

/* gl_stream_tables.c. vxs_gl_stream_tables_lights: if there will be tables, set table_count, and place DAGs.
 * words  of the stream;   returns the word count of DAGs, or `words` */
uint64_t vxs_gl_stream_tables_lights(vxs_gl *gl, const vxs_gl_desc *desc, uint64_t words);

/* Place the other lights, which begin with their tops, and room, behind `words` words. Returns the new word count. */
uint64_t vxs_gl_stream_tables_place(vxs_gl *gl, uint64_t words);

/* List the squares of pages, and queue DAGs and tops. */
vxs_result vxs_gl_stream_tables_put(vxs_gl *gl);

/* Begin the tables of a page in gl->tables, and give them the largest gap. */
void vxs_gl_stream_tables_begin(vxs_gl *gl, uint32_t number);

typedef enum gl_progress { GL_MORE, GL_READY, GL_NO_ROOM, GL_NO_MEMORY } gl_progress;

/* Make one more square of the page. */
gl_progress vxs_gl_stream_tables_make(vxs_gl *gl, uint32_t number);

/* Change the squares of a page in the tops: to the tables last made, or to coarse answers, and free its place. */
void vxs_gl_stream_tables_show(vxs_gl *gl, uint32_t number, int is_shown);

/* After pages were hidden: upload the tops; pages that had no room, and may have it now, lose their names. */
void vxs_gl_stream_tables_hidden(vxs_gl *gl);

/* Upload changed tops. */
void vxs_gl_stream_tables_write(vxs_gl *gl);
void vxs_gl_stream_tables_free(vxs_gl *gl);

/* Shader texts, made by the Makefile from the files of these names. */
extern const char vxs_gl_text_words_tables_glsl[], vxs_gl_text_smoke_lights_glsl[], vxs_gl_text_cull_glsl[],
    vxs_gl_text_view_glsl[], vxs_gl_text_first_shadow_glsl[], vxs_gl_text_depth_pages_glsl[], vxs_gl_text_depth_pages_fill_glsl[],
    vxs_gl_text_depth_pages_pack_glsl[], vxs_gl_text_depth_pages_mark_glsl[], vxs_gl_text_vxs_lookup_h[],
    vxs_gl_text_vxs_lookup_blocks_h[], vxs_gl_text_vxs_space_h[], vxs_gl_text_vxs_depths_h[], vxs_gl_text_vxs_cull_h[];

#endif
