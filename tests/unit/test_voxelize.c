/* Triangles in voxelized shadow volumes, on llvmpipe: where light rays meet them against rays traced in double, insides of closed models against
 * boxes, what is covered against many light rays in each voxel, airlight against exact shadows of triangles.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/opengl/gl.h"

#include <math.h>
#include <stdlib.h>

#include "random_lamp.h"
#include "repeats.h"

/* last, because cmocka's macro fail() would hide the function of message.h; it wants the four above it */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "grid_read.h"
#include "triangle_shadows.h"

enum { WIDE = 32, HIGH = 24, PIXELS = WIDE * HIGH, BOX_TRIANGLES = 12 * SCENE_BOXES };
enum { ASKED, DARK, WRONG, EYES }; /* what is counted */

static const vxs_medium haze = {{0.03, 0.035, 0.04}, {0.04, 0.045, 0.05}, 0.4};

/* The point light off screen, in view, beside the eye, behind it; the same of the others. */
static const double eyes[][3]  = {{9, 3, 1}, {-4, 6, 9}, {0.4, 1.5, 0}, {-8, 0.5, -8}, {4, 2.6, 1}};
static const double looks[][3] = {{0, 2, 0}, {0, 1, 0}, {5, 1.6, 2}, {0.5, 2.5, -0.3}, {9, 2.5, 2.1}};
enum { CAMERAS = sizeof eyes / sizeof *eyes };

static const float identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static const char *const kind_names[VXS_VOXELS_KINDS] = {"light rays", "solid", "covered"};

static vxs_shadow_grid *casting_grid(const volumes_scene *s, uint32_t columns, uint32_t rows, uint32_t bits)
{
    vxs_shadow_grid     *grid;
    vxs_shadow_grid_desc desc = {.columns = columns, .rows = rows, .bits = bits, .casts = 1};
    assert_int_equal(vxs_shadow_grid_create(&grid, s->volumes, &desc), VXS_OK);
    return grid;
}

/* One scene and grid for all tests, opened by the first. */
static volumes_scene    scene;
static vxs_shadow_grid *shared_grid;

static const volumes_scene *opened(void)
{
    if (scene.volumes) return &scene;
    scene_open(&scene, 64, WIDE, HIGH);
    shared_grid = casting_grid(&scene, 64, 48, 130);
    return &scene;
}

static int close_scene(void **state)
{
    (void)state;
    vxs_shadow_grid_destroy(shared_grid);
    if (scene.volumes) scene_close(&scene);
    return 0;
}

static GLuint buffer_of(const volumes_scene *s, const void *data, size_t size)
{
    GLuint buffer;
    s->gl->GenBuffers(1, &buffer);
    s->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    s->gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)size, data, GL_STATIC_DRAW);
    return buffer;
}

/* Triangles in memory. */
typedef struct triangles {
    const float    *places;
    uint32_t        place_count;
    const uint32_t *corners;
    uint32_t        count;
} triangles;

/* The scene's own; its boxes alone are closed. */
static triangles scene_triangles(uint32_t count)
{
    return (triangles){scene.positions, 8 * SCENE_BOXES + 4, scene.indices, count};
}

/* Places lie apart in their buffer, and not at its begin. */
static vxs_casters casters_of(const volumes_scene *s, triangles t, vxs_voxels kind)
{
    enum { FIRST = 2, WORDS = 5 };
    size_t      size = sizeof(float) * (FIRST + WORDS * t.place_count);
    float      *laid = calloc(1, size);
    vxs_casters c    = {.first_word = FIRST, .place_words = WORDS, .triangle_count = t.count, .kind = kind};
    assert_non_null(laid);
    for (uint32_t n = 0; n < t.place_count; n++) memcpy(laid + FIRST + WORDS * n, t.places + 3 * n, 3 * sizeof *laid);
    c.places  = buffer_of(s, laid, size);
    c.corners = buffer_of(s, t.corners, 3 * t.count * sizeof *t.corners);
    free(laid);
    memcpy(c.point_from_place, identity, sizeof identity);
    return c;
}

/* A light without its asset: triangles alone. */
static vxs_volumes_light bare_light(const volumes_scene *s, int light)
{
    vxs_volumes_light l = scene_light(light);
    l.constants         = &vxs_gl_constants(s->shadows)[light];
    return l;
}

static shadow_grid cast(const volumes_scene *s, const vxs_volumes_frame *frame, const vxs_volumes_light *l,
                        const vxs_light_map *map, vxs_shadow_grid *grid, const vxs_casters *c, const double *eye, int *eye_lit)
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

/* tests ---------------------------------------------------------------------------------------------------------------------------- */

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

/* What stands, of the asset or of its map, and what moves: on each light ray the nearer of both, bit for bit; and the eye is lit if it is by both. */
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
        vxs_light_map *map = filled_map(s, light);
        for (int camera = 0; camera < CAMERAS; camera++) {
            if (!scene_asks(light, camera)) continue;
            vxs_volumes_light l = scene_light(light), bare = bare_light(s, light);
            volumes_camera    at    = camera_at(eyes[camera], looks[camera], 0.8);
            vxs_volumes_frame frame = scene_frame(s, &at, &haze, VXS_AIR_EVERYWHERE, 30, metres);
            vxs_light_map    *from  = camera & 1 ? map : NULL;
            c.kind                  = light == SCENE_SUN ? VXS_VOXELS_RAYS : VXS_VOXELS_SOLID;
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
        vxs_light_map_destroy(map);
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

/* Solid voxels are those whose middles are in an odd number of boxes; shadow begins at the first, or where a light ray meets any box
 * before what can be seen. */
static void test_solid(void **state)
{
    (void)state;
    const volumes_scene *s = opened();
    static double        metres[PIXELS];
    uint32_t             asked = 0, dark = 0, before = 0, wrong = 0;
    vxs_casters          c = casters_of(s, scene_triangles(BOX_TRIANGLES), VXS_VOXELS_SOLID);
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (int camera = 0; camera < CAMERAS; camera++) {
            if (!scene_asks(light, camera)) continue;
            vxs_volumes_light l     = bare_light(s, light);
            volumes_camera    at    = camera_at(eyes[camera], looks[camera], 0.8);
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

/* Whatever light ray of a voxel meets a triangle, it is dark from there on; and no more than a voxel before the first of many of them. */
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

/* What pixels have of a light in the exact shadows of triangles.   metres  of each pixel's ray */
static void exact_image(const volumes_scene *s, const vxs_volumes_light *l, const volumes_camera *at, triangles t,
                        const double *metres, double *wanted)
{
    vxs_air_light air = scene_air_light(s, l);
    for (uint32_t n = 0; n < PIXELS; n++) {
        double direction[3], in_fog[2], *to = wanted + 3 * (size_t)n;
        camera_ray(s, at, n % WIDE, n / WIDE, direction);
        vxs_air_path path = vxs_air_path_of(&air, at->eye, direction, metres[n], VXS_AIR_EVERYWHERE, in_fog);
        triangles_airlight(t.places, t.corners, t.count, &haze, &air, &path, at->eye, direction, to);
        for (int i = 0; i < 3; i++) to[i] *= (double)l->colour[i];
    }
}

/* Airlight by triangles, against that in their exact shadows: as near as the grid is fine. */
static void test_converges(void **state)
{
    (void)state;
    const volumes_scene *s = opened();
    static double        metres[PIXELS], wanted[3 * PIXELS];
    float                pixels[4 * PIXELS];
    enum { SIZES = 4 };
    vxs_shadow_grid *grids[SIZES] = {0};
    const uint32_t   sizes = repeats(SIZES - 1, SIZES), step = repeats(2, 1);
    for (uint32_t n = 0; n < sizes; n += step) grids[n] = casting_grid(s, 64U << n, 64U << n, 64U << n);
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (int camera = 0; camera < CAMERAS; camera++) {
            if (!scene_asks(light, camera)) continue;
            vxs_volumes_light l     = bare_light(s, light);
            volumes_camera    at    = camera_at(eyes[camera], looks[camera], 0.8);
            vxs_volumes_frame frame = scene_frame(s, &at, &haze, VXS_AIR_EVERYWHERE, 30, metres);
            exact_image(s, &l, &at, scene_triangles(BOX_TRIANGLES), metres, wanted);
            for (vxs_voxels kind = 0; kind < VXS_VOXELS_KINDS; kind++) {
                vxs_casters c     = casters_of(s, scene_triangles(BOX_TRIANGLES), kind);
                double      first = 0, last = 0;
                print_message("light %d, camera %d, %s: RMS", light, camera, kind_names[kind]);
                for (uint32_t n = 0; n < sizes; n += step) {
                    assert_int_equal(vxs_volumes_begin(s->volumes, &frame), VXS_OK);
                    assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, grids[n], 0, &c, 1), VXS_OK);
                    scene_read(s, pixels);
                    last  = error_of(pixels, wanted, PIXELS);
                    first = n ? first : last;
                    print_message(" %.5f at %u^3", last, 64U << n);
                }
                print_message("\n");
                assert_true(last < (kind == VXS_VOXELS_RAYS ? 1e-2 : 2e-2));
                if (kind != VXS_VOXELS_SOLID) assert_true(last < first / 1.6);
            }
        }
    for (int n = 0; n < SIZES; n++) vxs_shadow_grid_destroy(grids[n]);
}

static void turn_about(double turn[3][3], float *v)
{
    double from[3] = {(double)v[0], (double)v[1], (double)v[2]};
    for (int i = 0; i < 3; i++) v[i] = (float)dot(turn[i], from);
}

/* Copies of the scene, turned to all sides by the matrix of its casters, agree. */
static void test_turned(void **state)
{
    (void)state;
    static const int     cameras[SCENE_LIGHTS] = {1, 2, 3};
    const volumes_scene *s                     = opened();
    static double        metres[PIXELS], wanted[3 * PIXELS];
    float                pixels[4 * PIXELS];
    rng                  r    = {11};
    vxs_shadow_grid     *grid = casting_grid(s, 128, 128, 128);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        vxs_volumes_light l     = bare_light(s, light);
        volumes_camera    at    = camera_at(eyes[cameras[light]], looks[cameras[light]], 0.8);
        vxs_volumes_frame frame = scene_frame(s, &at, &haze, VXS_AIR_EVERYWHERE, 30, metres);
        vxs_casters       c     = casters_of(s, scene_triangles(BOX_TRIANGLES), VXS_VOXELS_RAYS);
        double            most  = 0;
        exact_image(s, &l, &at, scene_triangles(BOX_TRIANGLES), metres, wanted);
        for (uint32_t n = 0; n < repeats(7, 66); n++) {
            vxs_light_constants turned = vxs_gl_constants(s->shadows)[light];
            vxs_volumes_frame   f      = frame;
            double              turn[3][3];
            random_direction(&r, turn[0]);
            random_direction(&r, turn[1]);
            cross(turn[0], turn[1], turn[2]);
            make_unit(turn[2]);
            cross(turn[2], turn[0], turn[1]);
            for (int i = 0; i < 9 && n < 6; i++) turn[i / 3][i % 3] = i % 3 == (i / 3 + (int)n) % 3 ? n < 3 ? 1 : -1 : 0;
            for (int i = 0; i < 3; i++) turn_about(turn, turned.ls_from_ws + 4 * i);
            for (int i = 0; i < 4; i++) turn_about(turn, f.view.point_from_depth + 4 * i);
            for (int i = 0; i < 9; i++) c.point_from_place[4 * (i % 3) + i / 3] = (float)turn[i / 3][i % 3];
            turn_about(turn, f.eye);
            l.constants = &turned;
            assert_int_equal(vxs_volumes_begin(s->volumes, &f), VXS_OK);
            assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, grid, 0, &c, 1), VXS_OK);
            scene_read(s, pixels);
            most = fmax(most, error_of(pixels, wanted, PIXELS));
        }
        print_message("light %d: turned copies differ from exact shadows by an RMS of %.5f at most\n", light, most);
        assert_true(most < 1.5e-2);
    }
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

/* A corner that makes trouble: in the lamp, in the eye, on the axis, far away, no number. */
static void random_corner(rng *r, const double *eye, const double *light, float *corner)
{
    static const float extremes[] = {0, 1e-30F, -1e-30F, 1e14F, -1e14F, 1e30F, 3e38F, INFINITY, -INFINITY, NAN};
    double             along      = uniform(r, -1, 2);
    uint32_t           what       = rng_below(r, 8);
    for (int i = 0; i < 3; i++) {
        double at = what == 0   ? light[i]
                    : what == 1 ? eye[i]
                    : what == 2 ? eye[i] + along * (light[i] - eye[i])
                                : uniform(r, -9, 9);
        corner[i] = what == 3 ? extremes[rng_below(r, sizeof extremes / sizeof *extremes)] : (float)at;
    }
}

/* Cameras, lights and triangles at random, among them such that are none: nothing that is drawn is no number, or negative. */
static void test_any_triangles(void **state)
{
    (void)state;
    enum { TRIANGLES = 70, PLACES = 60 };
    const volumes_scene *s = opened();
    static double        metres[PIXELS];
    float                pixels[4 * PIXELS], places[4 * PLACES];
    uint32_t             corners[3 * TRIANGLES];
    rng                  r = {5};
    for (uint32_t n = 0; n < repeats(40, 3000); n++) {
        int                 light = (int)rng_below(&r, SCENE_LIGHTS);
        double              eye[3], to[3];
        vxs_volumes_light   l   = bare_light(s, light);
        const vxs_air_light air = scene_air_light(s, &l);
        for (int i = 0; i < 3; i++) {
            eye[i] = uniform(&r, -9, 9);
            to[i]  = rng_below(&r, 2) ? uniform(&r, -5, 5) : air.place[i];
        }
        if (!rng_below(&r, 8))
            for (int i = 0; i < 3; i++) eye[i] = air.place[i] + 1e-3 * uniform(&r, -1, 1);
        for (int k = 0; k < PLACES; k++) random_corner(&r, eye, air.place, places + 4 * k);
        for (int k = 0; k < 3 * TRIANGLES; k++)
            corners[k] = rng_below(&r, 40) ? rng_below(&r, PLACES) : rng_below(&r, 2) ? PLACES : rng_u32(&r);
        vxs_casters c = {.places         = buffer_of(s, places, sizeof places),
                         .place_words    = 4,
                         .corners        = rng_below(&r, 4) ? buffer_of(s, corners, sizeof corners) : 0,
                         .triangle_count = TRIANGLES + rng_below(&r, 100), /* more than there are */
                         .kind           = (vxs_voxels)rng_below(&r, VXS_VOXELS_KINDS)};
        memcpy(c.point_from_place, identity, sizeof identity);
        volumes_camera    at    = camera_at(eye, to, exp(uniform(&r, -4, 1)));
        vxs_volumes_frame frame = scene_frame(s, &at, &haze, VXS_AIR_EVERYWHERE, exp(uniform(&r, -3, 8)), n % 8 ? NULL : metres);
        assert_int_equal(vxs_volumes_begin(s->volumes, &frame), VXS_OK);
        assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, shared_grid, 0, &c, 1), VXS_OK);
        scene_read(s, pixels);
        for (size_t k = 0; k < 4 * PIXELS; k++)
            if (!(isfinite(pixels[k]) && pixels[k] >= 0)) fail_msg("repeat %u, number %zu is %g", n, k, (double)pixels[k]);
        s->gl->DeleteBuffers(1, &c.places);
        s->gl->DeleteBuffers(1, &c.corners);
    }
}

static void test_misuse(void **state)
{
    (void)state;
    const volumes_scene *s        = opened();
    vxs_shadow_grid     *few_rows = casting_grid(s, 8, 7, 8), *other = make_grid(s, 8, 8, 8, 0);
    vxs_volumes_light    l     = bare_light(s, SCENE_SUN);
    volumes_camera       at    = camera_at(eyes[0], looks[0], 0.8);
    vxs_volumes_frame    frame = scene_frame(s, &at, &haze, 1e30, 30, NULL);
    const vxs_casters    good  = casters_of(s, scene_triangles(SCENE_TRIANGLES), VXS_VOXELS_COVERED);
    vxs_casters          bad[] = {good, good, good, good, good, good};
    bad[0].places              = 0;
    bad[1].place_words         = 2;
    bad[2].kind                = VXS_VOXELS_KINDS;
    bad[3].point_from_place[7] = NAN;
    bad[4].first_word          = UINT32_MAX;
    bad[5].triangle_count      = UINT32_MAX;
    assert_int_equal(vxs_volumes_begin(s->volumes, &frame), VXS_OK);
    for (size_t n = 0; n < sizeof bad / sizeof *bad; n++)
        assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, shared_grid, 0, &bad[n], 1), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, shared_grid, 0, NULL, 0),
                     VXS_E_ARGUMENT); /* no light ray has an end */
    assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, few_rows, 0, &good, 1), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, other, 0, &good, 1), VXS_E_ARGUMENT); /* it does not cast */
    assert_int_equal(vxs_volumes_grid_cast(s->volumes, &l, NULL, shared_grid, 0, &good, 1), VXS_OK);
    assert_int_equal(s->gl->GetError(), GL_NO_ERROR);
    vxs_shadow_grid_destroy(few_rows);
    vxs_shadow_grid_destroy(other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_light_rays), cmocka_unit_test(test_with_what_stands), cmocka_unit_test(test_solid),
        cmocka_unit_test(test_covered),    cmocka_unit_test(test_converges),        cmocka_unit_test(test_turned),
        cmocka_unit_test(test_thin),       cmocka_unit_test(test_any_triangles),    cmocka_unit_test(test_misuse),
    };
    return cmocka_run_group_tests(tests, NULL, close_scene);
}
