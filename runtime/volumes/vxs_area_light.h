/* Light of a surface in fog: as many virtual point lights as are set on it, each with a shadow volume of its own, all made at once. It stands on
 * vxs_volumes.h.
 *
 *     vxs_area_rectangle screen = {...};                                // once, or when the picture on it changes
 *     vxs_area_sample(&screen, VXS_AREA_IMPORTANCE, 0, lamps, 64);
 *     vxs_area_light_set(light, lamps, 64);
 *     vxs_area_light_cast(light, &(vxs_area_casters){points, count});   // again when anything has moved
 *     vxs_area_light_smoke(light, &(vxs_capsules){.list = smoke, .count = puffs}); // where there is smoke: when that or lamps have moved
 *
 *     vxs_volumes_area(air, light, &(vxs_area_look){0});                // each frame, behind vxs_volumes_begin
 *
 * Places of lamps and casters are metres from one place of the caller's choice, of which vxs_area_light_anchor tells where it is.
 * Source: [IVSV13].
 * SPDX-License-Identifier: MIT */
#ifndef VXS_AREA_LIGHT_H
#define VXS_AREA_LIGHT_H

#include "vxs_transmittance.h"
#include "vxs_volumes.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { VXS_VPLS_MAX = 256 }; /* no more at once */

/* virtual point lights ------------------------------------------------------------------------------------------------------------ */

/* A small piece of a surface that shines to one side: its intensity is `colour` times the cosine to its normal. */
typedef struct vxs_vpl {
    float place[3];
    float normal[3];     /* of length 1; all 0: it shines to all sides alike */
    float colour[3];     /* intensity along the normal, in candela, or in the units of the picture; >= 0 */
    float radius_metres; /* > 0: no eye ray passes nearer */
    uint32_t
        is_far; /* 1: it is far away: its light travels along the normal everywhere, and `colour` is the irradiance of what lies across that.
                            What casts its shadows is within radius_metres of its place */
} vxs_vpl;

/* A picture that shines, such as a screen or a window. */
typedef struct vxs_area_rectangle {
    float        corner[3];        /* from which the sides run; the picture's first texel is there */
    float        across[3], up[3]; /* both sides, metres; it shines to where their cross product points */
    float        radiance[3];      /* in each direction of that side alike, as of paper; >= 0 */
    const float *texture;          /* [high_px][wide_px][3] what the radiance is times, >= 0; NULL: 1 everywhere */
    uint32_t     wide_px, high_px; /* of the texture */
} vxs_area_rectangle;

/* How its places are chosen. */
typedef enum vxs_area_places {
    VXS_AREA_HALTON, /* points of Halton's sequence, of bases 2 and 3: any part of it is even, so that lamps may be added one by one */
    VXS_AREA_IMPORTANCE, /* points of Hammersley's set, moved to where the texture is bright: all lamps have one luminance, and none is where it is black */
    VXS_AREA_REGULAR,  /* the middles of equal cells, as square as `count` lets them be */
    VXS_AREA_JITTERED, /* a place at random in each of these cells */
} vxs_area_places;

/* Lamps of a rectangle. By importance all have one luminance, in the colour of their texel; else each has the light of all that is nearer to it than to others, by
 * 64 x 64 pieces, so that no bright place is missed; without a texture all are alike. Their sum is the rectangle's light, by importance in luminance.
 * seed   of what is at random; of Halton's and Hammersley's points a shift of all, round the edges. 0: none
 * lamps  [out] [count]
 * count  1 to VXS_VPLS_MAX
 * Returns VXS_OK; VXS_E_ARGUMENT for numbers that are none, a rectangle without area, or a texture without texels.
 * Cost: a reading of the texture, and 4096 distances for each lamp; of importance, two readings, and a row for each lamp. Threads: none shared; no memory is taken. */
vxs_result vxs_area_sample(const vxs_area_rectangle *rectangle, vxs_area_places places, uint32_t seed, vxs_vpl *lamps,
                           uint32_t count);

/* A picture of all that shines from far away, from each direction. */
typedef struct vxs_area_sky {
    const float      *
        texture; /* [high_px][wide_px][3] radiance, >= 0: rows of equal angles from the zenith, along y, down to the nadir; columns of equal angles from x by z
                             around */
    uint32_t wide_px, high_px;
    float    radiance[3];   /* what it is times, >= 0 */
    float    middle[3];     /* of a sphere about all that casts shadows; */
    float    radius_metres; /* its radius, > 0: shadow maps are as wide */
} vxs_area_sky;

/* Lamps of a sky, far away, likewise: texels count by their solid angle, and by importance by luminance times that.
 * seed, lamps, count  as above;   Returns, cost and threads likewise */
vxs_result vxs_area_sample_sky(const vxs_area_sky *sky, vxs_area_places places, uint32_t seed, vxs_vpl *lamps,
                               uint32_t count);

/* points of what casts shadows ---------------------------------------------------------------------------------------------------- */

/* A point of a surface, which stands for so much of it; as a storage buffer has it. */
typedef struct vxs_area_point {
    float place[3];
    float square_metres;
} vxs_area_point;

/* Points of triangles, as many on each as its part of the area is, in the order of the triangles, and on each along a curve: those that follow each other are
 * neighbours, so that one of each few is spread as evenly as all are.
 * positions  [3 * vertices] metres;   corners  [3 * triangle_count] vertices
 * points     [out] [count] all of one area
 * Returns the area of all triangles, in square metres; 0 where there is none, or it is no number, and then no points are written.
 * Threads: none shared; no memory is taken. */
double vxs_area_scatter(const float *positions, const uint32_t *corners, uint32_t triangle_count, vxs_area_point *points,
                        uint32_t count);

/* The same, denser where it matters to lamps: a quarter of the points by area, the others in proportion to what a face toward the lamps would get of their light
 * there, nothing between them. A large scene needs it, because points by area alone are far apart near a lamp.
 * lamps   [lamp_count] of each light about 16 are enough, as vxs_area_sample gives them; colours are weights. Those that are far away count as near ones
 * points  [out] [count] with areas of their own, which add up to about the whole
 * Returns, threads: as above; without light points are those of vxs_area_scatter.
 * Cost: for each lamp two looks at each triangle, and more at triangles that are wider than half of their distance. */
double vxs_area_scatter_for(const float *positions, const uint32_t *corners, uint32_t triangle_count, const vxs_vpl *lamps,
                            uint32_t lamp_count, vxs_area_point *points, uint32_t count);

/* the light ------------------------------------------------------------------------------------------------------------------------ */

typedef struct vxs_area_light vxs_area_light;

/* What is not named is 0, and means the default. */
typedef struct vxs_area_light_desc {
    uint32_t lamps;         /* the most that are set at once, VXS_VPLS_MAX and fewer; 0: all of them */
    uint32_t side_px;       /* of each lamp's imperfect shadow map: 32, 64, 128, 256; 0: 128 */
    uint32_t columns, rows; /* of each lamp's grid, whose eye rays have 128 bits: 1 to 256; 0: 128 */
    uint32_t takes_maps;    /* 1: exact light maps may be given in place of imperfect ones */
    uint32_t capsules;      /* of smoke, the most that there are at once, up to 2^24; 0: it takes none, and nothing is made for it */
    uint32_t smoke_side_px; /* curves a side of each lamp; 0: 64 */
    uint32_t smoke_nodes;   /* of each curve: 4, 8, 12, 16; 0: 4 */
} vxs_area_light_desc;

/* lamps * (16 * columns * rows + 5.4 * side_px * side_px) bytes of one storage buffer, 86 MiB by default, and three pictures of the view's size. With smoke, another
 * of lamps * 8 * smoke_nodes * smoke_side_px * smoke_side_px bytes, 32 MiB by default, and 32 for each capsule.
 * light  [out] NULL on failure
 * Returns VXS_OK; VXS_E_ARGUMENT; VXS_E_GL for a shader that does not compile, or more than a storage buffer of the context holds; VXS_E_MEMORY. */
vxs_result vxs_area_light_create(vxs_area_light **light, vxs_volumes *volumes, const vxs_area_light_desc *desc);
void       vxs_area_light_destroy(vxs_area_light *light); /* accepts NULL */

/* Its lamps; copied. Their shadow maps are those of before where nothing but colours has changed, as of a picture that moves; else they have none.
 * count  1 to those of create
 * Returns VXS_OK; VXS_E_ARGUMENT for numbers that are none, or normals of another length. */
vxs_result vxs_area_light_set(vxs_area_light *light, const vxs_vpl *lamps, uint32_t count);

/* Where the place is that lamps and casters count from, in metres from the origin that vxs_gl_origin was told last: again, when that origin follows a camera.
 * Shadow maps stay. Before the first call it is the origin.
 * Returns VXS_OK; VXS_E_ARGUMENT for numbers that are none. */
vxs_result vxs_area_light_anchor(vxs_area_light *light, const float place[3]);

typedef struct vxs_area_casters {
    unsigned buffer; /* of vxs_area_point, one behind the other; not read where count is 0 */
    uint32_t count;
    uint32_t is_whole; /* 1: each point is drawn into the map of each lamp; 0: of 64 points in a row, as many as the map can show, chosen anew for each
                          lamp, so that a map costs about the same for any number of points. Neighbours should follow each other, as vxs_area_scatter
                          and a file have them */
} vxs_area_casters;

/* Imperfect shadow maps of all lamps. A point is a disc of the surface that it lies on, a little wider than what it stands for; that surface is found by the points
 * before and behind it in the buffer, and where these lie on no plane it is a square across the light. Gaps between points are filled from coarser levels,
 * whether nothing is seen through them or something farther. Again, when lamps or casters have moved; between frames the maps stay.
 * Returns VXS_OK; VXS_E_ARGUMENT without lamps or a buffer, or where a lamp shines to all sides.
 * Cost: a look at each 64 points for each lamp, and about 4 * side_px^2 points drawn into each map at most where all that is seen is dense. */
vxs_result vxs_area_light_cast(vxs_area_light *light, const vxs_area_casters *casters);

/* How much smoke leaves of each lamp's light, on surfaces and in the air: curves as in vxs_transmittance.h, of the half of all directions that it shines to, or of the sphere
 * about its place where it is far away. Again, when lamps or smoke have moved; between frames they stay.
 * smoke  places count from where those of lamps do. What is thinner than a texel is as wide as one, and as much less dense. Without capsules nothing
 *        dims the light any more, and it costs nothing
 * Lamps with maps of baked lights are dimmed by the smoke that is baked for these, too, without this call; of others nothing is baked.
 * Returns VXS_OK; VXS_E_ARGUMENT without lamps, where a lamp shines to all sides, or for more capsules than create was told.
 * Cost: a workgroup for each lamp and 8 x 8 curves looks at all capsules, in their order. */
vxs_result vxs_area_light_smoke(vxs_area_light *light, const vxs_capsules *smoke);

/* 1: its lamps have imperfect shadow maps; 0: casting is to come. */
int vxs_area_light_is_cast(const vxs_area_light *light);

/* What a pixel gathers. */
typedef enum vxs_area_gather {
    VXS_AREA_EACH,    /* all lamps */
    VXS_AREA_NINTHS,  /* a ninth of them: each 3 x 3 pixels have all, and are mixed where they are as far away */
    VXS_AREA_QUARTER, /* all, of one pixel in four: others are mixed of those about them that are as far away */
} vxs_area_gather;

/* What is not named is 0, and means the default. */
typedef struct vxs_area_look {
    vxs_area_gather gather;
    uint32_t        runs;     /* as for vxs_volumes_grid, 128 at most; 0: 8 */
    uint32_t        is_sharp; /* 1: of a grid's rows the one that an eye ray is in, and not what lies between two */
    unsigned
                                normal_texture; /* GL_TEXTURE_2D of the view's size: normals of what was drawn, of length 1, 0 where nothing was; 0: airlight alone */
    const vxs_shadow_depth_map *const *maps; /* [lamps] of lamps that stay where they are: exact shadows; NULL: imperfect ones */
} vxs_area_look;

/* Add the airlight of all lamps to the frame's, by a grid for each, all made in one dispatch of all their light rays and one scan; and the light that they
 * send to surfaces, where normals are given. All pixels are drawn, whatever the frame's `least` is.
 * Returns VXS_OK; VXS_E_ARGUMENT without a frame, lamps, or their shadow maps, for curves of smoke of where lamps were before, for maps of a sun, or of lamps that are far away. */
vxs_result vxs_volumes_area(vxs_volumes *volumes, vxs_area_light *light, const vxs_area_look *look);

/* Irradiance of surfaces: RGBA32F, of the size of create, of which the view's corner is used; what fog takes between a lamp and a surface is taken. Of the last
 * look with normals. Valid until vxs_area_light_destroy. */
unsigned vxs_area_light_irradiance(const vxs_area_light *light);

#ifdef __cplusplus
}
#endif
#endif
