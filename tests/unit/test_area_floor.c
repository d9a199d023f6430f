/* A panel over a bare floor, and over one of which a plate hides half: what area lights send to surfaces, against the closed form
 * of a polygon [Lambert 1760], and to the air, against an integral over the panel and the eye ray, from many eyes, on floors of 8
 * to 200 metres, in each way to gather.
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
#include "baker/base/spread.h"

/* The panel is 2 m above the floor, the plate 1 m, where x < 0. */
enum { FLOOR, PLATE, PANEL, NOTHING, EXACT = 4, SOME_POINTS = 1 << 18, SHOWN = 16 };
static const double heights[] = {0, 1, 2}, panel_wide = 1, panel_deep = 0.6, far_metres = 60;

static const vxs_medium clear_air = {.anisotropy = 0}, mist = {{0.01, 0.01, 0.01}, {0.02, 0.02, 0.02}, 0.3};

static const vxs_area_rectangle panel = {{-1, 2, -0.6F}, {2, 0, 0}, {0, 0, 1.2F}, {1, 1, 1}, NULL, 0, 0};

typedef struct room {
    double half_metres; /* of the floor */
    int    has_plate;
} room;

/* Near and far, grazing, above, between panel and plate, below the panel, behind what is lit: from where, and where to. */
static const double views[][2][3] = {
    {{3, 1.6, 5}, {0, 0.3, 0}}, {{0, 6, 8}, {0, 0, 0}},       {{5, 1.6, 7}, {0, 0, 3}},    {{0.5, 0.3, 8}, {0, 0.2, 0}},
    {{1, 0.9, 3.5}, {0, 0, 2}}, {{0.1, 1.4, 0.3}, {1, 0, 0}}, {{0, 5, 0.3}, {0.01, 0, 0}}, {{9, 2, 12}, {0, 0, 2}},
    {{0, 10, 12}, {0, 0, 0}},   {{-3, 1.5, 6}, {1, 0, 1}},    {{2, 3.5, -3}, {0, 0, 1}},   {{3.9, 0.4, 3.9}, {-3, 0.2, -2}},
};
enum { VIEWS = sizeof views / sizeof *views };

static int is_on(const room *r, int what, double x, double z)
{
    if (what == PANEL) return fabs(x) <= panel_wide && fabs(z) <= panel_deep;
    return x >= -r->half_metres && x <= (what == PLATE ? 0 : r->half_metres) && fabs(z) <= r->half_metres;
}

/* What an eye ray meets, and where. */
static int meet(const room *r, const double eye[3], const double direction[3], double *metres)
{
    int met = NOTHING;
    *metres = far_metres;
    for (int what = FLOOR; what <= PANEL; what++) {
        double at = (heights[what] - eye[1]) / direction[1];
        if ((what == PLATE && !r->has_plate) || !(at > 1e-6 && at < *metres)) continue;
        if (!is_on(r, what, eye[0] + at * direction[0], eye[2] + at * direction[2])) continue;
        *metres = at;
        met     = what;
    }
    return met;
}

/* Whether the floor or the plate is between a place and the panel. */
static int is_hidden(const room *r, const double from[3], const double to[3])
{
    for (int what = FLOOR; what <= r->has_plate; what++) {
        double at = (heights[what] - from[1]) / (to[1] - from[1]);
        if (from[1] < heights[what] - 1e-9 && is_on(r, what, from[0] + at * (to[0] - from[0]), from[2] + at * (to[2] - from[2])))
            return 1;
    }
    return 0;
}

/* The irradiance of a place below the panel, facing up, by the part of the panel where x is `begin` and more. */
static double by_polygon(const double at[3], double begin)
{
    double corners[4][3] = {{begin, 2, -panel_deep},
                            {panel_wide, 2, -panel_deep},
                            {panel_wide, 2, panel_deep},
                            {begin, 2, panel_deep}},
           sum           = 0, across[3];
    if (begin >= panel_wide) return 0;
    for (int n = 0; n < 4; n++) {
        for (int i = 0; i < 3; i++) corners[n][i] -= at[i];
        make_unit(corners[n]);
    }
    for (int n = 0; n < 4; n++) {
        cross(corners[n], corners[(n + 1) % 4], across);
        double sine = sqrt(dot(across, across));
        sum += atan2(sine, dot(corners[n], corners[(n + 1) % 4])) * across[1] / sine;
    }
    return 0.5 * fabs(sum);
}

/* Of a surface that is met: nothing hidden, and as it is. The plate's edge is half as high as the panel. */
static double irradiance(const room *r, int what, const double at[3], const double eye[3], double *open)
{
    *open = what == FLOOR || (what == PLATE && eye[1] > 1) ? by_polygon(at, -panel_wide) : 0;
    return what == FLOOR && r->has_plate ? by_polygon(at, fmax(-panel_wide, -at[0])) : *open;
}

/* Airlight of the panel along an eye ray: a sum over places of both. */
static double air_along(const room *r, const vxs_medium *medium, const double eye[3], const double direction[3], double metres)
{
    enum { ACROSS = 20, DEEP = 12, STEPS = 160 };
    const double area = 4 * panel_wide * panel_deep / (ACROSS * DEEP), g = medium->anisotropy;
    double       sum = 0;
    for (int step = 0; step < STEPS; step++) { /* of even angles about the ray's place nearest to the panel's middle */
        double along = -(eye[0] * direction[0] + (eye[1] - 2) * direction[1] + eye[2] * direction[2]), beside = 0, place[3];
        for (int i = 0; i < 3; i++) {
            double off = eye[i] + along * direction[i] - (i == 1 ? 2 : 0);
            beside += off * off;
        }
        beside       = sqrt(beside) + 0.1;
        double begin = atan(-along / beside), end = atan((metres - along) / beside),
               angle = begin + (step + 0.5) / STEPS * (end - begin);
        double x = along + beside * tan(angle), dx = beside / (cos(angle) * cos(angle)) * (end - begin) / STEPS;
        for (int i = 0; i < 3; i++) place[i] = eye[i] + x * direction[i];
        if (place[1] >= 2) continue;
        for (int n = 0; n < ACROSS * DEEP; n++) {
            double from[3] = {-panel_wide + 2 * panel_wide * (n % ACROSS + 0.5) / ACROSS, 2,
                              -panel_deep + 2 * panel_deep * (n / ACROSS + 0.5) / DEEP},
                   way[3];
            if (is_hidden(r, place, from)) continue;
            for (int i = 0; i < 3; i++) way[i] = place[i] - from[i];
            double square = dot(way, way), away = sqrt(square), turned = -dot(way, direction) / away;
            double phase = (1 - g * g) / (4 * M_PI * pow(1 + g * g - 2 * g * turned, 1.5));
            sum += medium->scattering[0] * phase * -way[1] / (away * square) * exp(-medium->extinction[0] * (x + away)) * area * dx;
        }
    }
    return sum;
}

/* How near an eye ray comes to the panel, about, where VPLs are too far apart for it. */
static double distance_to_panel(const double eye[3], const double direction[3], double metres)
{
    double nearest = INFINITY;
    for (int n = 0; n <= 100; n++) {
        double square = 0;
        for (int i = 0; i < 3; i++) {
            double at = eye[i] + n / 100.0 * metres * direction[i], most = i == 0 ? panel_wide : i == 2 ? panel_deep : 0;
            double off = fmax(fabs(at - (i == 1 ? 2 : 0)) - most, 0);
            square += off * off;
        }
        nearest = fmin(nearest, sqrt(square));
    }
    return nearest;
}

/* The room's triangles. */
static uint32_t triangles(const room *r, float *positions, uint32_t *corners)
{
    static const uint32_t order[6] = {0, 1, 2, 0, 2, 3};
    const float           f = (float)r->half_metres, places[3][4][3] = {{{-f, 0, f}, {f, 0, f}, {f, 0, -f}, {-f, 0, -f}},
                                                                        {{-1, 2, -0.6F}, {1, 2, -0.6F}, {1, 2, 0.6F}, {-1, 2, 0.6F}},
                                                                        {{-f, 1, f}, {0, 1, f}, {0, 1, -f}, {-f, 1, -f}}};
    memcpy(positions, places, sizeof places);
    for (uint32_t n = 0; n < 18; n++) corners[n] = n / 6 * 4 + order[n % 6];
    return r->has_plate ? 6 : 4;
}

/* Points of it: by area alone, or about the panel's VPLs.   Returns their buffer */
static GLuint scatter(const room *r, int is_about_vpls, uint32_t point_count)
{
    float           positions[36];
    uint32_t        corners[18], count = triangles(r, positions, corners);
    vxs_vpl         vpls[SHOWN];
    vxs_area_point *scattered = malloc(point_count * sizeof *scattered);
    GLuint          buffer;
    assert_non_null(scattered);
    assert_int_equal(vxs_area_sample(&panel, VXS_AREA_IMPORTANCE, 0, vpls, SHOWN), VXS_OK);
    if (is_about_vpls)
        assert_true(vxs_area_scatter_for(positions, corners, count, vpls, SHOWN, scattered, point_count) > 0);
    else
        assert_true(vxs_area_scatter(positions, corners, count, scattered, point_count) > 0);
    scene.gl->GenBuffers(1, &buffer);
    scene.gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    scene.gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(point_count * sizeof *scattered), scattered, GL_STATIC_DRAW);
    free(scattered);
    return buffer;
}

/* What a view sees: depths and normals go up.   Returns its frame */
static vxs_volumes_frame look_from(const room *r, const volumes_camera *c, const vxs_medium *medium, int *met, double *metres)
{
    static float      depths[PIXELS], normal[4 * PIXELS];
    vxs_volumes_frame frame = scene_frame(&scene, c, medium, VXS_AIR_EVERYWHERE, far_metres, NULL);
    for (uint32_t n = 0; n < PIXELS; n++) {
        double direction[3];
        camera_ray(&scene, c, n % WIDE, n / WIDE, direction);
        met[n]            = meet(r, c->eye, direction, &metres[n]);
        depths[n]         = met[n] == NOTHING ? EMPTY_DEPTH : (float)(NEAR_METRES / (metres[n] * dot(direction, c->forward)));
        normal[4 * n + 1] = met[n] == NOTHING ? 0 : direction[1] < 0 ? 1 : -1;
    }
    scene.gl->TextureSubImage2D(scene.depths, 0, 0, 0, WIDE, HIGH, GL_RED, GL_FLOAT, depths);
    scene.gl->TextureSubImage2D(normals, 0, 0, 0, WIDE, HIGH, GL_RGBA, GL_FLOAT, normal);
    return frame;
}

/* How far what is drawn is off: the sums of what is found and of what is right; of what there would be in the open, or in the
 * view's mean where that is more, the most that a pixel is off, and RMS. */
typedef struct errors {
    double   found[PIXELS], wanted[PIXELS], open[PIXELS];
    uint32_t count;
    double   mean, most, rms;
} errors;

static void add_pixel(errors *e, double found, double wanted, double open)
{
    e->found[e->count]  = found;
    e->wanted[e->count] = wanted;
    e->open[e->count++] = open;
}

static void sum_up(errors *e)
{
    double found = 0, wanted = 0, open = 0, square = 0;
    assert_true(e->count > 0);
    for (uint32_t n = 0; n < e->count; n++) {
        found += e->found[n];
        wanted += e->wanted[n];
        open += e->open[n] / e->count;
    }
    for (uint32_t n = 0; n < e->count; n++) {
        double off = fabs(e->found[n] - e->wanted[n]) / fmax(e->open[n], open);
        e->most    = fmax(e->most, off);
        square += off * off;
    }
    e->mean = found / wanted;
    e->rms  = sqrt(square / e->count);
}

/* Of surfaces that the panel shines on; on others there is no light. */
static void surfaces_of(const room *r, const volumes_camera *c, const vxs_area_look *asked, errors *e)
{
    static int        met[PIXELS];
    static double     metres[PIXELS];
    static float      air[4 * PIXELS], pixels[4 * PIXELS];
    vxs_volumes_frame frame = look_from(r, c, &clear_air, met, metres);
    *e                      = (errors){.count = 0};
    draw(&frame, asked, air);
    scene.gl->GetTextureImage(vxs_area_light_irradiance(light), 0, GL_RGBA, GL_FLOAT, sizeof pixels, pixels);
    for (uint32_t n = 0; n < PIXELS; n++) {
        double direction[3], place[3], open;
        camera_ray(&scene, c, n % WIDE, n / WIDE, direction);
        for (int i = 0; i < 3; i++) place[i] = c->eye[i] + metres[n] * direction[i];
        double wanted = irradiance(r, met[n], place, c->eye, &open);
        assert_true(air[4 * n] == 0);
        if (open > 1e-3) add_pixel(e, (double)pixels[4 * n], wanted, open);
        if (open == 0 && asked->gather == VXS_AREA_EACH) assert_true(pixels[4 * n] < 1e-6F);
    }
    sum_up(e);
}

/* Of the air along rays that do not come near the panel, of each `step`-th pixel both ways. */
static void air_of(const room *r, const volumes_camera *c, const vxs_area_look *asked, uint32_t step, errors *e)
{
    static int        met[PIXELS];
    static double     metres[PIXELS];
    static float      pixels[4 * PIXELS];
    const room        bare  = {r->half_metres, 0};
    vxs_volumes_frame frame = look_from(r, c, &mist, met, metres);
    *e                      = (errors){.count = 0};
    draw(&frame, asked, pixels);
    for (uint32_t n = 0; n < PIXELS; n++) {
        double direction[3];
        if (n % WIDE % step != step / 2 || n / WIDE % step != step / 2) continue;
        camera_ray(&scene, c, n % WIDE, n / WIDE, direction);
        if (distance_to_panel(c->eye, direction, metres[n]) < 0.4) continue;
        double wanted = air_along(r, &mist, c->eye, direction, metres[n]);
        add_pixel(e, (double)pixels[4 * n], wanted, r->has_plate ? air_along(&bare, &mist, c->eye, direction, metres[n]) : wanted);
    }
    sum_up(e);
}

/* Whether an eye is not above the floor: then rays pass below its edge, where airlight is less exact. */
static int is_beside(const room *r, const double eye[3])
{
    return fabs(eye[0]) > r->half_metres || fabs(eye[2]) > r->half_metres;
}

static volumes_camera camera_of(int view)
{
    return camera_at(views[view][0], views[view][1], 0.6);
}

static void set_vpls(uint32_t seed, uint32_t count)
{
    vxs_vpl vpls[VXS_VPLS_MAX];
    assert_int_equal(vxs_area_sample(&panel, VXS_AREA_IMPORTANCE, seed, vpls, count), VXS_OK);
    assert_int_equal(vxs_area_light_set(light, vpls, count), VXS_OK);
}

static void cast_room(const room *r, int is_about_vpls, uint32_t point_count)
{
    GLuint buffer = scatter(r, is_about_vpls, point_count);
    assert_int_equal(vxs_area_light_cast(light, &(vxs_area_casters){buffer, point_count, 0}), VXS_OK);
    scene.gl->DeleteBuffers(1, &buffer);
}

/* tests ------------------------------------------------------------------------------------------------------------------------ */

/* Of bare floors points by area alone are enough; half below a plate, points about the VPLs say where its edge is. */
static void test_closed_forms(void **state)
{
    (void)state;
    static const double   floors[] = {100, 4, 20, 6};
    static const uint32_t vpls[]   = {64, 256};
    static errors         surface, air;
    for (size_t n = 0; n < repeats(2, 4 * 2 * 2); n++) {
        room     r     = {floors[n / 2 % 4], n % 2};
        uint32_t count = vpls[n / 8];
        set_vpls(0, count);
        cast_room(&r, r.has_plate, SOME_POINTS);
        for (int k = 0; k < VIEWS; k++) {
            volumes_camera c        = camera_of(k);
            int            asks_air = k % (int)repeats(8, 1) == 0;
            surfaces_of(&r, &c, &(vxs_area_look){.normal_texture = normals}, &surface);
            print_message("floor of %g m%s, %u VPLs, eye %g %g %g: surfaces %.3f, a pixel %.3f at most, RMS %.3f",
                          2 * r.half_metres, r.has_plate ? ", half hidden" : "", count, c.eye[0], c.eye[1], c.eye[2], surface.mean,
                          surface.most, surface.rms);
            if (asks_air) air_of(&r, &c, &(vxs_area_look){0}, repeats(8, 4), &air);
            if (asks_air) print_message("; air %.3f, a ray %.3f at most, RMS %.3f", air.mean, air.most, air.rms);
            print_message("\n");
            assert_true(surface.most < (r.has_plate ? 0.07 : 0.025) && surface.rms < (r.has_plate ? 0.03 : 0.015));
            assert_true(fabs(surface.mean - 1) < 0.03);
            double air_most = is_beside(&r, c.eye) ? 0.07 : r.has_plate ? 0.04 : 0.03;
            if (asks_air) assert_true(fabs(air.mean - 1) < air_most && air.most < 3 * air_most && air.rms < air_most);
        }
    }
}

/* A ninth of the VPLs for each pixel, and a quarter of the pixels, are as bright; and so are VPLs that shine to all sides at once,
 * as maps of theirs are. */
static void test_ways_to_gather(void **state)
{
    (void)state;
    static const char *const names[] = {"each", "ninths", "quarter"};
    static errors            surface, air;
    const room               r = {20, 0};
    set_vpls(0, 64);
    cast_room(&r, 0, SOME_POINTS);
    for (int k = 0; k < VIEWS; k += (int)repeats(10, 2))
        for (int which = 0; which <= VXS_AREA_QUARTER; which++) {
            volumes_camera c = camera_of(k);
            surfaces_of(&r, &c, &(vxs_area_look){.gather = (vxs_area_gather)which, .normal_texture = normals}, &surface);
            air_of(&r, &c, &(vxs_area_look){.gather = (vxs_area_gather)which}, 8, &air);
            print_message("%s, eye %g %g %g: surfaces %.3f, RMS %.3f; air %.3f, RMS %.3f\n", names[which], c.eye[0], c.eye[1],
                          c.eye[2], surface.mean, surface.rms, air.mean, air.rms);
            /* what is mixed of a quarter of 32 x 24 pixels is coarse where the light is a few of them wide */
            assert_true(fabs(surface.mean - 1) < (which == VXS_AREA_QUARTER ? 0.06 : 0.03));
            assert_true(fabs(air.mean - 1) < (which == VXS_AREA_NINTHS ? 0.08 : 0.05));
        }
}

/* RMS over two views of a floor that is half hidden. */
static double error_of(const room *r, uint32_t seed, uint32_t vpl_count, uint32_t point_count)
{
    static errors surface;
    double        square = 0;
    set_vpls(seed, vpl_count);
    cast_room(r, 1, point_count);
    for (int k = 0; k < 2; k++) {
        volumes_camera c = camera_of(k);
        surfaces_of(r, &c, &(vxs_area_look){.normal_texture = normals}, &surface);
        square += surface.rms * surface.rms / 2;
    }
    return sqrt(square);
}

/* More VPLs, and more points, never make it worse: medians over seeds. */
static void test_more_is_no_worse(void **state)
{
    (void)state;
    enum { SEEDS_MOST = 9 };
    const room r     = {20, 1};
    uint32_t   seeds = repeats(3, SEEDS_MOST);
    for (int by_points = 0; by_points < 2; by_points++) {
        double before = INFINITY, found[SEEDS_MOST];
        for (uint32_t step = 0; step < repeats(3, 4); step++) {
            uint32_t vpl_count = by_points ? 4 : 1U << 2 * step, point_count = by_points ? 1U << (12 + 2 * step) : SOME_POINTS;
            for (uint32_t seed = 0; seed < seeds; seed++) found[seed] = error_of(&r, seed, vpl_count, point_count);
            qsort(found, seeds, sizeof *found, doubles_ascending);
            print_message("%u VPLs, %u points: RMS %.4f\n", vpl_count, point_count, found[seeds / 2]);
            assert_true(found[seeds / 2] < 1.05 * before);
            before = found[seeds / 2];
        }
    }
}

/* a ball on a floor ------------------------------------------------------------------------------------------------------------ */

enum { AROUND = 64, DOWN = 32, BALL_CORNERS = 4 + (AROUND + 1) * (DOWN + 1), BALL_TRIANGLES = 2 + 2 * AROUND * DOWN };
static const double ball_at[3] = {0, 0.5, 0}, ball_radius = 0.5;

/* Metres to the ball along a ray; INFINITY: it is not met. */
static double to_ball(const double from[3], const double direction[3])
{
    double off[3] = {from[0] - ball_at[0], from[1] - ball_at[1], from[2] - ball_at[2]}, along = dot(off, direction),
           square = along * along - dot(off, off) + ball_radius * ball_radius;
    return square > 0 && -along - sqrt(square) > 0 ? -along - sqrt(square) : INFINITY;
}

/* Points by area of a ball in triangles, on a floor.   Returns their buffer */
static GLuint scatter_ball(double half_metres, uint32_t point_count)
{
    static float    positions[3 * BALL_CORNERS];
    static uint32_t corners[3 * BALL_TRIANGLES];
    const room      r         = {half_metres, 0};
    vxs_area_point *scattered = malloc(point_count * sizeof *scattered);
    float           floor_and_panel[36];
    uint32_t        floor_corners[18];
    GLuint          buffer;
    assert_non_null(scattered);
    triangles(&r, floor_and_panel, floor_corners);
    memcpy(positions, floor_and_panel, 12 * sizeof *positions);
    memcpy(corners, floor_corners, 6 * sizeof *corners);
    for (uint32_t n = 0; n < BALL_CORNERS - 4; n++) {
        double polar = M_PI * (n / (AROUND + 1)) / DOWN, turn = 2 * M_PI * (n % (AROUND + 1)) / AROUND;
        double way[3] = {sin(polar) * cos(turn), cos(polar), sin(polar) * sin(turn)};
        for (uint32_t i = 0; i < 3; i++) positions[12 + 3 * n + i] = (float)(ball_at[i] + ball_radius * way[i]);
    }
    for (uint32_t n = 0; n < AROUND * DOWN; n++) {
        uint32_t a = 4 + n / AROUND * (AROUND + 1) + n % AROUND, b = a + AROUND + 1, some[6] = {a, a + 1, b + 1, a, b + 1, b};
        memcpy(corners + 6 + 6 * n, some, sizeof some);
    }
    assert_true(vxs_area_scatter(positions, corners, BALL_TRIANGLES, scattered, point_count) > 0);
    scene.gl->GenBuffers(1, &buffer);
    scene.gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    scene.gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(point_count * sizeof *scattered), scattered, GL_STATIC_DRAW);
    free(scattered);
    return buffer;
}

/* What is round does not shade itself, from points that are .2 m apart, and that are in rows of triangles, as from many: surfaces
 * against rays to each VPL. */
static void test_ball(void **state)
{
    (void)state;
    enum { COUNT = 16 };
    static const uint32_t counts[] = {1 << 12, 1 << 18, 1 << 18};
    static const double   floors[] = {6, 20, 6}, least[] = {0.95, 0.94, 0.985};
    static float          depths[PIXELS], normal[4 * PIXELS], pixels[4 * PIXELS];
    static double         wanted[2][PIXELS];
    volumes_camera        c     = camera_at((double[3]){2, 1.6, 2}, (double[3]){0, 0.3, 0}, 0.5);
    vxs_volumes_frame     frame = scene_frame(&scene, &c, &clear_air, VXS_AIR_EVERYWHERE, far_metres, NULL);
    vxs_vpl               vpls[COUNT];
    assert_int_equal(vxs_area_sample(&panel, VXS_AREA_IMPORTANCE, 0, vpls, COUNT), VXS_OK);
    for (uint32_t n = 0; n < PIXELS; n++) {
        double direction[3], place[3], up[3] = {0, 1, 0};
        camera_ray(&scene, &c, n % WIDE, n / WIDE, direction);
        double metres  = fmin(to_ball(c.eye, direction), -c.eye[1] / direction[1]);
        int    is_ball = metres < -c.eye[1] / direction[1];
        for (uint32_t i = 0; i < 3; i++) {
            place[i] = c.eye[i] + metres * direction[i];
            if (is_ball) up[i] = (place[i] - ball_at[i]) / ball_radius;
            normal[4 * n + i] = (float)up[i];
        }
        depths[n]    = (float)(NEAR_METRES / (metres * dot(direction, c.forward)));
        wanted[0][n] = wanted[1][n] = 0;
        for (int k = 0; k < COUNT; k++) {
            double way[3], square;
            for (int i = 0; i < 3; i++) way[i] = (double)vpls[k].place[i] - place[i];
            square      = dot(way, way);
            double here = dot(way, up), lit = (double)vpls[k].colour[0] * here * way[1] / (square * square);
            make_unit(way);
            if (here > 0 && (is_ball || to_ball(place, way) == INFINITY)) wanted[is_ball][n] += lit;
        }
    }
    scene.gl->TextureSubImage2D(scene.depths, 0, 0, 0, WIDE, HIGH, GL_RED, GL_FLOAT, depths);
    scene.gl->TextureSubImage2D(normals, 0, 0, 0, WIDE, HIGH, GL_RGBA, GL_FLOAT, normal);
    assert_int_equal(vxs_area_light_set(light, vpls, COUNT), VXS_OK);
    for (int n = 0; n < 3; n++) {
        GLuint buffer  = scatter_ball(floors[n], counts[n]);
        double sums[4] = {0};
        assert_int_equal(vxs_area_light_cast(light, &(vxs_area_casters){buffer, counts[n], 0}), VXS_OK);
        scene.gl->DeleteBuffers(1, &buffer);
        draw(&frame, &(vxs_area_look){.normal_texture = normals}, pixels);
        scene.gl->GetTextureImage(vxs_area_light_irradiance(light), 0, GL_RGBA, GL_FLOAT, sizeof pixels, pixels);
        for (uint32_t k = 0; k < PIXELS; k++) {
            int is_ball = wanted[1][k] > 0;
            sums[2 * is_ball] += (double)pixels[4 * k];
            sums[2 * is_ball + 1] += wanted[is_ball][k];
        }
        print_message("a ball on a floor of %g m, %u points: the ball has %.3f of its light, the floor %.3f\n", 2 * floors[n],
                      counts[n], sums[2] / sums[3], sums[0] / sums[1]);
        for (int k = 0; k < 4; k += 2) assert_true(sums[k] / sums[k + 1] > least[n] && sums[k] / sums[k + 1] < 1.01);
    }
}

static int set_up(void **state)
{
    area_set_up(state);
    vxs_area_light_destroy(light);
    assert_int_equal(vxs_area_light_create(&light, scene.volumes, &(vxs_area_light_desc){.vpls = (uint32_t)repeats(64, 256)}),
                     VXS_OK);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_closed_forms),
        cmocka_unit_test(test_ways_to_gather),
        cmocka_unit_test(test_more_is_no_worse),
        cmocka_unit_test(test_ball),
    };
    return cmocka_run_group_tests(tests, set_up, area_tear_down);
}
