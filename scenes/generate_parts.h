/* Building blocks of generators: a scene that grows, closed and open shapes, lights.
 *
 *     parts p = parts_begin(s, "room");
 *     parts_mesh(&p, "table", 0);
 *     parts_box(&p, parts_upright, low, high);
 *     return parts_end(&p, m);
 *
 * Out of memory is recorded; later calls have no effect, and parts_end reports it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GENERATE_PARTS_H
#define GENERATE_PARTS_H

#include "baker/base/random.h"
#include "baker/scene/gltf/glb_write.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct parts {
    glb_scene *s;
    size_t     vertices, texcoords, triangles, meshes, materials, images, lights, smoke,
        smoke_vertices; /* capacities of the scene's arrays */
    int out_of_memory;
} parts;

/* Frame of a part: moved to `at`, and rotated about +Y by the angle with that cosine and sine. */
typedef struct parts_frame {
    double at[3];
    double cosine, sine; /* cosine^2 + sine^2 = 1 */
} parts_frame;

static const parts_frame parts_upright = {{0, 0, 0}, 1, 0};

/* s  [out] zeroed, then filled; the caller releases it with glb_scene_free, unless parts_end fails */
parts parts_begin(glb_scene *s, const char *name);

/* Append to a finished scene; call parts_mesh before adding shapes. */
parts parts_continue(glb_scene *s);

/* Returns VXS_OK, or VXS_E_MEMORY with the scene released and zeroed. Removes the last mesh if it is empty. */
vxs_result parts_end(parts *p, run_context *m);

/* Begin a new mesh for the following shapes. material: as in glb_mesh. */
void parts_mesh(parts *p, const char *name, uint32_t material);

/* Begin a new run of smoke. lines, material: as in glb_smoke. */
void parts_smoke(parts *p, const char *name, int lines, uint32_t material);
/* Add a point, or an end of a line. */
void parts_smoke_vertex(parts *p, const double place[3], double radius_metres, double extinction);

/* Returns 1 + the new material's index, as in glb_mesh.material. */
uint32_t parts_material(parts *p, glb_material material);

/* Returns 1 + the new image's index. Takes ownership of rgba, from malloc; NULL counts as out of memory. */
uint32_t parts_image(parts *p, uint32_t width_px, uint32_t height_px, uint8_t *rgba);

/* Returns the vertex's number within the mesh. The position is rounded to float. */
uint32_t parts_vertex(parts *p, double x, double y, double z);
/* As parts_vertex, with a texture coordinate. If a scene uses it, all vertices of meshes with an image must. */
uint32_t parts_vertex_uv(parts *p, const double position[3], double u, double v);
void     parts_triangle(parts *p, uint32_t a, uint32_t b, uint32_t c);

/* A closed box, 12 triangles; low and high in the frame. It is inside out if high < low on one axis or three. */
void parts_box(parts *p, parts_frame f, const double low[3], const double high[3]);

/* The triangles of a box whose eight vertices begin at `first`: vertex c is at the high end of axis a if bit a of c is set. */
void parts_box_triangles(parts *p, uint32_t first);

/* An upright box.  mesh: the name of a new mesh for it, without a material; NULL: append to the last mesh. */
void parts_box_at(parts *p, const char *mesh, double x0, double x1, double y0, double y1, double z0, double z1);

/* Two triangles a b c, a c d; counter-clockwise seen from the front. */
void parts_quad(parts *p, const double a[3], const double b[3], const double c[3], const double d[3]);

/* A sheet of columns x rows cells over a parallelogram: corner, corner + u, corner + v; its front is where u x v points. */
void parts_grid(parts *p, const double corner[3], const double u[3], const double v[3], uint32_t columns, uint32_t rows);

/* A surface of revolution about +Y: count points (radius, height) from the top down, facing outward, segments (a multiple of 4)
 * around. A radius of 0 is allowed only at an end, and closes it by a point.
 * 2 segments (count - 1) triangles, less segments for each end of radius 0. */
void parts_lathe(parts *p, const double at[3], const double (*profile)[2], uint32_t count, uint32_t segments);

/* A closed tube between two regular polygons: sides around, 4 sides - 4 triangles. The polygons are horizontal: rising branches
 * are sheared, not bent. From bottom to top, radii > 0, sides a multiple of 4. */
void parts_tube(parts *p, const double bottom[3], double bottom_radius, const double top[3], double top_radius, uint32_t sides);

void parts_light(parts *p, const char *name, light_shape shape);
void parts_point(parts *p, const char *name, const double at[3], double range_metres);
/* degrees: from the axis to the edge of the cone */
void parts_spot(parts *p, const char *name, const double at[3], const double direction[3], int degrees, double range_metres);
/* A directional light "sun". */
void parts_sun(parts *p, const double direction[3]);

/* Cosine and sine of k / n turns, for k in [0, n), n a multiple of 4: exact at quarters, else a point of the unit circle by
 * the rational parametrisation of each quarter, (1 - t^2, 2 t) / (1 + t^2): in order, but not evenly spaced. */
void parts_turn(uint32_t k, uint32_t n, double *cosine, double *sine);

#ifdef __cplusplus
}
#endif

/* A position for a spot above the street, under a street lamp's arm. along, out: unit, horizontal: along the street, and towards
 * its middle. */
typedef struct city_lamp {
    double head[3], along[3], out[3];
} city_lamp;

typedef struct city_block {
    const city_lamp *lamps;
    uint32_t         lamp_count;
    size_t           box_first, box_count; /* the block's boxes, eight vertices of the scene each: corner c is at the high end of
                                              axis a if bit a of c is set */
    double           x, z;                 /* its centre, metres */
    double           half, street;         /* half its side, and the width of the streets around it, metres */
} city_block;

/* Add `count` spots, named spot%04u from *made + 1: first one under each lamp, the rest alternately on walls and over the
 * streets. None is inside one of the block's boxes, or closer to it than 10 cm. Each points down, and slightly along the street
 * or away from the wall. Cones of 20 to 60 degrees, from the axis to the edge; 15 to 40 m of range. */
void add_city_spots(parts *p, const city_block *k, rng r, uint32_t count, uint32_t *made);

#endif
