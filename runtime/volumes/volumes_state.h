/* The object of vxs_volumes.h, and what the techniques share. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VOLUMES_STATE_H
#define VOLUMES_STATE_H

#include "volumes_blocks.h"
#include "volumes_gl.h"
#include "volumes_text.h"
#include "vxs_volumes.h"

/* Binding offsets in the context, from the caller's first binding on. */
enum { UNIT_DEPTHS, UNIT_MAP, UNIT_OTHER, UNIT_MESH, UNITS, IMAGE_BINDING = 0, STORAGES = 3 };

/* Bindings of uniform blocks, each with a buffer. */
enum { BLOCK_FRAME, BLOCK_OWN, BLOCK_CURVES, BLOCKS };

/* What a program is made of.
 * names   lines of #define; NULL: none
 * with    a text in addition to those that the bodies need; NULL: none
 * vertex  the body of the vertex shader; NULL: `body` is a compute shader, else a fragment shader */
typedef struct program_texts {
    const char         *names;
    const volumes_text *with, *vertex, *body;
} program_texts;

/* A hash of a driver and of the texts of a program. */
typedef struct program_key {
    uint64_t words[2];
} program_key;

/* A program that has been used: it is compiled at its first use, and deleted with the volumes. */
enum { PROGRAMS_MOST = 384, PROGRAM_NAMES = 320 }; /* more than kinds, codings and fogs times passes: 3 x 2 x 2 x 20, and 60 */
typedef struct volumes_program {
    char          names[PROGRAM_NAMES];
    program_texts texts;
    program_key   key;
    gl_name       name;       /* 0: it does not compile */
    int           is_pending; /* it was begun by a warming frame, and its driver has not been asked whether it compiles */
} volumes_program;

enum { BINARY_FORMATS_MOST = 16 };

/* What the buffers of the blocks contain. */
typedef struct uploaded_blocks {
    int         is_there[BLOCKS]; /* 0: undefined bytes */
    frame_block frame;
    own_block   own;
    curve_block curves;
} uploaded_blocks;

/* What techniques draw, and the depths of its pixels. */
typedef struct volumes_view {
    gl_name depth_texture, airlight, target; /* target: a framebuffer that draws into airlight */
    float   wide_px, high_px;
} volumes_view;

struct vxs_volumes {
    volumes_api       api;
    vxs_allocator     memory;
    vxs_log_fn       *log;
    void             *user;
    vxs_gl           *shadows;
    vxs_program_cache cache;  /* zeros: none */
    program_key       driver; /* hash of its strings */
    int               binary_formats[BINARY_FORMATS_MOST];
    uint32_t          binary_format_count; /* 0: no cache */
    uint32_t          width_px, height_px, first_unit, first_storage;
    gl_name           airlight, blocks[BLOCKS], vertex_array, target; /* target: a framebuffer that draws into airlight */
    gl_name           cut_buffer;                                     /* the number of rays of the frame that were cut short */
    frame_block       frame;
    own_block         own;
    curve_block       curves;
    uploaded_blocks   uploaded;
    volumes_view      other;                     /* of half the size; while techniques draw that, the whole one */
    gl_name           half_depths;               /* an array of one layer: depths and metres; 0: no fog at half the size */
    int               is_half;                   /* techniques draw at half the size */
    float             frame_least, least;        /* min_radiance of the frame; that of the light */
    gl_name           depth_texture;             /* of the frame; 0: no frame has begun */
    uint32_t          program_count, is_warming; /* is_warming: of the frame */
    vxs_result        result;                    /* VXS_E_GL: a program of the current call does not compile */
    volumes_program   programs[PROGRAMS_MOST];
};

struct vxs_shadow_depth_map {
    vxs_volumes        *volumes;
    vxs_light_constants constants; /* of a light that is not baked */
    uint32_t            baked, is_baked, side_px, layers;
    uint64_t            filled;        /* texels */
    gl_name             first, joined; /* textures; joined: 0 if nothing moves */
};

struct vxs_light_mesh {
    vxs_volumes *volumes;
    uint32_t     triangle_count;
    gl_name      words, texture, vertex_array; /* one buffer: corners, then positions */
};

/* Report why a function fails, and the remedy. Returns r. */
vxs_result vxs_volumes_fail(const vxs_volumes *v, vxs_result r, const char *text);

/* Memory from the allocator of the caller's desc. */
void *vxs_volumes_alloc(const vxs_volumes *v, size_t size);
void  vxs_volumes_free(const vxs_volumes *v, void *memory, size_t size);

/* A program, compiled at its first use: the texts of vxs_gl, then what the bodies need, then the bodies.
 * Returns 0 if it does not compile; then vxs_volumes_done returns VXS_E_GL. */
gl_name vxs_volumes_program(vxs_volumes *v, const program_texts *texts);

/* The same for the frame's light and fog: what they do not use is not compiled. */
gl_name vxs_volumes_light_program(vxs_volumes *v, const program_texts *texts);

/* The same as vxs_volumes_program, compiled now and owned by the caller. */
gl_name vxs_volumes_compile(const vxs_volumes *v, const program_texts *texts);

/* Use a cache from now on, if the driver has program binaries.   cache  NULL: none */
void vxs_volumes_cache_begin(vxs_volumes *v, const vxs_program_cache *cache);

/* Make a key of more bytes. */
void vxs_volumes_key_add(program_key *key, const void *data, size_t size_bytes);

/* A linked program from the cache.   Returns 0 if it is not there, is damaged, or the driver refuses it */
gl_name vxs_volumes_cache_get(const vxs_volumes *v, const program_key *key);

/* Put the binary of a linked program into the cache. */
void vxs_volumes_cache_put(const vxs_volumes *v, const program_key *key, gl_name program);

/* The result of a call that may have compiled programs. */
vxs_result vxs_volumes_done(vxs_volumes *v);

/* A texture of one level, without filtering.   layers  0: GL_TEXTURE_2D;   Returns 0 if there is no memory. */
gl_name vxs_volumes_texture(const vxs_volumes *v, gl_enum format, uint32_t wide, uint32_t high, uint32_t layers);

/* A storage buffer.   Returns 0 if there is no memory. */
gl_name vxs_volumes_buffer(const vxs_volumes *v, uint64_t size_bytes);

/* Write into a buffer that shaders write, too. */
void vxs_volumes_put(const vxs_volumes *v, gl_name buffer, uint64_t start_bytes, uint64_t size_bytes, const void *data);

void vxs_volumes_forget_error(const vxs_volumes *v);

/* Previous context state that a technique changes, except words and lights. */
typedef struct saved_state {
    int     program, active, textures[UNITS], samplers[UNITS];
    int     buffer, blocks[BLOCKS], image[6];
    int64_t block_starts[BLOCKS], block_sizes[BLOCKS];
} saved_state;

/* Begin to use a program: upload blocks that have changed, and bind them, words and lights; bind depths, a map and an image that are
 * not 0.
 * map     a GL_TEXTURE_2D_ARRAY
 * image   bound for reading and writing, all its layers;  format  of it */
saved_state vxs_volumes_use(vxs_volumes *v, gl_name program, gl_name map, gl_name image, gl_enum format);

/* Restore the state after a program. */
void vxs_volumes_restore(const vxs_volumes *v, const saved_state *saved);

/* Textures for fog at half the size. */
vxs_result vxs_volumes_half_create(vxs_volumes *v);

/* End fog at half the size without adding it. */
void vxs_volumes_show_full(vxs_volumes *v);

/* Whether something can be drawn: all programs of the current call compile, and the frame is not a warming one. */
int vxs_volumes_can_draw(const vxs_volumes *v);

/* Dispatch groups, if vxs_volumes_can_draw. */
void vxs_volumes_dispatch(const vxs_volumes *v, uint32_t x, uint32_t y, uint32_t z);

/* A dispatch with vxs_volumes_use before and vxs_volumes_restore after it; map, image (RGBA32F) as above. */
void vxs_volumes_run(vxs_volumes *v, gl_name program, gl_name map, gl_name image, uint32_t groups_across, uint32_t groups_down);

/* Previous storage buffer bindings, from the caller's first binding on. */
typedef struct saved_storage {
    int     buffer, buffers[STORAGES];
    int64_t starts[STORAGES], sizes[STORAGES];
} saved_storage;

saved_storage vxs_volumes_save_storage(const vxs_volumes *v);
void          vxs_volumes_use_storage(const vxs_volumes *v, gl_name first, gl_name second);
void          vxs_volumes_restore_storage(const vxs_volumes *v, const saved_storage *saved);

/* Previous state that drawing changes in addition. */
typedef struct saved_raster {
    int           array, viewport[4], scissor[4], framebuffer, blend[6], polygon[2], front, clip[2];
    unsigned char mask[4], blends, enabled[7];
} saved_raster;

/* Begin to draw the frame's pixels: no tests, both sides of faces, colour and alpha, one buffer with additive blending as given. */
saved_raster vxs_volumes_draw(const vxs_volumes *v, gl_enum source, gl_enum destination, gl_enum destination_alpha);
void         vxs_volumes_restore_raster(const vxs_volumes *v, const saved_raster *saved);

/* Set the light for the shaders that follow.   map  NULL: none.   Returns VXS_OK; VXS_E_ARGUMENT without a frame, or if the
 * light is invalid. */
vxs_result vxs_volumes_set_light(vxs_volumes *v, const vxs_volumes_light *light, const vxs_shadow_depth_map *map);

/* Upper bound of its airlight over all rays. */
double vxs_volumes_find_most(const vxs_volumes *v);

/* The pixels of the frame that may see that light.   Returns why there are none */
vxs_cull_result vxs_volumes_find_cull_result(const vxs_volumes *v, vxs_pixels *pixels);

/* Add its airlight by a program, in groups of 8 x 8 pixels, where it may be seen. */
void vxs_volumes_add(vxs_volumes *v, gl_name program, gl_name map);

/* Its constants. */
const vxs_light_constants *vxs_shadow_depth_map_constants(const vxs_shadow_depth_map *map);

#endif
