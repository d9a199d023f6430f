/* Scenes at the edges of what a baker can be given; tests/cli/test_stress.py holds what has to come of each.
 *
 * Most have a ground whose top is y = 0 and a sun that falls at 45 degrees towards +X, so that a shadow lies beside what casts it
 * by as much as that is high.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/generate/generate.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "baker/generate/generate_parts.h"

static const double slanted[3] = {1, -1, 0}, straight_down[3] = {0, -1, 0};

/* ---- parts of these scenes ---- */

/* A level sheet that faces up. */
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

/* In units of a tenth of a micrometre. */
static void tiny_scene(parts *p)
{
    const double unit = 1e-7;
    parts_box_at(p, "ground", -5 * unit, 5 * unit, -unit, 0, -5 * unit, 5 * unit);
    parts_box_at(p, "block", -unit, unit, 2 * unit, 3 * unit, -unit, unit);
    parts_sun(p, slanted);
    parts_spot(p, "spot", (double[3]){0, 8 * unit, 0}, straight_down, 30, 100 * unit);
}

/* Casters 1 mm, 1 m and 1 km below the lights, which stand at the origin, where floats are finest. */
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

static void empty_scene(parts *p)
{
    parts_sun(p, slanted);
}

static void one_triangle(parts *p)
{
    parts_mesh(p, "triangle", 0);
    uint32_t a = parts_vertex(p, -1, 0, -1), b = parts_vertex(p, -1, 0, 1), c = parts_vertex(p, 1, 0, 0);
    parts_triangle(p, a, b, c);
    parts_sun(p, slanted);
}

/* ---- lights ---- */

/* The sine of 0.01 degrees, against a length that is 1 but for 5e-5. */
static void grazing_wall(parts *p)
{
    const double direction[3] = {1, -0.01, 0.00017453};
    parts_box_at(p, "ground", 0, 1000, -1, 0, -5, 5);
    parts_box_at(p, "wall", 0, 1000, -0.5, 3, -0.3, 0);
    parts_sun(p, direction);
}

/* A solid one, one of no thickness, and one that the spot lies in the plane of. */
static void wall_along_light(parts *p)
{
    ground(p, 10);
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
    ground(p, 5);
    parts_box_at(p, "block", -1, 1, 2, 3, -1, 1);
}

static void light_in_wall(parts *p)
{
    ground(p, 8);
    parts_box_at(p, "wall", -0.5, 0.5, -0.5, 4, -4, 4);
    parts_sun(p, slanted);
    parts_point(p, "lamp", (double[3]){0, 2, 0}, 20);
}

/* One above the light, one that covers all of the sky, and one beside it that reaches from behind the light to before it. */
static void caster_behind_light(parts *p)
{
    ground(p, 8);
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
    ground(p, 6);
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
    parts_sun(p, slanted);
}

/* The same boxes and sheets again, boxes that share planes, and a sheet with its own back. */
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
    parts_sun(p, slanted);
}

static void close_sheets(parts *p)
{
    ground(p, 6);
    parts_mesh(p, "lower", 0);
    sheet_at(p, -1, 1, 2, -1, 1);
    parts_mesh(p, "upper", 0);
    sheet_at(p, 0, 2, 2 + 1e-6, -1, 1);
    parts_sun(p, slanted);
}

/* accessor 2, position 2 */
static void broken_vertices(parts *p, double value)
{
    ground(p, 5);
    parts_mesh(p, "broken", 0);
    triangle(p, (double[3]){-1, 1, -1}, (double[3]){-1, 1, 1}, (double[3]){1, value, 0});
    triangle(p, (double[3]){-1, 2, -1}, (double[3]){-1, 2, 1}, (double[3]){1, 2, 0});
    parts_sun(p, slanted);
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
    ground(p, 20);
    parts_mesh(p, "boxes", 0);
    for (int i = 0; i < 100; i++) {
        double half = 5 * (100 - i) / 100.0;
        parts_box_at(p, NULL, -half, half, 6 - half, 6 + half, -half, half);
    }
    parts_sun(p, slanted);
}

/* Bars turned about their middle, which all of them hold. */
static void intersecting_100(parts *p)
{
    ground(p, 12);
    parts_mesh(p, "bars", 0);
    for (uint32_t i = 0; i < 100; i++) {
        parts_frame f = {{0, 3 + i * 0.002, 0}, 1, 0};
        parts_turn(i, 200, &f.cosine, &f.sine);
        parts_box(p, f, (double[3]){-4, -0.5, -0.15}, (double[3]){4, 0.5, 0.15});
    }
    parts_sun(p, slanted);
}

/* Three stacks of a thousand: solids apart from each other, solids each of which reaches into the next, sheets. */
static void layers_1000(parts *p)
{
    const double nearly_down[3] = {0.01, -1, 0.02};
    ground(p, 12);
    parts_mesh(p, "apart", 0);
    for (int i = 0; i < 1000; i++) parts_box_at(p, NULL, -3, -1, 0.5 + i * 0.1, 0.55 + i * 0.1, -1, 1);
    parts_mesh(p, "into each other", 0);
    for (int i = 0; i < 1000; i++) parts_box_at(p, NULL, 1 + i % 7 * 0.01, 3 - i % 5 * 0.01, 0.5 + i * 0.1, 0.65 + i * 0.1, -1, 1);
    parts_mesh(p, "sheets", 0);
    for (int i = 0; i < 1000; i++) sheet_at(p, 5, 7, 0.5 + i * 0.1, -1, 1);
    parts_sun(p, nearly_down);
}

/* A closed box that faces inward, with things and a light in it. */
static void inside_out_room(parts *p)
{
    parts_box_at(p, "ground", -10, 10, -2, -1, -10, 10);
    parts_box_at(p, "room", 4, -4, 0, 3, -3, 3);
    parts_box_at(p, "table", -1, 1, 0.7, 0.8, -0.5, 0.5);
    parts_box_at(p, "crate", 2, 3, 0, 1, 1, 2);
    parts_sun(p, slanted);
    parts_point(p, "lamp", (double[3]){0, 2.5, 0}, 30);
}

/* ---- surfaces with one side ---- */

/* A strip of `columns` quads around, whose end is glued to its beginning upside down: vertex (columns, j) is (0, last - j).
 * Where the grid is closed across too, row `rows` is row 0. */
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

/* The figure of eight, turned by half a turn on its way around. */
static void klein_at(double half[2], double across, double v[3])
{
    double c, s;
    parts_turn((uint32_t)(across * 32 + 0.5), 32, &c, &s);
    around(half, 2 + (half[0] * s - half[1] * 2 * s * c), 2.5 + (half[1] * s + half[0] * 2 * s * c), v);
}

static void moebius_band(parts *p)
{
    ground(p, 8);
    parts_mesh(p, "band", 0);
    add_twisted(p, 64, 8, 0, moebius_at);
    parts_sun(p, straight_down);
}

static void klein_bottle(parts *p)
{
    ground(p, 8);
    parts_mesh(p, "bottle", 0);
    add_twisted(p, 64, 32, 1, klein_at);
    parts_sun(p, straight_down);
}

/* ---- all of them ---- */

static const struct {
    const char *name, *purpose;
    void (*make)(parts *p);
} cases[] = {
    {"far-coordinates", "details of a centimetre, 10 000 km from the origin", far_coordinates},
    {"near-far", "a caster 1 mm from the lights, and one 1 km away", near_far},
    {"grazing-wall", "sunlight along a wall of 1 km, at 0.01 degrees to it", grazing_wall},
    {"wall-along-light", "walls that lie in the direction of the light", wall_along_light},
    {"zero-area-and-needles", "triangles without area, and of 6 m by a micrometre", zero_area_and_needles},
    {"coplanar-duplicates", "the same triangles twice and thrice, and solids with common planes", coplanar_duplicates},
    {"close-sheets", "two sheets a micrometre apart", close_sheets},
    {"nested-100", "100 boxes, each inside the one before", nested_100},
    {"intersecting-100", "100 solids, each of which meets all others", intersecting_100},
    {"layers-1000", "1000 solids and 1000 sheets above each other", layers_1000},
    {"klein-bottle", "a closed surface with one side", klein_bottle},
    {"moebius-band", "an open surface with one side", moebius_band},
    {"inside-out-room", "a closed room that faces inward, with a light and things in it", inside_out_room},
    {"nan-vertices", "a position that is no number", nan_vertices},
    {"infinite-vertices", "a position at infinity", infinite_vertices},
    {"empty-scene", "a sun and nothing that it could shine on", empty_scene},
    {"one-triangle", "the smallest scene there is", one_triangle},
    {"no-light", "casters and no light", no_light},
    {"light-in-wall", "a point light inside a solid wall", light_in_wall},
    {"caster-behind-light", "casters behind a spot, and beside it", caster_behind_light},
    {"tiny-scene", "a scene of a thousandth of a millimetre", tiny_scene},
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

vxs_result stress_check(const char *name, message *m)
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

vxs_result generate_stress(glb_scene *s, const char *name, message *m)
{
    *s = (glb_scene){0};
    for (size_t i = 0; i < CASES; i++) {
        if (strcmp(name, cases[i].name)) continue;
        parts p = parts_begin(s, cases[i].name);
        cases[i].make(&p);
        return parts_end(&p, m);
    }
    return stress_check(name, m);
}
