/* Edge cases for a baker; tests/cli/test_stress.py has the expected results.
 *
 * Most have a ground with its top at y = 0 and a sun that falls at 45 degrees towards +X, so that a shadow is as far beside its
 * caster as the caster is high.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scenes/generate.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/random.h"
#include "scenes/generate_parts.h"

static const double slanted[3] = {1, -1, 0}, straight_down[3] = {0, -1, 0};

/* ---- parts of these scenes ---- */

/* A horizontal sheet that faces up. */
static void sheet_at(parts *p, double x0, double x1, double y, double z0, double z1)
{
    parts_quad(p, (double[3]){x0, y, z0}, (double[3]){x0, y, z1}, (double[3]){x1, y, z1}, (double[3]){x1, y, z0});
}

/* An upright sheet across Z. */
static void upright_sheet_at(parts *p, double x0, double x1, double y0, double y1, double z)
{
    parts_quad(p, (double[3]){x0, y0, z}, (double[3]){x1, y0, z}, (double[3]){x1, y1, z}, (double[3]){x0, y1, z});
}

static void ground(parts *p, double half)
{
    parts_box_at(p, "ground", -half, half, -1, 0, -half, half);
}

/* ---- places and sizes ---- */

/* Bars 1 cm thick and 10 cm apart, a metre above the ground. Positions are near the mesh's origin; its node is far away. */
static void far_coordinates(parts *p)
{
    const double at[3] = {1e7, 250000, -1e7};
    parts_box_at(p, "ground", -2, 2, -0.5, 0, -2, 2);
    parts_mesh(p, "bars", 0);
    for (int i = 0; i < 20; i++) parts_box_at(p, NULL, -1.5 + i * 0.1, -1.49 + i * 0.1, 1, 1.01, -1, 1);
    for (size_t i = 0; !p->out_of_memory && i < p->s->mesh_count; i++) memcpy(p->s->meshes[i].translation, at, sizeof at);
    parts_sun(p, slanted);
    parts_spot(p, "spot", (double[3]){at[0], at[1] + 3, at[2]}, straight_down, 50, 10);
}

/* In units of 0.1 micrometre. */
static void tiny_scene(parts *p)
{
    const double unit = 1e-7;
    parts_box_at(p, "ground", -5 * unit, 5 * unit, -unit, 0, -5 * unit, 5 * unit);
    parts_box_at(p, "block", -unit, unit, 2 * unit, 3 * unit, -unit, unit);
    parts_sun(p, slanted);
    parts_spot(p, "spot", (double[3]){0, 8 * unit, 0}, straight_down, 30, 100 * unit);
}

/* Casters 1 mm, 1 m and 1 km below the lights, which are at the origin, where floats are most precise. */
static void near_far(parts *p)
{
    parts_box_at(p, "ground", -600, 600, -1001, -1000, -600, 600);
    parts_box_at(p, "house", -220, -180, -1000.5, -980, -20, 20);
    parts_mesh(p, "near sheets", 0);
    sheet_at(p, 0.0002, 0.0004, -0.001, -0.0001, 0.0001);
    sheet_at(p, -0.1, -0.05, -1, 0.3, 0.35);
    parts_spot(p, "spot", (double[3]){0, 0, 0}, straight_down, 30, 2000);
    parts_point(p, "point", (double[3]){0, 0, 0}, 2000);
}

/* As far away as far_coordinates, but by the vertices themselves: at this distance floats resolve only whole metres. */
static void far_vertices(parts *p)
{
    const double x = 1e7, z = -1e7;
    parts_box_at(p, "ground", x - 60, x + 60, -1, 0, z - 60, z + 60);
    parts_box_at(p, "block", x - 10, x + 10, 20, 30, z - 10, z + 10);
}

/* Boxes of a millimetre beside one of 200 km. */
static void huge_and_tiny(parts *p)
{
    parts_box_at(p, "ground", -1e6, 1e6, -1e5, 0, -1e6, 1e6);
    parts_box_at(p, "huge", -1e5, 1e5, 1e5, 2e5, -1e5, 1e5);
    parts_mesh(p, "tiny", 0);
    for (int i = 0; i < 100; i++) parts_box_at(p, NULL, -1.001 - i * 0.01, -1 - i * 0.01, 0, 0.001, 0, 0.001);
}

static void one_triangle(parts *p)
{
    parts_mesh(p, "triangle", 0);
    uint32_t a = parts_vertex(p, -1, 0, -1), b = parts_vertex(p, -1, 0, 1), c = parts_vertex(p, 1, 0, 0);
    parts_triangle(p, a, b, c);
}

/* ---- lights ---- */

/* z is the sine of 0.01 degrees; the length is 1 within 5e-5. */
static void grazing_wall(parts *p)
{
    const double direction[3] = {1, -0.01, 0.00017453};
    parts_box_at(p, "ground", 0, 1000, -1, 0, -5, 5);
    parts_box_at(p, "wall", 0, 1000, -0.5, 3, -0.3, 0);
    parts_sun(p, direction);
}

/* A solid wall, one without thickness, and one whose plane contains the spot. */
static void wall_along_light(parts *p)
{
    parts_box_at(p, "solid wall", -3, 3, -0.5, 3, -0.1, 0.1);
    parts_mesh(p, "sheet wall", 0);
    upright_sheet_at(p, -3, 3, -0.5, 3, 2);
    parts_mesh(p, "sheet wall of the spot", 0);
    upright_sheet_at(p, -3, 3, -0.5, 3, -2);
    parts_sun(p, slanted);
    parts_spot(p, "spot", (double[3]){-5, 5, -2}, slanted, 40, 30);
}

static void no_light(parts *p)
{
    parts_box_at(p, "block", -1, 1, 2, 3, -1, 1);
}

static void light_in_wall(parts *p)
{
    parts_box_at(p, "wall", -0.5, 0.5, -0.5, 4, -4, 4);
    parts_sun(p, slanted);
    parts_point(p, "lamp", (double[3]){0, 2, 0}, 20);
}

/* A caster above the light, one that covers the whole sky, and one beside it that extends from behind the light to before it. */
static void caster_behind_light(parts *p)
{
    parts_box_at(p, "behind", -1, 1, 5, 6, -1, 1);
    parts_box_at(p, NULL, -8, 8, 7, 8, -8, 8);
    parts_box_at(p, NULL, 1, 2, 3.5, 4.5, -1, 1);
    parts_spot(p, "spot", (double[3]){0, 4, 0}, straight_down, 45, 20);
}

/* ---- triangles ---- */

static void triangle(parts *p, const double a[3], const double b[3], const double c[3])
{
    uint32_t i = parts_vertex(p, a[0], a[1], a[2]), j = parts_vertex(p, b[0], b[1], b[2]), k = parts_vertex(p, c[0], c[1], c[2]);
    parts_triangle(p, i, j, k);
}

static void zero_area_and_needles(parts *p)
{
    const double a[3] = {-1, 1, -3}, b[3] = {0, 1, -3}, c[3] = {1, 1, -3};
    parts_mesh(p, "no area", 0);
    triangle(p, a, a, a);
    triangle(p, a, a, c);
    triangle(p, a, c, c);
    triangle(p, a, b, c);
    triangle(p, c, b, a);
    parts_mesh(p, "needles", 0);
    for (int i = 0; i < 100; i++) {
        double z = -2 + i * 0.02, width = i < 50 ? 1e-6 : 1e-4;
        triangle(p, (double[3]){-4, 2, z}, (double[3]){2, 2, z + width}, (double[3]){2, 2, z});
    }
    parts_box_at(p, "block", -1, 1, 1, 2, 2, 4);
}

/* A closed surface, whatever the order of its corners. */
static void tetrahedron(parts *p, double corner[4][3])
{
    double   edge[3][3], volume = 0;
    uint32_t at[4];
    for (int n = 0; n < 3; n++)
        for (int k = 0; k < 3; k++) edge[n][k] = corner[n + 1][k] - corner[0][k];
    for (int k = 0; k < 3; k++)
        volume += edge[0][k] * (edge[1][(k + 1) % 3] * edge[2][(k + 2) % 3] - edge[1][(k + 2) % 3] * edge[2][(k + 1) % 3]);
    for (int n = 0; n < 4; n++) at[n] = parts_vertex(p, corner[n][0], corner[n][1], corner[n][2]);
    uint32_t a = at[volume < 0 ? 2 : 1], b = at[volume < 0 ? 1 : 2];
    parts_triangle(p, at[0], b, a);
    parts_triangle(p, at[0], a, at[3]);
    parts_triangle(p, a, b, at[3]);
    parts_triangle(p, b, at[0], at[3]);
}

/* Solids of 6 m by 10 micrometres to a millimetre, in all directions of a sloping plane. */
static void solid_needles(parts *p)
{
    parts_mesh(p, "needles", 0);
    for (uint32_t i = 0; i < 200; i++) {
        double c, s, thick = i % 2 ? 1e-3 : 1e-5, y = 3 + i * 0.002;
        parts_turn(i, 200, &c, &s);
        tetrahedron(p, (double[4][3]){{-3 * c, y - c, -3 * s},
                                      {3 * c, y + c, 3 * s},
                                      {3 * c - thick * s, y + c, 3 * s + thick * c},
                                      {3 * c, y + c + thick, 3 * s}});
    }
    parts_box_at(p, "block", -1, 1, 1, 2, 4, 6);
}

/* Solids of a tenth of a millimetre to a centimetre. */
static void dust(parts *p)
{
    rng r = rng_split(1, 0);
    parts_mesh(p, "dust", 0);
    for (int i = 0; i < 5000; i++) {
        double corner[4][3], size = i % 100 ? 1e-4 * (1 + i % 10) : 1e-2;
        double at[3] = {2 * rng_unit(&r) - 1, 1 + 2 * rng_unit(&r), 2 + rng_unit(&r)};
        for (int n = 0; n < 4; n++)
            for (int k = 0; k < 3; k++) corner[n][k] = at[k] + size * (rng_unit(&r) + (n == k + 1));
        tetrahedron(p, corner);
    }
    parts_box_at(p, "block", -1, 1, 1, 2, -4, -2);
}

/* Two cones base to base: 100 000 triangles meet at each tip. */
static void fan_100000(parts *p)
{
    enum { AROUND = 100000 };
    parts_mesh(p, "cones", 0);
    uint32_t top = parts_vertex(p, 0, 4, 0), bottom = parts_vertex(p, 0, 2, 0), first = bottom + 1;
    for (uint32_t i = 0; i < AROUND; i++) {
        double c, s;
        parts_turn(i, AROUND, &c, &s);
        parts_vertex(p, 2 * c, 3, 2 * s);
    }
    for (uint32_t i = 0; i < AROUND; i++) {
        uint32_t a = first + i, b = first + (i + 1) % AROUND;
        parts_triangle(p, top, b, a);
        parts_triangle(p, bottom, a, b);
    }
}

/* Quads whose sides cross, three sheets with a common edge, solids that share only a corner or an edge. */
static void bow_ties(parts *p)
{
    parts_mesh(p, "bow-tie", 0);
    triangle(p, (double[3]){-4, 2, -2}, (double[3]){-4, 2, 2}, (double[3]){-2, 2, 0});
    triangle(p, (double[3]){-2, 2, 0}, (double[3]){0, 2, 2}, (double[3]){0, 2, -2});
    parts_mesh(p, "quad that crosses itself", 0);
    parts_quad(p, (double[3]){-4, 1, 4}, (double[3]){-2, 1, 6}, (double[3]){-4, 1, 6}, (double[3]){-2, 1, 4});
    parts_mesh(p, "book", 0);
    for (int i = -1; i <= 1; i++)
        parts_quad(p, (double[3]){2, 2, -6}, (double[3]){2, 2, -4}, (double[3]){4, 2 + i, -4}, (double[3]){4, 2 + i, -6});
    parts_box_at(p, "at corners", 0, 1, 1, 2, 4, 5);
    parts_box_at(p, NULL, 1, 2, 2, 3, 5, 6);
    parts_box_at(p, "at edges", 2, 3, 1, 2, 0, 1);
    parts_box_at(p, NULL, 3, 4, 2, 3, 0, 1);
}

/* Borders with 7 and 11 quads on the two sides of a fold. */
static void t_junctions(parts *p)
{
    parts_mesh(p, "level", 0);
    parts_grid(p, (double[3]){-2, 2, -2}, (double[3]){0, 0, 4}, (double[3]){2, 0, 0}, 7, 3);
    parts_mesh(p, "sloped", 0);
    parts_grid(p, (double[3]){0, 2, -2}, (double[3]){0, 0, 4}, (double[3]){2, 0.5, 0.25}, 11, 5);
}

/* Sheets at the same place except for rounding, and for the diagonals of their cells. */
static void z_fighting(parts *p)
{
    enum { CELLS = 20, SHEETS = 6 };
    for (int sheet = 0; sheet < SHEETS; sheet++) {
        parts_mesh(p, "sheet", 0);
        uint32_t first = 0;
        for (uint32_t n = 0; n < (CELLS + 1) * (CELLS + 1); n++) {
            rng      r = rng_split(2, n);
            uint32_t i = n % (CELLS + 1), j = n / (CELLS + 1);
            uint32_t at = parts_vertex(p, -2 + i * 0.2, 2 + 0.2 * rng_unit(&r) + sheet * 1e-7, -2 + j * 0.2);
            if (!n) first = at;
        }
        for (uint32_t n = 0; n < CELLS * CELLS; n++) {
            uint32_t a = first + n / CELLS * (CELLS + 1) + n % CELLS, b = a + 1, c = a + CELLS + 1, d = c + 1;
            if (sheet % 2) {
                parts_triangle(p, a, c, d);
                parts_triangle(p, a, d, b);
            } else {
                parts_triangle(p, a, c, b);
                parts_triangle(p, b, c, d);
            }
        }
    }
}

/* A sheet with large holes, filter nearest, over one with fine holes, bilinear; both lean. */
static void checkered_masks(parts *p)
{
    for (int fine = 0; fine < 2; fine++) {
        uint32_t side = fine ? 256 : 4, at[4];
        double   low = fine ? 1 : 2, x0 = fine ? 2 : -2;
        uint8_t *rgba = malloc((size_t)4 * side * side);
        for (uint32_t n = 0; rgba && n < side * side; n++)
            memcpy(rgba + 4 * (size_t)n, (uint8_t[4]){128, 128, 128, (n + n / side) % 2 ? 0 : 255}, 4);
        uint32_t image = parts_image(p, side, side, rgba);
        parts_mesh(p, "checkered",
                   parts_material(p, (glb_material){.name = "checkered", .alpha_cutoff = 0.5, .image = image, .nearest = !fine}));
        for (int n = 0; n < 4; n++)
            at[n] = parts_vertex_uv(p, (double[3]){x0 + 4 * (n >> 1), low + (n >> 1) * fine, -2 + 4 * (n & 1)}, n >> 1, n & 1);
        parts_triangle(p, at[0], at[1], at[3]);
        parts_triangle(p, at[0], at[3], at[2]);
    }
}

/* The same boxes and sheets twice, boxes that share planes, and a sheet with its own back side. */
static void coplanar_duplicates(parts *p)
{
    for (int again = 0; again < 2; again++) {
        ground(p, 8);
        parts_box_at(p, "block", -1, 1, 1, 2, -1, 1);
    }
    parts_box_at(p, "blocks with shared planes", 2, 3, 1, 2, -1, 1);
    parts_box_at(p, NULL, 2.5, 3.5, 1, 2, -1, 1);
    parts_box_at(p, NULL, 2.25, 3.25, 1, 2, -1, 1);
    parts_mesh(p, "sheets", 0);
    for (int again = 0; again < 3; again++) sheet_at(p, -4, -3, 1.5, -1, 1);
    sheet_at(p, -4, -3, 3, 2, 3);
    sheet_at(p, -3, -4, 3, 2, 3);
}

static void close_sheets(parts *p)
{
    parts_mesh(p, "lower", 0);
    sheet_at(p, -1, 1, 2, -1, 1);
    parts_mesh(p, "upper", 0);
    sheet_at(p, 0, 2, 2 + 1e-6, -1, 1);
}

/* accessor 2, position 2 */
static void broken_vertices(parts *p, double value)
{
    parts_mesh(p, "broken", 0);
    triangle(p, (double[3]){-1, 1, -1}, (double[3]){-1, 1, 1}, (double[3]){1, value, 0});
    triangle(p, (double[3]){-1, 2, -1}, (double[3]){-1, 2, 1}, (double[3]){1, 2, 0});
}

static void nan_vertices(parts *p)
{
    broken_vertices(p, NAN);
}

static void infinite_vertices(parts *p)
{
    broken_vertices(p, INFINITY);
}

/* ---- solids ---- */

static void nested_100(parts *p)
{
    parts_mesh(p, "boxes", 0);
    for (int i = 0; i < 100; i++) {
        double half = 5 * (100 - i) / 100.0;
        parts_box_at(p, NULL, -half, half, 6 - half, 6 + half, -half, half);
    }
}

/* Bars rotated about their middle, which is in all of them. */
static void intersecting_100(parts *p)
{
    parts_mesh(p, "bars", 0);
    for (uint32_t i = 0; i < 100; i++) {
        parts_frame f = {{0, 3 + i * 0.002, 0}, 1, 0};
        parts_turn(i, 200, &f.cosine, &f.sine);
        parts_box(p, f, (double[3]){-4, -0.5, -0.15}, (double[3]){4, 0.5, 0.15});
    }
}

/* Blocks of 3 x 3 x 3 boxes whose faces touch. */
static void touching_27(parts *p)
{
    parts_mesh(p, "boxes", 0);
    for (int n = 0; n < 27; n++) {
        double x = -1.5 + n % 3, y = 1 + n / 3 % 3, z = -1.5 + n / 9;
        parts_box_at(p, NULL, x, x + 1, y, y + 1, z, z + 1);
    }
}

/* Boxes that intersect, with common planes at their tops and bottoms. */
static void common_planes_50(parts *p)
{
    parts_mesh(p, "boxes", 0);
    for (int i = 0; i < 50; i++) parts_box_at(p, NULL, -2 + i * 0.05, -1 + i * 0.0625, 1, 2, -1 - i * 0.01, 1 - i * 0.02);
}

/* A five-pointed star drawn in one line: the winding number of its middle is two. */
static void crossing_itself(parts *p)
{
    static const double tip[5][2] = {
        {2, 0}, {-1.618034, 1.1755705}, {0.618034, -1.902113}, {0.618034, 1.902113}, {-1.618034, -1.1755705}};
    parts_mesh(p, "star", 0);
    uint32_t low = parts_vertex(p, 0, 1, 0), high = parts_vertex(p, 0, 1.5, 0), first = high + 1;
    for (int n = 0; n < 10; n++) parts_vertex(p, tip[n / 2][0], n % 2 ? 1.5 : 1, tip[n / 2][1]);
    for (uint32_t n = 0; n < 5; n++) {
        uint32_t a = first + 2 * n, b = first + 2 * ((n + 1) % 5);
        parts_triangle(p, low, a, b);
        parts_triangle(p, high, b + 1, a + 1);
        parts_triangle(p, a, a + 1, b + 1);
        parts_triangle(p, a, b + 1, b);
    }
}

/* A strip a millimetre thick, rolled up 50 times. */
static void spiral(parts *p)
{
    enum { SEGMENTS = 64, STEPS = 50 * SEGMENTS };
    parts_mesh(p, "roll", 0);
    uint32_t first = 0;
    for (uint32_t n = 0; n <= STEPS; n++) {
        double c, s, radius = 0.5 + (double)n / STEPS;
        parts_turn(n % SEGMENTS, SEGMENTS, &c, &s);
        for (int k = 0; k < 4; k++) {
            double   at     = radius - (k % 2 ? 0.001 : 0);
            uint32_t vertex = parts_vertex(p, at * c, k / 2 ? 2 : 1, at * s);
            if (!n && !k) first = vertex;
        }
    }
    /* corners of a cross section: outside and inside below, outside and inside above */
    static const uint32_t about[5] = {0, 2, 3, 1, 0};
    for (uint32_t n = 0; n < STEPS; n++)
        for (int k = 0; k < 4; k++) {
            uint32_t a = first + 4 * n + about[k], b = first + 4 * n + about[k + 1];
            parts_triangle(p, a, b, a + 4);
            parts_triangle(p, b, b + 4, a + 4);
        }
    for (int end = 0; end < 2; end++) {
        uint32_t a = end ? first + 4 * STEPS : first, b = a + (end ? 2 : 1), c = a + (end ? 1 : 2);
        parts_triangle(p, a, b, c);
        parts_triangle(p, b, a + 3, c);
    }
}

/* Three stacks of a thousand: separate solids, solids that each intersect the next, sheets. */
static void layers_1000(parts *p)
{
    const double nearly_down[3] = {0.01, -1, 0.02};
    parts_mesh(p, "apart", 0);
    for (int i = 0; i < 1000; i++) parts_box_at(p, NULL, -3, -1, 0.5 + i * 0.1, 0.55 + i * 0.1, -1, 1);
    parts_mesh(p, "into each other", 0);
    for (int i = 0; i < 1000; i++) parts_box_at(p, NULL, 1 + i % 7 * 0.01, 3 - i % 5 * 0.01, 0.5 + i * 0.1, 0.65 + i * 0.1, -1, 1);
    parts_mesh(p, "sheets", 0);
    for (int i = 0; i < 1000; i++) sheet_at(p, 5, 7, 0.5 + i * 0.1, -1, 1);
    parts_sun(p, nearly_down);
}

/* A closed box that faces inward, with objects and a light in it. */
static void inside_out_room(parts *p)
{
    parts_box_at(p, "ground", -10, 10, -2, -1, -10, 10);
    parts_box_at(p, "room", 4, -4, 0, 3, -3, 3);
    parts_box_at(p, "table", -1, 1, 0.7, 0.8, -0.5, 0.5);
    parts_box_at(p, "crate", 2, 3, 0, 1, 1, 2);
    parts_sun(p, slanted);
    parts_point(p, "lamp", (double[3]){0, 2.5, 0}, 30);
}

/* ---- one-sided surfaces ---- */

/* A strip of `columns` quads around, whose end is joined to its beginning upside down: vertex (columns, j) is (0, last - j).
 * If the grid is also closed across, row `rows` is row 0. */
static void add_twisted(parts *p, uint32_t columns, uint32_t rows, int closed,
                        void (*at)(double half[2], double across, double v[3]))
{
    uint32_t stride = closed ? rows : rows + 1, first = 0;
    for (uint32_t i = 0; i < columns; i++)
        for (uint32_t j = 0; j < stride; j++) {
            double half[2], v[3];
            parts_turn(i, 2 * columns, &half[0], &half[1]);
            at(half, (double)j / rows, v);
            uint32_t vertex = parts_vertex(p, v[0], v[1], v[2]);
            if (!i && !j) first = vertex;
        }
    for (uint32_t i = 0; i < columns; i++)
        for (uint32_t j = 0; j < rows; j++) {
            uint32_t row[2] = {j % stride, (j + 1) % stride}, corner[4];
            for (int k = 0; k < 4; k++) {
                uint32_t r = row[k & 1], back = closed ? (rows - r) % rows : rows - r;
                corner[k] = first + (k < 2 ? i * stride + r : i + 1 == columns ? back : (i + 1) * stride + r);
            }
            parts_triangle(p, corner[0], corner[1], corner[3]);
            parts_triangle(p, corner[0], corner[3], corner[2]);
        }
}

/* half: cosine and sine of half the angle around. */
static void around(const double half[2], double radius, double y, double v[3])
{
    v[0] = radius * (2 * half[0] * half[0] - 1);
    v[1] = y;
    v[2] = radius * 2 * half[0] * half[1];
}

static void moebius_at(double half[2], double across, double v[3])
{
    double w = 2 * across - 1;
    around(half, 2 + w * half[0], 2.5 + w * half[1], v);
}

/* A figure of eight, rotated by half a turn on its way around. */
static void klein_at(double half[2], double across, double v[3])
{
    double c, s;
    parts_turn((uint32_t)(across * 32 + 0.5), 32, &c, &s);
    around(half, 2 + (half[0] * s - half[1] * 2 * s * c), 2.5 + (half[1] * s + half[0] * 2 * s * c), v);
}

static void moebius_band(parts *p)
{
    parts_mesh(p, "band", 0);
    add_twisted(p, 64, 8, 0, moebius_at);
}

static void klein_bottle(parts *p)
{
    parts_mesh(p, "bottle", 0);
    add_twisted(p, 64, 32, 1, klein_at);
}

/* ---- all of them ---- */

static const struct {
    const char *name, *purpose;
    void (*make)(parts *p);
    double        ground; /* half of its side, or 0: make adds what there is */
    const double *sun;
} cases[] = {
    {"far-coordinates", "details of a centimetre, 10 000 km from the origin", far_coordinates, 0, NULL},
    {"near-far", "a caster 1 mm from the lights, and one 1 km away", near_far, 0, NULL},
    {"grazing-wall", "sunlight along a wall of 1 km, at 0.01 degrees to it", grazing_wall, 0, NULL},
    {"wall-along-light", "walls that lie in the direction of the light", wall_along_light, 10, NULL},
    {"zero-area-and-needles", "triangles without area, and of 6 m by a micrometre", zero_area_and_needles, 6, slanted},
    {"coplanar-duplicates", "the same triangles twice and thrice, and solids with common planes", coplanar_duplicates, 0, slanted},
    {"close-sheets", "two sheets a micrometre apart", close_sheets, 6, slanted},
    {"nested-100", "100 boxes, each inside the one before", nested_100, 20, slanted},
    {"intersecting-100", "100 solids, each of which meets all others", intersecting_100, 12, slanted},
    {"layers-1000", "1000 solids and 1000 sheets above each other", layers_1000, 12, NULL},
    {"klein-bottle", "a closed surface with one side", klein_bottle, 8, straight_down},
    {"moebius-band", "an open surface with one side", moebius_band, 8, straight_down},
    {"inside-out-room", "a closed room that faces inward, with a light and things in it", inside_out_room, 0, NULL},
    {"nan-vertices", "a position that is no number", nan_vertices, 5, slanted},
    {"infinite-vertices", "a position at infinity", infinite_vertices, 5, slanted},
    {"empty-scene", "a sun and nothing that it could shine on", NULL, 0, slanted},
    {"one-triangle", "the smallest scene there is", one_triangle, 0, slanted},
    {"no-light", "casters and no light", no_light, 5, NULL},
    {"light-in-wall", "a point light inside a solid wall", light_in_wall, 8, NULL},
    {"caster-behind-light", "casters behind a spot, and beside it", caster_behind_light, 8, NULL},
    {"tiny-scene", "a scene of a thousandth of a millimetre", tiny_scene, 0, NULL},
    {"far-vertices", "vertices 10 000 km from the origin, where floats are whole metres", far_vertices, 0, slanted},
    {"huge-and-tiny", "boxes of a millimetre and of 200 km", huge_and_tiny, 0, slanted},
    {"solid-needles", "solids of 6 m by 10 micrometres", solid_needles, 8, slanted},
    {"dust", "5000 solids smaller than a texel", dust, 8, slanted},
    {"fan-100000", "100 000 triangles that meet at a vertex", fan_100000, 8, slanted},
    {"bow-ties", "sheets that cross themselves, solids that touch at a corner and an edge", bow_ties, 8, slanted},
    {"t-junctions", "borders of sheets with other vertices on either side", t_junctions, 8, slanted},
    {"z-fighting", "six sheets that differ by rounding", z_fighting, 8, slanted},
    {"checkered-masks", "alpha masks of 4 and of 256 pixels a side, in turns", checkered_masks, 8, slanted},
    {"touching-27", "boxes whose faces lie on each other", touching_27, 8, slanted},
    {"common-planes-50", "solids that meet, with tops and bottoms in common", common_planes_50, 8, slanted},
    {"crossing-itself", "a solid that crosses itself", crossing_itself, 8, slanted},
    {"spiral", "a strip of a millimetre, rolled up 50 times", spiral, 8, slanted},
};
enum { CASES = sizeof cases / sizeof *cases };

const char *stress_name(size_t i)
{
    return i < CASES ? cases[i].name : NULL;
}

const char *stress_purpose(size_t i)
{
    return i < CASES ? cases[i].purpose : NULL;
}

vxs_result stress_check(const char *name, run_context *m)
{
    char   names[768] = "";
    size_t used       = 0;
    for (size_t i = 0; i < CASES; i++) {
        if (!strcmp(name, cases[i].name)) return VXS_OK;
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", cases[i].name);
        if (used >= sizeof names) break;
    }
    return fail(m, VXS_E_ARGUMENT, "--case %s: expected one of %s", name, names);
}

vxs_result generate_stress(glb_scene *s, const char *name, run_context *m)
{
    *s = (glb_scene){0};
    for (size_t i = 0; i < CASES; i++) {
        if (strcmp(name, cases[i].name)) continue;
        parts p = parts_begin(s, cases[i].name);
        if (cases[i].ground > 0) ground(&p, cases[i].ground);
        if (cases[i].make) cases[i].make(&p);
        if (cases[i].sun) parts_sun(&p, cases[i].sun);
        return parts_end(&p, m);
    }
    return stress_check(name, m);
}
