/* libvxs_volumes: shadows in fog, on a graphics processor. It is built on libvxs_gl and uses its words and lights.
 *
 *     vxs_volumes *air;                                                 // when a level is loaded, with a context current
 *     vxs_volumes_desc desc = {.get_proc_address = my_loader, .shadows = shadows, .width_px = 1920, .height_px = 1080};
 *     if (vxs_volumes_create(&air, &desc) != VXS_OK) ...
 *
 *     vxs_volumes_begin(air, &frame);                                   // each frame: medium, camera, depths of what was drawn
 *     vxs_volumes_march(air, &sun, sun_map, 64, VXS_STEPS_EVEN);        // each light, by any technique
 *     vxs_volumes_composite(air);                                       // onto what was drawn
 *
 * The medium is homogeneous. Airlight is single scattering: light that the medium scatters once, toward the eye. It is
 * integrated along each eye ray over the parts that are lit. The techniques differ in how they find these parts. Media and
 * lights are the same for all of them (vxs_air_path.h).
 *
 * A shadow depth map stores for each light ray where shadow begins. It joins static casters, from the baked asset, with moving
 * casters, from depth maps of the caller, ray by ray. A shadow grid joins the asset or a shadow depth map with triangles that move.
 * Nothing else joins static and moving casters.
 *
 * The library links no OpenGL; it needs OpenGL 4.5. Each call requires that the context of vxs_volumes_create is current on the
 * calling thread. Calls restore the context state that they change, except words and lights, which stay bound as by vxs_gl_bind.
 * Only calls that end in "create", and a cache of programs, allocate memory. Programs are compiled at their first use, or in a frame
 * that is_warming.
 * Positions are metres from the origin that was last set by vxs_gl_origin.
 * Public.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_VOLUMES_H
#define VXS_VOLUMES_H

#include "vxs_gl.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct vxs_volumes          vxs_volumes;
typedef struct vxs_shadow_depth_map vxs_shadow_depth_map;
typedef struct vxs_shadow_grid      vxs_shadow_grid;
typedef struct vxs_adaptive_mesh    vxs_adaptive_mesh;

/* Programs as the driver compiled them, which the caller keeps from one run to the next, for instance as files. What is damaged, or
 * refused by the driver, is compiled and put again. Hashes find damage, not forgery: keep values where only the user can write. Not
 * used with drivers that have no program binaries. */
typedef struct vxs_program_cache {
    /* Read what was put under a key.
     * key    32 hexadecimal digits: a hash of the driver's name and version and of the program's text
     * value  [out] [room_bytes] not written if the room is too small
     * Returns its size, in bytes; 0: there is none. NULL: nothing is read */
    size_t (*get)(const char *key, void *value, size_t room_bytes, void *user);
    /* Store a value, in place of an older one of this key.   NULL: nothing is stored */
    void (*put)(const char *key, const void *value, size_t size_bytes, void *user);
    void *user;
} vxs_program_cache;

/* Fields that are not set are 0, which means the default. New fields are added at the end only. */
typedef struct vxs_volumes_desc {
    size_t struct_size; /* sizeof(vxs_volumes_desc); 0: the first version, which ends with log */
    vxs_gl_function (*get_proc_address)(const char *name, void *user);
    void                *user;
    const vxs_allocator *allocator;           /* NULL: malloc and free; copied, but its functions must outlive the object */
    vxs_gl              *shadows;             /* the baked lights; borrowed until vxs_volumes_destroy */
    uint32_t             width_px, height_px; /* of the largest view, > 0 */
    uint32_t             first_unit;          /* first texture unit that is used; its state is restored; 0: 8 */
    vxs_log_fn *log; /* receives a line for an error, with the remedy, and what a compiler of shaders reports; may be NULL */
    uint32_t    first_storage; /* first of three storage buffer bindings; must not overlap those of vxs_gl; 0: 5 */
    /* called on the thread of the call that first uses a program; NULL: none; copied, but its functions must outlive the object */
    const vxs_program_cache *program_cache;
    uint32_t                 has_half; /* 1: vxs_volumes_begin_half will be called; 6 bytes more for each pixel */
} vxs_volumes_desc;

/* volumes  [out] NULL on failure
 * Returns VXS_OK; VXS_E_ARGUMENT; VXS_E_MEMORY; VXS_E_GL: OpenGL is older than 4.5, a function is missing, a shader does not
 * compile, or the view is larger than the largest texture. On failure, draw the frame without fog. */
vxs_result vxs_volumes_create(vxs_volumes **volumes, const vxs_volumes_desc *desc);

/* Call it after everything that was created from it is destroyed. Accepts NULL. */
void vxs_volumes_destroy(vxs_volumes *volumes);

/* a frame ---------------------------------------------------------------------------------------------------------------------- */

/* The medium, the camera, and the depths of what was drawn. New fields are added at the end only, and none to vxs_view, which is
 * in its middle. */
typedef struct vxs_volumes_frame {
    size_t   struct_size;                  /* sizeof(vxs_volumes_frame); 0: the first version, which ends with depth_texture */
    float    scattering[3], extinction[3]; /* per metre, as for vxs_medium */
    float    anisotropy;
    float    ambient[3]; /* radiance that comes from all directions, such as from the sky; fog scatters it, too; 0: none */
    float    top_metres; /* height (along y) of the level top of ground fog; VXS_AIR_EVERYWHERE or more: no top */
    vxs_view view;       /* of vxs_gl.h; filter is not used */
    float    eye[3];     /* origin of all eye rays */
    float    far_metres; /* length of a ray that meets nothing, > 0 */
    /* Culls lights whose airlight is nowhere above this, and pixels where a light's airlight is not above it. 0: none. It bounds
     * the error of one light. vxs_volumes_light has a bound for each light, so that the caller can bound the sum. */
    float    min_radiance;
    unsigned depth_texture; /* GL_TEXTURE_2D of view.width_px x view.height_px depths or R32F; level 0 is read */
    /* 1: a frame that only compiles. Call the techniques of a frame to come, with its lights, for instance while a level loads:
     * their programs begin to compile, on the driver's threads where it has some (KHR_parallel_shader_compile), and nothing is
     * waited for, drawn, cast or built. vxs_shadow_depth_map_fill fills. */
    uint32_t is_warming;
} vxs_volumes_frame;

/* Begin a frame: set airlight to 0.
 * Returns VXS_OK; VXS_E_ARGUMENT for a view larger than given to create, or for numbers that are not valid. */
vxs_result vxs_volumes_begin(vxs_volumes *volumes, const vxs_volumes_frame *frame);

/* The number by which the structs below name a baked light: 1 + its index in vxs_gl. 0, as in a zeroed struct, names none. */
static inline uint32_t vxs_baked_number(uint32_t index)
{
    return index + 1;
}

/* A light of the frame: baked_number or constants is set, else functions return VXS_E_ARGUMENT. New fields are added at the end
 * only. */
typedef struct vxs_volumes_light {
    size_t                     struct_size;  /* sizeof(vxs_volumes_light); 0: the first version, which ends with min_radiance */
    uint32_t                   baked_number; /* vxs_baked_number; not used with constants */
    const vxs_light_constants *constants;    /* for a light that is not baked: the layout of its maps */
    float colour[3];     /* punctual lights: intensity, in candela; suns: irradiance, in lux; or both in the units of the image */
    float cos_inner;     /* spot lights: cosine where the cone starts to fade, as in glTF; >= the cosine where it ends */
    float radius_metres; /* punctual lights, > 0: without it, airlight is unbounded where a ray meets the light */

    /* Smoke that dims the light on its way: a map of the same light (vxs_transmittance.h). Only marches support it; they look it
     * up at each step. The other techniques use closed forms and return VXS_E_ARGUMENT. NULL: no smoke */
    const struct vxs_transmittance_map *smoke;
    uint32_t                            smoke_lookup; /* a vxs_curve_lookup */

    float min_radiance; /* for this light; 0: that of the frame */
} vxs_volumes_light;

/* Why a light is culled in a frame. */
typedef enum vxs_cull_result {
    VXS_NOT_CULLED,
    VXS_CULLED_FAINT,     /* nowhere more airlight than min_radiance */
    VXS_CULLED_OFFSCREEN, /* no more than that in any pixel of the view */
    VXS_CULLED_CLEAR,     /* the fog has a level top, and no ray of the view, or no light, gets below it */
} vxs_cull_result;

/* A rectangle of pixels. */
typedef struct vxs_pixels {
    uint32_t x, y, wide_px, high_px;
} vxs_pixels;

/* Compute whether and where the airlight of a light is visible in the current frame. Outside the returned pixels it is at most
 * min_radiance. The bound comes from the light's cone and range and ignores shadow. Techniques call this themselves and draw
 * only these pixels.
 * pixels  [out]
 * Returns VXS_CULLED_OFFSCREEN also for lights that the techniques refuse. */
vxs_cull_result vxs_volumes_cull(vxs_volumes *volumes, const vxs_volumes_light *light, vxs_pixels *pixels);

/* Upper bound of a light's airlight over all rays of the frame and all channels, ignoring shadow. Lights may be left out
 * together if the sum of their bounds is small enough.
 * Returns 0 for lights that the techniques refuse. */
float vxs_volumes_most(vxs_volumes *volumes, const vxs_volumes_light *light);

/* Airlight, linear: RGBA32F, of the size given to create. Only the corner that the view covers is used. Rows are in the order of
 * the depths. Alpha is not used. Valid until vxs_volumes_destroy. */
unsigned vxs_volumes_airlight(const vxs_volumes *volumes);

/* Fog at half the width and height, in about a quarter of the time: the techniques that are called before vxs_volumes_end_half draw a ray
 * for 2 x 2 pixels, and vxs_volumes_end_half adds their sum to the airlight of the frame. A pixel gets the light of rays that end
 * near where its own ends, so that light does not cross the edges of what is seen. vxs_volumes_cull counts such pixels meanwhile,
 * and area lights and vxs_volumes_transmittance are refused. vxs_volumes_composite calls vxs_volumes_end_half.
 * Returns VXS_OK; VXS_E_ARGUMENT without a frame, without has_half, or if it is called twice; VXS_E_GL. */
vxs_result vxs_volumes_begin_half(vxs_volumes *volumes);
vxs_result vxs_volumes_end_half(vxs_volumes *volumes);

/* Blend the frame's fog over a linear image: colour * transmittance of the fog + airlight, per channel. It draws into the
 * current draw framebuffer, from (0, 0) on, where pixels must match those of the depths. */
void vxs_volumes_composite(vxs_volumes *volumes);

/* shadow depth maps ------------------------------------------------------------------------------------------------------------------- */

/* Fields that are not set are 0, which means the default. New fields are added at the end only. */
typedef struct vxs_shadow_depth_map_desc {
    size_t                     struct_size;  /* sizeof(vxs_shadow_depth_map_desc); 0: the first version, which ends with moves */
    uint32_t                   baked_number; /* vxs_baked_number; not used with constants */
    /* for a light that is not baked: its prism, frustum or cube; its static part has no shadow */
    const vxs_light_constants *constants;
    uint32_t                   side_px; /* a power of two; 0, or more than the side of the baked map: the side of the baked map */
    uint32_t                   moves;   /* 1: vxs_shadow_depth_map_join will be called */
} vxs_shadow_depth_map_desc;

/* An R32F array of one or six layers of side_px x side_px texels, in the prism, frustum or cube of the light's baked maps. A
 * texel is the depth where shadow begins on the light ray through its centre: for suns in voxels of the baked light, for
 * punctual lights in metres along the map's axis; 1e30 where light does not end. Calls of vxs_shadow_depth_map_fill look the
 * baked part up once.
 * Returns VXS_OK; VXS_E_ARGUMENT; VXS_E_MEMORY; VXS_E_GL for a side that the context does not support. */
vxs_result vxs_shadow_depth_map_create(vxs_shadow_depth_map **map, vxs_volumes *volumes, const vxs_shadow_depth_map_desc *desc);
void       vxs_shadow_depth_map_destroy(vxs_shadow_depth_map *map);

/* Look up the baked shadow of the next texels, at most max_texels. Call it again when pages have arrived.
 * Returns how many texels are left. */
uint64_t vxs_shadow_depth_map_fill(vxs_shadow_depth_map *map, uint64_t max_texels);

/* Restart: the calls of vxs_shadow_depth_map_fill that follow look all texels up again. */
void vxs_shadow_depth_map_refill(vxs_shadow_depth_map *map);

/* A depth map of moving casters, seen from the light. A point light may have several, each for a part of its directions. */
typedef struct vxs_moving_casters {
    unsigned depth_texture; /* GL_TEXTURE_2D */
    uint32_t width_px, height_px;
    float    depth_from_point[16]; /* column-major: metres to texture coordinates and depth, times w */
    float    empty_depth;          /* depth of pixels without a caster */
} vxs_moving_casters;

/* Call it each frame: joins the baked map with moving casters.
 * casters  [count]; count 0: the baked map alone */
vxs_result vxs_shadow_depth_map_join(vxs_shadow_depth_map *map, const vxs_moving_casters *casters, uint32_t count);

/* The texture, a GL_TEXTURE_2D_ARRAY. Valid until vxs_shadow_depth_map_destroy. */
unsigned vxs_shadow_depth_map_texture(const vxs_shadow_depth_map *map);
uint32_t vxs_shadow_depth_map_side_px(const vxs_shadow_depth_map *map);
uint32_t vxs_shadow_depth_map_layers(const vxs_shadow_depth_map *map);

/* marches ---------------------------------------------------------------------------------------------------------------------- */

typedef enum vxs_steps {
    VXS_STEPS_EVEN, /* equal lengths */
    /* punctual lights: equal angles, over which phase and falloff vary little; suns: equal amounts of scattered light */
    VXS_STEPS_EQUIANGULAR,
} vxs_steps;

/* Add a light's airlight by sampling each ray at the middle of each step. If the light has smoke, or if it is baked with smoke,
 * the light that a step scatters is multiplied by the transmittance of the smoke. The other techniques ignore baked smoke,
 * because they use closed forms.
 * map    of the light; NULL: looks the asset up at each step
 * steps  1 to 65536 */
vxs_result vxs_volumes_march(vxs_volumes *volumes, const vxs_volumes_light *light, const vxs_shadow_depth_map *map, uint32_t steps,
                             vxs_steps which);

/* voxelized shadow volumes ----------------------------------------------------------------------------------------------------- */

/* Fields that are not set are 0, which means the default. New fields are added at the end only. */
typedef struct vxs_shadow_grid_desc {
    size_t   struct_size; /* sizeof(vxs_shadow_grid_desc); 0: the first version, which ends with between_rows */
    uint32_t columns;     /* for angles at the eye; 0: 512 */
    uint32_t rows;        /* for angles about the axis from the eye to the light; 0: 2048 */
    /* for angles at a punctual light, or distances from the axis to the sun; 0: 512. Memory is allocated in multiples of 128 */
    uint32_t bits;
    uint32_t scan_in_passes; /* 1: scan all at once, which needs twice the memory; 0: row by row, in shared memory */
    uint32_t casts;          /* 1: vxs_volumes_grid_cast will be called */
    uint32_t between_rows;   /* 1: an eye ray interpolates between the two nearest rows ([IVSV13] 3.3); 0: it uses one row */
} vxs_shadow_grid_desc;

/* A grid of bits: columns * rows * bits / 8 bytes in a storage buffer. It is rebuilt for each light of each frame, so any number
 * of lights can share one.
 * Returns VXS_OK; VXS_E_ARGUMENT for more than 16384 along a side; VXS_E_GL for more than the largest storage buffer of the
 * context; VXS_E_MEMORY. */
vxs_result vxs_shadow_grid_create(vxs_shadow_grid **grid, vxs_volumes *volumes, const vxs_shadow_grid_desc *desc);
void       vxs_shadow_grid_destroy(vxs_shadow_grid *grid);

/* The buffer: 128 bytes of header, then words as in vxs_shadow_grid.h. Valid until vxs_shadow_grid_destroy. */
unsigned vxs_shadow_grid_buffer(const vxs_shadow_grid *grid);

/* Add a light's airlight by a grid. It finds for each light ray where shadow begins, and stores this as one bit for each sample
 * of an eye ray ([VSV11]).
 * map   of the light; NULL: looks the asset up for each light ray, and needs no map
 * runs  number of parts of an eye ray; each is lit by the mean of its bits; 0: 16, or 32 where the anisotropy is 0.7 or more, or
 *       where a cone has a sharp rim; at most 16384
 * Behind the end of a bounded map of a sun, a ray that was in shadow stays in shadow. */
vxs_result vxs_volumes_grid(vxs_volumes *volumes, const vxs_volumes_light *light, const vxs_shadow_depth_map *map,
                            vxs_shadow_grid *grid, uint32_t runs);

/* How triangles become voxels. */
typedef enum vxs_voxels {
    VXS_VOXELS_RAYS, /* exact at light rays through the middles of voxels: equal to a shadow depth map of any size */
    /* voxels whose middles are inside a closed model; for other models the result is undefined ([Eisemann 2008]) */
    VXS_VOXELS_SOLID,
    VXS_VOXELS_COVERED, /* all voxels that a triangle touches, however thin it is; for grids of 8 rows and more ([Schwarz 2010]) */
    VXS_VOXELS_KINDS,
} vxs_voxels;

/* Triangles that cast shadow, in buffers of the caller, which are read as storage buffers. A triangle is left out if a corner is
 * not finite or is outside its buffer. Fields that are not set are 0, which means the default. */
typedef struct vxs_casters {
    unsigned   places;      /* a buffer of float[3] positions */
    uint32_t   first_word;  /* where positions begin in it, in floats */
    uint32_t   place_words; /* stride in floats, >= 3; 0: 3 */
    /* a buffer of uint32_t[3], the positions of a triangle; 0: each three positions are a triangle */
    unsigned   corners;
    uint32_t   triangle_count;       /* at most 2^30 */
    float      point_from_place[16]; /* column-major, to metres; the last row is not read */
    vxs_voxels kind;
} vxs_casters;

/* The same with triangles. On each light ray, shadow begins where the map or asset has it, or at a triangle, whichever is first.
 * map      NULL, for a light with constants: triangles alone
 * grid     created with `casts`
 * casters  [count]
 * Cost: a pass over the triangles of each element of casters, and the light rays that they cover; with VXS_VOXELS_SOLID the eye
 * rays and the bits behind these. */
vxs_result vxs_volumes_grid_cast(vxs_volumes *volumes, const vxs_volumes_light *light, const vxs_shadow_depth_map *map,
                                 vxs_shadow_grid *grid, uint32_t runs, const vxs_casters *casters, uint32_t count);

/* Number of invocations of the last vxs_volumes_grid_cast that a driver ended early. Then the shadows of some triangles are
 * missing, or wrong if models are closed (VXS_VOXELS_SOLID). llvmpipe ends all loops of an invocation after 65535 iterations. 64
 * triangles that fill the view of a grid of 512 bits and columns can reach this: use VXS_VOXELS_RAYS, several parts, or a
 * smaller grid. 0 with other drivers. Waits for the graphics processor. */
uint32_t vxs_shadow_grid_cut(const vxs_shadow_grid *grid);

/* exact intervals -------------------------------------------------------------------------------------------------------------- */

/* Add a baked light's airlight by the lit parts of each ray, exact to the voxel (vxs_intervals.h). Marches of the asset converge
 * to it. Where pages are missing, it uses the coarse answer.
 * Returns VXS_OK; VXS_E_ARGUMENT, also for a light that is not baked. */
vxs_result vxs_volumes_intervals(vxs_volumes *volumes, const vxs_volumes_light *light);

/* Number of rays of vxs_volumes_intervals that a driver ended early, in the current frame. They have no airlight behind the
 * place where they ended. llvmpipe, a software driver, ends all loops of an invocation after 65535 iterations. A ray that grazes
 * more than about ten thousand texels needs more. 0 with other drivers. Waits for the graphics processor. */
uint32_t vxs_volumes_cut(const vxs_volumes *volumes);

/* The same as vxs_volumes_intervals, in as many dispatches as the longest ray needs, so that no driver ends one early. It waits
 * for the graphics processor after each dispatch: use it for llvmpipe and for still images. It leaves 0 in the alpha of
 * airlight. */
vxs_result vxs_volumes_intervals_in_pieces(vxs_volumes *volumes, const vxs_volumes_light *light);

/* polygonal light volumes ------------------------------------------------------------------------------------------------------ */

/* The lit volume of a light has a closed surface: the shadow depth map, displaced to where shadow begins. Airlight of an eye ray is
 * a sum over its crossings with this surface, in any order. Where the ray enters the lit volume, the airlight from there to the
 * visible surface is added; where it leaves, it is subtracted. If the eye is in light, the airlight of the whole ray is added
 * [Billeter 2010]. The result is exact for this surface. In the surface, a depth step between two texels is a slope from the
 * middle of one to the middle of the other. */

/* Add a light's airlight by the surface of its current map: two triangles for each texel, generated while drawing. Six maps have
 * at most 4096 x 4096 texels, one map 8192 x 8192. */
vxs_result vxs_volumes_mesh_map(vxs_volumes *volumes, const vxs_volumes_light *light, const vxs_shadow_depth_map *map);

/* New fields are added at the end only. */
typedef struct vxs_adaptive_mesh_desc {
    size_t   struct_size; /* sizeof(vxs_adaptive_mesh_desc); 0: the first version, which ends with triangles_most */
    /* side: of the largest shadow depth map in use, a power of two, 1 to 8192, for six layers 4096; layers: 1 or 6 */
    uint32_t side_px, layers;
    uint32_t triangles_most; /* capacity, 12 bytes each; 0: for all quads, or as many as the context supports */
} vxs_adaptive_mesh_desc;

/* Storage for the surface of a current map, with few triangles where it is flat. Shaders rebuild it in each
 * vxs_volumes_mesh_adaptive, so any number of lights can share it.
 * Returns VXS_OK; VXS_E_ARGUMENT; VXS_E_GL: the size exceeds a storage buffer or a buffer texture of this context, or a shader
 * does not compile; VXS_E_MEMORY. */
vxs_result vxs_adaptive_mesh_create(vxs_adaptive_mesh **mesh, vxs_volumes *volumes, const vxs_adaptive_mesh_desc *desc);
void       vxs_adaptive_mesh_destroy(vxs_adaptive_mesh *mesh);

/* The buffer of its triangles, as vxs_volumes_mesh_adaptive left it. Words 0 to 3 are an indirect draw; word 4 is the number of
 * triangles; from word 8 on, each triangle has three vertices (vxs_mesh_code). Valid until vxs_adaptive_mesh_destroy. */
unsigned vxs_adaptive_mesh_buffer(const vxs_adaptive_mesh *mesh);

/* Add a light's airlight by the surface of its current map. The quads are those that vxs_light_mesh_plan chooses for that map,
 * except where an error equals the limit to within float rounding.
 * map           no larger than the mesh was created for
 * error_texels  as in vxs_light_mesh_desc, >= 0; below 0.01, float rounding may split flat areas
 * If there are more triangles than the capacity, it draws those of vxs_volumes_mesh_map instead; the buffer has the number. */
vxs_result vxs_volumes_mesh_adaptive(vxs_volumes *volumes, const vxs_volumes_light *light, const vxs_shadow_depth_map *map,
                                     vxs_adaptive_mesh *mesh, float error_texels);

/* The surface of a static map, built in C when a level is loaded, with few triangles where it is flat. Fields that are not set
 * are 0, which means the default. New fields are added at the end only. */
typedef struct vxs_light_mesh_desc {
    size_t                     struct_size; /* sizeof(vxs_light_mesh_desc); 0: the first version, which ends with error_texels */
    const vxs_light_constants *light;       /* layout of its maps; their origin is not used */
    const float               *first;       /* [layers][side_px][side_px] the shadow depth map, as in vxs_shadow_depth_map_create */
    uint32_t                   side_px;     /* a power of two, 1 to 8192; at most the side of the baked map */
    float far_metres; /* > 0: largest distance of a visible point from a punctual light without a range, or from a sun's map */
    /* largest error of a merged quad's triangles against the depth of a texel, in texel widths; 0: no quads are merged */
    float error_texels;
} vxs_light_mesh_desc;

typedef struct vxs_light_mesh_size {
    uint32_t vertex_count, triangle_count;
} vxs_light_mesh_size;

/* Bytes of working memory; 0 if the description is invalid, or too large for 32-bit indices. */
size_t vxs_light_mesh_room(const vxs_light_mesh_desc *desc);

/* Choose the quads and compute the size of the mesh.
 * room  [vxs_light_mesh_room] aligned as for uint32_t; vxs_light_mesh_fill reads it
 * size  [out]
 * Returns VXS_OK; VXS_E_ARGUMENT: nothing is written. Cost: 0.1 to 0.3 us per texel of the map. Threads: no shared state. */
vxs_result vxs_light_mesh_plan(const vxs_light_mesh_desc *desc, void *room, vxs_light_mesh_size *size);

/* Write the planned mesh; pass the same description and room as to vxs_light_mesh_plan. The mesh is closed: equally many
 * triangles use each edge in both directions. They share vertices, or have vertices at equal positions where faces of a cube
 * meet. Depths that are NaN count as 0.
 * places   [out] [3 * vertex_count] light space: for suns texels, texels and voxels of the baked map; for punctual lights metres
 *          from the light along the axes of light space
 * corners  [out] [3 * triangle_count] vertices; counterclockwise as seen from the unlit side, if light space is right-handed */
void vxs_light_mesh_fill(const vxs_light_mesh_desc *desc, const void *room, float *places, uint32_t *corners);

typedef struct vxs_light_mesh vxs_light_mesh;

/* Upload a mesh.
 * mesh             [out] NULL on failure
 * places, corners  as vxs_light_mesh_fill writes them
 * Returns VXS_OK; VXS_E_ARGUMENT; VXS_E_MEMORY, also for more words than a buffer texture of this context holds. */
vxs_result vxs_light_mesh_create(vxs_light_mesh **mesh, vxs_volumes *volumes, const float *places, const uint32_t *corners,
                                 const vxs_light_mesh_size *size);
void       vxs_light_mesh_destroy(vxs_light_mesh *mesh);

/* The buffer: 3 * triangle_count words of corners, then positions, as uploaded. Valid until vxs_light_mesh_destroy. */
unsigned vxs_light_mesh_buffer(const vxs_light_mesh *mesh);
uint32_t vxs_light_mesh_triangles(const vxs_light_mesh *mesh);

/* Add a light's airlight by its mesh. */
vxs_result vxs_volumes_mesh(vxs_volumes *volumes, const vxs_volumes_light *light, const vxs_light_mesh *mesh);

#ifdef __cplusplus
}
#endif
#endif
