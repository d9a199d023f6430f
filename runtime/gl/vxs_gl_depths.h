/* libvxs_gl: depths of baked lights in textures, so that the hardware filters them.
 *
 *     vxs_gl_depth_texture       a whole map, at any resolution, as a depth texture: for an engine's own shadow code
 *     vxs_gl_depth_pages         depth pages: squares of 128 x 128 texels of 16 bits, where a view needs them, in an atlas of a fixed
 *                                size: for maps of any size
 *
 *     vxs_gl_depth_pages *pages;                                                // after vxs_gl_create
 *     vxs_gl_depth_pages_create(&pages, shadows, &(vxs_gl_depth_pages_desc){0});
 *
 *     const char *text[VXS_GL_TEXTS + VXS_GL_DEPTH_PAGES_TEXTS + 1];            // a shader
 *     vxs_gl_texts(shadows, text);
 *     vxs_gl_depth_pages_texts(pages, text + VXS_GL_TEXTS);
 *     text[VXS_GL_TEXTS + VXS_GL_DEPTH_PAGES_TEXTS] = my_body;                  // calls vxs_paged_lit_by(light, position, normal,
 *                                                                               // vxs_box(9)) where it called vxs_lit_by
 *     vxs_gl_depth_pages_mark(pages, &view, my_depth_buffer);                   // each frame, once its depths are drawn
 *     vxs_gl_depth_pages_update(pages, 64);
 *     vxs_gl_bind(shadows);  vxs_gl_depth_pages_bind(pages);  draw();
 *
 * Level L of a map is the map that a bake at 2^L times fewer texels a side would have, with voxels 2^L times as deep: each of its
 * texels has the depth of the texel at the middle of those that it covers. A view needs the level whose texels are about a pixel
 * wide. Where a page is not in the atlas, the words give the same answer more slowly: pages change no answer, so that nothing pops.
 * Two exceptions: a page of a map of more than 65536 texels a side whose depths span more than 65534 voxels has its depths rounded
 * up to 2, 4 or 8 voxels; and voxels of a DAG between enter and exit depth may differ (vxs_first_shadow).
 *
 * Contexts, threads and state as for vxs_gl.h.
 * Public.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_GL_DEPTHS_H
#define VXS_GL_DEPTHS_H

#include "vxs_gl.h"

#ifdef __cplusplus
extern "C" {
#endif

/* whole maps ------------------------------------------------------------------------------------------------------------------ */

/* Make a depth texture of a map: GL_TEXTURE_2D, one level, linear filter, clamped to its edge, comparison GL_LEQUAL. A place whose
 * depth is voxel k (vxs_voxel) is lit where a comparison with (k + 0.5) / 2^levels passes. For 16 bits compare with
 * (k + 0.5) * 2^(16 - levels) / 65535; that is exact for at most 32768 texels a side, else depths are rounded up.
 * baked    its words are read; not kept
 * map      as vxs_voxel returns it
 * level    0 to levels: the texture has 2^(levels - level) texels a side
 * bits     16: GL_DEPTH_COMPONENT16, 32: GL_DEPTH_COMPONENT32F
 * texture  [out] the caller's, to be deleted with glDeleteTextures; 0 on failure
 * coarse   [out] as for vxs_depth_map
 * Returns VXS_OK; VXS_E_ARGUMENT (no such map, level or number of bits); VXS_E_MEMORY (also for a texture larger than the context
 * holds). Cost: some nanoseconds a texel on the calling thread. */
vxs_result vxs_gl_depth_texture(const vxs_gl *gl, const vxs_baked_light *baked, int map, uint32_t level, uint32_t bits,
                                unsigned *texture, int *coarse);

/* depth pages ----------------------------------------------------------------------------------------------------------------- */

typedef struct vxs_gl_depth_pages vxs_gl_depth_pages;

/* Fields that are 0 have their default. The struct grows only at its end. */
typedef struct vxs_gl_depth_pages_desc {
    size_t     struct_size;  /* sizeof(vxs_gl_depth_pages_desc); 0: the first version, up to and including unit */
    uint64_t   budget_bytes; /* of the atlas and what belongs to it on the GPU, without the page table; 0: 32 MiB */
    vxs_filter filter;       /* widest filter that pages answer, wider ones are answered by the words; {0}: vxs_smooth(9) */
    uint32_t   binding;      /* storage buffer of the page table; 0: first_binding of the vxs_gl_desc + 3 */
    uint32_t   unit;         /* texture unit of the atlas */
} vxs_gl_depth_pages_desc;

/* Create an empty atlas. It needs storage buffers and compute shaders: OpenGL 4.3, ES 3.1. Its programs compile at first use.
 * gl  borrowed until vxs_gl_depth_pages_destroy
 * Returns VXS_OK; VXS_E_ARGUMENT (a budget too small for a page, an invalid struct_size); VXS_E_MEMORY; VXS_E_GL. */
vxs_result vxs_gl_depth_pages_create(vxs_gl_depth_pages **pages, vxs_gl *gl, const vxs_gl_depth_pages_desc *desc);

/* Accepts NULL. */
void vxs_gl_depth_pages_destroy(vxs_gl_depth_pages *pages);

/* Get texts for a shader, behind those of vxs_gl_texts; valid until vxs_gl_depth_pages_destroy. The body behind them may call
 *
 *     uint  vxs_depth_level(uint n, vec3 at)           level of light n whose texels are about a pixel wide at a point, in the view
 *                                                      of the last vxs_gl_depth_pages_mark
 *     float vxs_paged_lit_by(uint n, vec3 at, vec3 normal, vxs_filter pcf)          as vxs_lit_by, at that level
 *     float vxs_paged_lit(uint n, uint level, vec3 at, vec3 normal, vxs_filter pcf)   as vxs_lit_by for level 0
 *
 * Texts depend on the desc alone. */
enum { VXS_GL_DEPTH_PAGES_TEXTS = 2 };
void vxs_gl_depth_pages_texts(const vxs_gl_depth_pages *pages, const char *texts[VXS_GL_DEPTH_PAGES_TEXTS]);

/* Bind the page table and the atlas. They stay bound. */
void vxs_gl_depth_pages_bind(const vxs_gl_depth_pages *pages);

/* What a view sees, and the levels that it needs. */
typedef struct vxs_depth_pages_view {
    vxs_view view;     /* its filter is not used */
    float    eye[3];   /* metres, relative to the origin of the lights' constants (vxs_gl_origin) */
    float    px_width; /* of a pixel, at 1 m from the eye, metres: 2 tan(vertical fov / 2) / height_px; 0: level 0 everywhere */
    uint32_t by_lists; /* 1: only lights that vxs_gl_cull has listed for this view; 0: all lights at every pixel */
} vxs_depth_pages_view;

/* Mark the pages that the pixels of a view need, with a compute shader.
 * depth_texture  as for vxs_gl_cull
 * Lists and words are then bound as by vxs_gl_bind, and pages as by vxs_gl_depth_pages_bind.
 * Returns VXS_OK; VXS_E_GL when its shader does not compile. */
vxs_result vxs_gl_depth_pages_mark(vxs_gl_depth_pages *pages, const vxs_depth_pages_view *view, unsigned depth_texture);

/* Decode pages into the atlas that the vxs_gl_depth_pages_mark before the last one has marked, in place of those that no view has
 * needed for longest. It reads marks of the frame before, so that it does not wait for this one. Words of these pages must be
 * uploaded: a page that lacks pages of a stream is used once it is decoded in full.
 * max_pages   0: none
 * Returns how many marked pages are still missing; UINT32_MAX when a shader does not compile. */
uint32_t vxs_gl_depth_pages_update(vxs_gl_depth_pages *pages, uint32_t max_pages);

/* Forget all pages: when words that they came from have changed (vxs_gl_put). */
void vxs_gl_depth_pages_forget(vxs_gl_depth_pages *pages);

/* Returns how many pages the atlas holds, and how many are in it. */
uint32_t vxs_gl_depth_pages_room(const vxs_gl_depth_pages *pages);
uint32_t vxs_gl_depth_pages_held(const vxs_gl_depth_pages *pages);

#ifdef __cplusplus
}
#endif
#endif
