/* Light of a surface in fog: virtual point lights (VPLs) on the surface, each with a shadow volume; all shadow volumes are built
 * at once. Built on vxs_volumes.h.
 *
 *     vxs_area_rectangle screen = {...};                                // once, or when the image on it changes
 *     vxs_area_sample(&screen, VXS_AREA_IMPORTANCE, 0, vpls, 64);
 *     vxs_area_light_set(light, vpls, 64);
 *     vxs_area_light_cast(light, &(vxs_area_casters){points, count});   // again when casters or VPLs have moved
 *     // if there is smoke; again when smoke or VPLs have moved
 *     vxs_area_light_smoke(light, &(vxs_capsules){.list = smoke, .count = puffs});
 *
 *     vxs_volumes_area(air, light, &(vxs_area_look){0});                // each frame, after vxs_volumes_begin
 *
 * Positions of VPLs and casters are metres from an anchor that the caller chooses; vxs_area_light_anchor
 * sets its position.
 * Source: [IVSV13].
 * Public.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_AREA_LIGHT_H
#define VXS_AREA_LIGHT_H

#include "vxs_transmittance.h"
#include "vxs_volumes.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { VXS_VPLS_MAX = 256 }; /* the largest number at once */

/* virtual point lights --------------------------------------------------------------------------------------------------------- */

/* A small patch of a surface that emits to one side: its intensity is `colour` times the cosine to its normal. */
typedef struct vxs_vpl {
    float    place[3];
    float    normal[3];     /* of length 1; all 0: it emits equally in all directions */
    float    colour[3];     /* intensity along the normal, in candela or in the units of the image; >= 0 */
    float    radius_metres; /* > 0: the least distance from it that is used for eye rays */
    /* 1: a distant light: its light travels along the normal everywhere, and `colour` is the irradiance of a surface
     * perpendicular to that. Its shadow casters are within radius_metres of its place */
    uint32_t is_far;
} vxs_vpl;

/* An image that emits light, such as a screen or a window. */
typedef struct vxs_area_rectangle {
    float        corner[3];        /* where both sides begin, at the first texel of the image */
    float        across[3], up[3]; /* the two sides, in metres; it emits to the side to which their cross product points */
    float        radiance[3];      /* equal in all directions of that side, as of paper; >= 0 */
    const float *texture;          /* [high_px][wide_px][3] factors of the radiance, >= 0; NULL: 1 everywhere */
    uint32_t     wide_px, high_px; /* of the texture */
} vxs_area_rectangle;

/* How the positions of VPLs are chosen. */
typedef enum vxs_area_places {
    /* Halton sequence, of bases 2 and 3: any part of it is evenly distributed, so that VPLs can be added one by one */
    VXS_AREA_HALTON,
    /* Hammersley set, warped to where the texture is bright: all VPLs have equal luminance, and none lies where the texture is
     * black */
    VXS_AREA_IMPORTANCE,
    VXS_AREA_REGULAR,  /* middles of equal cells, as square as `count` allows */
    VXS_AREA_JITTERED, /* a random position in each of these cells */
} vxs_area_places;

/* Sample VPLs of a rectangle. With VXS_AREA_IMPORTANCE all have equal luminance, in the colour of their texel. Otherwise each
 * VPL gets the light of its Voronoi cell, computed from 64 x 64 pieces, so that no bright area is missed; without a texture all
 * VPLs are equal. Their sum is the light of the rectangle; with VXS_AREA_IMPORTANCE this holds for luminance only.
 * seed   of random positions; for Halton and Hammersley points a shift of all, with wrap-around. 0: no shift
 * vpls  [out] [count]
 * count  1 to VXS_VPLS_MAX
 * Returns VXS_OK; VXS_E_ARGUMENT for numbers that are not valid, a rectangle without area, or a texture without texels.
 * Cost: one pass over the texture, and 4096 distances for each VPL; with VXS_AREA_IMPORTANCE two passes, and a row for each VPL.
 * Threads: no shared state; it allocates no memory. */
vxs_result vxs_area_sample(const vxs_area_rectangle *rectangle, vxs_area_places places, uint32_t seed, vxs_vpl *vpls,
                           uint32_t count);

/* An environment map: radiance of distant light from each direction. */
typedef struct vxs_area_sky {
    /* [high_px][wide_px][3] radiance, >= 0. Rows are equal angles from the zenith, along y, down to the nadir. Columns are equal
     * angles around, from x toward z */
    const float *texture;
    uint32_t     wide_px, high_px;
    float        radiance[3];   /* factor of the texture, >= 0 */
    float        middle[3];     /* centre of a sphere that contains all shadow casters */
    float        radius_metres; /* radius of the sphere, > 0; shadow maps have this width */
} vxs_area_sky;

/* Sample VPLs of a sky, which are distant. Texels are weighted by their solid angle, and with VXS_AREA_IMPORTANCE by luminance
 * times solid angle.
 * seed, vpls, count  as for vxs_area_sample
 * Returns, cost, threads: as for vxs_area_sample. */
vxs_result vxs_area_sample_sky(const vxs_area_sky *sky, vxs_area_places places, uint32_t seed, vxs_vpl *vpls, uint32_t count);

/* points on shadow casters ----------------------------------------------------------------------------------------------------- */

/* A point of a surface and the area that it represents; layout of a storage buffer. */
typedef struct vxs_area_point {
    float place[3];
    float square_metres;
} vxs_area_point;

/* Sample points of triangles. The number of points of a triangle is proportional to its area. Points are in the order of the
 * triangles, and on each triangle along a space-filling curve: consecutive points are neighbours, so that every n-th point is as
 * evenly distributed as all points.
 * positions  [3 * vertices] metres
 * corners    [3 * triangle_count] vertices
 * points     [out] [count] all of equal area
 * Returns the area of all triangles, in square metres; 0 if there is no area, or if it is not a valid number: then no points are
 * written.
 * Threads: no shared state; it allocates no memory. */
double vxs_area_scatter(const float *positions, const uint32_t *corners, uint32_t triangle_count, vxs_area_point *points,
                        uint32_t count);

/* The same, with more points where the lights matter. A quarter of the points are distributed by area. The others are
 * distributed by the irradiance of a face turned toward the lights, without shadows. Large scenes need it, because points by
 * area alone are too far apart near a light.
 * vpls   [vpl_count] about 16 per light are enough, from vxs_area_sample; colours are weights. Distant VPLs are treated as
 *         near ones
 * points  [out] [count] with individual areas, whose sum is about the total area
 * Returns, threads: as above; without light, the points are those of vxs_area_scatter.
 * Cost: two evaluations of each triangle for each VPL, and more for triangles that are wider than half of their distance. */
double vxs_area_scatter_for(const float *positions, const uint32_t *corners, uint32_t triangle_count, const vxs_vpl *vpls,
                            uint32_t vpl_count, vxs_area_point *points, uint32_t count);

/* the light -------------------------------------------------------------------------------------------------------------------- */

typedef struct vxs_area_light vxs_area_light;

/* Fields that are not set are 0, which means the default. New fields are added at the end only. */
typedef struct vxs_area_light_desc {
    size_t   struct_size;   /* sizeof(vxs_area_light_desc); 0: the first version, which ends with smoke_nodes */
    uint32_t vpls;          /* largest number of VPLs, at most VXS_VPLS_MAX; 0: VXS_VPLS_MAX */
    uint32_t side_px;       /* of the imperfect shadow map of each VPL: 32, 64, 128, 256; 0: 128 */
    uint32_t columns, rows; /* of the grid of each VPL, whose eye rays have 128 bits: 1 to 256; 0: 128 */
    uint32_t takes_maps;    /* 1: exact shadow depth maps may be given instead of imperfect shadow maps */
    uint32_t capsules;      /* largest number of smoke capsules, up to 2^24; 0: no smoke, and nothing is allocated for it */
    uint32_t smoke_side_px; /* curves per side for each VPL; 0: 64 */
    uint32_t smoke_nodes;   /* per curve: 4, 8, 12, 16; 0: 4 */
} vxs_area_light_desc;

/* Memory: vpls * (16 * columns * rows + 5.4 * side_px * side_px) bytes in one storage buffer, 86 MiB by default, and three
 * textures of the size of the view. With smoke, another buffer of vpls * 8 * smoke_nodes * smoke_side_px * smoke_side_px bytes,
 * 32 MiB by default, and 32 bytes for each capsule.
 * light  [out] NULL on failure
 * Returns VXS_OK; VXS_E_ARGUMENT; VXS_E_GL: a shader does not compile, or more than the largest storage buffer of the context;
 * VXS_E_MEMORY. */
vxs_result vxs_area_light_create(vxs_area_light **light, vxs_volumes *volumes, const vxs_area_light_desc *desc);
void       vxs_area_light_destroy(vxs_area_light *light); /* accepts NULL */

/* Set the VPLs; they are copied. If only colours have changed, as with a moving image, they keep their shadow maps; otherwise
 * they have none.
 * count  1 to the number given to create
 * Returns VXS_OK; VXS_E_ARGUMENT for numbers that are not valid, or normals whose length is not 1. */
vxs_result vxs_area_light_set(vxs_area_light *light, const vxs_vpl *vpls, uint32_t count);

/* Set the anchor: positions of VPLs and casters are relative to it. place is in metres from the origin that was last set by
 * vxs_gl_origin; call this again when that origin follows a camera. Shadow maps stay valid. Before the first call, the anchor is
 * the origin.
 * Returns VXS_OK; VXS_E_ARGUMENT for numbers that are not valid. */
vxs_result vxs_area_light_anchor(vxs_area_light *light, const float place[3]);

typedef struct vxs_area_casters {
    unsigned buffer; /* of vxs_area_point, without gaps; not read if count is 0 */
    uint32_t count;
    /* 1: each point is drawn into the map of each VPL. 0: of each 64 consecutive points, only as many are drawn as the map can
     * resolve, chosen anew for each VPL; then the cost of a map hardly depends on the number of points. Consecutive points
     * should be neighbours, as from vxs_area_scatter or in a file */
    uint32_t is_whole;
} vxs_area_casters;

/* Draw the imperfect shadow maps of all VPLs. A point is drawn as a disc on its surface, slightly larger than its area. The
 * points before and after it in the buffer give the plane of the surface; if they span no plane, the point is drawn as a square
 * that faces the light. Gaps between points are filled from coarser levels, whether the gap shows nothing or something farther
 * away. Call it again when VPLs or casters have moved; the maps are kept between frames.
 * Returns VXS_OK; VXS_E_ARGUMENT without VPLs or a buffer, or if a VPL emits in all directions.
 * Cost: one test for each 64 points and VPL; at most about 4 * side_px^2 points drawn into each map, where all visible surfaces
 * are dense. */
vxs_result vxs_area_light_cast(vxs_area_light *light, const vxs_area_casters *casters);

/* Compute how much smoke dims the light of each VPL, on surfaces and in the air: curves as in vxs_transmittance.h, over the half
 * of all directions to which the VPL emits, or over the sphere about its place if it is distant. Call it again when VPLs or
 * smoke have moved; the curves are kept between frames.
 * smoke  positions are relative to the anchor, as those of VPLs. A capsule thinner than a texel is widened to a texel, with less
 *        density. Without capsules the light is no longer dimmed, at no cost
 * If VPLs use maps of baked lights, the baked smoke of these lights dims them, too, without this call. Other VPLs have no baked
 * smoke.
 * Returns VXS_OK; VXS_E_ARGUMENT without VPLs, if a VPL emits in all directions, or for more capsules than given to create.
 * Cost: a workgroup for each VPL and 8 x 8 curves tests all capsules, in their order. */
vxs_result vxs_area_light_smoke(vxs_area_light *light, const vxs_capsules *smoke);

/* 1: the VPLs have imperfect shadow maps; 0: vxs_area_light_cast is still needed. */
int vxs_area_light_is_cast(const vxs_area_light *light);

/* Which VPLs each pixel evaluates. */
typedef enum vxs_area_gather {
    VXS_AREA_EACH,    /* all VPLs */
    VXS_AREA_NINTHS,  /* a ninth of them: 3 x 3 pixels together evaluate all; results are averaged over pixels of similar depth */
    VXS_AREA_QUARTER, /* all, at one pixel in four; other pixels interpolate neighbours of similar depth */
} vxs_area_gather;

/* Fields that are not set are 0, which means the default. New fields are added at the end only. */
typedef struct vxs_area_look {
    size_t                             struct_size; /* sizeof(vxs_area_look); 0: the first version, which ends with maps */
    vxs_area_gather                    gather;
    uint32_t                           runs;     /* as for vxs_volumes_grid, at most 128; 0: 8 */
    uint32_t                           is_sharp; /* 1: an eye ray uses one row of a grid; 0: it interpolates between two rows */
    /* GL_TEXTURE_2D of the size of the view: normals of what was drawn, of length 1, or 0 where nothing was drawn; 0: airlight
     * alone */
    unsigned                           normal_texture;
    const vxs_shadow_depth_map *const *maps; /* [vpls] exact shadow maps, for VPLs that do not move; NULL: imperfect shadow maps */
} vxs_area_look;

/* Add the airlight of all VPLs to the frame, and, if normals are given, compute the light that reaches surfaces. Each VPL has a
 * grid; all grids are built by one dispatch over all light rays and one scan. All pixels are drawn, whatever the frame's
 * min_radiance is.
 * Returns VXS_OK; VXS_E_ARGUMENT without a frame, VPLs, or their shadow maps; if the smoke curves belong to earlier VPL
 * positions; for maps of a sun, or of distant VPLs. */
vxs_result vxs_volumes_area(vxs_volumes *volumes, vxs_area_light *light, const vxs_area_look *look);

/* Irradiance of surfaces: RGBA32F, of the size given to create. Only the corner that the view covers is used. It includes
 * extinction by the fog between VPL and surface. It is that of the last vxs_volumes_area with normals. Valid until
 * vxs_area_light_destroy. */
unsigned vxs_area_light_irradiance(const vxs_area_light *light);

#ifdef __cplusplus
}
#endif
#endif
