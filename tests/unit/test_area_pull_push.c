/* Imperfect shadow maps of libvxs_volumes on llvmpipe, texel by texel against exact depths: light that leaks through gaps between
 * points, and shadows where there are none, of a wall on a floor, and of one with slits, from few points and many, of one VPL and
 * many.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>
#include <stdlib.h>

#include "random_light.h"
#include "repeats.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "runtime/volumes/area/area_state.h"
#include "volumes_scene.h"

#include "area_scene.h"

enum { MAP_SIDE = 128, QUADS = 4, FLOOR = QUADS - 1 };

static const double room_metres = 8; /* light beyond does not count */

/* Three parts of a wall, 1.5 m before the VPLs, with a slit between each two; and the floor it stands on. Corner,
 * and both sides. */
typedef struct quads {
    float at[QUADS][3][3];
} quads;

static quads wall_with_slits(float wide)
{
    quads q = {{{{-2, 0, 0}, {1.4F - wide / 2, 0, 0}, {0, 3, 0}},
                {{-0.6F + wide / 2, 0, 0}, {1.2F - wide, 0, 0}, {0, 3, 0}},
                {{0.6F + wide / 2, 0, 0}, {1.4F - wide / 2, 0, 0}, {0, 3, 0}},
                {{-5, 0, -5}, {10, 0, 0}, {0, 0, 10}}}};
    return q;
}

/* Metres to the first quad along a ray; room_metres at most. */
static double exact_depth(const quads *q, const double from[3], const double direction[3])
{
    double nearest = room_metres;
    for (int n = 0; n < QUADS; n++) {
        int across = n == FLOOR ? 1 : 2, other = n == FLOOR ? 2 : 1; /* the axis that it lies across, and that of its second side */
        double t = ((double)q->at[n][0][across] - from[across]) / direction[across];
        double x = from[0] + t * direction[0] - (double)q->at[n][0][0],
               y = from[other] + t * direction[other] - (double)q->at[n][0][other];
        if (t > 0 && t < nearest && x >= 0 && x <= (double)q->at[n][1][0] && y >= 0 && y <= (double)q->at[n][2][other]) nearest = t;
    }
    return nearest;
}

/* Points of the quads in a buffer. */
static GLuint points_of(const quads *q, uint32_t count)
{
    static const uint32_t two[6] = {0, 1, 2, 2, 1, 3};
    float                 positions[12 * QUADS];
    uint32_t              corners[6 * QUADS];
    vxs_area_point       *scattered = malloc(count * sizeof *scattered);
    GLuint                buffer;
    for (uint32_t n = 0; n < QUADS; n++)
        for (uint32_t k = 0; k < 4; k++)
            for (uint32_t i = 0; i < 3; i++) {
                const float(*at)[3]           = q->at[n];
                positions[12 * n + 3 * k + i] = at[0][i] + (k & 1 ? at[1][i] : 0) + (k & 2 ? at[2][i] : 0);
            }
    for (uint32_t n = 0; n < 6 * QUADS; n++) corners[n] = 4 * (n / 6) + two[n % 6];
    assert_non_null(scattered);
    assert_true(vxs_area_scatter(positions, corners, 2 * QUADS, scattered, count) > 100);
    scene.gl->GenBuffers(1, &buffer);
    scene.gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    scene.gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(count * sizeof *scattered), scattered, GL_STATIC_DRAW);
    free(scattered);
    return buffer;
}

/* What maps of VPLs let through, of all that VPLs send as far as room_metres: of airlight a piece of a ray has as much wherever it
 * is. */
typedef struct light_parts {
    double leaked, lost; /* where it does not come, and of what comes */
    double through;      /* of what comes through the slits, how much is there */
} light_parts;

/* Each VPL's map, in the middles of texels. */
static light_parts parts_of(const quads *q, uint32_t vpl_count, uint32_t vpl_step)
{
    static float map[MAP_SIDE * MAP_SIDE];
    light_parts  p   = {0};
    double       all = 0, beyond = 0;
    for (uint32_t n = 0; n < vpl_count; n += vpl_step) {
        double from[3], across[3], normal[3], up[3];
        for (int i = 0; i < 3; i++) {
            from[i]   = (double)light->vpls[n].place[i];
            across[i] = (double)light->vpls[n].across[i];
            normal[i] = (double)light->vpls[n].normal[i];
        }
        cross(normal, across, up);
        read_map(n, MAP_SIDE, map);
        for (int k = 0; k < MAP_SIDE * MAP_SIDE; k++) {
            double x = (k % MAP_SIDE + 0.5) / (MAP_SIDE / 2) - 1, y = (k / MAP_SIDE + 0.5) / (MAP_SIDE / 2) - 1,
                   square = x * x + y * y, direction[3];
            double cosine = (1 - square) / (1 + square), solid = 4 / ((1 + square) * (1 + square));
            if (cosine <= 0.02) continue;
            for (int i = 0; i < 3; i++) direction[i] = (1 + cosine) * (x * across[i] + y * up[i]) + cosine * normal[i];
            double wanted = exact_depth(q, from, direction), found = fmin((double)map[k], room_metres);
            double wall_at = from[2] < 0 ? -from[2] / direction[2] : 0,
                   at[2]   = {from[0] + wall_at * direction[0], from[1] + wall_at * direction[1]};
            all += solid * cosine * room_metres;
            p.leaked += solid * cosine * fmax(found - wanted, 0);
            p.lost += solid * cosine * fmax(wanted - found, 0);
            if (fabs(at[0]) > 1 || at[1] < 0 || at[1] > 3 || wanted < wall_at + 0.01) continue; /* not through a slit */
            beyond += solid * cosine * (wanted - wall_at);
            p.through += solid * cosine * fmax(fmin(found, wanted) - wall_at, 0);
        }
    }
    p.leaked /= all;
    p.lost /= all;
    p.through /= beyond > 0 ? beyond : 1;
    return p;
}

static light_parts cast_wall(const quads *q, uint32_t point_count, uint32_t vpl_count)
{
    const vxs_area_rectangle screen = {{-1, 0.7F, -1.5F}, {2, 0, 0}, {0, 1.6F, 0}, {1, 1, 1}, NULL, 0, 0};
    vxs_vpl                  vpls[VXS_VPLS_MAX];
    GLuint                   buffer = points_of(q, point_count);
    assert_int_equal(vxs_area_sample(&screen, VXS_AREA_HALTON, 0, vpls, vpl_count), VXS_OK);
    assert_int_equal(vxs_area_light_set(light, vpls, vpl_count), VXS_OK);
    assert_int_equal(vxs_area_light_cast(light, &(vxs_area_casters){buffer, point_count, 0}), VXS_OK);
    light_parts p = parts_of(q, vpl_count, vpl_count < 4 ? 1 : vpl_count / 4);
    scene.gl->DeleteBuffers(1, &buffer);
    return p;
}

/* A wall that stands on a floor: points of the floor, seen between those of the wall, do not keep its gaps open, however few there
 * are. */
static void test_wall_on_floor(void **state)
{
    (void)state;
    static const uint32_t counts[] = {20000, 5000, 100000, 262144}, vpls[] = {1, 16, 64, 256};
    const quads           q = wall_with_slits(0);
    for (size_t n = 0; n < repeats(1, 4); n++)
        for (size_t k = 0; k < 4; k++) {
            light_parts p = cast_wall(&q, counts[n], vpls[k]);
            print_message("%u points, %u VPLs: %.4f of all light leaks, %.4f is lost\n", counts[n], vpls[k], p.leaked, p.lost);
            assert_true(p.leaked < 0.001 && p.lost < 0.008);
        }
}

/* What comes through slits that are twice as wide as points are apart is there, and some of it where they are as wide. */
static void test_slits(void **state)
{
    (void)state;
    static const float    wide[]   = {0.2F, 0.4F};
    static const uint32_t counts[] = {20000, 100000};
    for (size_t n = 0; n < 2; n++)
        for (size_t k = 0; k < 2; k++) {
            quads       q = wall_with_slits(wide[n]);
            light_parts p = cast_wall(&q, counts[k], 16);
            print_message("%.1f m, %u points: %.4f leaks, %.4f is lost, %.2f comes through\n", (double)wide[n], counts[k], p.leaked,
                          p.lost, p.through);
            assert_true(p.leaked < 0.005 && p.lost < 0.03 && p.through > (wide[n] > 0.3F || counts[k] > 20000 ? 0.8 : 0.5));
        }
}

/* A light with maps of the default size, in place of that of area_set_up. */
static vxs_area_light *small;

static int set_up(void **state)
{
    area_set_up(state);
    small = light;
    return vxs_area_light_create(&light, scene.volumes, &(vxs_area_light_desc){.side_px = MAP_SIDE, .columns = 1, .rows = 1}) !=
           VXS_OK;
}

static int tear_down(void **state)
{
    vxs_area_light_destroy(small);
    return area_tear_down(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_wall_on_floor),
        cmocka_unit_test(test_slits),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
