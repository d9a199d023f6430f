/* Voxels of triangles, on llvmpipe: where light rays meet them against rays traced in double, insides of closed models against
 * boxes, what is covered against many light rays in each voxel; and how they are joined to what stands.
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

#include "casting.h"

enum { ASKED, DARK, WRONG, EYES }; /* what is counted */

static shadow_grid cast(const volumes_scene *s, const vxs_volumes_frame *frame, const vxs_volumes_light *l,
                        const vxs_shadow_depth_map *map, vxs_shadow_grid *grid, const vxs_casters *c, const double *eye,
                        int *eye_lit)
{
    assert_int_equal(vxs_volumes_begin(s->volumes, frame), VXS_OK);
    assert_int_equal(vxs_volumes_grid_cast(s->volumes, l, map, grid, 0, c, 1), VXS_OK);
    return read_grid(grid, eye, eye_lit);
}

/* The light ray at a place of a row and a bit, which are middles where they are whole.   begin  [out] in the world */
static void light_ray_at(const shadow_grid *g, double row, double bit, double begin[3], double direction[3], double turned[2])
{
    double across[3];
    vxs_epipolar_across(&g->space, vxs_grid_place(g->space.theta, row + 0.5, g->size.rows), across);
    vxs_epipolar_turn_of(&g->space, vxs_grid_place(g->space.phi, bit + 0.5, g->size.bits), turned);
    vxs_epipolar_light_ray(&g->space, across, turned, begin, direction);
    for (int i = 0; i < 3; i++) begin[i] += g->eye[i];
}

/* How many columns lie before where a light ray meets the first triangle; as many as there are: it meets none of them. */
static double columns_before_hit(const shadow_grid *g, triangles t, double row, double bit)
{
    double begin[3], direction[3], turned[2], far = g->space.away > 0 ? 0 : 1000;
    light_ray_at(g, row, bit, begin, direction, turned);
    for (int i = 0; i < 3; i++) begin[i] -= far * direction[i];
    double metres = triangles_hit(t.places, t.corners, t.count, begin, direction) - far;
    if (metres == INFINITY) return g->size.columns;
    double columns = vxs_grid_before(g->space.alpha, vxs_epipolar_alpha_at(&g->space, turned, metres), g->size.columns);
    return fmin(fmax(columns, 0), g->size.columns);
}

/* tests ------------------------------------------------------------------------------------------------------------------------ */

/* Whether shadow begins on each light ray where it meets the first triangle, and so it does of the eye. */
static void check_light_rays(const volumes_scene *s, triangles t, int light, int camera, uint32_t counts[4])
{
    vxs_casters       c     = casters_of(s, t, VXS_VOXELS_RAYS);
    vxs_volumes_light l     = bare_light(s, light);
    volumes_camera    at    = camera_at(eyes[camera], looks[camera], 0.8);
    vxs_volumes_frame frame = scene_frame(s, &at, &haze, VXS_AIR_EVERYWHERE, 30, NULL);
    int               eye_lit;
    double            to_light[3], way = light == SCENE_SUN ? INFINITY : 1;
    shadow_grid       g = cast(s, &frame, &l, NULL, shared_grid, &c, at.eye, &eye_lit);
    for (int row = 0; row < g.size.rows; row++)
        for (int bit = 0; bit < g.size.bits; bit++) {
            double wanted = columns_before_hit(&g, t, row, bit);
            int    found  = first_column(&g, row, bit);
            wanted        = wanted < g.size.columns ? fmax(wanted - 0.5, 0) : wanted;
            counts[WRONG] += !(found > wanted - 1e-2 && found < wanted + 1 + 1e-2);
            counts[DARK] += found < g.size.columns;
            counts[ASKED]++;
        }
    for (int i = 0; i < 3; i++) to_light[i] = g.space.axis[i] * (g.space.away > 0 ? g.space.away : 1);
    assert_int_equal(eye_lit, !(triangles_hit(t.places, t.corners, t.count, at.eye, to_light) < way));
    counts[EYES] += !eye_lit;
    free(g.words);
}

/* Of the scene's triangles, and of such that are large and lie anyhow. */
static void test_light_rays(void **state)
{
    (void)state;
    enum { LARGE = 9 };
    const volumes_scene *s = opened();
    float                places[9 * LARGE];
    uint32_t             corners[3 * LARGE], counts[4] = {0};
    rng                  r = {3};
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (int camera = 0; camera < CAMERAS; camera++) {
            for (uint32_t n = 0; n < 9 * LARGE; n++) places[n] = (float)uniform(&r, -20, 20);
            for (uint32_t n = 0; n < 3 * LARGE; n++) corners[n] = n;
            check_light_rays(s, scene_triangles(SCENE_TRIANGLES), light, camera, counts);
            for (uint32_t n = 1; n <= LARGE; n += 4)
                check_light_rays(s, (triangles){places, 3 * LARGE, corners, n}, light, camera, counts);
        }
    print_message("%u light rays, %u in shadow, %u elsewhere; %u eyes in shadow\n", counts[ASKED], counts[DARK], counts[WRONG],
                  counts[EYES]);
    assert_true(counts[DARK] > counts[ASKED] / 20 && counts[DARK] < counts[ASKED] && counts[EYES] > 0);
    assert_true(counts[WRONG] < counts[ASKED] / 20000); /* rays along an edge */
    assert_int_equal(s->gl->GetError(), GL_NO_ERROR);
}

/* What stands, of the asset or of its map, and what moves: on each light ray the nearer of both, bit for bit; and the eye is lit if
 * it is by both. */
static void test_with_what_stands(void **state)
{
    (void)state;
    const volumes_scene *s = opened();
    enum { STANDS, MOVES, BOTH, GRIDS };
    static double metres[PIXELS];
    uint32_t      more       = 0;
    vxs_casters   c          = casters_of(s, scene_triangles(BOX_TRIANGLES), VXS_VOXELS_RAYS);
    const float   turned[16] = {0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0.3F, 0.4F, 0.2F, 1};
    memcpy(c.point_from_place, turned, sizeof turned);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        vxs_shadow_depth_map *map = filled_map(s, light);
        for (int camera = 0; camera < CAMERAS; camera++) {
            if (!scene_asks(light, camera)) continue;
            vxs_volumes_light     l = scene_light(light), bare = bare_light(s, light);
            volumes_camera        at    = camera_at(eyes[camera], looks[camera], 0.8);
            vxs_volumes_frame     frame = scene_frame(s, &at, &haze, VXS_AIR_EVERYWHERE, 30, metres);
            vxs_shadow_depth_map *from  = camera & 1 ? map : NULL;
            c.kind                      = light == SCENE_SUN ? VXS_VOXELS_RAYS : VXS_VOXELS_SOLID;
            shadow_grid found[GRIDS];
            int         lit[GRIDS];
            assert_int_equal(vxs_volumes_begin(s->volumes, &frame), VXS_OK);
            assert_int_equal(vxs_volumes_grid(s->volumes, &l, from, shared_grid, 0), VXS_OK);
            found[STANDS] = read_grid(shared_grid, at.eye, &lit[STANDS]);
            found[MOVES]  = cast(s, &frame, &bare, NULL, shared_grid, &c, at.eye, &lit[MOVES]);
            found[BOTH]   = cast(s, &frame, &l, from, shared_grid, &c, at.eye, &lit[BOTH]);
            for (int n = 0; n < vxs_grid_words(&found[0].size); n++) {
                uint32_t stands = found[STANDS].words[n], moves = found[MOVES].words[n];
                if (found[BOTH].words[n] != (stands | moves)) fail_msg("light %d, camera %d: word %d", light, camera, n);
                more += (moves & ~stands) != 0 && (stands & ~moves) != 0;
            }
            assert_int_equal(lit[BOTH], lit[STANDS] && lit[MOVES]);
            for (int n = 0; n < GRIDS; n++) free(found[n].words);
        }
        vxs_shadow_depth_map_destroy(map);
    }
    assert_true(more > 100);
}

/* In how many boxes a place is. */
static int boxes_about(const volumes_scene *s, const double *at)
{
    int count = 0;
    for (int n = 0; n < SCENE_BOXES; n++) {
        const float *low = s->positions + 24 * n, *high = low + 21;
        int          in = 1;
        for (int i = 0; i < 3; i++) in &= at[i] > (double)low[i] && at[i] < (double)high[i];
        count += in;
    }
    return count;
}

/* Solid voxels are those whose middles are in an odd number of boxes; shadow begins at the first, or where a light ray meets any
 * box before what can be seen. */
static void test_solid(void **state)
{
    (void)state;
    const volumes_scene *s = opened();
    static double        metres[PIXELS];
    uint32_t             asked = 0, dark = 0, before = 0, wrong = 0;
    vxs_casters          c = casters_of(s, scene_triangles(BOX_TRIANGLES), VXS_VOXELS_SOLID);
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (int camera = 0; camera <= CAMERAS; camera++) { /* the last is in the first box */
            const float *low = s->positions, *high = low + 21;
            const double in_box[] = {0.5 * (double)(low[0] + high[0]), 0.5 * (double)(low[1] + high[1]),
                                     0.5 * (double)(low[2] + high[2])};
            if (camera < CAMERAS && !scene_asks(light, camera)) continue;
            vxs_volumes_light l     = bare_light(s, light);
            volumes_camera    at    = camera_at(camera < CAMERAS ? eyes[camera] : in_box, looks[camera % CAMERAS], 0.8);
            vxs_volumes_frame frame = scene_frame(s, &at, &haze, VXS_AIR_EVERYWHERE, 30, metres);
            int               eye_lit;
            shadow_grid       g = cast(s, &frame, &l, NULL, shared_grid, &c, at.eye, &eye_lit);
            for (int row = 0; row < g.size.rows; row++)
                for (int bit = 0; bit < g.size.bits; bit++) {
                    int found = first_column(&g, row, bit), wanted = 0, is_before;
                    is_before = columns_before_hit(&g, scene_triangles(BOX_TRIANGLES), row, bit) <= 0.5;
                    for (; wanted < g.size.columns && !is_before; wanted++) {
                        double angles[3] = {vxs_grid_middle(g.space.alpha, wanted, g.size.columns),
                                            vxs_grid_middle(g.space.theta, row, g.size.rows),
                                            vxs_grid_middle(g.space.phi, bit, g.size.bits)},
                               place[3];
                        if (g.space.away > 0 && angles[0] + angles[2] > M_PI - 1e-3) wanted = g.size.columns - 1; /* no light ray */
                        vxs_epipolar_place(&g.space, angles, place);
                        for (int i = 0; i < 3; i++) place[i] += g.eye[i];
                        if (boxes_about(s, place) & 1) break;
                    }
                    if (getenv("VXS_VERBOSE") && found != wanted)
                        print_message("light %d, camera %d, row %d, bit %d: %d, not %d\n", light, camera, row, bit, found, wanted);
                    wrong += found != wanted;
                    dark += found < g.size.columns;
                    before += is_before;
                    asked++;
                }
            free(g.words);
        }
    print_message("%u light rays, %u in shadow, %u before what is seen, %u wrong\n", asked, dark, before, wrong);
    assert_true(dark > asked / 20 && before > 100);
    assert_true(wrong < asked / 2000);
}

/* Whatever light ray of a voxel meets a triangle, it is dark from there on; and no more than a voxel before the first of many of
 * them. */
static void test_covered(void **state)
{
    (void)state;
    const volumes_scene *s = opened();
    enum { ACROSS = 5 };
    static double    metres[PIXELS];
    uint32_t         asked = 0, dark = 0, early = 0;
    vxs_shadow_grid *grid = casting_grid(s, 61, 16, 40);
    vxs_casters      c    = casters_of(s, scene_triangles(SCENE_TRIANGLES), VXS_VOXELS_COVERED);
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (int camera = 0; camera < CAMERAS; camera++) {
            if (!scene_asks(light, camera)) continue;
            vxs_volumes_light l     = bare_light(s, light);
            volumes_camera    at    = camera_at(eyes[camera], looks[camera], 0.8);
            vxs_volumes_frame frame = scene_frame(s, &at, &haze, VXS_AIR_EVERYWHERE, 30, metres);
            int               eye_lit;
            shadow_grid       g = cast(s, &frame, &l, NULL, grid, &c, at.eye, &eye_lit);
            for (int row = 0; row < g.size.rows; row++)
                for (int bit = 0; bit < g.size.bits; bit++) {
                    double least = g.size.columns;
                    int    found = first_column(&g, row, bit);
                    for (int n = 0; n < ACROSS * ACROSS; n++) {
                        double y = n / ACROSS / (ACROSS - 1.0) - 0.5, x = n % ACROSS / (ACROSS - 1.0) - 0.5;
                        least =
                            fmin(least, columns_before_hit(&g, scene_triangles(SCENE_TRIANGLES), row + 0.998 * y, bit + 0.998 * x));
                    }
                    if (found > least + 1e-3)
                        fail_msg("light %d, camera %d, row %d, bit %d: %d, not %g", light, camera, row, bit, found, least);
                    early += found < floor(least) - 1;
                    dark += found < g.size.columns;
                    asked++;
                }
            free(g.words);
        }
    print_message("%u voxels of light rays, %u in shadow, %u too early\n", asked, dark, early);
    assert_true(dark > asked / 20);
    assert_true(early < dark / 20);
    vxs_shadow_grid_destroy(grid);
}

/* A closed wire that is far thinner than a voxel: all of it is covered, and nearly none of it solid. */
static void test_thin(void **state)
{
    (void)state;
    enum { PLACES = 1000 };
    const volumes_scene *s         = opened();
    const double         ends[][3] = {{4.2, 1, 0.4}, {4.9, 4, 1.3}};
    float                places[24];
    uint32_t             dark[VXS_VOXELS_KINDS] = {0};
    for (int n = 0; n < 8; n++)
        for (int i = 0; i < 3; i++) places[3 * n + i] = (float)(ends[n >> 1 & 1][i] + (i != 1 ? 1e-3 * (n >> (i / 2 * 2) & 1) : 0));
    const triangles   wire  = {places, 8, s->indices, 12}; /* corners as of a box */
    vxs_shadow_grid  *grid  = casting_grid(s, 128, 128, 128);
    vxs_volumes_light l     = bare_light(s, SCENE_POINT);
    volumes_camera    at    = camera_at(eyes[0], looks[0], 0.8);
    vxs_volumes_frame frame = scene_frame(s, &at, &haze, VXS_AIR_EVERYWHERE, 30, NULL);
    for (vxs_voxels kind = 0; kind < VXS_VOXELS_KINDS; kind++) {
        vxs_casters c = casters_of(s, wire, kind);
        int         eye_lit;
        shadow_grid g = cast(s, &frame, &l, NULL, grid, &c, at.eye, &eye_lit);
        for (int n = 0; n < PLACES; n++) {
            double place[3], angles[3];
            for (int i = 0; i < 3; i++)
                place[i] = ends[0][i] + n / (PLACES - 1.0) * (ends[1][i] - ends[0][i]) - g.eye[i] + (i != 1 ? 5e-4 : 0);
            vxs_epipolar_from_place(&g.space, place, angles);
            int row = (int)floor(vxs_grid_before(g.space.theta, angles[1], g.size.rows));
            int bit = (int)floor(vxs_grid_before(g.space.phi, angles[2], g.size.bits));
            assert_in_range(row, 0, g.size.rows - 1);
            assert_in_range(bit, 0, g.size.bits - 1);
            dark[kind] += first_column(&g, row, bit) <= vxs_grid_before(g.space.alpha, angles[0], g.size.columns);
        }
        free(g.words);
    }
    print_message("of %d places of a wire %u are dark by light rays, %u solid, %u covered\n", PLACES, dark[0], dark[1], dark[2]);
    assert_int_equal(dark[VXS_VOXELS_COVERED], PLACES);
    assert_true(dark[VXS_VOXELS_SOLID] < PLACES / 20 && dark[VXS_VOXELS_RAYS] < PLACES / 2);
    vxs_shadow_grid_destroy(grid);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_light_rays), cmocka_unit_test(test_with_what_stands),
        cmocka_unit_test(test_solid),      cmocka_unit_test(test_covered),
        cmocka_unit_test(test_thin),
    };
    return cmocka_run_group_tests(tests, NULL, close_scene);
}
