/* libvxs_gl: baked shadows on a graphics processor. It stands on libvxs, which stays free of OpenGL.
 *
 *     vxs_gl *shadows;                                                          // when a level is loaded, with a context current
 *     vxs_gl_desc desc = {.get_proc_address = my_loader, .asset = asset};
 *     if (vxs_gl_create(&shadows, &desc) != VXS_OK) ...
 *     while (vxs_gl_upload(shadows, 4 << 20)) draw_loading_screen();            // in slices of 4 MiB a frame
 *
 *     const char *text[VXS_GL_TEXTS + 1];                                       // a shader, without any #include
 *     vxs_gl_texts(shadows, text);
 *     text[VXS_GL_TEXTS] = my_body;                                             // calls vxs_lit_by(light, position, normal, 9)
 *     glShaderSource(shader, VXS_GL_TEXTS + 1, text, NULL);
 *     ... glLinkProgram(program);  vxs_gl_link(shadows, program);
 *
 *     vxs_gl_upload(shadows, 1 << 20);                                          // each frame: of a stream (.stream = stream), what has come
 *     vxs_gl_origin(shadows, camera_ws);
 *     vxs_gl_bind(shadows);
 *     glUseProgram(program);  draw();
 *
 * It links no OpenGL: functions come from the caller's get_proc_address. OpenGL 4.3 or ES 3.1 hold words in a storage buffer, OpenGL 3.3
 * and ES 3.0 (WebGL 2) in an integer texture; shaders read both by the same names.
 * Every call needs the context of vxs_gl_create current on the calling thread, and clears the error that glGetError would have said. What
 * it changes of the context's state it puts back, but for what a call says, and GL_COPY_WRITE_BUFFER, which it leaves at 0.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_GL_H
#define VXS_GL_H

#include "vxs_stream.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct vxs_gl vxs_gl;

typedef void (*vxs_gl_function)(void);

/* How words and lights lie on the graphics processor. */
typedef enum vxs_gl_storage {
    VXS_GL_CHOOSE,  /* a buffer where fragment shaders may have two and one holds the words; else a texture */
    VXS_GL_BUFFER,  /* OpenGL 4.3, ES 3.1 */
    VXS_GL_TEXTURE, /* OpenGL 3.3, ES 3.0: R32UI for words, RGBA32UI for lights */
} vxs_gl_storage;

/* A light, and where its words are among those of all lights. */
typedef struct vxs_gl_light {
    const vxs_light *light; /* borrowed until vxs_gl_destroy */
    uint32_t         first_word;
} vxs_gl_light;

/* What is not named is 0, and means the default. It grows at its end only. */
typedef struct vxs_gl_desc {
    size_t struct_size; /* sizeof(vxs_gl_desc); 0: as it was at first, up to first_binding */
    vxs_gl_function (*get_proc_address)(const char *name, void *user);
    void                *user;
    const vxs_allocator *allocator; /* NULL: malloc and free; copied, but its functions must outlive the object */
    vxs_gl_storage       storage;

    const vxs_asset
        *asset; /* all its lights and their smoke, whose words are put as they are; borrowed until vxs_gl_upload returns 0 */

    /* without an asset or a stream: lights whose words the caller puts (vxs_gl_put) */
    const vxs_gl_light *lights; /* [light_count], copied */
    uint32_t            light_count;
    uint32_t            word_count; /* of all lights */

    uint32_t first_binding; /* buffers take this binding of storage buffers and the next two; textures such texture units */

    const vxs_stream *stream; /* without an asset: all its lights and smoke; vxs_gl_upload follows its pages. Borrowed until vxs_gl_destroy */

    /* without an asset: [lights] baked smoke of each, NULL: it has none; NULL: that of the stream, and without one no light has any. Its
     * words are borrowed until vxs_gl_upload returns 0 */
    const vxs_baked_smoke *const *smoke;
} vxs_gl_desc;

/* Make room for the words and the lights: one buffer for each, or one texture for each. Nothing is uploaded yet.
 * gl  [out] NULL on failure
 * Returns VXS_OK; VXS_E_ARGUMENT (no function, no light, an asset and a stream, a struct_size that makes no sense); VXS_E_MEMORY (the context's memory, too; more words than the largest buffer or
 * texture holds); VXS_E_GL (older than OpenGL 3.3 and ES 3.0, without a function, or without the storage that was asked for). */
vxs_result vxs_gl_create(vxs_gl **gl, const vxs_gl_desc *desc);

/* Accepts NULL. */
void vxs_gl_destroy(vxs_gl *gl);

/* Words that are to be uploaded: at first, and whenever they change. They go in the order in which they are put, whatever the slices. Words that
 * change while shaders look them up are uploaded in whole before the next draw. Not for the words of a stream.
 * words  [count] borrowed until they are uploaded: what they are then counts
 * first  where they go among the words of all lights
 * Returns VXS_OK; VXS_E_ARGUMENT beyond word_count, or without words; VXS_E_MEMORY, and nothing is changed. */
vxs_result vxs_gl_put(vxs_gl *gl, const uint32_t *words, uint32_t first, uint32_t count);

/* Upload of what is to be uploaded the next max_bytes, or fewer. SIZE_MAX: all. Returns how many bytes are left. Before it returns 0 lookups
 * give numbers that mean nothing.
 *
 * Of a stream, that is so until it has returned 0 once, at best before the first frame. Then call it between vxs_stream_frame and what is drawn; not
 * during that frame. Names of pages that have left are taken away first, all of them, 4 bytes each beside max_bytes; then pages that have come are
 * uploaded one by one, each with its name behind it. So whatever the slices, shaders answer as C does where pages are uploaded, and by the coarse level where
 * they are not yet; when 0 is returned, everywhere as C does. Frames of the stream may be left out. */
uint64_t vxs_gl_upload(vxs_gl *gl, size_t max_bytes);

/* How many bytes of words vxs_gl_upload has uploaded since vxs_gl_create. */
uint64_t vxs_gl_uploaded_bytes(const vxs_gl *gl);

/* Fill the constants of all lights, for positions that count from an origin, and upload them: 96 bytes a light.
 * origin_ws  as for vxs_light_constants_of: the camera's place, where a world is large; NULL: (0, 0, 0)
 * Called by vxs_gl_create with NULL. */
void vxs_gl_origin(vxs_gl *gl, const double origin_ws[3]);

/* The constants of light n, as they were filled last; [0, light count). Valid until vxs_gl_destroy. */
const vxs_light_constants *vxs_gl_constants(const vxs_gl *gl);
uint32_t                   vxs_gl_light_count(const vxs_gl *gl);

/* What a shader begins with, NUL-terminated texts valid until vxs_gl_destroy: the #version line and names of numbers, how words are
 * fetched, vxs_lookup.h, vxs_lookup_blocks.h, vxs_space.h, vxs_cull.h, and vxs_smoke.h with how lights are. With buffers they are the same for all assets
 * with smoke, and for all without, so that programs may be kept; with textures they have the asset's numbers. The body that follows them may call what those headers
 * declare, and
 *
 *     vxs_light_constants vxs_light_at(uint n)                            the constants of light n
 *     uint                vxs_light_count()                               as vxs_gl_light_count
 *     float               vxs_lit_by(uint n, vec3 at, vec3 normal, int filter_px)   vxs_lit of light n
 *     float               vxs_smoke_left_by(uint n, vec3 at)              how much of light n baked smoke leaves, 0 to 1: what is lit is multiplied by it
 *     uint                vxs_tile_of(ivec2 pixel)                        of lists that were culled; pixel counts as in the depths
 *     uint                vxs_tile_light_count(uint tile)                 how many lights may reach what the tile shows
 *     uint                vxs_tile_light(uint tile, uint n)               light n of them, in ascending order
 *
 * Words are fetched at indices that are clamped to the array, so that damaged ones give wrong numbers and nothing worse. A body that needs
 * an extension hands its compiler texts[0], its #extension lines, and texts 1 to VXS_GL_TEXTS - 1. */
enum { VXS_GL_TEXTS = 7 };
void vxs_gl_texts(const vxs_gl *gl, const char *texts[VXS_GL_TEXTS]);

/* Tell a program, once it is linked, where words and lights are. Nothing to do where they are buffers: their text says it. */
void vxs_gl_link(const vxs_gl *gl, unsigned program);

/* Bind words, lights and lists for shaders that follow: storage buffers at first_binding and the two behind it, or textures at such units,
 * and there they stay. The active texture unit is put back. */
void vxs_gl_bind(const vxs_gl *gl);

/* culling ------------------------------------------------------------------------------------------------------------------------- */

enum { VXS_TILE_PX = 8, VXS_LISTS_HEAD = 4 };

/* What a frame shows, and where: of each pixel (x, y) a depth d, at the place, from the origin of the lights' constants,
 *
 *     (a, b, c) / w,  (a, b, c, w) = point_from_depth * ((x + 0.5) / width_px, (y + 0.5) / height_px, d, 1)
 *
 * so that the matrix knows which way up the image is, and what its depths are. */
typedef struct vxs_view {
    uint32_t width_px, height_px;
    float    point_from_depth[16]; /* by columns, as OpenGL has it */
    float    empty_depth;          /* of pixels that show nothing: the depth that was cleared to */
    int32_t  filter_px;            /* the widest filter that lookups have, as for vxs_lookup */
} vxs_view;

/* Pixels whose place is as far from that origin along an axis, or no place at all, show nothing. */
#define VXS_VIEW_METRES 1e15

/* Words of the lists of a view: VXS_LISTS_HEAD, then of each tile of 8 x 8 pixels, rows, 1 + tile_lights. UINT64_MAX: more than that. */
uint64_t vxs_lists_words(uint32_t width_px, uint32_t height_px, uint32_t tile_lights);

/* Which lights may reach what each tile of 8 x 8 pixels shows: those whose volume (cone and range, prism) meets the box around its places
 * ([CPVS16] 6.3). No light that reaches a pixel is left out; one that is listed may reach none.
 * lights  [light_count];   depths  [height_px * width_px] rows
 * tile_lights  how many a list has room for. Where more are needed the list holds the number alone, and shaders ask all lights
 * lists   [out] [vxs_lists_words]: tiles in a row, tile rows, tile_lights, light_count; of each tile how many lights there are, and which.
 * Returns the longest list's number. */
uint32_t vxs_cull(const vxs_light_constants *lights, uint32_t light_count, const vxs_view *view, const float *depths,
                  uint32_t tile_lights, uint32_t *lists);

/* The same by a compute shader, in storage buffers alone. The lists are made, or made again where sizes change, and bound.
 * depth_texture  a GL_TEXTURE_2D of width_px x height_px texels of depth or R32F, that does not compare; level 0 is read
 * Leaves the lists bound as vxs_gl_bind does. A barrier for storage buffers is behind it.
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_GL without storage buffers and compute shaders, or when its shader does not compile. */
vxs_result vxs_gl_cull(vxs_gl *gl, const vxs_view *view, unsigned depth_texture, uint32_t tile_lights);

/* Lists of vxs_cull, for shaders of any storage.
 * lists  [vxs_lists_words] not kept.   Returns VXS_OK or VXS_E_MEMORY. */
vxs_result vxs_gl_put_lists(vxs_gl *gl, const uint32_t *lists);

#ifdef __cplusplus
}
#endif
#endif
