/* libvxs_gl: baked shadows on a GPU. It depends on libvxs, which stays free of OpenGL.
 *
 *     vxs_gl *shadows;                                                          // when a level is loaded, with a context current
 *     vxs_gl_desc desc = {.get_proc_address = my_loader, .asset = asset};
 *     if (vxs_gl_create(&shadows, &desc) != VXS_OK) ...
 *     while (vxs_gl_upload(shadows, 4 << 20)) draw_loading_screen();            // in slices of 4 MiB a frame
 *
 *     const char *text[VXS_GL_TEXTS + 1];                                       // a shader, without any #include
 *     vxs_gl_texts(shadows, text);
 *     text[VXS_GL_TEXTS] = my_body;                                             // calls vxs_lit_by(light, position, normal,
 *     vxs_box(9)) glShaderSource(shader, VXS_GL_TEXTS + 1, text, NULL);
 *     ... glLinkProgram(program);  vxs_gl_link(shadows, program);
 *
 *     vxs_gl_upload(shadows, 128 << 10);                                        // each frame: new pages of a stream (.stream = ..)
 *     vxs_gl_origin(shadows, camera_ws);
 *     vxs_gl_bind(shadows);
 *     glUseProgram(program);  draw();
 *
 * It links no OpenGL: functions come from the caller's get_proc_address. Words are in a storage buffer with OpenGL 4.3 or ES 3.1,
 * and in an integer texture with OpenGL 3.3 and ES 3.0 (WebGL 2); shaders read both by the same names.
 * Every call needs the context of vxs_gl_create current on the calling thread, and may clear a pending glGetError error. Each
 * call restores the context state that it changes, except for what its comment names, and for GL_COPY_WRITE_BUFFER, which becomes
 * 0.
 * Public.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_GL_H
#define VXS_GL_H

#include "vxs_stream.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct vxs_gl vxs_gl;

typedef void (*vxs_gl_function)(void);

/* Storage of words and lights on the GPU. */
typedef enum vxs_gl_storage {
    VXS_GL_CHOOSE,  /* a buffer if fragment shaders can use enough storage buffers and one holds all words; else a texture */
    VXS_GL_BUFFER,  /* OpenGL 4.3, ES 3.1 */
    VXS_GL_TEXTURE, /* OpenGL 3.3, ES 3.0: R32UI for words, RGBA32UI for lights */
} vxs_gl_storage;

/* A light, and the index of its first word in the array of all words. */
typedef struct vxs_gl_light {
    const vxs_light *light; /* borrowed until vxs_gl_destroy */
    uint32_t         first_word;
} vxs_gl_light;

/* Fields that are 0 have their default. The struct grows only at its end. */
typedef struct vxs_gl_desc {
    size_t struct_size; /* sizeof(vxs_gl_desc); 0: the first version, up to and including first_binding */
    vxs_gl_function (*get_proc_address)(const char *name, void *user);
    void                *user;
    const vxs_allocator *allocator; /* NULL: malloc and free; copied, but its functions must outlive the object */
    vxs_gl_storage       storage;

    const vxs_asset *asset; /* all its lights and smoke; vxs_gl_create queues their words. Borrowed until vxs_gl_upload returns 0 */

    /* without an asset or a stream: lights whose words the caller supplies (vxs_gl_put) */
    const vxs_gl_light *lights; /* [light_count], copied */
    uint32_t            light_count;
    uint32_t            word_count; /* of all lights */

    uint32_t first_binding; /* first of three consecutive storage buffer bindings, or texture units */

    const vxs_stream
        *stream; /* instead of an asset: its lights and smoke; vxs_gl_upload follows its pages. Borrowed until vxs_gl_destroy */

    /* without an asset: [light count] baked smoke of each light, NULL: none. A NULL array: the smoke of the stream, or none
     * without a stream. Words are borrowed until vxs_gl_upload returns 0 */
    const vxs_baked_smoke *const *smoke;

    /* explains errors: what the context lacks, the messages of its compiler, or the remedy; and warns where tables have no room.
     * Called with `user`. NULL: not wanted */
    vxs_log_fn *log;

    /* instead of an asset: [light_count] whole lights, for instance some of an asset; `smoke` is as without an asset. The lights are
     * borrowed until vxs_gl_destroy, their words until vxs_gl_upload returns 0 */
    const vxs_baked_light *const *baked;

    /* Tables: the depths of palette blocks, laid out for shaders in place of words, so that they need a quarter of the time. Lights
     * whose words the caller supplies have none. Of an asset, or of `baked`, vxs_gl_create makes them, in up to three times the
     * time of opening the file, and keeps them in memory until they are uploaded; if they would take more bytes than this, there
     * are none. Of a stream, vxs_gl_upload makes them page by page; this many bytes are allocated on the GPU. Where a page finds no
     * room, it stays coarse, and `log` warns once; if these are fewer bytes than the stream's own room for pages, there are none.
     * 0: 8 times the bytes of words, or 64 MiB where that is more, or 8 times that room; 1: none */
    uint64_t most_table_bytes;
} vxs_gl_desc;

/* Create the object, with storage for words and lights: one buffer for each, or one texture for each. No words are uploaded yet.
 * gl  [out] NULL on failure
 * Returns VXS_OK; VXS_E_ARGUMENT (no get_proc_address, no light, two of asset, stream and baked, an invalid struct_size);
 * VXS_E_MEMORY (also for GPU memory, and for more words than the largest buffer or texture holds); VXS_E_GL (OpenGL older than
 * 3.3 or ES older than 3.0, a missing function, or the requested storage is not available). */
vxs_result vxs_gl_create(vxs_gl **gl, const vxs_gl_desc *desc);

/* Accepts NULL. */
void vxs_gl_destroy(vxs_gl *gl);

/* Queue words for upload: at first, and whenever they change. They are uploaded in the order of the calls, whatever the slices.
 * To change words that shaders already use, upload them completely before the next draw. Not for the words of a stream, and not
 * where there are tables.
 * words  [count] borrowed until uploaded; read at upload
 * first  index of the first one in the array of all words
 * Returns VXS_OK; VXS_E_ARGUMENT beyond word_count, without words, or where there are tables; VXS_E_MEMORY, and nothing is queued. */
vxs_result vxs_gl_put(vxs_gl *gl, const uint32_t *words, uint32_t first, uint32_t count);

/* Upload at most max_bytes of the queued words. SIZE_MAX: all. Returns the number of bytes left. Until it returns 0, lookups give
 * meaningless results.
 *
 * With a stream this holds until it has returned 0 once, preferably before the first frame. After that, call it between
 * vxs_stream_frame and the draw calls, not during vxs_stream_frame. First, pages that were evicted are hidden. Then new pages are
 * uploaded one by one, and are shown when they are complete. What hides and shows them, at most 8 bytes for each square of 256 x 256
 * texels, is not counted in max_bytes. So with slices of any size, shaders give the same result as C where pages are uploaded, and
 * the coarse answer where they are not; after a return of 0, the same as C everywhere, if all tables have room. It need not be
 * called for every frame of the stream. Tables are made by this call, in
 * about 10 ms a MiB; until then their size, and so the number of bytes left, is an estimate. */
uint64_t vxs_gl_upload(vxs_gl *gl, size_t max_bytes);

/* Returns the bytes of all tables; of a stream, the bytes allocated for them. 0: shaders read words alone. */
uint64_t vxs_gl_table_bytes(const vxs_gl *gl);

/* Returns how many bytes of words vxs_gl_upload has uploaded since vxs_gl_create. */
uint64_t vxs_gl_uploaded_bytes(const vxs_gl *gl);

/* Compute and upload the constants of all lights for positions relative to an origin: 96 bytes a light.
 * origin_ws  as for vxs_light_constants_of: the camera position in a large world; NULL: (0, 0, 0)
 * vxs_gl_create calls it with NULL. */
void vxs_gl_origin(vxs_gl *gl, const double origin_ws[3]);

/* Returns the constants of all lights, [light count], as last computed. Valid until vxs_gl_destroy. */
const vxs_light_constants *vxs_gl_constants(const vxs_gl *gl);
uint32_t                   vxs_gl_light_count(const vxs_gl *gl);

/* Get the beginning of a shader as NUL-terminated texts, valid until vxs_gl_destroy: the #version line and constants, the fetch
 * of words, vxs_lookup.h, vxs_lookup_blocks.h (empty where there are tables), vxs_space.h, vxs_cull.h, and vxs_smoke.h with the
 * access to lights. With buffers they contain no sizes, so that programs can be cached; with textures they contain sizes of the
 * asset. If all lights have one kind, one coding, or as many maps, the texts have code for that alone (VXS_ONLY_KIND, _CODING,
 * _CUBE, vxs_space.h): for constants that are not of this object, #undef these names behind texts[0]. The body behind them may
 * call what those headers declare, and
 *
 *     vxs_light_constants vxs_light_at(uint n)                            the constants of light n
 *     uint                vxs_light_count()                               as vxs_gl_light_count
 *     float               vxs_lit_by(uint n, vec3 at, vec3 normal, vxs_filter pcf)    vxs_lit of light n
 *     float               vxs_smoke_left_by(uint n, vec3 at)              transmittance of light n's smoke, 0 to 1: a factor
 *     uint                vxs_tile_of(ivec2 pixel)                        tile in the lists; pixel coordinates as in the depths
 *     uint                vxs_tile_light_count(uint tile)                 number of lights that may reach the points in the tile
 *     uint                vxs_tile_light(uint tile, uint n)               light n of these, in ascending order
 *
 * Word indices are clamped to the array, so that damaged words give only wrong numbers. For a body that needs an extension,
 * compile texts[0], the #extension lines, and texts 1 to VXS_GL_TEXTS - 1; there "#define VXS_ONLY_WIDTH 5" and "#define
 * VXS_ONLY_SMOOTH 0" leave out the code for filters other than vxs_box(5). */
enum { VXS_GL_TEXTS = 7 };
void vxs_gl_texts(const vxs_gl *gl, const char *texts[VXS_GL_TEXTS]);

/* Set the texture units of words and lights in a linked program. Does nothing with buffers: their bindings are in the shader
 * text. */
void vxs_gl_link(const vxs_gl *gl, unsigned program);

/* Bind words, lights and lists for the shaders that follow: storage buffers at first_binding and the next two bindings, or
 * textures at these units. They stay bound. The active texture unit is restored. */
void vxs_gl_bind(const vxs_gl *gl);

/* culling --------------------------------------------------------------------------------------------------------------------- */

enum { VXS_TILE_PX = 8, VXS_LISTS_HEAD = 4 };

/* Depths of the pixels of a frame. The point of pixel (x, y) with depth d, relative to the origin of the lights' constants, is
 *
 *     (a, b, c) / w,  (a, b, c, w) = point_from_depth * ((x + 0.5) / width_px, (y + 0.5) / height_px, d, 1)
 *
 * so the matrix contains the vertical direction of the image and the depth convention. */
typedef struct vxs_view {
    uint32_t   width_px, height_px;
    float      point_from_depth[16]; /* column-major, as in OpenGL */
    float      empty_depth;          /* depth of empty pixels: the clear value */
    vxs_filter filter;               /* widest of the lookups, as for vxs_lookup */
} vxs_view;

/* A pixel whose point is this far from that origin along an axis, or is not finite, counts as empty. */
#define VXS_VIEW_METRES 1e15

/* Returns the number of words of the lists of a view: VXS_LISTS_HEAD, then 1 + tile_lights for each tile of 8 x 8 pixels, in
 * rows. UINT64_MAX on overflow. */
uint64_t vxs_lists_words(uint32_t width_px, uint32_t height_px, uint32_t tile_lights);

/* List for each tile of 8 x 8 pixels the lights that may reach its points: lights whose volume (cone and range, prism) meets the
 * bounding box of these points ([CPVS16] 6.3). Conservative: no light that reaches a pixel is missing, but a listed light may
 * reach no pixel.
 * lights       [light_count]
 * depths       [height_px * width_px] rows
 * tile_lights  capacity of each list. When a tile has more lights, its list is incomplete, its count is above tile_lights, and
 *              shaders use all lights
 * lists        [out] [vxs_lists_words] tiles in a row, tile rows, tile_lights, light_count; then for each tile the light count
 *              and the light indices
 * Returns the greatest light count of a tile. */
uint32_t vxs_cull(const vxs_light_constants *lights, uint32_t light_count, const vxs_view *view, const float *depths,
                  uint32_t tile_lights, uint32_t *lists);

/* The same with a compute shader; needs storage buffers. The lists are created, or created again when sizes change.
 * depth_texture  a GL_TEXTURE_2D of width_px x height_px depth or R32F texels, without depth comparison; level 0 is read
 * The lists are then bound as by vxs_gl_bind. It ends with a memory barrier for storage buffers.
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_GL without storage buffers and compute shaders, or when its shader does not compile. */
vxs_result vxs_gl_cull(vxs_gl *gl, const vxs_view *view, unsigned depth_texture, uint32_t tile_lights);

/* Upload lists of vxs_cull, for shaders with any storage.
 * lists  [vxs_lists_words] not kept
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result vxs_gl_put_lists(vxs_gl *gl, const uint32_t *lists);

#ifdef __cplusplus
}
#endif
#endif
