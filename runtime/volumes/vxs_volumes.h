/* libvxs_volumes: shadows in fog, on a graphics processor. It stands on libvxs_gl, whose words and lights it asks.
 *
 *     vxs_volumes *air;                                                 // when a level is loaded, with a context current
 *     vxs_volumes_desc desc = {.get_proc_address = my_loader, .shadows = shadows, .width_px = 1920, .height_px = 1080};
 *     if (vxs_volumes_create(&air, &desc) != VXS_OK) ...
 *
 *     vxs_volumes_begin(air, &frame);                                   // each frame: medium, camera, depths of what was drawn
 *     vxs_volumes_march(air, &sun, sun_map, 64, VXS_STEPS_EVEN);        // each light by a technique of its own
 *     vxs_volumes_composite(air);                                       // onto what was drawn
 *
 * Light that a homogeneous medium turns once toward the eye is added up along each eye ray, where a light reaches it. Techniques differ in how they
 * know that; what media and lights are is the same for all (vxs_air_path.h).
 *
 * A light map tells of each light ray where shadow begins on it: of what stands, from the baked asset, and of what moves, from depth maps of the
 * caller; joined there, ray by ray. A shadow grid does so, too, of the asset or a map, and of triangles that move. Nowhere else are they joined.
 *
 * It links no OpenGL, and wants 4.5. Every call needs the context of vxs_volumes_create current on the calling thread. What it changes
 * of the context's state it puts back, but for words and lights, which it leaves bound as vxs_gl_bind does. Memory and programs are taken by the
 * calls that end in create.
 * Places are metres from the origin that vxs_gl_origin was told last.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_VOLUMES_H
#define VXS_VOLUMES_H

#include "vxs_gl.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct vxs_volumes       vxs_volumes;
typedef struct vxs_shadow_depth_map     vxs_shadow_depth_map;
typedef struct vxs_shadow_grid   vxs_shadow_grid;
typedef struct vxs_adaptive_mesh vxs_adaptive_mesh;

/* What is not named is 0, and means the default. It grows at its end only. */
typedef struct vxs_volumes_desc {
    size_t struct_size; /* sizeof(vxs_volumes_desc); 0: as it was at first, up to log */
    vxs_gl_function (*get_proc_address)(const char *name, void *user);
    void                *user;
    const vxs_allocator *allocator;            /* NULL: malloc and free; copied, but its functions must outlive the object */
    vxs_gl              *shadows;              /* the baked lights; borrowed until vxs_volumes_destroy */
    uint32_t             width_px, height_px;  /* of the largest view, > 0 */
    uint32_t             first_unit;           /* texture units from here on are used, and put back; 0: 8 */
    void (*log)(const char *text, void *user); /* told what the compiler says of a shader that does not compile; NULL */
    uint32_t first_storage; /* bindings of storage buffers, as units: this and the next two, none of vxs_gl's; 0: 5 */
} vxs_volumes_desc;

/* volumes  [out] NULL on failure
 * Returns VXS_OK; VXS_E_ARGUMENT; VXS_E_MEMORY; VXS_E_GL: older than OpenGL 4.5, without a function, a shader that does not compile, or a view
 * larger than its textures. Then the frame is drawn without fog. */
vxs_result vxs_volumes_create(vxs_volumes **volumes, const vxs_volumes_desc *desc);

/* Behind all that was created of it. Accepts NULL. */
void vxs_volumes_destroy(vxs_volumes *volumes);

/* a frame ------------------------------------------------------------------------------------------------------------------------- */

/* What fills the air, and what was drawn. */
typedef struct vxs_volumes_frame {
    float    scattering[3], extinction[3]; /* per metre, as for vxs_medium */
    float    anisotropy;
    float    ambient[3]; /* radiance that comes from all sides, such as a part of the sky's: fog scatters it, too; 0: none */
    float    top_metres; /* height (along y) of the level top of ground fog; VXS_AIR_EVERYWHERE, or more: it has none */
    vxs_view view;       /* of vxs_gl.h; filter_px is not used */
    float    eye[3];     /* where all eye rays begin */
    float    far_metres; /* where a ray ends that meets nothing, > 0 */
    float    min_radiance; /* a light with no more airlight than this anywhere is culled, and so are pixels with no more of a light. 0: none.
                              It bounds the error of one light; vxs_volumes_light has another for each, so that a caller bounds the sum */
    unsigned depth_texture; /* GL_TEXTURE_2D of view.width_px x view.height_px depths or R32F; level 0 is read */
} vxs_volumes_frame;

/* Begin a frame: no airlight yet.
 * Returns VXS_OK; VXS_E_ARGUMENT for a view that is larger than that of create, or numbers that are none. */
vxs_result vxs_volumes_begin(vxs_volumes *volumes, const vxs_volumes_frame *frame);

/* A light of the frame. */
typedef struct vxs_volumes_light {
    uint32_t                   baked;     /* its number in vxs_gl; without constants */
    const vxs_light_constants *constants; /* of a light that is not baked: how its maps lie; NULL: it is */
    float colour[3];     /* lamps: intensity, in candela; suns: irradiance, in lux; or in the units of the picture */
    float cos_inner;     /* spot lights: where the cone is dimmer, as in glTF; at least that of where it ends */
    float radius_metres; /* lamps, > 0: airlight has no bound where a ray meets a point that shines */

    /* What dims it on its way: a map of the same light (vxs_transmittance.h), which marches ask at each step. Other techniques, whose forms are closed, say
     * VXS_E_ARGUMENT. NULL: nothing does */
    const struct vxs_transmittance_map *smoke;
    uint32_t                            smoke_lookup; /* as vxs_curve_lookup has it */

    float min_radiance; /* of this light; 0: the frame's */
} vxs_volumes_light;

/* Why a light is culled in a frame. */
typedef enum vxs_cull_result {
    VXS_NOT_CULLED,
    VXS_CULLED_FAINT,     /* no more airlight than min_radiance, in any direction */
    VXS_CULLED_OFFSCREEN, /* no more than that in any pixel of the view */
    VXS_CULLED_CLEAR,  /* the fog has a level top, and no ray of the view comes below it, or none of the light */
} vxs_cull_result;

/* A rectangle of pixels. */
typedef struct vxs_pixels {
    uint32_t x, y, wide_px, high_px;
} vxs_pixels;

/* Whether a light's airlight can be seen in the frame that has begun, and where: in no other pixel there is more than `least` of it. By its cone, its range
 * and a bound that holds whatever is in shadow; techniques draw no other pixels, so that nobody has to ask.
 * pixels  [out]
 * Returns VXS_CULLED_OFFSCREEN also for what the techniques refuse. */
vxs_cull_result vxs_volumes_cull(vxs_volumes *volumes, const vxs_volumes_light *light, vxs_pixels *pixels);

/* The most airlight of a light that any ray of the frame can have in any channel, whatever is in shadow. Lights of which this adds up to no more than a bound
 * may be left out together.   Returns 0 for what the techniques refuse */
float vxs_volumes_most(vxs_volumes *volumes, const vxs_volumes_light *light);

/* Airlight, linear: RGBA32F, of the size of create, of which the view's corner is used; rows as those of the depths. Alpha is not used. Valid until
 * vxs_volumes_destroy. */
unsigned vxs_volumes_airlight(const vxs_volumes *volumes);

/* Lay the frame's fog over a linear picture: its colour times what the fog leaves of it, per channel, and airlight added.
 * The current draw framebuffer, from (0, 0) on, where its pixels are those of the depths */
void vxs_volumes_composite(vxs_volumes *volumes);

/* light maps ---------------------------------------------------------------------------------------------------------------------- */

typedef struct vxs_shadow_depth_map_desc {
    uint32_t baked; /* the light's number in vxs_gl; without constants */
    const vxs_light_constants
            *constants; /* of a light that is not baked: a map without end is of this prism, frustum or cube; NULL: it is */
    uint32_t side_px;   /* a power of two; 0, or more than the baked map has: as that */
    uint32_t moves;     /* 1: vxs_shadow_depth_map_join will be called */
} vxs_shadow_depth_map_desc;

/* An R32F array of one or six layers of side_px x side_px texels, in the prism, frustum or cube of the light's baked maps. A texel is where
 * shadow begins on the light ray through its centre: of suns in voxels of the baked light, of lamps in metres along the map's axis; 1e30
 * where light does not end. The baked part is looked up once, in calls of vxs_shadow_depth_map_fill.
 * Returns VXS_OK; VXS_E_ARGUMENT; VXS_E_MEMORY; VXS_E_GL for a side that the context does not have. */
vxs_result vxs_shadow_depth_map_create(vxs_shadow_depth_map **map, vxs_volumes *volumes, const vxs_shadow_depth_map_desc *desc);
void       vxs_shadow_depth_map_destroy(vxs_shadow_depth_map *map);

/* Look up what is baked of the next max_texels, or fewer; again, when pages have come.
 * Returns how many are left. */
uint64_t vxs_shadow_depth_map_fill(vxs_shadow_depth_map *map, uint64_t max_texels);

/* Look all of it up again in calls of vxs_shadow_depth_map_fill that follow. */
void vxs_shadow_depth_map_refill(vxs_shadow_depth_map *map);

/* A depth map of what moves, seen from the light. Of a point light there may be several, each of a part. */
typedef struct vxs_moving_casters {
    unsigned depth_texture; /* GL_TEXTURE_2D */
    uint32_t width_px, height_px;
    float    depth_from_point[16]; /* by columns: metres to texture coordinates and depth, times w */
    float    empty_depth;          /* where nothing is */
} vxs_moving_casters;

/* Each frame: the baked map, and before it what moves.
 * casters  [count]; 0: the baked map alone */
vxs_result vxs_shadow_depth_map_join(vxs_shadow_depth_map *map, const vxs_moving_casters *casters, uint32_t count);

/* The texture, a GL_TEXTURE_2D_ARRAY. Valid until vxs_shadow_depth_map_destroy. */
unsigned vxs_shadow_depth_map_texture(const vxs_shadow_depth_map *map);
uint32_t vxs_shadow_depth_map_side_px(const vxs_shadow_depth_map *map);
uint32_t vxs_shadow_depth_map_layers(const vxs_shadow_depth_map *map);

/* marches ------------------------------------------------------------------------------------------------------------------------- */

typedef enum vxs_steps {
    VXS_STEPS_EVEN,  /* alike in metres */
    VXS_STEPS_EQUIANGULAR, /* of lamps alike in an angle in which phase and falloff are nearly even; of suns alike in what they scatter */
} vxs_steps;

/* Add a light's airlight by so many questions a ray, each at the middle of a step; of a light with smoke, what a step scatters is times what reaches it, and so
 * it is of a baked light whose smoke is baked. Of that no other technique knows: their forms are closed.
 * map  of the light; NULL: the asset is asked at each step
 * steps  1 to 65536 */
vxs_result vxs_volumes_march(vxs_volumes *volumes, const vxs_volumes_light *light, const vxs_shadow_depth_map *map, uint32_t steps,
                             vxs_steps which);

/* voxelized shadow volumes -------------------------------------------------------------------------------------------------------- */

/* What is not named is 0, and means the default. */
typedef struct vxs_shadow_grid_desc {
    uint32_t columns;        /* of angles at the eye; 0: 512 */
    uint32_t rows;           /* of angles about the way to the light; 0: 2048 */
    uint32_t bits;           /* of angles at a lamp, or distances from the way to the sun; 0: 512. Memory is of whole 128s */
    uint32_t scan_in_passes; /* 1: all at once, which takes as much memory again; 0: row by row, in shared memory */
    uint32_t casts;          /* 1: vxs_volumes_grid_cast will be called */
    uint32_t
        between_rows; /* 1: an eye ray has of the two rows whose middles it lies between, by how near they are ([IVSV13] 3.3); 0: its own */
} vxs_shadow_grid_desc;

/* A grid of bits, columns * rows * bits / 8 bytes in a storage buffer, made again for each light of each frame: any number of lights may use one.
 * Returns VXS_OK; VXS_E_ARGUMENT for more than 16384 along a side; VXS_E_GL for more than a storage buffer of the context holds; VXS_E_MEMORY. */
vxs_result vxs_shadow_grid_create(vxs_shadow_grid **grid, vxs_volumes *volumes, const vxs_shadow_grid_desc *desc);
void       vxs_shadow_grid_destroy(vxs_shadow_grid *grid);

/* The buffer: 128 bytes, and words as in vxs_shadow_grid.h. Valid until vxs_shadow_grid_destroy. */
unsigned vxs_shadow_grid_buffer(const vxs_shadow_grid *grid);

/* Add a light's airlight by a grid: of each light ray where shadow begins on it, a bit for each place of an eye ray ([VSV11]).
 * map   of the light; NULL: the asset is asked for each light ray, and no map is needed
 * runs  how many parts of an eye ray are each as lit as their bits are in the mean; 0: 16, or 32 where the anisotropy is 0.7 and more, or a cone has a
 *       sharp rim; 16384 at most
 * Behind the end of a sun's map that is bounded, what was in shadow is taken to stay so. */
vxs_result vxs_volumes_grid(vxs_volumes *volumes, const vxs_volumes_light *light, const vxs_shadow_depth_map *map, vxs_shadow_grid *grid,
                            uint32_t runs);

/* How triangles become voxels. */
typedef enum vxs_voxels {
    VXS_VOXELS_RAYS, /* where light rays through the middles of voxels meet a triangle, exactly: what a light map of any size would say */
    VXS_VOXELS_SOLID,   /* voxels whose middles are in a closed model; of others the answer is arbitrary ([Eisemann 2008]) */
    VXS_VOXELS_COVERED, /* all voxels that a triangle is in, however thin it is, in grids of 8 rows and more ([Schwarz 2010]) */
    VXS_VOXELS_KINDS,
} vxs_voxels;

/* Triangles that cast shadow, in buffers of the caller, which are read as storage. Corners that are no places, or beyond the end of a buffer, leave their
 * triangle out. What is not named is 0, and means the default. */
typedef struct vxs_casters {
    unsigned   places;               /* a buffer: float[3] each */
    uint32_t   first_word;           /* where they begin in it, in floats */
    uint32_t   place_words;          /* floats from one to the next, >= 3; 0: 3 */
    unsigned   corners;              /* a buffer: uint32_t[3], places of a triangle; 0: three places are one */
    uint32_t   triangle_count;       /* 2^30 at most */
    float      point_from_place[16]; /* by columns: metres; the last row is not read */
    vxs_voxels kind;
} vxs_casters;

/* The same with triangles: on each light ray shadow begins where it does by the map, or of the asset, or at a triangle, whichever is first.
 * map      NULL, of a light with constants: there are triangles alone
 * grid     made with `casts`
 * casters  [count]
 * Cost: a pass over the triangles for each of casters, and what they cover: light rays, or eye rays and bits behind these (VXS_VOXELS_SOLID). */
vxs_result vxs_volumes_grid_cast(vxs_volumes *volumes, const vxs_volumes_light *light, const vxs_shadow_depth_map *map,
                                 vxs_shadow_grid *grid, uint32_t runs, const vxs_casters *casters, uint32_t count);

/* Invocations of the last vxs_volumes_grid_cast that a driver ended early: shadows of some triangles are missing, or where models are closed
 * (VXS_VOXELS_SOLID) wrong. llvmpipe ends all loops of an invocation after 65535 rounds, which 64 triangles may take that fill the view of a grid of 512
 * bits and columns: give them as VXS_VOXELS_RAYS, or in parts, to a smaller grid. 0 with other drivers.   Waits for the graphics processor. */
uint32_t vxs_shadow_grid_cut(const vxs_shadow_grid *grid);

/* exact intervals ----------------------------------------------------------------------------------------------------------------- */

/* Add a baked light's airlight by the parts of each ray that it reaches, exactly to the voxel (vxs_intervals.h): the limit of marches of the
 * asset. Where pages are missing, by the coarse answer. Returns VXS_OK, or VXS_E_ARGUMENT, as of a light that is not baked. */
vxs_result vxs_volumes_intervals(vxs_volumes *volumes, const vxs_volumes_light *light);

/* Rays of vxs_volumes_intervals that a driver ended early, in the frame that has begun: behind the place where it did so they have no airlight. llvmpipe,
 * which draws without a graphics card, ends all loops of an invocation after 65535 rounds; a ray that grazes more than some ten thousand texels takes more.
 * 0 with other drivers.   Waits for the graphics processor. */
uint32_t vxs_volumes_cut(const vxs_volumes *volumes);

/* The same as vxs_volumes_intervals in as many dispatches as its longest ray takes, none of which a driver ends early. It waits for the graphics processor
 * behind each of them, so that it is for llvmpipe, and for pictures; and alpha of the airlight is 0 behind it. */
vxs_result vxs_volumes_intervals_in_pieces(vxs_volumes *volumes, const vxs_volumes_light *light);

/* polygonal light volumes --------------------------------------------------------------------------------------------------------- */

/* What a light reaches has a closed surface: the light's map displaced to where shadow begins. Along an eye ray airlight is a sum over its crossings
 * in any order: where the ray enters what is lit, the airlight from there to what is seen is added, where it leaves, taken away; and all of it is
 * added where the eye is in light [Billeter 2010]. It is exact towards the surface, in which a step of depth between two texels is a slope
 * from the middle of one to that of the other. */

/* Add a light's airlight by the surface of its map as it is now: two triangles for each texel, made where they are drawn. Six maps have 4096 x 4096 texels
 * at most, one has 8192 x 8192. */
vxs_result vxs_volumes_mesh_map(vxs_volumes *volumes, const vxs_volumes_light *light, const vxs_shadow_depth_map *map);

typedef struct vxs_adaptive_mesh_desc {
    uint32_t side_px, layers; /* of the largest light map that it is used with: a power of two, 1 to 8192, of six 4096; 1 or 6 */
    uint32_t triangles_most;  /* that there is room for, 12 bytes each; 0: as many as all quads have, or as the context holds */
} vxs_adaptive_mesh_desc;

/* Room for the surface of a map as it is now, with few triangles where it is flat: made by shaders in each vxs_volumes_mesh_adaptive, so that any number
 * of lights may use one.
 * Returns VXS_OK; VXS_E_ARGUMENT; VXS_E_GL for more than a storage buffer, or a texture of a buffer, has in this context, or a shader that does not
 * compile; VXS_E_MEMORY. */
vxs_result vxs_adaptive_mesh_create(vxs_adaptive_mesh **mesh, vxs_volumes *volumes, const vxs_adaptive_mesh_desc *desc);
void       vxs_adaptive_mesh_destroy(vxs_adaptive_mesh *mesh);

/* The buffer of its triangles, for who wants to know how many: the fifth of its words, as vxs_volumes_mesh_adaptive left it. The first four are an indirect
 * draw; behind eight words are three vertices of each triangle (vxs_mesh_code). Valid until vxs_adaptive_mesh_destroy. */
unsigned vxs_adaptive_mesh_buffer(const vxs_adaptive_mesh *mesh);

/* Add a light's airlight by the surface of its map as it is now, with the quads that vxs_light_mesh_plan chooses of that map, but where an error is what is
 * allowed to the rounding of a float.
 * map  no larger than the mesh was created for
 * error_texels  as vxs_light_mesh_desc has it, >= 0; below a hundredth, the rounding of floats may split what is flat
 * Where the triangles are more than there is room for, which the buffer tells, vxs_volumes_mesh_map's are drawn. */
vxs_result vxs_volumes_mesh_adaptive(vxs_volumes *volumes, const vxs_volumes_light *light, const vxs_shadow_depth_map *map,
                                     vxs_adaptive_mesh *mesh, float error_texels);

/* The surface of a map in which nothing moves: made in C when a level is loaded, with few triangles where it is flat. What is not named is 0, and
 * means the default. It grows at its end only. */
typedef struct vxs_light_mesh_desc {
    size_t                     struct_size; /* sizeof(vxs_light_mesh_desc); 0: as it was at first, up to error_texels */
    const vxs_light_constants *light;       /* how its maps lie; their origin does not count */
    const float               *first;       /* [layers][side_px][side_px] the light map, as vxs_shadow_depth_map_create has it */
    uint32_t                   side_px;     /* a power of two, 1 to 8192; no more than the baked map has */
    float far_metres;   /* > 0: what an eye ray sees is no farther from a lamp without a range, or from a sun's map */
    float error_texels; /* how far a larger quad's triangles may be off the depth of a texel, in widths of one; 0: none is larger */
} vxs_light_mesh_desc;

typedef struct vxs_light_mesh_size {
    uint32_t vertex_count, triangle_count;
} vxs_light_mesh_size;

/* Bytes of working memory; 0 where the description makes no sense, or is too large for 32-bit indices. */
size_t vxs_light_mesh_room(const vxs_light_mesh_desc *desc);

/* Choose the quads, and say how large the mesh is.
 * room  [vxs_light_mesh_room] aligned as for uint32_t; vxs_light_mesh_fill reads it
 * size  [out]
 * Returns VXS_OK; VXS_E_ARGUMENT, and nothing is written.
 * Cost: 0.1 to 0.3 us for each texel of the map. Threads: none shared. */
vxs_result vxs_light_mesh_plan(const vxs_light_mesh_desc *desc, void *room, vxs_light_mesh_size *size);

/* Write the mesh that was planned with the same description and room. It is closed: each edge is met by as many triangles one way as the other, at
 * equal vertices, or at vertices with equal places where faces of a cube meet. Depths that are no number count as 0.
 * places   [out] [3 * vertex_count] light space: of suns texels, texels and voxels of the baked map; of lamps metres about the light, along
 *          the axes of light space
 * corners  [out] [3 * triangle_count] vertices; counterclockwise as seen from where no light is, in a light space that is right-handed */
void vxs_light_mesh_fill(const vxs_light_mesh_desc *desc, const void *room, float *places, uint32_t *corners);

typedef struct vxs_light_mesh vxs_light_mesh;

/* Upload a mesh.
 * mesh  [out] NULL on failure.   places, corners  as vxs_light_mesh_fill writes them
 * Returns VXS_OK; VXS_E_ARGUMENT; VXS_E_MEMORY, or more words than a texture of a buffer has in this context. */
vxs_result vxs_light_mesh_create(vxs_light_mesh **mesh, vxs_volumes *volumes, const float *places, const uint32_t *corners,
                                 const vxs_light_mesh_size *size);
void       vxs_light_mesh_destroy(vxs_light_mesh *mesh);

/* The buffer: 3 * triangle_count words of corners, and places behind them, as they were uploaded. Valid until vxs_light_mesh_destroy. */
unsigned vxs_light_mesh_buffer(const vxs_light_mesh *mesh);
uint32_t vxs_light_mesh_triangles(const vxs_light_mesh *mesh);

/* Add a light's airlight by its mesh. */
vxs_result vxs_volumes_mesh(vxs_volumes *volumes, const vxs_volumes_light *light, const vxs_light_mesh *mesh);

#ifdef __cplusplus
}
#endif
#endif
